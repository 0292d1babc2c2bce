// The square of the least distance along an axis of sites at an offset: they are within `reach` of their middles.
float pore_gap(int offset, float place, float reach) {
    float gap = max(abs(float(offset) + 0.5 - place) - reach, 0.0);
    return gap * gap;
}
