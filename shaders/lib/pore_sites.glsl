// The nearest of random sites, one in each cell of size 1, and the nearest wall between two (porelang/ops/site_loops.py).
// `wanted` has a bit for each result that is read; a driver that knows it leaves out what is not.
PoreSites pore_sites(float x, float y, float z, float seed, float jitter, int wanted) {
    vec4 at = vec4(x, y, z, seed);
    float none = pore_nan();
    PoreSites found = PoreSites(none, none, none, none, none, none, none, none, none, none, none, none, none, none, none, none, none);
    if (!all(lessThan(abs(at), vec4(8388608.0))) || !(jitter >= 0.0 && jitter <= 1.0)) return found;
    int last = (wanted & 0x1c04) != 0 ? 2 : (wanted & 0x382) != 0 ? 1 : 0;
    precise float steps = roundEven(jitter * 256.0);
    precise float reach = steps / 512.0;
    ivec3 cell = ivec3(floor(at.xyz));
    int own_seed = int(floor(seed));
    precise vec3 place = at.xyz - floor(at.xyz);
    float s0 = pore_inf(), s1 = pore_inf(), s2 = pore_inf();  // squares of distances, and the vectors
    vec3 v0 = vec3(0.0), v1 = vec3(0.0), v2 = vec3(0.0);
    vec3 site_ = vec3(0.0);  // of the nearest: its place in its cell, from the middle
    ivec3 offset_ = ivec3(0);
    float limit = pore_inf();
    for (int a = 0; a < 5; a++) {
        precise float gx = pore_gap(pore_near(a), place.x, reach);
        if (gx > limit) continue;
        for (int b = 0; b < 5; b++) {
            precise float gy = gx + pore_gap(pore_near(b), place.y, reach);
            if (gy > limit) continue;
            for (int c = 0; c < 5; c++) {
                if (gy + pore_gap(pore_near(c), place.z, reach) > limit) continue;
                ivec3 offset = ivec3(pore_near(a), pore_near(b), pore_near(c));
                vec4 site = pore_site(cell + offset, own_seed, steps);
                precise vec3 r = vec3(offset) + ((site.xyz + 0.5) - place);
                precise float square = (r.x * r.x + r.y * r.y) + r.z * r.z;
                bool first = square < s0, second = square < s1;
                if (first) {
                    site_ = site.xyz;
                    offset_ = offset;
                    found.number = site.w;
                }
                if (last > 1 && square < s2) {
                    s2 = second ? s1 : square;
                    v2 = second ? v1 : r;
                }
                if (last > 0 && second) {
                    s1 = first ? s0 : square;
                    v1 = first ? v0 : r;
                }
                if (first) {
                    s0 = square;
                    v0 = r;
                }
                limit = last > 1 ? s2 : last > 0 ? s1 : s0;
            }
        }
    }
    float f0 = pore_sqrt(s0), f1 = pore_sqrt(s1), f2 = pore_sqrt(s2);
    precise vec3 n0 = f0 > 0.0 ? -v0 / f0 : vec3(0.0);
    precise vec3 n1 = f1 > 0.0 ? -v1 / f1 : vec3(0.0);
    precise vec3 n2 = f2 > 0.0 ? -v2 / f2 : vec3(0.0);
    found.f1 = f0;
    found.f2 = f1;
    found.f3 = f2;
    found.x1 = n0.x;
    found.y1 = n0.y;
    found.z1 = n0.z;
    found.x2 = n1.x;
    found.y2 = n1.y;
    found.z2 = n1.z;
    found.x3 = n2.x;
    found.y3 = n2.y;
    found.z3 = n2.z;
    if ((wanted & 0xe008) == 0) return found;
    vec3 across = vec3(1.0, 0.0, 0.0);
    precise float wall = pore_inf();
    float far = pore_inf();
    for (int a = 0; a < 5; a++) {
        precise float gx = pore_gap(pore_near(a), place.x, reach);
        if (gx > far) continue;
        for (int b = 0; b < 5; b++) {
            precise float gy = gx + pore_gap(pore_near(b), place.y, reach);
            if (gy > far) continue;
            for (int c = 0; c < 5; c++) {
                ivec3 offset = ivec3(pore_near(a), pore_near(b), pore_near(c));
                if (gy + pore_gap(pore_near(c), place.z, reach) > far || offset == offset_) continue;
                vec4 site = pore_site(cell + offset, own_seed, steps);
                precise vec3 r = vec3(offset) + ((site.xyz + 0.5) - place);
                precise vec3 apart = vec3(offset - offset_) + (site.xyz - site_);
                precise float square = (apart.x * apart.x + apart.y * apart.y) + apart.z * apart.z;
                precise float size = pore_sqrt(square);
                precise vec3 middle = 0.5 * (r + v0);
                precise vec3 to = apart / size;
                precise float distance_ = (middle.x * to.x + middle.y * to.y) + middle.z * to.z;
                if (distance_ < wall) {
                    wall = distance_;
                    across = -to;
                    far = (f0 + 2.0 * wall) * (f0 + 2.0 * wall) * 1.00001;
                }
            }
        }
    }
    found.wall = wall;
    found.xw = across.x;
    found.yw = across.y;
    found.zw = across.z;
    return found;
}
