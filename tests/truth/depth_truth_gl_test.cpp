// Depth as the program draws it against rays, for random cameras from 2 m above the ground to 4 radii: rays through the
// surface of the finest level of the tile database, at every pixel, and rays through the source rasters where a pixel
// covers a sample of them or more.
//
//   depth_truth_tests [--cameras=N] [--seed=S] [--tolerance=T[,T...]] [--collection=FOLDER] [--place=NAME] [--camera=K]
//
// N cameras for each tiling and place, a picture at each tolerance (pixels). FOLDER is the developers' collection of
// data, which a checkout does not bring: it adds two places with samples a metre apart. NAME and K: this place,
// this camera alone.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <random>
#include <sstream>
#include <string>
#include <thread>

#include "pyramid/height_query.h"
#include "pyramid/pyramid_builder.h"
#include "pyramid/pyramid_reader.h"
#include "render/context.h"
#include "render/renderer.h"
#include "scene/globe.h"
#include "truth/finest_surface.h"
#include "truth/pixel_miss.h"
#include "truth/ray_caster.h"

namespace tellurion {
namespace {

using namespace std::chrono_literals;

int camerasPerPlace = 3;
unsigned int seed = 20261122;
std::vector<double> tolerances{1.0};
std::filesystem::path collection;
std::string onlyPlace;
int onlyCamera = -1;

constexpr scene::Viewport kSize{.width = 128, .height = 96};
constexpr double kEyeHeight_m = 2.0;     ///< the least over the ground
constexpr double kShareWithin = 0.999;   ///< of all pixels, within the allowed distance
constexpr double kShareOfCamera = 0.99;  ///< likewise of the worst camera's
constexpr double kWorst = 3.0;           ///< times the allowed distance: no pixel is off by more
constexpr long kPixelsForShare = 1000;   ///< a camera that has fewer has no share of its own

/// The distance in pixels that a picture may be off: its tolerance, and a pixel where that is less.
double allowed_px(double tolerance_px) {
  return std::max(tolerance_px, 1.0);
}

struct Place {
  std::string name;
  geo::GeoRect where;
  double finestSample_m = 0;  ///< of the rasters, there
};

struct Planet {
  geo::Body body;
  std::vector<std::string> rasters;
  std::vector<Place> places;
};

std::string embedded(const std::string& file) {
  return TELLURION_SOURCE_DIR "/data/" + file;
}

std::vector<Planet> planets() {
  std::vector<Planet> all{
      {.body = geo::earth(),
       .rasters = {embedded("earth/etopo5_dem_10min.tif"), embedded("earth/srtm3_everest_N27E086_filled.tif")},
       .places = {{.name = "earth", .where = geo::GeoRect::whole(), .finestSample_m = 18553.0},
                  {.name = "everest",
                   .where = geo::GeoRect::fromDegrees(27.02, 86.02, 27.98, 86.98),
                   .finestSample_m = 92.8}}},
      {.body = geo::mars(),
       .rasters = {embedded("mars/mola_dem_4ppd.tif")},
       .places = {{.name = "mars", .where = geo::GeoRect::whole(), .finestSample_m = 14819.0}}}};
  if (collection.empty()) return all;
  all[0].rasters.push_back(collection / "earth/gabilan_lidar_dem_1m.tif");
  all[0].places.push_back({.name = "gabilan",
                           .where = geo::GeoRect::fromDegrees(35.921, -120.824, 35.927, -120.815),
                           .finestSample_m = 1.0});
  all[1].rasters.push_back(collection / "mars/gale_hrsc_dem_660m.tif");
  all[1].rasters.push_back(collection / "mars/gale_hirise_dem_1m.tif");
  all[1].places.push_back({.name = "gale",
                           .where = geo::GeoRect::fromDegrees(-4.6694, 137.3675, -4.6642, 137.3730),
                           .finestSample_m = 1.0});
  return all;
}

using HeightOf = std::function<double(const geo::Direction&)>;  ///< the ground's, metres above the ellipsoid

/// Cameras over random points of a place.
class Cameras {
 public:
  Cameras(const geo::Ellipsoid& ellipsoid, const Place& place, tiling::Scheme scheme)
      : ellipsoid_(ellipsoid), place_(place) {
    std::vector<unsigned int> dice{seed, static_cast<unsigned int>(scheme)};
    dice.insert(dice.end(), place.name.begin(), place.name.end());
    std::seed_seq mixed(dice.begin(), dice.end());
    random_.seed(mixed);
  }

