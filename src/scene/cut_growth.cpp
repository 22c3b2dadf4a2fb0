#include "scene/cut_growth.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace tellurion::scene {
namespace {

constexpr double kMissingRoot = 1e9;
constexpr double kUnseenRoot = 1e8;   ///< the horizon needs the depths that it tells: occluderDepth_m of select()
constexpr double kNoPicture = 10.0;   ///< how much more what is not there at all counts than what is too coarse
constexpr double kKeptNeed = 1e-6;    ///< of tiles that were split in the last frame: after all others
constexpr float kForeseen = 0.7f;     ///< less of it is of no consequence
constexpr double kLeastShare = 1e-6;  ///< of the picture: what is not in it, but needed beside it

/// Bytes that drawing it would copy.
std::uint64_t copiesOf(const CutNode& node) {
  return node.shown ? node.facts->copy_bytes : 0;
}

/// A forest of tiles that grows from the roots by splitting leaves.
class Growth {
 public:
  Growth(const GrowthRules& rules, GrowthBuffers& buffers, Selection& out)
      : rules_(rules),
        options_(rules.options),
        past_(rules.past),
        holdsAllReady_(past_.isKnown() && !options_.isNested),
        forest_(buffers.forest),
        queue_(buffers.queue),
        costly_(buffers.costly),
        tally_(buffers.tally),
        out_(out) {}

  void run() {
    growFromRoots();
    if (options_.morph && !past_.isKnown()) growAhead();
    if (past_.isKnown() && tally_.copies_bytes > options_.copies_bytes) growWithinCopies();
    out_.spareCopies_bytes = options_.copies_bytes - std::min(options_.copies_bytes, tally_.copies_bytes);
  }

  void addRoots() {
    clear();
    for (int root = 0; root < rules_.tiling.rootCount(); ++root) {
      CutNode& node = add(-1, root, rules_.tree.root(root));
      for (std::size_t place = 0; place < kAround; ++place) {
        const auto& beside = node.facts->around[place];
        node.around[place] = beside ? beside->root : -1;
      }
      out_.rootShares.push_back(node.seen ? shareOf(*node.facts) : 0.0);
      if (!node.facts->drawable) want(node.id, node.seen ? kMissingRoot : kUnseenRoot);
      if (node.facts->isStandIn && node.seen) want(node.id, kNoPicture * shareOf(*node.facts));
    }
  }

  /// Worst first, as long as something asks for a split, and no more than that; tells how many it were.
  std::size_t refine(std::size_t most = std::numeric_limits<std::size_t>::max()) {
    std::size_t done = 0;
    for (; done < most && !queue_.empty() && !out_.cappedByBudget; ++done)
      refineWorst();
    return done;
  }

 private:
  void growFromRoots() {
    addRoots();
    refine();
  }

  /// Starts again: first with the splits that cost no copy, so that it is known what is drawn in any case. What is
  /// refused while others are on their way down may have its turn once they are there. Wanted stays what the whole cut
  /// asked for.
  void growWithinCopies() {
    stage_ = Stage::free;
    growFromRoots();
    stage_ = Stage::copying;
    for (std::size_t before = 0; !costly_.empty() && before != forest_.nodes.size() && !out_.cappedByBudget;) {
      before = forest_.nodes.size();
      std::swap(queue_, costly_);
      std::make_heap(queue_.begin(), queue_.end());
      refine();
    }
    out_.heldBack = static_cast<int>(costly_.size());
  }

  /// Without a memory, a tile that will be split with a neighbour, or for one, has to be on its own surface by then,
  /// with no coarser one around. So what a tile needs counts for those beside it too, and the coarser ones around it
  /// are split when it comes near to its own split, before that the still coarser ones around those, and so on.
  void growAhead() {
    for (std::size_t before = 0; before != forest_.nodes.size() && !out_.cappedByBudget;) {
      before = forest_.nodes.size();
      foresee();
      for (int i = 0; i < static_cast<int>(before); ++i) {
        const CutNode& node = at(i);
        if (node.due > 1.0f && node.firstChild < 0 && node.seen)
          enqueue({.need = static_cast<double>(node.due), .id = node.id, .node = i});
      }
      refine();
    }
  }

