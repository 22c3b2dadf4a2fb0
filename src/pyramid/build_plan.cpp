#include "pyramid/build_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "pyramid/database_file.h"
#include "pyramid/geometric_error.h"
#include "raster/live_tiles.h"

namespace tellurion::pyramid {
namespace {

using Code = io::Failure::Code;

/// FNV-1a, 64 bits, as hexadecimal digits: a name for a text, not a protection.
std::string digestOf(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) {
    hash ^= static_cast<std::uint8_t>(c);
    hash *= 0x100000001b3u;
  }
  return fmt::format("{:016x}", hash);
}

/// How an input is named in the database and in its key: the same for "a.tif" and "./a.tif".
std::string storedName(const std::string& path) {
  return std::filesystem::path(path).lexically_normal().string();
}

/// What tells one content of a file from another without reading it.
std::string signatureOfFile(const std::string& path) {
  std::error_code error;
  const auto absolute = std::filesystem::weakly_canonical(path, error);
  const auto size = std::filesystem::file_size(path, error);
  if (error) return path;
  const auto time = std::filesystem::last_write_time(path, error).time_since_epoch().count();
  return fmt::format("{}|{}|{}", absolute.string(), size, time);
}

std::string requestKeyOf(const BuildOptions& options, const DatabaseMeta& meta, const std::string& inputs) {
  std::string text =
      fmt::format("{}|{}|{}|{}|{}|{}|{:a}|{:a}|{}", kBuilderVersion, formatVersionOf(meta.scheme), options.append,
                  nameOf(meta.kind), tiling::nameOf(meta.scheme), meta.body.name, meta.body.ellipsoid.semiMajorAxis_m(),
                  meta.body.ellipsoid.flattening(), options.maxLevel.value_or(-1));
  if (meta.kind == raster::Kind::elevation) text += fmt::format("|fill {:a}", meta.fillVoids_m);
  if (meta.kind == raster::Kind::imagery) text += fmt::format("|{}", nameOf(options.format));
  if (options.region) {
    text += fmt::format("|region {:a} {:a} {:a} {:a}", options.region->west.radians(), options.region->south.radians(),
                        options.region->width.radians(), options.region->north.radians());
  }
  if (options.nodata) text += fmt::format("|nodata {:a}", *options.nodata);
  return digestOf(text + inputs);
}

io::Result<void> checkOptions(const BuildOptions& options) {
  if (options.inputs.empty()) return io::fail(Code::invalidArgument, "no input: name at least one raster");
  if (options.maxLevel && (*options.maxLevel < 0 || *options.maxLevel > tiling::kMaxLevel)) {
    return io::fail(Code::invalidArgument, fmt::format("the deepest level must be 0 to {}", tiling::kMaxLevel));
  }
  const double limit_m = options.fillVoids_m.value_or(0.0);
  if (!(limit_m >= 0.0 && limit_m <= kFillWithoutLimit_m)) {
    return io::fail(Code::invalidArgument,
                    fmt::format("voids are filled over 0 to {:g} m, not {}", kFillWithoutLimit_m, limit_m));
  }
  if (options.fillVoids_m && options.kind == raster::Kind::imagery) {
    return io::fail(Code::invalidArgument, "only elevation has voids to fill: leave --fill-voids out");
  }
  if (options.format != TileFormat::jpeg && options.kind == raster::Kind::elevation) {
    return io::fail(Code::invalidArgument, "only imagery has a format: leave --format out");
  }
  if (options.memoryBytes < kLeastMemory) {
    return io::fail(Code::invalidArgument, fmt::format("a build takes at least {} MiB of memory", kLeastMemory >> 20u));
  }
  if (options.region && !(options.region->south < options.region->north && options.region->width > geo::Angle())) {
    return io::fail(Code::invalidArgument, "the region is empty: it is W,S,E,N in degrees, S less than N");
  }
  if (options.jobs < 0) return io::fail(Code::invalidArgument, "the number of jobs must not be negative");
  return {};
}

io::Result<void> checkBase(const BuildOptions& options, const DatabaseMeta& base) {
  const std::string where = options.output.string();
  if (base.kind != options.kind) {
    return io::fail(Code::invalidArgument, fmt::format("holds {}; append the same kind", nameOf(base.kind)), where);
  }
  if (base.scheme != options.scheme) {
    return io::fail(Code::invalidArgument,
                    fmt::format("is cut by the {0} tiling; append with --tiling {0}", tiling::nameOf(base.scheme)),
                    where);
  }
  if (options.fillVoids_m && *options.fillVoids_m != base.fillVoids_m) {
    return io::fail(
        Code::invalidArgument,
        fmt::format("was built with --fill-voids {:g}, and what is appended has to be filled alike: leave the "
                    "option out, or build the database again with the other one",
                    base.fillVoids_m),
        where);
  }
  return {};
}

io::Result<void> checkInput(const std::string& path) {
  if (!isTileDatabaseFile(path)) return {};
  return io::fail(
      Code::invalidArgument,
      "is a tile database, and a build takes rasters: name the rasters that it was made of ('tellurion info' "
      "lists them), or show it as it is, with others joined by commas ('tellurion view A.tdb,B.tdb')",
      path);
}

/// Holds what two rectangles share; nothing where they do not meet. A little too wide where they meet twice.
std::optional<geo::GeoRect> shared(const geo::GeoRect& bounds, const geo::GeoRect& region) {
  if (!bounds.intersects(region)) return std::nullopt;
  geo::GeoRect both = region.width < bounds.width ? region : bounds;
  both.south = std::max(bounds.south, region.south);
  both.north = std::min(bounds.north, region.north);
  return both;
}

PlannedInput plannedInput(const BuildOptions& options, const DatabaseMeta& meta, const raster::RasterInfo& info) {
  const tiling::Tiling tiling(meta.scheme);
  PlannedInput input{.path = info.path,
                     .depth = raster::levelOfSpacing(tiling, meta.tileCells, info.finestSpacing),
                     .footprint = {},
                     .bounds = info.bounds,
                     .files = info.files,
                     .signature = {}};
  input.signature = signatureOf(input);
  if (options.maxLevel && *options.maxLevel < input.depth) {
    input.depth = *options.maxLevel;
    input.footprint = tiling.metrics(input.depth).meanEdge / meta.tileCells;
  }
  return input;
}

/// 0, floating point, wins; else the finer step.
double finerStep(std::optional<double> soFar, double step) {
  if (!soFar) return step;
  return *soFar == 0.0 || step == 0.0 ? 0.0 : std::min(*soFar, step);
}

/// Lays one input's facts over the plan.
io::Result<void> addInput(const BuildOptions& options, raster::RasterInfo info, bool isFirst, BuildPlan& plan) {
  if (options.region) {
    const auto within = shared(info.bounds, *options.region);
    if (!within) {
      return io::fail(Code::invalidArgument, "lies wholly beside the region that is asked for: leave it out",
                      info.path);
    }
    info.bounds = *within;
  }
  if (isFirst) {
    plan.meta.body = info.body;
    plan.meta.bounds = info.bounds;
  } else if (!(plan.meta.body.ellipsoid == info.body.ellipsoid)) {
    return io::fail(Code::invalidArgument,
                    fmt::format("lies on {}, but what is below it on {}; say --body if one of them is wrong",
                                info.body.name, plan.meta.body.name),
                    info.path);
  } else {
    plan.meta.bounds = plan.meta.bounds.united(info.bounds);
  }
  const bool stepIsKnown = !isFirst && options.kind == raster::Kind::elevation;
  plan.meta.heightStep_m = options.kind == raster::Kind::imagery
                               ? 0.0
                               : finerStep(stepIsKnown ? std::optional(plan.meta.heightStep_m) : std::nullopt,
                                           heightStepFor(info.heightQuantum_m));
  plan.meta.sources.push_back(storedName(info.path));
  plan.inputs.push_back(plannedInput(options, plan.meta, info));
  plan.deepestLevel = std::max(plan.deepestLevel, plan.inputs.back().depth);
  for (const std::string& warning : info.warnings)
    plan.warnings.push_back(info.path + ": " + warning);
  return {};
}

/// How far above the deepest level blocks begin. Elevation: as far as errors are compared, so that no tile is decoded
/// for them. Imagery: enough for pixels to be halved before they are compressed, and few enough for all workers to have
/// some.
int blockDepth(raster::Kind kind) {
  return kind == raster::Kind::elevation ? kComparedLevels : 2;
}

/// What of the filling only the inputs' depths tell.
void planFilling(const std::optional<DatabaseMeta>& base, BuildPlan& plan) {
  if (plan.meta.kind != raster::Kind::elevation) return;
  const int from = std::ranges::min(plan.inputs, {}, &PlannedInput::depth).depth;
  plan.meta.fillFromLevel = base ? std::min(base->fillFromLevel, from) : from;
  plan.fill = fillPlan(plan.tiling(), plan.meta.tileCells, plan.meta.body, plan.meta.fillVoids_m,
                       plan.meta.fillFromLevel, plan.deepestLevel);
  if (base) plan.fill.baseFromLevel = base->fillFromLevel;
}

}  // namespace

