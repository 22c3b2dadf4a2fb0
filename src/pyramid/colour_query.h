#pragma once

#include "pyramid/height_query.h"

namespace tellurion::pyramid {

/// How colours are asked for; the same for all places of a batch.
struct ColourQuestion {
  std::optional<int> level;  ///< no deeper than this, 0 to tiling::kMaxLevel; nothing: the finest that is stored
  Sampling sampling = Sampling::bilinear;
};

struct ColourAnswer {
  raster::Rgba8 colour;    ///< sRGB, not premultiplied; a is the coverage there, never 0
  int level = 0;           ///< of the tile that answered
  double spacing_m = 0.0;  ///< mean distance between pixels of that level, along the ground
  bool hasFiner = false;   ///< finer tiles are stored at the place, but the question's level kept them out
};

/// Colours of places from the finest tiles of imagery that hold them, or from a level; mixed in linear light, weighted
/// by coverage. Across the edges of tiles of a level, whichever faces they are on, there is no step but what the stored
/// pictures (JPEG) have themselves; at the border of finer imagery the picture changes as the data do. Thread-safe.
class ColourQuery {
 public:
  /// `source` must hold imagery, else invalidArgument. Keeps decoded tiles (266 kB each for 256 pixels a side) up to
  /// `cacheBytes`.
  static io::Result<ColourQuery> create(std::shared_ptr<const raster::TileSource> source,
                                        std::uint64_t cacheBytes = kQueryCacheBytes);
  ~ColourQuery();
  ColourQuery(ColourQuery&&) noexcept;
  ColourQuery& operator=(ColourQuery&&) noexcept;

  /// Nothing where nothing covers the place, and for NaN. Fails as HeightQuery::at does.
  io::Result<std::optional<ColourAnswer>> at(const geo::Direction& place, const ColourQuestion& question = {}) const;
  /// The same for each of `places`, into `answers`, which is as long; as HeightQuery's.
  io::Result<void> at(std::span<const geo::Direction> places, std::span<std::optional<ColourAnswer>> answers,
                      const ColourQuestion& question = {}) const;

 private:
  struct State;
  explicit ColourQuery(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tellurion::pyramid
