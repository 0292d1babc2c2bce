#version 430
// The field on a block of a grid, z fastest. The coordinates of the three axes come as one list, rounded once by the
// caller, so that every backend samples the same places.
layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer Values { float values[]; };
layout(std430, binding = 1) readonly buffer Axes { float axes[]; };
uniform ivec3 shape;

// @field

void main() {
    int k = int(gl_GlobalInvocationID.x);
    int j = int(gl_GlobalInvocationID.y);
    int i = int(gl_GlobalInvocationID.z);
    if (k < shape.z) {
        values[(i * shape.y + j) * shape.z + k] =
            field(vec3(axes[i], axes[shape.x + j], axes[shape.x + shape.y + k]));
    }
}
