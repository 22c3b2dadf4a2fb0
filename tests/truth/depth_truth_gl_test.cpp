// Depth as the program draws it against rays, for random cameras from 2 m above the ground to 4 radii: rays through the
// surface of the finest level of the tile database, at every pixel, and rays through the source rasters where a pixel
// covers a sample of them or more. And of a database as it is built by default, whose coarser ground has moved to meet
// the finer (docs/tile-database.md), around the border and the voids of such data: rays through its own finest surface.
//
//   depth_truth_tests [--cameras=N] [--seed=S] [--tolerance=T[,T...]] [--collection=FOLDER] [--place=NAME] [--camera=K]
//                     [--height=PIXELS]
//
// N cameras for each tiling and place, a picture at each tolerance (pixels), 96 pixels high unless said otherwise.
// FOLDER is the developers' collection of data, which a checkout does not bring: it adds two places with samples a
// metre apart. NAME and K: this place, this camera alone.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>
#include <string>

#include "pyramid/pyramid_builder.h"
#include "pyramid/pyramid_reader.h"
#include "render/context.h"
#include "render/renderer.h"
#include "scene/globe.h"
#include "truth/drawn_triangles.h"
#include "truth/finest_surface_check.h"
#include "truth/proof_options.h"
#include "truth/random_cameras.h"
#include "truth/ray_caster.h"
#include "truth/seen_surface.h"

namespace tellurion {

const std::vector<std::string> truth::kOptionNames{"cameras", "seed",   "tolerance", "collection",
                                                   "place",   "camera", "height"};

namespace {

using namespace std::chrono_literals;

constexpr double kShareWithin = 0.999;        ///< of all pixels, within the tolerance
constexpr double kShareOfCamera = 0.99;       ///< likewise of the worst camera's
constexpr long kPixelsForNeedle = 1'000'000;  ///< one of so many may be a needle's, and one more
constexpr long kPixelsForShare = 500;         ///< a camera that has fewer has no share of its own
/// No budget is in the way of the proof: what it would leave undone would have to be left out of it.
constexpr int kMaxTiles = 1'000'000;

unsigned int seed() {
  return static_cast<unsigned int>(truth::option("seed", 20261122));
}

scene::Viewport size() {
  const int height = truth::option("height", 96);
  return {.width = height * 4 / 3, .height = height};
}

/// The most that any pixel may be off from the rasters: 3 pixels, or the tolerance where that is more.
double mostOffSource_px(double tolerance_px) {
  return std::max(3.0, tolerance_px);
}

/// Likewise from the finest ground, three times the tolerance where that is less. (What the rasters differ from the
/// finest ground does not get less with the tolerance.)
double mostOffFinest_px(double tolerance_px) {
  return std::min(3.0 * tolerance_px, mostOffSource_px(tolerance_px));
}

/// The frame that the view needs, with nothing on its way.
const scene::Frame& wholeFrame(scene::Globe& globe, const scene::View& view, double tolerance_px) {
  const scene::CutOptions options{.tolerance_px = tolerance_px, .maxTiles = kMaxTiles};
  const auto deadline = std::chrono::steady_clock::now() + 300s;
  while (globe.update(view, options).statistics.tilesWanted > 0 && std::chrono::steady_clock::now() < deadline)
    globe.waitForArrivals(500ms);
  return globe.update(view, options);
}

/// All pictures of one place at one tolerance.
struct Result {
  explicit Result(double tolerance_px) : finest(tolerance_px), source(tolerance_px) {}

  int cameras = 0;
  truth::Tally finest;
  truth::Tally source;
  long needles = 0;  ///< pixels of which the rasteriser made something else than what the frame draws there
  double worstShare = 1.0;
  double maxScreenError_px = 0;
  std::size_t mostTiles = 0;
};

class DepthTruth : public testing::TestWithParam<tiling::Scheme> {
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
    auto target = render::RenderTarget::create(size());
    ASSERT_TRUE(renderer && target);
    renderer_.emplace(std::move(*renderer));
    target_.emplace(std::move(*target));
    folder_ = std::filesystem::path(testing::TempDir()) / ("depth_truth_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override {
    if (!folder_.empty()) std::filesystem::remove_all(folder_);
  }

