// The arc cosine; NaN outside -1..1. Error: 1.1 ulp.
// Above 1/2 by acos(x) = 2 asin(sqrt((1 - x) / 2)), below -1/2 by its mirror image.
float pore_acos(float x) {
    float a = abs(x);
    precise float z = a * a;
    precise float w = x;
    if (a > 0.5) {
        z = 0.5 * (1.0 - a);
        w = pore_sqrt(z);
    }
    precise float y = pore_arc(w, z);
    precise float middle = 1.57079637 - (y + 4.37113883e-8);
    precise float right = 2.0 * y;
    precise float left = 3.14159274 - (right + 8.74227766e-8);
    float angle = a > 0.5 ? (x > 0.0 ? right : left) : middle;
    return (floatBitsToUint(x) & 0x7fffffffu) > 0x3f800000u ? pore_nan() : angle;
}
