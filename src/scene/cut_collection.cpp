#include "scene/cut_collection.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "scene/cut_past.h"

namespace tellurion::scene {
namespace {

constexpr double kAboveRounding = 1e-6;
constexpr double kUnseen_px_per_s = 15.0;  ///< a quarter of a pixel in a frame of a screen's 60 a second

/// From a grown forest to what is drawn.
class Collection {
 public:
  Collection(const CutOptions& options, const CutHistory* history, double pixelAngle, CutForest& forest,
             CollectionBuffers& buffers, Selection& out)
      : options_(options),
        history_(history),
        pixelAngle_(pixelAngle),
        forest_(forest),
        leaves_(buffers.leaves),
        corners_(history != nullptr ? history->now->corners : buffers.corners),
        out_(out) {}

  void run() {
    out_.nearest_m = std::numeric_limits<double>::infinity();
    addLeaves();
    if (usesCorners_) settleCorners();
    for (DrawnLeaf& leaf : leaves_)
      draw(leaf);
    if (history_ != nullptr) join();
    // What was only to be made ready for a later split leaves nothing too coarse.
    out_.cappedByBudget = out_.cappedByBudget && (isTooCoarse_ || out_.maxScreenError_px > options_.tolerance_px);
    if (history_ != nullptr) remember(forest_, *history_->now);
  }

 private:
  void addLeaves() {
    leaves_.clear();
    corners_.clear();
    for (int i = 0; i < static_cast<int>(forest_.nodes.size()); ++i) {
      const CutNode& node = forest_.at(i);
      if (node.firstChild >= 0) continue;
      isTooCoarse_ = isTooCoarse_ || (node.seen && node.need > 1.0);
      CornerLattice::Leaf corners{.id = node.id, .drawn = node.isDrawn()};
      if (corners.drawn) {
        corners.coarseEdges = coarseEdgesOf(i, 1);
        corners.isPart = node.part;
        corners.fromParent = node.before == Before::above;
        corners.goal = goalOf(node);
        corners.speed = speedOf(node);
        leaves_.push_back({.node = i, .coarseEdges = coarseEdgesOf(i, tiling::kMaxLevel)});
      }
      if (!usesCorners_) continue;
      corners_.add(node.facts->corners, corners, corners.drawn ? &leaves_.back().places : nullptr);
    }
  }

  void draw(DrawnLeaf& leaf) {
    const CutNode& node = forest_.at(leaf.node);
    SelectedTile tile{.id = node.id, .facts = node.facts, .coarseEdges = leaf.coarseEdges, .waits = node.waits};
    if (node.part) tile.over = forest_.at(node.parent).facts;
    leaf.isMorphed = usesCorners_ && node.parent >= 0 && !node.part;
    if (leaf.isMorphed) tile.morph = corners_.valuesAt(leaf.places, node.id.level);
    if (!node.shown && node.part) return;
    if (!node.shown) {
      out_.soon.push_back(tile);
      return;
    }
    tile.error_px = drawnError_px(node, leaf);
    out_.nearest_m = std::min(out_.nearest_m, node.distance_m);
    out_.maxScreenError_px = std::max(out_.maxScreenError_px, tile.error_px);
    leaf.drawn = static_cast<int>(out_.drawn.size());
    out_.drawn.push_back(tile);
  }

  /// A mesh has edges for what is one level finer, and a part of one none but its own.
  void join() {
    for (const DrawnLeaf& leaf : leaves_) {
      const CutNode& node = forest_.at(leaf.node);
      const int fewest = node.part ? 1 : 2;
      for (std::size_t e = 0; leaf.drawn >= 0 && e < tiling::kEdges.size(); ++e) {
        const int beyond = forest_.covering(leaf.node, e);
        const CutNode& coarse = forest_.at(beyond);
        if (!coarse.isDrawn() || !coarse.shown || coarse.surfaceLevel() + fewest > node.surfaceLevel()) continue;
        const auto ofCoarse = std::ranges::lower_bound(leaves_, beyond, {}, &DrawnLeaf::node);
        out_.joined.push_back({.coarse = static_cast<std::uint32_t>(ofCoarse->drawn),
                               .fine = static_cast<std::uint32_t>(leaf.drawn),
                               .edge = static_cast<std::uint8_t>(e)});
      }
    }
    std::ranges::sort(out_.joined, {}, [](const JoinedEdge& j) { return std::tuple(j.coarse, j.fine, j.edge); });
  }

  /// Across which the surface that is drawn is coarser, by so many levels at most.
  std::uint8_t coarseEdgesOf(int node, int levels) {
    unsigned mask = 0;
    if (forest_.at(node).part) return 0;
    for (std::size_t e = 0; e < tiling::kEdges.size(); ++e) {
      const CutNode& beyond = forest_.at(forest_.covering(node, e));
      const int coarser = forest_.at(node).id.level - beyond.surfaceLevel();
      if (coarser > 0 && coarser <= levels && beyond.isDrawn()) mask |= 1u << e;
    }
    return static_cast<std::uint8_t>(mask);
  }

