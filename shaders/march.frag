// @version
// A picture of the solid by sphere tracing: from the eye through each pixel, in steps that no surface can lie within.
//
// The box is divided into cells. For each the host has proved one of four things, told apart by one number: 0, no solid
// lies in it, and it is passed as a whole; -1, it is solid throughout; a slope, by which the field changes at most per mm,
// so that the field divided by it is a safe step; or more than STEEP where the field may jump, and small steps are taken.
// Where corners are cut out of the part, NOTCHED is defined: most pictures need not look for them. Where the surface has
// the colours of another field, PAINTED is.
const int NOTCHES = 8;
out vec4 colour;
uniform int want;       // LIGHT, GLASS, DISTANCE or STEPS
uniform float side;     // 1 looks for solid, -1 for the void behind it
uniform float layer;    // 0 looks from the eye on, 1 from the distances that are handed over
uniform vec2 size;      // of the whole picture, in pixels
uniform vec2 corner;    // of this tile, from the bottom left, in pixels
uniform int samples;    // pixels along a side that are averaged to one in the end
uniform vec3 eye;       // in mm
uniform mat3 camera;    // right, up, forward
uniform float zoom;     // half the height of the picture: at distance 1, or in mm where rays are parallel
uniform float perspective;  // 1, or 0 for parallel rays
uniform vec3 box_lo;    // what is shown of the part, in mm
uniform vec3 box_hi;
uniform vec3 cells_lo;  // what is divided into cells, in mm: all of that, or more
uniform vec3 cells_hi;
uniform vec3 cut_lo;    // 1 where that face of the box cuts the part
uniform vec3 cut_hi;
uniform int notches;    // boxes that are taken out, and their corners
uniform vec3 notch_lo[NOTCHES];
uniform vec3 notch_hi[NOTCHES];
uniform ivec3 counts;   // of cells along each axis
uniform float finest;   // no step is shorter, in mm
uniform float rounding; // how far float32 may misplace a point, in mm
uniform float nearest;  // nor than this, once a ray has taken MANY_STEPS
uniform float jump;     // the step where the field may jump, in mm
uniform float reach;    // how far around a place light is looked for, in mm
uniform float grain;    // the distance over which a normal is measured, in mm
uniform vec3 material;  // red, green and blue in the light, 0 to 1; 1 draws the light alone
uniform vec3 section;   // the same of faces where the part is cut

const int LIGHT = 0;
const int DISTANCE = 1;
const int STEPS = 2;
const int GLASS = 3;
const int MANY_STEPS = 512;     // a ray that takes more grazes the surface
const int MOST_STEPS = 65536;   // a ray of the longest box takes fewer
const float STEEP = 1e29;
const int RINGS = 10;
const vec3 LAMP = vec3(-0.451, 0.621, -0.641);  // in the viewer's axes

#ifdef GL_ES
uniform float farthest; // the depth of a place is its distance in these, in mm
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

// Where a ray enters and leaves a box; the first is larger where it does not meet it.
vec2 span(vec3 from, vec3 way, vec3 lo, vec3 hi) {
    vec3 a = (lo - from) / way;
    vec3 b = (hi - from) / way;
    return vec2(most(min(a, b)), least(max(a, b)));
}

#ifdef NOTCHED
bool taken_out(vec3 p) {
    for (int i = 0; i < notches; i++)
        if (least(min(p - notch_lo[i], notch_hi[i] - p)) > 0.0) return true;
    return false;
}

// The next notch on a ray from t on, from where it is entered to where it is left.
vec2 next_notch(vec3 from, vec3 way, float t) {
    vec2 next = vec2(1e30);
    for (int i = 0; i < notches; i++) {
        vec2 s = span(from, way, notch_lo[i], notch_hi[i]);
        if (s.x < s.y && t < s.y && s.x < next.x) next = s;
    }
    return next;
}
#endif

