// The nearest of random sites (porelang/ops/sites.py).
struct PoreSites {
    float f1;
    float f2;
    float f3;
    float wall;
    float x1;
    float y1;
    float z1;
    float x2;
    float y2;
    float z2;
    float x3;
    float y3;
    float z3;
    float xw;
    float yw;
    float zw;
    float number;
};
