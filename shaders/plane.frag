// @version
// A plane through a part, in the colours of a field, with lines of equal value: where the part is solid it hides what is
// behind it, elsewhere that shows through. Its line of zero is the thickest.
out vec4 colour;
uniform vec2 size;      // of the whole picture, in pixels
uniform vec3 eye;       // in mm
uniform mat3 camera;    // right, up, forward
uniform float zoom;     // half the height of the picture: at distance 1, or in mm where rays are parallel
uniform float perspective;  // 1, or 0 for parallel rays
uniform vec3 box_lo;    // what is shown of the part, in mm
uniform vec3 box_hi;
uniform int axis;       // along which the plane is
uniform float offset;   // at so many mm
uniform float farthest; // the depth of a place is its distance in these, in mm
uniform float nearer;   // so many mm: the plane hides the face where the part is cut by it
uniform float every;    // the step from line to line
uniform float clear;    // how much of it shows where the part is not, 0 to 1

const vec3 INK = vec3(0.13, 0.12, 0.12);

// @field

// How much of a pixel a line at 0 covers that is so many pixels wide, from the value and its change from pixel to pixel.
float line(float value, float change, float width) {
    float share = clamp(0.5 * width + 0.5 - abs(value) / change, 0.0, 1.0);
    return change > 0.0 && change < 1e30 ? share : 0.0;
}

void main() {
    vec2 at = (gl_FragCoord.xy * 2.0 - size) / size.y * zoom;
    vec3 aside = camera[0] * at.x + camera[1] * at.y;
    vec3 from = eye + (1.0 - perspective) * aside;
    vec3 way = normalize(camera[2] + perspective * aside);
    float slant = way[axis];
    float t = (offset - from[axis]) / (abs(slant) < 1e-9 ? 1e-9 : slant);
    vec3 p = from + way * t;
    p[axis] = offset;
    float f[2];
    fields(p, f);  // shown, and the part
    // of all pixels, those beside the plane too: a derivative asks for its neighbours
    float change = length(vec2(dFdx(f[0]), dFdy(f[0])));
    vec3 inside = step(box_lo, p) * step(p, box_hi);
    inside[axis] = 1.0;
    if (t <= 0.0 || inside.x * inside.y * inside.z == 0.0) discard;
    float place = f[0] / every;
    float thin = line(place - round(place), change / every, 1.0) * clamp(2.0 - 6.0 * change / every, 0.0, 1.0);
    float zero = line(f[0], change, 2.2);
    vec3 shade = mix(scale_colour(f[0]), INK, max(0.55 * thin, zero));
    float covers = f[1] <= 0.0 ? 1.0 : clear;
    colour = vec4(shade * covers, covers);
    gl_FragDepth = clamp((t - nearer) / farthest, 0.0, 1.0);
}
