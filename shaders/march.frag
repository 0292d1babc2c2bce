// @version
// A picture of the solid by sphere tracing: from the eye through each pixel, in steps that no surface can lie within.
//
// The box is divided into cells. For each the host has proved one of four things, told apart by one number: 0, no solid
// lies in it, and it is passed as a whole; -1, it is solid throughout; a slope, by which the field changes at most per mm,
// so that the field divided by it is a safe step; or more than STEEP where the field may jump, and small steps are taken.
out vec4 colour;
uniform int want;       // LIGHT, DISTANCE or STEPS
uniform vec2 size;      // of the whole picture, in pixels
uniform vec2 corner;    // of this tile, from the bottom left, in pixels
uniform int samples;    // pixels along a side that are averaged to one in the end
uniform vec3 eye;       // in mm
uniform mat3 camera;    // right, up, forward
uniform float zoom;     // half the height of the picture: at distance 1, or in mm where rays are parallel
uniform float perspective;  // 1, or 0 for parallel rays
uniform vec3 box_lo;    // what is shown of the part, in mm
uniform vec3 box_hi;
uniform vec3 cut_lo;    // 1 where that face of the box cuts the part
uniform vec3 cut_hi;
uniform ivec3 counts;   // of cells along each axis
uniform float nearest;  // no step is shorter, in mm
uniform float jump;     // the step where the field may jump, in mm
uniform float reach;    // how far around a place light is looked for, in mm
uniform float grain;    // the distance over which a normal is measured, in mm

const int LIGHT = 0;
const int DISTANCE = 1;
const int STEPS = 2;
const int MOST_STEPS = 65536;   // a ray of the longest box takes fewer
const float STEEP = 1e29;
const int DIRECTIONS = 8;
const int RINGS = 12;
const vec3 MATERIAL = vec3(0.945, 0.915, 0.855);
const vec3 SECTION = vec3(0.800, 0.440, 0.330);

#ifdef GL_ES
uniform highp sampler3D cells;
float cell(ivec3 at) { return texelFetch(cells, at, 0).r; }
#else
layout(std430, binding = 1) readonly buffer Cells { float cells[]; };
float cell(ivec3 at) { return cells[(at.x * counts.y + at.y) * counts.z + at.z]; }

// What this shader found when it was asked for DISTANCE, so that LIGHT need not look for it again.
layout(std430, binding = 2) readonly buffer Distances { float distances[]; };
uniform int across;  // of this tile, in pixels
#endif

// @field

float least(vec3 v) { return min(v.x, min(v.y, v.z)); }

float most(vec3 v) { return max(v.x, max(v.y, v.z)); }

bool solid(vec3 p) {
    return field(p) <= 0.0;
}

// The distance at which a ray meets the solid between `start` and `end`, or -1; `count` is the number of samples taken.
float meet(vec3 from, vec3 way, float start, float end, out int count) {
    vec3 edge = (box_hi - box_lo) / vec3(counts);
    vec3 ahead = step(vec3(0.0), way);
    float past = 0.25 * nearest;
    float before = start;
    float t = start;
    count = 0;
    for (int i = 0; i < MOST_STEPS && t <= end; i++) {
        vec3 p = from + way * t;
        ivec3 at = clamp(ivec3(floor((p - box_lo) / edge)), ivec3(0), counts - 1);
        float slope = cell(at);
        float leave = max(least((box_lo + (vec3(at) + ahead) * edge - from) / way), t) + past;
        float onward = leave;
        if (slope != 0.0) {
            float f = -1.0;
            if (slope > 0.0) {
                f = field(p);
                count++;
            }
            if (f <= 0.0) {
                for (int j = 0; j < 32 && t - before > past; j++) {
                    float middle = 0.5 * (before + t);
                    if (solid(from + way * middle)) t = middle;
                    else before = middle;
                    count++;
                }
                return t;
            }
            onward = min(leave, t + (slope < STEEP && f > nearest * slope ? f / slope : slope < STEEP ? nearest : jump));
        }
        before = t;
        t = onward;
    }
    return -1.0;
}

// Outward, from differences of the field.
vec3 normal(vec3 p) {
    vec2 e = vec2(grain, 0.0);
    vec3 n = vec3(field(p + e.xyy) - field(p - e.xyy), field(p + e.yxy) - field(p - e.yxy),
                  field(p + e.yyx) - field(p - e.yyx));
    float length_ = max(abs(n.x), max(abs(n.y), abs(n.z)));
    return length_ > 0.0 && length_ < 1e30 ? normalize(n / length_) : -camera[2];
}

