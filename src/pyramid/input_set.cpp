#include "pyramid/input_set.h"

#include <algorithm>

#include "pyramid/imagery_cleaning.h"
#include "raster/tile_places.h"

namespace tellurion::pyramid {
namespace {

/// Of samples of an imagery tile. Those that no single place owns get any: an input has nothing there.
std::vector<geo::Direction> placesOf(const tiling::Tiling& tiling, const tiling::TileId& id, int cells,
                                     std::span<const std::size_t> indices) {
  const auto side = static_cast<std::size_t>(raster::sideOf(raster::Kind::imagery, cells));
  std::vector<geo::Direction> places(indices.size());
  std::ranges::transform(indices, places.begin(), [&](std::size_t i) {
    return raster::placeOf(tiling, id, raster::Kind::imagery, cells, static_cast<int>(i % side),
                           static_cast<int>(i / side))
        .value_or(geo::Direction{});
  });
  return places;
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

/// The input's heights, which are above its vertical datum, as heights above the ellipsoid.
io::Result<void> InputSet::heightsAboveDatum(int input, raster::RasterFile& file,
                                             std::span<const geo::Direction> places, std::span<float> out) {
  const auto index = static_cast<std::size_t>(input);
  std::vector<float> heights(places.size(), raster::kNoData);
  if (auto ok = file.sampleHeights(places, plan_.inputs[index].footprint, heights); !ok) return ok;
  std::vector<std::size_t> found;
  std::vector<geo::Direction> foundPlaces;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    if (raster::isNoData(heights[i])) continue;
    found.push_back(i);
    foundPlaces.push_back(places[i]);
  }
  std::optional<raster::VerticalDatum>& datum = files_[index].datum;
  if (!datum) {
    auto opened = raster::VerticalDatum::open(plan_.verticalDatum, file.info().body, file.info().bounds);
    if (!opened) return tl::unexpected(opened.error());
    datum.emplace(std::move(*opened));
  }
  std::vector<double> zeros(found.size());
  if (auto ok = datum->heightsOfZero(foundPlaces, zeros); !ok) {
    ok.error().where = file.info().path;
    return ok;
  }
  for (std::size_t i = 0; i < found.size(); ++i)
    out[found[i]] = static_cast<float>(static_cast<double>(heights[found[i]]) + zeros[i]);
  return {};
}

io::Result<void> InputSet::heights(std::span<const int> inputs, std::span<const geo::Direction> places,
                                   std::span<float> out) {
  for (const int input : inputs) {
    const auto opened = file(input);
    if (!opened) return tl::unexpected(opened.error());
    const geo::Angle footprint = plan_.inputs[static_cast<std::size_t>(input)].footprint;
    auto ok = plan_.verticalDatum.empty() ? (*opened)->sampleHeights(places, footprint, out)
                                          : heightsAboveDatum(input, **opened, places, out);
    if (!ok) return ok;
  }
  return {};
}

io::Result<void> InputSet::colours(std::span<const int> inputs, const tiling::TileId& id,
                                   std::span<const std::size_t> indices, std::span<raster::Rgba8> out) {
  const tiling::Tiling tiling = plan_.tiling();
  const auto places =
      plan_.cleaned ? placesOf(tiling, id, plan_.meta.tileCells, indices) : std::vector<geo::Direction>();
  std::vector<raster::Rgba8> own(places.size());
  for (const int input : inputs) {
    const auto opened = file(input);
    if (!opened) return tl::unexpected(opened.error());
    const geo::Angle footprint = plan_.inputs[static_cast<std::size_t>(input)].footprint;
    std::ranges::fill(own, raster::Rgba8{});
    const std::span<raster::Rgba8> target = plan_.cleaned ? own : out;
    auto ok = (*opened)->sampleTile(tiling, id, plan_.meta.tileCells, indices, footprint, target);
    if (!ok) return ok;
    if (plan_.cleaned) plan_.cleaned->lay(input, places, own, out);
  }
  return {};
}

io::Result<void> InputSet::coloursAt(int input, std::span<const geo::Direction> places, geo::Angle footprint,
                                     std::span<raster::Rgba8> out) {
  const auto opened = file(input);
  if (!opened) return tl::unexpected(opened.error());
  return (*opened)->sampleColours(places, footprint, out);
}

io::Result<bool> InputSet::mayTouch(int input, const tiling::TileId& id, geo::Angle within) {
  if (files_.size() > mostOpen_) return true;
  const auto opened = file(input);
  if (!opened) return tl::unexpected(opened.error());
  return (*opened)->mayTouch(plan_.tiling(), id, within);
}

}  // namespace tellurion::pyramid