// The distance at which a ray, between `start` and `end`, comes from the one `side` of the surface to the other, or -1.
// No step is shorter than `fine`; `count` is the number of samples taken.
//
// From a sample f the surface is at least f / slope away. Two samples with f + g > slope * h have none between them if
// they are h apart: where the field falls more gently than its bound, a bold step twice as long is tried, looked at from
// its far end, and taken back if that does not prove it (Keinert et al. 2014).
float meet(vec3 from, vec3 way, float start, float end, float fine, out int count) {
    vec3 edge = (cells_hi - cells_lo) / vec3(counts);
    vec3 ahead = step(vec3(0.0), way);
    float t = start;
    float before = start;
    float f_before = -1.0;  // or the field there
    bool bold = false;
    bool met = false;
    count = 0;
#ifdef NOTCHED
    vec2 gap = next_notch(from, way, t);
#endif
    for (int i = 0; i < MOST_STEPS && t <= end; i++) {
#ifdef NOTCHED
        if (t >= gap.x && !bold) {
            if (t < gap.y) {
                if (side < 0.0) return max(gap.x, before);
                before = t = gap.y;
                f_before = -1.0;
            }
            gap = next_notch(from, way, t);
            continue;
        }
#endif
        vec3 p = from + way * t;
        ivec3 at = clamp(ivec3(floor((p - cells_lo) / edge)), ivec3(0), counts - 1);
        float slope = cell(at);
        float leave = max(least((cells_lo + (vec3(at) + ahead) * edge - from) / way), t) + fine;
        float onward = leave;
        float f = -1.0;
        bool bolder = false;
        if (slope > 0.0 || (side > 0.0 ? slope < 0.0 : slope == 0.0)) {
            float shortest = i < MANY_STEPS ? fine : max(fine, nearest);
            if (slope > 0.0) {
                f = side * field(p);
                count++;
                if (bold && !(f + f_before > slope * (t - before + rounding))) {
                    t = before + max(f_before / slope, shortest);
                    bold = false;
                    continue;
                }
            }
            met = f <= 0.0;
            if (met) break;  // and what follows is done by neighbours together
            float safe = slope < STEEP ? max(f / slope, shortest) : jump;
            if (f_before > 0.0 && slope < STEEP) {
                float falls = clamp((f_before - f) / (t - before), -0.5 * slope, slope);
                float far = min(1.95 * f / (slope + falls), leave - t - 1.1 * fine);  // it ends in the same cell
                bolder = far > 1.05 * safe;
                if (bolder) safe = far;
            }
            onward = min(leave, t + safe);
        }
        before = t;
        f_before = f;
        bold = bolder;
        t = onward;
    }
    if (!met) return -1.0;
    for (int j = 0; j < 32 && t - before > 0.25 * fine; j++) {
        float middle = 0.5 * (before + t);
        if (side * field(from + way * middle) <= 0.0) t = middle;
        else before = middle;
        count++;
    }
    return t;
}

// Outward, from differences of the field. In a loop and called in one place, as compilers make a copy of the field for
// each place that asks for it: with 17 of them the field of a study with phases took minutes to compile.
vec3 normal(vec3 p) {
    vec3 n = vec3(0.0);
    for (int i = 0; i < 6; i++) {
        int axis = i / 2;
        float sign_ = i % 2 == 0 ? 1.0 : -1.0;
        vec3 q = p;
        q[axis] += sign_ * grain;
        n[axis] += sign_ * field(q);
    }
    float length_ = max(abs(n.x), max(abs(n.y), abs(n.z)));
    return length_ > 0.0 && length_ < 1e30 ? normalize(n / length_) : -camera[2];
}

// The face of the box or of a notch that a place lies on, as an outward normal, if the part is cut there; else 0.
vec3 cut(vec3 p) {
    vec3 near = vec3(nearest);
    vec3 n = cut_hi * step(box_hi - p, near) - cut_lo * step(p - box_lo, near);
#ifdef NOTCHED
    for (int i = 0; i < notches && n == vec3(0.0); i++) {
        if (least(min(p - notch_lo[i], notch_hi[i] - p)) > -nearest)
            n = step(abs(p - notch_lo[i]), near) - step(abs(p - notch_hi[i]), near);
    }
#endif
    return n.x != 0.0 ? vec3(n.x, 0.0, 0.0) : n.y != 0.0 ? vec3(0.0, n.y, 0.0) : vec3(0.0, 0.0, n.z);
}

// A number from 0 to 1 for each sample of a pixel: what differs by it averages out, and no grain is seen.
float turn_of_sample() {
    ivec2 pixel = ivec2(gl_FragCoord.xy + corner) % samples;
    return float(pixel.x + samples * pixel.y) / float(samples * samples);
}

// How much of the sky above a surface is not hidden by solid within `reach`: 0 to 1.
float sky(vec3 p, vec3 n, float turn) {
    vec3 a = normalize(abs(n.z) < 0.9 ? cross(n, vec3(0.0, 0.0, 1.0)) : cross(n, vec3(1.0, 0.0, 0.0)));
    vec3 b = cross(n, a);
    int directions = samples < 3 ? 8 : 5;  // samples of a pixel look in different ones
    float hidden = 0.0;
    for (int i = 0; i < directions; i++) {
        float r2 = (float(i) + 0.5 * (turn + 0.5)) / float(directions);
        float angle = 2.3999632 * (float(i) + turn * float(directions));
        vec3 d = sqrt(r2) * (cos(angle) * a + sin(angle) * b) + sqrt(1.0 - r2) * n;
        for (int k = 0; k < RINGS; k++) {
            float far = (float(k) + 0.4 + 0.6 * turn) / float(RINGS);
            vec3 q = p + n * grain + d * (reach * far * far);
            if (most(max(box_lo - q, q - box_hi)) > 0.0) break;
#ifdef NOTCHED
            if (taken_out(q)) continue;
#endif
            if (solid(q)) {
                hidden += 1.0 - 0.8 * far * far;
                break;
            }
        }
    }
    return 1.0 - hidden / float(directions);
}

