// Four random numbers of a place (porelang/ops/random.py).
struct PoreRandom {
    float x;
    float y;
    float z;
    float w;
};