  std::shared_ptr<const raster::TileSource> databaseOf(const truth::Planet& planet,
                                                       std::optional<double> fillVoids_m) const {
    const pyramid::BuildOptions build{.output = folder_ / (planet.body.name + ".tdb"),
                                      .inputs = planet.rasters,
                                      .scheme = GetParam(),
                                      .body = planet.body,
                                      .fillVoids_m = fillVoids_m};
    const auto built = pyramid::buildPyramid(build);
    EXPECT_TRUE(built) << (built ? "" : describe(built.error()));
    const auto source = pyramid::PyramidReader::open(build.output);
    EXPECT_TRUE(source) << (source ? "" : describe(source.error()));
    return source ? *source : nullptr;
  }

  raster::Raster<float> drawn(const scene::Frame& frame) {
    renderer_->draw(frame, *target_);
    return render::readDistance(*target_, frame.view);
  }

  std::optional<render::Renderer> renderer_;
  std::optional<render::RenderTarget> target_;
  std::filesystem::path folder_;
};

/// A planet opened: what is drawn, and both truths.
struct World {
  /// moved: the rasters are no truth of the ground between and around them.
  World(const truth::Planet& planet, const std::shared_ptr<const raster::TileSource>& database, bool moved)
      : finest(*database), rasters(planet.rasters, planet.body.ellipsoid), hasMoved(moved) {
    auto opened =
        scene::Globe::fromLayers({.body = planet.body, .tiling = database->info().scheme}, {.elevation = {database}});
    EXPECT_TRUE(opened);
    if (opened) globe = std::move(*opened);
  }
  /// The higher of both truths: who is above it is under neither.
  double height_m(const geo::Direction& d) const {
    if (hasMoved) return finest.height_m(d);
    const geo::Geodetic place = geo::geodeticFromDirection(d);
    return std::max(finest.height_m(d), rasters.height_m(place.lat.degrees(), place.lon.degrees()));
  }

  truth::FinestSurface finest;
  truth::SourceSurface rasters;
  bool hasMoved;
  std::unique_ptr<scene::Globe> globe;
};

/// Both truths from one eye. Stays where it is.
class Truths {
 public:
  Truths(const World& world, const scene::View& view)
      : world_(world),
        view_(view),
        finest_([this](const geo::Ray& ray) { return truth::exactly(world_.finest.distanceAlong(ray)); }, view),
        source_([this](const geo::Ray& ray) { return seenAlong(world_.rasters, ray, view_.pixelAngle()); }, view) {}

  truth::Tally onFinest(const raster::Raster<float>& drawn, double tolerance_px, int camera) {
    return finest_.compare(drawn, tolerance_px, camera, [](int, int, double) { return true; });
  }
  /// Where a pixel covers a sample of the source or more.
  truth::Tally onSource(const raster::Raster<float>& drawn, double tolerance_px, int camera) {
    return source_.compare(drawn, tolerance_px, camera, [&](int col, int row, double drawn_m) {
      const geo::Ray ray = scene::rayThrough(view_, {col + 0.5, row + 0.5});
      const double d = std::isnan(drawn_m) ? finest_.centre(col, row).nearest_m : drawn_m;
      if (std::isnan(d)) return false;
      const truth::SourceSurface& rasters = world_.rasters;
      const geo::Geodetic place = rasters.ellipsoid().geodeticFromBody({ray.origin.m + ray.direction * d});
      return d * view_.pixelAngle() >= rasters.spacing_m(place.lat.degrees(), place.lon.degrees());
    });
  }