  /// Any height, any heading, any pitch that has ground in the picture.
  scene::View anywhere(const HeightOf& height_m) {
    const geo::Angle fov = geo::Angle::degrees(uniform(20, 70));
    scene::Camera camera{.position = somewhere()};
    const double highest_m = 4.0 * ellipsoid_.semiMajorAxis_m();
    const double above_m = kEyeHeight_m * std::pow(highest_m / kEyeHeight_m, uniform(0, 1));
    const auto below = geo::directionFromLatLon(camera.position.lat, camera.position.lon);
    camera.position.height_m = height_m(below) + above_m;
    const double horizon = std::acos(ellipsoid_.semiMinorAxis_m() / (ellipsoid_.semiMinorAxis_m() + above_m));
    camera.heading = geo::Angle::degrees(uniform(0, 360));
    camera.pitch = geo::Angle::degrees(uniform(-90, 15 - horizon * 180.0 / geo::kPi));
    camera.roll = geo::Angle::degrees(uniform(-30, 30));
    return scene::viewOf(camera, ellipsoid_, fov, kSize);
  }

  /// Looks at the place from any side, from so far away that each pixel covers a sample of the rasters or more.
  scene::View wherePixelsCoverSamples(const HeightOf& height_m) {
    const geo::Angle fov = geo::Angle::degrees(45);
    const double lowest_m = place_.finestSample_m / (2.0 * std::tan(fov.radians() / 2.0) / kSize.height);
    for (;;) {
      geo::Geodetic target = somewhere();
      target.height_m = height_m(geo::directionFromLatLon(target.lat, target.lon));
      const geo::LocalFrame frame = geo::localFrameAt(ellipsoid_, target);
      const double distance_m = lowest_m * std::exp(uniform(std::log(1.3), std::log(8.0)));
      const double elevation = uniform(12.0, 90.0) * geo::kPi / 180.0;
      const double azimuth = uniform(0.0, 2.0 * geo::kPi);
      const geo::Vec3 away =
          frame.bodyFromEnu() * geo::Vec3(std::cos(elevation) * std::sin(azimuth),
                                          std::cos(elevation) * std::cos(azimuth), std::sin(elevation));
      const geo::Geodetic place = ellipsoid_.geodeticFromBody(frame.origin + away * distance_m);
      const double below_m = height_m(geo::directionFromLatLon(place.lat, place.lon));
      if (place.height_m < below_m + kEyeHeight_m) continue;
      const geo::LocalFrame eye = geo::localFrameAt(ellipsoid_, place);
      const scene::Camera camera{
          .position = place,
          .heading = geo::Angle::radians(std::atan2(-geo::dot(away, eye.east), -geo::dot(away, eye.north))),
          .pitch = geo::Angle::radians(std::asin(std::clamp(-geo::dot(away, eye.up), -1.0, 1.0))),
          .roll = geo::Angle::degrees(uniform(-30.0, 30.0))};
      return scene::viewOf(camera, ellipsoid_, fov, kSize);
    }
  }

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  geo::Geodetic somewhere() {
    const double south = std::sin(place_.where.south.radians());
    const double north = std::sin(place_.where.north.radians());
    const double lat = std::asin(uniform(south, north));
    return {.lat = geo::Angle::radians(lat), .lon = place_.where.west + place_.where.width * uniform(0.0, 1.0)};
  }

