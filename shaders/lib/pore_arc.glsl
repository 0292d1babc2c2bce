// asin(w) for w in 0..1/2, from w and z = w^2, so that the caller may have z exactly where w is a root.
// asin(w) = w + w^3 P(w^2) with the minimax polynomial of degree 4 for the relative error (4.9e-9), by linear
// programming in float64.
float pore_arc(float w, float z) {
    precise float p = ((4.21583802e-2 * z + 2.41847448e-2) * z + 4.54691537e-2) * z + 7.49530941e-2;
    precise float y = w + w * (z * (p * z + 0.166667521));
    return y;
}
