// The vector to p from the nearest place on the axis of a bar, by the words of its leaf and its lane, and where along it
// that place is (0..1): `pore_foot`.
vec4 pore_bar@(int leaf, int c, vec3 p) {
    vec3 start = vec3(uintBitsToFloat(pore_word@(leaf + c)), uintBitsToFloat(pore_word@(leaf + 8 + c)),
                      uintBitsToFloat(pore_word@(leaf + 16 + c)));
    vec3 end = vec3(uintBitsToFloat(pore_word@(leaf + 24 + c)), uintBitsToFloat(pore_word@(leaf + 32 + c)),
                    uintBitsToFloat(pore_word@(leaf + 40 + c)));
    return pore_foot(start, end, uintBitsToFloat(pore_word@(leaf + 56 + c)), p);
}
