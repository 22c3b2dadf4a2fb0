#pragma once

#include "geo/body.h"
#include "scene/camera.h"

namespace tellurion::scene {

/// A view over the Earth: degrees and metres, 45 degrees high.
inline View viewFrom(double lat, double lon, double height_m, double heading, double pitch,
                     const Viewport& viewport = {.width = 1024, .height = 768}) {
  const Camera camera{
      .position = {.lat = geo::Angle::degrees(lat), .lon = geo::Angle::degrees(lon), .height_m = height_m},
      .heading = geo::Angle::degrees(heading),
      .pitch = geo::Angle::degrees(pitch),
      .roll = {}};
  return viewOf(camera, geo::earth().ellipsoid, geo::Angle::degrees(45.0), viewport);
}

}  // namespace tellurion::scene
