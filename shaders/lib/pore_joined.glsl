// Bars that are joined smoothly (porelang/ops/joints.py): those that are less than k farther than the nearest, of more
// than 64 the nearest, and what they agree in, by Newton's steps, as porelang/ops/joint_loops.py finds it.
PoreJoined pore_joined@(float x, float y, float z, float k) {
    PoreNearest first = pore_nearest@(x, y, z);
    float none = pore_nan();
    PoreJoined found = PoreJoined(none, none, none, none, none, none, none, none, none, none, none, none, none, none, none);
    if (pore_is_nan(first.distance) || pore_is_nan(k)) return found;
    found.distance = first.distance;
    if (pore_is_nan(first.along)) return found;
    int repeats = int(pore_word@(6));
    if (repeats > 0) {
        x = pore_folded(x, uintBitsToFloat(pore_word@(repeats)), uintBitsToFloat(pore_word@(repeats + 3)));
        y = pore_folded(y, uintBitsToFloat(pore_word@(repeats + 1)), uintBitsToFloat(pore_word@(repeats + 4)));
        z = pore_folded(z, uintBitsToFloat(pore_word@(repeats + 2)), uintBitsToFloat(pore_word@(repeats + 5)));
    }
    vec3 p = vec3(x, y, z);
    int groups = int(pore_word@(0));
    int leaves = int(pore_word@(1));
    int top = int(pore_word@(2));
    int bars = 16 + 56 * groups;
    int frames = bars + 64 * leaves;
    float least = first.distance;
    bool wide = k > 0.0;
    precise float limit = wide ? least + k : least;
    float d[64];
    int places[64];
    int stack[80];
    int height = 1;
    int count = 0;
    stack[0] = 0;
    while (height > 0) {
        height--;
        int node = stack[height];
        if (node < groups) {
            int box = 16 + 56 * node;
            int child = node == 0 ? 1 : 8 * node - 7 + top;
            for (int c = 0; c < 8; c++) {
                float r = uintBitsToFloat(pore_word@(box + 48 + c));
                if (!(r >= 0.0)) continue;
                vec3 low = vec3(uintBitsToFloat(pore_word@(box + c)), uintBitsToFloat(pore_word@(box + 8 + c)),
                                uintBitsToFloat(pore_word@(box + 16 + c)));
                vec3 high = vec3(uintBitsToFloat(pore_word@(box + 24 + c)), uintBitsToFloat(pore_word@(box + 32 + c)),
                                 uintBitsToFloat(pore_word@(box + 40 + c)));
                precise vec3 before = low - p;
                precise vec3 after = p - high;
                vec3 away = vec3(pore_beyond(before.x, after.x), pore_beyond(before.y, after.y), pore_beyond(before.z, after.z));
                precise float key = pore_length(away) - r;
                if (key <= limit) stack[height++] = child + c;
            }
        } else {
            for (int c = 0; c < 8; c++) {
                int place = 8 * (node - groups) + c;
                int leaf = bars + 64 * (place / 8);
                float r = uintBitsToFloat(pore_word@(leaf + 48 + c));
                if (!(r >= 0.0)) continue;
                vec4 q = pore_bar@(leaf, c, p);
                precise float own = pore_length(q.xyz) - r;
                if (!(own <= limit)) continue;
                int at = count;
                if (count >= 64) {
                    at = 0;
                    for (int i = 1; i < 64; i++) {
                        if (d[i] > d[at]) at = i;
                    }
                    if (!(own < d[at])) continue;
                }
                d[at] = own;
                places[at] = place;
                if (count < 64) count++;
            }
        }
    }
    if (!wide) count = 1;
    precise float over = wide ? pore_div(1.0, k) : 0.0;
    precise float s = 0.0;
    for (int step = 0; step < 10; step++) {
        precise float cubes = -1.0;
        precise float squares = 0.0;
        for (int i = 0; i < count; i++) {
            precise float u = (1.0 - (d[i] - least) * over) - s;
            if (u > 0.0) {
                squares += u * u;
                cubes += u * u * u;
            }
        }
        if (cubes > 0.0) s += pore_div(cubes, 3.0 * squares);
    }
    precise float b = 0.0;
    precise vec3 g = vec3(0.0);
    precise float slope = 0.0;
    for (int i = 0; i < count; i++) {
        precise float u = (1.0 - (d[i] - least) * over) - s;
        if (!(u > 0.0)) continue;
        vec3 q = pore_bar@(bars + 64 * (places[i] / 8), places[i] % 8, p).xyz;
        float size = pore_length(q);
        if (size > 0.0) g += (u * u) * vec3(pore_div(q.x, size), pore_div(q.y, size), pore_div(q.z, size));
        b += u * u;
        slope += u * u * (1.0 - u);
    }
    g = vec3(pore_div(g.x, b), pore_div(g.y, b), pore_div(g.z, b));
    slope = -pore_div(slope, b);
    precise float part = pore_div(1.0, b);
    precise vec3 across = vec3(0.0);  // yz, xz, xy
    precise vec3 along = vec3(0.0);
    precise vec3 drift = vec3(0.0);
    precise float turn = 0.0;
    for (int i = 0; i < count; i++) {
        precise float u = (1.0 - (d[i] - least) * over) - s;
        if (!(u > 0.0)) continue;
        vec4 q = pore_bar@(bars + 64 * (places[i] / 8), places[i] % 8, p);
        float size = pore_length(q.xyz);
        precise vec3 n = size > 0.0 ? vec3(pore_div(q.x, size), pore_div(q.y, size), pore_div(q.z, size)) : vec3(0.0);
        precise float bend = size > 0.0 ? pore_div(u * u, size) : 0.0;
        int frame = frames + 4 * places[i];
        vec3 t = vec3(uintBitsToFloat(pore_word@(frame)), uintBitsToFloat(pore_word@(frame + 1)),
                      uintBitsToFloat(pore_word@(frame + 2)));
        if (!(q.w > 0.0 && q.w < 1.0)) t = vec3(0.0);
        precise vec3 e = n - g;
        precise float pull = 2.0 * u * over;
        precise float rate = ((1.0 - u) + slope) * over;
        along += bend * ((vec3(1.0) - n * n) - t * t) - pull * e * e;
        across += bend * (-n.yxx * n.zzy - t.yxx * t.zzy) - pull * e.yxx * e.zzy;
        drift += 2.0 * u * rate * e;
        turn -= ((2.0 * u - 3.0 * u * u) + 2.0 * u * slope) * rate;
    }
    along *= part;
    across *= part;
    drift *= part;
    precise float f = wide ? least - k * s : least;
    return PoreJoined(f, g.x, g.y, g.z, slope, along.x, across.z, across.y, along.y, across.x, along.z,
                      drift.x, drift.y, drift.z, turn * part);
}
