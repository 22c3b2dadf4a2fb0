#include "scene/globe.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <unordered_map>
#include <utility>

#include "io/executor.h"
#include "scene/layer_sources.h"
#include "scene/tile_content.h"

namespace tellurion::scene {
namespace {

using Clock = std::chrono::steady_clock;

/// Of the byte budget, what decoded source tiles may take; the rest is for meshes and textures.
constexpr double kSourceShare = 0.25;

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

struct Arrival {
  tiling::TileId id;
  std::shared_ptr<const TileContent> content;
};

/// Where workers leave what they have made. Thread-safe.
class Arrivals {
 public:
  void add(Arrival arrival) {
    {
      const std::lock_guard lock(mutex_);
      waiting_.push_back(std::move(arrival));
    }
    arrived_.notify_all();
  }
  std::vector<Arrival> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(waiting_, {});
  }
  bool wait(std::chrono::milliseconds timeout) {
    std::unique_lock lock(mutex_);
    return arrived_.wait_for(lock, timeout, [&] { return !waiting_.empty(); });
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<Arrival> waiting_;
};

/// A task's state that worker and globe share: whoever is first decides whether it runs.
struct Job {
  std::atomic<bool> taken{false};
  io::Executor::Task task;
};

struct TileRecord final : TileFacts {
  double madeFor = 1.0;                   ///< the exaggeration that the facts were made for
  std::array<TileRecord*, 4> children{};  ///< their records, once they were asked for
  std::shared_ptr<const TileContent> content;
  std::shared_ptr<Job> job;      ///< asked for and not here yet
  std::uint64_t residency = 0;   ///< number of what was on the GPU when facts.copy_bytes was asked for
  std::uint64_t visibility = 0;  ///< number of the layers in sight that facts.texel_m was made for
  std::uint64_t lastUse = 0;     ///< number of the update that used it last
  std::uint64_t lastWanted = 0;  ///< number of the update that asked for it last
};

std::int64_t trianglesOf(const TerrainMesh& mesh) {
  std::int64_t indices = mesh.interior.count;
  for (const IndexRange& edge : mesh.fineEdge)
    indices += edge.count;
  return indices / 3;
}

std::uint64_t sourceBudget(const GlobeOptions& options, std::size_t layers) {
  const double share = kSourceShare * static_cast<double>(options.cpuCacheBytes);
  return static_cast<std::uint64_t>(share / static_cast<double>(std::max<std::size_t>(layers, 1)));
}

io::Result<int> commonCells(const std::vector<const raster::TileSourceInfo*>& infos, const Scene& scene,
                            raster::Kind kind, int otherwise) {
  int cells = infos.empty() ? otherwise : infos.front()->tileCells;
  for (const raster::TileSourceInfo* info : infos) {
    const auto wrong = [&](std::string message) {
      return io::fail(io::Failure::Code::invalidArgument, std::move(message), info->name);
    };
    if (info->kind != kind) {
      return wrong(
          fmt::format("holds {}, but the scene uses it as {}", raster::nameOf(info->kind), raster::nameOf(kind)));
    }
    if (info->scheme != scene.tiling) {
      return wrong(fmt::format("is tiled as {}, the scene as {}; build it again with --tiling {}",
                               tiling::nameOf(info->scheme), tiling::nameOf(scene.tiling),
                               tiling::nameOf(scene.tiling)));
    }
    if (!(info->body.ellipsoid == scene.body.ellipsoid)) {
      return wrong(fmt::format("is of the body {}, the scene of {}", info->body.name, scene.body.name));
    }
    if (info->tileCells != cells) {
      return wrong(fmt::format("has {} cells a side of a tile, the layer before it {}", info->tileCells, cells));
    }
  }
  const bool powerOfTwo = cells > 0 && (cells & (cells - 1)) == 0;
  if (kind == raster::Kind::elevation && !(powerOfTwo && cells >= 4 && cells <= 128)) {
    return io::fail(io::Failure::Code::unsupported, "elevation tiles must have 4 to 128 cells a side, a power of two",
                    infos.front()->name);
  }
  return cells;
}

}  // namespace

struct Globe::State final : public TileTree {
  State(const Scene& scene, const GlobeOptions& options, ContentMaker contentMaker,
        std::vector<std::shared_ptr<LayerTiles>> layerTiles, std::shared_ptr<LoadLedger> loads)
      : body(scene.body),
        lighting(scene.lighting),
        maker(std::move(contentMaker)),
        layers(std::move(layerTiles)),
        ledger(std::move(loads)),
        contentBudget(static_cast<std::uint64_t>((1.0 - kSourceShare) * static_cast<double>(options.cpuCacheBytes))),
        executor(options.workers) {
    frame.background = scene.background;
    frame.vertexGrid_m = vertexGrid_m(maker.ellipsoid);
  }

