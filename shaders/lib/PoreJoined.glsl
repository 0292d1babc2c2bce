// What is known of bars that are joined smoothly (porelang/ops/joints.py).
struct PoreJoined {
    float distance;
    float nx;
    float ny;
    float nz;
    float dk;
    float hxx;
    float hxy;
    float hxz;
    float hyy;
    float hyz;
    float hzz;
    float gx;
    float gy;
    float gz;
    float kk;
};
