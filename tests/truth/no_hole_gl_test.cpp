// The ground has no holes, whatever has come of its data, however it morphs, however high it is drawn and wherever the
// eye stands: the background, a colour that occurs nowhere else, shows at no pixel whose ray is sure to meet the
// ground.
//
//   no_hole_tests [--frames=N] [--seed=S]     N frames for each tiling (default 40), the first half of them with all
//                                             data loaded, the second half while tiles arrive late and in any order;
//                                             and half of N of an eye so slow that cuts are kept, likewise, with what
//                                             the GPU has
//
// Eyes, heights and how late each tile is follow from the seed; what has come at a frame depends on the machine too.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <thread>

#include "render/context.h"
#include "render/deepest_ground_test.h"
#include "render/renderer.h"
#include "scene/drawn_ground.h"
#include "scene/globe.h"
#include "scene/picking.h"
#include "truth/embedded_earth.h"
#include "truth/proof_options.h"

namespace tellurion {

const std::vector<std::string> truth::kOptionNames{"frames", "seed"};

namespace {

using namespace std::chrono_literals;

unsigned int seed() {
  return static_cast<unsigned int>(truth::option("seed", 20261122));
}

constexpr scene::Viewport kSize{.width = 320, .height = 240};
constexpr std::array<float, 3> kMagenta{1.0f, 0.0f, 1.0f};
constexpr double kDeepestGround_m = 11000.0;
constexpr double kEyeHeight_m = 2.0;       ///< the least over the ground
constexpr int kMorphing = 5;               ///< one frame in so many must, of a long walk
constexpr unsigned int kFramesAPlace = 6;  ///< on the average
const geo::Ellipsoid kEarth = geo::earth().ellipsoid;

using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution(low, high)(random);
}

/// Tiles come when they come: each after a while of its own, so that they overtake each other. As many are on their way
/// at once as there are workers, whom each keeps for that while: a slow line.
class LateSource final : public raster::TileSource {
 public:
  LateSource(std::shared_ptr<const raster::TileSource> source, unsigned int dice)
      : source_(std::move(source)), dice_(dice) {}

  /// How late the tiles are, at most and about; any thread.
  void slowTo(std::chrono::microseconds latest) const { latest_ = latest.count(); }

  const raster::TileSourceInfo& info() const override { return source_->info(); }
  io::Result<std::optional<raster::SourceTile>> load(const tiling::TileId& id) const override {
    const int number = asked_++;
    std::seed_seq mixed{dice_, static_cast<unsigned int>(tiling::TileIdHash{}(id))};
    Random random(mixed);
    std::this_thread::sleep_for(uniform(random, 0.0, 1.0) * uniform(random, 0.0, 2.0) *
                                std::chrono::microseconds(latest_));
    auto tile = source_->load(id);
    const std::lock_guard lock(mutex_);
    overtaken_ += number < newest_ ? 1 : 0;
    newest_ = std::max(newest_, number);
    return tile;
  }

  /// Tiles that came after one that was asked for later.
  int overtaken() const {
    const std::lock_guard lock(mutex_);
    return overtaken_;
  }

 private:
  std::shared_ptr<const raster::TileSource> source_;
  unsigned int dice_;
  mutable std::atomic<std::int64_t> latest_ = 0;  // microseconds
  mutable std::atomic<int> asked_ = 0;
  mutable std::mutex mutex_;
  mutable int newest_ = -1;
  mutable int overtaken_ = 0;
};

/// Where the eye is, with what grows and shrinks on the way.
struct Eye {
  geo::Direction over;
  double above_m = 0.0;  ///< the ground
  double heading_deg = 0.0;
  double pitch_deg = 0.0;
  double roll_deg = 0.0;
  double fov_deg = 45.0;

