in vec3 light;
in vec2 fromStar;
layout(location = 0) out vec4 colour;

void main() {
  colour = vec4(light * exp(-0.5 * dot(fromStar, fromStar)), 0.0);
}
