#version 430
// The field at a list of points: three coordinates each in, one value out, or ROOTS that follow each other.
layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer Values { float values[]; };
layout(std430, binding = 1) readonly buffer Points { float points[]; };
uniform int count;

uniform float u[1];
layout(std430, binding = 2) readonly buffer Data0 { uint data0[]; };
uint pore_word0(int i) { return data0[i]; }
layout(std430, binding = 3) readonly buffer Data1 { uint data1[]; };
uint pore_word1(int i) { return data1[i]; }
// Where a point lies in a sampled field: the lower node of its cell, the part of the cell on each axis, whether a
// coordinate is not a number, and whether the derivative that is asked for is 0 there.
struct PoreCell {
    int i;
    int j;
    int k;
    float f;
    float g;
    float h;
    bool bad;
    bool outside;
};
// Whether x is not a number, by its bits: a driver may assume that x != x is never true.
bool pore_is_nan(float x) {
    return (floatBitsToUint(x) & 0x7fffffffu) > 0x7f800000u;
}
// Where a point lies in a sampled field (porelang/ops/words.py), beyond it the nearest place; kx, ky and kz are the orders
// of the derivative that is asked for. Equal to NumPy's in float32 (porelang/ops/grid_loops.py).
PoreCell pore_cell0(float x, float y, float z, int kx, int ky, int kz) {
    int nx = int(pore_word0(0));
    int ny = int(pore_word0(1));
    int nz = int(pore_word0(2));
    precise float u = (x - uintBitsToFloat(pore_word0(4))) * uintBitsToFloat(pore_word0(7));
    precise float v = (y - uintBitsToFloat(pore_word0(5))) * uintBitsToFloat(pore_word0(8));
    precise float w = (z - uintBitsToFloat(pore_word0(6))) * uintBitsToFloat(pore_word0(9));
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
// Not a number, from its bits: 0.0 / 0.0 is folded to 0 by some drivers.
float pore_nan() {
    return uintBitsToFloat(0x7fc00000u);
}
// Trilinear interpolation of component c of a sampled field (porelang/ops/words.py), or its derivative of the orders
// kx, ky, kz (0 or 1). Equal to NumPy's in float32, bit for bit (porelang/ops/grid_loops.py).
float pore_lookup0(float x, float y, float z, int c, int kx, int ky, int kz) {
    int ny = int(pore_word0(1));
    int nz = int(pore_word0(2));
    int step = int(pore_word0(3));
    float rx = uintBitsToFloat(pore_word0(7));
    float ry = uintBitsToFloat(pore_word0(8));
    float rz = uintBitsToFloat(pore_word0(9));
    PoreCell at = pore_cell0(x, y, z, kx, ky, kz);
    int row = nz * step;
    int plane = ny * row;
    int first = 16 + at.i * plane + at.j * row + at.k * step + c;
    precise float p0 = 0.0;
    precise float p1 = 0.0;
    for (int n = 0; n < 2; n++) {
        int q = first + n * plane;
        float a0 = uintBitsToFloat(pore_word0(q));
        float a1 = uintBitsToFloat(pore_word0(q + row));
        precise float d0 = uintBitsToFloat(pore_word0(q + step)) - a0;
        precise float d1 = uintBitsToFloat(pore_word0(q + row + step)) - a1;
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
// What one walk to the nearest bar finds (porelang/ops/segments.py).
struct PoreNearest {
    float distance;
    float nx;
    float ny;
    float nz;
    float dx;
    float dy;
    float dz;
    float along;
    float radius;
    float length;
    float index;
};
// The nearest integer, halves to the even one. Exact; NaN and infinities stay what they are. GLSL leaves it to the
// driver where round() sends a half.
float pore_round(float x) {
    return pore_is_nan(x) ? x : roundEven(x);
}
// A coordinate moved by whole periods to within half a period of 0, as porelang/ops/segment_copies.py does; what is
// infinite stays so, and what is no number.
float pore_folded(float x, float period, float inverse) {
    precise float u = x * inverse;
    precise float turns = pore_round(u);
    precise float moved = x - turns * period;
    return pore_is_nan(moved) ? x : moved;
}
// Positive infinity, from its bits.
float pore_inf() {
    return uintBitsToFloat(0x7f800000u);
}
// The vector from the nearest place on the axis between two ends to p, and where along the axis that place is (0..1).
// `inverse` is 1 / length^2. Beyond an end the vector is measured from that end, so that bars that meet there tie.
vec4 pore_foot(vec3 start, vec3 end, float inverse, vec3 p) {
    precise float ex = end.x - start.x;
    precise float ey = end.y - start.y;
    precise float ez = end.z - start.z;
    precise float wx = p.x - start.x;
    precise float wy = p.y - start.y;
    precise float wz = p.z - start.z;
    precise float t = ((wx * ex + wy * ey) + wz * ez) * inverse;
    precise float qx = wx - ex * t;
    precise float qy = wy - ey * t;
    precise float qz = wz - ez * t;
    precise vec3 beyond = p - end;
    if (t >= 1.0) return vec4(beyond, 1.0);
    return t > 0.0 ? vec4(qx, qy, qz, t) : vec4(wx, wy, wz, 0.0);
}
// The upper half of x: its first 12 significant bits. Products of two halves are exact in float32, so that
// x y = xh yh + xh yl + xl yh + xl yl with xl = x - xh gives the rounding error of x * y (after Dekker 1971).
float pore_high(float x) {
    return uintBitsToFloat(floatBitsToUint(x) & 0xfffff000u);
}
// The square root; NaN for negatives, sqrt(-0) = -0.
// Error: 0.5 ulp (equal to NumPy's root for all 2^24 mantissas); denormals count as 0.
// The driver's root of the mantissa is corrected by its exact remainder (one step of Newton's method).
float pore_sqrt(float x) {
    uint i = floatBitsToUint(x);
    int e = int((i >> 23) & 255u) - 127;
    int odd = e & 1;
    float m = uintBitsToFloat((i & 0x007fffffu) | uint(127 + odd) << 23);
    precise float s = sqrt(m);
    float h = pore_high(s);
    precise float l = s - h;
    precise float rest = ((m - h * h) - 2.0 * h * l) - l * l;
    precise float exact = s + rest * (0.49999997 / s);  // a hair less than half: s is below the root where it matters
    precise float y = exact * uintBitsToFloat(uint(127 + ((e - odd) >> 1)) << 23);
    if ((i & 0x7f800000u) == 0u) y = uintBitsToFloat(i & 0x80000000u);
    else if (i > 0x7f800000u) y = pore_nan();
    else if (i == 0x7f800000u) y = x;
    return y;
}
// The bar at a place of the tree, tried: it becomes the best (its place and number) where its surface is nearer, of two
// that tie the one of the lower number. `least` is the distance from the surface, and from the axis.
void pore_try1(int bars, int ids, int place, vec3 p, inout vec2 least, inout vec4 foot, inout ivec2 best) {
    int leaf = bars + 64 * (place / 8);
    int c = place % 8;
    float r = uintBitsToFloat(pore_word1(leaf + 48 + c));
    if (!(r >= 0.0)) return;
    vec3 start = vec3(uintBitsToFloat(pore_word1(leaf + c)), uintBitsToFloat(pore_word1(leaf + 8 + c)),
                      uintBitsToFloat(pore_word1(leaf + 16 + c)));
    vec3 end = vec3(uintBitsToFloat(pore_word1(leaf + 24 + c)), uintBitsToFloat(pore_word1(leaf + 32 + c)),
                    uintBitsToFloat(pore_word1(leaf + 40 + c)));
    vec4 q = pore_foot(start, end, uintBitsToFloat(pore_word1(leaf + 56 + c)), p);
    precise float square = (q.x * q.x + q.y * q.y) + q.z * q.z;
    float size = pore_sqrt(square);
    precise float d = size - r;
    int own = int(pore_word1(ids + place));
    if (d < least.x || (d == least.x && own < best.y)) {
        best = ivec2(place, own);
        least = vec2(d, size);
        foot = q;
    }
}
// x 2^n for n in -252..254 and finite x, rounded once: in two steps, since 2^n alone may not be a float.
float pore_scale(float x, int n) {
    int half_n = n >> 1;
    precise float first = x * uintBitsToFloat(uint(half_n + 127) << 23);
    precise float y = first * uintBitsToFloat(uint(n - half_n + 127) << 23);
    return y;
}
// a / b as IEEE has it: x / 0 is an infinity with the sign of both, 0 / 0 and inf / inf are NaN.
// Error: 0.5 ulp (equal to NumPy's quotient in all of 4 million trials); denormals count as 0.
// The driver's quotient of the mantissas, good to 2.5 ulp by the specification, is corrected by its exact remainder.
float pore_div(float a, float b) {
    uint i = floatBitsToUint(a);
    uint j = floatBitsToUint(b);
    uint s = (i ^ j) & 0x80000000u;
    i &= 0x7fffffffu;
    j &= 0x7fffffffu;
    float m = uintBitsToFloat((i & 0x007fffffu) | 0x3f800000u);
    float d = uintBitsToFloat((j & 0x007fffffu) | 0x3f800000u);
    precise float q = m / d;
    float qh = pore_high(q);
    float dh = pore_high(d);
    precise float ql = q - qh;
    precise float dl = d - dh;
    precise float rest = (((m - qh * dh) - qh * dl) - ql * dh) - ql * dl;
    precise float exact = q + rest / d;
    uint y = floatBitsToUint(pore_scale(exact, int(i >> 23) - int(j >> 23)));
    bool a_zero = i < 0x00800000u;
    bool b_zero = j < 0x00800000u;
    bool a_inf = i == 0x7f800000u;
    bool b_inf = j == 0x7f800000u;
    if (a_zero || b_inf) y = 0u;
    if (b_zero || a_inf) y = 0x7f800000u;
    if ((a_zero && b_zero) || (a_inf && b_inf) || i > 0x7f800000u || j > 0x7f800000u) y = 0x7fc00000u;
    return uintBitsToFloat(y | s);
}
// The nearest bar of segments (porelang/ops/words.py), by the walk of porelang/ops/segment_loops.py through the same
// tree, or by its lists of cells (porelang/ops/segment_cells.py); of bars that repeat by those near the cell about the
// origin, to which the place is moved (porelang/ops/segment_copies.py). Not a number where a coordinate is none; too
// far away for squares, the distance is infinite and all else NaN.
PoreNearest pore_nearest1(float x, float y, float z) {
    int groups = int(pore_word1(0));
    int leaves = int(pore_word1(1));
    int top = int(pore_word1(2));
    int bars = 16 + 56 * groups;
    int frames = bars + 64 * leaves;
    int ids = frames + 32 * leaves;
    int repeats = int(pore_word1(6));
    bool bad = pore_is_nan(x) || pore_is_nan(y) || pore_is_nan(z);
    if (repeats > 0) {
        x = pore_folded(x, uintBitsToFloat(pore_word1(repeats)), uintBitsToFloat(pore_word1(repeats + 3)));
        y = pore_folded(y, uintBitsToFloat(pore_word1(repeats + 1)), uintBitsToFloat(pore_word1(repeats + 4)));
        z = pore_folded(z, uintBitsToFloat(pore_word1(repeats + 2)), uintBitsToFloat(pore_word1(repeats + 5)));
    }
    vec3 p = vec3(x, y, z);
    precise float slack = uintBitsToFloat(pore_word1(4)) * (uintBitsToFloat(pore_word1(3)) + ((abs(x) + abs(y)) + abs(z)));
    vec2 least = vec2(pore_inf(), 0.0);
    vec4 foot = vec4(0.0);
    ivec2 best = ivec2(-1, 0);
    int stack[80];
    float keys[80];
    int height = 0;
    int node = 0;
    bool going = !bad && slack < 1e30;
    int cells = int(pore_word1(8));
    if (going && cells > 0) {
        ivec3 shape = ivec3(int(pore_word1(9)), int(pore_word1(10)), int(pore_word1(11)));
        vec3 low = vec3(uintBitsToFloat(pore_word1(12)), uintBitsToFloat(pore_word1(13)), uintBitsToFloat(pore_word1(14)));
        precise vec3 at = floor((p - low) * uintBitsToFloat(pore_word1(15)));
        if (all(greaterThanEqual(at, vec3(0.0))) && all(lessThan(at, vec3(shape)))) {
            ivec3 cell = ivec3(at);
            int k = cells + (cell.x * shape.y + cell.y) * shape.z + cell.z;
            int list = cells + shape.x * shape.y * shape.z + 1;
            int end = int(pore_word1(k + 1));
            for (int i = int(pore_word1(k)); i < end; i++) {
                going = false;
                pore_try1(bars, ids, int(pore_word1(list + i)), p, least, foot, best);
            }
        }
    }
    while (going) {
        precise float reach = least.x + slack;
        if (node < groups) {
            int box = 16 + 56 * node;
            int first = node == 0 ? 1 : 8 * node - 7 + top;
            int bottom = height;
            for (int c = 0; c < 8; c++) {
                float r = uintBitsToFloat(pore_word1(box + 48 + c));
                if (!(r >= 0.0)) continue;
                precise vec3 before = vec3(uintBitsToFloat(pore_word1(box + c)), uintBitsToFloat(pore_word1(box + 8 + c)),
                                           uintBitsToFloat(pore_word1(box + 16 + c))) - p;
                precise vec3 after = p - vec3(uintBitsToFloat(pore_word1(box + 24 + c)), uintBitsToFloat(pore_word1(box + 32 + c)),
                                              uintBitsToFloat(pore_word1(box + 40 + c)));
                float dx = before.x > after.x ? before.x : after.x;
                float dy = before.y > after.y ? before.y : after.y;
                float dz = before.z > after.z ? before.z : after.z;
                dx = dx > 0.0 ? dx : 0.0;
                dy = dy > 0.0 ? dy : 0.0;
                dz = dz > 0.0 ? dz : 0.0;
                precise float square = (dx * dx + dy * dy) + dz * dz;
                precise float key = pore_sqrt(square) - r;
                if (key <= reach) {
                    int at = height;
                    while (at > bottom && keys[at - 1] < key) {
                        stack[at] = stack[at - 1];
                        keys[at] = keys[at - 1];
                        at--;
                    }
                    stack[at] = first + c;
                    keys[at] = key;
                    height++;
                }
            }
        } else {
            for (int c = 0; c < 8; c++)
                pore_try1(bars, ids, 8 * (node - groups) + c, p, least, foot, best);
        }
        going = false;
        while (height > 0 && !going) {
            height--;
            precise float limit = least.x + slack;
            node = stack[height];
            going = keys[height] <= limit;
        }
    }
    float none = pore_nan();
    if (best.x < 0) {
        return PoreNearest(bad ? none : pore_inf(), none, none, none, none, none, none, none, none, none, none);
    }
    float root = least.y;
    bool on = root == 0.0;
    int frame = frames + 4 * best.x;
    float radius = uintBitsToFloat(pore_word1(bars + 64 * (best.x / 8) + 48 + best.x % 8));
    int number = repeats > 0 ? int(pore_word1(repeats + 6 + best.y)) : best.y;
    return PoreNearest(
        least.x,
        on ? 0.0 : pore_div(foot.x, root), on ? 0.0 : pore_div(foot.y, root), on ? 0.0 : pore_div(foot.z, root),
        uintBitsToFloat(pore_word1(frame)), uintBitsToFloat(pore_word1(frame + 1)), uintBitsToFloat(pore_word1(frame + 2)),
        foot.w, radius, uintBitsToFloat(pore_word1(frame + 3)), float(number));
}
// The number x, every NaN as the same one. What a shader stores in a buffer goes through this: Mesa's software driver
// writes a buffer in a loop over the lanes, and LLVM moves the arithmetic of a value that is used once into that loop,
// one lane at a time. Used twice, it stays eight wide: 55 instead of 188 ms for 12 sines of 4.6 million points.
float pore_keep(float x) {
    return pore_is_nan(x) ? pore_nan() : x;
}
float field(vec3 p) {
    precise float v0 = pore_lookup0(p.x, p.y, p.z, 0, 0, 0, 0);
    precise float v1 = (v0 / 1.0e+01);
    PoreNearest v2 = pore_nearest1(p.x, p.y, p.z);
    precise float v3 = (v1 + v2.nx);
    precise float v4 = (v2.distance - u[0]);
    precise float v5 = min(v3, v4);
    return pore_keep(v5);
}

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint i = group * 64u + gl_LocalInvocationID.x;
    if (i >= uint(count)) return;
    vec3 p = vec3(points[3u * i], points[3u * i + 1u], points[3u * i + 2u]);
#ifdef ROOTS
    float f[ROOTS];
    fields(p, f);
    for (int k = 0; k < ROOTS; k++) values[uint(ROOTS) * i + uint(k)] = f[k];
#else
    values[i] = field(p);
#endif
}
