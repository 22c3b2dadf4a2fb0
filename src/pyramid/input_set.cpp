#include "pyramid/input_set.h"

#include <algorithm>

namespace tellurion::pyramid {

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
