// x radians in turns, less whole turns: x / tau in two floats, within about -1/2..1/2.
// Error: 3e-8 turns + |x| 2^-50.
float pore_turns(float x) {
    float h = pore_high(x);
    precise float l = x - h;
    precise float u = x * 0.159154937;
    // 0.159118652 is the upper half of 0.159154937; the last term is what 1 / tau has beyond it
    precise float rest = (((h * 0.159118652 - u) + h * 3.6284327507e-5) + l * 0.159118652) + l * 3.6284327507e-5;
    precise float low = rest + x * 6.42063824e-9;
    precise float r = (u - roundEven(u)) + (low - roundEven(low));
    return r;
}
