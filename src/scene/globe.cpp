#include "scene/globe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>
#include <utility>

#include "geo/sun.h"
#include "raster/service_url.h"
#include "scene/drawn_patches.h"
#include "scene/frame_tiles.h"
#include "scene/generation.h"
#include "scene/layer_roster.h"
#include "scene/layer_sources.h"
#include "scene/picture_renewal.h"
#include "scene/succession.h"
#include "scene/view_motion.h"

namespace tellurion::scene {
namespace {

using Clock = std::chrono::steady_clock;

/// Of the byte budget, what decoded source tiles may take; the rest is for meshes and textures.
constexpr double kSourceShare = 0.25;

/// A generation to come keeps others waiting no longer than this: from then on layers join without those that hold it
/// up, and when for so long nothing of it has come, what is shown goes on becoming finer.
constexpr std::chrono::seconds kLongestPending{1};

/// Failures that are kept: a server that lacks everything has one for each tile.
constexpr std::size_t kMostFailures = 1000;

}  // namespace

struct Globe::State {
  State(const Scene& scene, const GlobeOptions& given)
      : globeOptions(given),
        body(scene.body),
        motion(scene.body.ellipsoid),
        lighting(scene.lighting),
        sky(scene.sky),
        executor(given.workers, io::Executor::Share::background) {
    frame.background = scene.background;
    frame.air = scene.air;
    frame.ellipsoid = scene.body.ellipsoid;
    frame.vertexGrid_m = vertexGrid_m(body.ellipsoid);
  }

