#include "scene/select.h"

#include <algorithm>
#include <utility>

#include "scene/screen_share.h"
#include "scene/view_frustum.h"

namespace tellurion::scene {
namespace {

constexpr double kNearest_m = 0.5;

/// Where the last frame drew a tile's place.
enum class Before : std::uint8_t {
  nowhere,
  above,  ///< as part of a coarser tile
  here,
  below,  ///< as finer tiles
};

struct Node {
  tiling::TileId id;
  TileFacts* facts = nullptr;
  int parent = -1;
  int firstChild = -1;  ///< its four children follow each other
  /// The deepest nodes known to hold the places of TileFacts::around; -1 where nothing is.
  std::array<int, kAround> around{};
  std::uint8_t inside = 0;  ///< planes of the frustum that all of it lies within
  std::uint8_t insidePicture = 0;
  bool seen = false;      ///< may be in the picture, or soon (CutOptions::margin)
  bool shown = false;     ///< may be in the picture itself
  bool waits = false;     ///< would be split, but has not left its parent's surface yet
  bool hasDrawn = false;  ///< something below it is drawn
  bool kept = false;      ///< is split only since it was, and its children are not back on its surface
  Before before = Before::nowhere;
  double distance_m = 0.0;
  double error_px = 0.0;
  double texel_px = 0.0;
  double spacing_px = 0.0;
  double need = 0.0;  ///< how much too coarse it is: more than 1 asks for a split
};
struct Waiting {
  double need;
  tiling::TileId id;  ///< breaks ties, so that the order is the same on every run
  int node;
  bool operator<(const Waiting& o) const { return need != o.need ? need < o.need : id > o.id; }
};

/// What a cut is made in: its memory is kept.
struct Buffers {
  std::vector<Node> nodes;      ///< the roots first, in their order
  std::vector<Waiting> queue;   ///< a heap
  std::vector<Waiting> costly;  ///< what would copy to the GPU
  CornerLattice corners;        ///< where nothing is remembered
  Selection out;

  void clear() {
    nodes.clear();
    queue.clear();
    costly.clear();
    Selection fresh;
    std::swap(fresh.drawn, out.drawn);
    std::swap(fresh.soon, out.soon);
    std::swap(fresh.wanted, out.wanted);
    fresh.drawn.clear();
    fresh.soon.clear();
    fresh.wanted.clear();
    out = std::move(fresh);
  }
};

/// A forest of tiles that grows from the roots by splitting leaves.
class Cut {
 public:
  Cut(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, Buffers& buffers, const View& view,
      const CutOptions& options, double occluderDepth_m, TileTree& tree, const CutHistory* history)
      : nodes_(buffers.nodes),
        queue_(buffers.queue),
        costly_(buffers.costly),
        ownCorners_(buffers.corners),
        out_(buffers.out),
        tiling_(tiling),
        view_(view),
        picture_(view),
        frustum_(view, history != nullptr ? options.margin : 0.0),
        horizon_(ellipsoid.horizon(history != nullptr ? lifted(view.eye, ellipsoid) : view.eye, occluderDepth_m)),
        pixelAngle_(view.pixelAngle()),
        options_(options),
        tree_(tree),
        history_(history) {}

  void run() {
    grow();
    if (history_ != nullptr && copies_bytes_ > options_.copies_bytes) growWithinCopies();
    collect();
  }

 private:
  void grow() {
    for (int root = 0; root < tiling_.rootCount(); ++root) {
      const tiling::TileId id{.level = 0, .root = static_cast<std::uint8_t>(root)};
      const int node = add(id, tree_.root(root), -1);
      for (std::size_t place = 0; place < kAround; ++place) {
        const auto& beside = at(node).facts->around[place];
        at(node).around[place] = beside ? beside->root : -1;
      }
      count(at(node), 1);
      if (!at(node).facts->drawable) want(id, isSeen(node) ? kMissingRoot : kUnseenRoot);
    }
    refine();
  }

  /// Starts again: first with the splits that cost no copy, so that it is known what is drawn in any case. What is
  /// refused while others are on their way down may have its turn once they are there. Wanted stays what the whole cut
  /// asked for.
  void growWithinCopies() {
    nodes_.clear();
    queue_.clear();
    out_.visited = out_.culledFrustum = out_.culledHorizon = 0;
    out_.cappedByBudget = false;
    copies_bytes_ = 0;
    leaves_ = 0;
    triangles_ = bytes_ = 0;
    stage_ = Stage::free;
    grow();
    stage_ = Stage::copying;
    for (std::size_t before = 0; !costly_.empty() && before != nodes_.size() && !out_.cappedByBudget;) {
      before = nodes_.size();
      std::swap(queue_, costly_);
      std::make_heap(queue_.begin(), queue_.end());
      refine();
    }
    out_.heldBack = static_cast<int>(costly_.size());
  }

