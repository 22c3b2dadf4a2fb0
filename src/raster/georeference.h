#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "geo/body.h"
#include "io/failure.h"
#include "raster/projection.h"

class GDALDataset;

namespace tellurion::raster {

/// Where a dataset says that it lies.
struct Georeference {
  /// x = t[0] + col t[1] + row t[2], y = t[3] + col t[4] + row t[5]; (0, 0) is the outer corner of the first pixel.
  std::array<double, 6> transform{};
  /// From longitude and latitude in degrees to (x, y); nothing when they are the same.
  std::optional<Projection> projection;
  /// x after which the map begins again; 0 when it does not.
  double turn = 0.0;
  geo::Body body = geo::earth();
  bool bodyIsAssumed = false;  ///< no spatial reference names it
};

/// `body`, if given, is taken in place of the one that the spatial reference names. Warnings are added.
io::Result<Georeference> readGeoreference(GDALDataset& dataset, const std::string& path,
                                          const std::optional<geo::Body>& body, std::vector<std::string>& warnings);

}  // namespace tellurion::raster
