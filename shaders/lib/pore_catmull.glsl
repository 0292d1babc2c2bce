// What the nodes i-1, i+1 and i+2 of n add to the node i, each times its difference from it, at the part f of a cell:
// Catmull-Rom and its derivatives. A node beyond the border continues the line of the last two: its weight joins theirs.
vec3 pore_catmull(float f, int i, int n, int order) {
    precise float a = -3.0;
    precise float b = -9.0;
    precise float c = 3.0;
    if (order == 0) {
        a = f * (f * (1.0 - 0.5 * f) - 0.5);
        b = f * (f * (2.0 - 1.5 * f) + 0.5);
        c = f * f * (0.5 * f - 0.5);
    } else if (order == 1) {
        a = f * (2.0 - 1.5 * f) - 0.5;
        b = f * (4.0 - 4.5 * f) + 0.5;
        c = f * (1.5 * f - 1.0);
    } else if (order == 2) {
        a = 2.0 - 3.0 * f;
        b = 4.0 - 9.0 * f;
        c = 3.0 * f - 1.0;
    }
    if (i == 0) {
        b = b - a;
        a = 0.0;
    }
    if (i == n - 2) {
        b = b + 2.0 * c;
        c = 0.0;
    }
    return vec3(a, b, c);
}
