// The cosine of u turns, cos(tau u); NaN for infinities. Error: 1.1e-7, however large u.
// The reduction is exact; 1/4 - |r| is rounded only where the cosine is flat.
float pore_cos_turns(float u) {
    precise float r = u - roundEven(u);
    precise float t = 0.25 - abs(r);
    return pore_sine(t);
}
