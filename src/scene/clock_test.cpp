// Layers that follow the clock: what is drawn while it is set, and what is asked of whom.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <thread>

#include "geo/body.h"
#include "io/other_threads_test.h"
#include "scene/globe.h"
#include "scene/procedural_source_test.h"
#include "scene/scene_clock.h"

namespace tellurion::scene {
namespace {

using namespace std::chrono_literals;

constexpr int kImageryLevels = 4;

/// One colour, down to a level.
class PlainImages final : public raster::TileSource {
 public:
  explicit PlainImages(std::uint8_t red) : red_(red) {
    info_ = {.name = "plain",
             .kind = raster::Kind::imagery,
             .scheme = tiling::Scheme::cube,
             .tileCells = raster::kImageryPixels,
             .maxLevel = kImageryLevels};
  }
  const raster::TileSourceInfo& info() const override { return info_; }
  io::Result<std::optional<raster::SourceTile>> load(const tiling::TileId& id) const override {
    while (held)
      std::this_thread::sleep_for(1ms);
    ++loads;
    raster::SourceTile tile;
    tile.childMask = id.level < kImageryLevels ? 15 : 0;
    tile.payload = raster::ImageryTile{raster::Raster<raster::Rgba8>(258, 258, {red_, 9, 9, 255})};
    return std::optional(std::move(tile));
  }
  std::atomic<bool> held{false};
  mutable std::atomic<int> loads{0};

 private:
  raster::TileSourceInfo info_;
  std::uint8_t red_;
};

class Clock : public testing::Test {
 protected:
  Clock() {
    for (std::uint8_t i = 0; i < 4; ++i) {
      steps.push_back(std::make_shared<PlainImages>(static_cast<std::uint8_t>(50 * i + 50)));
      layer.steps.push_back({.time_s = 100.0 * i, .source = steps.back()});
    }
    ground = std::make_shared<ProceduralSource>(raster::Kind::elevation, tiling::Scheme::cube, 6);
  }
  ~Clock() override {
    for (const auto& step : steps)
      step->held = false;
  }

  void open(double start_s, std::uint64_t cacheBytes = std::uint64_t{1} << 30u) {
    Scene scene;
    scene.clock.start_s = start_s;
    globe =
        Globe::fromLayers(scene, {.elevation = {ground}, .imagery = {layer}}, {.cpuCacheBytes = cacheBytes}).value();
  }
  const Frame& update() { return globe->update(view); }
  /// How often each colour is drawn.
  std::map<int, int> colours(const Frame& frame) const {
    std::map<int, int> out;
    for (const DrawnTile& tile : frame.tiles) {
      ++out[tile.pictureCount == 0 ? 0 : int{frame.pictures[tile.firstPicture].image->mips[0].samples[0].r}];
    }
    return out;
  }
  const Frame& settled() {
    const auto end = std::chrono::steady_clock::now() + 240s;
    while (!update().complete && std::chrono::steady_clock::now() < end)
      globe->waitForArrivals(50ms);
    return update();
  }
  static std::set<std::uint64_t> meshes(const Frame& frame) {
    std::set<std::uint64_t> out;
    for (const DrawnTile& tile : frame.tiles)
      out.insert(tile.mesh->serial);
    return out;
  }
  /// Until nothing more is loaded ahead.
  void rest() {
    int before = -1;
    for (int same = 0; same < 2;) {
      update();
      while (!io::othersSleep())
        std::this_thread::sleep_for(100us);
      int now = 0;
      for (const auto& step : steps)
        now += step->loads;
      same = now == before ? same + 1 : 0;
      before = now;
    }
  }

