#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <thread>

#include "geo/seed_test.h"
#include "scene/derived_layer.h"
#include "scene/drawn_ground.h"
#include "scene/late_globe_test.h"

namespace tellurion::scene {
namespace {

using namespace std::chrono_literals;
using tiling::Scheme;
using tiling::TileId;

class LateLayers : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(All, LateLayers, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

TEST_P(LateLayers, theSurfaceIsWholeWhileServersAreDeadThenSlowThenWell) {
  const View view = hillsView();
  const auto places = placesIn(view);
  const tiling::Tiling tiling(GetParam());
  Remote ground(raster::Kind::elevation, GetParam());
  Remote colours(raster::Kind::imagery, GetParam());
  const auto globe =
      globeOf({.elevation = {ground.source}, .imagery = {{.source = colours.source}}, .resources = {}}, GetParam());
  // Dead: a bare planet, once its roots are made.
  const Frame* frame = &passed(*globe, view);
  for (int i = 0; i < 20; ++i) {
    expectWhole(globe->update(view), tiling, places);
    globe->waitForArrivals(5ms);
  }
  frame = &globe->update(view);
  EXPECT_FALSE(frame->complete);
  EXPECT_EQ(frame->statistics.layersComing, 2);
  EXPECT_EQ(globe->groundHeight_m(geo::directionFromDegrees(46.6, 8.0)), 0.0);
  // Slow, one answer a frame, then dead again, then well: whole in every frame.
  for (int i = 0; i < 150; ++i) {
    if (i < 60 || i > 90) {
      ground.server->serve(1);
      colours.server->serve(1);
    }
    expectWhole(globe->update(view), tiling, places);
    if (HasFatalFailure()) return;
    globe->waitForArrivals(5ms);
  }
  const auto late = pictureOf(completed(*globe, view, {ground.server, colours.server}));
  EXPECT_NE(globe->groundHeight_m(geo::directionFromDegrees(46.6, 8.0)), 0.0);
  expectAskedOnce(*ground.server);
  expectAskedOnce(*colours.server);
  EXPECT_EQ(ground.source->unpreparedLoads() + colours.source->unpreparedLoads(), 0);
  // The same as if all had been there from the start.
  const auto local =
      globeOf({.elevation = {ground.planet}, .imagery = {{.source = colours.planet}}, .resources = {}}, GetParam());
  EXPECT_EQ(late, pictureOf(completed(*local, view, {})));
}

/// Ground of this machine under ground of a server that ends and fades in the middle of the picture: what tiles of
/// several levels need beside each other is prepared too.
TEST_P(LateLayers, whatEdgesNeedOfCoarserTilesIsPreparedToo) {
  const View view = hillsView();
  const geo::Direction middle = geo::directionFromDegrees(47.0, 8.2);
  const tiling::Tiling tiling(GetParam());
  Remote patch(raster::Kind::elevation, GetParam(), 9);
  patch.planet->height = [](const geo::Direction& d) { return 500.0 + hillsAt(d); };
  patch.planet->stored = [=](const TileId& id) {
    const auto cap = tiling.cap(id);
    return geo::angleBetween(cap.centre, middle).degrees() < cap.radius.degrees() + 0.05;
  };
  const auto planet = std::make_shared<ProceduralSource>(raster::Kind::elevation, GetParam(), 5);
  // Little memory: what is needed again has to be prepared again.
  const auto globe = globeOf({.elevation = {planet, patch.source}, .imagery = {}, .resources = {}}, GetParam(),
                             {.workers = 2, .cpuCacheBytes = 1u << 20});
  const auto late = pictureOf(completed(*globe, view, {patch.server}, 3));
  EXPECT_EQ(patch.source->unpreparedLoads(), 0);
  EXPECT_TRUE(globe->failures().empty());
  const auto local = globeOf({.elevation = {planet, patch.planet}, .imagery = {}, .resources = {}}, GetParam());
  EXPECT_EQ(late, pictureOf(completed(*local, view, {})));
}

/// A server that loses what it once had, and never had the finest: a tile fails where its stand-ins are kept no more.
class Decaying final : public raster::TileSource {
 public:
  explicit Decaying(std::shared_ptr<RemoteSource> source) : source_(std::move(source)) {}
  const raster::TileSourceInfo& info() const override { return source_->info(); }
  std::optional<raster::TilePresence> presence(const TileId& id) const override { return source_->presence(id); }
  std::unique_ptr<raster::Preparation> prepare(const TileId& id, double priority,
                                               std::function<void()> ready) const override {
    return source_->prepare(id, priority, std::move(ready));
  }
  io::Result<std::optional<raster::SourceTile>> load(const TileId& id) const override {
    {
      const std::lock_guard lock(mutex_);
      const bool isAgain = !loaded_.insert(id).second;
      if (id.level == info().maxLevel || (isAgain && id.level > 1)) {
        return io::fail(io::Failure::Code::corrupt, "is lost", info().name);
      }
    }
    return source_->load(id);
  }

 private:
  std::shared_ptr<RemoteSource> source_;
  mutable std::mutex mutex_;
  mutable std::set<TileId> loaded_;
};

TEST_P(LateLayers, whatStandsInForLostTilesIsFetchedBeforeAWorkerNeedsIt) {
  Remote patch(raster::Kind::elevation, GetParam());
  const auto planet = std::make_shared<ProceduralSource>(raster::Kind::elevation, GetParam(), 8);
  // Little memory, so that what once was loaded is dropped, and lost when it is asked for again.
  const auto globe =
      globeOf({.elevation = {planet, std::make_shared<Decaying>(patch.source)}, .imagery = {}, .resources = {}},
              GetParam(), {.workers = 2, .cpuCacheBytes = 1u << 20});
  completed(*globe, hillsView(), {patch.server}, 5);
  EXPECT_FALSE(globe->failures().empty());
  EXPECT_EQ(patch.source->unpreparedLoads(), 0);
}

/// Whatever the eye did before: once all has come, all fades to its place and the frame is complete.
TEST_P(LateLayers, withAClockAFrameAtRestIsCompleteAtLast) {
  constexpr double kFrame_s = 0.05;
  auto random = geo::seededGenerator();
  Remote ground(raster::Kind::elevation, GetParam(), 5);
  Remote colours(raster::Kind::imagery, GetParam(), 7);
  const auto globe =
      globeOf({.elevation = {ground.source}, .imagery = {{.source = colours.source}}, .resources = {}}, GetParam());
  double time_s = 0.0;
  const auto next = [&](const View& view, int answers) -> const Frame& {
    ground.server->serve(answers);
    colours.server->serve(answers);
    const Frame& frame = globe->update(view, {.time_s = time_s += kFrame_s});
    globe->waitForArrivals(2ms);
    return frame;
  };
  const auto between = [&](double low, double high) { return geo::uniform(random, low, high); };
  View view = hillsView();
  for (int leg = 0; leg < 6; ++leg) {
    double lat = between(-80, 80);
    const double lon = between(-180, 180);
    const double height_m = std::exp(between(std::log(5e3), std::log(5e6)));
    double heading = between(0, 360);
    const double pitch = between(-90, -5);
    for (int i = 0; i < 20; ++i)
      next(view = viewFrom(lat += 0.02, lon, height_m, heading += 3, pitch, kViewport), 2);
  }
  const auto end = std::chrono::steady_clock::now() + 240s;
  const Frame* frame = &next(view, 1000);
  int framesWithAll = 0;
  while (!frame->complete && framesWithAll < 1000 && std::chrono::steady_clock::now() < end) {
    frame = &next(view, 1000);
    if (frame->statistics.tilesWanted == 0 && frame->statistics.layersComing == 0) ++framesWithAll;
  }
  EXPECT_TRUE(frame->complete) << frame->statistics.tilesWanted << " wanted, morphing " << frame->morphing;
  // A level after the other, 0.3 s each at most; both ways.
  EXPECT_LT(framesWithAll, 2 * 8 * 0.3 / kFrame_s);
}

/// A root at a time, those in sight first; the far side not before it is looked at.
TEST_P(LateLayers, imageryTakesPartWhereItsRootsAreHere) {
  const View here = hillsView();
  const View there = viewFrom(-46.6, -172.0, 60e3, 20, -35, kViewport);
  const tiling::Tiling tiling(GetParam());
  Remote colours(raster::Kind::imagery, GetParam());
  const auto globe = globeOf({.elevation = {}, .imagery = {{.source = colours.source}}, .resources = {}}, GetParam());
  // What is in sight is known once there is a first cut.
  ASSERT_TRUE(comesTrue(*globe, here, [](const Frame& frame) { return !frame.tiles.empty(); }));
  passed(*globe, here, 5);
  colours.server->serve(1);
  const Frame* frame = &passed(*globe, here);
  EXPECT_EQ(frame->statistics.layersComing, 0);
  EXPECT_TRUE(std::ranges::any_of(frame->tiles, [](const DrawnTile& tile) { return tile.pictureCount == 1; }));
  EXPECT_FALSE(frame->complete);
  completed(*globe, here, {colours.server}, 1);
  const auto farRoot = static_cast<std::uint8_t>(tiling.rootPoint(geo::directionFromDegrees(-46.6, -172.0)).root);
  EXPECT_EQ(colours.server->answered().count({.level = 0, .root = farRoot}), 0u);
  // Turned round, the surface is whole all the same.
  const auto places = placesIn(there);
  for (int i = 0; i < 40; ++i) {
    expectWhole(globe->update(there), tiling, places);
    if (HasFatalFailure()) return;
    if (i > 5) colours.server->serve(1);
    globe->waitForArrivals(5ms);
  }
  const auto late = pictureOf(completed(*globe, there, {colours.server}));
  EXPECT_EQ(colours.source->unpreparedLoads(), 0);
  EXPECT_TRUE(globe->failures().empty());
  expectAskedOnce(*colours.server);
  const auto local = globeOf({.elevation = {}, .imagery = {{.source = colours.planet}}, .resources = {}}, GetParam());
  EXPECT_EQ(late, pictureOf(completed(*local, there, {})));
}

/// Heights, too: what is in sight first. Ground of which the heights are not here is flat, and finer all the same where
/// they are.
TEST_P(LateLayers, elevationTakesPartWhereItsRootsAreHere) {
  const View view = viewFrom(20.0, 8.0, 12e6, 0, -90, kViewport);
  const tiling::Tiling tiling(GetParam());
  const auto places = placesIn(view);
  Remote ground(raster::Kind::elevation, GetParam(), 4);
  const auto globe = globeOf({.elevation = {ground.source}, .imagery = {}, .resources = {}}, GetParam());
  const auto end = std::chrono::steady_clock::now() + 240s;
  while (globe->update(view).statistics.tilesWanted > 0 && std::chrono::steady_clock::now() < end)
    globe->waitForArrivals(5ms);
  std::size_t here = 0;
  const auto look = [&] {
    const Frame& frame = globe->update(view);
    ASSERT_NO_FATAL_FAILURE(expectWhole(frame, tiling, places));
    EXPECT_GE(frame.statistics.layersComing, 1) << "it is not done before its last root";
    EXPECT_FALSE(frame.complete);
    std::size_t withHeights = 0;
    for (const geo::Direction& place : places)
      withHeights += *globe->groundHeight_m(place) != 0.0 ? 1u : 0u;
    EXPECT_GE(withHeights, here) << "ground that had heights has none";
    here = withHeights;
    globe->waitForArrivals(5ms);
  };
  ground.server->serve(1);
  while (here == 0 && std::chrono::steady_clock::now() < end)
    ASSERT_NO_FATAL_FAILURE(look());
  EXPECT_GT(here, 0u) << "one root alone shows";
  EXPECT_LT(here, places.size());
  while (ground.server->answered().size() + 1 < static_cast<std::size_t>(tiling.rootCount()) &&
         std::chrono::steady_clock::now() < end) {
    ground.server->serve(1);
    for (int i = 0; i < 5; ++i)
      ASSERT_NO_FATAL_FAILURE(look());
  }
  const auto late = pictureOf(completed(*globe, view, {ground.server}));
  EXPECT_EQ(ground.source->unpreparedLoads(), 0);
  EXPECT_TRUE(globe->lateLayers().empty());
  expectAskedOnce(*ground.server);
  const auto local = globeOf({.elevation = {ground.planet}, .imagery = {}, .resources = {}}, GetParam());
  EXPECT_EQ(late, pictureOf(completed(*local, view, {})));
}

/// One small answer is a picture on every root, which becomes the layer's own root by root.
TEST_P(LateLayers, anOverviewIsSeenBeforeTheFirstRoot) {
  const View view = hillsView();
  Remote colours(raster::Kind::imagery, GetParam());
  Remote overview(raster::Kind::imagery, GetParam(), 0);
  colours.source->overviewSource = overview.source;
  const auto globe = globeOf({.elevation = {}, .imagery = {{.source = colours.source}}, .resources = {}}, GetParam());
  passed(*globe, view, 5);
  overview.server->serve(1000);
  const Frame* frame = &passed(*globe, view);
  EXPECT_GT(frame->tiles.size(), 0u);
  for (const DrawnTile& tile : frame->tiles)
    EXPECT_EQ(tile.pictureCount, 1u);
  EXPECT_FALSE(frame->complete);
  EXPECT_TRUE(colours.server->answered().empty());
  const auto late = pictureOf(completed(*globe, view, {colours.server}, 1));
  EXPECT_EQ(overview.source->unpreparedLoads() + colours.source->unpreparedLoads(), 0);
  const auto local = globeOf({.elevation = {}, .imagery = {{.source = colours.planet}}, .resources = {}}, GetParam());
  EXPECT_EQ(late, pictureOf(completed(*local, view, {})));
}

/// Whatever the number of roots: they would take all connections, and what is under way is not taken back.
TEST_P(LateLayers, anOverviewIsTheFirstImageThatIsAskedFor) {
  const auto planet = std::make_shared<ProceduralSource>(raster::Kind::imagery, GetParam(), 6);
  const auto server = std::make_shared<FakeServer>(FakeServer::Line{.places = 6});
  const auto colours = std::make_shared<RemoteSource>(planet, server);
  const auto overview =
      std::make_shared<RemoteSource>(std::make_shared<ProceduralSource>(raster::Kind::imagery, GetParam(), 0), server);
  colours->overviewSource = overview;
  // Open from the start, and opened by a thread.
  for (const LayerSource& source : {LayerSource(colours), LayerSource([&] { return colours; }, "http://there")}) {
    const std::size_t before = server->begun().size();
    const auto globe = globeOf({.elevation = {}, .imagery = {{.source = source}}, .resources = {}}, GetParam());
    ASSERT_TRUE(comesTrue(*globe, hillsView(), [&](const Frame&) { return server->begun().size() > before; }));
    passed(*globe, hillsView(), 10);
    const auto begun = server->begun();
    for (std::size_t i = before; i < begun.size(); ++i)
      EXPECT_EQ(begun[i], overview.get()) << "roots wait until it has come";
    server->serve(1000);
    ASSERT_TRUE(comesTrue(*globe, hillsView(), showsPictures));
    for (const DrawnTile& tile : globe->update(hillsView()).tiles)
      EXPECT_EQ(tile.pictureCount, 1u);
    EXPECT_EQ(server->begun().back(), colours.get());
  }
}

TEST(LateLayers, anOverviewThatNeverComesKeepsNoRootsBack) {
  Remote colours(raster::Kind::imagery);
  Remote overview(raster::Kind::imagery, Scheme::cube, 0);
  colours.source->overviewSource = overview.source;
  const auto globe = globeOf({.elevation = {}, .imagery = {{.source = colours.source}}, .resources = {}});
  completed(*globe, hillsView(), {colours.server});
  EXPECT_TRUE(overview.server->answered().empty());
}

/// As pictures of several servers' heights do: of what is here first, then of all.
TEST(LateLayers, aDataSetMayTakeTheOthersPlace) {
  const View view = hillsView();
  Remote first(raster::Kind::imagery, Scheme::cube, 5);
  Remote whole(raster::Kind::imagery, Scheme::cube, 4);
  GlobeLayers::Imagery layer{.source = first.source};
  layer.alsoFrom.emplace_back(whole.source);
  layer.alsoFrom.back().replacesOthers = true;
  GlobeLayers layers;
  layers.imagery.push_back(std::move(layer));
  const auto globe = globeOf(std::move(layers));
  const auto end = std::chrono::steady_clock::now() + 240s;
  const Frame* frame = &globe->update(view);
  while (frame->statistics.layersComing != 1 && std::chrono::steady_clock::now() < end) {
    first.server->serve(1000);
    globe->waitForArrivals(5ms);
    frame = &globe->update(view);
  }
  EXPECT_EQ(frame->statistics.layersComing, 1);
  frame = &passed(*globe, view);
  EXPECT_TRUE(std::ranges::any_of(frame->tiles, [](const DrawnTile& tile) { return tile.pictureCount == 1; }));
  const auto late = pictureOf(completed(*globe, view, {first.server, whole.server}));
  const auto local = globeOf({.elevation = {}, .imagery = {{.source = whole.planet}}, .resources = {}});
  EXPECT_EQ(late, pictureOf(completed(*local, view, {}))) << "nothing is left of the first, though it is finer";
}

TEST(LateLayers, aLayerThatIsLateIsNamed) {
  Remote ground(raster::Kind::elevation);
  const LayerSource::Opening fails = []() -> io::Result<LayerSource::Pointer> {
    return io::fail(io::Failure::Code::ioError, "the server does not answer");
  };
  const auto globe = globeOf({.elevation = {ground.source},
                              .imagery = {{.source = LayerSource(fails, "http://me:word@there/wms?token=abc")}},
                              .resources = {}});
  passed(*globe, hillsView(), 3);
  const auto late = globe->lateLayers();
  ASSERT_EQ(late.size(), 2u);
  EXPECT_EQ(late[0].where, "procedural");
  EXPECT_NE(late[0].message.find("elevation.0"), late[0].message.npos) << late[0].message;
  EXPECT_EQ(late[1].where, "http://there/wms?token=***");
  EXPECT_NE(late[1].message.find("imagery.0"), late[1].message.npos) << late[1].message;
}

/// Whose layers are opened by threads that wait until the test lets them go.
class HangingServer {
 public:
  /// In any case before the globe ends, which waits for its threads.
  class LetGo {
   public:
    explicit LetGo(HangingServer& server) : server_(server) {}
    ~LetGo() { server_.letGo(); }
    LetGo(const LetGo&) = delete;
    LetGo& operator=(const LetGo&) = delete;

   private:
    HangingServer& server_;
  };
  LayerSource source(const std::string& name) {
    const auto opening = [this]() -> io::Result<LayerSource::Pointer> {
      ++asked_;
      std::unique_lock lock(mutex_);
      mostAtOnce_ = std::max(mostAtOnce_, ++atOnce_);
      changed_.wait(lock, [&] { return isLetGo_; });
      --atOnce_;
      return io::fail(io::Failure::Code::notFound, "never was there");
    };
    return {opening, name};
  }
  int asked() const { return asked_; }
  int mostAtOnce() {
    const std::lock_guard lock(mutex_);
    return mostAtOnce_;
  }
  void letGo() {
    const std::lock_guard lock(mutex_);
    isLetGo_ = true;
    changed_.notify_all();
  }

 private:
  std::atomic<int> asked_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool isLetGo_ = false;
  int atOnce_ = 0;
  int mostAtOnce_ = 0;
};

TEST(LateLayers, aServerThatHangsKeepsNoOthersLayersShut) {
  constexpr int kHanging = 9;
  HangingServer hanging;
  const auto planet = std::make_shared<ProceduralSource>(raster::Kind::imagery, Scheme::cube, 3);
  GlobeLayers layers;
  for (int i = 0; i < kHanging; ++i)
    layers.imagery.push_back({.source = hanging.source("http://hangs/wms?layer=" + std::to_string(i))});
  layers.imagery.push_back({.source = LayerSource([&] { return planet; }, "http://well/wms")});
  const auto globe = globeOf(std::move(layers));
  const HangingServer::LetGo atTheEnd(hanging);
  EXPECT_TRUE(comesTrue(*globe, hillsView(), showsPictures));
  EXPECT_LE(hanging.mostAtOnce(), 2);
  hanging.letGo();
  EXPECT_TRUE(comesTrue(*globe, hillsView(), [](const Frame& frame) { return frame.statistics.layersComing == 0; }));
  EXPECT_EQ(hanging.asked(), kHanging) << "each has its turn";
}

/// However many pictures are made of them, heights of a server that hangs keep nothing else waiting, and the blame is
/// theirs.
TEST(LateLayers, picturesOfHeightsBeginWithTheServerThatAnswers) {
  HangingServer hanging;
  std::atomic<bool> isWell = false;
  const auto planet = std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 2);
  const auto opening = [&]() -> io::Result<LayerSource::Pointer> {
    if (!isWell) return io::fail(io::Failure::Code::ioError, "not yet");
    return LayerSource::Pointer(planet);
  };
  const SharedSources heights = {std::make_shared<SharedSource>(hanging.source("http://hangs/wms"), std::nullopt),
                                 std::make_shared<SharedSource>(LayerSource(opening, "http://well/wms"), std::nullopt)};
  GlobeLayers layers;
  for (const auto& each : heights)
    layers.elevation.push_back(layerOf(each));
  for (int i = 0; i < 5; ++i) {
    auto sources = derivedLayer(heights, raster::Hillshade{}, SharedSource::OpenedBy::layersOfItsOwn);
    ASSERT_TRUE(sources);
    ASSERT_EQ(sources->size(), 2u);
    layers.imagery.push_back({.source = sources->front()});
    layers.imagery.back().alsoFrom.push_back(sources->back());
  }
  const auto globe = globeOf(std::move(layers));
  const HangingServer::LetGo atTheEnd(hanging);
  passed(*globe, hillsView(), 5);
  const auto blamed = [&](const std::string& layer) {
    std::vector<std::string> servers;
    for (const io::Failure& late : globe->lateLayers()) {
      if (late.message.starts_with(layer + " ")) servers.push_back(late.where);
    }
    return servers;
  };
  EXPECT_EQ(blamed("imagery.3"), (std::vector<std::string>{"http://hangs/wms", "http://well/wms"}));
  isWell = true;
  EXPECT_TRUE(comesTrue(*globe, hillsView(), showsPictures));
  EXPECT_EQ(blamed("imagery.3"), std::vector<std::string>{"http://hangs/wms"});
  EXPECT_EQ(blamed("elevation.0"), std::vector<std::string>{"http://hangs/wms"});
  EXPECT_TRUE(blamed("elevation.1").empty());
  EXPECT_EQ(hanging.asked(), 1);
  // It says at last that there is nothing: pictures of the rest are all there is.
  hanging.letGo();
  EXPECT_TRUE(comesTrue(*globe, hillsView(), [](const Frame& frame) { return frame.complete; }));
  EXPECT_TRUE(globe->lateLayers().empty());
}

TEST(LateLayers, turningAwayCancelsWhatIsOnItsWay) {
  Remote colours(raster::Kind::imagery, Scheme::cube, 9);
  const auto globe = globeOf({.elevation = {}, .imagery = {{.source = colours.source}}, .resources = {}});
  const View here = viewFrom(0, 0, 100e3, 0, -60, kViewport);
  const View there = viewFrom(0, 170, 100e3, 0, -60, kViewport);
  for (int i = 0; i < 1000 && (i < 5 || colours.server->waiting() == 0); ++i) {
    if (i < 5) colours.server->serve(6);
    passed(*globe, here, 3);
  }
  ASSERT_GT(colours.server->waiting(), 0u);
  const int before = colours.server->cancelled();
  globe->update(there);
  EXPECT_GT(colours.server->cancelled(), before);
  completed(*globe, there, {colours.server});
  // Back again: only what was turned away from is asked for a second time.
  completed(*globe, here, {colours.server});
  expectAskedOnce(*colours.server);
}

TEST(LateLayers, aServerOfOneLayerThatIsDeadKeepsNoOtherLayerBack) {
  const View view = hillsView();
  Remote dead(raster::Kind::elevation);
  Remote well(raster::Kind::imagery);
  const auto globe = globeOf({.elevation = {dead.source}, .imagery = {{.source = well.source}}, .resources = {}});
  const Frame* frame = nullptr;
  for (int i = 0; i < 400; ++i) {
    well.server->serve(1000);
    frame = &globe->update(view);
    if (frame->statistics.layersComing == 1 && frame->statistics.tilesWanted == 0) break;
    globe->waitForArrivals(20ms);
  }
  EXPECT_EQ(frame->statistics.layersComing, 1);
  EXPECT_EQ(frame->statistics.tilesWanted, 0);
  EXPECT_FALSE(frame->complete);
  for (const DrawnTile& tile : frame->tiles)
    EXPECT_EQ(tile.pictureCount, 1u);
  // The elevation comes after all.
  const auto late = pictureOf(completed(*globe, view, {dead.server, well.server}));
  const auto local = globeOf({.elevation = {dead.planet}, .imagery = {{.source = well.planet}}, .resources = {}});
  EXPECT_EQ(late, pictureOf(completed(*local, view, {})));
  expectAskedOnce(*dead.server);
  expectAskedOnce(*well.server);
}

/// How many tiles a settled picture has, and at least has while colours come to it; nothing where they took so long
/// that the new may be shown before it is as good.
std::optional<std::pair<std::size_t, std::size_t>> settledAndFewestWhileColoursCome() {
  const View view = hillsView();
  const auto planet = std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 6);
  Remote colours(raster::Kind::imagery);
  const auto globe = globeOf({.elevation = {planet}, .imagery = {{.source = colours.source}}, .resources = {}});
  const auto end = std::chrono::steady_clock::now() + 240s;
  while (globe->update(view).statistics.tilesWanted != 0 && std::chrono::steady_clock::now() < end)
    globe->waitForArrivals(20ms);
  const std::size_t settled = globe->update(view).tiles.size();
  std::size_t fewest = settled;
  const auto start = std::chrono::steady_clock::now();
  for (bool isComplete = false; !isComplete;) {
    if (std::chrono::steady_clock::now() > start + 900ms) return std::nullopt;
    colours.server->serve(1000);
    const Frame& frame = globe->update(view);
    fewest = std::min(fewest, frame.tiles.size());
    isComplete = frame.complete;
    if (!isComplete) globe->waitForArrivals(20ms);
  }
  return std::pair(settled, fewest);
}

TEST(LateLayers, whatIsDrawnStaysUntilTheNewIsAsGood) {
  for (int tries = 0; tries < 5; ++tries) {
    const auto seen = settledAndFewestWhileColoursCome();
    if (!seen) continue;
    const auto [settled, fewest] = *seen;
    ASSERT_GT(settled, 20u);
    EXPECT_EQ(fewest, settled) << "all colours come at once: no frame in between falls back to the roots";
    return;
  }
  GTEST_SKIP() << "too busy a machine";
}

TEST(LateLayers, sourcesAreOpenedOnAnotherThreadAndAgainWhileTheyFail) {
  const View view = hillsView();
  Remote colours(raster::Kind::imagery);
  std::atomic<int> tries{0};
  const LayerSource::Opening opening = [&]() -> io::Result<LayerSource::Pointer> {
    std::this_thread::sleep_for(20ms);
    if (++tries < 2) return io::fail(io::Failure::Code::ioError, "the server does not answer");
    return LayerSource::Pointer(colours.source);
  };
  const auto globe =
      globeOf({.elevation = {}, .imagery = {{.source = LayerSource(opening, "http://there")}}, .resources = {}});
  const Frame* frame = &globe->update(view);
  EXPECT_EQ(frame->statistics.layersComing, 1);
  bool told = false;
  const auto end = std::chrono::steady_clock::now() + 240s;
  while (!frame->complete && std::chrono::steady_clock::now() < end) {
    colours.server->serve(1000);
    globe->waitForArrivals(20ms);
    frame = &globe->update(view);
    for (const io::Failure& trouble : globe->troubles())
      told = told || io::describe(trouble) == "http://there: the server does not answer";
  }
  EXPECT_TRUE(frame->complete);
  EXPECT_TRUE(told);
  EXPECT_TRUE(globe->troubles().empty());
  EXPECT_TRUE(globe->failures().empty());
  EXPECT_EQ(tries, 2);
}

TEST(LateLayers, aLayerThatNeverCanBeOpenedIsAFailureAndTheRestIsDrawn) {
  const auto planet = std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 4);
  Remote wrong(raster::Kind::imagery, Scheme::healpix);
  const LayerSource::Opening opensWrong = [&] { return LayerSource::Pointer(wrong.source); };
  const LayerSource::Opening fails = [&]() -> io::Result<LayerSource::Pointer> {
    return io::fail(io::Failure::Code::notFound, "no layer 'x'; the server offers: y", "http://there");
  };
  const auto globe =
      globeOf({.elevation = {planet},
               .imagery = {{.source = LayerSource(opensWrong, "a")}, {.source = LayerSource(fails, "b")}},
               .resources = {}});
  const Frame& frame = completed(*globe, hillsView(), {});
  EXPECT_EQ(frame.statistics.failures, 2u);
  ASSERT_EQ(globe->failures().size(), 2u);
  EXPECT_GT(frame.tiles.size(), 20u);
}

TEST(LateLayers, aGlobeThatGoesDoesNotWaitForServers) {
  Remote ground(raster::Kind::elevation);
  {
    const auto globe = globeOf({.elevation = {ground.source}, .imagery = {}, .resources = {}});
    passed(*globe, hillsView(), 3);
    ground.server->serve(6);
    for (int i = 0; i < 1000 && ground.server->waiting() == 0; ++i)
      passed(*globe, hillsView(), 1);
    EXPECT_GT(ground.server->waiting(), 0u);
  }
  // To be here at all is the proof: the server never answers what it has been asked for.
  EXPECT_EQ(ground.server->waiting(), 0u);
}

}  // namespace
}  // namespace tellurion::scene
