// Builds that clean their inputs, against the picture that the inputs were made of.
#include "pyramid/imagery_cleaning.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>

#include "geo/seed_test.h"
#include "pyramid/colour_query.h"
#include "pyramid/synthetic_rasters_test.h"

namespace tellurion::pyramid::testing {
namespace {

using raster::Rgba8;
using tiling::Scheme;

constexpr double kWest = 10.0;
constexpr double kSouth = 40.0;
constexpr double kSide = 4.0;
constexpr int kPixels = 240;
constexpr double kPixel = kSide / kPixels;

double lonOf(int column) {
  return kWest + (column + 0.5) * kPixel;
}
double latOf(int row) {
  return kSouth + kSide - (row + 0.5) * kPixel;
}

/// Land: soft colours, some contrast, never near white.
std::array<double, 3> ground(double lat, double lon) {
  const double wave = std::sin(9.0 * lon + 2.0 * lat) * std::cos(7.0 * lat);
  const double broad = std::sin(1.3 * lon) + std::cos(1.7 * lat);
  return {95.0 + 25.0 * wave + 8.0 * broad, 105.0 + 18.0 * wave - 6.0 * broad, 80.0 - 20.0 * wave + 9.0 * broad};
}

Rgba8 rgb(const std::array<double, 3>& c) {
  const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround(std::clamp(v, 1.0, 254.0))); };
  return {byte(c[0]), byte(c[1]), byte(c[2]), 255};
}

/// Another sensor on another day: a line a channel that drifts over the picture.
std::array<double, 3> elsewhere(double lat, double lon) {
  std::array<double, 3> c = ground(lat, lon);
  const double east = (lon - kWest) / kSide;
  const double north = (lat - kSouth) / kSide;
  c[0] = (0.75 + 0.15 * east) * c[0] + 40.0;
  c[1] = (1.1 - 0.2 * north) * c[1] + 15.0 * east;
  c[2] = 0.9 * c[2] + 30.0 * north - 5.0;
  return c;
}

double farthest(Rgba8 seen, const std::array<double, 3>& expected) {
  return std::max({std::abs(seen.r - expected[0]), std::abs(seen.g - expected[1]), std::abs(seen.b - expected[2])});
}

class ImageryCleaningOf : public ::testing::TestWithParam<Scheme> {
 protected:
  std::string written(const std::string& name, const std::function<Rgba8(double lat, double lon)>& colour) const {
    writeColour(folder_ / name, degreesGrid(kWest, kSouth, kWest + kSide, kSouth + kSide, kPixels, kPixels),
                [&](int c, int r) { return colour(latOf(r), lonOf(c)); });
    return (folder_ / name).string();
  }
  BuildOptions options(const std::vector<std::string>& inputs, const std::string& name) const {
    BuildOptions options;
    options.output = folder_ / name;
    options.inputs = inputs;
    options.kind = raster::Kind::imagery;
    options.scheme = GetParam();
    return options;
  }
  /// Its colours, to be asked for.
  static ColourQuery built(const BuildOptions& options) {
    auto query = ColourQuery::create(builtPyramid(options));
    if (!query) std::abort();
    return std::move(*query);
  }
  static Rgba8 at(const ColourQuery& query, double lat, double lon) {
    const auto answer = query.at(geo::directionFromDegrees(lat, lon));
    EXPECT_TRUE(answer.has_value());
    return answer && *answer ? (*answer)->colour : Rgba8{};
  }

  TemporaryFolder folder_;
};

/// Three round holes.
double outsideOfHoles(double lat, double lon) {
  double least = 1e9;
  for (const auto& [north, east, radius] : {std::array{41.0, 11.2, 0.35}, {42.7, 12.9, 0.5}, {43.0, 10.8, 0.2}})
    least = std::min(least, std::hypot(lat - north, lon - east) - radius);
  return least;
}

