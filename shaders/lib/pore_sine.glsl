// The sine of t turns for t in -1/4..1/4. Error: 1.1e-7, 1.9 ulp.
// sin(tau t) = 4 t + t P(t^2), where 4 t is exact, with the minimax polynomial of degree 4 for the relative error
// (1.1e-8), by linear programming in float64, its coefficients rounded to float32 one after another.
float pore_sine(float t) {
    precise float z = t * t;
    precise float p = ((39.3661575 * z - 76.5335617) * z + 81.6006927) * z - 41.3416595;
    precise float y = 4.0 * t + t * (z * p + 2.28318524);
    return y;
}