  /// Whatever the cut looks at counts as used, siblings that wait for each other too: else a small budget would drop
  /// the first of four children before the last has come, for ever.
  TileFacts* use(const tiling::TileId& id, TileRecord& r) {
    r.lastUse = updates;
    if (r.madeFor != frame.exaggeration) {
      makeBox(id, r);
      if (r.content) takeFacts(id, r);
    }
    if (r.content && r.visibility != visibility) takeTexels(r);
    takeCopies(id.level, r);
    return &r;
  }
  TileFacts* root(int root) override {
    const tiling::TileId id{.level = 0, .root = static_cast<std::uint8_t>(root)};
    return use(id, record(id));
  }
  std::array<TileFacts*, 4> children(const tiling::TileId& id, TileFacts& facts) override {
    TileRecord& r = static_cast<TileRecord&>(facts);
    std::array<TileFacts*, 4> out{};
    for (int q = 0; q < 4; ++q) {
      TileRecord*& child = r.children[static_cast<std::size_t>(q)];
      if (child == nullptr) child = &record(id.child(q));
      out[static_cast<std::size_t>(q)] = use(id.child(q), *child);
    }
    return out;
  }

  /// What is on the GPU stays there, and is not asked for again, until something leaves.
  void takeCopies(int level, TileRecord& r) const {
    if (gpu == nullptr || !r.content) {
      r.copy_bytes = 0;
      r.residency = 0;
    } else if (r.copy_bytes > 0 || r.residency != residency) {
      const TileContent& c = *r.content;
      r.copy_bytes = gpu->missingBytes(*c.mesh);
      if (c.relief) r.copy_bytes += shareOf(gpu->missingReliefBytes(*c.relief), level - c.reliefLevel);
      for (std::size_t i = 0; i < c.pictures.size(); ++i) {
        const LayerPicture& picture = c.pictures[i];
        if (picture.image && frame.looks[i].visible)
          r.copy_bytes += shareOf(gpu->missingColourBytes(*picture.image), level - picture.level);
      }
      r.residency = residency;
    }
  }

  void takeTexels(TileRecord& r) const {
    r.texel_m = texelOf_m(*r.content, maker.colours, frame.looks);
    r.visibility = visibility;
  }

  /// What tiles miss, and how fine they must be, depends on which layers are visible.
  void lookAtLayers() {
    const auto sameAsBefore = [&](const LayerLook& look) {
      return look.visible == wasVisible[static_cast<std::size_t>(&look - frame.looks.data())];
    };
    if (std::ranges::all_of(frame.looks, sameAsBefore)) return;
    for (std::size_t i = 0; i < frame.looks.size(); ++i)
      wasVisible[i] = frame.looks[i].visible;
    ++visibility;
    ++residency;
  }

  void lookAt(const Residency* residencyNow) {
    const std::uint64_t now = residencyNow != nullptr ? residencyNow->departures() : 0;
    if (residencyNow != gpu || now != departures) ++residency;
    gpu = residencyNow;
    departures = now;
  }

  TileRecord& record(const tiling::TileId& id) {
    const auto [found, isNew] = records.try_emplace(id);
    if (isNew) {
      found->second.corners = tileCorners(maker.tiling, id);
      found->second.around = tilesAround(maker.tiling, id);
      makeBox(id, found->second);
    }
    return found->second;
  }

  double reachOfParent_m(const tiling::TileId& id) const;
  OrientedBox drawnBox(const tiling::TileId& id, const HeightRange& range) const;
  void makeBox(const tiling::TileId& id, TileRecord& r) const;
  void takeFacts(const tiling::TileId& id, TileRecord& r) const;
  void receive();
  const CutHistory* historyAt(const CutOptions& options);
  double occluderDepth_m() const;
  void request(const std::vector<WantedTile>& wanted);
  void submit(const WantedTile& wanted, TileRecord& record);
  void cancelUnwanted();
  void fillFrame(const View& view, const Selection& selection);
  void fillDebug(const CutOptions& options);
  DrawnTile drawn(const SelectedTile& tile);
  void evict();
  Light lightFor(const View& view) const;