// Whether nothing solid lies between a place and the lamp; that is a disc, which a sample sees a part of.
float lamp(vec3 p, vec3 n, vec3 way, float turn) {
    float angle = 2.3999632 * 9.0 * turn;
    way = normalize(way + 0.06 * sqrt(turn) * (cos(angle) * camera[0] + sin(angle) * camera[1]));
    way = mix(way, vec3(1e-9), lessThan(abs(way), vec3(1e-9)));
    vec3 from = p + n * (2.0 * grain);
    int count;
    return meet(from, way, 0.0, span(from, way, box_lo, box_hi).y, grain, count) < 0.0 ? 1.0 : 0.0;
}

#ifdef PAINTED
const float AMBIENT = 0.35;  // of a colour is seen in the darkest shade: colours are to be read, not only seen

// The colour of the field at a place, in the light that falls on white.
vec3 tinted(vec3 p, vec3 light) {
    return (AMBIENT + (1.0 - AMBIENT) * light) * scale_colour(paint(p));
}
#else
vec3 tinted(vec3 p, vec3 light) { return light; }
#endif

// A place in the light, with its outward normal; or on a face where the part is `sawn`.
vec3 lit(vec3 p, vec3 n, bool sawn) {
    vec3 v = n * camera;  // in the viewer's axes: right, up, forward
    if (sawn) return tinted(p, section) * (0.90 + 0.20 * max(dot(v, normalize(vec3(-0.2, 0.9, -0.4))), 0.0));
    float turn = turn_of_sample();
    float open = sky(p, n, turn);
    float key = max(dot(v, LAMP), 0.0);
    if (key > 0.0) key *= 0.35 + 0.65 * lamp(p, n, camera * LAMP, turn);
    float fill = max(dot(v, normalize(vec3(0.80, 0.05, -0.55))), 0.0);
    float rim = max(dot(v, normalize(vec3(0.10, 0.90, 0.40))), 0.0);
    float light = (0.08 + 0.38 * open) + 0.46 * key + (0.12 * fill + 0.08 * rim) * (0.35 + 0.65 * open);
    float facing = clamp(-v.z, 0.0, 1.0);
    light *= 0.80 + 0.20 * smoothstep(0.0, 0.35, facing);
    vec3 shade = mix(vec3(0.80, 0.86, 1.0), vec3(1.0), smoothstep(0.0, 0.75, light));  // hollows are cool
    return tinted(p, clamp(material * shade * pow(light * 1.10, 0.80), 0.0, 1.0));
}

// The surface alone, in clear glass, from either side: how light it is, and how much it hides. Cut faces are not there.
vec4 glass(vec3 n, bool sawn, vec3 way) {
    if (sawn) return vec4(0.0);
    vec3 v = (dot(n, way) > 0.0 ? -n : n) * camera;
    float edge = 1.0 - abs(dot(n, way));
    return vec4(vec3(0.42 + 0.38 * max(dot(v, LAMP), 0.0)), 0.20 + 0.55 * edge * edge * edge);
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
    vec2 whole = span(from, way, box_lo, box_hi);
    float start = max(whole.x, 0.0);
    int count = 0;
    float t = -1.0;
    float known = -1.0;
#ifndef GL_ES
    bool lighting = want == LIGHT || want == GLASS;
    if (lighting || layer > 0.0) known = distances[int(gl_FragCoord.y) * across + int(gl_FragCoord.x)];
    if (lighting) t = known;
    else if (layer == 0.0 || known >= 0.0)
#endif
    t = meet(from, way, layer == 0.0 ? start : known + finest, whole.y, finest, count);
    if (want == DISTANCE) colour = bytes(floatBitsToUint(t));
    else if (want == STEPS) colour = bytes(uint(count));
#ifdef GL_ES
    else if (t < 0.0) discard;
#else
    else if (t < 0.0) colour = vec4(0.0);
#endif
    else {
        vec3 p = from + way * t;
        vec3 n = cut(p);
        bool sawn = n != vec3(0.0);
        if (!sawn) n = normal(p);
        colour = want == GLASS ? glass(n, sawn, way) : vec4(lit(p, n, sawn), 1.0);
    }
#ifdef GL_ES
    gl_FragDepth = clamp(t / farthest, 0.0, 1.0);
#endif
}