  void foresee() {
    for (CutNode& node : forest_.nodes)
      node.due = static_cast<float>(node.need);
    for (int i = 0; i < static_cast<int>(forest_.nodes.size()); ++i) {
      const auto need = static_cast<float>(at(i).need);
      if (need <= kForeseen) continue;
      for (std::size_t place = 0; place < kAround; ++place) {
        const int cover = forest_.covering(i, place);
        if (cover >= 0 && at(cover).id.level == at(i).id.level) at(cover).due = std::max(at(cover).due, need);
      }
    }
    for (int i = 0; i < static_cast<int>(forest_.nodes.size()); ++i)
      pushToCoarser(i);
  }

  void pushToCoarser(int node) {
    const float due = at(node).due / static_cast<float>(kBeforehand);
    if (due <= kForeseen || !at(node).seen) return;
    for (std::size_t place = 0; place < kAround; ++place) {
      const int cover = forest_.covering(node, place);
      if (cover < 0 || at(cover).id.level >= at(node).id.level || at(cover).due >= due) continue;
      at(cover).due = due;
      pushToCoarser(cover);
    }
  }

  void clear() {
    forest_.nodes.clear();
    queue_.clear();
    costly_.clear();
    out_.rootShares.clear();
    out_.visited = out_.culledFrustum = out_.culledHorizon = 0;
    out_.cappedByBudget = false;
    tally_ = {};
  }

  void refineWorst() {
    const WaitingNode worst = queue_.front();
    std::pop_heap(queue_.begin(), queue_.end());
    queue_.pop_back();
    if (at(worst.node).firstChild < 0) {
      if (worst.kept && mayMerge(at(worst.node))) return;
      at(worst.node).kept = worst.kept;
      cause_ = worst.node;
      refused_ = false;
      if (!split(worst.node, worst.need, false)) {
        if (refused_) costly_.push_back(worst);
        return;
      }
    }
    if (options_.morph && at(worst.node).need > 1.0) queueRing(worst.node, worst.need);
  }

  CutNode& at(int node) { return forest_.at(node); }

  void enqueue(const WaitingNode& waiting) {
    queue_.push_back(waiting);
    std::push_heap(queue_.begin(), queue_.end());
  }

  /// What it costs to draw, if it is drawn.
  void count(const CutNode& node, int sign) {
    if (!node.seen) return;
    tally_.leaves += sign;
    tally_.triangles += sign * node.facts->triangles;
    tally_.bytes += sign * static_cast<std::int64_t>(node.facts->bytes);
  }

  /// `which`: its quadrant, or number of a root, whose parent is -1. What lies around it is left to the caller.
  CutNode& add(int parent, int which, TileFacts* facts) {
    const int index = static_cast<int>(forest_.nodes.size());
    CutNode& node = forest_.nodes.emplace_back(facts, parent);
    const CutNode* over = parent >= 0 ? &at(parent) : nullptr;
    // Made in its place: moved there, its parts would be waited for.
    node.id =
        over != nullptr ? over->id.child(which) : tiling::TileId{.level = 0, .root = static_cast<std::uint8_t>(which)};
    look(node, over);
    past_.recall(node, over);
    node.part = over != nullptr && node.seen && past_.isKnown() && (!facts->drawable || past_.staysPart(node));
    // What is only there until it looks like its parent asks for nothing below it.
    if (over != nullptr && (over->kept || node.part)) node.need = std::min(node.need, 1.0);
    count(node, 1);
    tally_.copies_bytes += copiesOf(node);
    if (node.need > 1.0) {
      enqueue({.need = node.need, .id = node.id, .node = index});
    } else if (node.before == Before::below && node.isDrawn() && !node.part &&
               (stage_ != Stage::whole || !past_.isBackOnItsSurface(node, rules_.tree.children(node.id, *facts)))) {
      enqueue({.need = kKeptNeed, .id = node.id, .node = index, .kept = true});
    }
    return node;
  }

  void look(CutNode& node, const CutNode* parent) {
    ++out_.visited;
    if (parent != nullptr && !parent->seen) return;
    const CutSight::Found found = rules_.sight.look(node, parent);
    out_.culledFrustum += found == CutSight::Found::beyondFrustum ? 1 : 0;
    out_.culledHorizon += found == CutSight::Found::beyondHorizon ? 1 : 0;
  }

  /// It was split, and may be drawn itself again.
  bool mayMerge(const CutNode& node) {
    const bool fits = stage_ == Stage::whole || tally_.copies_bytes <= std::max(options_.copies_bytes, copiesOf(node));
    return fits && past_.isBackOnItsSurface(node, rules_.tree.children(node.id, *node.facts));
  }

