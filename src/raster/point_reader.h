#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "geo/body.h"
#include "raster/point_layer.h"
#include "raster/projection.h"

class OGRFeature;
class OGRLayer;
class OGRPoint;

namespace tellurion::raster {

/// Where a layer lies.
struct PointReference {
  geo::Body body = geo::earth();
  bool isMap = false;                    ///< coordinates are metres or the like, not angles
  std::optional<Projection> projection;  ///< nothing: longitude and latitude in degrees
};

/// Where in a layer's features place and height are; -1: nowhere.
struct PointColumns {
  int x = -1;
  int y = -1;
  int height = -1;
  bool heightIsZ = false;  ///< the geometry's, where it has one; the column where it has none
};

/// Finds them by the rules of readPoints(). Reads the layer where it has to.
io::Result<PointColumns> columnsOf(OGRLayer& layer, bool isMap, const PointOptions& options, const std::string& path,
                                   std::vector<std::string>& warnings);

/// Takes the points out of features, and counts those that are none. One thread only.
class PointReader {
 public:
  PointReader(const PointReference& reference, const PointColumns& columns, const std::optional<double>& nodata,
              const PointSink& sink);

  io::Result<void> take(const OGRFeature& feature, const std::string& path);
  /// After the last feature.
  io::Result<void> finish();

  /// What was left out becomes warnings; a failure where nothing is left.
  io::Result<void> tell(const std::string& path, std::vector<std::string>& warnings) const;

 private:
  /// Why a point is left out.
  enum class Fault : std::uint8_t { noNumber, nodata, elsewhere, impossible };
  static constexpr std::size_t kFaults = 4;

  io::Result<void> takePoint(const OGRPoint& point, const OGRFeature& feature);
  io::Result<void> takeAt(std::optional<double> x, std::optional<double> y, std::optional<double> height_m);
  void count(Fault fault) { ++faults_[static_cast<std::size_t>(fault)]; }

  const PointReference& reference_;
  PointColumns columns_;
  std::optional<double> nodata_;
  const PointSink& sink_;
  double lowest_m_ = 0.0;
  double highest_m_ = 0.0;
  std::vector<double> x_;  ///< of those that wait for their projection
  std::vector<double> y_;
  std::vector<double> heights_m_;
  std::uint64_t taken_ = 0;
  std::array<std::uint64_t, kFaults> faults_{};
};

}  // namespace tellurion::raster
