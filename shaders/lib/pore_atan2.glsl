// The angle of the point (x, y) in -pi..pi, with C's and NumPy's rules for signed zeros and infinities.
// Error: 1.5 ulp. Denormals count as 0.
// atan(q) = q + q^3 P(q^2) for q in 0..1 with the minimax polynomial of degree 8 for the relative error (2.6e-9), by
// linear programming in float64; then pi / 2 and pi in two floats.
float pore_atan2(float y, float x) {
    uint i = floatBitsToUint(y);
    uint j = floatBitsToUint(x);
    uint sign_bit = i & 0x80000000u;
    bool left = j > 0x7fffffffu;
    i &= 0x7fffffffu;
    j &= 0x7fffffffu;
    bool steep = i > j;
    uint small = steep ? j : i;
    uint large = steep ? i : j;
    float q = pore_div(uintBitsToFloat(small), uintBitsToFloat(large));
    if (large < 0x00800000u) q = 0.0;
    if (small == 0x7f800000u) q = 1.0;
    precise float z = q * q;
    precise float p = ((-1.78300741e-3 * z + 1.08692329e-2) * z - 3.10976002e-2) * z + 5.78817166e-2;
    precise float t = (((p * z - 8.39931443e-2) * z + 0.109508812) * z - 0.142640159) * z + 0.199985296;
    precise float a = q + q * (z * (t * z - 0.333332986));
    precise float upright = 1.57079637 - (a + 4.37113883e-8);
    if (steep) a = upright;
    precise float mirrored = 3.14159274 - (a + 8.74227766e-8);
    if (left) a = mirrored;
    if (large > 0x7f800000u) a = pore_nan();
    return uintBitsToFloat(floatBitsToUint(a) | sign_bit);
}
