// The larger number; NaN if either is NaN (GLSL leaves max of NaN undefined). Exact.
float pore_max(float a, float b) {
    float most = b > a ? b : a;
    return pore_is_nan(a) ? a : (pore_is_nan(b) ? b : most);
}
