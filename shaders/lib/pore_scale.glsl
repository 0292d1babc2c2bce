// x 2^n for n in -252..254 and finite x, rounded once: in two steps, since 2^n alone may not be a float.
float pore_scale(float x, int n) {
    int half_n = n >> 1;
    precise float first = x * uintBitsToFloat(uint(half_n + 127) << 23);
    precise float y = first * uintBitsToFloat(uint(n - half_n + 127) << 23);
    return y;
}
