// The arc sine; NaN outside -1..1. Error: 2.3 ulp.
// Above 1/2 by asin(x) = pi / 2 - 2 asin(sqrt((1 - x) / 2)).
float pore_asin(float x) {
    float a = abs(x);
    precise float z = a * a;
    precise float w = a;
    if (a > 0.5) {
        z = 0.5 * (1.0 - a);
        w = pore_sqrt(z);
    }
    precise float y = pore_arc(w, z);
    precise float steep = 1.57079637 - (2.0 * y + 4.37113883e-8);
    if (a > 0.5) y = steep;
    uint i = floatBitsToUint(x);
    uint result = floatBitsToUint(y) | (i & 0x80000000u);
    return uintBitsToFloat((i & 0x7fffffffu) > 0x3f800000u ? 0x7fc00000u : result);
}