  /// The children need not wait for a later frame: they cost no copy, or what is left for copies is enough.
  bool mayCopy(const TileChildren& children, const CutNode& node) const {
    std::uint64_t copies = 0;
    for (const TileFacts* child : children)
      copies += node.shown ? child->copy_bytes : 0;
    const std::uint64_t others = tally_.copies_bytes - copiesOf(node);
    if (copies <= copiesOf(node)) return true;
    return stage_ == Stage::copying && (others == 0 || others + copies <= options_.copies_bytes);
  }

  void want(const tiling::TileId& id, double priority) { out_.wanted.push_back({.id = id, .priority = priority}); }

  /// What better ground in a tile's place adds to the picture: its area. How much too coarse the ground is does not
  /// count beyond that it is: what takes several levels to be fine takes as many times as many tiles.
  double urgencyOf(const TileFacts& facts, double need) const { return std::min(need, 1.0) * shareOf(facts); }
  double shareOf(const TileFacts& facts) const { return std::max(rules_.sight.share(facts), kLeastShare); }

  /// The children that may be seen are there, or are asked for: with one urgency, since the last of them counts.
  /// `cause`: whose better ground they are for.
  bool areReady(const tiling::TileId& id, const TileChildren& children, std::uint8_t inside, const TileFacts& cause,
                double need) {
    bool ready = true;
    double urgency = 0.0;
    for (int q = 0; q < 4; ++q) {
      TileFacts& child = *children[static_cast<std::size_t>(q)];
      if (child.drawable || (!holdsAllReady_ && !rules_.sight.maySee(child, inside))) continue;
      if (ready) urgency = urgencyOf(cause, need);
      want(id.child(q), urgency);
      ready = false;
    }
    return ready;
  }

  /// While a tile waits for its morph, what will be needed below its children comes already.
  void prefetchBelow(const tiling::TileId& id, const TileChildren& children, double priority) {
    for (int q = 0; q < 4; ++q) {
      CutNode child(children[static_cast<std::size_t>(q)], -1);
      child.id = id.child(q);
      if (!child.facts->drawable || child.id.level >= tiling::kMaxLevel) continue;
      // Whether it may be seen is the dearest to ask, and of few that wait it matters.
      child.distance_m = rules_.sight.distance_m(child.facts->tightBox);
      rules_.sight.measure(child);
      if (child.need <= 1.0 || !rules_.sight.maySee(*child.facts, 0)) continue;
      const TileChildren below = rules_.tree.children(child.id, *child.facts);
      if (areReady(child.id, below, 0, *child.facts, std::min(child.need, priority)))
        prefetchBelow(child.id, below, priority);
    }
  }

  bool affords(const CutNode& node, const TileChildren& children, double priority) {
    std::int64_t triangles = tally_.triangles - (node.seen ? node.facts->triangles : 0);
    std::int64_t bytes = tally_.bytes - (node.seen ? static_cast<std::int64_t>(node.facts->bytes) : 0);
    for (const TileFacts* child : children) {
      triangles += node.seen ? child->triangles : 0;
      bytes += node.seen ? static_cast<std::int64_t>(child->bytes) : 0;
    }
    const bool enough = tally_.leaves + (node.seen ? 3 : 0) <= options_.maxTiles &&
                        triangles <= options_.maxTriangles && std::cmp_less_equal(bytes, options_.maxBytes);
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
    if (at(node).facts->isStandIn) {
      want(id, urgencyOf(*at(cause_).facts, priority));
      return false;
    }
    const TileChildren children = rules_.tree.children(id, *at(node).facts);
    if (!affords(at(node), children, priority)) return false;
    const bool isReady = areReady(id, children, at(node).inside, *at(cause_).facts, priority);
    const bool stays = staysFiner(at(node), children);
    if (!isReady && !stays) return false;
    const std::size_t nodes = forest_.nodes.size();
    const bool balanced = splitCoarserAround(node, priority, atAnyCost);
    // What lies around it may have taken the rest.
    if (nodes != forest_.nodes.size() && !affords(at(node), children, priority)) return false;
    if (!past_.mayPart(at(node), children)) {
      at(node).waits = true;
      prefetchBelow(id, children, priority);
      return false;
    }
    if (!balanced && (!stays || refused_)) return false;
    if (!atAnyCost && !mayCopy(children, at(node))) {
      refused_ = true;
      return false;
    }
    replaceByChildren(node, children);
    return true;
  }

