#include "scene/tile_forest.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

namespace tellurion::scene {
namespace {

/// What a root's ground may be before it is loaded.
HeightRange unknownRange(const geo::Ellipsoid& ellipsoid) {
  const double share = 0.05 * ellipsoid.semiMinorAxis_m();
  return {.low_m = -std::min(20e3, share), .high_m = std::min(30e3, share)};
}

/// What a tile is charged of a picture: one of an ancestor is copied once for all tiles that it is drawn on, so each is
/// charged a part.
std::uint64_t shareOf(std::uint64_t picture_bytes, int levelsBelow) {
  return picture_bytes >> static_cast<unsigned>(2 * std::clamp(levelsBelow, 0, 2));
}

/// Drawing the last frame has driven records out of the processor's caches: what is read soon is sent for at once,
/// instead of line by line as it is missed. Null is fine.
void expectReading(const TileRecord* r) {
  if (r == nullptr) return;
  constexpr std::ptrdiff_t kLine = 64;
  const auto* begin = reinterpret_cast<const char*>(&r->parts);
  const auto* end = reinterpret_cast<const char*>(&r->lastWanted);
  assert(begin < end);  // the members stand in the order of reading
  for (const auto* line = begin; line < end; line += kLine)
    __builtin_prefetch(line);
}

/// With more of them than that, the longest unused go even where their contents fit.
constexpr std::size_t kRecordsKept = 20000;

std::int64_t trianglesOf(const TerrainMesh& mesh) {
  std::int64_t indices = mesh.interior.count;
  for (const IndexRange& edge : mesh.fineEdge)
    indices += edge.count;
  return indices / 3;
}

}  // namespace

TileForest::TileForest(ContentMaker maker) : maker_(std::move(maker)) {
  records_.reserve(kRecordsKept);  // no update has to move them to a larger table
}

/// What tiles miss, and how fine they must be, depends on which layers are visible.
void TileForest::lookAt(std::span<const LayerLook> looks) {
  isVisible_.resize(looks.size(), false);
  bool same = true;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    same = same && isVisible_[i] == looks[i].visible;
    isVisible_[i] = looks[i].visible;
  }
  if (same) return;
  ++visibility_;
  ++residency_;
}

void TileForest::begin(double exaggeration, std::span<const LayerLook> looks, const Residency* gpu) {
  if (!isSortedOut_) sortOutUnused();  // nobody had it evict
  isSortedOut_ = false;
  for (const TileRecord* r : lastUsed_)  // mostly what this one uses
    expectReading(r);
  ++updates_;
  lookAt(looks);
  exaggeration_ = exaggeration;
  const std::uint64_t now = gpu != nullptr ? gpu->departures() : 0;
  if (gpu != gpu_ || now != departures_) ++residency_;
  gpu_ = gpu;
  departures_ = now;
  arrivals_ = gpu != nullptr ? gpu->arrivals() : 0;
}

bool TileForest::isAsAt(double exaggeration, std::span<const LayerLook> looks, const Residency* gpu) const {
  return exaggeration == exaggeration_ && gpu == gpu_ && (gpu == nullptr || gpu->departures() == departures_) &&
         std::ranges::equal(looks, isVisible_, {}, &LayerLook::visible);
}

/// Whatever the cut looks at counts as used, siblings that wait for each other too: else a small budget would drop
/// the first of four children before the last has come, for ever.
void TileForest::countAsUsed(TileRecord& r) {
  if (r.lastUse == updates_) return;
  if (r.isUnused) unused_.remove(r);
  r.lastUse = updates_;
  (isSortedOut_ ? lastUsed_ : used_).push_back(&r);
}

TileFacts* TileForest::use(TileRecord& r) {
  countAsUsed(r);
  if (r.madeFor != exaggeration_) {
    makeBox(r);
    if (r.content) takeFacts(r);
  }
  if (r.content && r.visibility != visibility_) takeTexels(r);
  takeCopies(r);
  return &r;
}

