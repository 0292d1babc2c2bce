// e^x: infinity above 88.7228, 0 below -104, or below -87.4 where the driver has no denormals.
// Error: 0.96 ulp.
// x = k ln 2 + r with ln 2 in two parts, the first short enough for k ln 2 to be exact; e^r = 1 + r + r^2 P(r) with the
// minimax polynomial of degree 4 for the relative error (3.1e-9), by linear programming in float64.
float pore_exp(float x) {
    float inside = x > 89.0 ? 89.0 : (x < -104.0 ? -104.0 : x);
    precise float k = roundEven(inside * 1.44269502);
    precise float r = (inside - k * 0.693145752) - k * 1.42860677e-6;
    precise float p = (((1.38210563e-3 * r + 8.36867467e-3) * r + 4.16682623e-2) * r + 0.166665211) * r + 0.49999994;
    precise float y = 1.0 + (r + r * r * p);
    return pore_is_nan(x) ? x : pore_scale(y, int(k));
}