TEST_P(ImageryCleaningOf, HolesAreFilledInTheColoursAround) {
  const std::string below = written("below.tif", [](double lat, double lon) { return rgb(elsewhere(lat, lon)); });
  const std::string above = written("above.tif", [](double lat, double lon) {
    return outsideOfHoles(lat, lon) < 0.0 ? Rgba8{} : rgb(ground(lat, lon));
  });
  BuildOptions plain = options({below, above}, "plain.tdb");
  BuildOptions matched = options({below, above}, "matched.tdb");
  matched.cleaning.matchColours = true;
  const ColourQuery before = built(plain);
  const ColourQuery after = built(matched);
  double worstBefore = 0.0;
  double sumAfter = 0.0;
  int places = 0;
  for (double lat = kSouth + 0.1; lat < kSouth + kSide - 0.1; lat += 0.031) {
    for (double lon = kWest + 0.1; lon < kWest + kSide - 0.1; lon += 0.031) {
      if (outsideOfHoles(lat, lon) > -0.05) continue;
      worstBefore = std::max(worstBefore, farthest(at(before, lat, lon), ground(lat, lon)));
      const double off = farthest(at(after, lat, lon), ground(lat, lon));
      EXPECT_LT(off, 14.0) << lat << " " << lon;
      sumAfter += off;
      ++places;
    }
  }
  EXPECT_GT(places, 500);
  EXPECT_GT(worstBefore, 25.0) << "the test has nothing to mend";
  EXPECT_LT(sumAfter / places, 5.0);
}

TEST_P(ImageryCleaningOf, SeamsAreFeatheredInsideAndNothingElseChanges) {
  const std::string below = written("below.tif", [](double, double) { return Rgba8{200, 100, 50, 255}; });
  const std::string above = written("above.tif", [](double lat, double lon) {
    return outsideOfHoles(lat, lon) < 0.0 ? Rgba8{} : Rgba8{60, 160, 120, 255};
  });
  BuildOptions feathered = options({below, above}, "feathered.tdb");
  constexpr double kWidth_deg = 0.2;
  feathered.cleaning.feather_m = kWidth_deg * geo::kPi / 180.0 * geo::earth().ellipsoid.meanRadius_m();
  const ColourQuery query = built(feathered);
  int changed = 0;
  for (double lat = 42.7 - 0.9; lat < 42.7 + 0.9; lat += 0.01) {
    // Along the meridian through the largest hole's middle, away from the other holes and the border.
    const double fromRim = outsideOfHoles(lat, 12.9);
    const Rgba8 colour = at(query, lat, 12.9);
    EXPECT_EQ(colour.a, 255);
    if (fromRim < -0.02) {
      EXPECT_LT(farthest(colour, {200, 100, 50}), 4.0) << lat;
    } else if (fromRim > kWidth_deg + 0.05) {
      EXPECT_LT(farthest(colour, {60, 160, 120}), 4.0) << lat;
    } else {
      ++changed;
    }
    const Rgba8 next = at(query, lat + 0.01, 12.9);
    EXPECT_LT(std::abs(next.r - colour.r), 30) << "a step at " << lat;
  }
  EXPECT_GT(changed, 20);
}

TEST_P(ImageryCleaningOf, WithNothingBelowThereIsNothingToFadeInto) {
  const std::string only = written("only.tif", [](double, double) { return Rgba8{60, 160, 120, 255}; });
  const std::string far = (folder_ / "far.tif").string();
  writeColour(far, degreesGrid(60, 10, 61, 11, 20, 20), [](int, int) { return Rgba8{1, 2, 3, 255}; });
  BuildOptions feathered = options({far, only}, "feathered.tdb");
  feathered.cleaning.feather_m = 30000.0;
  const ColourQuery query = built(feathered);
  for (const double lat : {kSouth + 0.02, kSouth + 1.0, kSouth + kSide - 0.02}) {
    const Rgba8 colour = at(query, lat, kWest + 2.0);
    EXPECT_EQ(colour.a, 255) << lat;
    EXPECT_LT(farthest(colour, {60, 160, 120}), 4.0) << lat;
  }
}

