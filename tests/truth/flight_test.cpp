// A slow flight over real ground at 60 frames a second: no point of the ground jumps from one frame to the next. Tells
// what the update of the cut takes.
//
//   flight_tests [--from=T] [--seconds=N]    the part of the 30 seconds that is flown (default: 3 from 22 on)
//                [--tolerance=PIXELS]        that the ground is drawn within (default: 3; 1 draws more than 500 tiles);
//                                            by place alone a list, 1,3 if nothing is said
//                [--control-frames=N]        a second that the flight without morphing has, all 30 seconds of it
//                                            (default: 6)
//
// Flown five times on each tiling: every frame waiting for its data, with a memory of the last frame and without; in
// real time, with data that come late; likewise turning fast to and fro; and with morphing switched off, which has to
// fail what the others pass.
//
// Watched are 600 places all along, and wherever a tile takes the place of another, or another mesh is drawn of it,
// vertices of that mesh and places between them. No place jumps by more than half a pixel, but where the eye turns
// fast.

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
#include "truth/proof_options.h"

namespace tellurion {

const std::vector<std::string> truth::kOptionNames{"from", "seconds", "tolerance", "control-frames"};

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr double kAllowedJump_px = 0.5;
// What has to pop does so by more than that, and not once.
constexpr double kClearJump_px = 1.2 * kAllowedJump_px;
constexpr long kClearJumps = 5;
constexpr scene::Viewport kSize{.width = 1024, .height = 768};
const geo::Ellipsoid kEarth = geo::earth().ellipsoid;

/// Each tile takes a few milliseconds more, as one from a server nearby does.
class SlowSource final : public raster::TileSource {
 public:
  SlowSource(std::shared_ptr<const raster::TileSource> source, double slowness)
      : source_(std::move(source)), slowness_(slowness) {}
  const raster::TileSourceInfo& info() const override { return source_->info(); }
  io::Result<std::optional<raster::SourceTile>> load(const tiling::TileId& id) const override {
    const auto few_us = static_cast<double>(2000 + tiling::TileIdHash{}(id) % 8000);
    std::this_thread::sleep_for(std::chrono::duration<double, std::micro>(slowness_ * few_us));
    return source_->load(id);
  }

