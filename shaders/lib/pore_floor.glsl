// The largest integer that is not above x. Exact; NaN and infinities stay what they are.
float pore_floor(float x) {
    return pore_is_nan(x) ? x : floor(x);
}
