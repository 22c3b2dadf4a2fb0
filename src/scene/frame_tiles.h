#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "scene/frame.h"
#include "scene/tile_record.h"

namespace tellurion::scene {

/// Fills frames with what a cut draws. What the last frame has too is moved over from it: its owners are not counted
/// again and its windows not computed again, which most of a frame would be. One thread only.
class FrameTiles {
 public:
  /// Empties the frame's tiles, what comes soon and their pictures, to fill it again; the frame must be the same one
  /// each time. order: of the imagery layers, bottom first; must stay while the frame is filled.
  void begin(Frame& frame, std::span<const std::uint32_t> order);
  /// Behind the tiles, and behind what comes soon once that was begun. The tile has content, or the one over it has,
  /// of which it is then drawn (SelectedTile::over) with all of its mesh, until it gets that part of it; that does not
  /// come soon.
  void add(const SelectedTile& tile, const ContentMaker& maker);
  /// What is added from here on is not drawn, but comes soon.
  void beginSoon() { isSoon_ = true; }
  /// The frame's pictures lie in this order.
  bool isInOrder(std::span<const std::uint32_t> order) const { return std::ranges::equal(order, order_); }
  /// Lets go of what only the last frame had.
  void finish();

 private:
  DrawnTile* lastOf(const TileRecord& record);
  DrawnTile made(const tiling::TileId& id, const TileContent& content, const ContentMaker& maker);
  DrawnTile movedOver(DrawnTile& last);

  Frame* frame_ = nullptr;
  bool isSoon_ = false;
  std::vector<std::uint32_t> order_;
  // Of the last frame. Its tiles and those that came soon are counted through, and so are the contents that they show.
  std::vector<DrawnTile> lastTiles_;
  std::vector<DrawnTile> lastSoon_;
  std::vector<DrawnPicture> lastPictures_;
  struct Shown {
    std::shared_ptr<const TileContent> content;
    const TerrainMesh* mesh;  ///< the content's, not asked of it again: that would be read for nothing else
  };
  std::vector<Shown> lastShown_;
  std::vector<Shown> shown_;  ///< of this frame, likewise
};

}  // namespace tellurion::scene