  geo::Ellipsoid ellipsoid_;
  Place place_;
  std::mt19937_64 random_;
};

std::string described(const scene::View& view, const geo::Ellipsoid& ellipsoid) {
  const scene::Camera c = scene::cameraOf(view, ellipsoid);
  std::ostringstream out;
  out.precision(12);
  out << c.position.lat.degrees() << ',' << c.position.lon.degrees() << ',' << c.position.height_m << ','
      << c.heading.degrees() << ',' << c.pitch.degrees() << ',' << c.roll.degrees() << " fov "
      << view.verticalFov.degrees();
  return out.str();
}

/// What a picture's pixels are off, those of sky that is sky not counted.
struct Tally {
  long pixels = 0;
  long allowed = 0;          ///< within the allowed distance
  long withinTolerance = 0;  ///< within the tolerance
  double worst_px = 0;
  int camera = 0;  ///< of the worst, as are the next two
  int col = 0;
  int row = 0;

  void count(double miss_px, double tolerance_px, int atCol, int atRow) {
    ++pixels;
    allowed += miss_px <= allowed_px(tolerance_px) ? 1 : 0;
    withinTolerance += miss_px <= tolerance_px ? 1 : 0;
    if (miss_px <= worst_px) return;
    worst_px = miss_px;
    col = atCol;
    row = atRow;
  }
  void add(const Tally& o) {
    pixels += o.pixels;
    allowed += o.allowed;
    withinTolerance += o.withinTolerance;
    if (o.worst_px <= worst_px) return;
    worst_px = o.worst_px;
    camera = o.camera;
    col = o.col;
    row = o.row;
  }
  double share() const { return pixels == 0 ? 1.0 : static_cast<double>(allowed) / static_cast<double>(pixels); }
  std::string told() const {
    std::array<char, 200> text{};
    const auto percent = [&](long n) {
      return pixels == 0 ? 100.0 : 100.0 * static_cast<double>(n) / static_cast<double>(pixels);
    };
    std::snprintf(text.data(), text.size(),
                  "%9ld pixels, %.4f%% allowed, %.4f%% within the tolerance, worst %.2f px "
                  "(camera %d, pixel %d, %d)",
                  pixels, percent(allowed), percent(withinTolerance), worst_px, camera, col, row);
    return text.data();
  }
};

/// One surface from one eye, its rays kept.
class Seen {
 public:
  Seen(truth::DistanceAlong surface, const scene::View& view)
      : surface_(std::move(surface)), view_(view), centres_(kSize.width, kSize.height, kUnknown) {}

  double centre(int col, int row) {
    double& known = centres_.at(col, row);
    if (known == kUnknown) known = surface_(scene::rayThrough(view_, middleOf(col, row)));
    return known;
  }

  /// `counts(col, row, distance)`: whether a pixel that shows something at this distance is compared.
  template <class Counts>
  Tally compare(const raster::Raster<float>& drawn, double tolerance_px, int camera, const Counts& counts) {
    const double most_px = 4.0 * allowed_px(tolerance_px);
    Tally sum{.camera = camera};
    Tally others{.camera = camera};
    const auto rows = [&](int first, int step, Tally& tally) {
      for (int row = first; row < kSize.height; row += step) {
        for (int col = 0; col < kSize.width; ++col) {
          const auto distance = static_cast<double>(drawn.at(col, row));
          if (!counts(col, row, distance)) continue;
          if (std::isnan(distance) && std::isnan(centre(col, row))) continue;
          const double miss = truth::missOf(surface_, view_, middleOf(col, row), distance, centre(col, row), most_px);
          tally.count(miss, tolerance_px, col, row);
        }
      }
    };
    {
      const std::jthread other(rows, 1, 2, std::ref(others));
      rows(0, 2, sum);
    }
    sum.add(others);
    return sum;
  }

