// Where a point lies in a sampled field: the lower node of its cell, the part of the cell on each axis, whether a
// coordinate is not a number, and whether the derivative that is asked for is 0 there.
struct PoreCell {
    int i;
    int j;
    int k;
    float f;
    float g;
    float h;
    bool bad;
    bool outside;
};
