// The length of a vector, each step rounded as NumPy rounds it.
float pore_length(vec3 q) {
    precise float square = (q.x * q.x + q.y * q.y) + q.z * q.z;
    return pore_sqrt(square);
}
