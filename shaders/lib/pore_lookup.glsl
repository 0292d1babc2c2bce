// Trilinear interpolation of component c of a sampled field (porelang/ops/words.py), or its derivative of the orders
// kx, ky, kz (0 or 1). Equal to NumPy's in float32, bit for bit (porelang/ops/grid_loops.py).
float pore_lookup@(float x, float y, float z, int c, int kx, int ky, int kz) {
    int nx = int(pore_word@(0));
    int ny = int(pore_word@(1));
    int nz = int(pore_word@(2));
    int step = int(pore_word@(3));
    float rx = uintBitsToFloat(pore_word@(7));
    float ry = uintBitsToFloat(pore_word@(8));
    float rz = uintBitsToFloat(pore_word@(9));
    precise float u = (x - uintBitsToFloat(pore_word@(4))) * rx;
    precise float v = (y - uintBitsToFloat(pore_word@(5))) * ry;
    precise float w = (z - uintBitsToFloat(pore_word@(6))) * rz;
    float tx = float(nx - 1);
    float ty = float(ny - 1);
    float tz = float(nz - 1);
    bool bad = pore_is_nan(u) || pore_is_nan(v) || pore_is_nan(w);
    bool outside = (kx > 0 && (u < 0.0 || u > tx)) || (ky > 0 && (v < 0.0 || v > ty)) || (kz > 0 && (w < 0.0 || w > tz));
    u = u > 0.0 ? u : 0.0;
    v = v > 0.0 ? v : 0.0;
    w = w > 0.0 ? w : 0.0;
    u = u < tx ? u : tx;
    v = v < ty ? v : ty;
    w = w < tz ? w : tz;
    if (bad) { u = 0.0; v = 0.0; w = 0.0; }
    int i = int(u) < nx - 2 ? int(u) : nx - 2;
    int j = int(v) < ny - 2 ? int(v) : ny - 2;
    int k = int(w) < nz - 2 ? int(w) : nz - 2;
    precise float f = u - float(i);
    precise float g = v - float(j);
    precise float h = w - float(k);
    int row = nz * step;
    int plane = ny * row;
    int at = 16 + i * plane + j * row + k * step + c;
    precise float p0 = 0.0;
    precise float p1 = 0.0;
    for (int n = 0; n < 2; n++) {
        int q = at + n * plane;
        float a0 = uintBitsToFloat(pore_word@(q));
        float a1 = uintBitsToFloat(pore_word@(q + row));
        precise float d0 = uintBitsToFloat(pore_word@(q + step)) - a0;
        precise float d1 = uintBitsToFloat(pore_word@(q + row + step)) - a1;
        precise float s0 = kz == 0 ? a0 + d0 * h : d0 * rz;
        precise float s1 = kz == 0 ? a1 + d1 * h : d1 * rz;
        precise float d = s1 - s0;
        p0 = p1;
        p1 = ky == 0 ? s0 + d * g : d * ry;
    }
    precise float d = p1 - p0;
    precise float s = kx == 0 ? p0 + d * f : d * rx;
    if (outside) s = 0.0;
    return bad ? pore_nan() : s;
}
