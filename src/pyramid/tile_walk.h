#pragma once

#include <optional>
#include <vector>

#include "pyramid/input_set.h"

namespace tellurion::pyramid {

/// A tile that may hold data and must be made, with the inputs that may reach into it or its gutter.
struct Candidate {
  tiling::TileId id;
  std::vector<int> inputs;
  std::vector<bool>
      makes;  ///< of each input: it makes the tile and all its ancestors candidates where it is deep enough
};

/// A part of a level's walk.
struct WalkScope {
  std::optional<tiling::TileId> within;  ///< only what lies below this tile
  std::optional<int> stopAt;  ///< a coarser level: its tiles come out that may have candidates below, not these
};

/// The candidates of one level in the order of their rows, found by descending from the roots only where inputs are, so
/// that the list is never held. A tile is a candidate when an input as deep as its level touches it, or moves heights
/// in it (FillPlan), or when the base database stores it and any input touches or moves it or an edge neighbour (whose
/// samples are in its gutter). One thread only.
class TileWalk {
 public:
  /// Tiles with rows up to `after` are left out. `base` may be null; all must outlive the walk.
  TileWalk(const BuildPlan& plan, InputSet& inputs, TileDatabase* base, int level, std::int64_t after = 0,
           const WalkScope& scope = {});
  /// Those among the children of a candidate, without a base.
  TileWalk(const BuildPlan& plan, InputSet& inputs, const Candidate& parent);

  /// Nothing: the level is done.
  io::Result<std::optional<Candidate>> next();

 private:
  struct Touch {
    int input;
    bool inside;  ///< the input makes the tile and all its ancestors candidates where it is deep enough
  };
  /// A tile and the latitudes and longitudes that hold it.
  struct Bounded {
    tiling::TileId id;
    geo::GeoRect bounds;
  };
  struct Node {
    tiling::TileId id;
    std::vector<Touch> touches;
  };
  bool isBehind(const tiling::TileId& id) const;
  bool isOutside(const tiling::TileId& id) const;
  io::Result<bool> isAlive(const Node& node);
  io::Result<void> push(const tiling::TileId& id, const std::vector<Touch>& ofParent);
  /// The tile itself, then its edge neighbours.
  std::vector<Bounded> surroundings(const tiling::TileId& id) const;
  io::Result<bool> mayTouch(int input, const Bounded& tile, geo::Angle within);
  io::Result<std::optional<Touch>> touched(const std::vector<Bounded>& tiles, const Touch& ofParent);

  const BuildPlan& plan_;
  InputSet& inputs_;
  TileDatabase* base_;
  int level_;
  geo::Angle makesWithin_;    ///< so near to an input that is deep enough, tiles of the level have to be there
  geo::Angle touchesWithin_;  ///< what is stored so near to any input may change; no less
  std::int64_t after_;
  WalkScope scope_;
  std::vector<Node> stack_;
  io::Result<void> started_;
};

/// The number of candidates of a level: counted while they are few, estimated from the inputs' areas beyond.
io::Result<std::uint64_t> estimatedCandidates(const BuildPlan& plan, InputSet& inputs, TileDatabase* base, int level);

}  // namespace tellurion::pyramid
