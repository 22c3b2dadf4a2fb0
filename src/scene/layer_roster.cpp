#include "scene/layer_roster.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "scene/roster_entry.h"
#include "scene/source_fit.h"

namespace tellurion::scene {
namespace {

constexpr double kOverviewPriority = 1e12;  ///< before all: it is little, and all there is to see
constexpr double kRootPriority = 1e9;       ///< before any tile that is only wanted finer
constexpr double kUnseenGround = 1e3;       ///< likewise: what is out of sight decides on the ground in sight
constexpr double kUnseenPriority = 1e-12;   ///< after them
constexpr std::chrono::seconds kLongestRetry{30};
constexpr std::chrono::seconds kLongestAside{30};
constexpr std::size_t kLayersToAdd = 2;            ///< that find threads free which open them, whoever hangs
constexpr std::chrono::seconds kOverviewAlone{2};  ///< then roots are asked for as well: it may never come

/// The cells a side of the tiles of the first source that is open already, which all others must have.
int firstCells(const LayerSource& source, int soFar, bool& isFirst) {
  if (!source.open || !isFirst) return soFar;
  isFirst = false;
  return source.open->info().tileCells;
}

}  // namespace

LayerRoster::LayerRoster(const Scene& scene, TileFetches& fetches, Doorbell& bell)
    : tiling_(scene.tiling),
      body_(scene.body),
      fetches_(fetches),
      bell_(bell),
      time_s_(scene.clock.start_s.value_or(std::numeric_limits<double>::infinity())),
      ledger_(std::make_shared<LoadLedger>()) {}

LayerRoster::~LayerRoster() = default;

io::Result<std::unique_ptr<LayerRoster>> LayerRoster::create(const Scene& scene, GlobeLayers layers,
                                                             std::uint64_t budgetBytes, TileFetches& fetches,
                                                             Doorbell& bell) {
  std::unique_ptr<LayerRoster> roster(new LayerRoster(scene, fetches, bell));
  std::size_t count = layers.elevation.size() + layers.imagery.size();
  for (const GlobeLayers::Imagery& layer : layers.imagery)
    count += layer.alsoFrom.size() +
             (layer.steps.empty() && !layer.openSteps ? 0 : 2);  // one that is shown, one that goes, one to come
  roster->layerBudgetBytes_ = budgetBytes / std::max<std::size_t>(count, 1);

  bool isFirst = true;
  for (const LayerSource& source : layers.elevation)
    roster->cells_ = firstCells(source, roster->cells_, isFirst);
  for (GlobeLayers::Imagery& layer : layers.imagery)
    roster->layOut(layer);
  for (std::size_t i = 0; i < layers.elevation.size(); ++i) {
    if (auto wrong = roster->take(raster::Kind::elevation, std::move(layers.elevation[i]), i))
      return tl::unexpected(std::move(*wrong));
  }
  for (std::size_t i = 0; i < layers.imagery.size(); ++i) {
    if (auto wrong = roster->takeImagery(std::move(layers.imagery[i]), i)) return tl::unexpected(std::move(*wrong));
  }
  if (const std::size_t late = roster->sourcesToOpen(); late > 0)
    roster->openers_ = std::make_unique<SourceOpeners>(late + kLayersToAdd, bell);
  return roster;
}

/// Sources that are not open, and series, which open one at a time.
std::size_t LayerRoster::sourcesToOpen() const {
  const auto isLate = [](const auto& entry) { return entry->state == Entry::State::opening; };
  return static_cast<std::size_t>(
      std::ranges::count_if(elevation_, isLate) + std::ranges::count_if(imagery_, isLate) +
      std::ranges::count_if(layout_, [](const ImageryLayout& layout) { return layout.series != nullptr; }));
}

io::Result<void> LayerRoster::addImagery(GlobeLayers::Imagery layer) {
  const std::size_t index = layout_.size(), entries = imagery_.size();
  layOut(layer);
  if (auto wrong = takeImagery(std::move(layer), index)) {
    imagery_.resize(entries);
    layout_.pop_back();
    return tl::unexpected(std::move(*wrong));
  }
  if (!openers_ && sourcesToOpen() > 0) openers_ = std::make_unique<SourceOpeners>(kLayersToAdd, bell_);
  return {};
}

void LayerRoster::layOut(GlobeLayers::Imagery& layer) {
  ImageryLayout& layout = layout_.emplace_back();
  if (!layer.steps.empty()) {
    const std::size_t first = stepAt(layer.steps, time_s_);
    layer.source = layer.steps[first].source;
    layout.series = seriesOf(std::move(layer.steps), first, layout_.size() - 1);
  }
  layout.isStrength = layer.look.role != LayerRole::colour;
  bool isFirst = true;
  layout.pixels = firstCells(layer.source, layout.pixels, isFirst);
  for (const LayerSource& set : layer.alsoFrom)
    layout.pixels = firstCells(set, layout.pixels, isFirst);
}

std::optional<io::Failure> LayerRoster::takeImagery(GlobeLayers::Imagery layer, std::size_t index) {
  if (auto wrong = take(raster::Kind::imagery, std::move(layer.source), index)) return wrong;
  if (layer.openSteps) openFirstStep(*imagery_.back(), layer);
  for (LayerSource& set : layer.alsoFrom) {
    if (auto wrong = take(raster::Kind::imagery, std::move(set), index)) return wrong;
  }
  return std::nullopt;
}

std::optional<io::Failure> LayerRoster::take(raster::Kind kind, LayerSource source, std::size_t layer) {
  Entry& entry = add(kind, std::move(source), layer);
  if (!entry.source.open) return std::nullopt;
  auto wrong = misfit(entry.source.open->info(), tiling_, body_, kind, cellsOf(entry));
  if (!wrong && kind == raster::Kind::elevation && !isMeshable(cells_))
    wrong =
        io::Failure{io::Failure::Code::unsupported, "elevation tiles must have 4 to 128 cells a side, a power of two",
                    entry.source.open->info().name};
  if (!wrong) begin(entry, Clock::now(), {});
  return wrong;
}

std::shared_ptr<LayerSeries> LayerRoster::seriesOf(std::vector<TimedSource> steps, std::size_t first,
                                                   std::size_t layer) {
  const auto make = [this, layer](LayerSource::Pointer source) -> io::Result<std::shared_ptr<LayerTiles>> {
    if (auto wrong = misfit(source->info(), tiling_, body_, raster::Kind::imagery, layout_[layer].pixels))
      return tl::unexpected(std::move(*wrong));
    return std::make_shared<LayerTiles>(std::move(source), layerBudgetBytes_, ledger_);
  };
  auto series = std::make_shared<LayerSeries>(std::move(steps), first, make, bell_);
  series->setClock(time_s_, forwards_);
  return series;
}

/// What the entry opens becomes the list of steps, and then the step that the clock had when the globe was made.
void LayerRoster::openFirstStep(Entry& entry, const GlobeLayers::Imagery& layer) {
  entry.steps = std::make_shared<Entry::Steps>();
  entry.source.opening = [steps = entry.steps, openSteps = layer.openSteps,
                          time_s = time_s_]() -> io::Result<LayerSource::Pointer> {
    auto all = openSteps();
    if (!all) return tl::unexpected(std::move(all.error()));
    steps->all = std::move(*all);
    steps->first = stepAt(steps->all, time_s);
    const LayerSource& first = steps->all[steps->first].source;
    return first.open ? io::Result<LayerSource::Pointer>(first.open) : first.opening();
  };
}

int LayerRoster::cellsOf(const Entry& entry) const {
  return entry.kind == raster::Kind::elevation ? cells_ : layout_[entry.layer].pixels;
}

LayerRoster::Entry& LayerRoster::add(raster::Kind kind, LayerSource source, std::size_t layer) {
  auto entry = std::make_unique<Entry>();
  entry->kind = kind;
  entry->layer = layer;
  entry->source = std::move(source);
  auto& all = kind == raster::Kind::elevation ? elevation_ : imagery_;
  return *all.emplace_back(std::move(entry));
}

void LayerRoster::takeOpened(Entry& entry, io::Result<LayerSource::Pointer> source, Clock::time_point now,
                             std::span<const double> rootShares) {
  if (!source) {
    entry.trouble = source.error();
    if (source.error().code != io::Failure::Code::ioError) {
      entry.state = Entry::State::failed;
      ledger_->add({.failure = *std::exchange(entry.trouble, std::nullopt), .tile = {}});
    }
    entry.retryAt = now + entry.retryIn;
    entry.retryIn = std::min(2 * entry.retryIn, kLongestRetry);
    return;
  }
  entry.trouble.reset();
  entry.source.open = std::move(*source);
  auto wrong = misfit(entry.source.open->info(), tiling_, body_, entry.kind, cellsOf(entry));
  if (wrong) {
    entry.state = Entry::State::failed;
    ledger_->add({.failure = std::move(*wrong), .tile = {}});
  } else {
    if (entry.steps)
      layout_[entry.layer].series = seriesOf(std::move(entry.steps->all), entry.steps->first, entry.layer);
    begin(entry, now, rootShares);
  }
}

/// Of an entry that is open: its overview first, if it has one, then its roots.
void LayerRoster::begin(Entry& entry, Clock::time_point now, std::span<const double> rootShares) {
  entry.tiles = std::make_shared<LayerTiles>(entry.source.open, layerBudgetBytes_, ledger_);
  const bool mayLook = entry.kind == raster::Kind::imagery && !entry.steps && !layout_[entry.layer].series;
  if (mayLook && entry.tiles->tellsPresence()) fetchOverview(entry);
  if (entry.overviewRoots.empty()) {
    fetchRoots(entry, rootShares);
  } else {
    entry.state = Entry::State::looking;
    entry.rootsAt = now + kOverviewAlone;
  }
}

/// Of imagery only those in sight, as far as that is known.
void LayerRoster::fetchRoots(Entry& entry, std::span<const double> rootShares) {
  entry.state = Entry::State::fetching;
  for (int root = 0; entry.tiles->tellsPresence() && root < tiling_.rootCount(); ++root) {
    const tiling::TileId id{.level = 0, .root = static_cast<std::uint8_t>(root)};
    if (entry.tiles->storedLevel(id) < 0) continue;
    if (entry.kind == raster::Kind::imagery && !rootShares.empty() && !(rootShares[id.root] > 0.0)) continue;
    auto fetch = fetches_.fetch(*entry.tiles, id, kRootPriority);
    if (fetch) entry.roots.push_back({.root = id.root, .fetch = std::move(fetch)});
  }
  if (entry.roots.empty()) entry.state = Entry::State::ready;
}

/// What goes wrong with it is nobody's business: the roots will tell.
void LayerRoster::fetchOverview(Entry& entry) {
  auto source = entry.source.open->overview();
  if (!source) return;
  entry.overview = std::make_shared<LayerTiles>(std::move(source), layerBudgetBytes_, std::make_shared<LoadLedger>());
  for (int root = 0; root < tiling_.rootCount(); ++root) {
    const tiling::TileId id{.level = 0, .root = static_cast<std::uint8_t>(root)};
    if (auto fetch = fetches_.fetch(*entry.overview, id, kOverviewPriority))
      entry.overviewRoots.push_back(std::move(fetch));
  }
}

void LayerRoster::hurryRoots(Entry& entry, std::span<const double> rootShares) {
  if (rootShares.empty()) return;
  const double unseen = entry.kind == raster::Kind::elevation ? kUnseenGround : kUnseenPriority;
  for (const Entry::Root& root : entry.roots)
    fetches_.hurry(*root.fetch, rootShares[root.root] > 0.0 ? kRootPriority * rootShares[root.root] : unseen);
}

/// Decoded, those out of sight too: no root stands without its picture any more.
bool LayerRoster::hasAllRoots(const Entry& entry) const {
  for (int root = 0; root < tiling_.rootCount(); ++root) {
    const tiling::TileId id{.level = 0, .root = static_cast<std::uint8_t>(root)};
    if (entry.tiles->storedLevel(id) >= 0 && !entry.tiles->kept(id)) return false;
  }
  return true;
}

bool LayerRoster::advance(Clock::time_point now, std::span<const double> rootShares, bool isPending) {
  fetches_.beginPass();
  bool changed = false;
  for (auto* all : {&elevation_, &imagery_}) {
    for (const auto& entry : *all) {
      if (entry->state == Entry::State::opening) {
        if (auto source = entry->opening ? entry->opening->take() : std::nullopt) {
          entry->opening.reset();
          takeOpened(*entry, std::move(*source), now, rootShares);
        }
        if (mayOpen(*entry, now)) entry->opening = openers_->open(entry->source);
      }
      if (mayFetchRoots(*entry, now)) fetchRoots(*entry, rootShares);
      if (entry->state == Entry::State::fetching) {
        hurryRoots(*entry, rootShares);
        if (mayTakePart(*entry, rootShares)) entry->state = Entry::State::ready;
      } else if (lacksRoots(*entry)) {
        hurryRoots(*entry, rootShares);
      }
      if (entry->asideUntil && (!isPending || now >= *entry->asideUntil)) {
        entry->asideUntil.reset();
        changed = true;
      }
      changed = changed || hasMoreToTell(*entry, rootShares, isPending);
    }
  }
  for (const ImageryLayout& layout : layout_) {
    if (layout.series) layout.series->advance(now, *openers_, *ledger_);
  }
  return changed;
}

bool LayerRoster::isOf(const Entry& entry, const LayerTiles* tiles) const {
  if (entry.tiles || entry.kind == raster::Kind::elevation) return entry.tiles.get() == tiles;
  const auto& series = layout_[entry.layer].series;
  return series && series->current()->now().tiles.get() == tiles;
}

bool LayerRoster::setAside(std::span<const LayerTiles* const> waitedFor, Clock::time_point now) {
  std::size_t joining = 0;
  std::vector<Entry*> late;
  for (auto* all : {&elevation_, &imagery_}) {
    for (const auto& entry : *all) {
      if (!joins(*entry)) continue;
      ++joining;
      if (std::ranges::any_of(waitedFor, [&](const LayerTiles* tiles) { return isOf(*entry, tiles); }))
        late.push_back(entry.get());
    }
  }
  if (late.empty() || late.size() == joining) return false;
  for (Entry* entry : late) {
    entry->isTold = entry->isShown;
    entry->toldRoots = entry->shownRoots;
    entry->asideUntil = now + entry->asideFor;
    entry->asideFor = std::min(2 * entry->asideFor, kLongestAside);
  }
  return true;
}

void LayerRoster::isShown() {
  for (auto* all : {&elevation_, &imagery_}) {
    for (const auto& entry : *all) {
      entry->isShown = entry->isTold;
      entry->shownRoots = entry->toldRoots;
      if (entry->asideUntil) entry->asideUntil = Clock::time_point();
      if (entry->isTold) entry->asideFor = RosterEntry::kAsideFirst;
    }
  }
}

/// It is to be opened, or opened again, and would not keep a thread waiting for what others open or wait for already.
bool LayerRoster::mayOpen(const Entry& entry, Clock::time_point now) const {
  return entry.state == Entry::State::opening && !entry.opening && now >= entry.retryAt &&
         openers_->mayOpen(entry.source);
}

bool LayerRoster::isDue(Clock::time_point now) const {
  const auto isDueNow = [&](const auto& entry) {
    return mayOpen(*entry, now) || mayFetchRoots(*entry, now) || (entry->asideUntil && now >= *entry->asideUntil);
  };
  return std::any_of(elevation_.begin(), elevation_.end(), isDueNow) ||
         std::any_of(imagery_.begin(), imagery_.end(), isDueNow) ||
         std::any_of(layout_.begin(), layout_.end(), [&](const ImageryLayout& layout) {
           return layout.series && layout.series->isDue(now, *openers_);
         });
}

void LayerRoster::setClock(double time_s, bool forwards) {
  time_s_ = time_s;
  forwards_ = forwards;
  for (const ImageryLayout& layout : layout_) {
    if (layout.series) layout.series->setClock(time_s, forwards);
  }
}

std::vector<std::shared_ptr<LayerTiles>> LayerRoster::upcoming() const {
  std::vector<std::shared_ptr<LayerTiles>> out;
  for (const ImageryLayout& layout : layout_) {
    auto tiles = layout.series ? layout.series->upcoming() : nullptr;
    if (tiles) out.push_back(std::move(tiles));
  }
  return out;
}

int LayerRoster::stepsComing() const {
  return static_cast<int>(std::count_if(layout_.begin(), layout_.end(), [](const ImageryLayout& layout) {
    return layout.series && layout.series->isComing();
  }));
}

/// A series shows its first step from here on, and others as the clock goes.
void LayerRoster::join(Entry& entry, ColourLayers::Layer& layer) {
  const auto& series = layout_[entry.layer].series;
  if (!series) {
    layer.sets.push_back(entry.tiles);
    if (overviewIsHere(entry)) layer.overviews.push_back({.of = entry.tiles.get(), .tiles = entry.overview});
    return;
  }
  layer.step = series->current();
  if (entry.tiles) series->join(std::exchange(entry.tiles, nullptr));
}

ContentMaker LayerRoster::maker(bool regularMesh, bool compressTextures) {
  std::vector<GroundLayers::Layer> ground;
  std::vector<ColourLayers::Layer> colours;
  for (const ImageryLayout& layout : layout_) {
    ColourLayers::Layer& layer = colours.emplace_back();
    layer.pixels = layout.pixels;
    layer.isStrength = layout.isStrength;
  }
  for (const auto& entry : elevation_) {
    if (!entry->asideUntil) {
      entry->isTold = entry->state == Entry::State::ready;
      entry->toldRoots = entry->isTold ? rootsHere(*entry) : 0;
    }
    if (!entry->isTold) continue;
    ground.emplace_back(entry->tiles, entry->source.seam_m, entry->toldRoots);
  }
  std::vector<bool> isReplaced(layout_.size());
  for (const auto& entry : imagery_) {
    if (!entry->asideUntil) entry->isTold = entry->state == Entry::State::ready;
    if (entry->isTold && entry->source.replacesOthers) isReplaced[entry->layer] = true;
  }
  for (const auto& entry : imagery_) {
    if (entry->isTold && isReplaced[entry->layer] == entry->source.replacesOthers) join(*entry, colours[entry->layer]);
  }
  return {.tiling = tiling_,
          .ellipsoid = body_.ellipsoid,
          .ground = GroundLayers(tiling_, std::move(ground), cells_),
          .colours = ColourLayers(std::move(colours), compressTextures),
          .regularMesh = regularMesh};
}

bool LayerRoster::groundIsNested() const {
  return std::all_of(elevation_.begin(), elevation_.end(),
                     [](const auto& entry) { return !entry->isTold || entry->source.open->info().isNested; });
}

void LayerRoster::rootsAreMade() {
  for (auto* all : {&elevation_, &imagery_}) {
    for (const auto& entry : *all) {
      if (!entry->isTold || lacksRoots(*entry)) continue;
      entry->roots.clear();
      if (!entry->overview || !hasAllRoots(*entry)) continue;
      entry->overview.reset();
      entry->overviewRoots.clear();
    }
  }
}

int LayerRoster::coming() const {
  int count = 0;
  for (const auto* all : {&elevation_, &imagery_}) {
    count +=
        static_cast<int>(std::count_if(all->begin(), all->end(), [](const auto& entry) { return isComing(*entry); }));
  }
  return count;
}

std::uint64_t LayerRoster::bytes() const {
  std::uint64_t bytes = 0;
  for (const auto* all : {&elevation_, &imagery_}) {
    for (const auto& entry : *all)
      bytes += (entry->tiles ? entry->tiles->bytes() : 0) + (entry->overview ? entry->overview->bytes() : 0);
  }
  for (const ImageryLayout& layout : layout_)
    bytes += layout.series ? layout.series->bytes() : 0;
  return bytes;
}

std::vector<io::Failure> LayerRoster::complaints() const {
  std::vector<io::Failure> out;
  for (const auto* all : {&elevation_, &imagery_}) {
    for (const auto& entry : *all) {
      auto told = entry->tiles ? entry->tiles->complaint() : std::nullopt;
      // Heights and the pictures that are made of them have one server.
      if (told && std::ranges::find(out, told->where, &io::Failure::where) == out.end())
        out.push_back(std::move(*told));
    }
  }
  return out;
}

std::vector<io::Failure> LayerRoster::lateLayers() const {
  std::vector<io::Failure> out;
  for (const auto* all : {&elevation_, &imagery_}) {
    for (const auto& entry : *all) {
      if (!isComing(*entry)) continue;
      const char* state = entry->state == Entry::State::opening ? "its server had not told what it offers"
                                                                : "its coarsest images had not all come";
      std::vector<std::string> servers;
      if (entry->state == Entry::State::opening && entry->source.waitsFor) servers = entry->source.waitsFor();
      if (servers.empty()) servers.push_back(entry->source.open ? entry->source.open->info().name : entry->source.name);
      for (std::string& server : servers) {
        io::Failure late{.code = io::Failure::Code::ioError,
                         .message = fmt::format("{}.{} of the scene: {} in time; raise --timeout, or see with "
                                                "'tellurion sources' whether the server answers",
                                                raster::nameOf(entry->kind), entry->layer, state),
                         .where = std::move(server)};
        const auto isSame = [&](const io::Failure& told) {
          return told.where == late.where && told.message == late.message;
        };
        if (std::ranges::none_of(out, isSame)) out.push_back(std::move(late));
      }
    }
  }
  for (std::size_t i = 0; i < layout_.size(); ++i) {
    if (!layout_[i].series || !layout_[i].series->isComing()) continue;
    out.push_back({.code = io::Failure::Code::ioError,
                   .message = "the map of the clock's time had not come in time; raise --timeout",
                   .where = fmt::format("imagery.{} of the scene", i)});
  }
  return out;
}

std::vector<io::Failure> LayerRoster::troubles() const {
  std::vector<io::Failure> out;
  for (const auto* all : {&elevation_, &imagery_}) {
    for (const auto& entry : *all) {
      if (!entry->trouble) continue;
      out.push_back(*entry->trouble);
      if (out.back().where.empty()) out.back().where = entry->source.name;
    }
  }
  return out;
}

}  // namespace tellurion::scene
