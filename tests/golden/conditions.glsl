#version 430
// The field at a list of points: three coordinates each in, one value out, or ROOTS that follow each other.
layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer Values { float values[]; };
layout(std430, binding = 1) readonly buffer Points { float points[]; };
uniform int count;

uniform float u[1];
// Zero, as a uniform that is never set: a factor that the driver cannot see. Drivers fold x * 0.0 to 0.0 in spite of
// `precise`, also where x is infinite or no number (seen on Mesa 22.3).
uniform float pore_nought;
// Whether b does not hold. NVIDIA's compiler takes !(a < b) for a >= b, which a NaN makes false too (measured: an H200,
// driver 580), in whatever words it is written; a sum with a number that it does not know it leaves alone.
bool pore_not(bool b) {
    precise float x = (b ? 1.0 : 0.0) + pore_nought;
    return x < 0.5;
}
// Whether x is not a number, by its bits: a driver may assume that x != x is never true.
bool pore_is_nan(float x) {
    return (floatBitsToUint(x) & 0x7fffffffu) > 0x7f800000u;
}
// The largest integer that is not above x. Exact; NaN and infinities stay what they are.
float pore_floor(float x) {
    return pore_is_nan(x) ? x : floor(x);
}
// The upper half of x: its first 12 significant bits. Products of two halves are exact in float32, so that
// x y = xh yh + xh yl + xl yh + xl yl with xl = x - xh gives the rounding error of x * y (after Dekker 1971).
float pore_high(float x) {
    return uintBitsToFloat(floatBitsToUint(x) & 0xfffff000u);
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
// a - b floor(a / b): the remainder with the sign of b. Error: that of a float32 evaluation of this formula, every
// step of which is rounded correctly; where b is 0 or either is infinite, NaN.
float pore_mod(float a, float b) {
    precise float whole = b * pore_floor(pore_div(a, b));
    precise float y = a - whole;
    return y;
}
// Not a number, from its bits: 0.0 / 0.0 is folded to 0 by some drivers.
float pore_nan() {
    return uintBitsToFloat(0x7fc00000u);
}
// The angle of the point (x, y) in -pi..pi, with C's and NumPy's rules for signed zeros and infinities.
// Error: 1.5 ulp. Denormals count as 0.
// atan(q) = q + q^3 P(q^2) for q in 0..1 with the minimax polynomial of degree 8 for the relative error (2.6e-9), by
// linear programming in float64; then pi / 2 and pi in two floats.
float pore_atan2(float y, float x) {
    uint i = floatBitsToUint(y);
    uint j = floatBitsToUint(x);
    uint sign_bit = i & 0x80000000u;
    bool left = j > 0x7fffffffu;
    i &= 0x7fffffffu;
    j &= 0x7fffffffu;
    bool steep = i > j;
    uint small = steep ? j : i;
    uint large = steep ? i : j;
    float q = pore_div(uintBitsToFloat(small), uintBitsToFloat(large));
    if (large < 0x00800000u) q = 0.0;
    if (small == 0x7f800000u) q = 1.0;
    precise float z = q * q;
    precise float p = ((-1.78300741e-3 * z + 1.08692329e-2) * z - 3.10976002e-2) * z + 5.78817166e-2;
    precise float t = (((p * z - 8.39931443e-2) * z + 0.109508812) * z - 0.142640159) * z + 0.199985296;
    precise float a = q + q * (z * (t * z - 0.333332986));
    precise float upright = 1.57079637 - (a + 4.37113883e-8);
    if (steep) a = upright;
    precise float mirrored = 3.14159274 - (a + 8.74227766e-8);
    if (left) a = mirrored;
    if (large > 0x7f800000u) a = pore_nan();
    return uintBitsToFloat(floatBitsToUint(a) | sign_bit);
}
// The number x, every NaN as the same one. What a shader stores in a buffer goes through this: Mesa's software driver
// writes a buffer in a loop over the lanes, and LLVM moves the arithmetic of a value that is used once into that loop,
// one lane at a time. Used twice, it stays eight wide: 55 instead of 188 ms for 12 sines of 4.6 million points.
float pore_keep(float x) {
    return pore_is_nan(x) ? pore_nan() : x;
}
float field(vec3 p) {
    bool v0 = (p.x < u[0]);
    bool v1 = (p.y <= 0.0e+00);
    bool v2 = pore_not(v1);
    bool v3 = (v0 && v2);
    precise float v4 = pore_mod(p.x, u[0]);
    precise float v5 = pore_atan2(p.y, p.x);
    precise float v6 = (v3 ? v4 : v5);
    return pore_keep(v6);
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
