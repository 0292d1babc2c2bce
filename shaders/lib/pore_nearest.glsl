// The nearest bar of segments (porelang/ops/words.py), by the walk of porelang/ops/segment_loops.py through the same
// tree, or by its lists of cells (porelang/ops/segment_cells.py); of bars that repeat by those near the cell about the
// origin, to which the place is moved (porelang/ops/segment_copies.py). Not a number where a coordinate is none; too
// far away for squares, the distance is infinite and all else NaN.
PoreNearest pore_nearest@(float x, float y, float z) {
    int groups = int(pore_word@(0));
    int leaves = int(pore_word@(1));
    int top = int(pore_word@(2));
    int bars = 16 + 56 * groups;
    int frames = bars + 64 * leaves;
    int ids = frames + 32 * leaves;
    int repeats = int(pore_word@(6));
    bool bad = pore_is_nan(x) || pore_is_nan(y) || pore_is_nan(z);
    if (repeats > 0) {
        x = pore_folded(x, uintBitsToFloat(pore_word@(repeats)), uintBitsToFloat(pore_word@(repeats + 3)));
        y = pore_folded(y, uintBitsToFloat(pore_word@(repeats + 1)), uintBitsToFloat(pore_word@(repeats + 4)));
        z = pore_folded(z, uintBitsToFloat(pore_word@(repeats + 2)), uintBitsToFloat(pore_word@(repeats + 5)));
    }
    vec3 p = vec3(x, y, z);
    precise float slack = uintBitsToFloat(pore_word@(4)) * (uintBitsToFloat(pore_word@(3)) + ((abs(x) + abs(y)) + abs(z)));
    vec2 least = vec2(pore_inf(), 0.0);
    vec4 foot = vec4(0.0);
    ivec2 best = ivec2(-1, 0);
    int stack[80];
    float keys[80];
    int height = 0;
    int node = 0;
    bool going = !bad && slack < 1e30;
    int cells = int(pore_word@(8));
    if (going && cells > 0) {
        ivec3 shape = ivec3(int(pore_word@(9)), int(pore_word@(10)), int(pore_word@(11)));
        vec3 low = vec3(uintBitsToFloat(pore_word@(12)), uintBitsToFloat(pore_word@(13)), uintBitsToFloat(pore_word@(14)));
        precise vec3 at = floor((p - low) * uintBitsToFloat(pore_word@(15)));
        if (all(greaterThanEqual(at, vec3(0.0))) && all(lessThan(at, vec3(shape)))) {
            ivec3 cell = ivec3(at);
            int k = cells + (cell.x * shape.y + cell.y) * shape.z + cell.z;
            int list = cells + shape.x * shape.y * shape.z + 1;
            int end = int(pore_word@(k + 1));
            for (int i = int(pore_word@(k)); i < end; i++) {
                going = false;
                pore_try@(bars, ids, int(pore_word@(list + i)), p, least, foot, best);
            }
        }
    }
    while (going) {
        precise float reach = least.x + slack;
        if (node < groups) {
            int box = 16 + 56 * node;
            int first = node == 0 ? 1 : 8 * node - 7 + top;
            int bottom = height;
            for (int c = 0; c < 8; c++) {
                float r = uintBitsToFloat(pore_word@(box + 48 + c));
                if (!(r >= 0.0)) continue;
                precise vec3 before = vec3(uintBitsToFloat(pore_word@(box + c)), uintBitsToFloat(pore_word@(box + 8 + c)),
                                           uintBitsToFloat(pore_word@(box + 16 + c))) - p;
                precise vec3 after = p - vec3(uintBitsToFloat(pore_word@(box + 24 + c)), uintBitsToFloat(pore_word@(box + 32 + c)),
                                              uintBitsToFloat(pore_word@(box + 40 + c)));
                float dx = before.x > after.x ? before.x : after.x;
                float dy = before.y > after.y ? before.y : after.y;
                float dz = before.z > after.z ? before.z : after.z;
                dx = dx > 0.0 ? dx : 0.0;
                dy = dy > 0.0 ? dy : 0.0;
                dz = dz > 0.0 ? dz : 0.0;
                precise float square = (dx * dx + dy * dy) + dz * dz;
                precise float key = pore_sqrt(square) - r;
                if (key <= reach) {
                    int at = height;
                    while (at > bottom && keys[at - 1] < key) {
                        stack[at] = stack[at - 1];
                        keys[at] = keys[at - 1];
                        at--;
                    }
                    stack[at] = first + c;
                    keys[at] = key;
                    height++;
                }
            }
        } else {
            for (int c = 0; c < 8; c++)
                pore_try@(bars, ids, 8 * (node - groups) + c, p, least, foot, best);
        }
        going = false;
        while (height > 0 && !going) {
            height--;
            precise float limit = least.x + slack;
            node = stack[height];
            going = keys[height] <= limit;
        }
    }
    float none = pore_nan();
    if (best.x < 0) {
        return PoreNearest(bad ? none : pore_inf(), none, none, none, none, none, none, none, none, none, none);
    }
    float root = least.y;
    bool on = root == 0.0;
    int frame = frames + 4 * best.x;
    float radius = uintBitsToFloat(pore_word@(bars + 64 * (best.x / 8) + 48 + best.x % 8));
    int number = repeats > 0 ? int(pore_word@(repeats + 6 + best.y)) : best.y;
    return PoreNearest(
        least.x,
        on ? 0.0 : pore_div(foot.x, root), on ? 0.0 : pore_div(foot.y, root), on ? 0.0 : pore_div(foot.z, root),
        uintBitsToFloat(pore_word@(frame)), uintBitsToFloat(pore_word@(frame + 1)), uintBitsToFloat(pore_word@(frame + 2)),
        foot.w, radius, uintBitsToFloat(pore_word@(frame + 3)), float(number));
}
