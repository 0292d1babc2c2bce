// u turns in radians, less whole turns, which are taken off before the multiplication by tau: exactly.
float pore_reduced(float u) {
    precise float r = (u - roundEven(u)) * 6.2831855;
    return r;
}