TileFacts* TileForest::root(int root) {
  return use(record({.level = 0, .root = static_cast<std::uint8_t>(root)}));
}

std::array<TileFacts*, 4> TileForest::children(const tiling::TileId& id, TileFacts& facts) {
  TileRecord& r = static_cast<TileRecord&>(facts);
  for (const TileRecord* child : r.children)
    expectReading(child);
  std::array<TileFacts*, 4> out{};
  for (int q = 0; q < 4; ++q) {
    TileRecord*& child = r.children[static_cast<std::size_t>(q)];
    if (child == nullptr) child = &record(id.child(q));
    out[static_cast<std::size_t>(q)] = use(*child);
  }
  return out;
}

/// What is on the GPU stays there, and is not asked for again, until something leaves; what is missing, until something
/// comes.
void TileForest::takeCopies(TileRecord& r) const {
  if (gpu_ == nullptr || !r.content) {
    r.copy_bytes = 0;
    r.residency = 0;
  } else if (r.residency != residency_ || (r.copy_bytes > 0 && r.arrivals != arrivals_)) {
    const TileContent& c = *r.content;
    r.copy_bytes = gpu_->missingBytes(*c.mesh);
    if (c.relief) r.copy_bytes += shareOf(gpu_->missingReliefBytes(*c.relief), r.id.level - c.reliefLevel);
    for (std::size_t i = 0; i < c.pictures.size(); ++i) {
      const LayerPicture& picture = c.pictures[i];
      if (picture.image && isVisible_[i])
        r.copy_bytes += shareOf(gpu_->missingColourBytes(*picture.image), r.id.level - picture.level);
    }
    r.residency = residency_;
    r.arrivals = arrivals_;
  }
}

void TileForest::takeTexels(TileRecord& r) const {
  r.texel_m = texelOf_m(*r.content, maker_.colours, isVisible_);
  r.visibility = visibility_;
}

void TileForest::takeParts(TileRecord& r) const {
  r.parts = exaggeration_ == 1.0 ? std::span(r.content->parts) : std::span<const OrientedBox>();
}

TileRecord& TileForest::record(const tiling::TileId& id) {
  const auto [found, isNew] = records_.try_emplace(id);
  TileRecord& r = found->second;
  if (isNew) {
    r.id = id;
    r.corners = tileCorners(maker_.tiling, id);
    r.around = tilesAround(maker_.tiling, id);
    makeBox(r);
    countAsUsed(r);
  }
  return r;
}

const TileRecord* TileForest::find(const tiling::TileId& id) const {
  const auto found = records_.find(id);
  return found != records_.end() ? &found->second : nullptr;
}

/// Metres by which a tile drawn as its parent's mesh may leave the parent's samples: that misses them by a little more
/// than its tolerance.
double TileForest::reachOfParent_m(const tiling::TileId& id) const {
  return 2.0 * meshTolerance_m(maker_.tiling, maker_.ellipsoid, id.level - 1, maker_.ground.cells());
}

/// Holds ground of these heights as it is drawn.
OrientedBox TileForest::drawnBox(const tiling::TileId& id, const HeightRange& range) const {
  // What is lifted goes along normals of 16 bits, which lean by up to one part in 32767.
  const double lean_m =
      std::abs(exaggeration_ - 1.0) * std::max(std::abs(range.low_m), std::abs(range.high_m)) / 32767.0;
  const HeightRange drawn{.low_m = range.low_m * exaggeration_, .high_m = range.high_m * exaggeration_};
  return grown(estimatedBox(maker_.tiling, maker_.ellipsoid, id, drawn), lean_m);
}

/// What is known of a tile without its content: a box from what its parent tells.
void TileForest::makeBox(TileRecord& r) const {
  const tiling::TileId& id = r.id;
  r.madeFor = exaggeration_;
  HeightRange range = unknownRange(maker_.ellipsoid);
  if (id.level > 0) {
    const TileRecord* parent = find(id.parent());
    if (parent != nullptr && parent->content)
      range = parent->content->childRange[static_cast<std::size_t>(id.quadrant())];
    const double reach_m = reachOfParent_m(id);
    range = {.low_m = range.low_m - reach_m, .high_m = range.high_m + reach_m};
  }
  r.box = drawnBox(id, range);
}

