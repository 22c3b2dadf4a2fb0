#pragma once

#include <string>
#include <vector>

#include "geo/body.h"
#include "geo/geo_rect.h"

// The data that pictures are measured over.
namespace tellurion::truth {

struct Place {
  std::string name;
  geo::GeoRect where;
  double finestSample_m = 0;  ///< of the rasters, there
};

struct Planet {
  geo::Body body;
  std::vector<std::string> rasters;
  std::vector<Place> places;
};

/// The Earth at 10' with Everest at 3", and Mars at 15 km: the project's own. With a collection (a folder; empty: none)
/// that has them, also Gabilan Mesa and the floor of Gale crater, both with samples a metre apart.
std::vector<Planet> planets(const std::string& collection);

/// The Earth at 10' with Everest at 3", and one place around the border of that: with a collection that has it, of the
/// raster as it was published, full of voids.
Planet planetWithVoids(const std::string& collection);

}  // namespace tellurion::truth
