// From values to colours: for pictures alone, and no part of what is checked between the backends.
uniform vec3 scale_colours[9];  // evenly from its least value to its middle, and from there to its greatest
uniform vec3 scale_ends;        // least, middle, greatest

// The colour of a value on a scale; grey of what is no number.
vec3 scale_colour(float value) {
    if (!(abs(value) < 3e38)) return vec3(0.6);
    float low = scale_ends.x, middle = scale_ends.y, high = scale_ends.z;
    float place = value < middle ? 0.5 * (value - low) / (middle - low) : 0.5 + 0.5 * (value - middle) / (high - middle);
    place = clamp(place, 0.0, 1.0) * 8.0;
    int below = min(int(place), 7);
    return mix(scale_colours[below], scale_colours[below + 1], place - float(below));
}
