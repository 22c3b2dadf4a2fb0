#include "scene/tiles_around.h"

namespace tellurion::scene {
namespace {

constexpr Kin sibling(std::uint8_t quadrant) {
  return {.isSibling = true, .which = quadrant};
}
constexpr Kin beyond(std::uint8_t place) {
  return {.isSibling = false, .which = place};
}

// Places: 0 top, 1 right, 2 bottom, 3 left, 4 top left, 5 top right, 6 bottom right, 7 bottom left.
constexpr std::array<std::array<Kin, kAround>, 4> kKin{{
    {beyond(0), sibling(1), sibling(2), beyond(3), beyond(4), beyond(0), sibling(3), beyond(3)},
    {beyond(0), beyond(1), sibling(3), sibling(0), beyond(0), beyond(5), beyond(1), sibling(2)},
    {sibling(0), sibling(3), beyond(2), beyond(3), beyond(3), sibling(1), beyond(2), beyond(7)},
    {sibling(1), beyond(1), beyond(2), sibling(2), sibling(0), beyond(1), beyond(6), beyond(2)},
}};

}  // namespace

TilesAround tilesAround(const tiling::Tiling& tiling, const tiling::TileId& id) {
  TilesAround around;
  for (std::size_t e = 0; e < tiling::kEdges.size(); ++e)
    around[e] = tiling.edgeNeighbour(id, tiling::kEdges[e]).tile;
  for (std::size_t c = 0; c < tiling::kCorners.size(); ++c)
    around[tiling::kEdges.size() + c] = tiling.cornerNeighbour(id, tiling::kCorners[c]);
  return around;
}

Kin kinAround(int quadrant, std::size_t place) {
  return kKin[static_cast<std::size_t>(quadrant)][place];
}

}  // namespace tellurion::scene