  geo::Body body;
  Lighting lighting;
  ContentMaker maker;
  std::vector<std::shared_ptr<LayerTiles>> layers;
  std::shared_ptr<LoadLedger> ledger;
  std::uint64_t contentBudget;
  std::unordered_map<tiling::TileId, TileRecord, tiling::TileIdHash> records;
  std::vector<tiling::TileId> underway;
  std::uint64_t contentBytes = 0;
  std::uint64_t updates = 0;
  std::vector<io::Failure> failures;
  Selector selector{maker.tiling, maker.ellipsoid};
  std::array<CutMemory, 2> memories;  ///< of the last time and of this one; which is which, history says
  CutHistory history{.last = &memories[0], .now = &memories[1]};
  std::optional<double> time_s;      ///< of memories' newer one
  std::optional<double> lastTime_s;  ///< and of the older
  const Residency* gpu = nullptr;    ///< of this update
  std::uint64_t departures = 0;      ///< of that
  std::uint64_t residency = 0;       ///< rises when something may have left, and with another GPU
  std::vector<std::string> imageryNames;
  std::vector<bool> wasVisible;  ///< of each imagery layer
  std::uint64_t visibility = 1;  ///< rises when that changes
  Frame frame;
  Arrivals arrivals;
  io::Executor executor;  ///< last: its workers use what stands above
};

/// Metres by which a tile drawn as its parent's mesh may leave the parent's samples: that misses them by a little more
/// than its tolerance.
double Globe::State::reachOfParent_m(const tiling::TileId& id) const {
  return 2.0 * meshTolerance_m(maker.tiling, maker.ellipsoid, id.level - 1, maker.ground.cells());
}

/// Holds ground of these heights as it is drawn.
OrientedBox Globe::State::drawnBox(const tiling::TileId& id, const HeightRange& range) const {
  // What is lifted goes along normals of 16 bits, which lean by up to one part in 32767.
  const double lean_m =
      std::abs(frame.exaggeration - 1.0) * std::max(std::abs(range.low_m), std::abs(range.high_m)) / 32767.0;
  const HeightRange drawn{.low_m = range.low_m * frame.exaggeration, .high_m = range.high_m * frame.exaggeration};
  return grown(estimatedBox(maker.tiling, maker.ellipsoid, id, drawn), lean_m);
}

/// What is known of a tile without its content: a box from what its parent tells.
void Globe::State::makeBox(const tiling::TileId& id, TileRecord& r) const {
  r.madeFor = frame.exaggeration;
  HeightRange range = unknownRange(maker.ellipsoid);
  if (id.level > 0) {
    const auto parent = records.find(id.parent());
    if (parent != records.end() && parent->second.content)
      range = parent->second.content->childRange[static_cast<std::size_t>(id.quadrant())];
    const double reach_m = reachOfParent_m(id);
    range = {.low_m = range.low_m - reach_m, .high_m = range.high_m + reach_m};
  }
  r.box = drawnBox(id, range);
}

/// What its content adds.
void Globe::State::takeFacts(const tiling::TileId& id, TileRecord& r) const {
  const TileContent& content = *r.content;
  const double more = std::max(1.0, frame.exaggeration);
  r.drawable = true;
  r.error_m = content.error_m * more;
  takeTexels(r);
  r.spacing_m = content.spacing_m;
  r.triangles = trianglesOf(*content.mesh);
  r.bytes = content.bytes;
  r.tightBox = frame.exaggeration == 1.0 ? content.box
                                         : grown(drawnBox(id, content.range), r.error_m + more * reachOfParent_m(id));
  // What a root was assumed to hold may be too little. All roots are waited for, so a complete cut does not depend on
  // when they came.
  if (id.level == 0) r.box = r.tightBox;
}

void Globe::State::receive() {
  for (Arrival& arrival : arrivals.take()) {
    TileRecord& r = record(arrival.id);
    r.job.reset();
    r.content = std::move(arrival.content);
    if (r.madeFor != frame.exaggeration) makeBox(arrival.id, r);
    takeFacts(arrival.id, r);
    r.lastUse = updates;
    contentBytes += r.content->bytes;
  }
  std::erase_if(underway, [&](const tiling::TileId& id) { return !record(id).job; });
  for (io::Failure& failure : ledger->takeFailures())
    failures.push_back(std::move(failure));
}

/// Updates at one time all start from what was drawn at the time before, so that the last of them, when all has come,
/// does not depend on the order of arrivals.
const CutHistory* Globe::State::historyAt(const CutOptions& options) {
  if (!options.time_s || !options.morph) {
    time_s = lastTime_s = std::nullopt;
    for (CutMemory& memory : memories) {
      memory.clear();
      memory.corners.clear();
    }
    return nullptr;
  }
  if (time_s != options.time_s) {
    std::swap(memories[0], memories[1]);
    lastTime_s = std::exchange(time_s, options.time_s);
  }
  history.step = lastTime_s ? std::clamp((*time_s - *lastTime_s) / options.fade_s, 0.0, 1.0) : 1.0;
  return &history;
}

/// How deep below the ellipsoid the ground lies at most, as far as the roots tell.
double Globe::State::occluderDepth_m() const {
  double lowest_m = 0.0;
  for (int root = 0; root < maker.tiling.rootCount(); ++root) {
    const auto found = records.find({.level = 0, .root = static_cast<std::uint8_t>(root)});
    const bool known = found != records.end() && found->second.content;
    lowest_m = std::min(lowest_m, (known ? found->second.content->range : unknownRange(maker.ellipsoid)).low_m);
  }
  return -lowest_m * frame.exaggeration;
}

void Globe::State::submit(const WantedTile& wanted, TileRecord& r) {
  std::shared_ptr<const TileContent> parent;
  if (wanted.id.level > 0) parent = record(wanted.id.parent()).content;
  r.job = std::make_shared<Job>();
  r.job->task = executor.submit(wanted.priority,
                                [this, id = wanted.id, parent = std::move(parent), job = r.job.get(), keep = r.job] {
                                  if (job->taken.exchange(true)) return;
                                  arrivals.add({.id = id, .content = maker.make(id, parent.get())});
                                });
  underway.push_back(wanted.id);
}

void Globe::State::request(const std::vector<WantedTile>& wanted) {
  for (const WantedTile& w : wanted) {
    TileRecord& r = record(w.id);
    r.lastWanted = updates;
    if (r.job) {
      r.job->task.setPriority(w.priority);
    } else {
      submit(w, r);
    }
  }
  cancelUnwanted();
}

void Globe::State::cancelUnwanted() {
  std::erase_if(underway, [&](const tiling::TileId& id) {
    TileRecord& r = record(id);
    if (r.lastWanted == updates || r.job->taken.exchange(true)) return false;
    r.job->task.cancel();
    r.job.reset();
    return true;
  });
}

DrawnTile Globe::State::drawn(const SelectedTile& tile) {
  const TileContent& content = *static_cast<const TileRecord&>(*tile.facts).content;
  DrawnTile out{.id = tile.id,
                .mesh = content.mesh,
                .coarseEdges = tile.coarseEdges,
                .morph = tile.morph,
                .firstPicture = static_cast<std::uint32_t>(frame.pictures.size()),
                .relief = content.relief,
                .error_px = tile.error_px};
  for (std::size_t i = 0; i < content.pictures.size(); ++i) {
    const LayerPicture& picture = content.pictures[i];
    if (!picture.image) continue;
    frame.pictures.push_back({.image = picture.image,
                              .window = windowIn(tile.id, picture.level, maker.colours.pixels(i), raster::kGutter),
                              .layer = static_cast<std::uint32_t>(i)});
    ++out.pictureCount;
  }
  if (out.relief) out.reliefWindow = windowIn(tile.id, content.reliefLevel, maker.ground.cells(), 0.5);
  return out;
}

Light Globe::State::lightFor(const View& view) const {
  Light light{.enabled = lighting.enabled, .toSun_body = lighting.subsolar.n, .ambient = lighting.ambient};
  if (lighting.sun == Lighting::Sun::withCamera) {
    // Behind the eye, to the left and above: 35 degrees off the line of sight, as maps are lit.
    light.toSun_body = glm::transpose(view.viewFromBody) * geo::normalize(geo::Vec3(-0.5, 0.5, 1.0));
  }
  return light;
}

void Globe::State::fillFrame(const View& view, const Selection& selection) {
  frame.view = view;
  frame.light = lightFor(view);
  frame.complete =
      selection.wanted.empty() && selection.heldBack == 0 && !selection.cappedByBudget && !selection.morphing;
  frame.morphing = selection.morphing;
  FrameStatistics& s = frame.statistics;
  s.tilesVisited = selection.visited;
  s.tilesCulledFrustum = selection.culledFrustum;
  s.tilesCulledHorizon = selection.culledHorizon;
  s.tilesWanted = static_cast<int>(selection.wanted.size());
  s.tilesHeldBack = selection.heldBack;
  s.cappedByBudget = selection.cappedByBudget;
  s.maxScreenError_px = selection.maxScreenError_px;
  s.tilesALevel.fill(0);
  frame.tiles.clear();
  frame.pictures.clear();
  for (const SelectedTile& tile : selection.drawn) {
    frame.tiles.push_back(drawn(tile));
    ++s.tilesALevel[tile.id.level];
  }
  frame.soon.clear();
  for (const SelectedTile& tile : selection.soon)
    frame.soon.push_back(drawn(tile));
  frame.soonCopies_bytes = selection.spareCopies_bytes;
  s.cpuCacheBytes = contentBytes;
  for (const auto& layer : layers)
    s.cpuCacheBytes += layer->bytes();
  s.requests = ledger->requests();
  s.failedRequests = failures.size();
}

void Globe::State::fillDebug(const CutOptions& options) {
  DebugOverlay& debug = frame.debug;
  debug.tolerance_px = std::isfinite(options.tolerance_px) ? options.tolerance_px : 1.0;
  debug.boxes.clear();
  if (!debug.views.has(DebugView::boxes)) return;
  for (const DrawnTile& tile : frame.tiles)
    debug.boxes.push_back(record(tile.id).tightBox);
}

void Globe::State::evict() {
  constexpr std::size_t kRecordsKept = 20000;
  if (contentBytes <= contentBudget && records.size() <= kRecordsKept) return;
  std::vector<std::pair<std::uint64_t, tiling::TileId>> unused;
  for (const auto& [id, r] : records) {
    if (!r.job && r.lastUse != updates && r.lastWanted != updates) unused.emplace_back(r.lastUse, id);
  }
  // The longest unused first, of those the deepest: children go before their parents.
  std::sort(unused.begin(), unused.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second.level > b.second.level;
  });
  for (const auto& [use, id] : unused) {
    if (contentBytes <= contentBudget && records.size() <= kRecordsKept / 2) return;
    const auto found = records.find(id);
    if (found->second.content) contentBytes -= found->second.content->bytes;
    const auto parent = id.level > 0 ? records.find(id.parent()) : records.end();
    if (parent != records.end()) parent->second.children[static_cast<std::size_t>(id.quadrant())] = nullptr;
    records.erase(found);
  }
}