  void refine() {
    while (!queue_.empty() && !out_.cappedByBudget) {
      const Waiting worst = queue_.front();
      std::pop_heap(queue_.begin(), queue_.end());
      queue_.pop_back();
      if (at(worst.node).firstChild < 0) {
        if (worst.need == kKept && mayMerge(at(worst.node))) continue;
        at(worst.node).kept = worst.need == kKept;
        cause_ = worst.node;
        refused_ = false;
        if (!split(worst.node, worst.need, false)) {
          if (refused_) costly_.push_back(worst);
          continue;
        }
      }
      if (options_.morph && at(worst.node).need > 1.0) queueRing(worst.node, worst.need);
    }
  }

  static constexpr double kMissingRoot = 1e9;
  static constexpr double kUnseenRoot = 1e-9;  ///< what its depths tell is needed: see occluderDepth_m
  static constexpr double kAboveRounding = 1e-6;
  static constexpr double kKept = 1e-6;    ///< of the need of tiles that were split in the last frame
  static constexpr double kLeastShare = 1e-6;  ///< of the picture: what is not in it, but needed beside it
  static constexpr double kLift = 0.05;    ///< of the eye's height: what comes over the horizon soon
  using Children = std::array<TileFacts*, 4>;

  static geo::BodyPosition lifted(const geo::BodyPosition& eye, const geo::Ellipsoid& ellipsoid) {
    const geo::Geodetic place = ellipsoid.geodeticFromBody(eye);
    return eye + geo::directionFromLatLon(place.lat, place.lon).n * (kLift * std::max(place.height_m, 100.0));
  }

  void enqueue(double need, const tiling::TileId& id, int node) {
    queue_.push_back({.need = need, .id = id, .node = node});
    std::push_heap(queue_.begin(), queue_.end());
  }

  Node& at(int node) { return nodes_[static_cast<std::size_t>(node)]; }
  bool isSeen(int node) { return at(node).seen; }

  /// What it costs to draw, if it is drawn.
  void count(const Node& node, int sign) {
    if (!node.seen) return;
    leaves_ += sign;
    triangles_ += sign * node.facts->triangles;
    bytes_ += sign * static_cast<std::int64_t>(node.facts->bytes);
  }

  int add(const tiling::TileId& id, TileFacts* facts, int parent) {
    Node node{.id = id, .facts = facts, .parent = parent};
    classify(node);
    if (history_ != nullptr) node.before = beforeOf(node);
    // What is only there until it looks like its parent asks for nothing below it.
    if (parent >= 0 && at(parent).kept) node.need = std::min(node.need, 1.0);
    nodes_.push_back(node);
    copies_bytes_ += copiesOf(node);
    const int index = static_cast<int>(nodes_.size()) - 1;
    if (node.need > 1.0) {
      enqueue(node.need, id, index);
    } else if (node.before == Before::below && node.seen && node.facts->drawable &&
               (stage_ != Stage::whole || !isBackOnItsSurface(node))) {
      enqueue(kKept, id, index);
    }
    return index;
  }

  Before beforeOf(const Node& node) {
    if (const auto was = history_->last->find(node.id))
      return *was == CutMemory::Was::leaf ? Before::here : Before::below;
    if (node.parent < 0) return Before::nowhere;
    const Before over = at(node.parent).before;
    return over == Before::here || over == Before::above ? Before::above : Before::nowhere;
  }

  static bool isOnParentsSurface(const TileFacts& facts, int level, const CornerLattice& corners) {
    return std::all_of(facts.corners.corners.begin(), facts.corners.corners.end(),
                       [&](CornerKey corner) { return !(corners.valueAt(corner, level) > 0.0f); });
  }

  /// The children that were drawn all look like their parent.
  bool isBackOnItsSurface(const Node& node) const {
    const Children children = tree_.children(node.id, *node.facts);
    for (int q = 0; q < 4; ++q) {
      const tiling::TileId child = node.id.child(q);
      const auto was = history_->last->find(child);
      if (!was) continue;
      if (*was == CutMemory::Was::split) return false;
      if (!isOnParentsSurface(*children[static_cast<std::size_t>(q)], child.level, history_->last->corners))
        return false;
    }
    return true;
  }

