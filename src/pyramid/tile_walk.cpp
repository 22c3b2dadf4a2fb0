#include "pyramid/tile_walk.h"

#include <algorithm>
#include <cmath>

namespace tellurion::pyramid {
namespace {

constexpr std::uint64_t kMostCounted = 4096;

/// The angle of a reach, which is a chord, and some more.
geo::Angle angleOf(double reach) {
  return geo::Angle::radians(1.01 * reach);
}

}  // namespace

TileWalk::TileWalk(const BuildPlan& plan, InputSet& inputs, TileDatabase* base, int level, std::int64_t after,
                   const WalkScope& scope)
    : plan_(plan),
      inputs_(inputs),
      base_(base),
      level_(level),
      makesWithin_(angleOf(plan.fill.reachOfTiles(level))),
      touchesWithin_(makesWithin_),
      after_(after),
      scope_(scope) {
  if (base != nullptr) touchesWithin_ = std::max(makesWithin_, angleOf(plan.fill.reachDownTo(level)));
  std::vector<Touch> all;
  for (int i = 0; i < static_cast<int>(plan.inputs.size()); ++i)
    all.push_back({.input = i, .inside = true});
  for (int root = plan.tiling().rootCount() - 1; root >= 0 && started_; --root) {
    started_ = push({.level = 0, .root = static_cast<std::uint8_t>(root), .x = 0, .y = 0}, all);
  }
}

TileWalk::TileWalk(const BuildPlan& plan, InputSet& inputs, const Candidate& parent)
    : plan_(plan),
      inputs_(inputs),
      base_(nullptr),
      level_(parent.id.level + 1),
      makesWithin_(angleOf(plan.fill.reachOfTiles(level_))),
      touchesWithin_(makesWithin_),
      after_(0) {
  std::vector<Touch> touches;
  for (std::size_t i = 0; i < parent.inputs.size(); ++i)
    touches.push_back({.input = parent.inputs[i], .inside = parent.makes[i]});
  for (int quadrant = 3; quadrant >= 0 && started_; --quadrant)
    started_ = push(parent.id.child(quadrant), touches);
}

/// Whether all the tile's descendants at the level are in rows up to `after`.
bool TileWalk::isBehind(const tiling::TileId& id) const {
  const int below = 2 * (level_ - id.level);
  const std::int64_t lastRow = ((rowNumberOf(id) + 1) << below) - 1;
  return lastRow <= after_;
}

bool TileWalk::isOutside(const tiling::TileId& id) const {
  if (!scope_.within) return false;
  const int shared = std::min(id.level, scope_.within->level);
  return id.ancestor(shared) != scope_.within->ancestor(shared);
}

std::vector<TileWalk::Bounded> TileWalk::surroundings(const tiling::TileId& id) const {
  const tiling::Tiling tiling = plan_.tiling();
  std::vector<Bounded> tiles{{id, tiling.bounds(id)}};
  for (const tiling::Edge edge : tiling::kEdges) {
    const tiling::TileId neighbour = tiling.edgeNeighbour(id, edge).tile;
    tiles.push_back({neighbour, tiling.bounds(neighbour)});
  }
  return tiles;
}

io::Result<bool> TileWalk::mayTouch(int input, const Bounded& tile, geo::Angle within) {
  if (!plan_.inputs[static_cast<std::size_t>(input)].bounds.grown(within).intersects(tile.bounds)) return false;
  return inputs_.mayTouch(input, tile.id, within);
}

io::Result<std::optional<TileWalk::Touch>> TileWalk::touched(const std::vector<Bounded>& tiles, const Touch& ofParent) {
  if (ofParent.inside) {
    const auto makes = mayTouch(ofParent.input, tiles.front(), makesWithin_);
    if (!makes) return tl::unexpected(makes.error());
    if (*makes) return std::optional(Touch{.input = ofParent.input, .inside = true});
  }
  for (const Bounded& tile : tiles) {
    const auto may = mayTouch(ofParent.input, tile, touchesWithin_);
    if (!may) return tl::unexpected(may.error());
    if (*may) return std::optional(Touch{.input = ofParent.input, .inside = false});
  }
  return std::optional<Touch>{};
}

io::Result<bool> TileWalk::isAlive(const Node& node) {
  const auto isDeep = [&](const Touch& touch) {
    return touch.inside && plan_.inputs[static_cast<std::size_t>(touch.input)].depth >= level_;
  };
  if (std::ranges::any_of(node.touches, isDeep)) return true;
  if (base_ == nullptr || node.touches.empty()) return false;
  return base_->contains(node.id);
}

io::Result<void> TileWalk::push(const tiling::TileId& id, const std::vector<Touch>& ofParent) {
  if (isBehind(id) || isOutside(id)) return {};
  Node node{.id = id, .touches = {}};
  const std::vector<Bounded> tiles = surroundings(id);
  for (const Touch& touch : ofParent) {
    const auto own = touched(tiles, touch);
    if (!own) return tl::unexpected(own.error());
    if (*own) node.touches.push_back(**own);
  }
  const auto alive = isAlive(node);
  if (!alive) return tl::unexpected(alive.error());
  if (*alive) stack_.push_back(std::move(node));
  return {};
}

io::Result<std::optional<Candidate>> TileWalk::next() {
  if (!started_) return tl::unexpected(started_.error());
  while (!stack_.empty()) {
    const Node node = std::move(stack_.back());
    stack_.pop_back();
    if (node.id.level == scope_.stopAt.value_or(level_)) {
      Candidate candidate{.id = node.id, .inputs = {}, .makes = {}};
      for (const Touch& touch : node.touches) {
        candidate.inputs.push_back(touch.input);
        candidate.makes.push_back(touch.inside);
      }
      return std::optional(std::move(candidate));
    }
    for (int quadrant = 3; quadrant >= 0; --quadrant) {
      if (auto ok = push(node.id.child(quadrant), node.touches); !ok) return tl::unexpected(ok.error());
    }
  }
  return std::optional<Candidate>{};
}

namespace {

double areaOf(const geo::GeoRect& rect) {
  return rect.width.radians() * (std::sin(rect.north.radians()) - std::sin(rect.south.radians()));
}

}  // namespace

io::Result<std::uint64_t> estimatedCandidates(const BuildPlan& plan, InputSet& inputs, TileDatabase* base, int level) {
  const double tilesOfLevel = static_cast<double>(plan.tiling().rootCount()) * std::exp2(2.0 * level);
  double area = 0.0;
  for (const PlannedInput& input : plan.inputs) {
    if (input.depth >= level || base != nullptr) area += areaOf(input.bounds);
  }
  const double share = std::min(1.0, area / (4.0 * geo::kPi));
  if (share * tilesOfLevel > static_cast<double>(kMostCounted)) {
    return static_cast<std::uint64_t>(share * tilesOfLevel);
  }
  TileWalk walk(plan, inputs, base, level);
  std::uint64_t count = 0;
  while (true) {
    const auto candidate = walk.next();
    if (!candidate) return tl::unexpected(candidate.error());
    if (!*candidate) return count;
    if (++count >= 4 * kMostCounted) return count;
  }
}

}  // namespace tellurion::pyramid
