// @version
// A picture of the solid by sphere tracing: from the eye through each pixel, in steps that no surface can lie within.
// The step is the field divided by a bound on its slope, so that nothing is stepped over.
out vec4 colour;
uniform vec2 size;      // of the picture, in pixels
uniform vec3 eye;       // in mm
uniform mat3 camera;    // right, up, forward
uniform float zoom;     // half the height of the picture at distance 1
uniform vec3 box_lo;    // the part's bounds, in mm
uniform vec3 box_hi;
uniform float slope;    // a Lipschitz bound of the field within the box
uniform float nearest;  // the distance at which a ray has arrived, in mm

// @field

float clipped(vec3 p) {
    vec3 d = max(box_lo - p, p - box_hi);
    return max(field(p) / slope, max(d.x, max(d.y, d.z)));
}

vec3 normal(vec3 p) {
    vec2 e = vec2(nearest, -nearest);
    return normalize(e.xyy * clipped(p + e.xyy) + e.yyx * clipped(p + e.yyx) + e.yxy * clipped(p + e.yxy)
                     + e.xxx * clipped(p + e.xxx));
}

void main() {
    vec2 at = (gl_FragCoord.xy * 2.0 - size) / size.y * zoom;
    vec3 way = normalize(camera * vec3(at, 1.0));
    vec3 inverse = 1.0 / way;
    vec3 a = (box_lo - nearest - eye) * inverse;
    vec3 b = (box_hi + nearest - eye) * inverse;
    vec3 low = min(a, b);
    vec3 high = max(a, b);
    float t = max(max(low.x, max(low.y, low.z)), 0.0);
    float last = min(high.x, min(high.y, high.z));
    for (int i = 0; i < 4096 && t < last; i++) {
        float d = clipped(eye + way * t);
        if (d < nearest) {
            vec3 n = normal(eye + way * t);
            float light = 0.35 + 0.65 * max(dot(n, normalize(vec3(0.4, -0.5, 0.75))), 0.0);
            colour = vec4(vec3(0.93, 0.90, 0.84) * light, 1.0);
            return;
        }
        t += d;
    }
    colour = vec4(0.0);
}