  /// Bytes that drawing it would copy.
  static std::uint64_t copiesOf(const Node& node) { return node.shown ? node.facts->copy_bytes : 0; }

  /// It was split, and may be drawn itself again.
  bool mayMerge(const Node& node) const {
    const bool fits = stage_ == Stage::whole || copies_bytes_ <= std::max(options_.copies_bytes, copiesOf(node));
    return fits && isBackOnItsSurface(node);
  }

  /// The children need not wait for a later frame: they cost no copy, or what is left for copies is enough.
  bool mayCopy(const Children& children, const Node& node) const {
    std::uint64_t copies = 0;
    for (const TileFacts* child : children)
      copies += node.shown ? child->copy_bytes : 0;
    const std::uint64_t others = copies_bytes_ - copiesOf(node);
    if (copies <= copiesOf(node)) return true;
    return stage_ == Stage::copying && (others == 0 || others + copies <= options_.copies_bytes);
  }

  /// A tile that was drawn may be split once it has left its parent's surface, and when what touches its children and
  /// is as fine as they are is on its surface there.
  bool mayPart(const Node& node, const Children& children) const {
    if (history_ == nullptr || node.before == Before::below || node.before == Before::nowhere) return true;
    if (node.before == Before::above) return false;
    const CornerLattice& last = history_->last->corners;
    return std::all_of(node.facts->corners.corners.begin(), node.facts->corners.corners.end(),
                       [&](CornerKey corner) { return last.valueAt(corner, node.id.level) >= 1.0f; }) &&
           std::all_of(children.begin(), children.end(),
                       [&](const TileFacts* child) { return isOnParentsSurface(*child, node.id.level + 1, last); });
  }

  /// Its ground lies in both boxes, and in its parent's.
  static std::optional<std::uint8_t> planesAround(const ViewFrustum& frustum, const TileFacts& facts,
                                                  std::uint8_t parents) {
    const auto inside = frustum.planesAround(facts.box, parents);
    return inside && facts.drawable ? frustum.planesAround(facts.tightBox, *inside) : inside;
  }
  bool beyondHorizon(const TileFacts& facts) const {
    return isBeyondHorizon(facts.box, horizon_) || (facts.drawable && isBeyondHorizon(facts.tightBox, horizon_));
  }
  bool maySee(const TileFacts& facts, std::uint8_t parents) const {
    return planesAround(frustum_, facts, parents) && !beyondHorizon(facts);
  }

  void classify(Node& node) {
    ++out_.visited;
    if (node.parent >= 0 && !isSeen(node.parent)) return;
    const auto inside =
        planesAround(frustum_, *node.facts, node.parent >= 0 ? at(node.parent).inside : std::uint8_t{0});
    if (!inside) {
      ++out_.culledFrustum;
    } else if (beyondHorizon(*node.facts)) {
      ++out_.culledHorizon;
    } else {
      node.seen = true;
      showIn(node);
      node.inside = *inside;
      // Its ground lies in its parent's box as well.
      node.distance_m = (node.facts->drawable ? node.facts->tightBox : node.facts->box).distance_m(view_.eye);
      if (node.parent >= 0) node.distance_m = std::max(node.distance_m, at(node.parent).distance_m);
      measure(node);
    }
  }

  /// In the picture itself, the margin left out.
  void showIn(Node& node) {
    if (history_ == nullptr) {
      node.shown = true;
    } else if (node.parent < 0 || at(node.parent).shown) {
      const auto inside =
          planesAround(picture_, *node.facts, node.parent >= 0 ? at(node.parent).insidePicture : std::uint8_t{0});
      node.shown = inside.has_value();
      node.insidePicture = inside.value_or(0);
    }
  }

  /// How large it is on screen from its distance, and how much it needs its children for that.
  void measure(Node& node) const {
    node.error_px = pixelsAcross(node.facts->error_m, node.distance_m, pixelAngle_);
    node.texel_px = pixelsAcross(node.facts->texel_m, node.distance_m, pixelAngle_);
    node.spacing_px = pixelsAcross(node.facts->spacing_m, node.distance_m, pixelAngle_);
    if (!node.facts->drawable) return;
    node.need = std::max({node.error_px / options_.tolerance_px, node.texel_px / options_.texelTolerance_px,
                          node.spacing_px / options_.maxSpacing_px});
  }

