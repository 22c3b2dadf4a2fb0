#include "pyramid/input_set.h"

#include <algorithm>

#include "pyramid/imagery_cleaning.h"
#include "raster/tile_places.h"

namespace tellurion::pyramid {
namespace {

/// Where samples of a tile lie. Those that no single place owns get any: an input has nothing there.
std::vector<geo::Direction> placesOf(const BuildPlan& plan, const tiling::TileId& id,
                                     std::span<const std::size_t> indices) {
  const tiling::Tiling tiling = plan.tiling();
  const auto side = static_cast<std::size_t>(raster::sideOf(plan.meta.kind, plan.meta.tileCells));
  std::vector<geo::Direction> places(indices.size());
  std::ranges::transform(indices, places.begin(), [&](std::size_t i) {
    return raster::placeOf(tiling, id, plan.meta.kind, plan.meta.tileCells, static_cast<int>(i % side),
                           static_cast<int>(i / side))
        .value_or(geo::Direction{});
  });
  return places;
}

bool holds(const geo::GeoRect& outer, const geo::GeoRect& inner) {
  if (inner.south < outer.south || inner.north > outer.north) return false;
  if (outer.width >= geo::Angle::degrees(360.0)) return true;
  geo::Angle from = geo::wrappedLongitude(inner.west - outer.west);
  if (from < geo::Angle()) from = from + geo::Angle::degrees(360.0);
  return from + inner.width <= outer.width;
}

/// Which of the samples lie in the region that is built, as indices into `indices`; nothing: all.
std::optional<std::vector<std::size_t>> insideOfRegion(const BuildPlan& plan, const tiling::TileId& id,
                                                       std::span<const std::size_t> indices) {
  if (!plan.region) return std::nullopt;
  const tiling::Tiling tiling = plan.tiling();
  const geo::Angle gutter = tiling.metrics(id.level).largestEdge * (2.0 / plan.meta.tileCells);
  if (holds(*plan.region, tiling.bounds(id).grown(gutter))) return std::nullopt;
  const auto side = static_cast<std::size_t>(raster::sideOf(plan.meta.kind, plan.meta.tileCells));
  std::vector<std::size_t> inside;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const auto place = raster::placeOf(tiling, id, plan.meta.kind, plan.meta.tileCells,
                                       static_cast<int>(indices[i] % side), static_cast<int>(indices[i] / side));
    if (!place) continue;
    const geo::Geodetic at = geo::geodeticFromDirection(*place);
    if (plan.region->contains(at.lat, at.lon)) inside.push_back(i);
  }
  return inside;
}

}  // namespace

void InputSet::collectWarnings(const raster::RasterFile& file, std::set<std::string>& warnings) {
  for (const std::string& warning : file.info().warnings)
    warnings.insert(file.info().path + ": " + warning);
}

std::set<std::string> InputSet::warnings() const {
  std::set<std::string> warnings = warnings_;
  for (const Slot& slot : files_) {
    if (slot.file) collectWarnings(*slot.file, warnings);
  }
  return warnings;
}

void InputSet::closeOldest() {
  const auto age = [](const Slot& slot) { return slot.file ? slot.lastUse : UINT64_MAX; };
  const auto oldest = std::ranges::min_element(files_, {}, age);
  collectWarnings(*oldest->file, warnings_);
  oldest->file.reset();
  --openFiles_;
}

io::Result<raster::RasterFile*> InputSet::file(int input) {
  Slot& slot = files_[static_cast<std::size_t>(input)];
  slot.lastUse = ++uses_;
  if (slot.file) return &*slot.file;
  if (openFiles_ >= mostOpen_) closeOldest();
  const PlannedInput& from = planned(input);
  if (auto ok = checkUnchanged(from.files); !ok) return tl::unexpected(ok.error());
  raster::RasterOptions options = plan_.rasterOptions;
  options.cacheBytes = cacheBytes_;
  auto opened = raster::RasterFile::open(from.path, plan_.meta.kind, options);
  if (!opened) return tl::unexpected(opened.error());
  slot.file.emplace(std::move(*opened));
  ++openFiles_;
  return &*slot.file;
}

template <class T>
io::Result<void> InputSet::laid(std::span<const int> inputs, const tiling::TileId& id,
                                std::span<const std::size_t> indices, std::span<T> out) {
  const auto within = insideOfRegion(plan_, id, indices);
  if (within && within->size() < indices.size()) {
    std::vector<std::size_t> some(within->size());
    std::vector<T> values(within->size());
    for (std::size_t i = 0; i < some.size(); ++i) {
      some[i] = indices[(*within)[i]];
      values[i] = out[(*within)[i]];
    }
    if (auto ok = sampled(inputs, id, some, std::span(values)); !ok) return ok;
    for (std::size_t i = 0; i < some.size(); ++i)
      out[(*within)[i]] = values[i];
    return {};
  }
  return sampled(inputs, id, indices, out);
}