// The face of the box that a place lies on, as an outward normal, if the part is cut there; else 0.
vec3 cut(vec3 p) {
    vec3 below = cut_lo * step(p - box_lo, vec3(nearest));
    vec3 above = cut_hi * step(box_hi - p, vec3(nearest));
    vec3 n = above - below;
    return n.x != 0.0 ? vec3(n.x, 0.0, 0.0) : n.y != 0.0 ? vec3(0.0, n.y, 0.0) : vec3(0.0, 0.0, n.z);
}

// How much of the sky above a surface is not hidden by solid within `reach`: 0 to 1. The directions turn from one
// sample of a pixel to the next, so that their average has many and no grain is seen.
float sky(vec3 p, vec3 n) {
    vec3 a = normalize(abs(n.z) < 0.9 ? cross(n, vec3(0.0, 0.0, 1.0)) : cross(n, vec3(1.0, 0.0, 0.0)));
    vec3 b = cross(n, a);
    ivec2 pixel = ivec2(gl_FragCoord.xy + corner) % samples;
    float turn = float(pixel.x + samples * pixel.y) / float(samples * samples);
    float hidden = 0.0;
    for (int i = 0; i < DIRECTIONS; i++) {
        float r2 = (float(i) + 0.5 * (turn + 0.5)) / float(DIRECTIONS);
        float angle = 2.3999632 * (float(i) + turn * float(DIRECTIONS));
        vec3 d = sqrt(r2) * (cos(angle) * a + sin(angle) * b) + sqrt(1.0 - r2) * n;
        for (int k = 0; k < RINGS; k++) {
            float far = (float(k) + 0.4 + 0.6 * turn) / float(RINGS);
            vec3 q = p + n * grain + d * (reach * far * far);
            if (most(max(box_lo - q, q - box_hi)) > 0.0) break;
            if (solid(q)) {
                hidden += 1.0 - 0.8 * far * far;
                break;
            }
        }
    }
    return 1.0 - hidden / float(DIRECTIONS);
}

vec3 lit(vec3 p) {
    vec3 face = cut(p);
    bool section = face != vec3(0.0);
    vec3 n = section ? face : normal(p);
    vec3 v = n * camera;  // in the viewer's axes: right, up, forward
    if (section) return SECTION * (0.93 + 0.12 * max(dot(v, normalize(vec3(-0.4, 0.7, -0.6))), 0.0));
    float key = max(dot(v, normalize(vec3(-0.45, 0.62, -0.64))), 0.0);
    float fill = max(dot(v, normalize(vec3(0.80, 0.05, -0.55))), 0.0);
    float rim = max(dot(v, normalize(vec3(0.10, 0.90, 0.40))), 0.0);
    float open = sky(p, n);
    float light = (0.16 + 0.30 * open) + (0.42 * key + 0.12 * fill + 0.06 * rim) * (0.35 + 0.65 * open);
    float facing = clamp(-v.z, 0.0, 1.0);
    light *= 0.80 + 0.20 * smoothstep(0.0, 0.35, facing);
    vec3 shade = mix(vec3(0.80, 0.86, 1.0), vec3(1.0), smoothstep(0.0, 0.75, light));  // hollows are cool
    return clamp(MATERIAL * shade * pow(light * 1.09, 0.85), 0.0, 1.0);
}

vec4 bytes(uint bits) {
    return vec4(bits & 255u, (bits >> 8) & 255u, (bits >> 16) & 255u, bits >> 24) / 255.0;
}

void main() {
    vec2 at = ((gl_FragCoord.xy + corner) * 2.0 - size) / size.y * zoom;
    vec3 aside = camera[0] * at.x + camera[1] * at.y;
    vec3 from = eye + (1.0 - perspective) * aside;
    vec3 way = normalize(camera[2] + perspective * aside);
    way = mix(way, vec3(1e-9), lessThan(abs(way), vec3(1e-9)));  // nothing is divided by 0
    vec3 a = (box_lo - from) / way;
    vec3 b = (box_hi - from) / way;
    int count = 0;
    float t;
#ifndef GL_ES
    if (want == LIGHT) t = distances[int(gl_FragCoord.y) * across + int(gl_FragCoord.x)];
    else
#endif
    t = meet(from, way, max(most(min(a, b)), 0.0), least(max(a, b)), count);
    if (want == DISTANCE) colour = bytes(floatBitsToUint(t));
    else if (want == STEPS) colour = bytes(uint(count));
    else colour = t < 0.0 ? vec4(0.0) : vec4(lit(from + way * t), 1.0);
}
