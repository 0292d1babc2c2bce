// The nearest integer, halves to the even one. Exact; NaN and infinities stay what they are. GLSL leaves it to the
// driver where round() sends a half.
float pore_round(float x) {
    return pore_is_nan(x) ? x : roundEven(x);
}
