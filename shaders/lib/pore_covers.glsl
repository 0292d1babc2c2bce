// Whether a point lies within the box of a sampled field's nodes (porelang/ops/words.py), faces included. Exact.
bool pore_covers@(float x, float y, float z) {
    return x >= uintBitsToFloat(pore_word@(4)) && x <= uintBitsToFloat(pore_word@(10))
        && y >= uintBitsToFloat(pore_word@(5)) && y <= uintBitsToFloat(pore_word@(11))
        && z >= uintBitsToFloat(pore_word@(6)) && z <= uintBitsToFloat(pore_word@(12));
}
