// A slow flight over real ground at 60 frames a second: no point of the ground jumps from one frame to the next.
// Tells what the update of the cut takes.
//
//   flight_tests [--from=T] [--seconds=N]    the part of the 30 seconds that is flown (default: 3 from 22 on)
//                [--tolerance=PIXELS]        that the ground is drawn within (default: 3; 1 draws more than 500 tiles)
//
// Flown four times on each tiling: every frame waiting for its data, with a memory of the last frame and without; in
// real time, with data that come late; and with morphing switched off, all 30 seconds with fewer frames, which has to
// fail what the others pass (at less than the default tolerance nothing need pop by so much).

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "scene/drawn_ground.h"
#include "scene/globe.h"
#include "scene/picking.h"
#include "truth/embedded_earth.h"

namespace tellurion {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

double from = 22.0;
double seconds = 3.0;

constexpr double kTolerance_px = 3.0;  ///< with less, ground seldom pops by half a pixel in any case
double tolerance_px = kTolerance_px;
constexpr double kAllowedJump_px = 0.5;
constexpr scene::Viewport kSize{.width = 1024, .height = 768};
const geo::Ellipsoid kEarth = geo::earth().ellipsoid;

/// Each tile takes a few milliseconds more, as one from a server nearby does.
class SlowSource final : public raster::TileSource {
 public:
  explicit SlowSource(std::shared_ptr<const raster::TileSource> source) : source_(std::move(source)) {}
  const raster::TileSourceInfo& info() const override { return source_->info(); }
  io::Result<std::optional<raster::SourceTile>> load(const tiling::TileId& id) const override {
    std::this_thread::sleep_for(std::chrono::microseconds(2000 + tiling::TileIdHash{}(id) % 8000));
    return source_->load(id);
  }

 private:
  std::shared_ptr<const raster::TileSource> source_;
};

/// From the plain into the mountains at 500 m/s, first 12 km high, turning and going down.
scene::View viewAt(double t) {
  const scene::Camera camera{.position = {.lat = geo::Angle::degrees(27.25 + 500.0 * t / 111e3),
                                          .lon = geo::Angle::degrees(86.6),
                                          .height_m = 12000.0 - 60.0 * t},
                             .heading = geo::Angle::degrees(20.0 + 2.0 * t),
                             .pitch = geo::Angle::degrees(-20.0),
                             .roll = {}};
  return scene::viewOf(camera, kEarth, geo::Angle::degrees(45.0), kSize);
}

std::optional<geo::Vec2> inPicture(const scene::View& view, const geo::BodyPosition& p) {
  const geo::Vec3 v = view.viewFromBody * (p - view.eye);
  if (v.z > -1.0) return std::nullopt;
  const geo::Vec2 at = geo::Vec2(v.x, v.y) / (-v.z * view.pixelAngle());
  if (std::abs(at.x) > 0.5 * view.viewport.width || std::abs(at.y) > 0.5 * view.viewport.height) return std::nullopt;
  return at;
}

struct Flight {
  bool morph = true;
  bool remembers = true;
  bool waits = true;  ///< every frame for its data; else in real time
  double from = tellurion::from;
  double seconds = tellurion::seconds;
  double framesASecond = 60.0;
};

struct Log {
  std::vector<double> update_ms;  ///< of frames that asked for nothing
  std::vector<double> tiles;
  double worst_px = 0.0;
  double worstAt_s = 0.0;
  long compared = 0;
  long over = 0;  ///< jumps that are too large
  int incomplete = 0;
};

double percentile(std::vector<double> all, double share) {
  if (all.empty()) return 0.0;
  std::sort(all.begin(), all.end());
  return all[static_cast<std::size_t>(share * static_cast<double>(all.size() - 1))];
}

/// Points of the ground and where they were drawn last.
class Watched {
 public:
  /// Anywhere in the picture at any time of the flight.
  explicit Watched(const Flight& how) : before_(kPlaces) {
    constexpr double kGround_m = 4000.0;
    std::mt19937_64 random(20261122);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    while (places_.size() < kPlaces) {
      const scene::View view = viewAt(how.from + how.seconds * share(random));
      const double col = share(random) * kSize.width;
      const geo::Ray ray = scene::rayThrough(view, {col, share(random) * kSize.height});
      if (const auto meets = kEarth.intersect(ray, kGround_m))
        places_.push_back(kEarth.directionFromBody(ray.origin + ray.direction * *meets));
    }
  }