io::Result<void> InputSet::sampled(std::span<const int> inputs, const tiling::TileId& id,
                                   std::span<const std::size_t> indices, std::span<float> out) {
  if (indices.empty()) return {};
  const bool isMoved = !plan_.verticalDatum.empty();
  const bool hasPoints = std::ranges::any_of(inputs, [&](int input) { return planned(input).ground != nullptr; });
  const auto places = isMoved || hasPoints ? placesOf(plan_, id, indices) : std::vector<geo::Direction>();
  std::vector<float> own(isMoved ? indices.size() : 0);
  for (const int input : inputs) {
    std::ranges::fill(own, raster::kNoData);
    auto ok = ofOne(input, id, indices, places, isMoved ? own : out);
    if (ok && isMoved) ok = layAboveDatum(input, places, own, out);
    if (!ok) return ok;
  }
  return {};
}

/// Heights of an input as they are stored.
io::Result<void> InputSet::ofOne(int input, const tiling::TileId& id, std::span<const std::size_t> indices,
                                 std::span<const geo::Direction> places, std::span<float> out) {
  const PlannedInput& from = planned(input);
  if (from.ground) return from.ground->sampleHeights(from.spacingLevel, places, out);
  const auto opened = file(input);
  if (!opened) return tl::unexpected(opened.error());
  return (*opened)->sampleTile(plan_.tiling(), id, plan_.meta.tileCells, indices, from.footprint, out);
}

io::Result<void> InputSet::sampled(std::span<const int> inputs, const tiling::TileId& id,
                                   std::span<const std::size_t> indices, std::span<raster::Rgba8> out) {
  if (indices.empty()) return {};
  const auto places = plan_.cleaned ? placesOf(plan_, id, indices) : std::vector<geo::Direction>();
  std::vector<raster::Rgba8> own(places.size());
  for (const int input : inputs) {
    const auto opened = file(input);
    if (!opened) return tl::unexpected(opened.error());
    const geo::Angle footprint = planned(input).footprint;
    std::ranges::fill(own, raster::Rgba8{});
    const std::span<raster::Rgba8> target = plan_.cleaned ? own : out;
    auto ok = (*opened)->sampleTile(plan_.tiling(), id, plan_.meta.tileCells, indices, footprint, target);
    if (!ok) return ok;
    if (plan_.cleaned) plan_.cleaned->lay(input, places, own, out);
  }
  return {};
}

/// Lays an input's heights, which are above its vertical datum, as heights above the ellipsoid.
io::Result<void> InputSet::layAboveDatum(int input, std::span<const geo::Direction> places,
                                         std::span<const float> heights, std::span<float> out) {
  const auto index = static_cast<std::size_t>(input);
  std::vector<std::size_t> found;
  std::vector<geo::Direction> foundPlaces;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    if (raster::isNoData(heights[i])) continue;
    found.push_back(i);
    foundPlaces.push_back(places[i]);
  }
  std::optional<raster::VerticalDatum>& datum = files_[index].datum;
  if (!datum) {
    auto opened = raster::VerticalDatum::open(plan_.verticalDatum, plan_.meta.body, planned(input).bounds);
    if (!opened) return tl::unexpected(opened.error());
    datum.emplace(std::move(*opened));
  }
  std::vector<double> zeros(found.size());
  if (auto ok = datum->heightsOfZero(foundPlaces, zeros); !ok) {
    ok.error().where = planned(input).path;
    return ok;
  }
  for (std::size_t i = 0; i < found.size(); ++i)
    out[found[i]] = static_cast<float>(static_cast<double>(heights[found[i]]) + zeros[i]);
  return {};
}

io::Result<void> InputSet::coloursAt(int input, std::span<const geo::Direction> places, geo::Angle footprint,
                                     std::span<raster::Rgba8> out) {
  const auto opened = file(input);
  if (!opened) return tl::unexpected(opened.error());
  return (*opened)->sampleColours(places, footprint, out);
}

io::Result<void> InputSet::heights(std::span<const int> inputs, const tiling::TileId& id,
                                   std::span<const std::size_t> indices, std::span<float> out) {
  return laid(inputs, id, indices, out);
}

io::Result<void> InputSet::colours(std::span<const int> inputs, const tiling::TileId& id,
                                   std::span<const std::size_t> indices, std::span<raster::Rgba8> out) {
  return laid(inputs, id, indices, out);
}

io::Result<bool> InputSet::mayTouch(int input, const tiling::TileId& id, geo::Angle within) {
  const PlannedInput& asked = planned(input);
  if (asked.ground) return asked.ground->mayTouch(asked.spacingLevel, plan_.tiling(), id, within);
  if (files_.size() > mostOpen_) return true;
  const auto opened = file(input);
  if (!opened) return tl::unexpected(opened.error());
  return (*opened)->mayTouch(plan_.tiling(), id, within);
}

}  // namespace tellurion::pyramid
