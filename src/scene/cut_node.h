#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "scene/select.h"

namespace tellurion::scene {

/// Where the last frame drew a tile's place.
enum class Before : std::uint8_t {
  nowhere,
  above,  ///< as part of a coarser tile
  here,
  below,  ///< as finer tiles
};

/// The share of what asks for a split from which on all that it takes is made ready, where nothing is remembered.
inline constexpr double kBeforehand = 0.9;

/// Two lines of a processor's cache, what others look at in the first.
struct alignas(64) CutNode {
  CutNode(TileFacts* itsFacts, int itsParent) : parent(itsParent), facts(itsFacts) {}

  tiling::TileId id;
  int firstChild = -1;  ///< its four children follow each other
  int parent;           ///< -1: a root
  bool seen = false;    ///< may be in the picture, or soon (CutOptions::margin)
  bool shown = false;   ///< may be in the picture itself
  bool waits = false;   ///< would be split, but has not left its parent's surface yet
  bool kept = false;    ///< is split only since it was, and its children are not back on its surface
  TileFacts* facts;
  double need = 0.0;  ///< how much too coarse it is: more than 1 asks for a split
  double distance_m = 0.0;
  int past = -1;  ///< its place in the last frame's CutMemory
  Before before = Before::nowhere;
  std::uint8_t inside = 0;  ///< planes of the frustum that all of it lies within
  std::uint8_t insidePicture = 0;
  bool part = false;  ///< it is not here: drawn is that quarter of its parent's mesh
  /// The deepest nodes known to hold the places of TileFacts::around; -1 where nothing is. Set by who adds the node.
  std::array<int, kAround> around;
  double error_px = 0.0;
  double texel_px = 0.0;
  double spacing_px = 0.0;
  float presence = 1.0f;  ///< how much it counts: less than 1 in the margin, where nothing is remembered
  /// With morphing, where nothing is remembered: its need, or what its neighbours will ask of it.
  float due = 0.0f;

  bool isDrawn() const { return firstChild < 0 && seen && (part || facts->drawable); }
  /// Of the surface that it is drawn as.
  int surfaceLevel() const { return part ? id.level - 1 : id.level; }
};
static_assert(sizeof(CutNode) == 128);

/// The tiles that a cut has looked at, the roots first, in their order; parents before their children.
struct CutForest {
  std::vector<CutNode> nodes;

  CutNode& at(int node) { return nodes[static_cast<std::size_t>(node)]; }
  const CutNode& at(int node) const { return nodes[static_cast<std::size_t>(node)]; }
  /// The deepest node, no deeper than this one, that holds a place around it (TilesAround); -1: nothing does.
  int covering(int node, std::size_t place);
};

inline int CutForest::covering(int node, std::size_t place) {
  CutNode& n = at(node);
  int cover = n.around[place];
  if (cover < 0) return -1;
  while (at(cover).firstChild >= 0 && at(cover).id.level < n.id.level) {
    // Mostly it follows from the tile's own name, which spares reading its facts.
    const auto inRoot = besideInRoot(n.id, place);
    const tiling::TileId beside = inRoot ? *inRoot : *n.facts->around[place];
    cover = at(cover).firstChild + beside.ancestor(at(cover).id.level + 1).quadrant();
  }
  n.around[place] = cover;
  return cover;
}

}  // namespace tellurion::scene
