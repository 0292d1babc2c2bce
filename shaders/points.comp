#version 430
// The field at a list of points: three coordinates each in, one value out, or ROOTS that follow each other.
layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer Values { float values[]; };
layout(std430, binding = 1) readonly buffer Points { float points[]; };
uniform int count;

// @field

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
