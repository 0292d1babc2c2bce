// How far the sites of cells at an offset are from a place in its cell at least, along each axis, squared.
vec3 pore_gap(vec3 offset, vec3 place, float half_) {
    vec3 gap = max(abs(offset + 0.5 - place) - half_, vec3(0.0));
    return gap * gap;
}
