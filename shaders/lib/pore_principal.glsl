// Values and directions of the symmetric tensor with these components, by the rotations of
// porelang/ops/principal_loops.py. Not a number where a component is none, or infinite; denormals count as 0.
PorePrincipal pore_principal(float xx, float yy, float zz, float xy, float yz, float xz) {
    float part[6] = float[6](xx, yy, zz, xy, yz, xz);
    float size = 0.0;
    bool bad = false;
    for (int n = 0; n < 6; n++) {
        bad = bad || pore_is_nan(part[n]) || pore_is_nan(pore_nought * part[n]);
        size = abs(part[n]) > size ? abs(part[n]) : size;
    }
    if (bad) {
        float none = pore_nan();
        return PorePrincipal(none, none, none, none, none, none, none, none, none, none, none, none);
    }
    float scale = size >= 1.17549435e-38 ? size : 1.0;
    float a[3] = float[3](xx / scale, yy / scale, zz / scale);
    float b[3] = float[3](yz / scale, xz / scale, xy / scale);  // b[r] is that of the two other axes
    vec3 v[3] = vec3[3](vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    for (int k = 0; k < 6; k++) {
        bool turned = pore_turn(a, b, v, 0, 1, 2);
        turned = pore_turn(a, b, v, 0, 2, 1) || turned;
        turned = pore_turn(a, b, v, 1, 2, 0) || turned;
        if (!turned) break;
    }
    pore_exchange(a, v, 0, 1);
    pore_exchange(a, v, 1, 2);
    pore_exchange(a, v, 0, 1);
    for (int i = 0; i < 2; i++) {
        precise float ahead = (9.0 * v[i].x + 3.0 * v[i].y) + v[i].z;
        if (ahead < 0.0) v[i] = -v[i];
    }
    precise float x = v[0].y * v[1].z - v[0].z * v[1].y;
    precise float y = v[0].z * v[1].x - v[0].x * v[1].z;
    precise float z = v[0].x * v[1].y - v[0].y * v[1].x;
    return PorePrincipal(a[0] * scale, a[1] * scale, a[2] * scale, v[0].x, v[0].y, v[0].z, v[1].x, v[1].y, v[1].z, x, y, z);
}