  /// Those who wait for a network are not waited for.
  ~State() {
    if (resources) resources->cancelWaits();
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void name(const GlobeLayers::Imagery& layer);
  std::unique_ptr<Generation> generation();
  void show(std::unique_ptr<Generation> one);
  void renewPictures(const Selection& selection, const Residency* gpu);
  void receive();
  std::optional<View> viewAhead(const View& view, const CutOptions& options);
  void beginNext(Clock::time_point now);
  bool mayTakeOver(const Selection& ofShown, const CutOptions& options) const;
  bool nextStandsStill(Clock::time_point now) const;
  void request(const View& view, const CutOptions& options, const Selection& ofShown);
  const Selection& cut(const View& view, const CutOptions& options, const Residency* gpu, bool hasCome);
  void refreshFrame(const View& view, const Selection& selection);
  bool frameIsOfTheseTiles() const;
  std::uint64_t retiredBytes() const;
  std::uint64_t sourceBudget() const;
  void evict();
  void fillTiles(const Selection& selection);
  void fillSoon(const Selection& selection);
  void fillStatistics(const Selection& selection);
  void fillDebug(const CutOptions& options);
  Light lightFor(const View& view) const;

  GlobeOptions globeOptions;
  geo::Body body;
  ViewMotion motion;
  Lighting lighting;
  SkySettings sky;
  SkyPlaces skyPlaces;  ///< at the clock's time
  /// An image that cannot be had fails every tile that it is a part of: it is told once.
  std::vector<io::Failure> failures;
  std::unordered_map<std::string, std::size_t> failureNumbers;  ///< by their words
  struct FailedTile {
    std::size_t failure = 0;             ///< of failures
    std::optional<tiling::TileId> tile;  ///< none: a whole layer
  };
  std::vector<FailedTile> failedTiles;
  std::uint64_t failureCount = 0;
  std::shared_ptr<io::Resources> resources;
  Doorbell bell;
  TileFetches fetches{bell};
  std::unique_ptr<LayerRoster> roster;
  std::unique_ptr<Generation> shown;                 ///< what is drawn; never null
  std::unique_ptr<Generation> next;                  ///< with layers that have joined, until it is good enough; or null
  std::vector<std::unique_ptr<Generation>> retired;  ///< until their workers are done
  std::unique_ptr<PictureRenewal> renewal;           ///< of shown
  std::optional<double> time_s;                      ///< of the clock
  std::optional<geo::Vec3> sunByClock;               ///< towards the sun at that time, where it is known
  std::uint64_t spareCopies_bytes = 0;               ///< what this update's pictures leave of CutOptions::copies_bytes
  Clock::time_point pendingSince;                    ///< of next
  bool shownGoesOn = true;                           ///< shown was asked for in the last update
  const Selection* nextCut = nullptr;                ///< of this update; null without next
  std::vector<std::string> imageryNames;
  std::vector<std::uint32_t> imageryOrder;  ///< bottom first
  bool isKept = false;                      ///< this update keeps the last one's cut
  std::uint64_t frameRenewals = 0;          ///< TileForest's, of the frame's tiles
  Frame frame;
  FrameTiles frameTiles;  ///< fills it
  DrawnPatches patches;   ///< likewise, after that
  io::Executor executor;  ///< last: its workers use what stands above
};

/// A layer on top of those that have been named.
void Globe::State::name(const GlobeLayers::Imagery& layer) {
  imageryOrder.push_back(static_cast<std::uint32_t>(imageryNames.size()));
  frame.looks.push_back(layer.look);
  const LayerSource& named = layer.steps.empty() ? layer.source : layer.steps.front().source;
  const std::string& source = named.open ? named.open->info().name : named.name;
  imageryNames.push_back(layer.name.empty() ? source.substr(source.find_last_of('/') + 1) : layer.name);
}

std::unique_ptr<Generation> Globe::State::generation() {
  ContentMaker maker = roster->maker(globeOptions.regularMesh, globeOptions.compressTextures);
  return std::make_unique<Generation>(std::move(maker), roster->groundIsNested(), executor, fetches, bell);
}

void Globe::State::show(std::unique_ptr<Generation> one) {
  if (shown) retired.push_back(std::move(shown));
  shown = std::move(one);
  roster->isShown();
  renewal = std::make_unique<PictureRenewal>(shown->forest.maker().colours, executor, fetches, bell);
}

void Globe::State::renewPictures(const Selection& selection, const Residency* gpu) {
  spareCopies_bytes = selection.spareCopies_bytes;
  const bool allIsHere = !next && roster->coming() == 0 && selection.wanted.empty() && shown->loading.isIdle();
  renewal->update(shown->forest, selection.drawn, gpu, spareCopies_bytes, roster->upcoming(), allIsHere);
}

void Globe::State::receive() {
  for (const auto& old : retired)
    old->loading.receive();
  std::erase_if(retired, [](const auto& old) { return old->loading.isIdle(); });
  for (LoadFailure& failed : roster->ledger().takeFailures()) {
    ++failureCount;
    if (failedTiles.size() >= kMostFailures) continue;
    const auto [known, isNew] = failureNumbers.try_emplace(io::describe(failed.failure), failures.size());
    if (isNew) failures.push_back(std::move(failed.failure));
    failedTiles.push_back({.failure = known->second, .tile = failed.tile});
  }
}

/// What will be looked at soon, where that is another view.
std::optional<View> Globe::State::viewAhead(const View& view, const CutOptions& options) {
  if (!options.time_s || !options.prefetch) {
    motion.forget();
    return std::nullopt;
  }
  constexpr double kAhead_s = 1.0;
  motion.add(view, *options.time_s);
  return motion.ahead(kAhead_s);
}

/// The one before it, if there is one, lets go of what is on its way only after this one has asked for it.
void Globe::State::beginNext(Clock::time_point now) {
  if (next) retired.push_back(std::move(next));
  next = generation();
  pendingSince = now;
}

/// Nothing gets coarser by it; to a planet without any layer all is better.
bool Globe::State::mayTakeOver(const Selection& ofShown, const CutOptions& options) const {
  if (!next->rootsAreDrawable()) return false;
  if (shown->forest.maker().isBare()) return true;
  return (nextCut->wanted.empty() || !next->lacksRoots()) && isAsFineAs(*nextCut, ofShown, options.tolerance_px);
}

/// For a while nothing of the generation to come has been made: it may be that its servers hang.
bool Globe::State::nextStandsStill(Clock::time_point now) const {
  return next && now - std::max(pendingSince, next->lastArrival()) >= kLongestPending;
}

/// First who asks, then who lets go: what both need is not fetched again. What is shown is asked for after what is to
/// come, whose days come, and only when that stands still.
void Globe::State::request(const View& view, const CutOptions& options, const Selection& ofShown) {
  const std::optional<View> soon = viewAhead(view, options);
  // An update that keeps the cut has time for what lies ahead.
  const bool wasKept = std::exchange(isKept, shown->age() > 0);
  if (isKept) {
    shown->ahead.look(soon, options, shown->forest);
    return;
  }
  const auto ask = [&](Generation& one, const Selection& selection) {
    if (!soon || !wasKept) one.ahead.look(soon, options, one.forest);
    one.loading.request(selection.wanted, one.ahead.wanted(one.forest));
  };
  shownGoesOn = !next || nextStandsStill(Clock::now());
  if (next && shownGoesOn) ask(*shown, ofShown);
  next ? ask(*next, *nextCut) : ask(*shown, ofShown);
  if (!shownGoesOn) {
    shown->ahead.look(std::nullopt, options, shown->forest);
    shown->loading.pause();
  }
  for (const auto& old : retired)
    old->loading.stop();
}

/// What is drawn, and what is asked for.
const Selection& Globe::State::cut(const View& view, const CutOptions& cutOptions, const Residency* gpu, bool hasCome) {
  const auto now = Clock::now();
  if (roster->advance(now, shown->rootShares(), next != nullptr)) beginNext(now);
  const auto cutThrough = [&](Generation& one) {
    return &one.cut(view, cutOptions, frame.exaggeration, frame.looks, gpu, !next, hasCome);
  };
  const Selection* selection = cutThrough(*shown);
  nextCut = next ? cutThrough(*next) : nullptr;
  if (next && mayTakeOver(*selection, cutOptions)) {
    show(std::move(next));
    selection = std::exchange(nextCut, nullptr);
  } else if (next && now - pendingSince >= kLongestPending && roster->setAside(next->waitedFor(), now)) {
    beginNext(now);
    nextCut = cutThrough(*next);
  }
  request(view, cutOptions, *selection);
  if (!next) roster->rootsAreMade();
  return *selection;
}

std::uint64_t Globe::State::retiredBytes() const {
  std::uint64_t bytes = 0;
  for (const auto& old : retired)
    bytes += old->forest.contentBytes();
  return bytes;
}

std::uint64_t Globe::State::sourceBudget() const {
  return static_cast<std::uint64_t>(kSourceShare * static_cast<double>(globeOptions.cpuCacheBytes));
}

/// Each keeps what it needs, and all together no more than the budget where that is enough. Source tiles that workers
/// hold may be more than their share: then it is contents that go. Told is what is left, in the same breath: between
/// two updates nothing but source tiles comes, up to their share.
void Globe::State::evict() {
  const std::uint64_t budget = globeOptions.cpuCacheBytes;
  const std::uint64_t ofSources = roster->bytes();
  const std::uint64_t others = retiredBytes() + std::max(ofSources, sourceBudget());
  const auto left = [&](std::uint64_t more) { return budget - std::min(budget, others + more); };
  shown->evict(left(next ? next->forest.contentBytes() : 0));
  if (next) next->evict(left(shown->forest.contentBytes()));
  FrameStatistics& s = frame.statistics;
  s.cpuCacheBytes =
      shown->forest.contentBytes() + (next ? next->forest.contentBytes() : 0) + retiredBytes() + ofSources;
  s.cpuCacheOver_bytes = s.cpuCacheBytes - std::min(s.cpuCacheBytes, budget);
}

Light Globe::State::lightFor(const View& view) const {
  Light light{.enabled = lighting.enabled, .toSun_body = lighting.subsolar.n, .ambient = lighting.ambient};
  if (lighting.sun == Lighting::Sun::byClock && sunByClock) light.toSun_body = *sunByClock;
  if (lighting.sun == Lighting::Sun::withCamera) {
    // Behind the eye, to the left and above: 35 degrees off the line of sight, as maps are lit.
    light.toSun_body = glm::transpose(view.viewFromBody) * geo::normalize(geo::Vec3(-0.5, 0.5, 1.0));
  }
  return light;
}

/// All of the frame but its tiles.
void Globe::State::refreshFrame(const View& view, const Selection& selection) {
  frame.view = view;
  frame.light = lightFor(view);
  frame.sky = skyFor(sky, skyPlaces, body, lighting.enabled && lighting.sun != Lighting::Sun::withCamera);
  fillStatistics(selection);
  const FrameStatistics& s = frame.statistics;
  frame.complete = s.layersComing == 0 && !next && s.tilesWanted == 0 && selection.heldBack == 0 &&
                   !selection.cappedByBudget && !selection.morphing;
  frame.morphing = selection.morphing;
  frame.unsettled = selection.morphing || s.tilesHeldBack > 0 || shown->hasLeeway();
  frame.soonCopies_bytes = spareCopies_bytes;
}

/// The cut is that of the last update, and so is what its tiles show.
bool Globe::State::frameIsOfTheseTiles() const {
  return isKept && frameRenewals == shown->forest.renewals() && frameTiles.isInOrder(imageryOrder);
}

void Globe::State::fillTiles(const Selection& selection) {
  if (frameIsOfTheseTiles()) {
    for (std::size_t i = 0; selection.fading > 0.0f && i < selection.drawn.size(); ++i)
      frame.tiles[i].morph = selection.drawn[i].morph;
    return;
  }
  frameRenewals = shown->forest.renewals();
  const ContentMaker& maker = shown->forest.maker();
  frameTiles.begin(frame, imageryOrder);
  for (const SelectedTile& tile : selection.drawn)
    frameTiles.add(tile, maker);
  patches.apply(selection, maker.tiling, frame);
  fillSoon(selection);
}

/// What comes into the picture soon, and what will take its place, goes to the GPU as far as there is time for it.
void Globe::State::fillSoon(const Selection& selection) {
  frameTiles.beginSoon();
  for (const SelectedTile& tile : selection.soon)
    frameTiles.add(tile, shown->forest.maker());
  if (next) {
    for (const SelectedTile& tile : nextCut->drawn)
      frameTiles.add(tile, next->forest.maker());
  }
  frameTiles.finish();
}

void Globe::State::fillStatistics(const Selection& selection) {
  FrameStatistics& s = frame.statistics;
  s.cutAge = shown->age();
  s.tilesVisited = selection.visited;
  s.tilesCulledFrustum = selection.culledFrustum;
  s.tilesCulledHorizon = selection.culledHorizon;
  s.tilesWanted = static_cast<int>((nextCut != nullptr ? nextCut : &selection)->wanted.size()) + renewal->outOfDate();
  s.tilesHeldBack = selection.heldBack + renewal->heldBack();
  s.cappedByBudget = selection.cappedByBudget;
  s.maxScreenError_px = selection.maxScreenError_px;
  s.tilesALevel.fill(0);
  for (const SelectedTile& tile : selection.drawn)
    ++s.tilesALevel[tile.id.level];
  s.layersComing = roster->coming() + roster->stepsComing() + (next ? 1 : 0);
  s.requests = roster->ledger().requests();
  s.failedRequests = failureCount;
  s.failures = failureCount;
  if (!resources) return;
  const io::ResourceStatistics network = resources->statistics();
  s.requests += network.requests;
  s.failedRequests += network.failedRequests;
}

void Globe::State::fillDebug(const CutOptions& options) {
  DebugOverlay& debug = frame.debug;
  debug.tolerance_px = std::isfinite(options.tolerance_px) ? options.tolerance_px : 1.0;
  debug.boxes.clear();
  if (!debug.views.has(DebugView::boxes)) return;
  for (const DrawnTile& tile : frame.tiles) {
    const TileRecord& record = shown->forest.record(tile.id);
    debug.boxes.push_back(record.drawable ? record.tightBox : record.box);
  }
}

namespace {

io::Failure noSunByClock(const Scene& scene) {
  const std::string where = fmt::format("{}: light.sun = \"clock\"", scene.name);
  if (!scene.clock.start_s)
    return {io::Failure::Code::invalidArgument,
            "there is no time to ask for the sun: give the scene a [clock] with a start, or use --time", where};
  return {io::Failure::Code::unsupported,
          fmt::format("where the sun stands over '{}' at that time is not known: it is over earth, mars and moon in "
                      "the years 1000 to 3000, elsewhere give "
                      "light.sun = [latitude, longitude]",
                      scene.body.name),
          where};
}

}  // namespace

Globe::Globe(std::unique_ptr<State> state) : state_(std::move(state)) {}
Globe::~Globe() = default;

io::Result<std::unique_ptr<Globe>> Globe::open(const Scene& scene, const GlobeOptions& options,
                                               const BuildSink& progress, const std::stop_token& stop) {
  auto layers = openLayers(scene, progress, stop, options.online, options.cpuCacheBytes / 2);
  if (!layers) return tl::unexpected(std::move(layers.error()));
  return fromLayers(scene, std::move(*layers), options);
}

io::Result<std::unique_ptr<Globe>> Globe::fromLayers(const Scene& scene, GlobeLayers layers,
                                                     const GlobeOptions& options) {
  auto state = std::make_unique<State>(scene, options);
  state->resources = layers.resources;
  for (const GlobeLayers::Imagery& layer : layers.imagery)
    state->name(layer);
  auto roster = LayerRoster::create(scene, std::move(layers), state->sourceBudget(), state->fetches, state->bell);
  if (!roster) return tl::unexpected(std::move(roster.error()));
  state->roster = std::move(*roster);
  state->roster->advance(Clock::now(), {}, false);
  state->time_s = scene.clock.start_s;
  if (state->time_s) state->sunByClock = geo::directionToSun(state->body, *state->time_s);
  state->skyPlaces = skyPlacesAt(state->body, state->time_s);
  if (scene.lighting.sun == Lighting::Sun::byClock && !state->sunByClock) return tl::unexpected(noSunByClock(scene));
  state->show(state->generation());
  return std::unique_ptr<Globe>(new Globe(std::move(state)));
}

io::Result<void> Globe::addImagery(const ImageryLayer& layer) {
  State& s = *state_;
  if (layer.derived && !layer.derived->of)
    return io::fail(io::Failure::Code::unsupported, "a layer that is added needs a source of its own", layer.name);
  Scene scene;
  scene.body = s.body;
  scene.tiling = s.shown->forest.maker().tiling.scheme();
  scene.imagery.push_back(layer);
  const std::uint64_t imageBytes = s.globeOptions.cpuCacheBytes / 2 / (s.imageryNames.size() + 1);
  auto layers = openLayers(scene, {}, {}, s.globeOptions.online, imageBytes, s.resources);
  if (!layers) return tl::unexpected(std::move(layers.error()));
  if (!s.resources) s.resources = layers->resources;
  return addImagery(std::move(layers->imagery.front()));
}

io::Result<void> Globe::addImagery(GlobeLayers::Imagery layer) {
  State& s = *state_;
  GlobeLayers::Imagery named = layer;
  if (auto added = s.roster->addImagery(std::move(layer)); !added) return added;
  s.name(named);
  return {};
}

const geo::Body& Globe::body() const {
  return state_->body;
}
Lighting& Globe::lighting() {
  return state_->lighting;
}
Air& Globe::air() {
  return state_->frame.air;
}
SkySettings& Globe::sky() {
  return state_->sky;
}
std::array<float, 3>& Globe::background() {
  return state_->frame.background;
}
std::span<LayerLook> Globe::imageryLooks() {
  return state_->frame.looks;
}
const std::vector<std::string>& Globe::imageryNames() const {
  return state_->imageryNames;
}
std::span<const std::uint32_t> Globe::imageryOrder() const {
  return state_->imageryOrder;
}
void Globe::moveImagery(std::size_t layer, std::size_t place) {
  std::vector<std::uint32_t>& order = state_->imageryOrder;
  const auto from = std::ranges::find(order, layer);
  if (from == order.end()) return;
  const auto to = order.begin() + static_cast<std::ptrdiff_t>(std::min(place, order.size() - 1));
  if (to < from) {
    std::rotate(to, from, from + 1);
  } else {
    std::rotate(from, from + 1, to + 1);
  }
}
double& Globe::exaggeration() {
  return state_->frame.exaggeration;
}
DebugViews& Globe::debugViews() {
  return state_->frame.debug.views;
}
void Globe::setClock(double time_s) {
  State& s = *state_;
  s.roster->setClock(time_s, !s.time_s || time_s >= *s.time_s);
  s.time_s = time_s;
  if (const auto sun = geo::directionToSun(s.body, time_s)) s.sunByClock = sun;
  s.skyPlaces = skyPlacesAt(s.body, time_s);
}
std::optional<double> Globe::clock() const {
  return state_->time_s;
}
void Globe::freezeCut(const std::optional<View>& at) {
  DebugOverlay& debug = state_->frame.debug;
  debug.frozenCut = at;
  if (at) debug.frozenPyramid = pyramidOf(*at, state_->body.ellipsoid);
}
bool Globe::cutIsFrozen() const {
  return state_->frame.debug.frozenCut.has_value();
}
const std::vector<io::Failure>& Globe::failures() const {
  return state_->failures;
}

std::vector<io::Failure> Globe::failuresInFrame() const {
  const State& s = *state_;
  const bool allAreKnown = s.failureCount <= s.failedTiles.size();
  std::vector<bool> counts(s.failures.size(), !allAreKnown);
  for (const State::FailedTile& failed : s.failedTiles) {
    const auto lies = [&](const DrawnTile& tile) {
      return tile.id.level >= failed.tile->level && tile.id.ancestor(failed.tile->level) == *failed.tile;
    };
    if (!counts[failed.failure] && (!failed.tile || std::ranges::any_of(s.frame.tiles, lies)))
      counts[failed.failure] = true;
  }
  std::vector<io::Failure> out = s.roster->complaints();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i]) out.push_back(s.failures[i]);
  }
  return out;
}

