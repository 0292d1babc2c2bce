// Where a point lies in a sampled field (porelang/ops/words.py), beyond it the nearest place; kx, ky and kz are the orders
// of the derivative that is asked for. Equal to NumPy's in float32 (porelang/ops/grid_loops.py).
PoreCell pore_cell@(float x, float y, float z, int kx, int ky, int kz) {
    int nx = int(pore_word@(0));
    int ny = int(pore_word@(1));
    int nz = int(pore_word@(2));
    precise float u = (x - uintBitsToFloat(pore_word@(4))) * uintBitsToFloat(pore_word@(7));
    precise float v = (y - uintBitsToFloat(pore_word@(5))) * uintBitsToFloat(pore_word@(8));
    precise float w = (z - uintBitsToFloat(pore_word@(6))) * uintBitsToFloat(pore_word@(9));
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
    return PoreCell(i, j, k, f, g, h, bad, outside);
}
