// The random numbers of the cell of size 1 that a place lies in, 0 to 1; none beyond 2^23 cells (porelang/ops/random.py).
PoreRandom pore_random(float x, float y, float z, float seed) {
    vec4 at = vec4(x, y, z, seed);
    if (!all(lessThan(abs(at), vec4(8388608.0)))) {
        float none = pore_nan();
        return PoreRandom(none, none, none, none);
    }
    uvec4 v = pore_pcg4d(uvec4(ivec4(floor(at)))) >> 8u;
    return PoreRandom(float(v.x) * 5.9604644775390625e-8, float(v.y) * 5.9604644775390625e-8,
                      float(v.z) * 5.9604644775390625e-8, float(v.w) * 5.9604644775390625e-8);
}