  void want(const tiling::TileId& id, double priority) { out_.wanted.push_back({.id = id, .priority = priority}); }

  /// What better ground in a tile's place adds to the picture: missing detail times area.
  double urgencyOf(const TileFacts& facts, double need) const {
    return need * std::max(screenShare(facts.drawable ? facts.tightBox : facts.box, view_), kLeastShare);
  }

  /// The four children are there, or are asked for: with one urgency, since the last of them counts. Without a history,
  /// only those that may be seen have to be. `cause`: whose better ground they are for.
  bool areReady(const tiling::TileId& id, const Children& children, std::uint8_t inside, const TileFacts& cause,
                double need) {
    bool ready = true;
    for (int q = 0; q < 4; ++q) {
      const TileFacts& child = *children[static_cast<std::size_t>(q)];
      if (child.drawable || (history_ == nullptr && !maySee(child, inside))) continue;
      want(id.child(q), urgencyOf(cause, need));
      ready = false;
    }
    return ready;
  }

  /// While a tile waits for its morph, what will be needed below its children comes already.
  void prefetchBelow(const tiling::TileId& id, const Children& children, double priority) {
    for (int q = 0; q < 4; ++q) {
      Node child{.id = id.child(q), .facts = children[static_cast<std::size_t>(q)]};
      if (!child.facts->drawable || !maySee(*child.facts, 0)) continue;
      child.distance_m = child.facts->tightBox.distance_m(view_.eye);
      measure(child);
      if (child.need <= 1.0 || child.id.level >= tiling::kMaxLevel) continue;
      const Children below = tree_.children(child.id, *child.facts);
      if (areReady(child.id, below, 0, *child.facts, std::min(child.need, priority)))
        prefetchBelow(child.id, below, priority);
    }
  }

  bool affords(const Node& node, const Children& children, double priority) {
    std::int64_t triangles = triangles_ - (node.seen ? node.facts->triangles : 0);
    std::int64_t bytes = bytes_ - (node.seen ? static_cast<std::int64_t>(node.facts->bytes) : 0);
    for (const TileFacts* child : children) {
      triangles += node.seen ? child->triangles : 0;
      bytes += node.seen ? static_cast<std::int64_t>(child->bytes) : 0;
    }
    const bool enough = leaves_ + (node.seen ? 3 : 0) <= options_.maxTiles && triangles <= options_.maxTriangles &&
                        std::cmp_less_equal(bytes, options_.maxBytes);
    out_.cappedByBudget = out_.cappedByBudget || (!enough && priority > 1.0);
    return enough;
  }

  /// Splits a leaf and, before it, every coarser one that touches it. False when something that this takes is not
  /// loaded yet, has to morph first, or has to be copied later; then nothing but coarser neighbours may have changed.
  bool split(int node, double priority, bool atAnyCost) {
    const tiling::TileId id = at(node).id;
    // Else what is drawn finer now would vanish for a frame.
    atAnyCost = atAnyCost || stage_ == Stage::whole || at(node).before == Before::below;
    if (!at(node).facts->drawable || id.level >= tiling::kMaxLevel) return false;
    const Children children = tree_.children(id, *at(node).facts);
    if (!affords(at(node), children, priority)) return false;
    if (!areReady(id, children, at(node).inside, *at(cause_).facts, priority)) return false;
    const bool balanced = splitCoarserAround(node, priority, atAnyCost);
    if (!affords(at(node), children, priority)) return false;  // what lies around it took the rest
    if (!mayPart(at(node), children)) {
      at(node).waits = true;
      prefetchBelow(id, children, priority);
      return false;
    }
    if (!balanced) return false;
    if (!atAnyCost && !mayCopy(children, at(node))) {
      refused_ = true;
      return false;
    }
    copies_bytes_ -= copiesOf(at(node));
    const int first = static_cast<int>(nodes_.size());
    count(at(node), -1);
    for (int q = 0; q < 4; ++q) {
      add(id.child(q), children[static_cast<std::size_t>(q)], node);
      count(nodes_.back(), 1);
    }
    at(node).firstChild = first;
    for (int q = 0; q < 4; ++q) {
      for (std::size_t place = 0; place < kAround; ++place) {
        const Kin kin = kinAround(q, place);
        at(first + q).around[place] = kin.isSibling ? first + kin.which : at(node).around[kin.which];
      }
    }
    return true;
  }

