// The sine of u turns, sin(tau u); NaN for infinities. Error: 1.1e-7, however large u.
// u - roundEven(u) is exact, so the error does not grow with u; folding to a quarter turn is exact too.
float pore_sin_turns(float u) {
    precise float r = u - roundEven(u);
    precise float folded = (r < 0.0 ? -0.5 : 0.5) - r;
    return pore_sine(abs(r) > 0.25 ? folded : r);
}