Globe::Globe(std::unique_ptr<State> state) : state_(std::move(state)) {}
Globe::~Globe() = default;

io::Result<std::unique_ptr<Globe>> Globe::open(const Scene& scene, const GlobeOptions& options,
                                               const BuildSink& progress, const std::stop_token& stop) {
  auto layers = openLayers(scene, progress, stop);
  if (!layers) return tl::unexpected(std::move(layers.error()));
  return fromLayers(scene, std::move(*layers), options);
}

io::Result<std::unique_ptr<Globe>> Globe::fromLayers(const Scene& scene, GlobeLayers layers,
                                                     const GlobeOptions& options) {
  std::vector<const raster::TileSourceInfo*> elevation;
  for (const auto& source : layers.elevation)
    elevation.push_back(&source->info());
  const auto cells = commonCells(elevation, scene, raster::Kind::elevation, raster::kElevationCells);
  if (!cells) return tl::unexpected(cells.error());
  std::vector<int> pixels;  // a layer each
  std::size_t imagerySets = 0;
  for (const auto& layer : layers.imagery) {
    std::vector<const raster::TileSourceInfo*> sets{&layer.source->info()};
    for (const auto& set : layer.alsoFrom)
      sets.push_back(&set->info());
    const auto common = commonCells(sets, scene, raster::Kind::imagery, raster::kImageryPixels);
    if (!common) return tl::unexpected(common.error());
    pixels.push_back(*common);
    imagerySets += sets.size();
  }

  const std::uint64_t budget = sourceBudget(options, elevation.size() + imagerySets);
  auto ledger = std::make_shared<LoadLedger>();
  std::vector<std::shared_ptr<LayerTiles>> all;
  std::vector<std::shared_ptr<LayerTiles>> ground;
  std::vector<ColourLayers::Layer> colours;
  std::vector<LayerLook> looks;
  std::vector<std::string> names;
  for (auto& source : layers.elevation)
    ground.push_back(std::make_shared<LayerTiles>(std::move(source), budget, ledger));
  for (auto& layer : layers.imagery) {
    looks.push_back(layer.look);
    const std::string& source = layer.source->info().name;
    names.push_back(layer.name.empty() ? source.substr(source.find_last_of('/') + 1) : layer.name);
    ColourLayers::Layer& colour = colours.emplace_back();
    colour.pixels = pixels[looks.size() - 1];
    colour.nightLights = layer.look.nightLights;
    colour.sets.push_back(std::make_shared<LayerTiles>(std::move(layer.source), budget, ledger));
    for (auto& set : layer.alsoFrom)
      colour.sets.push_back(std::make_shared<LayerTiles>(std::move(set), budget, ledger));
    all.insert(all.end(), colour.sets.begin(), colour.sets.end());
  }
  all.insert(all.end(), ground.begin(), ground.end());
  const tiling::Tiling tiling(scene.tiling);
  ContentMaker maker{.tiling = tiling,
                     .ellipsoid = scene.body.ellipsoid,
                     .ground = GroundLayers(tiling, std::move(ground), *cells),
                     .colours = ColourLayers(std::move(colours)),
                     .regularMesh = options.regularMesh};
  auto state = std::make_unique<State>(scene, options, std::move(maker), std::move(all), std::move(ledger));
  state->wasVisible.assign(looks.size(), true);
  state->frame.looks = std::move(looks);
  state->imageryNames = std::move(names);
  return std::unique_ptr<Globe>(new Globe(std::move(state)));
}

