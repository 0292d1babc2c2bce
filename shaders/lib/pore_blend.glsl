// The cubic through four nodes in a row, with the weights of pore_catmull; a derivative where `order` is not 0.
float pore_blend(vec4 p, vec3 w, int order) {
    precise float a = (p.x - p.y) * w.x;
    precise float b = (p.z - p.y) * w.y;
    precise float c = (p.w - p.y) * w.z;
    precise float sum = (a + b) + c;
    precise float y = (order == 0 ? p.y : 0.0) + sum;
    return y;
}