 private:
  static constexpr double kUnknown = -1.0;
  static scene::PixelPosition middleOf(int col, int row) { return {col + 0.5, row + 0.5}; }

  truth::DistanceAlong surface_;
  scene::View view_;
  raster::Raster<double> centres_;
};

/// The frame that the view needs, with nothing on its way.
const scene::Frame& wholeFrame(scene::Globe& globe, const scene::View& view, double tolerance_px) {
  const scene::CutOptions options{.tolerance_px = tolerance_px};
  const auto deadline = std::chrono::steady_clock::now() + 300s;
  while (globe.update(view, options).statistics.tilesWanted > 0 && std::chrono::steady_clock::now() < deadline)
    globe.waitForArrivals(500ms);
  return globe.update(view, options);
}

/// All pictures of one place at one tolerance.
struct Result {
  int cameras = 0;
  int capped = 0;  ///< the cut had tiles enough before it was fine enough: nothing is promised
  Tally finest;    ///< of the others, as are the next three
  Tally source;
  double worstShare = 1.0;
  double maxScreenError_px = 0;
  Tally cappedFinest;
  double cappedScreenError_px = 0;
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
    auto target = render::RenderTarget::create(kSize);
    ASSERT_TRUE(renderer && target);
    renderer_.emplace(std::move(*renderer));
    target_.emplace(std::move(*target));
    folder_ = std::filesystem::path(testing::TempDir()) / ("depth_truth_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override {
    if (!folder_.empty()) std::filesystem::remove_all(folder_);
  }

  std::shared_ptr<const raster::TileSource> databaseOf(const Planet& planet) const {
    const pyramid::BuildOptions build{.output = folder_ / (planet.body.name + ".tdb"),
                                      .inputs = planet.rasters,
                                      .scheme = GetParam(),
                                      .body = planet.body,
                                      .fillVoids_m = 0.0};  // the rasters are the truth, coarse ones beside fine too
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
  World(const Planet& planet, const std::shared_ptr<const raster::TileSource>& database)
      : finest(*database), rasters(planet.rasters, planet.body.ellipsoid) {
    auto opened =
        scene::Globe::fromLayers({.body = planet.body, .tiling = database->info().scheme}, {.elevation = {database}});
    EXPECT_TRUE(opened);
    if (opened) globe = std::move(*opened);
  }
  double height_m(const geo::Direction& d) const { return finest.height_m(d); }

  truth::FinestSurface finest;
  truth::SourceSurface rasters;
  std::unique_ptr<scene::Globe> globe;
};

/// Both truths from one eye. Stays where it is.
class Truths {
 public:
  Truths(const World& world, const scene::View& view)
      : world_(world),
        view_(view),
        finest_([this](const geo::Ray& ray) { return world_.finest.distanceAlong(ray); }, view),
        source_([this](const geo::Ray& ray) { return distanceAlong(world_.rasters, ray, view_.pixelAngle()); }, view) {}

  Tally onFinest(const raster::Raster<float>& drawn, double tolerance_px, int camera) {
    return finest_.compare(drawn, tolerance_px, camera, [](int, int, double) { return true; });
  }
  /// Where a pixel covers a sample of the source or more.
  Tally onSource(const raster::Raster<float>& drawn, double tolerance_px, int camera) {
    return source_.compare(drawn, tolerance_px, camera, [&](int col, int row, double drawn_m) {
      const geo::Ray ray = scene::rayThrough(view_, {col + 0.5, row + 0.5});
      const double d = std::isnan(drawn_m) ? finest_.centre(col, row) : drawn_m;
      if (std::isnan(d)) return false;
      const truth::SourceSurface& rasters = world_.rasters;
      const geo::Geodetic place = rasters.ellipsoid().geodeticFromBody({ray.origin.m + ray.direction * d});
      return d * view_.pixelAngle() >= rasters.spacing_m(place.lat.degrees(), place.lon.degrees());
    });
  }

