// The natural logarithm; log(0) = -inf, NaN for negatives. Error: 0.79 ulp. Denormals count as 0.
// x = 2^e (1 + f) with 1 + f in sqrt(1/2)..sqrt(2); log(1 + f) = f - f^2 / 2 + f^3 P(f) with the minimax polynomial of
// degree 8 for the relative error (7.7e-10), by linear programming in float64.
float pore_log(float x) {
    uint i = floatBitsToUint(x);
    uint shifted = i + (0x3f800000u - 0x3f3504f3u);
    float e = float(int(shifted >> 23) - 127);
    precise float f = uintBitsToFloat((shifted & 0x007fffffu) + 0x3f3504f3u) - 1.0;
    precise float z = f * f;
    precise float p = ((6.74981177e-2 * f - 0.116711177) * f + 0.118838593) * f - 0.12406119;
    precise float s = ((p * f + 0.142203122) * f - 0.166679919) * f + 0.20002073;
    precise float q = (s * f - 0.250000089) * f + 0.333333135;
    precise float tail = (e * 1.42860677e-6 + z * f * q) - 0.5 * z;
    precise float y = e * 0.693145752 + (f + tail);
    if ((i & 0x7f800000u) == 0u) y = -pore_inf();
    else if (i > 0x7f800000u) y = pore_nan();
    else if (i == 0x7f800000u) y = x;
    return y;
}