const geo::Body& Globe::body() const {
  return state_->body;
}
Lighting& Globe::lighting() {
  return state_->lighting;
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
double& Globe::exaggeration() {
  return state_->frame.exaggeration;
}
DebugViews& Globe::debugViews() {
  return state_->frame.debug.views;
}
void Globe::freezeCut(const std::optional<View>& at) {
  DebugOverlay& debug = state_->frame.debug;
  debug.frozenCut = at;
  if (at) debug.frozenPyramid = pyramidOf(*at, state_->maker.ellipsoid);
}
bool Globe::cutIsFrozen() const {
  return state_->frame.debug.frozenCut.has_value();
}
const std::vector<io::Failure>& Globe::failures() const {
  return state_->failures;
}

const Frame& Globe::update(const View& view, const CutOptions& options, const Residency* gpu) {
  const auto start = Clock::now();
  State& s = *state_;
  ++s.updates;
  s.lookAt(gpu);
  s.lookAtLayers();
  s.receive();
  const View& cutView = s.frame.debug.frozenCut ? *s.frame.debug.frozenCut : view;
  const CutHistory* history = s.historyAt(options);
  const Selection& selection = s.selector.select(cutView, options, s.occluderDepth_m(), s, history);
  s.request(selection.wanted);
  s.fillFrame(view, selection);
  s.fillDebug(options);
  s.evict();
  s.frame.statistics.update_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  return s.frame;
}

bool Globe::waitForArrivals(std::chrono::milliseconds timeout) {
  return !state_->underway.empty() && state_->arrivals.wait(timeout);
}

std::optional<double> Globe::groundHeight_m(const geo::Direction& d) const {
  const tiling::RootPoint p = state_->maker.tiling.rootPoint(d);
  std::optional<double> height_m;
  for (int level = 0; level <= kDeepestLevel; ++level) {
    const double across = std::exp2(level);
    const auto index = [&](double w) {
      return static_cast<std::uint32_t>(std::clamp(std::floor(w * across), 0.0, across - 1.0));
    };
    const tiling::TileId id{static_cast<std::uint8_t>(level), static_cast<std::uint8_t>(p.root), index(p.u),
                            index(p.v)};
    const auto found = state_->records.find(id);
    if (found == state_->records.end() || !found->second.content) return height_m;
    height_m =
        state_->frame.exaggeration * heightIn(found->second.content->heights, p.u * across - id.x, p.v * across - id.y);
  }
  return height_m;
}

}  // namespace tellurion::scene