 private:
  const World& world_;
  scene::View view_;
  Seen finest_;
  Seen source_;
};

void expectGood(const Tally& tally, double tolerance_px, Result& result, const std::string& what) {
  EXPECT_LE(tally.worst_px, kWorst * allowed_px(tolerance_px)) << what << ", pixel " << tally.col << ", " << tally.row;
  if (tally.pixels < kPixelsForShare) return;
  EXPECT_GE(tally.share(), kShareOfCamera) << what;
  result.worstShare = std::min(result.worstShare, tally.share());
}

/// The finest ground read in two ways, which differ only beside tiles that are not stored, and its rays.
void expectSound(const truth::FinestSurface& ground, const std::shared_ptr<const raster::TileSource>& database,
                 const Place& place) {
  auto query = pyramid::HeightQuery::create(database);
  ASSERT_TRUE(query);
  Cameras cameras(database->info().body.ellipsoid, place, database->info().scheme);
  const auto height = [&](const geo::Direction& d) { return ground.height_m(d); };
  int same = 0;
  constexpr int kPlaces = 100;
  for (int i = 0; i < kPlaces; ++i) {
    const scene::View view = cameras.anywhere(height);
    const geo::Direction below = ground.ellipsoid().directionFromBody(view.eye);
    const auto answer = query->at(below);
    ASSERT_TRUE(answer && *answer);
    same += std::abs((*answer)->height_m - ground.height_m(below)) < 0.01 ? 1 : 0;

    const geo::Ray ray = scene::rayThrough(view, scene::centreOf(kSize));
    const double distance_m = ground.distanceAlong(ray);
    const double end_m = std::isnan(distance_m) ? 10.0 * ground.ellipsoid().semiMajorAxis_m() : distance_m;
    const auto above_m = [&](double d) {
      const geo::BodyPosition p{ray.origin.m + ray.direction * d};
      return ground.ellipsoid().geodeticFromBody(p).height_m - height(ground.ellipsoid().directionFromBody(p));
    };
    if (!std::isnan(distance_m)) {
      // Rays may graze a crest: what a thousandth of a pixel is across, there.
      const double exact_m = 1e-5 * distance_m;
      const double slack_m = std::max(0.01, 1e-6 * distance_m);
      EXPECT_GT(above_m(distance_m - exact_m), -slack_m) << place.name << ", ray " << i;
      EXPECT_LT(above_m(distance_m + exact_m), slack_m) << place.name << ", ray " << i;
    }
    for (double share = 0.01; share < 0.999; share += 0.01)
      EXPECT_GT(above_m(share * end_m), 0.0) << place.name << ", ray " << i << ", " << share << " of " << end_m << " m";
  }
  EXPECT_GE(same, kPlaces - 3) << place.name;
}

/// One camera at one tolerance; `drawn` makes the picture of a frame.
template <class Drawn>
void look(World& world, const scene::View& view, Truths& truths, int camera, double tolerance_px, const Drawn& drawn,
          Result& result, const std::string& what) {
  const scene::Frame& frame = wholeFrame(*world.globe, view, tolerance_px);
  const double error_px = frame.statistics.maxScreenError_px;
  const raster::Raster<float> picture = drawn(frame);
  const Tally onFinest = truths.onFinest(picture, tolerance_px, camera);
  ++result.cameras;
  if (frame.statistics.cappedByBudget) {
    ++result.capped;
    result.cappedFinest.add(onFinest);
    result.cappedScreenError_px = std::max(result.cappedScreenError_px, error_px);
    return;
  }
  ASSERT_TRUE(frame.complete) << what;
  EXPECT_LE(error_px, tolerance_px * (1.0 + 1e-6)) << what;
  const Tally onSource = truths.onSource(picture, tolerance_px, camera);
  expectGood(onFinest, tolerance_px, result, what + ", against the finest ground");
  expectGood(onSource, tolerance_px, result, what + ", against the source");
  result.maxScreenError_px = std::max(result.maxScreenError_px, error_px);
  result.finest.add(onFinest);
  result.source.add(onSource);
}

void tell(const Place& place, tiling::Scheme scheme, double tolerance_px, const Result& r) {
  std::printf("%-8s %-10s tolerance %g px: %d cameras; max_screen_error_px %.6f; worst camera %.3f%%\n",
              place.name.c_str(), std::string(nameOf(scheme)).c_str(), tolerance_px, r.cameras - r.capped,
              r.maxScreenError_px, 100.0 * r.worstShare);
  std::printf("  finest ground:  %s\n  source rasters: %s\n", r.finest.told().c_str(), r.source.told().c_str());
  if (r.capped > 0)
    std::printf("  %d more, cut off by the budget of tiles, max_screen_error_px %.3f:\n  finest ground:  %s\n",
                r.capped, r.cappedScreenError_px, r.cappedFinest.told().c_str());
  std::fflush(stdout);
}

TEST_P(DepthTruth, IsWithinTheTolerance) {
  const auto picture = [&](const scene::Frame& frame) { return drawn(frame); };
  for (const Planet& planet : planets()) {
    const auto database = databaseOf(planet);
    ASSERT_TRUE(database);
    World world(planet, database);
    ASSERT_TRUE(world.globe);
    const auto height = [&](const geo::Direction& d) { return world.height_m(d); };
    for (const Place& place : planet.places) {
      if (!onlyPlace.empty() && place.name != onlyPlace) continue;
      expectSound(world.finest, database, place);
      Cameras cameras(planet.body.ellipsoid, place, GetParam());
      std::vector<Result> results(tolerances.size());
      for (int number = 0; number < camerasPerPlace; ++number) {
        const scene::View view = number % 3 == 2 ? cameras.wherePixelsCoverSamples(height) : cameras.anywhere(height);
        if (onlyCamera >= 0 && number != onlyCamera) continue;
        Truths truths(world, view);
        for (std::size_t i = 0; i < tolerances.size(); ++i) {
          std::ostringstream what;
          what << place.name << " camera " << number << " of seed " << seed << ", tolerance " << tolerances[i] << ", "
               << described(view, planet.body.ellipsoid);
          look(world, view, truths, number, tolerances[i], picture, results[i], what.str());
          if (HasFatalFailure()) return;
        }
      }
      for (std::size_t i = 0; i < tolerances.size(); ++i) {
        tell(place, GetParam(), tolerances[i], results[i]);
        EXPECT_GE(results[i].finest.share(), kShareWithin) << place.name << ", tolerance " << tolerances[i];
        EXPECT_GE(results[i].source.share(), kShareWithin) << place.name << ", tolerance " << tolerances[i];
      }
    }
  }
}

// The measure can fail: near the mountains the bare ellipsoid does not pass it.
TEST_P(DepthTruth, TellsTheGroundFromTheEllipsoid) {
  const Planet planet = planets().front();
  const truth::SourceSurface rasters(planet.rasters, planet.body.ellipsoid);
  const auto bare = scene::Globe::fromLayers({.body = planet.body, .tiling = GetParam()}, {});
  ASSERT_TRUE(bare);
  const auto flat = [](const geo::Direction&) { return 0.0; };
  const scene::View view = Cameras(planet.body.ellipsoid, planet.places[1], GetParam()).wherePixelsCoverSamples(flat);
  Seen source([&](const geo::Ray& ray) { return truth::distanceAlong(rasters, ray, view.pixelAngle()); }, view);
  const auto some = [](int col, int row, double) { return col % 8 == 0 && row % 8 == 0; };
  EXPECT_LT(source.compare(drawn(wholeFrame(**bare, view, 1.0)), 1.0, 0, some).share(), 0.9);
}

// A ball of 1 km from 3 km off: its outline is 41 pixels from the middle of the picture.
class Ball : public testing::Test {
 protected:
  static std::optional<double> distance_m(double x_px, double raised_m = 0.0) {
    return kBall.intersect(scene::rayThrough(view(), {kSize.width / 2.0 + x_px, kSize.height / 2.0}), raised_m);
  }
  static double miss_px(double x_px, std::optional<double> drawn_m) {
    const auto ball = [](const geo::Ray& ray) { return kBall.intersect(ray).value_or(kSky); };
    return truth::missOf(ball, view(), {kSize.width / 2.0 + x_px, kSize.height / 2.0}, drawn_m.value_or(kSky),
                         distance_m(x_px).value_or(kSky), 4.0);
  }
  static scene::View view() {
    const scene::Camera camera{.position = {.height_m = 2000.0}, .pitch = geo::Angle::degrees(-90)};
    return scene::viewOf(camera, kBall, geo::Angle::degrees(45), kSize);
  }
  static double outline_px() { return std::tan(std::asin(1.0 / 3.0)) / view().pixelAngle(); }

