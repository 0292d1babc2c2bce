// The nearest bar of segments (porelang/ops/words.py), by the walk of porelang/ops/segment_loops.py through the same
// tree. Not a number where a coordinate is none; too far away for squares, the distance is infinite and all else NaN.
PoreNearest pore_nearest@(float x, float y, float z) {
    int groups = int(pore_word@(0));
    int leaves = int(pore_word@(1));
    int top = int(pore_word@(2));
    int bars = 8 + 56 * groups;
    int frames = bars + 64 * leaves;
    int ids = frames + 32 * leaves;
    vec3 p = vec3(x, y, z);
    bool bad = pore_is_nan(x) || pore_is_nan(y) || pore_is_nan(z);
    precise float slack = uintBitsToFloat(pore_word@(4)) * (uintBitsToFloat(pore_word@(3)) + ((abs(x) + abs(y)) + abs(z)));
    float least = pore_inf();
    float root = 0.0;
    vec4 foot = vec4(0.0);
    int best = -1;
    int number = 0;
    int stack[80];
    float keys[80];
    int height = 0;
    int node = 0;
    bool going = !bad && slack < 1e30;
    while (going) {
        precise float reach = least + slack;
        if (node < groups) {
            int box = 8 + 56 * node;
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
            int leaf = bars + 64 * (node - groups);
            for (int c = 0; c < 8; c++) {
                float r = uintBitsToFloat(pore_word@(leaf + 48 + c));
                if (!(r >= 0.0)) continue;
                vec3 start = vec3(uintBitsToFloat(pore_word@(leaf + c)), uintBitsToFloat(pore_word@(leaf + 8 + c)),
                                  uintBitsToFloat(pore_word@(leaf + 16 + c)));
                vec3 end = vec3(uintBitsToFloat(pore_word@(leaf + 24 + c)), uintBitsToFloat(pore_word@(leaf + 32 + c)),
                                uintBitsToFloat(pore_word@(leaf + 40 + c)));
                vec4 q = pore_foot(start, end, uintBitsToFloat(pore_word@(leaf + 56 + c)), p);
                precise float square = (q.x * q.x + q.y * q.y) + q.z * q.z;
                float size = pore_sqrt(square);
                precise float d = size - r;
                int place = 8 * (node - groups) + c;
                int own = int(pore_word@(ids + place));
                if (d < least || (d == least && own < number)) {
                    best = place;
                    number = own;
                    least = d;
                    root = size;
                    foot = q;
                }
            }
        }
        going = false;
        while (height > 0 && !going) {
            height--;
            precise float limit = least + slack;
            node = stack[height];
            going = keys[height] <= limit;
        }
    }
    float none = pore_nan();
    if (best < 0) {
        return PoreNearest(bad ? none : pore_inf(), none, none, none, none, none, none, none, none, none, none);
    }
    bool on = root == 0.0;
    int frame = frames + 4 * best;
    float radius = uintBitsToFloat(pore_word@(bars + 64 * (best / 8) + 48 + best % 8));
    return PoreNearest(
        least,
        on ? 0.0 : pore_div(foot.x, root), on ? 0.0 : pore_div(foot.y, root), on ? 0.0 : pore_div(foot.z, root),
        uintBitsToFloat(pore_word@(frame)), uintBitsToFloat(pore_word@(frame + 1)), uintBitsToFloat(pore_word@(frame + 2)),
        foot.w, radius, uintBitsToFloat(pore_word@(frame + 3)), float(number));
}
