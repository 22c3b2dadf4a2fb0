#include "scene/frame_tiles.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace tellurion::scene {

void FrameTiles::begin(Frame& frame, std::span<const std::uint32_t> order) {
  frame_ = &frame;
  isSoon_ = false;
  std::swap(lastTiles_, frame.tiles);
  std::swap(lastSoon_, frame.soon);
  std::swap(lastPictures_, frame.pictures);
  std::swap(lastShown_, shown_);
  if (std::ranges::equal(order, order_)) return;
  order_.assign(order.begin(), order.end());
  lastShown_.clear();  // their pictures lie in another order
}

void FrameTiles::finish() {
  lastTiles_.clear();
  lastSoon_.clear();
  lastPictures_.clear();
  lastShown_.clear();
}

/// Null: the last frame did not have it, or with another content.
DrawnTile* FrameTiles::lastOf(const TileRecord& record) {
  const std::size_t at = record.drawnAt;
  if (at >= lastShown_.size() || lastShown_[at].content != record.content) return nullptr;
  DrawnTile& last = at < lastTiles_.size() ? lastTiles_[at] : lastSoon_[at - lastTiles_.size()];
  return last.id == record.id ? &last : nullptr;
}

DrawnTile FrameTiles::movedOver(DrawnTile& last) {
  DrawnTile out = std::move(last);
  const auto first = lastPictures_.begin() + out.firstPicture;
  out.firstPicture = static_cast<std::uint32_t>(frame_->pictures.size());
  std::move(first, first + out.pictureCount, std::back_inserter(frame_->pictures));
  return out;
}

DrawnTile FrameTiles::made(const tiling::TileId& id, const TileContent& content, const ContentMaker& maker) {
  DrawnTile out{.id = id,
                .mesh = content.mesh,
                .firstPicture = static_cast<std::uint32_t>(frame_->pictures.size()),
                .relief = content.relief};
  for (const std::uint32_t layer : order_) {
    const LayerPicture* picture = layer < content.pictures.size() ? &content.pictures[layer] : nullptr;
    if (picture == nullptr || !picture->image) continue;
    frame_->pictures.push_back({.image = picture->image,
                                .window = windowIn(id, picture->level, maker.colours.pixels(layer), raster::kGutter),
                                .layer = layer});
    ++out.pictureCount;
  }
  if (out.relief) out.reliefWindow = windowIn(id, content.reliefLevel, maker.ground.cells(), 0.5);
  return out;
}

void FrameTiles::add(const SelectedTile& tile, const ContentMaker& maker) {
  if (isSoon_ && tile.over != nullptr) return;
  auto& record = static_cast<TileRecord&>(*tile.facts);
  const auto& content = tile.over != nullptr ? static_cast<const TileRecord&>(*tile.over).content : record.content;
  DrawnTile* last = tile.over == nullptr ? lastOf(record) : nullptr;
  const std::size_t at = record.drawnAt;
  DrawnTile out = last != nullptr ? movedOver(*last) : made(tile.id, *content, maker);
  Shown& shown = shown_.emplace_back(last != nullptr ? std::move(lastShown_[at])
                                                     : Shown{.content = content, .mesh = content->mesh.get()});
  if (out.mesh.get() != shown.mesh) out.mesh = shown.content->mesh;  // the last frame had a patch
  record.drawnAt = static_cast<std::uint32_t>(shown_.size() - 1);
  out.coarseEdges = tile.coarseEdges;
  out.morph = tile.morph;
  out.error_px = tile.error_px;
  (isSoon_ ? frame_->soon : frame_->tiles).push_back(std::move(out));
}

}  // namespace tellurion::scene