  static constexpr double kSky = std::numeric_limits<double>::quiet_NaN();
  static constexpr geo::Ellipsoid kBall{1000.0, 0.0};
};

TEST_F(Ball, IsOffByTheWidthOfPixelsAlongTheRay) {
  const double width_m = 2000.0 * view().pixelAngle();
  for (const double px : {-3.5, -0.2, 0.0, 0.3, 1.7, 3.9}) {
    // Both the ball's surface and the picture face the eye there.
    EXPECT_NEAR(miss_px(0.0, *distance_m(0.0) + px * width_m), std::abs(px), 0.04 * std::abs(px)) << px;
  }
}

TEST_F(Ball, IsOffByTheWayToItsOutline) {
  EXPECT_EQ(miss_px(outline_px() + 1.0, std::nullopt), 0.0);
  for (const double px : {0.4, 1.1, 2.9})  // rings are a quarter of a pixel apart
    EXPECT_NEAR(miss_px(outline_px() - px, std::nullopt), px, 0.25) << px;
  EXPECT_GT(miss_px(outline_px() - 4.5, std::nullopt), 4.0);
  // What is drawn beyond the outline has no surface on its ray, and the nearest beside it.
  EXPECT_NEAR(miss_px(outline_px() + 2.1, distance_m(outline_px() - 0.1)), 2.25, 0.25);
  EXPECT_GT(miss_px(outline_px() + 4.5, distance_m(outline_px() - 0.1)), 4.0);
}

TEST_F(Ball, IsMetAnywhereBetweenNeighbouringRays) {
  // Grazing, half a pixel aside is far along the ray.
  const double x = outline_px() - 2.0;
  const double halfAPixelOn = *distance_m(x + 0.5);
  EXPECT_GT((halfAPixelOn - *distance_m(x)) / (halfAPixelOn * view().pixelAngle()), 1.0);
  EXPECT_NEAR(miss_px(x, halfAPixelOn), 0.5, 0.25);
}

INSTANTIATE_TEST_SUITE_P(Schemes, DepthTruth,
                         testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix),
                         [](const auto& scheme) { return std::string(nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.starts_with("--cameras=")) tellurion::camerasPerPlace = std::stoi(argument.substr(10));
    if (argument.starts_with("--seed=")) tellurion::seed = static_cast<unsigned int>(std::stoul(argument.substr(7)));
    if (argument.starts_with("--collection=")) tellurion::collection = argument.substr(13);
    if (argument.starts_with("--place=")) tellurion::onlyPlace = argument.substr(8);
    if (argument.starts_with("--camera=")) tellurion::onlyCamera = std::stoi(argument.substr(9));
    if (argument.starts_with("--tolerance=")) {
      std::istringstream list(argument.substr(12));
      tellurion::tolerances.clear();
      for (std::string one; std::getline(list, one, ',');)
        tellurion::tolerances.push_back(std::stod(one));
    }
  }
  return RUN_ALL_TESTS();
}
