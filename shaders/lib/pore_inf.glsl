// Positive infinity, from its bits.
float pore_inf() {
    return uintBitsToFloat(0x7f800000u);
}
