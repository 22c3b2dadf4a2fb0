// Vectors carry their frame: _tile is metres from the mesh's origin, _rte metres relative to the eye, both in body axes;
// _view has x right, y up, z backwards.

layout(location = 0) in vec3 position_tile;
layout(location = 1) in vec3 up_body;
layout(location = 2) in float placeS;  // tile-local, 0..32768
// A value a tile (divisor 1):
layout(location = 3) in vec3 originCoarse_rte;
layout(location = 4) in vec4 originFine_rte;  // w: parentStep_m
layout(location = 5) in vec4 colourWindow;  // offset, scale
layout(location = 6) in vec4 reliefWindow;
layout(location = 7) in vec4 plain;  // linear colour where there is no texture, share of the texture
layout(location = 8) in ivec4 layers;  // colour or first picture, relief (its layer or its number), pictures or (second | third << 16), bits of two halves: their strengths
// A value a vertex again: what position_tile lost in single precision, in steps of the vertex grid.
layout(location = 9) in vec3 fine_tile;
layout(location = 10) in float placeT;
layout(location = 11) in vec4 toParent;  // to the parent's surface, body axes; w: the difference in height; in steps
layout(location = 12) in float height_m;
// A value a tile:
layout(location = 13) in vec4 morph;  // at (s, t) = (0, 0), (1, 0), (0, 1), (1, 1): 0 the parent's surface, 1 its own
#ifdef SECOND
layout(location = 15) in vec4 secondWindow;
out vec2 secondPlace;
#endif
#ifdef THIRD
layout(location = 14) in vec4 thirdWindow;
out vec2 thirdPlace;
#endif

#ifdef MIRROR
out vec3 place_rte;
#endif

#ifdef AIR
out vec4 place_air;  // relative to the eye; w: height above the ellipsoid
#endif

out vec4 textureCoordinates;  // colour, relief
out vec3 upInterpolated_body;
flat out vec4 plainColour;
flat out ivec4 textureLayers;

// Neighbours may be drawn by programs that differ in what they do with the rest.
invariant gl_Position;

// How much of the way to its parent's surface is left at a vertex.
float wayBack(vec2 place) {
  precise float above = morph.x * (1.0 - place.x) + morph.y * place.x;
  precise float below = morph.z * (1.0 - place.x) + morph.w * place.x;
  precise float back = 1.0 - (above * (1.0 - place.y) + below * place.y);
  return back;
}

// A vertex, moved by a multiple of the vertex grid, relative to the snapped eye: correctly rounded to float whatever the
// tile's origin is, so that two tiles that share a vertex draw it at the same place to the last bit, one level apart
// too, where the finer one lies wholly on its parent's surface. The origin comes in two floats whose sum is exact;
// Knuth's two-sum keeps what an addition loses; the small parts are multiples of the vertex grid and add up exactly.
// `precise` keeps the compiler from "simplifying" that to zero.
vec3 rteFromTile(vec3 moved) {
  precise vec3 sum = position_tile + originCoarse_rte;
  precise vec3 part = sum - position_tile;
  precise vec3 lost = (position_tile - (sum - part)) + (originCoarse_rte - part);
  precise vec3 sumMoved = sum + moved;
  precise vec3 partMoved = sumMoved - sum;
  precise vec3 lostMoved = (sum - (sumMoved - partMoved)) + (moved - partMoved);
  precise vec3 rte = sumMoved + ((lost + lostMoved) + (originFine_rte.xyz + fine_tile * eyeRemainder.w));
  return rte;
}

// Morphing and exaggeration are the same in all tiles of a level that share the vertex, to the last bit: on an edge the
// weights of the two far corners are exactly zero, and turning an edge round exchanges two summands.
void main() {
  vec2 place = vec2(placeS, placeT) * (1.0 / 32768.0);
  precise vec4 change = toParent * originFine_rte.w * wayBack(place);
  precise vec3 moved = round(change.xyz / eyeRemainder.w) * eyeRemainder.w;
  precise vec3 position_rte =
      (rteFromTile(moved) - eyeRemainder.xyz) + up_body * ((height_m + change.w) * switches.y);
  vec3 position_view = mat3(viewFromBody) * position_rte;
  // Reverse z with the far plane at infinity: depth is near / distance, 1 at the near plane, 0 at infinity.
  gl_Position = vec4(onPicture(position_view), projection.z, -position_view.z);
  textureCoordinates = vec4(colourWindow.xy + colourWindow.zw * place, reliefWindow.xy + reliefWindow.zw * place);
  upInterpolated_body = up_body;
  plainColour = plain;
  textureLayers = layers;
#ifdef AIR
  place_air = vec4(airView.scale.xyz * position_rte, height_m + change.w);
#endif
#ifdef SECOND
  secondPlace = secondWindow.xy + secondWindow.zw * place;
#endif
#ifdef THIRD
  thirdPlace = thirdWindow.xy + thirdWindow.zw * place;
#endif
#ifdef MIRROR
  place_rte = position_rte;
#endif
}
