// The smaller number; NaN if either is NaN (GLSL leaves min of NaN undefined). Exact.
float pore_min(float a, float b) {
    float least = b < a ? b : a;
    return pore_is_nan(a) ? a : (pore_is_nan(b) ? b : least);
}