  /// What is out of view counts only where there is a history: an eye that turns is to find it fit.
  bool splitCoarserAround(int node, double priority, bool atAnyCost) {
    const int level = at(node).id.level;
    bool balanced = true;
    for (std::size_t place = 0; place < kAround; ++place) {
      bool goesOn = true;
      for (int cover = covering(node, place);
           goesOn && cover >= 0 && at(cover).id.level < level && (history_ != nullptr || isSeen(cover));
           cover = covering(node, place))
        goesOn = split(cover, priority, atAnyCost);
      balanced = balanced && goesOn;  // what the others miss is asked for at once
    }
    return balanced;
  }

  /// Children that leave their parent's surface up to its border need others of their level beyond it.
  void queueRing(int node, double need) {
    const int level = at(node).id.level;
    for (std::size_t place = 0; place < kAround; ++place) {
      const int cover = covering(node, place);
      if (cover < 0) continue;
      const Node& beyond = at(cover);
      if (beyond.id.level == level && beyond.seen && beyond.firstChild < 0 && beyond.need <= 1.0)
        enqueue(1.0 + 0.25 * (need - 1.0), beyond.id, cover);
    }
  }

  /// The deepest node of the forest, no deeper than this one, that holds a place around it; -1: nothing does.
  int covering(int node, std::size_t place) {
    Node& n = at(node);
    int cover = n.around[place];
    if (cover < 0) return -1;
    while (at(cover).firstChild >= 0 && at(cover).id.level < n.id.level)
      cover = at(cover).firstChild + n.facts->around[place]->ancestor(at(cover).id.level + 1).quadrant();
    n.around[place] = cover;
    return cover;
  }

  std::uint8_t coarseEdgesOf(int node) {
    unsigned mask = 0;
    for (std::size_t e = 0; e < tiling::kEdges.size(); ++e) {
      const Node& beyond = at(covering(node, e));
      if (beyond.id.level + 1 == at(node).id.level && beyond.seen) mask |= 1u << e;
    }
    return static_cast<std::uint8_t>(mask);
  }

  /// How far a tile must have left its parent's surface: 0 when the parent is just fine enough, 1 where only its own
  /// is. What is drawn misses (1 - m) of the parent's error and m of its own, the tolerance at most.
  float goalOf(const Node& node) {
    if (!options_.morph || node.parent < 0 || node.waits) return 1.0f;
    const Node& parent = at(node.parent);
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
    return static_cast<float>(std::max({geometry, texture, samples}));
  }

  /// Ground that is far off hurries: from twice the tolerance on, in proportion.
  float speedOf(const Node& node) {
    return node.parent < 0 ? 1.0f : static_cast<float>(std::max(1.0, 0.5 * at(node.parent).need));
  }

  bool isDrawn(const Node& node) const { return node.firstChild < 0 && node.seen && node.facts->drawable; }

  /// With m the least value at its corners, it misses m of its own error and the rest of its parent's at most.
  double drawnError_px(const Node& node, const std::array<float, 4>& morph) {
    if (node.parent < 0) return node.error_px;
    const double least = static_cast<double>(*std::min_element(morph.begin(), morph.end()));
    const double ofParent = pixelsAcross(at(node.parent).facts->error_m, node.distance_m, pixelAngle_);
    return node.error_px + (1.0 - least) * std::max(ofParent - node.error_px, 0.0);
  }

  /// Its children are leaves on its surface: the next frame draws it instead.
  bool isReadyToMerge(const Node& node, const CornerLattice& corners) {
    for (int child = node.firstChild; child < node.firstChild + 4; ++child) {
      if (at(child).firstChild >= 0) return false;
      if (isDrawn(at(child)) && !isOnParentsSurface(*at(child).facts, node.id.level + 1, corners)) return false;
    }
    return true;
  }

  void settleCorners(CornerLattice& corners) {
    corners.clear();
    for (const Node& node : nodes_) {
      if (node.firstChild < 0)
        corners.add(node.facts->corners, node.id.level, isDrawn(node), node.before == Before::above, goalOf(node),
                    speedOf(node));
    }
    const bool atGoals = history_ != nullptr
                             ? corners.settle(&history_->last->corners, static_cast<float>(history_->step))
                             : corners.settle(nullptr, 1.0f);
    const bool unfinished = std::any_of(nodes_.begin(), nodes_.end(), [&](const Node& n) {
      return n.waits || (n.kept && n.firstChild >= 0 && isReadyToMerge(n, corners));
    });
    out_.morphing = !atGoals || unfinished;
  }

