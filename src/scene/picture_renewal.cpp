#include "scene/picture_renewal.h"

#include <algorithm>
#include <utility>

namespace tellurion::scene {
namespace {

/// Before tiles that are only wanted finer, after roots.
constexpr double kRenewalPriority = 1e8;
/// After all that is in the picture.
constexpr double kAheadPriority = -1.0;
/// Of one step at a time, so that little is in the way when the clock turns round.
constexpr std::size_t kMostAhead = 32;

std::uint64_t missingBytes(const TileContent& content, const Residency* gpu) {
  std::uint64_t bytes = 0;
  for (const LayerPicture& picture : content.pictures) {
    if (gpu != nullptr && picture.isOwn && picture.image) bytes += gpu->missingColourBytes(*picture.image);
  }
  return bytes;
}

std::shared_ptr<const TileContent> contentOf(const TileForest& forest, const tiling::TileId& id) {
  const TileRecord* record = forest.find(id);
  return record != nullptr ? record->content : nullptr;
}

}  // namespace

struct PictureRenewal::Arrivals {
  std::mutex mutex;
  std::vector<Made> waiting;
};

PictureRenewal::PictureRenewal(const ColourLayers& colours, io::Executor& executor, TileFetches& fetches,
                               Doorbell& bell)
    : colours_(std::make_shared<const ColourLayers>(colours)),
      executor_(executor),
      fetches_(fetches),
      bell_(bell),
      arrivals_(std::make_shared<Arrivals>()) {}

PictureRenewal::~PictureRenewal() {
  for (const auto& [id, job] : jobs_) {
    if (!job->taken.exchange(true)) job->task.cancel();
  }
  for (const Ahead& ahead : ahead_) {
    for (const Ahead::Load& load : ahead.loads)
      load.task.cancel();
  }
}

/// Those that are drawn, each after the ancestors whose pictures it shows.
std::vector<tiling::TileId> PictureRenewal::staleTiles(const TileForest& forest,
                                                       const std::vector<SelectedTile>& drawn) {
  std::vector<tiling::TileId> stale;
  listed_.clear();
  for (const SelectedTile& tile : drawn)
    addStale(forest, tile.id, stale);
  std::ranges::stable_sort(stale, {}, [](const tiling::TileId& id) { return id.level; });
  return stale;
}

void PictureRenewal::addStale(const TileForest& forest, const tiling::TileId& id, std::vector<tiling::TileId>& stale) {
  const auto content = contentOf(forest, id);
  if (!content || colours_->areUpToDate(content->pictures) || !listed_.insert(id).second) return;
  stale.push_back(id);
  for (const LayerPicture& picture : content->pictures) {
    if (picture.level < id.level) addStale(forest, id.ancestor(picture.level), stale);
  }
}

/// What is made, once there is room for its copy. False: there is nothing made of this tile as it is.
bool PictureRenewal::exchange(TileForest& forest, const tiling::TileId& id, const Residency* gpu,
                              std::uint64_t& spare_bytes, bool mayExceed) {
  const auto found = made_.find(id);
  if (found == made_.end()) return false;
  if (found->second.from != contentOf(forest, id)) {
    made_.erase(found);
    return false;
  }
  const std::uint64_t bytes = missingBytes(*found->second.content, gpu);
  if (bytes > spare_bytes && !mayExceed) return true;
  spare_bytes -= std::min(bytes, spare_bytes);
  forest.renew(id, std::move(found->second.content));
  made_.erase(found);
  return true;
}

/// A picture that is an ancestor's waits for it.
bool PictureRenewal::canBegin(const TileForest& forest, const tiling::TileId& id, const TileContent& content) const {
  return std::ranges::all_of(content.pictures, [&](const LayerPicture& picture) {
    if (picture.level >= id.level) return true;
    const auto over = contentOf(forest, id.ancestor(picture.level));
    return !over || colours_->areUpToDate(over->pictures);
  });
}

void PictureRenewal::begin(const tiling::TileId& id, TileJob& job) {
  needs_.clear();
  colours_->addNeedsOfSteps(id, needs_);
  for (const TileNeed& need : needs_) {
    if (auto tile = need.tiles->kept(need.id)) {
      job.kept.push_back(std::move(tile));
    } else if (!need.tiles->isMissing(need.id)) {
      auto fetch = fetches_.fetch(*need.tiles, need.id, kRenewalPriority);
      (fetch ? job.missing : job.fetched).push_back({.need = need, .fetch = std::move(fetch)});
    }
  }
}

void PictureRenewal::make(TileForest& forest, const tiling::TileId& id) {
  const auto content = contentOf(forest, id);
  auto& job = jobs_[id];
  if (!job) {
    if (!canBegin(forest, id, *content)) return;
    job = std::make_shared<TileJob>();
    begin(id, *job);
  }
  while (!job->missing.empty() && job->missing.back().fetch->isReady()) {
    job->fetched.push_back(std::move(job->missing.back()));
    job->missing.pop_back();
  }
  if (job->missing.empty() && !job->submitted) submit(forest, id, content);
}

void PictureRenewal::submit(const TileForest& forest, const tiling::TileId& id,
                            const std::shared_ptr<const TileContent>& content) {
  std::vector<LayerPicture> over(content->pictures.size());
  for (std::size_t i = 0; i < over.size(); ++i) {
    const int level = content->pictures[i].level;
    const auto from = id.level > 0 ? contentOf(forest, id.ancestor(std::min(level, id.level - 1))) : nullptr;
    over[i] = from ? from->pictures[i] : content->pictures[i];
  }
  const auto& job = jobs_[id];
  job->submitted = true;
  job->task = executor_.submit(kRenewalPriority, [id, content, over = std::move(over), job = job, colours = colours_,
                                                  editions = editions_, arrivals = arrivals_, &bell = bell_] {
    if (job->taken.exchange(true)) return;
    std::shared_ptr<const TileContent> made;
    if (colours->editions() == editions) {
      for (const TileJob::Part& part : job->fetched) {
        if (auto tile = part.need.tiles->get(part.need.id)) job->kept.push_back(std::move(tile));
      }
      made = withPictures(*content, colours->renewed(id, content->pictures, over));
      // Another step has nothing at hand: what was made of it lacks everything.
      if (colours->editions() != editions) made.reset();
    }
    {
      const std::lock_guard lock(arrivals->mutex);
      arrivals->waiting.push_back({.id = id, .from = content, .content = std::move(made)});
    }
    bell.ring();
  });
}

/// What is not drawn any more, or is up to date.
void PictureRenewal::forget(const std::vector<tiling::TileId>& stale) {
  if (stale.empty() && jobs_.empty() && made_.empty()) return;
  std::erase_if(made_, [&](const auto& each) { return listed_.count(each.first) == 0; });
  std::erase_if(jobs_, [&](const auto& each) {
    if (each.second && (listed_.count(each.first) != 0 || each.second->taken.exchange(true))) return false;
    if (each.second) each.second->task.cancel();
    return true;
  });
}

/// What was fetched for another step is of no use, and nobody may wait for what was not fetched.
void PictureRenewal::restart() {
  auto editions = colours_->editions();
  if (editions == editions_) return;
  editions_ = std::move(editions);
  std::erase_if(jobs_, [](const auto& each) {
    if (each.second && each.second->taken.exchange(true)) return false;
    if (each.second) each.second->task.cancel();
    return true;
  });
}

void PictureRenewal::update(TileForest& forest, const std::vector<SelectedTile>& drawn, const Residency* gpu,
                            std::uint64_t& spareCopies_bytes, const std::vector<std::shared_ptr<LayerTiles>>& upcoming,
                            bool allIsHere) {
  if (!colours_->followsClock()) return;
  {
    const std::lock_guard lock(arrivals_->mutex);
    for (Made& made : arrivals_->waiting) {
      jobs_.erase(made.id);
      if (made.content) made_[made.id] = std::move(made);
    }
    arrivals_->waiting.clear();
  }
  restart();
  const std::vector<tiling::TileId> stale = staleTiles(forest, drawn);
  const std::size_t before = made_.size();
  for (const tiling::TileId& id : stale) {
    if (!exchange(forest, id, gpu, spareCopies_bytes, made_.size() == before)) make(forest, id);
  }
  forget(stale);
  outOfDate_ = static_cast<int>(std::ranges::count_if(drawn, [&](const SelectedTile& tile) {
    const auto content = contentOf(forest, tile.id);
    return content && !colours_->areUpToDate(content->pictures);
  }));
  loadAhead(forest, drawn, stale.empty() ? upcoming : std::vector<std::shared_ptr<LayerTiles>>(), allIsHere);
}

void PictureRenewal::advance(Ahead& ahead) {
  std::erase_if(ahead.loads, [](const Ahead::Load& load) { return load.done->load(); });
  for (Ahead::Load& load : ahead.loads) {
    if (load.fetch && load.fetch->isReady()) {
      load.task = executor_.submit(
          kAheadPriority, [tiles = ahead.tiles, id = load.id, fetch = std::move(load.fetch), done = load.done] {
            tiles->get(id);
            done->store(true);
          });
    }
  }
}

/// Of what is drawn the same tiles, as far as the cache of the step holds them.
void PictureRenewal::loadAhead(const TileForest& forest, const std::vector<SelectedTile>& drawn,
                               const std::vector<std::shared_ptr<LayerTiles>>& upcoming, bool allIsHere) {
  std::erase_if(ahead_, [&](const Ahead& ahead) {
    if (std::ranges::find(upcoming, ahead.tiles) != upcoming.end()) return false;
    for (const Ahead::Load& load : ahead.loads)
      load.task.cancel();
    return true;
  });
  for (const auto& tiles : upcoming) {
    auto found = std::ranges::find(ahead_, tiles, &Ahead::tiles);
    if (found == ahead_.end()) {
      ahead_.push_back({.tiles = tiles, .asked = {}, .loads = {}});
      found = ahead_.end() - 1;
    }
    advance(*found);
    if (!allIsHere) continue;
    for (const SelectedTile& tile : drawn) {
      const auto content = contentOf(forest, tile.id);
      const int level = content ? colours_->levelOfSteps(content->pictures) : -1;
      // Where only what is above a tile tells that it is stored, that is needed too.
      for (int each = tiles->tellsPresence() ? level : std::min(level, 0); each >= 0 && each <= level; ++each) {
        if (found->loads.size() >= kMostAhead || tiles->isFull()) break;
        askAhead(*found, tile.id.ancestor(each));
      }
    }
  }
}

void PictureRenewal::askAhead(Ahead& ahead, const tiling::TileId& id) {
  const auto& tiles = ahead.tiles;
  if (!ahead.asked.insert(id).second || tiles->kept(id) || tiles->isMissing(id)) return;
  Ahead::Load load{.id = id, .fetch = nullptr, .task = {}, .done = std::make_shared<std::atomic<bool>>(false)};
  load.fetch = fetches_.fetch(*tiles, id, kAheadPriority);
  if (!load.fetch) {
    load.task = executor_.submit(kAheadPriority, [tiles, id, done = load.done] {
      tiles->get(id);
      done->store(true);
    });
  }
  ahead.loads.push_back(std::move(load));
}

}  // namespace tellurion::scene
