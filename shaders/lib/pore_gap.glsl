// The square of the least distance along an axis of sites at an offset: they are within `reach` of their middles.
float pore_gap(int offset, float place, float reach) {
    precise float gap = abs((float(offset) + 0.5) - place) - reach;
    precise float square = gap > 0.0 ? gap * gap : 0.0;
    return square;
}
