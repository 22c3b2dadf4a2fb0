#pragma once

#include <functional>
#include <random>
#include <string>

#include "geo/ellipsoid.h"
#include "scene/camera.h"
#include "tiling/tiling.h"
#include "truth/proof_planets.h"

namespace tellurion::truth {

using HeightOf = std::function<double(const geo::Direction&)>;  ///< the ground's, metres above the ellipsoid

/// Cameras over random points of a place, none of them less than 2 m above the ground that they are told of. The same
/// for a seed, place and scheme.
class RandomCameras {
 public:
  RandomCameras(const geo::Ellipsoid& ellipsoid, const Place& place, tiling::Scheme scheme, unsigned int seed,
                scene::Viewport size);

  /// From 2 m above the ground to 4 radii, any heading, any pitch that has ground in the picture.
  scene::View anywhere(const HeightOf& height_m);
  /// Looks at the place from any side, from so far away that each pixel covers a sample of the rasters or more.
  scene::View wherePixelsCoverSamples(const HeightOf& height_m);

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  geo::Geodetic somewhere();

  geo::Ellipsoid ellipsoid_;
  Place place_;
  scene::Viewport size_;
  std::mt19937_64 random_;
};

/// As --camera of the program takes it, and the field of view.
std::string described(const scene::View& view, const geo::Ellipsoid& ellipsoid);

}  // namespace tellurion::truth