 private:
  std::shared_ptr<const raster::TileSource> source_;
  double slowness_;
};

/// From the plain into the mountains at 500 m/s, first 12 km high, turning and going down.
scene::View viewAt(double t, double turn_degrees = 0.0) {
  const scene::Camera camera{.position = {.lat = geo::Angle::degrees(27.25 + 500.0 * t / 111e3),
                                          .lon = geo::Angle::degrees(86.6),
                                          .height_m = 12000.0 - 60.0 * t},
                             .heading = geo::Angle::degrees(20.0 + 2.0 * t + turn_degrees),
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
  double from = truth::option("from", 22.0);
  double seconds = truth::option("seconds", 3.0);
  double tolerance_px = 3.0;
  double framesASecond = 60.0;
  double turn_degreesASecond = 0.0;  ///< besides that of the flight, to and fro
  double slowness = 1.0;             ///< of late tiles

  scene::View viewAt(double t) const {
    constexpr double kOneWay_degrees = 60.0;
    const double turned = std::fmod(turn_degreesASecond * (t - from), 2.0 * kOneWay_degrees);
    return tellurion::viewAt(t, kOneWay_degrees - std::abs(kOneWay_degrees - turned));
  }
};

/// How far points jumped between two frames.
struct Jumps {
  double worst_px = 0.0;
  double worstAt_s = 0.0;
  geo::Vec2 worstIn{0.0, 0.0};  ///< the picture, pixels
  long compared = 0;
  long over = 0;  ///< that are too large

  std::string told() const {
    std::array<char, 100> text{};
    std::snprintf(text.data(), text.size(), "%.3f px (%.2f s, at %.0f, %.0f), %ld of %ld over", worst_px, worstAt_s,
                  worstIn.x, worstIn.y, over, compared);
    return text.data();
  }
};

struct Log {
  std::vector<double> update_ms;
  std::vector<double> tiles;
  Jumps places;    ///< all along
  Jumps vertices;  ///< of tiles that take the place of others
  Jumps between;   ///< those
  int incomplete = 0;
};

double percentile(std::vector<double> all, double share) {
  if (all.empty()) return 0.0;
  std::sort(all.begin(), all.end());
  return all[static_cast<std::size_t>(share * static_cast<double>(all.size() - 1))];
}

/// Points of the ground and where they were drawn last: some all along, and wherever a tile takes the place of another.
class Watched {
 public:
  /// Those all along are anywhere in the picture at any time of the flight.
  Watched(const Flight& how, const tiling::Tiling& tiling) : tiling_(tiling), before_(kPlaces) {
    constexpr double kGround_m = 4000.0;
    while (places_.size() < kPlaces) {
      const scene::View view = how.viewAt(how.from + how.seconds * share());
      const double col = share() * kSize.width;
      const geo::Ray ray = scene::rayThrough(view, {col, share() * kSize.height});
      if (const auto meets = kEarth.intersect(ray, kGround_m))
        places_.push_back(kEarth.directionFromBody(ray.origin + ray.direction * *meets));
    }
  }

  void compare(const scene::Frame& frame, double t, Log& log) {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const auto now = scene::drawnPoint(frame, tiling_, places_[i]);
      count(last_.view, frame.view, before_[i], now, t, log.places);
      before_[i] = now;
    }
    if (!last_.tiles.empty()) compareChanges(frame, t, log);
    last_ = frame;
  }

 private:
  static constexpr std::size_t kPlaces = 600;
  static constexpr int kPlacesATile = 200;  ///< at vertices, and as many between

  double share() { return std::uniform_real_distribution(0.0, 1.0)(random_); }

  void compareChanges(const scene::Frame& frame, double time_s, Log& log) {
    for (const scene::DrawnTile& tile : frame.tiles) {
      const auto isSame = [&](const scene::DrawnTile& other) {
        return other.id == tile.id && other.mesh == tile.mesh && other.coarseEdges == tile.coarseEdges;
      };
      if (std::any_of(last_.tiles.begin(), last_.tiles.end(), isSame)) continue;
      const std::vector<scene::TerrainVertex>& vertices = tile.mesh->vertices;
      const auto compareAt = [&](double s, double t, Jumps& jumps) {
        const geo::Direction place = tiling_.direction(tiling::rootPointIn(tile.id, s, t));
        count(last_.view, frame.view, scene::drawnPoint(last_, tiling_, place),
              scene::drawnPoint(frame, tiling_, place), time_s, jumps);
      };
      for (int i = 0; i < kPlacesATile; ++i) {
        const scene::TerrainVertex& v =
            vertices[static_cast<std::size_t>(share() * static_cast<double>(vertices.size()))];
        const double unit = scene::kPlaceUnits;
        compareAt(v.s / unit, v.t / unit, log.vertices);
        const double s = share();
        compareAt(s, share(), log.between);
      }
    }
  }

  /// Of a place in both pictures.
  static void count(const scene::View& last, const scene::View& view, const std::optional<geo::BodyPosition>& before,
                    const std::optional<geo::BodyPosition>& now, double t, Jumps& jumps) {
    const bool wasThere = before && inPicture(last, *before);
    const auto a = now && wasThere ? inPicture(view, *before) : std::nullopt;
    const auto b = now && wasThere ? inPicture(view, *now) : std::nullopt;
    if (!a || !b) return;
    const double jump_px = geo::length(*a - *b);
    ++jumps.compared;
    jumps.over += jump_px > kAllowedJump_px ? 1 : 0;
    if (jump_px <= jumps.worst_px) return;
    jumps.worst_px = jump_px;
    jumps.worstAt_s = t;
    jumps.worstIn = {0.5 * kSize.width + b->x, 0.5 * kSize.height - b->y};
  }

  tiling::Tiling tiling_;
  std::mt19937_64 random_{20261122};
  std::vector<geo::Direction> places_;
  std::vector<std::optional<geo::BodyPosition>> before_;
  scene::Frame last_;
};

Log fly(scene::Globe& globe, const tiling::Tiling& tiling, const Flight& how) {
  Watched ground(how, tiling);
  Log log;
  // From when the roots are there, and the first frame has settled.
  const auto deadline = Clock::now() + 120s;
  for (double t = -1e6;
       !globe.update(how.viewAt(how.from), {.tolerance_px = how.tolerance_px, .morph = how.morph, .time_s = t})
            .complete;
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
    const scene::CutOptions options{.tolerance_px = how.tolerance_px,
                                    .morph = how.morph,
                                    .time_s = how.remembers ? std::optional(t) : std::nullopt};
    const scene::Frame* frame = &globe.update(how.viewAt(t), options);
    for (int i = 0; how.waits && frame->statistics.tilesWanted > 0 && i < 1000; ++i) {
      globe.waitForArrivals(1000ms);
      frame = &globe.update(how.viewAt(t), options);
    }
    log.incomplete += frame->statistics.tilesWanted > 0 ? 1 : 0;
    log.update_ms.push_back(frame->statistics.update_ms);
    log.tiles.push_back(static_cast<double>(frame->tiles.size()));
    ground.compare(*frame, t, log);
    if (!how.waits) std::this_thread::sleep_until(start + std::chrono::duration<double>(1.0 / how.framesASecond));
  }
  return log;
}

void print(const std::string& tiling, const char* what, const Log& log) {
  std::printf(
      "%-10s %-22s largest jump %s %g px; new tiles' vertices %s; between %s; %3.0f tiles, cut %.3f ms, 99%% %.3f ms; "
      "%d frames wanted more\n",
      tiling.c_str(), what, log.places.told().c_str(), kAllowedJump_px, log.vertices.told().c_str(),
      log.between.told().c_str(), percentile(log.tiles, 0.5), percentile(log.update_ms, 0.5),
      percentile(log.update_ms, 0.99), log.incomplete);
  std::fflush(stdout);
}

class SlowFlight : public testing::TestWithParam<tiling::Scheme> {
 protected:
  void SetUp() override {
    source_ = earthOn(GetParam());
    ASSERT_TRUE(source_);
  }

