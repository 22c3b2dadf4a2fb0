#include "pyramid/input_set.h"

#include <algorithm>

#include "raster/tile_places.h"

namespace tellurion::pyramid {
namespace {

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
  const std::string& path = plan_.inputs[static_cast<std::size_t>(input)].path;
  raster::RasterOptions options = plan_.rasterOptions;
  options.cacheBytes = cacheBytes_;
  auto opened = raster::RasterFile::open(path, plan_.meta.kind, options);
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
    if (auto ok = sampled<T>(inputs, id, some, values); !ok) return ok;
    for (std::size_t i = 0; i < some.size(); ++i)
      out[(*within)[i]] = values[i];
    return {};
  }
  return sampled(inputs, id, indices, out);
}

template <class T>
io::Result<void> InputSet::sampled(std::span<const int> inputs, const tiling::TileId& id,
                                   std::span<const std::size_t> indices, std::span<T> out) {
  if (indices.empty()) return {};
  const tiling::Tiling tiling = plan_.tiling();
  for (const int input : inputs) {
    const auto opened = file(input);
    if (!opened) return tl::unexpected(opened.error());
    const geo::Angle footprint = plan_.inputs[static_cast<std::size_t>(input)].footprint;
    auto ok = (*opened)->sampleTile(tiling, id, plan_.meta.tileCells, indices, footprint, out);
    if (!ok) return ok;
  }
  return {};
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
  if (files_.size() > mostOpen_) return true;
  const auto opened = file(input);
  if (!opened) return tl::unexpected(opened.error());
  return (*opened)->mayTouch(plan_.tiling(), id, within);
}

}  // namespace tellurion::pyramid
