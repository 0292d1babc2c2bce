// The principal values of a symmetric tensor, the largest first, and their directions (porelang/ops/principal.py).
struct PorePrincipal {
    float v1;
    float v2;
    float v3;
    float x1;
    float y1;
    float z1;
    float x2;
    float y2;
    float z2;
    float x3;
    float y3;
    float z3;
};