  Log flown(const char* what, const Flight& how) const {
    std::shared_ptr<const raster::TileSource> ground = source_;
    if (!how.waits) ground = std::make_shared<SlowSource>(source_, how.slowness);
    auto globe = scene::Globe::fromLayers({.body = geo::earth(), .tiling = GetParam()}, {.elevation = {ground}});
    EXPECT_TRUE(globe);
    if (!globe) return {};
    Log log = fly(**globe, tiling::Tiling(GetParam()), how);
    print(std::string(nameOf(GetParam())), what, log);
    EXPECT_GT(log.places.compared, how.seconds * how.framesASecond * 20);
    return log;
  }

  void expectSmooth(const char* what, const Flight& how) const {
    const Log log = flown(what, how);
    EXPECT_LE(log.places.worst_px, kAllowedJump_px);
    EXPECT_LE(log.vertices.worst_px, kAllowedJump_px);
    EXPECT_LE(log.between.worst_px, kAllowedJump_px);
  }

 private:
  std::shared_ptr<const raster::TileSource> source_;
};

TEST_P(SlowFlight, nothingPops) {
  expectSmooth("waits, remembers", {.tolerance_px = truth::option("tolerance", 3.0)});
}

TEST_P(SlowFlight, nothingPopsByPlaceAlone) {
  for (const double tolerance_px : truth::option("tolerance", std::vector{1.0, 3.0})) {
    std::array<char, 60> what{};
    std::snprintf(what.data(), what.size(), "by place alone, %g px", tolerance_px);
    expectSmooth(what.data(), {.remembers = false, .tolerance_px = tolerance_px});
  }
}

TEST_P(SlowFlight, nothingPopsInRealTime) {
  expectSmooth("real time", {.waits = false, .tolerance_px = truth::option("tolerance", 3.0)});
}

// The eye turns far faster than tiles come. What comes to lie beside finer ground then is not smooth
// (docs/selection.md); of the places that are watched all along hardly any is among it.
TEST_P(SlowFlight, hardlyAnythingPopsWhenTheEyeTurnsFast) {
  const Log log = flown(
      "turns fast",
      {.waits = false, .tolerance_px = truth::option("tolerance", 3.0), .turn_degreesASecond = 90.0, .slowness = 4.0});
  EXPECT_GT(log.incomplete, 0) << "tiles come in time";
  // Up to 3 in ten thousand were measured.
  EXPECT_LE(static_cast<double>(log.places.over), 0.002 * static_cast<double>(log.places.compared));
}

// What pops does so between any two frames, so that all of the way with few of them shows it.
TEST_P(SlowFlight, popsWithoutMorphing) {
  const Flight abrupt{.morph = false,
                      .from = 0.0,
                      .seconds = 30.0,
                      .tolerance_px = truth::option("tolerance", 3.0),
                      .framesASecond = truth::option("control-frames", 6.0)};
  const Log log = flown("without morphing", abrupt);
  EXPECT_GT(std::max(log.vertices.worst_px, log.between.worst_px), kClearJump_px);
  EXPECT_GE(log.vertices.over + log.between.over, kClearJumps);
}

INSTANTIATE_TEST_SUITE_P(Schemes, SlowFlight,
                         testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix),
                         [](const auto& scheme) { return std::string(nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion
