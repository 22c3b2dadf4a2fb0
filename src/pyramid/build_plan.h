#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pyramid/database.h"
#include "pyramid/fill_plan.h"
#include "pyramid/input_signature.h"
#include "pyramid/pyramid_builder.h"
#include "raster/point_ground.h"
#include "raster/raster_file.h"

namespace tellurion::pyramid {

class ImageryCleaning;

/// A raster, or of a layer of points the ground of one spacing (planned_points.h).
struct PlannedInput {
  std::string path;
  /// The smallest level whose largest sample spacing does not exceed the input's finest, no deeper than asked for.
  int depth = 0;
  /// Side of the area that a sample averages; 0: bilinear. Wide only where the depth asked for is less than the natural
  /// one.
  geo::Angle footprint;
  geo::GeoRect bounds;           ///< of what of it is built
  geo::GeoRect extent;           ///< of all of it
  geo::Angle spacing;            ///< the finest that is made use of
  std::vector<FileStamp> files;  ///< all that it is read from, as they were when it was planned
  std::shared_ptr<const raster::PointGround> ground = nullptr;  ///< null: a raster
  int spacingLevel = 0;                                         ///< of the ground
};

/// All that is decided before the first tile is made. Immutable: worker threads share it.
struct BuildPlan {
  raster::RasterOptions rasterOptions;
  std::string verticalDatum;  ///< of all inputs; empty: their heights are taken as they are
  CleaningOptions cleaning;
  std::shared_ptr<const ImageryCleaning> cleaned;  ///< what they come to: made before the first tile; null: nothing
  std::vector<PlannedInput> inputs;
  DatabaseMeta meta;  ///< of the database when it is finished, but for its deepest level and `complete`
  int deepestLevel = 0;
  std::optional<geo::GeoRect> region;  ///< samples elsewhere have no data
  TileFormat format = TileFormat::jpeg;
  FillPlan fill;
  /// The level whose tiles are made together with all below them; nothing where samples depend on more than the inputs
  /// at their place: on a base, or on finer data near by.
  std::optional<int> blockLevel;
  std::optional<std::filesystem::path> base;  ///< the database that the inputs are laid over
  std::vector<std::string> warnings;
  std::vector<std::string> olderKeys;  ///< build keys that former versions of the builder gave the same command

  /// Whether heights may depend on other data than that at their place, or have to say how deep that is.
  bool fills() const;
  /// What is held in memory as long as the build goes on, and of points is needed while they are asked for.
  std::uint64_t bytesHeld(int jobs) const;
  /// Of the first tiles that are made.
  int startLevel() const { return blockLevel.value_or(deepestLevel); }
  tiling::Tiling tiling() const { return tiling::Tiling(meta.scheme); }
};

/// Opens each input once and decides. `base`: the database that --append found at the output.
io::Result<BuildPlan> planBuild(const BuildOptions& options, const std::optional<DatabaseMeta>& base);

/// The step of stored heights: the quantum / 16, rounded down to a power of two; 0 for floating point.
double heightStepFor(double heightQuantum_m);

}  // namespace tellurion::pyramid
