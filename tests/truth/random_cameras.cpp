#include "truth/random_cameras.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

namespace tellurion::truth {
namespace {

constexpr double kEyeHeight_m = 2.0;  ///< the least over the ground

}  // namespace

RandomCameras::RandomCameras(const geo::Ellipsoid& ellipsoid, const Place& place, tiling::Scheme scheme,
                             unsigned int seed, scene::Viewport size)
    : ellipsoid_(ellipsoid), place_(place), size_(size) {
  std::vector<unsigned int> dice{seed, static_cast<unsigned int>(scheme)};
  dice.insert(dice.end(), place.name.begin(), place.name.end());
  std::seed_seq mixed(dice.begin(), dice.end());
  random_.seed(mixed);
}

scene::View RandomCameras::anywhere(const HeightOf& height_m) {
  const geo::Angle fov = geo::Angle::degrees(uniform(20, 70));
  scene::Camera camera{.position = somewhere()};
  const double highest_m = 4.0 * ellipsoid_.semiMajorAxis_m();
  const double above_m = kEyeHeight_m * std::pow(highest_m / kEyeHeight_m, uniform(0, 1));
  const auto below = geo::directionFromLatLon(camera.position.lat, camera.position.lon);
  camera.position.height_m = height_m(below) + above_m;
  const double horizon = std::acos(ellipsoid_.semiMinorAxis_m() / (ellipsoid_.semiMinorAxis_m() + above_m));
  camera.heading = geo::Angle::degrees(uniform(0, 360));
  camera.pitch = geo::Angle::degrees(uniform(-90, 15 - horizon * 180.0 / geo::kPi));
  camera.roll = geo::Angle::degrees(uniform(-30, 30));
  return scene::viewOf(camera, ellipsoid_, fov, size_);
}

scene::View RandomCameras::wherePixelsCoverSamples(const HeightOf& height_m) {
  const geo::Angle fov = geo::Angle::degrees(45);
  const double lowest_m = place_.finestSample_m / (2.0 * std::tan(fov.radians() / 2.0) / size_.height);
  for (;;) {
    geo::Geodetic target = somewhere();
    target.height_m = height_m(geo::directionFromLatLon(target.lat, target.lon));
    const geo::LocalFrame frame = geo::localFrameAt(ellipsoid_, target);
    const double distance_m = lowest_m * std::exp(uniform(std::log(1.3), std::log(8.0)));
    const double elevation = uniform(12.0, 90.0) * geo::kPi / 180.0;
    const double azimuth = uniform(0.0, 2.0 * geo::kPi);
    const geo::Vec3 away =
        frame.bodyFromEnu() * geo::Vec3(std::cos(elevation) * std::sin(azimuth),
                                        std::cos(elevation) * std::cos(azimuth), std::sin(elevation));
    const geo::Geodetic place = ellipsoid_.geodeticFromBody(frame.origin + away * distance_m);
    const double below_m = height_m(geo::directionFromLatLon(place.lat, place.lon));
    if (place.height_m < below_m + kEyeHeight_m) continue;
    const geo::LocalFrame eye = geo::localFrameAt(ellipsoid_, place);
    const scene::Camera camera{
        .position = place,
        .heading = geo::Angle::radians(std::atan2(-geo::dot(away, eye.east), -geo::dot(away, eye.north))),
        .pitch = geo::Angle::radians(std::asin(std::clamp(-geo::dot(away, eye.up), -1.0, 1.0))),
        .roll = geo::Angle::degrees(uniform(-30.0, 30.0))};
    return scene::viewOf(camera, ellipsoid_, fov, size_);
  }
}

geo::Geodetic RandomCameras::somewhere() {
  const double south = std::sin(place_.where.south.radians());
  const double north = std::sin(place_.where.north.radians());
  const double lat = std::asin(uniform(south, north));
  return {.lat = geo::Angle::radians(lat), .lon = place_.where.west + place_.where.width * uniform(0.0, 1.0)};
}

std::string described(const scene::View& view, const geo::Ellipsoid& ellipsoid) {
  const scene::Camera c = scene::cameraOf(view, ellipsoid);
  std::ostringstream out;
  out.precision(17);  // to the bit, so that the program draws what was drawn
  out << c.position.lat.degrees() << ',' << c.position.lon.degrees() << ',' << c.position.height_m << ','
      << c.heading.degrees() << ',' << c.pitch.degrees() << ',' << c.roll.degrees() << " fov "
      << view.verticalFov.degrees();
  return out.str();
}

}  // namespace tellurion::truth
