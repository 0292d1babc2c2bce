// The sine of x radians; NaN for infinities. Error: 1.9e-7 + |x| 2^-47.
float pore_sin(float x) {
    return pore_sin_turns(pore_turns(x));
}
