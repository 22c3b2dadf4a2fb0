#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "io/sqlite.h"
#include "raster/tile_source.h"

namespace tellurion::pyramid {

inline constexpr std::int64_t kNewestFormatVersion = 2;
/// The version of the file format (docs/tile-database.md) that files of a tiling are written in, and the only one of
/// it that is read.
std::int64_t formatVersionOf(tiling::Scheme scheme);

/// What the file says about itself (docs/tile-database.md, "meta").
struct DatabaseMeta {
  raster::Kind kind = raster::Kind::elevation;
  tiling::Scheme scheme = tiling::Scheme::cube;
  geo::Body body = geo::earth();
  int tileCells = raster::kElevationCells;
  int maxLevel = 0;
  geo::GeoRect bounds = geo::GeoRect::whole();
  double heightStep_m = 0.0;
  double fillVoids_m = 0.0;  ///< elevation: the limit that voids were filled with (fill_plan.h); 0: they were not
  int fillFromLevel = 0;     ///< elevation: of the coarsest input
  double maxError_m = 0.0;   ///< elevation: how far stored heights may be off what the inputs say; 0: not asked for
  bool complete = false;
  std::string buildKey;    ///< what this file was, or is being, built from; two equal keys: two equal files
  std::string requestKey;  ///< the last request alone, whatever was in the file before it
  std::vector<std::string> sources;
};

/// Names and values, read whole; where: for messages.
struct MetaTable {
  std::string where;
  std::map<std::string, std::string, std::less<>> texts;
  std::map<std::string, double, std::less<>> numbers;
};
using MetaValue = std::variant<std::string, std::int64_t, double>;
/// What tells how tiles are to be read: all but the keys, the sources and whether the file is complete.
std::vector<std::pair<std::string_view, MetaValue>> valuesForReading(const DatabaseMeta& meta);
/// The same from such values. Fails on what is missing or out of its range, and names it.
io::Result<DatabaseMeta> metaForReading(const MetaTable& table);

/// What a source of such tiles tells of itself; name: for messages.
raster::TileSourceInfo sourceInfoOf(std::string name, const DatabaseMeta& meta);

/// The tables `meta` and `sources`. Fails on what is missing or out of its range, and names it.
io::Result<DatabaseMeta> readMeta(const io::SqliteConnection& connection);
/// All but the position of an unfinished build.
io::Result<void> writeMeta(const io::SqliteConnection& connection, const DatabaseMeta& meta);

}  // namespace tellurion::pyramid
