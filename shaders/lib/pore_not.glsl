// Whether b does not hold. NVIDIA's compiler takes !(a < b) for a >= b, which a NaN makes false too (measured: an H200,
// driver 580), in whatever words it is written; a sum with a number that it does not know it leaves alone.
bool pore_not(bool b) {
    precise float x = (b ? 1.0 : 0.0) + pore_nought;
    return x < 0.5;
}
