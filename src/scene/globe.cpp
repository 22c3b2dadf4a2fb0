#include "scene/globe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/layer_sources.h"
#include "scene/tile_loading.h"

namespace tellurion::scene {
namespace {

using Clock = std::chrono::steady_clock;

/// Of the byte budget, what decoded source tiles may take; the rest is for meshes and textures.
constexpr double kSourceShare = 0.25;

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

struct Globe::State {
  State(const Scene& scene, const GlobeOptions& options, ContentMaker contentMaker,
        std::vector<std::shared_ptr<LayerTiles>> layerTiles, std::shared_ptr<LoadLedger> loads)
      : body(scene.body),
        lighting(scene.lighting),
        layers(std::move(layerTiles)),
        ledger(std::move(loads)),
        contentBudget(static_cast<std::uint64_t>((1.0 - kSourceShare) * static_cast<double>(options.cpuCacheBytes))),
        forest(std::move(contentMaker)),
        selector(forest.maker().tiling, forest.maker().ellipsoid),
        loading(forest, executor),
        executor(options.workers) {
    frame.background = scene.background;
    frame.vertexGrid_m = vertexGrid_m(body.ellipsoid);
  }

  void receive();
  const CutHistory* historyAt(const CutOptions& options);
  void fillFrame(const View& view, const Selection& selection);
  void fillDebug(const CutOptions& options);
  DrawnTile drawn(const SelectedTile& tile) const;
  Light lightFor(const View& view) const;

  geo::Body body;
  Lighting lighting;
  std::vector<std::shared_ptr<LayerTiles>> layers;
  std::shared_ptr<LoadLedger> ledger;
  std::uint64_t contentBudget;
  std::vector<io::Failure> failures;
  TileForest forest;
  Selector selector;
  std::array<CutMemory, 2> memories;  ///< of the last time and of this one; which is which, history says
  CutHistory history{.last = &memories[0], .now = &memories[1]};
  std::optional<double> time_s;      ///< of memories' newer one
  std::optional<double> lastTime_s;  ///< and of the older
  Frame frame;
  TileLoading loading;
  io::Executor executor;  ///< last: its workers use what stands above
};

void Globe::State::receive() {
  loading.receive();
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

DrawnTile Globe::State::drawn(const SelectedTile& tile) const {
  const ContentMaker& maker = forest.maker();
  const TileContent& content = *static_cast<const TileRecord&>(*tile.facts).content;
  DrawnTile out{.id = tile.id,
                .mesh = content.mesh,
                .coarseEdges = tile.coarseEdges,
                .morph = tile.morph,
                .colour = content.colour,
                .relief = content.relief,
                .error_px = tile.error_px};
  if (out.colour) out.colourWindow = windowIn(tile.id, content.colourLevel, maker.colours.pixels(), raster::kGutter);
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
  for (const SelectedTile& tile : selection.drawn) {
    frame.tiles.push_back(drawn(tile));
    ++s.tilesALevel[tile.id.level];
  }
  frame.soon.clear();
  for (const SelectedTile& tile : selection.soon)
    frame.soon.push_back(drawn(tile));
  frame.soonCopies_bytes = selection.spareCopies_bytes;
  s.cpuCacheBytes = forest.contentBytes();
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
    debug.boxes.push_back(forest.record(tile.id).tightBox);
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
  std::vector<const raster::TileSourceInfo*> imagery;
  for (const auto& source : layers.elevation)
    elevation.push_back(&source->info());
  for (const auto& layer : layers.imagery)
    imagery.push_back(&layer.source->info());
  const auto cells = commonCells(elevation, scene, raster::Kind::elevation, raster::kElevationCells);
  if (!cells) return tl::unexpected(cells.error());
  const auto pixels = commonCells(imagery, scene, raster::Kind::imagery, raster::kImageryPixels);
  if (!pixels) return tl::unexpected(pixels.error());

  const std::uint64_t budget = sourceBudget(options, elevation.size() + imagery.size());
  auto ledger = std::make_shared<LoadLedger>();
  std::vector<std::shared_ptr<LayerTiles>> all;
  std::vector<std::shared_ptr<LayerTiles>> ground;
  std::vector<ColourLayers::Layer> colours;
  for (auto& source : layers.elevation)
    ground.push_back(std::make_shared<LayerTiles>(std::move(source), budget, ledger));
  for (auto& layer : layers.imagery) {
    colours.push_back({.tiles = std::make_shared<LayerTiles>(std::move(layer.source), budget, ledger),
                       .opacity = layer.opacity,
                       .nightLights = layer.nightLights});
    all.push_back(colours.back().tiles);
  }
  all.insert(all.end(), ground.begin(), ground.end());
  const tiling::Tiling tiling(scene.tiling);
  ContentMaker maker{.tiling = tiling,
                     .ellipsoid = scene.body.ellipsoid,
                     .ground = GroundLayers(tiling, std::move(ground), *cells),
                     .colours = ColourLayers(std::move(colours), *pixels),
                     .regularMesh = options.regularMesh};
  return std::unique_ptr<Globe>(
      new Globe(std::make_unique<State>(scene, options, std::move(maker), std::move(all), std::move(ledger))));
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
double& Globe::exaggeration() {
  return state_->frame.exaggeration;
}
DebugViews& Globe::debugViews() {
  return state_->frame.debug.views;
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

const Frame& Globe::update(const View& view, const CutOptions& options, const Residency* gpu) {
  const auto start = Clock::now();
  State& s = *state_;
  s.forest.begin(s.frame.exaggeration, gpu);
  s.receive();
  const View& cutView = s.frame.debug.frozenCut ? *s.frame.debug.frozenCut : view;
  const CutHistory* history = s.historyAt(options);
  const Selection& selection = s.selector.select(cutView, options, s.forest.occluderDepth_m(), s.forest, history);
  s.loading.request(selection.wanted);
  s.fillFrame(view, selection);
  s.fillDebug(options);
  s.forest.evict(s.contentBudget);
  s.frame.statistics.update_ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  return s.frame;
}

bool Globe::waitForArrivals(std::chrono::milliseconds timeout) {
  return !state_->loading.isIdle() && state_->loading.wait(timeout);
}

std::optional<double> Globe::groundHeight_m(const geo::Direction& d) const {
  const tiling::RootPoint p = state_->forest.maker().tiling.rootPoint(d);
  std::optional<double> height_m;
  for (int level = 0; level <= kDeepestLevel; ++level) {
    const double across = std::exp2(level);
    const auto index = [&](double w) {
      return static_cast<std::uint32_t>(std::clamp(std::floor(w * across), 0.0, across - 1.0));
    };
    const tiling::TileId id{static_cast<std::uint8_t>(level), static_cast<std::uint8_t>(p.root), index(p.u),
                            index(p.v)};
    const TileRecord* found = state_->forest.find(id);
    if (found == nullptr || !found->content) return height_m;
    height_m = state_->frame.exaggeration * heightIn(found->content->heights, p.u * across - id.x, p.v * across - id.y);
  }
  return height_m;
}

}  // namespace tellurion::scene
