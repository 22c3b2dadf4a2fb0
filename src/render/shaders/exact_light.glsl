// The light that a sampler's texel means, where the sampler decodes sRGB as it is.
vec3 exactLight(vec3 light) { return light; }
