// The offsets 0, -1, 1, -2, 2, ... of cells along an axis, near ones first.
int pore_near(int k) {
    return (k & 1) == 1 ? -(k + 1) / 2 : k / 2;
}
