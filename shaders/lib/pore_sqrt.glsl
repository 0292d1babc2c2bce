// The square root; NaN for negatives, sqrt(-0) = -0.
// Error: 0.5 ulp (equal to NumPy's root for all 2^24 mantissas); denormals count as 0.
// The driver's root of the mantissa is corrected by its exact remainder (one step of Newton's method).
float pore_sqrt(float x) {
    uint i = floatBitsToUint(x);
    int e = int((i >> 23) & 255u) - 127;
    int odd = e & 1;
    float m = uintBitsToFloat((i & 0x007fffffu) | uint(127 + odd) << 23);
    precise float s = sqrt(m);
    float h = pore_high(s);
    precise float l = s - h;
    precise float rest = ((m - h * h) - 2.0 * h * l) - l * l;
    precise float exact = s + rest * (0.49999997 / s);  // a hair less than half: s is below the root where it matters
    precise float y = exact * uintBitsToFloat(uint(127 + ((e - odd) >> 1)) << 23);
    if ((i & 0x7f800000u) == 0u) y = uintBitsToFloat(i & 0x80000000u);
    else if (i > 0x7f800000u) y = pore_nan();
    else if (i == 0x7f800000u) y = x;
    return y;
}
