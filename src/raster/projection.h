#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "geo/geo_rect.h"
#include "io/failure.h"

namespace tellurion::raster {

/// Between longitude and latitude in degrees and the coordinates of a spatial reference, by PROJ, off the network. One
/// fixed operation for every point, so a result depends on the point alone. One thread only; move-only.
class Projection {
 public:
  Projection(Projection&&) noexcept;
  Projection& operator=(Projection&&) noexcept;
  ~Projection();

  /// From the geographic coordinates that the reference itself is built on: no change of datum.
  static io::Result<Projection> fromOwnGeographic(const std::string& wkt);
  /// From WGS 84, by the most accurate operation for `area` that needs no file that is not installed.
  /// Without an area the best operation for the whole of the reference's own.
  static io::Result<Projection> fromWgs84(const std::string& wkt, const std::optional<geo::GeoRect>& area);

  /// In place: x holds longitudes and y latitudes in degrees, afterwards coordinates of the reference (east, north; its
  /// units). A point that has none becomes infinite.
  void forward(std::span<double> x, std::span<double> y) const;
  void inverse(std::span<double> x, std::span<double> y) const;

  /// Whether it changes nothing: the reference is longitude and latitude, in degrees, on the source's datum.
  bool isIdentity() const;

 private:
  struct Handles;
  explicit Projection(std::unique_ptr<Handles> handles);
  std::unique_ptr<Handles> handles_;
};

}  // namespace tellurion::raster
