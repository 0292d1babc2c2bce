// The nearest of random sites, one in each cell of size 1, and the nearest wall between two (porelang/ops/site_loops.py).
PoreSites pore_sites(float x, float y, float z, float seed, float jitter) {
    vec4 at = vec4(x, y, z, seed);
    if (!all(lessThan(abs(at), vec4(8388608.0))) || !(jitter >= 0.0 && jitter <= 1.0)) {
        float none = pore_nan();
        return PoreSites(none, none, none, none, none, none, none, none, none, none, none, none, none, none, none, none, none);
    }
    float steps = roundEven(jitter * 256.0);
    float reach = steps / 512.0;
    ivec3 cell = ivec3(floor(at.xyz));
    int own_seed = int(floor(seed));
    precise vec3 place = at.xyz - floor(at.xyz);
    int near[5] = int[5](0, -1, 1, -2, 2);
    vec3 squares = vec3(pore_inf());
    vec3 vectors[3];
    vec3 sites[3];  // their places in their cells, from the middles
    ivec3 offsets[3];
    float number = 0.0;
    for (int a = 0; a < 5; a++)
    for (int b = 0; b < 5; b++)
    for (int c = 0; c < 5; c++) {
        ivec3 offset = ivec3(near[a], near[b], near[c]);
        vec3 gap = pore_gap(vec3(offset), place, reach);
        if (gap.x > squares.z || gap.x + gap.y > squares.z) break;
        if (gap.x + gap.y + gap.z > squares.z) continue;
        vec4 site = pore_site(cell + offset, own_seed, steps);
        precise vec3 r = vec3(offset) + ((site.xyz + 0.5) - place);
        precise float square = (r.x * r.x + r.y * r.y) + r.z * r.z;
        if (!(square < squares.z)) continue;
        int m = square < squares.x ? 0 : square < squares.y ? 1 : 2;
        for (int k = 2; k > m; k--) {
            squares[k] = squares[k - 1];
            vectors[k] = vectors[k - 1];
            sites[k] = sites[k - 1];
            offsets[k] = offsets[k - 1];
        }
        squares[m] = square;
        vectors[m] = r;
        sites[m] = site.xyz;
        offsets[m] = offset;
        if (m == 0) number = site.w;
    }
    vec3 f = vec3(pore_sqrt(squares.x), pore_sqrt(squares.y), pore_sqrt(squares.z));
    vec3 across = vec3(1.0, 0.0, 0.0);
    precise float wall = pore_inf();
    float far = (f.x + 2.0 * f.y) * (f.x + 2.0 * f.y);
    for (int a = 0; a < 5; a++)
    for (int b = 0; b < 5; b++)
    for (int c = 0; c < 5; c++) {
        ivec3 offset = ivec3(near[a], near[b], near[c]);
        vec3 gap = pore_gap(vec3(offset), place, reach);
        if (gap.x > far || gap.x + gap.y > far) break;
        if (gap.x + gap.y + gap.z > far || offset == offsets[0]) continue;
        vec4 site = pore_site(cell + offset, own_seed, steps);
        precise vec3 r = vec3(offset) + ((site.xyz + 0.5) - place);
        precise vec3 apart = vec3(offset - offsets[0]) + (site.xyz - sites[0]);
        precise float square = (apart.x * apart.x + apart.y * apart.y) + apart.z * apart.z;
        precise float size = pore_sqrt(square);
        precise vec3 middle = 0.5 * (r + vectors[0]);
        precise vec3 to = apart / size;
        precise float found = (middle.x * to.x + middle.y * to.y) + middle.z * to.z;
        if (found < wall) {
            wall = found;
            across = -to;
            far = min(far, (f.x + 2.0 * wall) * (f.x + 2.0 * wall) * 1.00001);
        }
    }
    vec3 n[3];
    for (int m = 0; m < 3; m++) n[m] = f[m] > 0.0 ? -vectors[m] / f[m] : vec3(0.0);
    return PoreSites(f.x, f.y, f.z, wall, n[0].x, n[0].y, n[0].z, n[1].x, n[1].y, n[1].z, n[2].x, n[2].y, n[2].z,
                     across.x, across.y, across.z, number);
}