  /// How far a tile must have left its parent's surface: 0 when the parent is just fine enough, 1 where only its own
  /// is. What is drawn misses (1 - m) of the parent's error and m of its own, the tolerance at most.
  float goalOf(const CutNode& node) const {
    if (!options_.morph || node.parent < 0 || node.waits) return 1.0f;
    const CutNode& parent = forest_.at(node.parent);
    // All seen from where the parent is: with that distance it was split, and at the same moment this is 0.
    const auto share = [](double ofParent, double own, double allowed) {
      if (ofParent <= allowed) return 0.0;
      return own >= ofParent ? 1.0 : std::min((ofParent - allowed) / (ofParent - own) + kAboveRounding, 1.0);
    };
    const double own_px =
        parent.facts->error_m > 0.0 ? parent.error_px * (node.facts->error_m / parent.facts->error_m) : parent.error_px;
    const double geometry = share(parent.error_px, own_px, options_.tolerance_px);
    const double texture = share(parent.texel_px, 0.5 * parent.texel_px, options_.texelTolerance_px);
    const double samples = share(parent.spacing_px, 0.5 * parent.spacing_px, options_.maxSpacing_px);
    const double own = static_cast<double>(node.presence) * std::max({geometry, texture, samples});
    return static_cast<float>(std::max(own, aheadOf(node)));
  }

  /// Where nothing is remembered it has left it by the time it is split, be it for a neighbour's sake.
  double aheadOf(const CutNode& node) const {
    if (history_ != nullptr) return 0.0;
    return std::clamp((static_cast<double>(node.due) - kBeforehand) / (1.0 - kBeforehand), 0.0, 1.0);
  }

  /// What has little way to go takes less than fade_s: so many pixels a second no one sees, and ground that is only as
  /// late as the eye is fast stays within the tolerance. Ground that is far off hurries: from twice the tolerance on,
  /// in proportion.
  float speedOf(const CutNode& node) const {
    if (node.parent < 0) return 1.0f;
    const CutNode& parent = forest_.at(node.parent);
    const double unseen = kUnseen_px_per_s * options_.fade_s / std::max(parent.error_px, kAboveRounding);
    return static_cast<float>(std::max({1.0, unseen, 0.5 * parent.need}));
  }

  /// With m the least value at its corners, it misses m of its own error and the rest of its parent's at most.
  double drawnError_px(const CutNode& node, const DrawnLeaf& leaf) const {
    if (node.parent < 0) return node.error_px;
    if (node.part) return pixelsAcross(forest_.at(node.parent).facts->error_m, node.distance_m, pixelAngle_);
    const double least = leaf.isMorphed ? static_cast<double>(corners_.leastAt(leaf.places, node.id.level)) : 1.0;
    const double ofParent = pixelsAcross(forest_.at(node.parent).facts->error_m, node.distance_m, pixelAngle_);
    return node.error_px + (1.0 - least) * std::max(ofParent - node.error_px, 0.0);
  }

  /// Its children are leaves on its surface: the next frame draws it instead.
  bool isReadyToMerge(const CutNode& node) const {
    for (int i = node.firstChild; i < node.firstChild + 4; ++i) {
      const CutNode& child = forest_.at(i);
      if (child.firstChild >= 0) return false;
      if (child.isDrawn() && !child.part && !isOnParentsSurface(*child.facts, child.id.level, corners_)) return false;
    }
    return true;
  }

  void settleCorners() {
    out_.fading = history_ != nullptr ? corners_.settle(&history_->last->corners, static_cast<float>(history_->step))
                                      : corners_.settle(nullptr, 1.0f);
    out_.morphing =
        out_.fading > 0.0f || std::any_of(forest_.nodes.begin(), forest_.nodes.end(), [&](const CutNode& n) {
          return n.waits || (n.part && n.facts->drawable) || (n.kept && n.firstChild >= 0 && isReadyToMerge(n));
        });
  }

  const CutOptions& options_;
  bool usesCorners_ = options_.morph || !options_.isNested;
  const CutHistory* history_;
  double pixelAngle_;
  CutForest& forest_;
  std::vector<DrawnLeaf>& leaves_;
  CornerLattice& corners_;
  Selection& out_;
  bool isTooCoarse_ = false;  ///< something that may be in the picture, or soon, asks for a split that was not made
};

}  // namespace

void moveOn(const CornerLattice& corners, const CollectionBuffers& buffers, Selection& out) {
  for (const DrawnLeaf& leaf : buffers.leaves) {
    if (leaf.drawn < 0 || !leaf.isMorphed) continue;
    SelectedTile& tile = out.drawn[static_cast<std::size_t>(leaf.drawn)];
    tile.morph = corners.valuesAt(leaf.places, tile.id.level);
  }
}

void collectCut(const CutOptions& options, const CutHistory* history, double pixelAngle, CutForest& forest,
                CollectionBuffers& buffers, Selection& out) {
  Collection(options, history, pixelAngle, forest, buffers, out).run();
}

}  // namespace tellurion::scene
