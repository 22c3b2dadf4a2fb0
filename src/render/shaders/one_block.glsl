// Where a draw call reads one block of reliefs, the place of a relief is its layer.
layout(binding = 3) uniform sampler2DArray reliefs;

vec3 reliefTexel(int layer, vec2 place) { return texture(reliefs, vec3(place, float(layer))).xyz; }
