// A coordinate moved by whole periods to within half a period of 0, as porelang/ops/segment_copies.py does; what is
// infinite stays so, and what is no number.
float pore_folded(float x, float period, float inverse) {
    precise float u = x * inverse;
    precise float turns = pore_round(u);
    precise float moved = x - turns * period;
    return pore_is_nan(moved) ? x : moved;
}
