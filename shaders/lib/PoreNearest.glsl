// What one walk to the nearest bar finds (porelang/ops/segments.py).
struct PoreNearest {
    float distance;
    float nx;
    float ny;
    float nz;
    float dx;
    float dy;
    float dz;
    float along;
    float radius;
    float length;
    float index;
};