  void remember(CutMemory& memory) {
    memory.clear();
    // Children follow their parents.
    for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
      const bool drawn = isDrawn(*node);
      if (!drawn && !node->hasDrawn) continue;
      if (node->parent >= 0) at(node->parent).hasDrawn = true;
      memory.add(node->id, drawn ? CutMemory::Was::leaf : CutMemory::Was::split);
    }
  }

  /// Each tile once, as urgent as the most urgent of those who asked for it.
  void sortWanted() {
    auto& wanted = out_.wanted;
    std::sort(wanted.begin(), wanted.end(), [](const WantedTile& a, const WantedTile& b) {
      return a.id != b.id ? a.id < b.id : a.priority > b.priority;
    });
    wanted.erase(std::unique(wanted.begin(), wanted.end(),
                             [](const WantedTile& a, const WantedTile& b) { return a.id == b.id; }),
                 wanted.end());
    std::sort(wanted.begin(), wanted.end(), [](const WantedTile& a, const WantedTile& b) {
      return a.priority != b.priority ? a.priority > b.priority : a.id < b.id;
    });
  }

  void collect() {
    CornerLattice& corners = history_ != nullptr ? history_->now->corners : ownCorners_;
    if (options_.morph) settleCorners(corners);
    for (int i = 0; i < static_cast<int>(nodes_.size()); ++i) {
      const Node& node = at(i);
      if (!isDrawn(node)) continue;
      SelectedTile tile{.id = node.id, .facts = node.facts, .coarseEdges = coarseEdgesOf(i)};
      for (std::size_t q = 0; options_.morph && node.parent >= 0 && q < 4; ++q)
        tile.morph[q] = corners.valueAt(node.facts->corners.corners[q], node.id.level);
      if (!node.shown) {
        out_.soon.push_back(tile);
        continue;
      }
      tile.error_px = drawnError_px(node, tile.morph);
      out_.maxScreenError_px = std::max(out_.maxScreenError_px, tile.error_px);
      out_.drawn.push_back(tile);
    }
    if (history_ != nullptr) remember(*history_->now);
    out_.spareCopies_bytes = options_.copies_bytes - std::min(options_.copies_bytes, copies_bytes_);
    sortWanted();
  }

  std::vector<Node>& nodes_;
  std::vector<Waiting>& queue_;
  std::vector<Waiting>& costly_;
  CornerLattice& ownCorners_;
  Selection& out_;
  const tiling::Tiling& tiling_;
  const View& view_;
  ViewFrustum picture_;
  ViewFrustum frustum_;   ///< with the margin
  geo::Horizon horizon_;  ///< likewise
  double pixelAngle_;
  const CutOptions& options_;
  TileTree& tree_;
  const CutHistory* history_;
  int leaves_ = 0;              ///< that are seen
  std::int64_t triangles_ = 0;  ///< of those
  std::int64_t bytes_ = 0;
  std::uint64_t copies_bytes_ = 0;  ///< that drawing the leaves would take
  enum class Stage : std::uint8_t {
    whole,
    free,
    copying
  } stage_ = Stage::whole;  ///< whatever it costs; else see growWithinCopies
  bool refused_ = false;    ///< a split, for its copies
  int cause_ = -1;          ///< the leaf that is being split, and all that touches it for its sake
};

}  // namespace

double pixelsAcross(double length_m, double distance_m, double pixelAngle) {
  return length_m / (std::max(distance_m, kNearest_m) * pixelAngle);
}

struct Selector::Work {
  tiling::Tiling tiling;
  geo::Ellipsoid ellipsoid;
  Buffers buffers;
};

Selector::Selector(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid)
    : work_(std::make_unique<Work>(Work{.tiling = tiling, .ellipsoid = ellipsoid, .buffers = {}})) {}
Selector::~Selector() = default;
Selector::Selector(Selector&&) noexcept = default;
Selector& Selector::operator=(Selector&&) noexcept = default;

const Selection& Selector::select(const View& view, const CutOptions& options, double occluderDepth_m, TileTree& tree,
                                  const CutHistory* history) {
  work_->buffers.clear();
  Cut(work_->tiling, work_->ellipsoid, work_->buffers, view, options, occluderDepth_m, tree,
      options.morph ? history : nullptr)
      .run();
  return work_->buffers.out;
}

Selection select(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const View& view,
                 const CutOptions& options, double occluderDepth_m, TileTree& tree, const CutHistory* history) {
  return Selector(tiling, ellipsoid).select(view, options, occluderDepth_m, tree, history);
}

}  // namespace tellurion::scene
