// Tricubic Catmull-Rom interpolation of component c of a sampled field (porelang/ops/words.py), or its derivative of the
// orders kx, ky, kz (0 to 3). Equal to NumPy's in float32 (porelang/ops/grid_loops.py).
float pore_cubic@(float x, float y, float z, int c, int kx, int ky, int kz) {
    int nx = int(pore_word@(0));
    int ny = int(pore_word@(1));
    int nz = int(pore_word@(2));
    int step = int(pore_word@(3));
    float rx = uintBitsToFloat(pore_word@(7));
    float ry = uintBitsToFloat(pore_word@(8));
    float rz = uintBitsToFloat(pore_word@(9));
    PoreCell at = pore_cell@(x, y, z, kx, ky, kz);
    vec3 wx = pore_catmull(at.f, at.i, nx, kx);
    vec3 wy = pore_catmull(at.g, at.j, ny, ky);
    vec3 wz = pore_catmull(at.h, at.k, nz, kz);
    precise float sx = 1.0;
    precise float sy = 1.0;
    precise float sz = 1.0;
    for (int n = 0; n < kx; n++) sx = sx * rx;
    for (int n = 0; n < ky; n++) sy = sy * ry;
    for (int n = 0; n < kz; n++) sz = sz * rz;
    int row = nz * step;
    int plane = ny * row;
    int k0 = (at.k > 0 ? at.k - 1 : 0) * step + c;
    int k1 = at.k * step + c;
    int k2 = k1 + step;
    int k3 = (at.k + 2 < nz ? at.k + 2 : at.k + 1) * step + c;
    vec4 planes = vec4(0.0);
    for (int m = 0; m < 4; m++) {
        int a = at.i - 1 + m;
        a = a > 0 ? a : 0;
        a = a < nx ? a : nx - 1;
        vec4 rows = vec4(0.0);
        for (int n = 0; n < 4; n++) {
            int b = at.j - 1 + n;
            b = b > 0 ? b : 0;
            b = b < ny ? b : ny - 1;
            int q = 16 + a * plane + b * row;
            vec4 line = vec4(uintBitsToFloat(pore_word@(q + k0)), uintBitsToFloat(pore_word@(q + k1)),
                             uintBitsToFloat(pore_word@(q + k2)), uintBitsToFloat(pore_word@(q + k3)));
            precise float r = pore_blend(line, wz, kz) * sz;
            rows = vec4(rows.yzw, r);
        }
        precise float r = pore_blend(rows, wy, ky) * sy;
        planes = vec4(planes.yzw, r);
    }
    precise float s = pore_blend(planes, wx, kx) * sx;
    if (at.outside) s = 0.0;
    return at.bad ? pore_nan() : s;
}