std::vector<io::Failure> Globe::lateLayers() const {
  std::vector<io::Failure> out = state_->roster->lateLayers();
  for (io::Failure& late : out)
    late.where = raster::withoutSecrets(late.where);
  return out;
}

std::vector<io::Failure> Globe::troubles() const {
  std::vector<io::Failure> out = state_->roster->troubles();
  if (state_->resources) {
    for (io::Failure& trouble : state_->resources->troubles())
      out.push_back(std::move(trouble));
  }
  for (io::Failure& trouble : out)
    trouble.where = raster::withoutSecrets(trouble.where);
  return out;
}

const Frame& Globe::update(const View& view, const CutOptions& options, const Residency* gpu) {
  const auto start = Clock::now();
  State& s = *state_;
  const bool hasCome = s.bell.quiet();
  s.receive();
  const View& cutView = s.frame.debug.frozenCut ? *s.frame.debug.frozenCut : view;
  const Selection& selection = s.cut(cutView, options, gpu, hasCome);
  s.renewPictures(selection, gpu);
  s.refreshFrame(view, selection);
  s.fillTiles(selection);
  s.fillDebug(options);
  if (!s.isKept || hasCome) s.evict();
  s.frame.statistics.update_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  return s.frame;
}

bool Globe::waitForArrivals(std::chrono::milliseconds timeout) {
  State& s = *state_;
  const auto now = Clock::now();
  if ((!s.shownGoesOn && s.nextStandsStill(now)) || s.roster->isDue(now) || s.shown->isBehind()) return true;
  const bool isComing = s.roster->stepsComing() > 0 || s.renewal->outOfDate() > 0 || !s.shown->loading.isIdle() ||
                        (s.next && !s.next->loading.isIdle()) || s.roster->coming() > 0;
  return isComing && s.bell.wait(timeout);
}

std::optional<double> Globe::groundHeight_m(const geo::Direction& d) const {
  const tiling::RootPoint p = state_->shown->forest.maker().tiling.rootPoint(d);
  std::optional<double> height_m;
  for (int level = 0; level <= kDeepestLevel; ++level) {
    const double across = std::exp2(level);
    const auto index = [&](double w) {
      return static_cast<std::uint32_t>(std::clamp(std::floor(w * across), 0.0, across - 1.0));
    };
    const tiling::TileId id{static_cast<std::uint8_t>(level), static_cast<std::uint8_t>(p.root), index(p.u),
                            index(p.v)};
    const TileRecord* found = state_->shown->forest.find(id);
    if (found == nullptr || !found->content) return height_m;
    height_m = state_->frame.exaggeration * heightIn(found->content->heights, p.u * across - id.x, p.v * across - id.y);
  }
  return height_m;
}

}  // namespace tellurion::scene