TEST_P(ImageryCleaningOf, CutAtACoastlineTheSeaIsTheBases) {
  const std::string ocean = written("ocean.tif", [](double, double) { return Rgba8{20, 40, 120, 255}; });
  const std::string scene = written("scene.tif", [](double, double) { return Rgba8{180, 170, 90, 255}; });
  const std::filesystem::path coast = folder_ / "coast.geojson";
  // An island of 2 x 2 degrees with a lake of half a degree, and one that lies a turn farther west.
  std::ofstream(coast) << R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":)"
                          R"({"type":"Polygon","coordinates":[[[11,41],[13,41],[13,43],[11,43],[11,41]],)"
                          R"([[11.5,41.5],[11.5,42],[12,42],[12,41.5],[11.5,41.5]]]}},)"
                          R"({"type":"Feature","properties":{},"geometry":{"type":"Polygon","coordinates":)"
                          R"([[[-346.7,40.2],[-346.2,40.2],[-346.2,40.7],[-346.7,40.7],[-346.7,40.2]]]}}]})";
  BuildOptions cut = options({ocean, scene}, "cut.tdb");
  cut.cleaning.cutAt = {coast.string()};
  cut.cleaning.feather_m = 11000.0;  // 0.1 degree
  const ColourQuery query = built(cut);
  const auto isLand = [&](double lat, double lon) { return farthest(at(query, lat, lon), {180, 170, 90}) < 5.0; };
  const auto isSea = [&](double lat, double lon) { return farthest(at(query, lat, lon), {20, 40, 120}) < 5.0; };
  EXPECT_TRUE(isLand(41.2, 12.0));
  EXPECT_TRUE(isLand(42.97, 12.97));
  EXPECT_TRUE(isSea(41.75, 11.75)) << "the lake's middle";
  EXPECT_TRUE(isSea(43.15, 12.0));
  EXPECT_TRUE(isSea(40.2, 10.2));
  EXPECT_TRUE(isLand(40.45, 13.55)) << "an island in another turn";
  const Rgba8 shallow = at(query, 43.05, 12.0);
  EXPECT_GT(shallow.r, 30);
  EXPECT_LT(shallow.r, 175);
}

/// How thick the clouds are: three banks with soft rims.
double cloudAt(double lat, double lon) {
  double thickest = 0.0;
  for (const auto& [north, east, radius] : {std::array{41.0, 11.0, 0.4}, {42.4, 13.0, 0.5}, {43.2, 11.3, 0.25}}) {
    const double in = (radius - std::hypot(lat - north, lon - east)) / 0.12;
    thickest = std::max(thickest, std::clamp(in, 0.0, 1.0));
  }
  return thickest;
}

