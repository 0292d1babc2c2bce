// -1, 0 or 1; NaN stays NaN. Exact.
float pore_sign(float x) {
    float s = x > 0.0 ? 1.0 : (x < 0.0 ? -1.0 : 0.0);
    return pore_is_nan(x) ? x : s;
}