/// What its content adds.
void TileForest::takeFacts(TileRecord& r) const {
  const TileContent& content = *r.content;
  const double more = std::max(1.0, exaggeration_);
  r.drawable = true;
  r.isStandIn = content.isStandIn;
  r.error_m = content.error_m * more;
  takeTexels(r);
  r.spacing_m = content.spacing_m;
  r.triangles = trianglesOf(*content.mesh);
  r.bytes = content.bytes;
  r.tightBox = exaggeration_ == 1.0 ? content.box
                                    : grown(drawnBox(r.id, content.range), r.error_m + more * reachOfParent_m(r.id));
  takeParts(r);
  // What a root was assumed to hold may be too little. All roots are waited for, so a complete cut does not depend on
  // when they came.
  if (r.id.level == 0) r.box = r.tightBox;
}

void TileForest::take(const tiling::TileId& id, std::shared_ptr<const TileContent> content) {
  TileRecord& r = record(id);
  r.job.reset();
  if (r.content) contentBytes_ -= r.content->bytes;
  r.content = std::move(content);
  r.residency = 0;
  if (r.madeFor != exaggeration_) makeBox(r);
  takeFacts(r);
  countAsUsed(r);
  contentBytes_ += r.content->bytes;
}

void TileForest::renew(const tiling::TileId& id, std::shared_ptr<const TileContent> content) {
  TileRecord& r = record(id);
  ++renewals_;
  contentBytes_ += content->bytes - r.content->bytes;
  r.content = std::move(content);
  r.bytes = r.content->bytes;
  r.residency = 0;
  takeTexels(r);
  takeParts(r);
}

double TileForest::occluderDepth_m() const {
  double lowest_m = 0.0;
  for (int root = 0; root < maker_.tiling.rootCount(); ++root) {
    const TileRecord* found = find({.level = 0, .root = static_cast<std::uint8_t>(root)});
    const bool known = found != nullptr && found->content;
    lowest_m = std::min(lowest_m, (known ? found->content->range : unknownRange(maker_.ellipsoid)).low_m);
  }
  return -lowest_m * exaggeration_;
}

/// What the last update used and this one did not goes to the others, the deepest first: children go before their
/// parents.
void TileForest::sortOutUnused() {
  std::erase_if(lastUsed_, [&](const TileRecord* r) { return r->lastUse == updates_ || r->isUnused; });
  std::ranges::sort(lastUsed_, [](const TileRecord* a, const TileRecord* b) {
    return a->id.level != b->id.level ? a->id.level > b->id.level : a->id < b->id;
  });
  for (TileRecord* r : lastUsed_) {
    if (!r->isUnused) unused_.add(*r);
  }
  std::swap(lastUsed_, used_);
  used_.clear();
  isSortedOut_ = true;
}

void TileForest::evict(std::uint64_t budgetBytes, std::uint64_t heldSince) {
  if (!isSortedOut_) sortOutUnused();  // once a cut, or what that used would be forgotten
  while (contentBytes_ > budgetBytes || records_.size() > kRecordsKept) {
    TileRecord* r = unused_.oldest();
    if (r == nullptr || r->lastUse >= heldSince) return;
    unused_.remove(*r);
    if (r->job || r->lastWanted == updates_) {
      lastUsed_.push_back(r);  // it counts as used, as long as it is on its way
    } else {
      drop(*r);
    }
  }
}

void TileForest::drop(TileRecord& r) {
  const tiling::TileId id = r.id;
  if (r.content) contentBytes_ -= r.content->bytes;
  const auto parent = id.level > 0 ? records_.find(id.parent()) : records_.end();
  if (parent != records_.end()) parent->second.children[static_cast<std::size_t>(id.quadrant())] = nullptr;
  records_.erase(id);
}

}  // namespace tellurion::scene
