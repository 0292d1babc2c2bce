// The bar at a place of the tree, tried: it becomes the best (its place and number) where its surface is nearer, of two
// that tie the one of the lower number. `least` is the distance from the surface, and from the axis.
void pore_try@(int bars, int ids, int place, vec3 p, inout vec2 least, inout vec4 foot, inout ivec2 best) {
    int leaf = bars + 64 * (place / 8);
    int c = place % 8;
    float r = uintBitsToFloat(pore_word@(leaf + 48 + c));
    if (!(r >= 0.0)) return;
    vec3 start = vec3(uintBitsToFloat(pore_word@(leaf + c)), uintBitsToFloat(pore_word@(leaf + 8 + c)),
                      uintBitsToFloat(pore_word@(leaf + 16 + c)));
    vec3 end = vec3(uintBitsToFloat(pore_word@(leaf + 24 + c)), uintBitsToFloat(pore_word@(leaf + 32 + c)),
                    uintBitsToFloat(pore_word@(leaf + 40 + c)));
    vec4 q = pore_foot(start, end, uintBitsToFloat(pore_word@(leaf + 56 + c)), p);
    precise float square = (q.x * q.x + q.y * q.y) + q.z * q.z;
    float size = pore_sqrt(square);
    precise float d = size - r;
    int own = int(pore_word@(ids + place));
    if (d < least.x || (d == least.x && own < best.y)) {
        best = ivec2(place, own);
        least = vec2(d, size);
        foot = q;
    }
}
