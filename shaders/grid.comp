#version 430
// The field on a block of a grid, z fastest. The coordinates of the three axes come as one list, rounded once by the
// caller, so that every backend samples the same places. A group walks one row along z, so that what depends on x and y
// alone is computed once a row: half the time of a group for every 64 samples, on Mesa's software driver.
layout(local_size_x = 32) in;
layout(std430, binding = 0) writeonly buffer Values { float values[]; };
layout(std430, binding = 1) readonly buffer Axes { float axes[]; };
uniform ivec3 shape;

// @field

void main() {
    int i = int(gl_WorkGroupID.y);
    int j = int(gl_WorkGroupID.x);
    int row = (i * shape.y + j) * shape.z;
    float x = axes[i];
    float y = axes[shape.x + j];
    for (int k = int(gl_LocalInvocationID.x); k < shape.z; k += 32) {
        values[row + k] = field(vec3(x, y, axes[shape.x + shape.y + k]));
    }
}
