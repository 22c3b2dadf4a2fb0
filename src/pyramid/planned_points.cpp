#include "pyramid/planned_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <new>
#include <utility>

namespace tellurion::pyramid {
namespace {

using Code = io::Failure::Code;

/// With the cells that they are found by.
constexpr std::uint64_t kBytesEach = raster::ScatteredPoints::kBytesEach + 4;
constexpr std::uint64_t kMostCacheBytes = std::uint64_t{128} << 20u;  ///< blocks of a million points
constexpr std::uint64_t kLeastTextOfAPoint = 5;                       ///< "1,2,3"

/// The cube's cells that are as wide as samples of the deepest level that is wanted.
int mergeLevelOf(const BuildOptions& options, int tileCells) {
  if (!options.maxLevel) return tiling::kMaxLevel;
  const geo::Angle sample = tiling::Tiling(options.scheme).metrics(*options.maxLevel).meanEdge / tileCells;
  const tiling::Tiling cube(tiling::Scheme::cube);
  int level = 0;
  while (level < tiling::kMaxLevel && cube.metrics(level).meanEdge > sample)
    ++level;
  return level;
}

/// Memory that is never written to is never taken; a vector that grows would take all twice.
io::Result<std::vector<raster::PackedPoint>> roomForPoints(const std::string& path, std::uint64_t most) {
  std::vector<raster::PackedPoint> points;
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  const std::uint64_t expected = error ? 0 : std::min<std::uint64_t>(most, size / kLeastTextOfAPoint + 1);
  try {
    points.reserve(static_cast<std::size_t>(expected));
  } catch (const std::bad_alloc&) {
    return io::fail(Code::invalidArgument, "holds more points than this machine has memory for", path);
  }
  return points;
}

std::string tooMany(std::uint64_t most) {
  return fmt::format(
      "holds more than the {} points that a quarter of --memory has room for: give it more ({} bytes a point), or "
      "build "
      "parts of the layer one after the other with --append. The ground of each ends where its points do, so parts "
      "have "
      "to overlap by some spacings, or gaps are left between them",
      most, 4 * kBytesEach);
}

std::uint64_t bytesOfPlanned(const BuildPlan& plan) {
  std::uint64_t bytes = 0;
  const raster::PointGround* counted = nullptr;
  for (const PlannedInput& input : plan.inputs) {
    if (input.ground && input.ground.get() != counted) bytes += input.ground->points().size() * kBytesEach;
    if (input.ground) counted = input.ground.get();
  }
  return bytes;
}

}  // namespace

raster::RasterInfo PointInput::infoOf(int spacingLevel) const {
  raster::RasterInfo info;
  info.path = path;
  info.files = layer.files;
  info.bounds = ground->bounds(spacingLevel);
  info.finestSpacing = raster::ScatteredPoints::spacingOf(spacingLevel);
  info.body = layer.body;
  info.warnings = layer.warnings;
  return info;
}

io::Result<PointInput> openPointGround(const std::string& path, const BuildOptions& options, const BuildPlan& plan) {
  if (options.kind != raster::Kind::elevation) {
    return io::fail(Code::invalidArgument, "holds points, of which elevation is made: say --kind elevation", path);
  }
  const std::uint64_t held = bytesOfPlanned(plan);
  const std::uint64_t most = options.memoryBytes / 4 > held ? (options.memoryBytes / 4 - held) / kBytesEach : 0;
  auto points = roomForPoints(path, most);
  if (!points) return tl::unexpected(std::move(points.error()));
  const raster::PointSink keep = [&](const geo::Direction& place, float height_m) -> io::Result<void> {
    if (points->size() >= most) return io::fail(Code::invalidArgument, tooMany(most), path);
    points->push_back(raster::packedPoint(place, height_m));
    return {};
  };
  auto layer = raster::readPoints(path, plan.rasterOptions, options.points, keep);
  if (!layer) return tl::unexpected(std::move(layer.error()));
  raster::ScatteredPoints scattered(std::move(*points), mergeLevelOf(options, plan.meta.tileCells));
  if (scattered.spacingLevels().empty()) {
    return io::fail(Code::invalidArgument,
                    fmt::format("its {} points cover no ground: at least 16 of them have to lie near each other, and "
                                "not along a line",
                                scattered.size()),
                    path);
  }
  return PointInput{.path = path,
                    .layer = std::move(*layer),
                    .ground = std::make_shared<const raster::PointGround>(
                        std::move(scattered), std::min(options.memoryBytes / 8, kMostCacheBytes))};
}

std::uint64_t bytesOfPoints(const raster::PointGround& ground) {
  return ground.points().size() * kBytesEach + ground.cacheBytes();
}

}  // namespace tellurion::pyramid
