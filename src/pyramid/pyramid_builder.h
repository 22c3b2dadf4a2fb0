#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "geo/body.h"
#include "geo/geo_rect.h"
#include "io/failure.h"
#include "pyramid/cleaning_options.h"
#include "raster/point_layer.h"
#include "raster/tile.h"
#include "tiling/tiling.h"

namespace tellurion::pyramid {

/// How imagery is stored: JPEG where a tile is wholly covered and WebP without loss elsewhere; all PNG; all WebP
/// without loss.
enum class TileFormat : std::uint8_t { jpeg, png, webp };
std::optional<TileFormat> tileFormatByName(std::string_view name);
std::string_view nameOf(TileFormat format);

inline constexpr std::uint64_t kLeastMemory = std::uint64_t{128} << 20u;

struct BuildOptions {
  std::filesystem::path output;     ///< work is done in OUTPUT.part, renamed at the end
  std::vector<std::string> inputs;  ///< rasters and layers of points, bottom first: later ones lie over earlier ones
  raster::Kind kind = raster::Kind::elevation;
  tiling::Scheme scheme = tiling::Scheme::cube;
  std::optional<geo::Body> body;  ///< left out: what the inputs say, which must agree
  std::optional<int> maxLevel;    ///< no tile deeper than this; what is finer is averaged
  std::optional<double> nodata;   ///< overrides the NODATA value of every input
  /// Elevation: how far at most, in metres, data may move coarser heights beside it, in its voids and beyond its
  /// border, so that there is no step (void_fill.h); 0: not at all. Left out: as far as the inputs' depths ask for, or,
  /// for an append, what the database was built with. An append with another one is refused.
  std::optional<double> fillVoids_m;
  /// Elevation: no stored height is farther from what the inputs say there than this, metres, above 0, but for what
  /// fillVoids_m moves; much smaller files (bounded_heights.h). Left out: as exact as the inputs are stored, or, for an
  /// append, as the database was built. An append with another one is refused.
  std::optional<double> maxError_m;
  /// Elevation: what the inputs' heights are above, as raster/vertical_datum.h names it; they are stored above the
  /// ellipsoid. Empty: as they are.
  std::string verticalDatum;
  raster::PointOptions points;  ///< elevation: how inputs that are layers of points are read
  CleaningOptions cleaning;     ///< imagery
  /// Only what lies in it is built, as if every input ended at its edges; nothing beside it is read but what samples
  /// within are made of.
  std::optional<geo::GeoRect> region;
  TileFormat format = TileFormat::jpeg;  ///< imagery
  /// What the process may take of memory, resident, at most, whatever the size of the inputs; kLeastMemory at least.
  /// Blocks of an input that are larger than a part of it are read all the same, and so are many workers fed.
  std::uint64_t memoryBytes = std::uint64_t{1} << 30u;
  int jobs = 0;         ///< worker threads; 0: one for each core
  bool append = false;  ///< lay the inputs over the database that is there; kind, tiling and body must agree with it
};

/// How far a build is.
struct BuildProgress {
  int level = 0;                 ///< the one that is being made; deepest first
  std::uint64_t done = 0;        ///< tiles made, those of an interrupted run included
  std::uint64_t total = 0;       ///< an estimate; never less than `done`
  std::uint64_t doneBefore = 0;  ///< of `done`, those made by an interrupted run
};
/// Called on the thread that called buildPyramid, at most some ten times a second.
using ProgressSink = std::function<void(const BuildProgress&)>;

struct BuildReport {
  std::uint64_t tiles = 0;            ///< in the finished database
  std::uint64_t bytes = 0;            ///< its file size
  int maxLevel = 0;                   ///< the deepest level that holds a tile
  bool alreadyComplete = false;       ///< the same build had been finished before; nothing was done
  bool resumed = false;               ///< went on where an interrupted run was
  std::vector<std::string> warnings;  ///< of opening and of sampling, each once, sorted; at most 101
};

/// Names all that the bytes of a new database with these options depend on: the options, every file that is read, and
/// the versions of builder and format. Opens the inputs; `output` and `jobs` do not count.
io::Result<std::string> keyOfBuild(const BuildOptions& options);

/// Builds or extends a tile database. All cores work; memory is bounded whatever the size of the inputs. The result is
/// the same, byte for byte, whatever the number of threads and however often the build was killed and started again. A
/// stop asked for through `stop` gives Failure::Code::cancelled; the same call then goes on where it was.
io::Result<BuildReport> buildPyramid(const BuildOptions& options, const ProgressSink& progress = {},
                                     std::stop_token stop = {});

}  // namespace tellurion::pyramid
