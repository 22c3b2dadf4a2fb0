#include "pyramid/build_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "geo/shared_rect.h"
#include "pyramid/bounded_heights.h"
#include "pyramid/database_file.h"
#include "pyramid/geometric_error.h"
#include "pyramid/imagery_cleaning.h"
#include "pyramid/planned_points.h"
#include "pyramid/text_digest.h"
#include "raster/live_tiles.h"
#include "raster/point_layer.h"
#include "raster/vertical_datum.h"

namespace tellurion::pyramid {
namespace {

using Code = io::Failure::Code;

/// Part of every key: raised where the same inputs would give other bytes. 3: small pages of elevation, and HEALPix
/// imagery by its mean spacing.
int builderVersionOf(const DatabaseMeta& meta) {
  return meta.kind == raster::Kind::elevation || meta.scheme == tiling::Scheme::healpix ? 3 : 2;
}

/// The same for what is made of points.
constexpr const char* kPointsVersion = "|points 1";

/// How an input is named in the database and in its key: the same for "a.tif" and "./a.tif".
std::string storedName(const std::string& path) {
  return std::filesystem::path(path).lexically_normal().string();
}

std::string keyOfCleaning(const CleaningOptions& cleaning) {
  if (!cleaning.asksForAnything()) return {};
  std::string text = fmt::format("|clean {} {:a} {}", cleaning.matchColours, cleaning.feather_m, cleaning.clouds);
  for (const std::string& file : cleaning.cutAt)
    text += " " + stampOf(file).text;
  return text;
}

std::string keyOfPoints(const raster::PointOptions& points) {
  if (!points.asksForAnything()) return {};
  std::string text = "|points " + points.reference;
  for (const std::string& column : points.columns)
    text += "|" + column;
  return text;
}

std::string requestKeyOf(const BuildOptions& options, const DatabaseMeta& meta, const std::string& inputs,
                         int version) {
  std::string text =
      fmt::format("{}|{}|{}|{}|{}|{}|{:a}|{:a}|{}", version, formatVersionOf(meta.scheme), options.append,
                  nameOf(meta.kind), tiling::nameOf(meta.scheme), meta.body.name, meta.body.ellipsoid.semiMajorAxis_m(),
                  meta.body.ellipsoid.flattening(), options.maxLevel.value_or(-1));
  if (meta.kind == raster::Kind::elevation) text += fmt::format("|fill {:a}", meta.fillVoids_m);
  if (meta.maxError_m > 0.0) text += fmt::format("|error {:a}", meta.maxError_m);
  text += keyOfCleaning(options.cleaning);
  if (!options.verticalDatum.empty()) text += "|datum " + options.verticalDatum;
  text += keyOfPoints(options.points);
  if (meta.kind == raster::Kind::imagery) text += fmt::format("|{}", nameOf(options.format));
  if (options.region) {
    text += fmt::format("|region {:a} {:a} {:a} {:a}", options.region->west.radians(), options.region->south.radians(),
                        options.region->width.radians(), options.region->north.radians());
  }
  if (options.nodata) text += fmt::format("|nodata {:a}", *options.nodata);
  return digestOf(text + inputs);
}

constexpr double kMostFeather_m = 1e7;

io::Result<void> checkCleaning(const BuildOptions& options) {
  const CleaningOptions& cleaning = options.cleaning;
  if (!(cleaning.feather_m >= 0.0 && cleaning.feather_m <= kMostFeather_m)) {
    return io::fail(Code::invalidArgument,
                    fmt::format("seams are feathered over 0 to {:g} m, not {}", kMostFeather_m, cleaning.feather_m));
  }
  if (!cleaning.asksForAnything()) return {};
  if (options.kind == raster::Kind::elevation) {
    return io::fail(Code::invalidArgument,
                    "only imagery is cleaned: leave --match-colours, --feather, --cut and --clouds out");
  }
  const bool compares = cleaning.matchColours || cleaning.clouds;
  if (compares && (options.append || options.inputs.size() < 2)) {
    return io::fail(Code::invalidArgument,
                    "--match-colours and --clouds compare inputs of one build with each other: name at least two, the "
                    "clear or filling one first, without --append");
  }
  if (!options.append && options.inputs.size() < 2) {
    return io::fail(Code::invalidArgument,
                    "--feather and --cut show what is below an input, and below the first there is nothing: name what "
                    "lies below first, or lay it over a database with --append");
  }
  return {};
}

io::Result<void> checkPoints(const BuildOptions& options) {
  const std::size_t columns = options.points.columns.size();
  if (options.points.asksForAnything() && options.kind == raster::Kind::imagery) {
    return io::fail(Code::invalidArgument,
                    "only elevation is made of points: leave --points-columns and --points-srs out");
  }
  if (columns != 0 && columns != 1 && columns != 3) {
    return io::fail(
        Code::invalidArgument,
        fmt::format("--points-columns names one column, the height's, or three, x, y and height; not {}", columns));
  }
  return {};
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
  if (options.maxError_m && !(*options.maxError_m > 0.0 && *options.maxError_m <= kMostMaxError_m)) {
    return io::fail(Code::invalidArgument, fmt::format("heights may be off by more than 0 and at most {:g} m, not {}",
                                                       kMostMaxError_m, *options.maxError_m));
  }
  if (options.maxError_m && options.kind == raster::Kind::imagery) {
    return io::fail(Code::invalidArgument, "only elevation has heights that may be off: leave --max-error out");
  }
  if (!options.verticalDatum.empty() && options.kind == raster::Kind::imagery) {
    return io::fail(Code::invalidArgument, "only elevation has a vertical datum: leave --vertical-datum out");
  }
  if (auto ok = checkPoints(options); !ok) return ok;
  if (auto ok = checkCleaning(options); !ok) return ok;
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
  if (options.maxError_m && *options.maxError_m != base.maxError_m) {
    return io::fail(
        Code::invalidArgument,
        base.maxError_m > 0.0
            ? fmt::format(
                  "was built with --max-error {:g}, and what is appended is stored alike: leave the option out, "
                  "or build the database again with the other one",
                  base.maxError_m)
            : "was built without --max-error, and what is appended is stored alike: leave the option out, or build the "
              "database again with it",
        where);
  }
  return {};
}

io::Failure whileOpened(io::Failure failure) {
  failure.message = failure.code == Code::notFound ? "there is no such file any more"
                                                   : "changed while it was opened; run the same command again when "
                                                     "nothing writes it any more";
  return failure;
}

io::Result<void> checkInput(const std::string& path) {
  if (!isTileDatabaseFile(path)) return {};
  return io::fail(
      Code::invalidArgument,
      "is a tile database, and a build takes rasters: name the rasters that it was made of ('tellurion info' "
      "lists them), or show it as it is, with others joined by commas ('tellurion view A.tdb,B.tdb')",
      path);
}

PlannedInput plannedInput(const BuildOptions& options, const DatabaseMeta& meta, const raster::RasterInfo& info,
                          const geo::GeoRect& within) {
  const tiling::Tiling tiling(meta.scheme);
  PlannedInput input{.path = info.path,
                     .depth = raster::levelOfSpacing(tiling, meta.tileCells, info.finestSpacing, meta.kind),
                     .footprint = {},
                     .bounds = within,
                     .extent = info.bounds,
                     .spacing = info.finestSpacing,
                     .files = {stampOf(info.path)},
                     .ground = nullptr,
                     .spacingLevel = 0};
  for (const std::string& file : info.files)
    input.files.push_back(stampOf(file));
  if (options.maxLevel && *options.maxLevel < input.depth) {
    input.depth = *options.maxLevel;
    input.footprint = tiling.metrics(input.depth).meanEdge / meta.tileCells;
    input.spacing = std::max(input.spacing, input.footprint);
  }
  return input;
}

std::string signatureOf(const PlannedInput& input) {
  std::string text = storedName(input.path);
  for (const FileStamp& file : input.files) {
    if (!file.text.empty()) text += "|" + file.text;
  }
  return text;
}

/// 0, floating point, wins; else the finer step.
double finerStep(std::optional<double> soFar, double step) {
  if (!soFar) return step;
  return *soFar == 0.0 || step == 0.0 ? 0.0 : std::min(*soFar, step);
}

/// Lays one input's facts over the plan.
io::Result<void> addInput(const BuildOptions& options, const raster::RasterInfo& info, bool isFirst, BuildPlan& plan) {
  const auto within = options.region ? geo::sharedRect(info.bounds, *options.region) : std::optional(info.bounds);
  if (!within) {
    return io::fail(Code::invalidArgument, "lies wholly beside the region that is asked for: leave it out", info.path);
  }
  if (isFirst) {
    plan.meta.body = info.body;
    plan.meta.bounds = *within;
  } else if (!(plan.meta.body.ellipsoid == info.body.ellipsoid)) {
    return io::fail(Code::invalidArgument,
                    fmt::format("lies on {}, but what is below it on {}; say --body if one of them is wrong",
                                info.body.name, plan.meta.body.name),
                    info.path);
  } else {
    plan.meta.bounds = plan.meta.bounds.united(*within);
  }
  const bool stepIsKnown = !isFirst && options.kind == raster::Kind::elevation;
  const auto boundedStep = options.kind == raster::Kind::elevation ? stepForError(plan.meta.maxError_m, plan.meta.body)
                                                                   : std::optional<double>(0.0);
  plan.meta.heightStep_m = boundedStep ? *boundedStep
                                       : finerStep(stepIsKnown ? std::optional(plan.meta.heightStep_m) : std::nullopt,
                                                   heightStepFor(info.heightQuantum_m));
  plan.inputs.push_back(plannedInput(options, plan.meta, info, *within));
  plan.deepestLevel = std::max(plan.deepestLevel, plan.inputs.back().depth);
  for (const std::string& warning : info.warnings)
    plan.warnings.push_back(info.path + ": " + warning);
  return {};
}

/// Whether the vertical datum can be had for an input; its grids become files that the input is read from.
io::Result<void> addVerticalDatum(const raster::RasterInfo& info, BuildPlan& plan) {
  if (plan.verticalDatum.empty()) return {};
  PlannedInput& input = plan.inputs.back();
  const auto datum = raster::VerticalDatum::open(plan.verticalDatum, info.body, input.bounds);
  if (!datum) return tl::unexpected(datum.error());
  for (const std::string& file : datum->files())
    input.files.push_back(stampOf(file));
  return {};
}

io::Result<void> addRaster(const BuildOptions& options, const std::string& path, bool isFirst, BuildPlan& plan) {
  const auto file = raster::RasterFile::open(path, options.kind, plan.rasterOptions);
  if (!file) return tl::unexpected(file.error());
  if (auto ok = addInput(options, file->info(), isFirst, plan); !ok) return ok;
  return addVerticalDatum(file->info(), plan);
}

/// The ground of each spacing as an input, coarsest first; what no ground of the region is made of is left out.
io::Result<void> addPoints(const BuildOptions& options, const std::string& path, bool isFirst, BuildPlan& plan) {
  auto layer = openPointGround(path, options, plan);
  if (!layer) return tl::unexpected(std::move(layer.error()));
  const std::size_t before = plan.inputs.size();
  for (const int level : layer->ground->points().spacingLevels()) {
    raster::RasterInfo info = layer->infoOf(level);
    const bool isLast = level == layer->ground->points().spacingLevels().back();
    const bool isBeside = options.region && !geo::sharedRect(info.bounds, *options.region);
    if (isBeside && !(isLast && plan.inputs.size() == before)) continue;
    if (plan.inputs.size() > before) info.warnings.clear();
    if (auto ok = addInput(options, info, isFirst && plan.inputs.size() == before, plan); !ok) return ok;
    plan.inputs.back().footprint = {};
    plan.inputs.back().ground = layer->ground;
    plan.inputs.back().spacingLevel = level;
    if (auto ok = addVerticalDatum(info, plan); !ok) return ok;
  }
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

std::uint64_t BuildPlan::bytesHeld(int jobs) const {
  std::uint64_t bytes = cleaned ? cleaned->bytes() : 0;
  const raster::PointGround* counted = nullptr;
  for (const PlannedInput& input : inputs) {
    if (!input.ground || input.ground.get() == counted) continue;
    counted = input.ground.get();
    bytes += bytesOfPoints(*counted);
  }
  if (counted != nullptr) bytes += static_cast<std::uint64_t>(jobs) * raster::PointGround::kBytesToMakeABlock;
  return bytes;
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
  plan.rasterOptions = {.nodata = options.nodata, .body = options.body, .sourcesAnywhere = true, .cacheBytes = 0};
  plan.verticalDatum = options.verticalDatum;
  plan.cleaning = options.cleaning;
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
    plan.meta.maxError_m = options.maxError_m.value_or(0.0);
    plan.meta.tileCells = options.kind == raster::Kind::elevation ? raster::kElevationCells : raster::kImageryPixels;
  }
  std::string signatures;
  for (const std::string& path : options.inputs) {
    if (auto ok = checkInput(path); !ok) return tl::unexpected(ok.error());
    const std::vector<FileStamp> before = {stampOf(path)};
    const bool isFirst = !base && plan.inputs.empty();
    const bool isPoints = raster::isPointFile(path, options.points);
    const auto added = isPoints ? addPoints(options, path, isFirst, plan) : addRaster(options, path, isFirst, plan);
    if (!added) return tl::unexpected(added.error());
    // Else the key would be that of other bytes, or of none.
    if (auto ok = checkUnchanged(before); !ok) return tl::unexpected(whileOpened(ok.error()));
    plan.meta.sources.push_back(storedName(path));
    signatures += "\n" + signatureOf(plan.inputs.back()) + (isPoints ? kPointsVersion : "");
  }
  plan.meta.maxLevel = plan.deepestLevel;
  planFilling(base, plan);
  if (!base && !plan.fills()) plan.blockLevel = std::max(0, plan.deepestLevel - blockDepth(plan.meta.kind));
  const auto keyOf = [&](const std::string& request) { return base ? digestOf(base->buildKey + request) : request; };
  const int version = builderVersionOf(plan.meta);
  plan.meta.requestKey = requestKeyOf(options, plan.meta, signatures, version);
  plan.meta.buildKey = keyOf(plan.meta.requestKey);
  for (int older = 1; older < version; ++older)
    plan.olderKeys.push_back(keyOf(requestKeyOf(options, plan.meta, signatures, older)));
  return plan;
}

}  // namespace tellurion::pyramid
