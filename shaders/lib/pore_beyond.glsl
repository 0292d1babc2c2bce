// How far a coordinate lies outside of a range, by how far it is before it and after it (either below 0 inside).
float pore_beyond(float before, float after) {
    float most = before > after ? before : after;
    return most > 0.0 ? most : 0.0;
}
