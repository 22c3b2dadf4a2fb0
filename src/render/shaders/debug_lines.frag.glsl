flat in vec4 lineColour;

layout(location = 0) out vec4 colour;

void main() { colour = lineColour; }
