#include "scene/succession.h"

#include <algorithm>
#include <unordered_map>

namespace tellurion::scene {
namespace {

/// Of a tile that is drawn.
struct Drawn {
  double error_px = 0.0;
  bool isToSplit = false;  ///< tiles below it are on its way, or here
};

using DrawnTiles = std::unordered_map<tiling::TileId, Drawn, tiling::TileIdHash>;

/// The drawn tile that strictly holds this one; null: there is none.
Drawn* over(DrawnTiles& drawn, const tiling::TileId& id) {
  for (int level = id.level - 1; level >= 0; --level) {
    if (const auto found = drawn.find(id.ancestor(level)); found != drawn.end()) return &found->second;
  }
  return nullptr;
}

}  // namespace

bool isAsFineAs(const Selection& next, const Selection& shown, double tolerance_px) {
  if (next.heldBack > 0) return false;
  if (next.wanted.empty() && !next.morphing) return true;
  DrawnTiles drawn;
  drawn.reserve(next.drawn.size());
  for (const SelectedTile& tile : next.drawn)
    drawn[tile.id] = {.error_px = tile.error_px, .isToSplit = tile.waits};
  for (const WantedTile& wanted : next.wanted) {
    if (Drawn* tile = over(drawn, wanted.id)) tile->isToSplit = true;
  }
  for (const SelectedTile& tile : shown.drawn) {
    const auto same = drawn.find(tile.id);
    // Still on its way from its parent's surface.
    if (same != drawn.end() && same->second.error_px > std::max(tolerance_px, tile.error_px)) return false;
    const Drawn* coarser = over(drawn, tile.id);
    if (coarser != nullptr && (coarser->isToSplit || coarser->error_px > tolerance_px)) return false;
  }
  return true;
}

}  // namespace tellurion::scene