  void compare(const scene::Frame& frame, const tiling::Tiling& tiling, double t, Log& log) {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const auto now = scene::drawnPoint(frame, tiling, places_[i]);
      const auto a = now && before_[i] ? inPicture(frame.view, *before_[i]) : std::nullopt;
      const auto b = now && before_[i] ? inPicture(frame.view, *now) : std::nullopt;
      before_[i] = now;
      if (!a || !b) continue;
      const double jump_px = geo::length(*a - *b);
      ++log.compared;
      log.over += jump_px > kAllowedJump_px ? 1 : 0;
      if (jump_px > log.worst_px) {
        log.worst_px = jump_px;
        log.worstAt_s = t;
      }
    }
  }

 private:
  static constexpr std::size_t kPlaces = 600;
  std::vector<geo::Direction> places_;
  std::vector<std::optional<geo::BodyPosition>> before_;
};

Log fly(scene::Globe& globe, const tiling::Tiling& tiling, const Flight& how) {
  Watched ground(how);
  Log log;
  // From when the roots are there, and the first frame has settled.
  const auto deadline = Clock::now() + 120s;
  for (double t = -1e6;
       !globe.update(viewAt(how.from), {.tolerance_px = tolerance_px, .morph = how.morph, .time_s = t}).complete;
       t += 1.0) {
    if (Clock::now() > deadline) {
      ADD_FAILURE() << "does not settle";
      break;
    }
    globe.waitForArrivals(100ms);
  }
  const int frames = static_cast<int>(how.seconds * how.framesASecond);
  for (int k = 0; k < frames; ++k) {
    const auto start = Clock::now();
    const double t = how.from + k / how.framesASecond;
    const scene::CutOptions options{
        .tolerance_px = tolerance_px, .morph = how.morph, .time_s = how.remembers ? std::optional(t) : std::nullopt};
    const scene::Frame* frame = &globe.update(viewAt(t), options);
    for (int i = 0; how.waits && frame->statistics.tilesWanted > 0 && i < 1000; ++i) {
      globe.waitForArrivals(1000ms);
      frame = &globe.update(viewAt(t), options);
    }
    log.incomplete += frame->statistics.tilesWanted > 0 ? 1 : 0;
    log.update_ms.push_back(frame->statistics.update_ms);
    log.tiles.push_back(static_cast<double>(frame->tiles.size()));
    ground.compare(*frame, tiling, t, log);
    if (!how.waits) std::this_thread::sleep_until(start + std::chrono::duration<double>(1.0 / how.framesASecond));
  }
  return log;
}

void print(const std::string& tiling, const char* what, const Log& log) {
  std::printf(
      "%-10s %-22s largest jump %6.3f px (at %5.2f s), %ld of %ld over %g px; %3.0f tiles, cut %.3f ms, 99%% %.3f ms; "
      "%d frames wanted more\n",
      tiling.c_str(), what, log.worst_px, log.worstAt_s, log.over, log.compared, kAllowedJump_px,
      percentile(log.tiles, 0.5), percentile(log.update_ms, 0.5), percentile(log.update_ms, 0.99), log.incomplete);
}

class SlowFlight : public testing::TestWithParam<tiling::Scheme> {};

TEST_P(SlowFlight, nothingPops) {
  const std::string name(nameOf(GetParam()));
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("flight_" + name + std::to_string(getpid()));
  const auto source = earthOn(GetParam(), folder);
  ASSERT_TRUE(source);
  const auto flown = [&](const char* what, const Flight& how) {
    std::shared_ptr<const raster::TileSource> ground = source;
    if (!how.waits) ground = std::make_shared<SlowSource>(source);
    auto globe = scene::Globe::fromLayers({.body = geo::earth(), .tiling = GetParam()}, {.elevation = {ground}});
    EXPECT_TRUE(globe);
    Log log = fly(**globe, tiling::Tiling(GetParam()), how);
    print(name, what, log);
    EXPECT_GT(log.compared, how.seconds * how.framesASecond * 20);
    return log;
  };
  EXPECT_LE(flown("waits, remembers", {}).worst_px, kAllowedJump_px);
  EXPECT_LE(flown("waits, by place alone", {.remembers = false}).worst_px, kAllowedJump_px);
  EXPECT_LE(flown("real time", {.waits = false}).worst_px, kAllowedJump_px);
  // What pops does so between any two frames: the whole way with fewer of them shows it as well.
  const Flight abrupt{.morph = false, .from = 0.0, .seconds = 30.0, .framesASecond = 6.0};
  const double pops_px = flown("without morphing", abrupt).worst_px;
  if (tolerance_px >= kTolerance_px) {
    EXPECT_GT(pops_px, kAllowedJump_px);
  }
  std::filesystem::remove_all(folder);
}

INSTANTIATE_TEST_SUITE_P(Schemes, SlowFlight,
                         testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix),
                         [](const auto& scheme) { return std::string(nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion
