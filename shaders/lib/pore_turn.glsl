// The axes p and q of a tensor turned so that the component between them is 0, and the directions with them; r is the
// third axis. `a` are the components on the diagonal, b[r] the one between the two axes that are not r.
bool pore_turn(inout float a[3], inout float b[3], inout vec3 v[3], int p, int q, int r) {
    precise float g = b[r] + b[r];
    if (!(abs(g) > 1.4210855e-14)) return false;
    precise float h = a[q] - a[p];
    precise float root = pore_sqrt(h * h + g * g);
    precise float t = h >= 0.0 ? g / (h + root) : g / (h - root);
    precise float c = 1.0 / pore_sqrt(t * t + 1.0);
    precise float s = t * c;
    precise float shift = t * b[r];
    precise float low = a[p] - shift;
    precise float high = a[q] + shift;
    precise float rp = c * b[q] - s * b[p];
    precise float rq = s * b[q] + c * b[p];
    precise vec3 vp = c * v[p] - s * v[q];
    precise vec3 vq = s * v[p] + c * v[q];
    a[p] = low;
    a[q] = high;
    b[r] = 0.0;
    b[q] = rp;
    b[p] = rq;
    v[p] = vp;
    v[q] = vq;
    return true;
}
