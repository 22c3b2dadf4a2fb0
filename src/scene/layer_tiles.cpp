#include "scene/layer_tiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "raster/service_url.h"

namespace tellurion::scene {
namespace {

std::uint64_t bytesOf(const raster::SourceTile& tile) {
  if (const auto* heights = std::get_if<raster::ElevationTile>(&tile.payload)) {
    return sizeof(raster::SourceTile) + heights->samples.samples.size() * sizeof(float);
  }
  return sizeof(raster::SourceTile) +
         std::get<raster::ImageryTile>(tile.payload).pixels.samples.size() * sizeof(raster::Rgba8);
}

/// What is known of tiles that are not kept: about its bytes a tile, and the share of the budget that it may take.
constexpr std::uint64_t kKnownBytes = 64;
constexpr double kKnownShare = 0.1;

/// Whether a tile is what its source says that it holds; the code behind it indexes without looking again.
bool fits(const raster::SourceTile& tile, const raster::TileSourceInfo& info) {
  const int side = info.tileCells + 2 * raster::kGutter;
  if (const auto* heights = std::get_if<raster::ElevationTile>(&tile.payload)) {
    return info.kind == raster::Kind::elevation && heights->samples.width == side + 1 &&
           heights->samples.height == side + 1;
  }
  const auto& pixels = std::get<raster::ImageryTile>(tile.payload).pixels;
  return info.kind == raster::Kind::imagery && pixels.width == side && pixels.height == side;
}

}  // namespace

void LoadLedger::add(LoadFailure failure) {
  // What people are told may be shown to others.
  failure.failure.where = raster::withoutSecrets(failure.failure.where);
  const std::lock_guard lock(mutex_);
  failures_.push_back(std::move(failure));
}

std::vector<LoadFailure> LoadLedger::takeFailures() {
  const std::lock_guard lock(mutex_);
  return std::exchange(failures_, {});
}

LayerTiles::LayerTiles(std::shared_ptr<const raster::TileSource> source, std::uint64_t budgetBytes,
                       std::shared_ptr<LoadLedger> ledger)
    : source_(std::move(source)),
      budgetBytes_(budgetBytes),
      ledger_(std::move(ledger)),
      tellsPresence_(source_->presence({}).has_value()) {}

LayerTiles::TilePointer LayerTiles::kept(const tiling::TileId& id) {
  const std::lock_guard lock(mutex_);
  const auto found = tiles_.find(id);
  if (found == tiles_.end() || found->second.loading) return nullptr;
  uses_.splice(uses_.begin(), uses_, found->second.use);
  return found->second.tile;
}

LayerTiles::TilePointer LayerTiles::held(const tiling::TileId& id) {
  if (!tellsPresence_) return get(id);
  TilePointer tile = kept(id);
  if (!tile && !isMissing(id)) ++refusals_;
  return tile;
}

bool LayerTiles::isMissing(const tiling::TileId& id) const {
  const std::lock_guard lock(mutex_);
  const auto known = known_.find(id);
  return id.level > info().maxLevel || (known != known_.end() && !known->second.stored);
}

LayerTiles::TilePointer LayerTiles::get(const tiling::TileId& id) {
  if (id.level > info().maxLevel) return nullptr;
  {
    std::unique_lock lock(mutex_);
    for (;;) {
      const auto found = tiles_.find(id);
      if (found == tiles_.end()) break;
      if (!found->second.loading) {
        uses_.splice(uses_.begin(), uses_, found->second.use);
        return found->second.tile;
      }
      loaded_.wait(lock);
    }
    const auto known = known_.find(id);
    if (known != known_.end() && !known->second.stored) return nullptr;
    tiles_.try_emplace(id);
  }
  TilePointer tile = load(id);
  const std::lock_guard lock(mutex_);
  known_[id] = tile ? Known{.stored = true, .childMask = tile->childMask} : Known{};
  forget();
  if (!tile) {
    tiles_.erase(id);
  } else {
    uses_.push_front(id);
    const std::uint64_t bytes = bytesOf(*tile);
    tiles_[id] = {.loading = false, .tile = tile, .bytes = bytes, .use = uses_.begin()};
    bytes_ += bytes;
    trim();
  }
  loaded_.notify_all();
  return tile;
}

LayerTiles::TilePointer LayerTiles::load(const tiling::TileId& id) {
  ledger_->countRequest();
  auto loaded = source_->load(id);
  if (!loaded) {
    ledger_->add({.failure = std::move(loaded.error()), .tile = id});
    return nullptr;
  }
  if (!*loaded) {
    // Who tells what is stored without having looked may err.
    if (!tellsPresence_ && parentLists(id)) {
      ledger_->add(
          {.failure = {.code = io::Failure::Code::corrupt,
                       .message = fmt::format("tile {}/{}/{}/{} is missing though its parent lists it; build it again",
                                              id.level, id.root, id.x, id.y),
                       .where = info().name},
           .tile = id});
    }
    return nullptr;
  }
  if (!fits(**loaded, info())) {
    ledger_->add({.failure = {.code = io::Failure::Code::corrupt,
                              .message = "a tile is not of the size and kind that its source states",
                              .where = info().name},
                  .tile = id});
    return nullptr;
  }
  return std::make_shared<const raster::SourceTile>(std::move(**loaded));
}

bool LayerTiles::parentLists(const tiling::TileId& id) const {
  if (id.level == 0) return false;
  const std::lock_guard lock(mutex_);
  const auto parent = known_.find(id.parent());
  return parent != known_.end() && parent->second.stored && ((parent->second.childMask >> id.quadrant()) & 1) != 0;
}

void LayerTiles::forget() {
  const double share = kKnownShare * static_cast<double>(budgetBytes_);
  if (static_cast<double>(known_.size() * kKnownBytes) <= share) return;
  std::erase_if(known_, [&](const auto& k) { return k.second.stored && tiles_.count(k.first) == 0; });
}

void LayerTiles::trim() {
  const std::uint64_t known = known_.size() * kKnownBytes;
  for (auto last = uses_.end(); bytes_ + known > budgetBytes_ && last != std::next(uses_.begin());) {
    --last;
    const auto entry = tiles_.find(*last);
    if (entry->second.tile.use_count() > 1) continue;
    bytes_ -= entry->second.bytes;
    tiles_.erase(entry);
    last = uses_.erase(last);
  }
}

LayerTiles::Known LayerTiles::know(const tiling::TileId& id) {
  {
    const std::lock_guard lock(mutex_);
    const auto known = known_.find(id);
    if (known != known_.end()) return known->second;
  }
  if (const auto presence = source_->presence(id)) {
    const Known told{.stored = presence->stored, .childMask = presence->childMask};
    if (!told.stored) return told;  // not kept: only what is stored is ever forgotten
    const std::lock_guard lock(mutex_);
    known_.try_emplace(id, told);
    forget();
    return told;
  }
  const TilePointer tile = get(id);
  return tile ? Known{.stored = true, .childMask = tile->childMask} : Known{};
}

int LayerTiles::storedLevel(const tiling::TileId& id) {
  const int deepest = std::min<int>(id.level, info().maxLevel);
  for (int level = 0; level <= deepest; ++level) {
    const Known here = know(id.ancestor(level));
    if (!here.stored) return level - 1;
    if (level == deepest) return level;
    const int quadrant = id.ancestor(level + 1).quadrant();
    if (((here.childMask >> quadrant) & 1) == 0) return level;
    if (level + 1 == deepest) {
      // Not loaded for this question alone; one that is known to have failed does not count.
      const std::lock_guard lock(mutex_);
      const auto known = known_.find(id.ancestor(deepest));
      return known != known_.end() && !known->second.stored ? level : deepest;
    }
  }
  return -1;
}

std::optional<io::Failure> LayerTiles::complaint() const {
  auto told = source_->complaint();
  if (told) told->where = raster::withoutSecrets(told->where);
  return told;
}

bool LayerTiles::isFull() const {
  constexpr double kNearlyAll = 0.9;
  const std::lock_guard lock(mutex_);
  return static_cast<double>(bytes_) >= kNearlyAll * static_cast<double>(budgetBytes_);
}

std::uint64_t LayerTiles::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_ + known_.size() * kKnownBytes;
}

}  // namespace tellurion::scene
