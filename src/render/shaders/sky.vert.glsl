// The sky, as far as there is air: a dome of bands from a little below the horizon up to the zenith, or from above the
// air to where that ends. Infinitely far: it shows where nothing else was drawn. Bands lie as the table's rows, and light
// is looked up at their corners, for it changes slowly; rows that would be less than half a pixel apart are left out, and what
// the picture does not show (air_pass.cpp). One instance a band, a strip of triangles each; the last instance is the
// sun's disc.
out vec3 skyLight;
out vec3 skyReaches;
out vec2 fromSun;  // from its middle, 1 at its rim
flat out vec3 moon;  // likewise; z: its radius, 0 where it is not before the sun

uniform vec4 moon_body;  // unit vector from the eye; w: its angular radius, 0: none

uniform int rows[kSkyBands + 1];  // where bands end, from below; of them bandCount + 1
uniform int bandCount;
uniform int firstColumn;

const float kBelowHorizon = 0.2;  // of the tangent of half the angle to the nadir

vec3 domeDirection(int column, int row) {
  float upwards = float(max(row - 1, 0)) / float(kSkyBands - 1);
  float tangent = row == 0 ? kBelowHorizon / airView.horizon.z : upwards * upwards * upwards / airView.horizon.w;
  float scale = 1.0 / (1.0 + tangent * tangent);
  float past = 2.0 * tangent * scale;
  float pastCosine = (1.0 - tangent * tangent) * scale;
  float sine = past * airView.horizon.y + pastCosine * airView.horizon.x;
  float cosine = pastCosine * airView.horizon.y - past * airView.horizon.x;
  float azimuth = 2.0 * kPi * float(column % kSkyColumns) / float(kSkyColumns);
  vec3 across = cross(airView.up.xyz, airView.side.xyz);
  return sine * (cos(azimuth) * airView.side.xyz + sin(azimuth) * across) - cosine * airView.up.xyz;
}

void main() {
  int corner = gl_VertexID % 2;
  moon = vec3(0.0);
  vec3 direction;
  if (gl_InstanceID < bandCount) {
    direction = domeDirection(firstColumn + gl_VertexID / 2, rows[gl_InstanceID + corner]);
    fromSun = vec2(1e3);
  } else {
    float soft = 1.0 + airView.toSun.w / air.aerosolExtinction.w;
    fromSun = soft * vec2(corner == 0 ? -1.0 : 1.0, gl_VertexID / 2 == 0 ? -1.0 : 1.0);
    if (gl_VertexID >= 4) fromSun = vec2(soft);
    vec3 sideways = normalize(cross(airView.toSun.xyz, abs(airView.toSun.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
    vec3 upwards = cross(sideways, airView.toSun.xyz);
    vec3 moon_air = normalize(moon_body.xyz * airView.scale.xyz);
    if (dot(moon_air, airView.toSun.xyz) > 0.0)
      moon = vec3(dot(moon_air, sideways), dot(moon_air, upwards), moon_body.w) / air.aerosolExtinction.w;
    direction = airView.toSun.xyz + air.aerosolExtinction.w * (fromSun.x * sideways + fromSun.y * upwards);
  }
  vec3 place = airPlaceOfSky(airView, normalize(direction));
  skyReaches = exp(-textureLod(airDepth, place.yz, 0.0).rgb);
  skyLight = textureLod(airLight, place, 0.0).rgb;
  vec3 direction_view = mat3(viewFromBody) * (direction / airView.scale.xyz);
  gl_Position = vec4(onPicture(direction_view), 0.0, -direction_view.z);
}
