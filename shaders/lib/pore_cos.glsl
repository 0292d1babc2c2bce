// The cosine of x radians; NaN for infinities. Error: 1.3e-7 + |x| 2^-47.
float pore_cos(float x) {
    return pore_cos_turns(pore_turns(x));
}
