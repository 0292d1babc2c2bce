// Not a number, from its bits: 0.0 / 0.0 is folded to 0 by some drivers.
float pore_nan() {
    return uintBitsToFloat(0x7fc00000u);
}