std::optional<TileFormat> tileFormatByName(std::string_view name) {
  for (const TileFormat format : {TileFormat::jpeg, TileFormat::png, TileFormat::webp}) {
    if (nameOf(format) == name) return format;
  }
  return std::nullopt;
}

std::string_view nameOf(TileFormat format) {
  switch (format) {
    case TileFormat::jpeg:
      return "jpeg";
    case TileFormat::png:
      return "png";
    case TileFormat::webp:
      return "webp";
  }
  return "?";
}

bool BuildPlan::fills() const {
  if (base) return true;
  if (meta.fillVoids_m == 0.0) return false;
  return std::ranges::any_of(inputs, [&](const PlannedInput& input) { return input.depth != deepestLevel; });
}

std::string signatureOf(const PlannedInput& input) {
  std::string text = storedName(input.path) + "|" + signatureOfFile(input.path);
  for (const std::string& file : input.files)
    text += "|" + signatureOfFile(file);
  return text;
}

double heightStepFor(double heightQuantum_m) {
  if (!(heightQuantum_m > 0.0) || !std::isfinite(heightQuantum_m)) return 0.0;
  return std::exp2(std::floor(std::log2(heightQuantum_m / 16.0)));
}

io::Result<BuildPlan> planBuild(const BuildOptions& options, const std::optional<DatabaseMeta>& base) {
  if (auto ok = checkOptions(options); !ok) return tl::unexpected(ok.error());
  BuildPlan plan;
  plan.region = options.region;
  plan.format = options.format;
  plan.rasterOptions = {.nodata = options.nodata, .body = options.body, .cacheBytes = 0};
  if (base) {
    if (auto ok = checkBase(options, *base); !ok) return tl::unexpected(ok.error());
    plan.meta = *base;
    plan.meta.complete = false;
    plan.base = options.output;
    plan.deepestLevel = base->maxLevel;
  } else {
    plan.meta.kind = options.kind;
    plan.meta.scheme = options.scheme;
    if (options.kind == raster::Kind::elevation)
      plan.meta.fillVoids_m = options.fillVoids_m.value_or(kFillWithoutLimit_m);
    plan.meta.tileCells = options.kind == raster::Kind::elevation ? raster::kElevationCells : raster::kImageryPixels;
  }
  std::string signatures;
  for (const std::string& path : options.inputs) {
    if (auto ok = checkInput(path); !ok) return tl::unexpected(ok.error());
    const auto file = raster::RasterFile::open(path, options.kind, plan.rasterOptions);
    if (!file) return tl::unexpected(file.error());
    const bool isFirst = !base && plan.inputs.empty();
    if (auto ok = addInput(options, file->info(), isFirst, plan); !ok) return tl::unexpected(ok.error());
    signatures += "\n" + plan.inputs.back().signature;
  }
  plan.meta.maxLevel = plan.deepestLevel;
  planFilling(base, plan);
  if (!base && !plan.fills()) plan.blockLevel = std::max(0, plan.deepestLevel - blockDepth(plan.meta.kind));
  plan.meta.requestKey = requestKeyOf(options, plan.meta, signatures);
  plan.meta.buildKey = base ? digestOf(base->buildKey + plan.meta.requestKey) : plan.meta.requestKey;
  return plan;
}

}  // namespace tellurion::pyramid
