// a^b as C and NumPy have it: a negative base gives a sign with an integer exponent and NaN with any other;
// x^0 = 1^y = 1 even for NaN; 0^negative = inf. Error: 1.2 ulp + |b log2 a| / 24 ulp. Denormals count as 0.
// log2 |a| = e + log2(m) with log2(m) = (2 / ln 2) atanh(s), s = (m - 1) / (m + 1), all in two floats (products after
// Dekker 1971); atanh(s) = s + s^3 P(s^2), P of degree 3 (relative error 2.5e-11), and 2^f = 1 + f Q(f), Q of degree 5
// (3.0e-9), both minimax by linear programming in float64.
float pore_pow(float a, float b) {
    uint i = floatBitsToUint(a);
    uint sign_bit = i & 0x80000000u;
    i &= 0x7fffffffu;
    uint j = floatBitsToUint(b) & 0x7fffffffu;

    // s and its remainder
    uint shifted = i + (0x3f800000u - 0x3f3504f3u);
    float e = float(int(shifted >> 23) - 127);
    float m = uintBitsToFloat((shifted & 0x007fffffu) + 0x3f3504f3u);
    precise float f = m - 1.0;
    precise float d = m + 1.0;
    precise float d_rest = m - (d - 1.0);
    precise float s = f / d;
    float sh = pore_high(s);
    float dh = pore_high(d);
    precise float sl = s - sh;
    precise float dl = d - dh;
    precise float f_rest = ((((f - sh * dh) - sh * dl) - sl * dh) - sl * dl) - s * d_rest;
    precise float s_rest = f_rest / d;

    // log2 |a| = hi + lo; 2.88476562 is the upper half of 2.88539004, 2 / ln 2 is this and 3.85192607e-8
    precise float z = s * s;
    precise float p = ((0.121389188 * z + 0.142494068) * z + 0.200004861) * z + 0.333333313;
    precise float head = s * 2.88539004;
    precise float tail = (((sh * 2.88476562 - head) + sh * 6.24418259e-4) + sl * 2.88476562) + sl * 6.24418259e-4;
    precise float more = tail + (s * 3.85192607e-8 + 2.88539004 * (s_rest + s * z * p));
    precise float sum = e + head;
    precise float sum_rest = ((e - sum) + head) + more;
    precise float hi = sum + sum_rest;
    precise float lo = (sum - hi) + sum_rest;

    // b log2 |a| = y + y_rest; no base but 1 survives an exponent beyond 2^33
    float c = b > 8589934592.0 ? 8589934592.0 : (b < -8589934592.0 ? -8589934592.0 : b);
    float ch = pore_high(c);
    float hh = pore_high(hi);
    precise float cl = c - ch;
    precise float hl = hi - hh;
    precise float y = c * hi;
    precise float y_rest = ((((ch * hh - y) + ch * hl) + cl * hh) + cl * hl) + c * lo;
    if (abs(y) >= 200.0) {
        y = y > 0.0 ? 200.0 : -200.0;
        y_rest = 0.0;
    }
    float k = roundEven(y);
    precise float g = (y - k) + y_rest;
    precise float t = ((1.53264977e-4 * g + 1.33908121e-3) * g + 9.61850584e-3) * g + 5.55035993e-2;
    precise float q = (t * g + 0.240226477) * g + 0.693147182;
    precise float power = 1.0 + g * q;
    uint result = floatBitsToUint(pore_scale(power, int(k)));

    bool whole = floor(b) == b;
    precise float half_b = 0.5 * b;
    bool odd = whole && floor(half_b) != half_b;
    bool negative = floatBitsToUint(b) > 0x7fffffffu;
    if (i < 0x00800000u) result = negative ? 0x7f800000u : 0u;
    if (i == 0x7f800000u) result = negative ? 0u : 0x7f800000u;
    if (sign_bit != 0u && !whole && i >= 0x00800000u && i < 0x7f800000u) result = 0x7fc00000u;
    if (odd) result |= sign_bit;
    if (i > 0x7f800000u || j > 0x7f800000u) result = 0x7fc00000u;
    if (j < 0x00800000u || (i == 0x3f800000u && sign_bit == 0u)) result = 0x3f800000u;
    return uintBitsToFloat(result);
}