  void replaceByChildren(int node, const TileChildren& children) {
    const int first = static_cast<int>(forest_.nodes.size());
    tally_.copies_bytes -= copiesOf(at(node));
    count(at(node), -1);
    for (int q = 0; q < 4; ++q) {
      CutNode& child = add(node, q, children[static_cast<std::size_t>(q)]);
      for (std::size_t place = 0; place < kAround; ++place) {
        const Kin kin = kinAround(q, place);
        child.around[place] = kin.isSibling ? first + kin.which : at(node).around[kin.which];
      }
    }
    at(node).firstChild = first;
  }

  /// It was drawn as finer tiles, or has just come into view, and some of them are here. So it is drawn as those,
  /// whatever is not here beside them: of that a part of this tile's mesh is drawn, or the coarser tile next to it,
  /// joined to the finer ones.
  bool staysFiner(const CutNode& node, const TileChildren& children) const {
    return !holdsAllReady_ && past_.isKnown() && (node.before == Before::below || node.before == Before::nowhere) &&
           std::ranges::any_of(children, &TileFacts::drawable);
  }

  /// What is out of view does not count, unless nothing coarser can be joined to it when it comes into view.
  bool splitCoarserAround(int node, double priority, bool atAnyCost) {
    const int level = at(node).id.level;
    bool balanced = true;
    for (std::size_t place = 0; place < kAround; ++place) {
      bool goesOn = true;
      for (int cover = forest_.covering(node, place);
           goesOn && cover >= 0 && at(cover).id.level < level && (holdsAllReady_ || at(cover).seen);
           cover = forest_.covering(node, place))
        goesOn = split(cover, priority, atAnyCost);
      balanced = balanced && goesOn;  // what the others miss is asked for at once
    }
    return balanced;
  }

  /// Children that leave their parent's surface up to its border need others of their level beyond it.
  void queueRing(int node, double need) {
    const int level = at(node).id.level;
    for (std::size_t place = 0; place < kAround; ++place) {
      const int cover = forest_.covering(node, place);
      if (cover < 0) continue;
      const CutNode& beyond = at(cover);
      if (beyond.id.level == level && beyond.seen && beyond.firstChild < 0 && beyond.need <= 1.0)
        enqueue({.need = 1.0 + 0.25 * (need - 1.0), .id = beyond.id, .node = cover});
    }
  }

  const GrowthRules& rules_;
  const CutOptions& options_;
  const CutPast& past_;
  /// An eye that turns is to find all fit: tiles with all four of their children, and with neighbours that fit them.
  /// Needed only where levels disagree about the ground (CutOptions::isNested): nothing else can be joined there.
  bool holdsAllReady_;
  CutForest& forest_;
  std::vector<WaitingNode>& queue_;
  std::vector<WaitingNode>& costly_;
  LeafTally& tally_;
  Selection& out_;
  enum class Stage : std::uint8_t {
    whole,
    free,
    copying
  } stage_ = Stage::whole;  ///< whatever it costs; else see growWithinCopies
  bool refused_ = false;    ///< a split, for its copies
  int cause_ = -1;          ///< the leaf that is being split, and all that touches it for its sake
};

}  // namespace

void growCut(const GrowthRules& rules, GrowthBuffers& buffers, Selection& out) {
  Growth(rules, buffers, out).run();
}

void growRoots(const GrowthRules& rules, GrowthBuffers& buffers, Selection& out) {
  Growth(rules, buffers, out).addRoots();
}

std::size_t growOn(const GrowthRules& rules, std::size_t most, GrowthBuffers& buffers, Selection& out) {
  return Growth(rules, buffers, out).refine(most);
}

void sortWanted(std::vector<WantedTile>& wanted) {
  std::ranges::sort(wanted, [](const WantedTile& a, const WantedTile& b) {
    return a.id != b.id ? a.id < b.id : a.priority > b.priority;
  });
  const auto again = std::ranges::unique(wanted, {}, &WantedTile::id);
  wanted.erase(again.begin(), again.end());
  std::ranges::sort(wanted, [](const WantedTile& a, const WantedTile& b) {
    return a.priority != b.priority ? a.priority > b.priority : a.id < b.id;
  });
}

}  // namespace tellurion::scene
