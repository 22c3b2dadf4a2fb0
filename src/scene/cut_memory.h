#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "scene/corner_lattice.h"

namespace tellurion::scene {

/// What a frame drew, for the next one to go on from without a jump: the forest of its cut, as places that are found
/// from the roots down. One thread.
class CutMemory {
 public:
  /// Drawn itself; drawn as a part of its parent's mesh; drawn as finer tiles.
  enum class Was : std::uint8_t { nowhere, leaf, part, split };

  CornerLattice corners;

  void clear() { places_.clear(); }
  /// Room for a forest of so many nodes, the roots first; all of them were drawn nowhere.
  void start(std::size_t nodes) { places_.assign(nodes, {}); }
  /// firstChild: its children are this node and the three after it; -1 where nothing of it is drawn finer.
  void set(int node, Was was, int firstChild) {
    places_[static_cast<std::size_t>(node)] = {.firstChild = firstChild, .was = was};
  }

  /// A root's place; -1: nothing is known of it.
  int rootPlace(int root) const { return static_cast<std::size_t>(root) < places_.size() ? root : -1; }
  /// Of a place's child; -1 likewise, and for a place of -1.
  int childPlace(int place, int quadrant) const {
    const int first = place < 0 ? -1 : places_[static_cast<std::size_t>(place)].firstChild;
    return first < 0 ? -1 : first + quadrant;
  }
  Was at(int place) const { return place < 0 ? Was::nowhere : places_[static_cast<std::size_t>(place)].was; }

 private:
  struct Place {
    int firstChild = -1;
    Was was = Was::nowhere;
  };
  std::vector<Place> places_;
};

}  // namespace tellurion::scene
