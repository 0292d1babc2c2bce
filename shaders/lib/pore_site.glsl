// Where in its cell the site of a cell lies, from the middle of it: exactly (porelang/ops/site_loops.py). And its number.
vec4 pore_site(ivec3 cell, int seed, float jitter) {
    uvec4 v = pore_pcg4d(uvec4(ivec4(cell, seed)));
    ivec3 place = 2 * (ivec3(v.xyz >> 17u) - 16384) + 1;
    return vec4(vec3(place) * (jitter * 5.9604644775390625e-8), float(v.w >> 8u) * 5.9604644775390625e-8);
}