TEST_P(ImageryCleaningOf, CloudsGiveWayToTheClearMapAndClearGroundStays) {
  const std::string clear = written("clear.tif", [](double lat, double lon) { return rgb(elsewhere(lat, lon)); });
  const std::string cloudy = written("cloudy.tif", [](double lat, double lon) {
    std::array<double, 3> c = ground(lat, lon);
    for (double& v : c)
      v += cloudAt(lat, lon) * (235.0 - v);
    return rgb(c);
  });
  BuildOptions cleaned = options({clear, cloudy}, "cleaned.tdb");
  cleaned.cleaning.clouds = true;
  cleaned.cleaning.matchColours = true;
  const ColourQuery query = built(cleaned);
  int cloudPlaces = 0;
  int stillCloud = 0;
  int clearPlaces = 0;
  int spoilt = 0;
  for (double lat = kSouth + 0.1; lat < kSouth + kSide - 0.1; lat += 0.031) {
    for (double lon = kWest + 0.1; lon < kWest + kSide - 0.1; lon += 0.031) {
      const double off = farthest(at(query, lat, lon), ground(lat, lon));
      if (cloudAt(lat, lon) > 0.3) {
        ++cloudPlaces;
        stillCloud += off > 20.0 ? 1 : 0;
      } else if (cloudAt(lat, lon) == 0.0) {
        ++clearPlaces;
        spoilt += off > 16.0 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(cloudPlaces, 800);
  EXPECT_LT(stillCloud, cloudPlaces / 50);
  EXPECT_LT(spoilt, clearPlaces / 50);
}

TEST_P(ImageryCleaningOf, TheBytesDoNotDependOnTheWorkers) {
  const std::string below = written("below.tif", [](double lat, double lon) { return rgb(elsewhere(lat, lon)); });
  const std::string above = written("above.tif", [](double lat, double lon) {
    return outsideOfHoles(lat, lon) < 0.0 ? Rgba8{} : rgb(ground(lat, lon));
  });
  std::string first;
  for (const int jobs : {1, 3}) {
    BuildOptions cleaned = options({below, above}, fmt::format("jobs{}.tdb", jobs));
    cleaned.cleaning = {.matchColours = true, .feather_m = 9000.0, .cutAt = {}, .clouds = true};
    cleaned.jobs = jobs;
    ASSERT_NE(builtPyramid(cleaned), nullptr);
    const std::string bytes = bytesOf(cleaned.output);
    if (first.empty()) first = bytes;
    EXPECT_TRUE(bytes == first);
  }
}

TEST_P(ImageryCleaningOf, WhatIsHalfTransparentIsFeatheredAndStays) {
  const std::string below = written("below.tif", [](double, double) { return Rgba8{200, 100, 50, 255}; });
  const std::string above = written("above.tif", [](double, double) { return Rgba8{40, 180, 150, 128}; });
  const Rgba8 plain = at(built(options({below, above}, "plain.tdb")), kSouth + 2.0, kWest + 2.0);
  EXPECT_GT(farthest(plain, {200, 100, 50}), 20.0) << "the test has nothing to keep";
  BuildOptions feathered = options({below, above}, "feathered.tdb");
  feathered.cleaning.feather_m = 10000.0;
  const Rgba8 seen = at(built(feathered), kSouth + 2.0, kWest + 2.0);
  const auto channel = [](std::uint8_t v) { return static_cast<double>(v); };
  EXPECT_LT(farthest(seen, {channel(plain.r), channel(plain.g), channel(plain.b)}), 4.0);
}

TEST_P(ImageryCleaningOf, PolygonsBesideAnInputAndTooNarrowARampAreWarnedOf) {
  const std::string below = written("below.tif", [](double, double) { return Rgba8{200, 100, 50, 255}; });
  const std::filesystem::path coast = folder_ / "far.geojson";
  std::ofstream(coast) << R"({"type":"Polygon","coordinates":[[[51,1],[53,1],[53,3],[51,3],[51,1]]]})";
  BuildOptions cut = options({below, below}, "cut.tdb");
  cut.cleaning.cutAt = {coast.string()};
  cut.cleaning.feather_m = 100.0;
  const auto report = buildPyramid(cut);
  ASSERT_TRUE(report.has_value()) << io::describe(report.error());
  const auto warned = [&](const char* what) {
    return std::ranges::any_of(report->warnings,
                               [&](const std::string& w) { return w.find(what) != std::string::npos; });
  };
  EXPECT_TRUE(warned("no polygon of --cut meets it"));
  EXPECT_TRUE(warned("--feather 100 is narrower"));
}

INSTANTIATE_TEST_SUITE_P(Tilings, ImageryCleaningOf, ::testing::Values(Scheme::cube, Scheme::healpix),
                         [](const auto& tested) { return std::string(tiling::nameOf(tested.param)); });

TEST(ImageryCleaning, AnotherBuildsPartIsRefusedBeforeAnythingIsCleaned) {
  const TemporaryFolder folder;
  writeColour(folder / "a.tif", degreesGrid(0, 0, 10, 10, 20, 20), [](int, int) { return Rgba8{9, 9, 9, 255}; });
  BuildOptions options;
  options.output = folder / "out.tdb";
  options.inputs = {(folder / "a.tif").string(), (folder / "a.tif").string()};
  options.kind = raster::Kind::imagery;
  ASSERT_TRUE(buildPyramid(options).has_value());
  std::filesystem::rename(options.output, folder / "out.tdb.part");
  // Cleaning would fail for the polygons, were it begun.
  options.cleaning.cutAt = {(folder / "none.shp").string()};
  const auto result = buildPyramid(options);
  ASSERT_FALSE(result.has_value());
  const std::string& message = result.error().message;
  EXPECT_NE(message.find("is left from a build with other"), std::string::npos) << message;
  for (const char* option : {"--match-colours", "--feather", "--cut", "--clouds", "--format", "--region"})
    EXPECT_NE(message.find(option), std::string::npos) << message;
}

TEST(ImageryCleaning, WhatCannotBeIsSaidAndEveryOptionIsAnotherBuild) {
  const TemporaryFolder folder;
  writeColour(folder / "a.tif", degreesGrid(0, 0, 10, 10, 20, 20), [](int, int) { return Rgba8{9, 9, 9, 255}; });
  std::ofstream(folder / "lines.geojson") << R"({"type":"LineString","coordinates":[[1,1],[5,5]]})";
  const std::string input = (folder / "a.tif").string();
  BuildOptions options;
  options.output = folder / "out.tdb";
  options.inputs = {input, input};
  options.kind = raster::Kind::imagery;
  std::vector<std::string> keys{*keyOfBuild(options)};
  const auto differs = [&](const CleaningOptions& cleaning) {
    options.cleaning = cleaning;
    const auto key = keyOfBuild(options);
    ASSERT_TRUE(key.has_value()) << io::describe(key.error());
    EXPECT_EQ(std::ranges::find(keys, *key), keys.end());
    keys.push_back(*key);
  };
  differs({.matchColours = true, .feather_m = 0.0, .cutAt = {}, .clouds = false});
  differs({.matchColours = false, .feather_m = 10.0, .cutAt = {}, .clouds = false});
  differs({.matchColours = false, .feather_m = 0.0, .cutAt = {input}, .clouds = false});
  differs({.matchColours = false, .feather_m = 0.0, .cutAt = {}, .clouds = true});

  const auto refused = [&](const BuildOptions& wrong, const char* why) {
    const auto result = buildPyramid(wrong);
    ASSERT_FALSE(result.has_value()) << why;
    EXPECT_NE(result.error().message.find(why), std::string::npos) << result.error().message;
    EXPECT_FALSE(std::filesystem::exists(folder / "out.tdb.part"));
  };
  BuildOptions single = options;
  single.inputs = {input};
  refused(single, "at least two");
  for (const CleaningOptions& alone :
       {CleaningOptions{.matchColours = false, .feather_m = 9.0, .cutAt = {}, .clouds = false},
        CleaningOptions{.matchColours = false, .feather_m = 0.0, .cutAt = {input}, .clouds = false}}) {
    single.cleaning = alone;
    refused(single, "lies below first");
  }
  BuildOptions heights = options;
  heights.kind = raster::Kind::elevation;
  refused(heights, "only imagery");
  BuildOptions lines = options;
  lines.cleaning = {
      .matchColours = false, .feather_m = 0.0, .cutAt = {(folder / "lines.geojson").string()}, .clouds = false};
  refused(lines, "no polygons");
  lines.cleaning.cutAt = {(folder / "none.shp").string()};
  refused(lines, "no such file");
  lines.cleaning.cutAt = {input};
  refused(lines, "cannot be opened as vectors");
  BuildOptions wide = options;
  wide.cleaning.feather_m = std::nan("");
  refused(wide, "feathered");
}

}  // namespace
}  // namespace tellurion::pyramid::testing
