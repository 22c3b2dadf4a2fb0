#include "geo/local_frame.h"

namespace tellurion::geo {

LocalFrame localFrameAt(const Ellipsoid& ellipsoid, const Geodetic& g) {
  const SinCos lat = sinCos(g.lat);
  const SinCos lon = sinCos(g.lon);
  return {.origin = ellipsoid.bodyFromGeodetic(g),
          .east = Vec3(-lon.sin, lon.cos, 0.0),
          .north = Vec3(-lat.sin * lon.cos, -lat.sin * lon.sin, lat.cos),
          .up = Vec3(lat.cos * lon.cos, lat.cos * lon.sin, lat.sin)};
}

}  // namespace tellurion::geo
