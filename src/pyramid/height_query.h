#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "geo/geodetic.h"
#include "raster/tile_source.h"

namespace tellurion::pyramid {

/// How a value between samples is found: on the bilinear surface between the four around a place, or as the sample that
/// is nearest to it (of several equally near ones any).
enum class Sampling : std::uint8_t { bilinear, nearest };

/// What a query keeps of decoded tiles unless it is told otherwise, bytes.
inline constexpr std::uint64_t kQueryCacheBytes = std::uint64_t{64} << 20u;

/// How heights are asked for; the same for all places of a batch.
struct HeightQuestion {
  /// No deeper than this level, 0 to tiling::kMaxLevel; nothing: the finest that is stored at each place.
  std::optional<int> level;
  Sampling sampling = Sampling::bilinear;
  bool withNormals = false;  ///< these cost several times what a height does
};

struct HeightAnswer {
  double height_m = 0.0;  ///< metres above the ellipsoid (or above what the source's heights are above)
  /// Unit normal of the bilinear surface there: east, north, up; the body's curvature included. 0 where not asked for.
  geo::Vec3 normal_enu{0.0, 0.0, 0.0};
  int level = 0;           ///< of the tile that answered
  double spacing_m = 0.0;  ///< mean distance between samples of that level, along the ground
  /// How far at most the height is from the surface of the finest tiles that are stored at the place, metres: 0 where
  /// that surface answered, or what its samples may be off in a database that was built with --max-error. Beside gaps
  /// of the data, where the finest surface ends, it is a distance in space as the geometric error is
  /// (docs/tile-database.md). How far the data are from the true ground nobody knows here.
  double errorBound_m = 0.0;
  bool hasFiner = false;  ///< finer tiles are stored at the place, but the question's level kept them out
};

/// Heights of places from the finest tiles that hold them, or from a level. The bilinear surface has no step: not
/// between tiles of a level, whichever faces they are on, and not between a tile and coarser ones beside it, for there
/// its border lies on the surface of the level above, as that of the drawn ground does (docs/queries.md). Where the
/// nearest of the four samples is NODATA there is no height, else the weights are shared among those that have data.
///
/// Thread-safe: any number of threads may ask one query, and share what it keeps.
class HeightQuery {
 public:
  /// `source` must hold elevation, else invalidArgument. Keeps decoded tiles (17 kB each for 64 cells a side) up to
  /// `cacheBytes`.
  static io::Result<HeightQuery> create(std::shared_ptr<const raster::TileSource> source,
                                        std::uint64_t cacheBytes = kQueryCacheBytes);
  ~HeightQuery();
  HeightQuery(HeightQuery&&) noexcept;
  HeightQuery& operator=(HeightQuery&&) noexcept;

  /// Nothing where there is no data, and for NaN. Fails on what load() fails on (corrupt, ioError, ...), and with
  /// corrupt where a tile is missing; other places can still be asked.
  io::Result<std::optional<HeightAnswer>> at(const geo::Direction& place, const HeightQuestion& question = {}) const;

  /// The same for each of `places`, into `answers`, which is as long. To the last bit what they give one by one, but a
  /// tile is read once for all places on it: several times faster for thousands of random places in memory, tens of
  /// times where the tiles do not fit into the cache. Takes 60 bytes a place meanwhile. When a tile fails the batch
  /// does, and what is in `answers` is any.
  io::Result<void> at(std::span<const geo::Direction> places, std::span<std::optional<HeightAnswer>> answers,
                      const HeightQuestion& question = {}) const;

 private:
  struct State;
  explicit HeightQuery(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tellurion::pyramid