  scene::View on(double ground_m) const {
    geo::Geodetic place = geo::geodeticFromDirection(over);
    place.height_m = ground_m + above_m;
    return scene::viewOf({.position = place,
                          .heading = geo::Angle::degrees(heading_deg),
                          .pitch = geo::Angle::degrees(pitch_deg),
                          .roll = geo::Angle::degrees(roll_deg)},
                         kEarth, geo::Angle::degrees(fov_deg), kSize);
  }
};

geo::Direction aside(const geo::Direction& d, double angle, Random& random) {
  const geo::Vec3 way(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
  return {geo::normalize(d.n + way * angle)};
}

/// Anywhere on the body, in the finest data, or where many tiles meet: corners of large tiles, the poles among them.
geo::Direction anyPlace(const tiling::Tiling& tiling, Random& random) {
  const double kind = uniform(random, 0.0, 1.0);
  if (kind < 0.3) return geo::directionFromDegrees(uniform(random, 27.0, 28.0), uniform(random, 86.0, 87.0));
  if (kind < 0.5) {
    const int root = static_cast<int>(random() % static_cast<unsigned>(tiling.rootCount()));
    const tiling::TileId id{.level = 0, .root = static_cast<std::uint8_t>(root)};
    const auto quarter = [&] { return static_cast<double>(random() % 5) / 4.0; };
    const double s = quarter();
    return aside(tiling.direction(tiling::rootPointIn(id, s, quarter())), std::pow(10.0, uniform(random, -7, -1)),
                 random);
  }
  return geo::directionFromLatLon(geo::Angle::radians(std::asin(uniform(random, -1, 1))),
                                  geo::Angle::degrees(uniform(random, -180, 180)));
}

Eye anywhere(const tiling::Tiling& tiling, Random& random) {
  const double highest_m = 4.0 * kEarth.semiMajorAxis_m();
  const double above_m = kEyeHeight_m * std::pow(highest_m / kEyeHeight_m, uniform(random, 0.0, 1.0));
  // From far away the ground is small and below, from near it is all around.
  const double highestPitch_deg = above_m > 1e6 ? -50.0 : 10.0;
  return {.over = anyPlace(tiling, random),
          .above_m = above_m,
          .heading_deg = uniform(random, 0, 360),
          .pitch_deg = uniform(random, -90, highestPitch_deg),
          .roll_deg = uniform(random, -30, 30),
          .fov_deg = uniform(random, 20, 100)};
}

/// Steps of this length are about as long as an eye's in flight at a few frames a second.
void moveALittle(Eye& eye, Random& random, double length) {
  eye.over = aside(eye.over, 0.1 * length * std::min(eye.above_m / kEarth.semiMajorAxis_m(), 1.0), random);
  eye.above_m = std::clamp(eye.above_m * std::exp(length * uniform(random, -0.2, 0.15)), kEyeHeight_m,
                           4.0 * kEarth.semiMajorAxis_m());
  eye.heading_deg += length * uniform(random, -5, 5);
  eye.pitch_deg = std::clamp(eye.pitch_deg + length * uniform(random, -3, 3), -90.0, 30.0);
}

struct Tally {
  int frames = 0;
  int incomplete = 0;   ///< something was on its way
  int capped = 0;       ///< the cut had tiles enough before it was fine enough
  int morphing = 0;     ///< some tile was between its parent's surface and its own
  int exaggerated = 0;  ///< heights were drawn more than 5 times as high
  int overtaken = 0;    ///< tiles that came after one that was asked for later
  int kept = 0;         ///< the cut was that of an earlier frame
  long needles = 0;     ///< pixels of ground without depth: triangles seen edge on
  long pixels = 0;      ///< whose rays are sure to meet the ground
  long deepPixels = 0;  ///< those that meet it however deep it were
  long holes = 0;       ///< those of the first that show the background
};

/// A picture's pixels whose rays are sure to meet the ground.
struct Seen {
  long pixels = 0;
  long deepPixels = 0;  ///< those that meet it however deep it were
  long holes = 0;       ///< those of the first that show the background
  long needles = 0;     ///< those that show ground, but have no depth
  // The first hole.
  int col = 0;
  int row = 0;
  bool isDeep = false;
  geo::BodyPosition ground;
};

Seen seenIn(const scene::Frame& frame, const render::RenderTarget& target) {
  const double height_m = std::max(scene::cameraOf(frame.view, kEarth).position.height_m, 0.0);
  const double horizon_m = std::sqrt(height_m * (height_m + 2.0 * kEarth.semiMajorAxis_m()));
  // Corners of triangles are drawn on a lattice of a 256th of a pixel.
  const double depth_m = render::deepestGround_m(frame, kEarth) + 0.02 * horizon_m * frame.view.pixelAngle();
  const double deep_m = std::max(depth_m, kDeepestGround_m * frame.exaggeration);
  const auto picture = render::readColour(target);
  const auto distances = render::readDistance(target, frame.view);
  Seen seen;
  for (int row = 0; row < kSize.height; ++row) {
    for (int col = 0; col < kSize.width; ++col) {
      const geo::Ray ray = scene::rayThrough(frame.view, {col + 0.5, row + 0.5});
      const auto meets = kEarth.intersect(ray, -depth_m);
      if (!meets) continue;
      ++seen.pixels;
      const bool isDeep = kEarth.intersect(ray, -deep_m).has_value();
      seen.deepPixels += isDeep ? 1 : 0;
      const raster::Rgba8 pixel = picture.at(col, row);
      const bool isSky = pixel.r == 255 && pixel.g == 0 && pixel.b == 255;
      EXPECT_TRUE(!isSky || std::isnan(distances.at(col, row))) << "a background with depth at " << col << ", " << row;
      seen.needles += !isSky && std::isnan(distances.at(col, row)) ? 1 : 0;
      if (!isSky || seen.holes++ > 0) continue;
      seen.col = col;
      seen.row = row;
      seen.isDeep = isDeep;
      seen.ground = {ray.origin.m + ray.direction * *meets};
    }
  }
  return seen;
}

class NoHole : public testing::TestWithParam<tiling::Scheme> {
 protected:
  static void SetUpTestSuite() {
    auto made = render::HeadlessContext::create();
    if (made) context() = std::make_unique<render::HeadlessContext>(std::move(*made));
  }
  static void TearDownTestSuite() { context().reset(); }
  static std::unique_ptr<render::HeadlessContext>& context() {
    static std::unique_ptr<render::HeadlessContext> it;
    return it;
  }

  void SetUp() override {
    if (!context()) GTEST_SKIP() << "no OpenGL context here";
    auto renderer = render::Renderer::create();
    auto target = render::RenderTarget::create(kSize);
    ASSERT_TRUE(renderer && target);
    renderer_.emplace(std::move(*renderer));
    target_.emplace(std::move(*target));
    source_ = earthOn(GetParam());
    ASSERT_TRUE(source_);
  }

  std::optional<render::Renderer> renderer_;
  std::optional<render::RenderTarget> target_;
  std::shared_ptr<const raster::TileSource> source_;
};

std::string nameOfTile(const tiling::TileId& id) {
  return std::to_string(id.level) + "/" + std::to_string(id.root) + "/" + std::to_string(id.x) + "/" +
         std::to_string(id.y);
}

/// How the eye goes from place to place, and whether tiles are there.
enum class Gait {
  whole,  ///< all are, in every frame
  late,   ///< they come when they come
  slow,   ///< likewise, in steps so small that cuts are kept, by the clock and with what is on the GPU
};

const char* nameOf(Gait gait) {
  return gait == Gait::whole ? "whole" : gait == Gait::late ? "late" : "slow";
}

/// A walk over the body from place to place, frame by frame, and what was seen on it.
class Walk {
 public:
  Walk(tiling::Scheme scheme, std::shared_ptr<const raster::TileSource> source, Gait gait, unsigned int dice)
      : random_(dice), tiling_(scheme), gait_(gait) {
    if (gait != Gait::whole) source = late_ = std::make_shared<LateSource>(std::move(source), dice);
    auto globe = scene::Globe::fromLayers({.body = geo::earth(), .tiling = scheme}, {.elevation = {std::move(source)}},
                                          {.workers = 3, .cpuCacheBytes = std::uint64_t{96} << 20});
    EXPECT_TRUE(globe) << (globe ? "" : describe(globe.error()));
    if (!globe) return;
    globe_ = std::move(*globe);
    globe_->background() = kMagenta;
  }

  /// Until all roots are there: no earlier is there any ground.
  bool begin() {
    return globe_ && wholeFrame(Eye{.over = {{1, 0, 0}}, .above_m = 2e7, .pitch_deg = -90.0}.on(0.0),
                                {.tolerance_px = 1e9, .morph = false})
                         .complete;
  }

  /// Of a picture from above that lacks the tile in its middle.
  Seen lookWithoutATile(render::Renderer& renderer, const render::RenderTarget& target) {
    const Eye eye{.over = anyPlace(tiling_, random_), .above_m = 1e6, .pitch_deg = -90.0};
    scene::Frame frame = wholeFrame(eye.on(0.0), {});
    const tiling::RootPoint p = tiling_.rootPoint(eye.over);
    std::erase_if(frame.tiles, [&](const scene::DrawnTile& tile) {
      const double size = tiling::tileSize(tile.id.level);
      return tile.id.root == p.root && std::abs(p.u / size - tile.id.x - 0.5) <= 0.5 &&
             std::abs(p.v / size - tile.id.y - 0.5) <= 0.5;
    });
    renderer.draw(frame, target);
    return seenIn(frame, target);
  }

  Tally look(int frames, render::Renderer& renderer, const render::RenderTarget& target) {
    if (gait_ == Gait::slow) residency_ = &renderer.residency();
    for (int i = 0; i < frames; ++i) {
      const unsigned int aPlace = gait_ == Gait::slow ? 8 * kFramesAPlace : kFramesAPlace;
      i == 0 || random_() % aPlace == 0 ? jump() : step();
      const scene::Frame* frame = frameAboveGround();
      if (frame == nullptr) {
        ADD_FAILURE() << "frame " << i << ": the eye cannot be kept above the ground";
        return tally_;
      }
      renderer.draw(*frame, target);
      count(*frame, target, i);
    }
    tally_.overtaken = late_ ? late_->overtaken() : 0;
    return tally_;
  }

 private:
  void jump() {
    eye_ = anywhere(tiling_, random_);
    const std::array exaggerations{1.0, 1.0, 1.0, 3.0, 0.0, 100.0, std::exp(uniform(random_, 0.0, std::log(100.0)))};
    globe_->exaggeration() = exaggerations[random_() % exaggerations.size()];
    tolerance_px_ = std::exp2(uniform(random_, 0.0, 3.0));
    hasClock_ = random_() % 5 != 0 || gait_ == Gait::slow;
    if (late_ && jumps_++ % 3 != 1) comeNearly();
    time_s_ += random_() % 2 == 0 ? 1.0 / 60.0 : 1.0;
  }

  /// Else tiles would come too slowly for the ground to be anywhere near as fine as it morphs: most are there before.
  void comeNearly() {
    late_->slowTo(0ms);
    wholeFrame(eye_.on(globe_->groundHeight_m(eye_.over).value_or(0.0)), {.tolerance_px = 1.5 * tolerance_px_});
    late_->slowTo(60ms);
  }

  /// A tile parts only when all four of its children have come, and what touches it: without some of them between two
  /// frames a slow machine sees nothing on its way.
  void takeSome() {
    constexpr int kArrivals = 10;
    for (int i = 0; i < kArrivals && lastView_; ++i) {
      if (globe_->update(*lastView_, options(), residency_).statistics.tilesWanted == 0) return;
      globe_->waitForArrivals(100ms);
    }
  }

  void step() {
    moveALittle(eye_, random_, gait_ == Gait::slow ? 0.002 : 1.0);
    time_s_ += 1.0 / 60.0;
    if (random_() % 30 == 0) globe_->exaggeration() = uniform(random_, 0.0, 5.0);
    if (!late_) return;
    if (gait_ == Gait::slow) {  // to take some at the new time and the old view would be to rest
      globe_->waitForArrivals(50ms);
      return;
    }
    takeSome();
    std::this_thread::sleep_for(std::chrono::milliseconds(random_() % 30));
  }

  scene::CutOptions options() const {
    scene::CutOptions options{.tolerance_px = tolerance_px_};
    if (residency_ != nullptr) options.copies_bytes = std::uint64_t{1} << 20;
    if (hasClock_) options.time_s = time_s_;
    return options;
  }

  const scene::Frame& wholeFrame(const scene::View& view, const scene::CutOptions& options) {
    const auto deadline = std::chrono::steady_clock::now() + 240s;
    while (globe_->update(view, options).statistics.tilesWanted > 0 && std::chrono::steady_clock::now() < deadline)
      globe_->waitForArrivals(100ms);
    const scene::Frame& frame = globe_->update(view, options);
    EXPECT_EQ(frame.statistics.tilesWanted, 0);
    return frame;
  }

  const scene::Frame& frameFor(const scene::View& view) {
    lastView_ = view;
    return late_ ? globe_->update(view, options(), residency_) : wholeFrame(view, options());
  }

  /// What is known below the eye may be finer than what is drawn there, and another with each tile that comes, so the
  /// eye is raised until it is above both, each time by more.
  const scene::Frame* frameAboveGround() {
    double ground_m = globe_->groundHeight_m(eye_.over).value_or(0.0);
    double more_m = 0.0;
    for (int i = 0; i < 30; ++i) {
      const scene::Frame& frame = frameFor(eye_.on(ground_m));
      const double known_m = globe_->groundHeight_m(eye_.over).value_or(ground_m);
      const double drawn_m = scene::drawnHeight_m(frame, tiling_, kEarth, eye_.over).value_or(known_m);
      if (ground_m >= std::max(known_m, drawn_m) - 0.5 * kEyeHeight_m) return &frame;
      ground_m = std::max(known_m, drawn_m) + more_m;
      more_m = i < 4 ? 0.0 : 2.0 * more_m + 1.0;
    }
    return nullptr;
  }

  void count(const scene::Frame& frame, const render::RenderTarget& target, int number) {
    ++tally_.frames;
    tally_.incomplete += frame.statistics.tilesWanted > 0 ? 1 : 0;
    tally_.capped += frame.statistics.cappedByBudget ? 1 : 0;
    tally_.morphing += isMorphing(frame) ? 1 : 0;
    tally_.exaggerated += frame.exaggeration > 5.0 ? 1 : 0;
    tally_.kept += frame.statistics.cutAge > 0 ? 1 : 0;
    const Seen seen = seenIn(frame, target);
    tally_.pixels += seen.pixels;
    tally_.deepPixels += seen.deepPixels;
    tally_.holes += seen.holes;
    tally_.needles += seen.needles;
    EXPECT_EQ(seen.holes, 0) << "frame " << number << " of seed " << seed() << ", " << nameOf(gait_)
                             << described(frame, seen);
  }

  static bool isMorphing(const scene::Frame& frame) {
    return std::any_of(frame.tiles.begin(), frame.tiles.end(), [](const scene::DrawnTile& tile) {
      return std::any_of(tile.morph.begin(), tile.morph.end(), [](float m) { return m > 0.0f && m < 1.0f; });
    });
  }

  /// Where a hole is, and the tiles there.
  std::string described(const scene::Frame& frame, const Seen& seen) const {
    if (seen.holes == 0) return "";
    const scene::Camera camera = scene::cameraOf(frame.view, kEarth);
    std::string out =
        "\n  first at pixel " + std::to_string(seen.col) + ", " + std::to_string(seen.row) +
        (seen.isDeep ? "" : ", near the outline") + "; eye " + std::to_string(camera.position.lat.degrees()) + ", " +
        std::to_string(camera.position.lon.degrees()) + ", " + std::to_string(camera.position.height_m) +
        " m; heading " + std::to_string(camera.heading.degrees()) + ", pitch " +
        std::to_string(camera.pitch.degrees()) + ", roll " + std::to_string(camera.roll.degrees()) + ", fov " +
        std::to_string(frame.view.verticalFov.degrees()) + "; exaggeration " + std::to_string(frame.exaggeration) +
        ", tolerance " + std::to_string(tolerance_px_) + (hasClock_ ? ", with a clock" : "") +
        (frame.statistics.tilesWanted > 0 ? ", incomplete" : "") + (frame.statistics.cappedByBudget ? ", capped" : "") +
        ", " + std::to_string(frame.tiles.size()) + " tiles; ground height known below the eye " +
        std::to_string(globe_->groundHeight_m(eye_.over).value_or(0.0)) + " m, drawn " +
        std::to_string(scene::drawnHeight_m(frame, tiling_, kEarth, eye_.over).value_or(std::nan(""))) + " m";
    const geo::Direction d = kEarth.directionFromBody(seen.ground);
    const tiling::RootPoint p = tiling_.rootPoint(d);
    out += "; the ray comes down " + std::to_string(geo::length(seen.ground - frame.view.eye)) + " m away, at " +
           std::to_string(p.root) + ": " + std::to_string(p.u) + ", " + std::to_string(p.v);
    for (const scene::DrawnTile& tile : frame.tiles) {
      const double size = tiling::tileSize(tile.id.level);
      const double s = p.u / size - tile.id.x, t = p.v / size - tile.id.y;
      if (tile.id.root != p.root || std::min(s, t) < -0.1 || std::max(s, t) > 1.1) continue;
      out += "\n  tile " + nameOfTile(tile.id) + " (there " + std::to_string(s) + ", " + std::to_string(t) +
             "), coarse edges " + std::to_string(tile.coarseEdges) + ", morph";
      for (const float m : tile.morph)
        out += " " + std::to_string(m);
    }
    return out;
  }

  std::shared_ptr<const LateSource> late_;  ///< null: all data are there in every frame
  Random random_;
  tiling::Tiling tiling_;
  Gait gait_;
  const scene::Residency* residency_ = nullptr;  ///< of a slow walk
  std::unique_ptr<scene::Globe> globe_;
  Eye eye_;
  std::optional<scene::View> lastView_;
  double tolerance_px_ = 1.0;
  bool hasClock_ = true;
  double time_s_ = 0.0;
  int jumps_ = 0;
  Tally tally_;
};

TEST_P(NoHole, InAnyFrame) {
  const int all = truth::option("frames", 40);
  for (const Gait gait : {Gait::whole, Gait::late, Gait::slow}) {
    const auto dice = 8 * seed() + 2 * static_cast<unsigned int>(GetParam());
    Walk walk(GetParam(), source_, gait, gait == Gait::slow ? dice + 6 : dice + (gait == Gait::late ? 1 : 0));
    ASSERT_TRUE(walk.begin());
    const int frames = all / 2;
    const Tally tally = walk.look(frames, *renderer_, *target_);
    std::printf(
        "%-10s %-5s seed %u: %4d frames, %4d incomplete, %d capped, %4d morphing, %d exaggerated, %d tiles overtaken, "
        "%d of kept cuts; %ld pixels, %ld of them %g m deep, %ld needles; %ld holes\n",
        std::string(nameOf(GetParam())).c_str(), nameOf(gait), seed(), tally.frames, tally.incomplete, tally.capped,
        tally.morphing, tally.exaggerated, tally.overtaken, tally.kept, tally.pixels, tally.deepPixels,
        kDeepestGround_m, tally.needles, tally.holes);
    std::fflush(stdout);
    EXPECT_EQ(tally.frames, frames);
    EXPECT_GT(tally.pixels, 10000L * frames);
    EXPECT_LE(tally.needles, tally.pixels / 100000) << "ground without depth";
    // What has come at a frame is the machine's: of a short walk hardly more can be asked than that there was some.
    const bool isShort = all < 200;
    const int enough = gait == Gait::late ? (isShort ? 1 : frames / 3) : (isShort ? 0 : frames / 20);
    if (gait == Gait::whole) {
      EXPECT_EQ(tally.incomplete, 0);
    } else {
      EXPECT_GE(tally.incomplete, enough) << "tiles hardly come late";
      EXPECT_GE(tally.overtaken, gait == Gait::slow && isShort ? 0 : 1)
          << "tiles come in the order in which they were asked for";
    }
    if (gait == Gait::slow) {
      EXPECT_GE(tally.kept, isShort ? 0 : frames / 10) << "cuts are hardly kept";
    } else {
      EXPECT_GT(tally.morphing, isShort ? 0 : frames / kMorphing) << "the ground hardly morphs";
    }
  }
}

// The measure can fail.
TEST_P(NoHole, IsToldWhereATileIsLeftOut) {
  Walk walk(GetParam(), source_, Gait::whole, seed());
  ASSERT_TRUE(walk.begin());
  for (int i = 0; i < 3; ++i) {
    const Seen seen = walk.lookWithoutATile(*renderer_, *target_);
    EXPECT_GT(seen.holes, 10);
    EXPECT_LT(seen.holes, seen.pixels);
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, NoHole,
                         testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix),
                         [](const auto& scheme) { return std::string(nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion
