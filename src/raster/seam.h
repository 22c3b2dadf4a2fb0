#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "geo/ellipsoid.h"
#include "geo/geo_rect.h"
#include "raster/nearest_tiles.h"
#include "raster/tile_source.h"
#include "tiling/tiling.h"

namespace tellurion::raster {

/// How much of a local elevation model counts at a place, so that it does not end as a cliff over the layers below: 0
/// where it has no data, 1 further inside than the width of the seam, smooth between. A function of the place alone,
/// whatever the level of the tile that asks; so the ground stays whole, and samples of parents stay samples of their
/// children. Immutable, thread-safe.
///
/// It knows the model's outline, voids included, on a map of kMapSide x kMapSide cells over the model's bounds: seams
/// narrower than a few of these are not made, and data or voids of less than a cell may not be known.
class Seam {
 public:
  static constexpr int kMapSide = 256;
  /// Of the smaller side of the model's bounds.
  static constexpr double kUsualShare = 0.05;
  /// Bounds larger than this have no seam: their map would be too coarse, and they are no local model.
  static constexpr double kLargest_degrees = 40.0;

  /// hasData: whether the model has a height at a place; it is asked for each cell of the map once, and may block.
  /// width_m: 0 is kUsualShare. Null: the model is too large for a seam.
  static std::shared_ptr<const Seam> around(const geo::GeoRect& bounds, const geo::Ellipsoid& ellipsoid, double width_m,
                                            const std::function<bool(const geo::Direction&)>& hasData);

  /// The same of a source over others. seam_m: as wide as that, 0: none, nothing: kUsualShare. hasData: whether the
  /// source has a height at a place, on a level that is fine enough for the map. Null: it ends with a step.
  static std::shared_ptr<const Seam> of(const TileSourceInfo& info, const std::optional<double>& seam_m,
                                        const std::function<bool(int level, const geo::Direction& place)>& hasData);

  double weight(const geo::Direction& place) const;  ///< 0..1
  double width_m() const { return width_m_; }

 private:
  Seam() = default;

  geo::Vec3 middle_{0.0, 0.0, 0.0};
  geo::Vec3 east_{0.0, 0.0, 0.0};
  geo::Vec3 north_{0.0, 0.0, 0.0};
  double radius_m_ = 0.0;
  double left_m_ = 0.0;  ///< of the map's first column of cells, from the middle
  double low_m_ = 0.0;   ///< likewise of its first row
  double cellWidth_m_ = 0.0;
  double cellHeight_m_ = 0.0;
  double width_m_ = 0.0;
  std::vector<float> inside_m_;  ///< from the middle of each cell to what has no data, less what a cell may hide
};

/// Seam::of, made when it is first asked for. Thread-safe.
class LateSeam {
 public:
  /// Whether the source has a tile, of one that tells what it stores, so that nothing is waited for; nothing: it does
  /// not tell.
  using Told = std::function<std::optional<bool>(const tiling::TileId& id)>;
  /// The deepest tile over another, itself included; none where there is none or it fails. May block.
  using Nearest = std::function<NearestTiles::Found(const tiling::TileId& id)>;
  /// Null: it ends with a step. The same source each time; the functions are used by the first call alone.
  const Seam* get(const TileSourceInfo& info, const std::optional<double>& seam_m, const Told& told,
                  const Nearest& nearest);

 private:
  std::once_flag made_;
  std::shared_ptr<const Seam> seam_;
};

/// Whether the nearest sample to a place in an elevation tile, which must hold the place, is a height.
bool hasHeightAt(const SourceTile& tile, const tiling::TileId& id, const tiling::Tiling& tiling,
                 const geo::Direction& place);

}  // namespace tellurion::raster
