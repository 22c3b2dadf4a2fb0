#include "scene/succession.h"

#include <unordered_map>

namespace tellurion::scene {
namespace {

/// Of a tile that is drawn: what of it is finer elsewhere.
struct Below {
  bool isFineEnough = false;
  bool isSplit = false;   ///< by the other cut
  bool isWanted = false;  ///< a tile below it is on its way
};

using DrawnTiles = std::unordered_map<tiling::TileId, Below, tiling::TileIdHash>;

/// The drawn tile that strictly holds this one; null: there is none.
Below* over(DrawnTiles& drawn, const tiling::TileId& id) {
  for (int level = id.level - 1; level >= 0; --level) {
    if (const auto found = drawn.find(id.ancestor(level)); found != drawn.end()) return &found->second;
  }
  return nullptr;
}

}  // namespace

bool isAsFineAs(const Selection& next, const Selection& shown, double tolerance_px) {
  if (next.heldBack > 0) return false;
  if (next.wanted.empty()) return true;
  DrawnTiles drawn;
  drawn.reserve(next.drawn.size());
  for (const SelectedTile& tile : next.drawn)
    drawn[tile.id].isFineEnough = tile.error_px <= tolerance_px;
  for (const WantedTile& wanted : next.wanted) {
    if (Below* tile = over(drawn, wanted.id)) tile->isWanted = true;
  }
  for (const SelectedTile& tile : shown.drawn) {
    const Below* coarser = over(drawn, tile.id);
    if (coarser != nullptr && (coarser->isWanted || !coarser->isFineEnough)) return false;
  }
  return true;
}

}  // namespace tellurion::scene