  View view =
      viewOf(Camera{.position = {.lat = geo::Angle::degrees(20.0), .lon = geo::Angle::degrees(40.0), .height_m = 1.5e6},
                    .pitch = geo::Angle::degrees(-90.0)},
             geo::earth().ellipsoid, geo::Angle::degrees(45.0), {.width = 640, .height = 480});
  std::vector<std::shared_ptr<PlainImages>> steps;
  GlobeLayers::Imagery layer;
  std::shared_ptr<ProceduralSource> ground;
  std::unique_ptr<Globe> globe;
};

TEST_F(Clock, theNewestStepThatIsNotAfterItIsShown) {
  open(250.0);
  EXPECT_EQ(globe->clock(), 250.0);
  EXPECT_EQ(colours(settled()).size(), 1u);
  EXPECT_EQ(colours(settled()).begin()->first, 150);
  for (const auto& [time_s, red] :
       {std::pair(99.9, 50), std::pair(100.0, 100), std::pair(1e9, 200), std::pair(-5.0, 50)}) {
    globe->setClock(time_s);
    const auto drawn = colours(settled());
    ASSERT_EQ(drawn.size(), 1u) << time_s;
    EXPECT_EQ(drawn.begin()->first, red) << time_s;
  }
}

TEST_F(Clock, withoutATimeItIsTheLast) {
  Scene scene;
  globe = Globe::fromLayers(scene, {.elevation = {ground}, .imagery = {layer}}).value();
  EXPECT_FALSE(globe->clock());
  EXPECT_EQ(colours(settled()).begin()->first, 200);
}

TEST_F(Clock, picturesAreExchangedWithoutABlankFrameAndNothingElseIsMade) {
  open(0.0);
  const auto before = meshes(settled());
  const auto tiles = update().tiles.size();
  const auto groundRequests = ground->requests();
  steps[1]->held = true;
  globe->setClock(100.0);
  for (int i = 0; i < 10; ++i) {
    const Frame& frame = update();
    EXPECT_FALSE(frame.complete);
    EXPECT_EQ(colours(frame), (std::map<int, int>{{50, static_cast<int>(tiles)}}));
    std::this_thread::sleep_for(2ms);
  }
  steps[1]->held = false;
  bool mixed = false;
  for (;;) {
    const Frame& frame = update();
    const auto drawn = colours(frame);
    int all = 0;
    for (const auto& [red, count] : drawn) {
      EXPECT_TRUE(red == 50 || red == 100) << red;
      all += count;
    }
    ASSERT_EQ(all, static_cast<int>(tiles));
    EXPECT_EQ(meshes(frame), before);
    mixed = mixed || drawn.size() == 2;
    if (frame.complete) break;
    globe->waitForArrivals(50ms);
  }
  EXPECT_EQ(colours(update()), (std::map<int, int>{{100, static_cast<int>(tiles)}}));
  EXPECT_EQ(ground->requests(), groundRequests);
}

TEST_F(Clock, theNextStepInItsDirectionIsLoadedAhead) {
  open(100.0);
  settled();
  rest();
  EXPECT_GT(steps[2]->loads, 0);
  EXPECT_EQ(steps[3]->loads, 0);
  EXPECT_EQ(steps[0]->loads, 0);
  const int ahead = steps[2]->loads;
  globe->setClock(200.0);
  EXPECT_EQ(colours(settled()).begin()->first, 150);
  EXPECT_EQ(steps[2]->loads, ahead) << "what was loaded ahead is what is needed";
  // It turns round.
  globe->setClock(199.0);
  settled();
  rest();
  EXPECT_GT(steps[0]->loads, 0);
}

TEST_F(Clock, playingStaysInItsBudget) {
  constexpr std::uint64_t kBudget = std::uint64_t{96} << 20u;
  open(0.0, kBudget);
  settled();
  std::uint64_t most = 0;
  for (int round = 0; round < 12; ++round) {
    globe->setClock(100.0 * (round % 4));
    settled();
    for (int i = 0; i < 5; ++i)
      most = std::max(most, update().statistics.cpuCacheBytes);
  }
  // What is drawn is held in any case.
  EXPECT_LT(most, kBudget * 5 / 4);
}

TEST_F(Clock, stepsOfAServerAreKnownOnceItHasAnswered) {
  std::atomic<int> answers{0};
  std::atomic<int> opened{0};
  GlobeLayers::Imagery online;
  online.source = LayerSource([]() -> io::Result<LayerSource::Pointer> { return nullptr; }, "server");
  online.openSteps = [&]() -> io::Result<std::vector<TimedSource>> {
    if (++answers == 1) return io::fail(io::Failure::Code::ioError, "not now", "server");
    std::vector<TimedSource> out;
    for (const TimedSource& step : layer.steps) {
      const auto open = [&opened, source = step.source.open]() -> io::Result<LayerSource::Pointer> {
        ++opened;
        return source;
      };
      out.push_back({.time_s = step.time_s, .source = LayerSource(open, "step")});
    }
    return out;
  };
  Scene scene;
  scene.clock.start_s = 110.0;
  globe = Globe::fromLayers(scene, {.elevation = {ground}, .imagery = {online}}).value();
  globe->setClock(120.0);
  EXPECT_EQ(colours(settled()).begin()->first, 100);
  EXPECT_EQ(answers, 2);
  globe->setClock(310.0);
  const auto drawn = colours(settled());
  EXPECT_EQ(drawn.size(), 1u);
  EXPECT_EQ(drawn.begin()->first, 200);
  EXPECT_LE(opened, 3) << "the first, one ahead, the last";
}

/// Holds what was drawn; each picture takes 100 bytes.
class PictureGpu final : public Residency {
 public:
  std::uint64_t missingBytes(const TerrainMesh&) const override { return 0; }
  std::uint64_t missingColourBytes(const TextureImage& image) const override {
    return held.contains(image.serial) ? 0 : 100;
  }
  std::uint64_t missingReliefBytes(const TextureImage&) const override { return 0; }
  std::uint64_t departures() const override { return 1; }
  std::uint64_t arrivals() const override { return held.size(); }
  int draw(const Frame& frame) {
    int copied = 0;
    for (const DrawnPicture& picture : frame.pictures)
      copied += held.insert(picture.image->serial).second ? 1 : 0;
    return copied;
  }
  std::set<std::uint64_t> held;
};

TEST_F(Clock, copiesOfNewPicturesAreSpreadOverFrames) {
  open(0.0);
  PictureGpu gpu;
  CutOptions options{.copies_bytes = 300};
  options.time_s = 0.0;
  const auto play = [&](int red) {
    int most = 0;
    for (int i = 0; i < 5000; ++i) {
      *options.time_s += 0.03;
      const Frame& frame = globe->update(view, options, &gpu);
      most = std::max(most, gpu.draw(frame));
      if (frame.complete && colours(frame).begin()->first == red) return most;
      globe->waitForArrivals(20ms);
    }
    ADD_FAILURE() << "never complete";
    return most;
  };
  play(50);
  const std::size_t tiles = globe->update(view, options, &gpu).tiles.size();
  globe->setClock(100.0);
  std::this_thread::sleep_for(100ms);
  EXPECT_LE(play(100), 3);
  EXPECT_EQ(globe->update(view, options, &gpu).tiles.size(), tiles);
}

/// An eye that moves so slowly that cuts are kept for some frames: each of these has its budget, and no more.
TEST_F(Clock, copiesOfNewPicturesAreSpreadOverFramesThatKeepTheirCut) {
  constexpr int kEach = 3;
  open(0.0);
  PictureGpu gpu;
  CutOptions options{.prefetch = false, .copies_bytes = 100 * kEach};
  options.time_s = 0.0;
  double lon = 40.0;
  int kept = 0;
  const auto fly = [&](int red) {
    int most = 0;
    for (int i = 0; i < 5000; ++i) {
      *options.time_s += 0.03;
      lon += 1e-4;
      const View moved = viewOf(
          Camera{.position = {.lat = geo::Angle::degrees(20.0), .lon = geo::Angle::degrees(lon), .height_m = 1.5e6},
                 .pitch = geo::Angle::degrees(-90.0)},
          geo::earth().ellipsoid, geo::Angle::degrees(45.0), {.width = 640, .height = 480});
      const Frame& frame = globe->update(moved, options, &gpu);
      kept += frame.statistics.cutAge > 0 ? 1 : 0;
      most = std::max(most, gpu.draw(frame));
      const auto drawn = colours(frame);
      if (drawn.size() == 1 && drawn.begin()->first == red && frame.statistics.tilesWanted == 0) return most;
      globe->waitForArrivals(5ms);
    }
    ADD_FAILURE() << "never of the new step";
    return most;
  };
  fly(50);
  for (const auto& [time_s, red] : {std::pair(100.0, 100), std::pair(200.0, 150), std::pair(300.0, 200)}) {
    globe->setClock(time_s);
    EXPECT_LE(fly(red), kEach) << time_s;
  }
  EXPECT_GT(kept, 0);
}

TEST(SceneClock, runsToItsEnd) {
  EXPECT_FALSE(timeAfter({}, 3.0));
  EXPECT_EQ(timeAfter({.start_s = 10.0, .rate = 2.0}, 3.0), 16.0);
  EXPECT_EQ(timeAfter({.start_s = 10.0, .end_s = 12.0, .rate = 2.0}, 3.0), 12.0);
  EXPECT_EQ(timeAfter({.start_s = 10.0, .end_s = 5.0, .rate = -2.0}, 3.0), 5.0);
  EXPECT_EQ(timeAfter({.start_s = 10.0, .end_s = 5.0, .rate = 2.0}, 3.0), 16.0);
}

// Truth: GNU date, `date -u -d @SECONDS +"%Y %j %H"`.
TEST(CalendarTime, isThatOfTheCalendar) {
  const auto check = [](double time_s, int year, int day, double hour) {
    const CalendarTime time = calendarTimeOf(time_s);
    EXPECT_EQ(time.year, year) << time_s;
    EXPECT_EQ(time.day, day) << time_s;
    EXPECT_NEAR(time.hour, hour, 1e-9) << time_s;
  };
  check(0.0, 1970, 1, 0.0);
  check(-1.0, 1969, 365, 24.0 - 1.0 / 3600.0);
  check(951825600.0, 2000, 60, 12.0);  // 29 February
  check(1104537599.0, 2004, 366, 24.0 - 1.0 / 3600.0);
  check(-2208988800.0, 1900, 1, 0.0);
  check(-1e30, 0, 1, 0.0);
  check(std::numeric_limits<double>::quiet_NaN(), 0, 1, 0.0);
  check(1e30, 9999, 365, 24.0 - 1.0 / 3600.0);
  EXPECT_EQ(daysOfYear(1900), 365);
  EXPECT_EQ(daysOfYear(2000), 366);
  EXPECT_EQ(daysOfYear(2004), 366);
}

TEST(CalendarTime, comesBack) {
  std::mt19937_64 random(20260601);
  std::uniform_real_distribution<double> anyTime(-62167219200.0, 253402300799.0);
  for (int i = 0; i < 10000; ++i) {
    const double time_s = std::floor(anyTime(random));
    const CalendarTime time = calendarTimeOf(time_s);
    ASSERT_GE(time.day, 1);
    ASSERT_LE(time.day, daysOfYear(time.year));
    ASSERT_GE(time.hour, 0.0);
    ASSERT_LT(time.hour, 24.0);
    ASSERT_NEAR(secondsOf(time), time_s, 1e-4);
    // The end of a day and of a year is the beginning of the next.
    ASSERT_EQ(secondsOf({time.year, daysOfYear(time.year), 24.0}), secondsOf({time.year + 1, 1, 0.0}));
  }
}

}  // namespace
}  // namespace tellurion::scene
