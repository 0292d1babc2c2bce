// Trilinear interpolation of component c of a sampled field (porelang/ops/words.py), or its derivative of the orders
// kx, ky, kz (0 or 1). Equal to NumPy's in float32, bit for bit (porelang/ops/grid_loops.py).
float pore_lookup@(float x, float y, float z, int c, int kx, int ky, int kz) {
    int ny = int(pore_word@(1));
    int nz = int(pore_word@(2));
    int step = int(pore_word@(3));
    float rx = uintBitsToFloat(pore_word@(7));
    float ry = uintBitsToFloat(pore_word@(8));
    float rz = uintBitsToFloat(pore_word@(9));
    PoreCell at = pore_cell@(x, y, z, kx, ky, kz);
    int row = nz * step;
    int plane = ny * row;
    int first = 16 + at.i * plane + at.j * row + at.k * step + c;
    precise float p0 = 0.0;
    precise float p1 = 0.0;
    for (int n = 0; n < 2; n++) {
        int q = first + n * plane;
        float a0 = uintBitsToFloat(pore_word@(q));
        float a1 = uintBitsToFloat(pore_word@(q + row));
        precise float d0 = uintBitsToFloat(pore_word@(q + step)) - a0;
        precise float d1 = uintBitsToFloat(pore_word@(q + row + step)) - a1;
        precise float s0 = kz == 0 ? a0 + d0 * at.h : d0 * rz;
        precise float s1 = kz == 0 ? a1 + d1 * at.h : d1 * rz;
        precise float d = s1 - s0;
        p0 = p1;
        p1 = ky == 0 ? s0 + d * at.g : d * ry;
    }
    precise float d = p1 - p0;
    precise float s = kx == 0 ? p0 + d * at.f : d * rx;
    if (at.outside) s = 0.0;
    return at.bad ? pore_nan() : s;
}
