#include "pyramid/export_samples.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

namespace tellurion::pyramid {
namespace {

constexpr double kCoarser = 1.1;  // a grid of 90 degrees a tile fits a face of a cube
constexpr std::size_t kMostCovered = 4096;

/// Asks a query for all places of a grid, rows of one level together; put(i, answer) takes what it says.
template <class Answer, class Query, class Question, class Put>
io::Result<void> ask(const Query& query, const ExportSamples& samples, const PlaceGrid& grid, int deepest,
                     Question question, const Put& put) {
  const std::size_t width = grid.longitudes_degrees.size();
  const std::size_t rows = grid.latitudes_degrees.size();
  std::vector<geo::Direction> places;
  std::vector<std::optional<Answer>> answers;
  for (std::size_t first = 0; first < rows;) {
    const int level = samples.levelFor(grid.steps_degrees[first]);
    std::size_t end = first;
    places.clear();
    for (; end < rows && samples.levelFor(grid.steps_degrees[end]) == level; ++end)
      for (const double longitude : grid.longitudes_degrees)
        places.push_back(geo::directionFromDegrees(grid.latitudes_degrees[end], longitude));
    answers.assign(places.size(), std::nullopt);
    question.level = std::min(level, deepest);
    if (auto ok = query.at(places, std::span(answers), question); !ok) return ok;
    for (std::size_t i = 0; i < answers.size(); ++i)
      if (answers[i]) put(first * width + i, *answers[i]);
    first = end;
  }
  return {};
}

struct Covered {
  tiling::TileId id;
  std::uint8_t childMask = 0;
  float min_m = raster::kNoData;
  float max_m = raster::kNoData;
};

io::Result<std::optional<Covered>> coveredBy(const raster::TileSource& source, const tiling::TileId& id) {
  if (source.info().kind == raster::Kind::imagery) {
    const auto presence = source.lookUp(id);
    if (!presence) return tl::unexpected(presence.error());
    if (!presence->stored) return std::optional<Covered>{};
    return Covered{.id = id, .childMask = presence->childMask};
  }
  const auto tile = source.load(id);
  if (!tile) return tl::unexpected(tile.error());
  if (!*tile) return std::optional<Covered>{};
  return Covered{.id = id,
                 .childMask = (*tile)->childMask,
                 .min_m = (*tile)->statistics.min_m,
                 .max_m = (*tile)->statistics.max_m};
}

}  // namespace

io::Result<std::unique_ptr<const ExportSamples>> ExportSamples::open(const std::filesystem::path& path) {
  auto reader = PyramidReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  std::unique_ptr<ExportSamples> samples(new ExportSamples);
  samples->source_ = *reader;
  if ((*reader)->info().kind == raster::Kind::elevation) {
    auto query = HeightQuery::create(*reader);
    if (!query) return tl::unexpected(query.error());
    samples->heights_.emplace(std::move(*query));
  } else {
    auto query = ColourQuery::create(*reader);
    if (!query) return tl::unexpected(query.error());
    samples->colours_.emplace(std::move(*query));
  }
  return std::unique_ptr<const ExportSamples>(std::move(samples));
}

double ExportSamples::spacing_degrees(int level) const {
  return tiling::Tiling(info().scheme).metrics(level).meanEdge.degrees() / info().tileCells;
}

int ExportSamples::levelFor(double step_degrees) const {
  int level = 0;
  while (level < info().maxLevel && spacing_degrees(level) > kCoarser * step_degrees)
    ++level;
  return level;
}

io::Result<raster::Raster<float>> ExportSamples::heights(const PlaceGrid& grid, int deepest) const {
  raster::Raster<float> out(static_cast<int>(grid.longitudes_degrees.size()),
                            static_cast<int>(grid.latitudes_degrees.size()), raster::kNoData);
  const auto put = [&](std::size_t i, const HeightAnswer& answer) {
    out.samples[i] = static_cast<float>(answer.height_m);
  };
  if (auto ok = ask<HeightAnswer>(*heights_, *this, grid, deepest, HeightQuestion{}, put); !ok)
    return tl::unexpected(ok.error());
  return out;
}

io::Result<raster::Raster<raster::Rgba8>> ExportSamples::colours(const PlaceGrid& grid, int deepest) const {
  raster::Raster<raster::Rgba8> out(static_cast<int>(grid.longitudes_degrees.size()),
                                    static_cast<int>(grid.latitudes_degrees.size()));
  const auto put = [&](std::size_t i, const ColourAnswer& answer) { out.samples[i] = answer.colour; };
  if (auto ok = ask<ColourAnswer>(*colours_, *this, grid, deepest, ColourQuestion{}, put); !ok)
    return tl::unexpected(ok.error());
  return out;
}

io::Result<std::uint64_t> ExportSamples::storedTiles() const {
  const auto summary = source_->summary();
  if (!summary) return tl::unexpected(summary.error());
  std::uint64_t tiles = 0;
  for (const LevelSummary& level : summary->levels)
    tiles += level.tiles;
  return tiles;
}

io::Result<std::vector<CoveredRect>> ExportSamples::coverage() const {
  const tiling::Tiling tiling(info().scheme);
  std::vector<Covered> level;
  for (int root = 0; root < tiling.rootCount(); ++root) {
    const auto found = coveredBy(*source_, {.level = 0, .root = static_cast<std::uint8_t>(root), .x = 0, .y = 0});
    if (!found) return tl::unexpected(found.error());
    if (*found) level.push_back(**found);
  }
  std::vector<CoveredRect> ends;  // where no deeper tile is
  const auto add = [&](const tiling::TileId& id, const Covered& values) {
    ends.push_back({.rect = tiling.bounds(id), .min_m = values.min_m, .max_m = values.max_m});
  };
  while (!level.empty() && ends.size() + 4 * level.size() <= kMostCovered) {
    std::vector<Covered> below;
    for (const Covered& tile : level) {
      for (int q = 0; q < 4; ++q) {
        const tiling::TileId id = tile.id.level < tiling::kMaxLevel ? tile.id.child(q) : tile.id;
        if (((tile.childMask >> q) & 1) == 0) {
          add(id, tile);
          continue;
        }
        const auto found = coveredBy(*source_, id);
        if (!found) return tl::unexpected(found.error());
        if (*found) below.push_back(**found);
      }
    }
    level = std::move(below);
  }
  for (const Covered& tile : level)
    add(tile.id, tile);
  return ends;
}

}  // namespace tellurion::pyramid
