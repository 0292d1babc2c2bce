// The vector from the nearest place on the axis between two ends to p, and where along the axis that place is (0..1).
// `inverse` is 1 / length^2. Beyond an end the vector is measured from that end, so that bars that meet there tie.
vec4 pore_foot(vec3 start, vec3 end, float inverse, vec3 p) {
    precise float ex = end.x - start.x;
    precise float ey = end.y - start.y;
    precise float ez = end.z - start.z;
    precise float wx = p.x - start.x;
    precise float wy = p.y - start.y;
    precise float wz = p.z - start.z;
    precise float t = ((wx * ex + wy * ey) + wz * ez) * inverse;
    precise float qx = wx - ex * t;
    precise float qy = wy - ey * t;
    precise float qz = wz - ez * t;
    precise vec3 beyond = p - end;
    if (t >= 1.0) return vec4(beyond, 1.0);
    return t > 0.0 ? vec4(qx, qy, qz, t) : vec4(wx, wy, wz, 0.0);
}
