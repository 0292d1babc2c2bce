#version 430
// The field at a list of points: three coordinates each in, one value out, or ROOTS that follow each other.
layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer Values { float values[]; };
layout(std430, binding = 1) readonly buffer Points { float points[]; };
uniform int count;

// The sine of t turns for t in -1/4..1/4. Error: 1.1e-7, 1.9 ulp.
// sin(tau t) = 4 t + t P(t^2), where 4 t is exact, with the minimax polynomial of degree 4 for the relative error
// (1.1e-8), by linear programming in float64, its coefficients rounded to float32 one after another.
float pore_sine(float t) {
    precise float z = t * t;
    precise float p = ((39.3661575 * z - 76.5335617) * z + 81.6006927) * z - 41.3416595;
    precise float y = 4.0 * t + t * (z * p + 2.28318524);
    return y;
}
// The cosine of u turns, cos(tau u); NaN for infinities. Error: 1.1e-7, however large u.
// The reduction is exact; 1/4 - |r| is rounded only where the cosine is flat.
float pore_cos_turns(float u) {
    precise float r = u - roundEven(u);
    precise float t = 0.25 - abs(r);
    return pore_sine(t);
}
// The sine of u turns, sin(tau u); NaN for infinities. Error: 1.1e-7, however large u.
// u - roundEven(u) is exact, so the error does not grow with u; folding to a quarter turn is exact too.
float pore_sin_turns(float u) {
    precise float r = u - roundEven(u);
    precise float folded = (r < 0.0 ? -0.5 : 0.5) - r;
    return pore_sine(abs(r) > 0.25 ? folded : r);
}
// Whether x is not a number, by its bits: a driver may assume that x != x is never true.
bool pore_is_nan(float x) {
    return (floatBitsToUint(x) & 0x7fffffffu) > 0x7f800000u;
}
// Not a number, from its bits: 0.0 / 0.0 is folded to 0 by some drivers.
float pore_nan() {
    return uintBitsToFloat(0x7fc00000u);
}
// The number x, every NaN as the same one. What a shader stores in a buffer goes through this: Mesa's software driver
// writes a buffer in a loop over the lanes, and LLVM moves the arithmetic of a value that is used once into that loop,
// one lane at a time. Used twice, it stays eight wide: 55 instead of 188 ms for 12 sines of 4.6 million points.
float pore_keep(float x) {
    return pore_is_nan(x) ? pore_nan() : x;
}
float field(vec3 p) {
    precise float v0 = (p.z * 7.957747e-03);
    precise float v1 = pore_cos_turns(v0);
    precise float v2 = (p.x * v1);
    precise float v3 = pore_sin_turns(v0);
    precise float v4 = (p.y * v3);
    precise float v5 = (v2 - v4);
    precise float v6 = (v5 * 8.660254e-01);
    precise float v7 = (p.x * v3);
    precise float v8 = (v1 * p.y);
    precise float v9 = (v7 + v8);
    precise float v10 = (-v9);
    precise float v11 = (v10 * 5.0e-01);
    precise float v12 = (v6 - v11);
    precise float v13 = abs(v12);
    precise float v14 = (v13 - 5.0e+00);
    precise float v15 = max(v14, 0.0e+00);
    precise float v16 = (v9 * 8.660254e-01);
    precise float v17 = (v5 * 5.0e-01);
    precise float v18 = (v16 - v17);
    precise float v19 = abs(v18);
    precise float v20 = (v19 - 1.0e+01);
    precise float v21 = max(v20, 0.0e+00);
    precise float v22 = sqrt(v15 * v15 + v21 * v21);
    precise float v23 = (p.z * 8.660254e-01);
    precise float v24 = (p.z * 1.339746e-01);
    precise float v25 = (v23 + v24);
    precise float v26 = abs(v25);
    precise float v27 = (v26 - 1.5e+01);
    precise float v28 = max(v27, 0.0e+00);
    precise float v29 = sqrt(v22 * v22 + v28 * v28);
    precise float v30 = max(v14, v20);
    precise float v31 = max(v27, v30);
    precise float v32 = min(v31, 0.0e+00);
    precise float v33 = (v29 + v32);
    return pore_keep(v33);
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
