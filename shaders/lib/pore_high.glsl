// The upper half of x: its first 12 significant bits. Products of two halves are exact in float32, so that
// x y = xh yh + xh yl + xl yh + xl yl with xl = x - xh gives the rounding error of x * y (after Dekker 1971).
float pore_high(float x) {
    return uintBitsToFloat(floatBitsToUint(x) & 0xfffff000u);
}
