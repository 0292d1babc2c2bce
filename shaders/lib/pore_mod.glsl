// a - b floor(a / b): the remainder with the sign of b. Error: that of a float32 evaluation of this formula, every
// step of which is rounded correctly; where b is 0 or either is infinite, NaN.
float pore_mod(float a, float b) {
    precise float whole = b * pore_floor(pore_div(a, b));
    precise float y = a - whole;
    return y;
}