 private:
  const World& world_;
  scene::View view_;
  truth::SeenSurface finest_;
  truth::SeenSurface source_;
};

void expectGood(const truth::Tally& tally, double most_px, Result& result, const std::string& what) {
  EXPECT_LE(tally.worst_px, most_px) << what << ", pixel " << tally.col << ", " << tally.row;
  if (tally.pixels < kPixelsForShare) return;
  EXPECT_GE(tally.share(), kShareOfCamera) << what;
  result.worstShare = std::min(result.worstShare, tally.share());
}

/// A rasteriser has few bits: of a triangle that is seen along itself and is thinner than its lattice it may tell a
/// depth far in front of it (docs/rendering.md, "Depth"). Puts in a pixel's place what the frame's triangles are there
/// in double precision, if they are all further away than the pixel is, also a hundredth of a pixel beside its centre.
bool putTrianglesForNeedle(raster::Raster<float>& picture, const scene::Frame& frame, int col, int row) {
  const auto along = [&](double dx, double dy) {
    return truth::drawnAlong(frame, scene::rayThrough(frame.view, {col + 0.5 + dx, row + 0.5 + dy}));
  };
  constexpr double kBeside_px = 0.01;
  constexpr double kNearer = 1e-3;
  double nearest_m = along(0.0, 0.0);
  const double here_m = nearest_m;
  for (const double dx : {-kBeside_px, kBeside_px})
    for (const double dy : {-kBeside_px, kBeside_px})
      nearest_m = std::min(nearest_m, along(dx, dy));
  if (!std::isfinite(here_m) || !(static_cast<double>(picture.at(col, row)) < (1.0 - kNearer) * nearest_m))
    return false;
  picture.at(col, row) = static_cast<float>(here_m);
  return true;
}

/// One camera at one tolerance; `drawn` makes the picture of a frame.
template <class Drawn>
void look(World& world, const scene::View& view, Truths& truths, int camera, double tolerance_px, const Drawn& drawn,
          Result& result, const std::string& what) {
  const scene::Frame& frame = wholeFrame(*world.globe, view, tolerance_px);
  ASSERT_FALSE(frame.statistics.cappedByBudget) << what;
  ASSERT_TRUE(frame.complete) << what;
  EXPECT_LE(frame.statistics.maxScreenError_px, tolerance_px * (1.0 + 1e-6)) << what;
  raster::Raster<float> picture = drawn(frame);
  truth::Tally onFinest = truths.onFinest(picture, tolerance_px, camera);
  while (onFinest.worst_px > mostOffFinest_px(tolerance_px) &&
         putTrianglesForNeedle(picture, frame, onFinest.col, onFinest.row)) {
    ++result.needles;
    onFinest = truths.onFinest(picture, tolerance_px, camera);
  }
  const truth::Tally onSource =
      world.hasMoved ? truth::Tally(tolerance_px) : truths.onSource(picture, tolerance_px, camera);
  expectGood(onFinest, mostOffFinest_px(tolerance_px), result, what + ", against the finest ground");
  expectGood(onSource, mostOffSource_px(tolerance_px), result, what + ", against the source");
  ++result.cameras;
  result.maxScreenError_px = std::max(result.maxScreenError_px, frame.statistics.maxScreenError_px);
  result.mostTiles = std::max(result.mostTiles, frame.tiles.size());
  result.finest.add(onFinest);
  result.source.add(onSource);
}

void tell(const truth::Place& place, tiling::Scheme scheme, double tolerance_px, const Result& r) {
  std::printf(
      "%-8s %-10s tolerance %g px: %d cameras; max_screen_error_px %.6f; worst camera %.3f%%; up to %zu tiles\n",
      place.name.c_str(), std::string(nameOf(scheme)).c_str(), tolerance_px, r.cameras, r.maxScreenError_px,
      100.0 * r.worstShare, r.mostTiles);
  std::printf("  finest ground:  %s\n", r.finest.told().c_str());
  if (r.needles > 0) std::printf("  pixels that are the rasteriser's, not the surface's: %ld\n", r.needles);
  if (r.source.pixels > 0) std::printf("  source rasters: %s\n", r.source.told().c_str());
  std::fflush(stdout);
}

/// As the command line has it.
struct Asked {
  std::vector<double> tolerances = truth::option("tolerance", std::vector{1.0, 0.5, 4.0});
  int cameras = truth::option("cameras", 3);  ///< a place
  int onlyCamera = truth::option("camera", -1);
  std::string onlyPlace = truth::option("place", std::string());
};

/// All cameras of a place; `drawn` makes the picture of a frame.
template <class Drawn>
void lookAround(World& world, truth::RandomCameras& cameras, const truth::Place& place, tiling::Scheme scheme,
                const Drawn& drawn) {
  const Asked asked;
  const auto height = [&](const geo::Direction& d) { return world.height_m(d); };
  std::vector<Result> results(asked.tolerances.begin(), asked.tolerances.end());
  for (int number = 0; number < asked.cameras; ++number) {
    const scene::View view = number % 3 == 0 ? cameras.wherePixelsCoverSamples(height) : cameras.anywhere(height);
    if (asked.onlyCamera >= 0 && number != asked.onlyCamera) continue;
    Truths truths(world, view);
    for (std::size_t i = 0; i < asked.tolerances.size(); ++i) {
      std::ostringstream what;
      what << place.name << " camera " << number << " of seed " << seed() << ", tolerance " << asked.tolerances[i]
           << ", " << truth::described(view, world.finest.ellipsoid());
      look(world, view, truths, number, asked.tolerances[i], drawn, results[i], what.str());
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  for (std::size_t i = 0; i < asked.tolerances.size(); ++i) {
    tell(place, scheme, asked.tolerances[i], results[i]);
    EXPECT_GE(results[i].finest.share(), kShareWithin) << place.name << ", tolerance " << asked.tolerances[i];
    EXPECT_LE(results[i].needles, 1 + results[i].finest.pixels / kPixelsForNeedle) << place.name;
    if (world.hasMoved) continue;
    // One camera alone may be so near that no pixel covers a sample.
    if (asked.onlyCamera >= 0 && results[i].source.pixels == 0) continue;
    EXPECT_GE(results[i].source.share(), kShareWithin) << place.name << ", tolerance " << asked.tolerances[i];
  }
}

TEST_P(DepthTruth, IsWithinTheTolerance) {
  const Asked asked;
  for (const truth::Planet& planet : truth::planets(truth::option("collection", std::string()))) {
    const auto database = databaseOf(planet, 0.0);  // the rasters are the truth, coarse ones beside fine too
    ASSERT_TRUE(database);
    World world(planet, database, false);
    ASSERT_TRUE(world.globe);
    for (const truth::Place& place : planet.places) {
      if (!asked.onlyPlace.empty() && place.name != asked.onlyPlace) continue;
      SCOPED_TRACE(place.name);
      truth::RandomCameras cameras(planet.body.ellipsoid, place, GetParam(), seed(), size());
      expectSound(world.finest, database, cameras);
      lookAround(world, cameras, place, GetParam(), [&](const scene::Frame& frame) { return drawn(frame); });
      if (HasFatalFailure()) return;
    }
  }
}

TEST_P(DepthTruth, OfADefaultBuildIsWithinTheTolerance) {
  const truth::Planet planet = truth::planetWithVoids(truth::option("collection", std::string()));
  const truth::Place& place = planet.places.front();
  if (const Asked asked; !asked.onlyPlace.empty() && place.name != asked.onlyPlace) GTEST_SKIP();
  const auto database = databaseOf(planet, {});
  ASSERT_TRUE(database);
  World world(planet, database, true);
  ASSERT_TRUE(world.globe);
  // Some of the ground that is looked at has moved: the finest surface is not that of the rasters.
  truth::RandomCameras places(planet.body.ellipsoid, place, GetParam(), seed(), size());
  int moved = 0;
  for (int i = 0; i < 100; ++i) {
    const geo::Geodetic at =
        scene::cameraOf(places.anywhere([](const geo::Direction&) { return 0.0; }), planet.body.ellipsoid).position;
    const double off_m = world.finest.height_m(geo::directionFromLatLon(at.lat, at.lon)) -
                         world.rasters.height_m(at.lat.degrees(), at.lon.degrees());
    moved += std::abs(off_m) > 20.0 ? 1 : 0;
  }
  EXPECT_GE(moved, 5);
  EXPECT_LE(moved, 95);
  truth::RandomCameras cameras(planet.body.ellipsoid, place, GetParam(), seed(), size());
  expectSound(world.finest, database, cameras);
  lookAround(world, cameras, place, GetParam(), [&](const scene::Frame& frame) { return drawn(frame); });
}

// The measure can fail: near the mountains the bare ellipsoid does not pass it.
TEST_P(DepthTruth, TellsTheGroundFromTheEllipsoid) {
  const truth::Planet planet = truth::planets({}).front();
  const truth::SourceSurface rasters(planet.rasters, planet.body.ellipsoid);
  const auto bare = scene::Globe::fromLayers({.body = planet.body, .tiling = GetParam()}, {});
  ASSERT_TRUE(bare);
  const auto flat = [](const geo::Direction&) { return 0.0; };
  truth::RandomCameras cameras(planet.body.ellipsoid, planet.places[1], GetParam(), seed(), size());
  const scene::View view = cameras.wherePixelsCoverSamples(flat);
  truth::SeenSurface source([&](const geo::Ray& ray) { return truth::seenAlong(rasters, ray, view.pixelAngle()); },
                            view);
  const auto some = [](int col, int row, double) { return col % 4 == 0 && row % 4 == 0; };
  const truth::Tally tally = source.compare(drawn(wholeFrame(**bare, view, 1.0)), 1.0, 0, some);
  EXPECT_GT(tally.pixels, 50);
  EXPECT_LT(tally.share(), 0.9);
}

INSTANTIATE_TEST_SUITE_P(Schemes, DepthTruth,
                         testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix),
                         [](const auto& scheme) { return std::string(nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion
