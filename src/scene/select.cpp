#include "scene/select.h"

#include <algorithm>
#include <queue>
#include <unordered_map>

#include "scene/view_frustum.h"

namespace tellurion::scene {
namespace {

constexpr double kNearest_m = 0.5;

/// A forest of tiles that grows from the roots by splitting leaves.
class Cut {
 public:
  Cut(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const View& view, const CutOptions& options,
      double occluderDepth_m, TileTree& tree)
      : tiling_(tiling),
        ellipsoid_(ellipsoid),
        view_(view),
        frustum_(view),
        pixelAngle_(view.pixelAngle()),
        options_(options),
        occluderDepth_m_(occluderDepth_m),
        tree_(tree) {}

  Selection run() {
    for (int root = 0; root < tiling_.rootCount(); ++root) {
      const int node = add({.level = 0, .root = static_cast<std::uint8_t>(root)});
      if (!at(node).facts->drawable) want(at(node).id, isSeen(node) ? kMissingRoot : kUnseenRoot);
    }
    while (!queue_.empty() && !out_.cappedByBudget) {
      const int worst = queue_.top().node;
      queue_.pop();
      if (at(worst).firstChild < 0) split(worst, at(worst).need);
    }
    collect();
    return std::move(out_);
  }

 private:
  static constexpr double kMissingRoot = 1e9;
  static constexpr double kUnseenRoot = 1e-9;  ///< what its depths tell is needed: see occluderDepth_m

  struct Node {
    tiling::TileId id;
    const TileFacts* facts = nullptr;
    int firstChild = -1;  ///< its four children follow each other
    bool seen = false;    ///< may be in the picture
    double error_px = 0.0;
    double need = 0.0;  ///< how much too coarse it is: more than 1 asks for a split
  };
  struct Waiting {
    double need;
    tiling::TileId id;  ///< breaks ties, so that the order is the same on every run
    int node;
    bool operator<(const Waiting& o) const { return need != o.need ? need < o.need : id > o.id; }
  };

  Node& at(int node) { return nodes_[static_cast<std::size_t>(node)]; }
  bool isSeen(int node) { return at(node).seen; }

  int add(const tiling::TileId& id) {
    Node node{.id = id, .facts = tree_.facts(id)};
    classify(node);
    nodes_.push_back(node);
    const int index = static_cast<int>(nodes_.size()) - 1;
    if (node.need > 1.0) queue_.push({.need = node.need, .id = id, .node = index});
    return index;
  }

  bool inPicture(const TileFacts& facts) const {
    return frustum_.mayShow(facts.box) && (!facts.drawable || frustum_.mayShow(facts.tightBox));
  }
  bool beyondHorizon(const TileFacts& facts) const {
    const auto hidden = [&](const OrientedBox& box) {
      return isBeyondHorizon(box, view_.eye, ellipsoid_, occluderDepth_m_);
    };
    return hidden(facts.box) || (facts.drawable && hidden(facts.tightBox));
  }

  void classify(Node& node) {
    ++out_.visited;
    if (!inPicture(*node.facts)) {
      ++out_.culledFrustum;
    } else if (beyondHorizon(*node.facts)) {
      ++out_.culledHorizon;
    } else {
      node.seen = true;
      const double distance_m = (node.facts->drawable ? node.facts->tightBox : node.facts->box).distance_m(view_.eye);
      node.error_px = pixelsAcross(node.facts->error_m, distance_m, pixelAngle_);
      const double texel_px = pixelsAcross(node.facts->texel_m, distance_m, pixelAngle_);
      const double spacing_px = pixelsAcross(node.facts->spacing_m, distance_m, pixelAngle_);
      if (node.facts->drawable)
        node.need = std::max({node.error_px / options_.tolerance_px, texel_px, spacing_px / options_.maxSpacing_px});
    }
  }

  void want(const tiling::TileId& id, double priority) {
    double& known = wanted_[id];
    known = std::max(known, priority);
  }

  /// The four children are there, or are asked for.
  bool childrenReady(const tiling::TileId& id, double priority) {
    bool ready = true;
    for (int q = 0; q < 4; ++q) {
      const tiling::TileId child = id.child(q);
      const TileFacts* facts = tree_.facts(child);
      if (facts->drawable || !inPicture(*facts) || beyondHorizon(*facts)) continue;
      want(child, priority);
      ready = false;
    }
    return ready;
  }

  /// Splits a leaf and, before it, every coarser neighbour that would end up two levels apart. False when something
  /// that this takes is not loaded yet; then nothing but coarser neighbours may have changed.
  bool split(int node, double priority) {
    const tiling::TileId id = at(node).id;
    if (!at(node).facts->drawable || id.level >= tiling::kMaxLevel) return false;
    if (static_cast<int>(leaves_) + 3 > options_.maxTiles) {
      out_.cappedByBudget = true;
      return false;
    }
    if (!childrenReady(id, priority)) return false;
    for (const tiling::Edge edge : tiling::kEdges) {
      const tiling::TileId neighbour = tiling_.edgeNeighbour(id, edge).tile;
      for (int cover = covering(neighbour); at(cover).id.level < id.level && isSeen(cover);
           cover = covering(neighbour)) {
        if (!split(cover, priority)) return false;
      }
    }
    const int first = static_cast<int>(nodes_.size());
    for (int q = 0; q < 4; ++q)
      add(id.child(q));
    at(node).firstChild = first;
    leaves_ += 3;
    return true;
  }

  /// The deepest node of the forest that holds a tile.
  int covering(const tiling::TileId& id) {
    int node = id.root;
    for (int level = 1; level <= id.level && at(node).firstChild >= 0; ++level) {
      node = at(node).firstChild + id.ancestor(level).quadrant();
    }
    return node;
  }

  std::uint8_t coarseEdgesOf(const tiling::TileId& id) {
    unsigned mask = 0;
    for (std::size_t e = 0; e < tiling::kEdges.size(); ++e) {
      const int cover = covering(tiling_.edgeNeighbour(id, tiling::kEdges[e]).tile);
      if (at(cover).id.level + 1 == id.level && isSeen(cover)) mask |= 1u << e;
    }
    return static_cast<std::uint8_t>(mask);
  }

  void collect() {
    for (const Node& node : nodes_) {
      if (node.firstChild >= 0 || !node.seen || !node.facts->drawable) continue;
      out_.drawn.push_back({.id = node.id, .coarseEdges = coarseEdgesOf(node.id)});
      out_.maxScreenError_px = std::max(out_.maxScreenError_px, node.error_px);
    }
    for (const auto& [id, priority] : wanted_)
      out_.wanted.push_back({.id = id, .priority = priority});
    std::sort(out_.wanted.begin(), out_.wanted.end(), [](const WantedTile& a, const WantedTile& b) {
      return a.priority != b.priority ? a.priority > b.priority : a.id < b.id;
    });
  }

  const tiling::Tiling& tiling_;
  const geo::Ellipsoid& ellipsoid_;
  const View& view_;
  ViewFrustum frustum_;
  double pixelAngle_;
  const CutOptions& options_;
  double occluderDepth_m_;
  TileTree& tree_;
  std::vector<Node> nodes_;  ///< the roots first, in their order
  std::size_t leaves_ = 0;
  std::priority_queue<Waiting> queue_;
  std::unordered_map<tiling::TileId, double, tiling::TileIdHash> wanted_;
  Selection out_;
};

}  // namespace

double pixelsAcross(double length_m, double distance_m, double pixelAngle) {
  return length_m / (std::max(distance_m, kNearest_m) * pixelAngle);
}

Selection select(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const View& view,
                 const CutOptions& options, double occluderDepth_m, TileTree& tree) {
  return Cut(tiling, ellipsoid, view, options, occluderDepth_m, tree).run();
}

}  // namespace tellurion::scene
