// The axis of the larger value first; of equal ones nothing is exchanged.
void pore_exchange(inout float a[3], inout vec3 v[3], int p, int q) {
    if (a[p] < a[q]) {
        float value = a[p];
        vec3 direction = v[p];
        a[p] = a[q];
        v[p] = v[q];
        a[q] = value;
        v[q] = direction;
    }
}
