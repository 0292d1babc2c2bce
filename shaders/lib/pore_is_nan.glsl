// Whether x is not a number, by its bits: a driver may assume that x != x is never true.
bool pore_is_nan(float x) {
    return (floatBitsToUint(x) & 0x7fffffffu) > 0x7f800000u;
}
