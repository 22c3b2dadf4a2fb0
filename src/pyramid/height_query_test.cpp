#include "pyramid/height_query.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "geo/local_frame.h"
#include "pyramid/synthetic_rasters_test.h"

namespace tellurion::pyramid::testing {
namespace {

using tiling::Scheme;
using tiling::TileId;

/// A planet as a function: tiles down to a level, made when they are asked for.
class FunctionSource final : public raster::TileSource {
 public:
  FunctionSource(Scheme scheme, int maxLevel, std::function<double(const geo::Direction&)> height)
      : height_(std::move(height)) {
    info_.scheme = scheme;
    info_.maxLevel = maxLevel;
    info_.body = geo::moon();
  }
  const raster::TileSourceInfo& info() const override { return info_; }
  io::Result<std::optional<raster::SourceTile>> load(const TileId& id) const override {
    if (id.level > info_.maxLevel) return std::optional<raster::SourceTile>{};
    const tiling::Tiling tiling(info_.scheme);
    raster::Raster<float> samples(67, 67, raster::kNoData);
    for (int r = 0; r <= 64; ++r) {
      for (int c = 0; c <= 64; ++c) {
        samples.at(c + 1, r + 1) =
            static_cast<float>(height_(tiling.direction(tiling::rootPointIn(id, c / 64.0, r / 64.0))));
      }
    }
    raster::SourceTile tile;
    tile.childMask = id.level < info_.maxLevel ? 15 : 0;
    tile.payload = raster::ElevationTile{std::move(samples)};
    return std::optional(std::move(tile));
  }

 private:
  raster::TileSourceInfo info_;
  std::function<double(const geo::Direction&)> height_;
};

class HeightQueryTest : public ::testing::TestWithParam<Scheme> {
 protected:
  HeightQuery query(int maxLevel, std::function<double(const geo::Direction&)> height,
                    std::uint64_t cacheBytes = 4 << 20) const {
    auto created =
        HeightQuery::create(std::make_shared<FunctionSource>(GetParam(), maxLevel, std::move(height)), cacheBytes);
    EXPECT_TRUE(created.has_value());
    return std::move(*created);
  }
};

const std::vector<geo::Direction>& places() {
  static const std::vector<geo::Direction> all = [] {
    std::vector<geo::Direction> list = {geo::directionFromDegrees(90, 0),  geo::directionFromDegrees(-90, 0),
                                        geo::directionFromDegrees(0, 180), geo::directionFromDegrees(0, -180),
                                        geo::directionFromDegrees(0, 45),  geo::directionFromDegrees(41.8103149, 0),
                                        geo::directionFromDegrees(0, 0),   geo::directionFromDegrees(35.2643897, 45)};
    std::mt19937 random(11);
    std::uniform_real_distribution<double> lat(-89.9, 89.9);
    std::uniform_real_distribution<double> lon(-180, 180);
    for (int i = 0; i < 300; ++i)
      list.push_back(geo::directionFromDegrees(lat(random), lon(random)));
    return list;
  }();
  return all;
}

TEST_P(HeightQueryTest, ABareSpheresNormalIsUp) {
  HeightQuery flat = query(3, [](const geo::Direction&) { return 250.0; });
  for (const geo::Direction& place : places()) {
    const auto answer = flat.at(place, {.withNormals = true});
    ASSERT_TRUE(answer.has_value() && answer->has_value());
    EXPECT_EQ((*answer)->height_m, 250.0);
    EXPECT_EQ((*answer)->level, 3);
    EXPECT_NEAR((*answer)->normal_enu.x, 0.0, 1e-5);
    EXPECT_NEAR((*answer)->normal_enu.y, 0.0, 1e-5);
    EXPECT_NEAR((*answer)->normal_enu.z, 1.0, 1e-9);
  }
}

/// A slope that is known: the height grows with z, so the ground falls to the north by dh/dlat = k cos(lat).
TEST_P(HeightQueryTest, NormalLeansAwayFromTheSlope) {
  const double k = 400000.0;
  HeightQuery slope = query(5, [k](const geo::Direction& d) { return k * d.n.z; });
  const double radius = geo::moon().ellipsoid.semiMajorAxis_m();
  for (const geo::Direction& place : places()) {
    const auto answer = slope.at(place, {.withNormals = true});
    ASSERT_TRUE(answer.has_value() && answer->has_value());
    const double height = k * place.n.z;
    const double gradient = k * std::sqrt(1 - place.n.z * place.n.z) / (radius + height);  // to the north
    const double length = std::hypot(gradient, 1.0);
    EXPECT_NEAR((*answer)->height_m, height, 20.0);
    EXPECT_NEAR((*answer)->normal_enu.x, 0.0, 2e-3);
    EXPECT_NEAR((*answer)->normal_enu.y, -gradient / length, 2e-3);
    EXPECT_NEAR((*answer)->normal_enu.z, 1.0 / length, 2e-3);
  }
}

TEST_P(HeightQueryTest, LevelLimitsTheDepth) {
  HeightQuery deep = query(6, [](const geo::Direction& d) { return 1000.0 * std::sin(40.0 * d.n.x); });
  for (int level = 0; level <= 8; ++level) {
    const auto answer = deep.at(geo::directionFromDegrees(12.3, 45.6), {.level = level});
    ASSERT_TRUE(answer.has_value() && answer->has_value());
    EXPECT_EQ((*answer)->level, std::min(level, 6));
  }
}

TEST_P(HeightQueryTest, NoDataWhereTheNearestSampleHasNone) {
  HeightQuery half = query(2, [](const geo::Direction& d) { return d.n.y > 0.3 ? std::nan("") : 7.0; });
  int missing = 0;
  for (const geo::Direction& place : places()) {
    const auto answer = half.at(place);
    ASSERT_TRUE(answer.has_value());
    EXPECT_FALSE(place.n.y > 0.32 && answer->has_value());
    if (place.n.y > 0.28) {
      missing += answer->has_value() ? 0 : 1;
      continue;
    }
    ASSERT_TRUE(answer->has_value());
    EXPECT_EQ((*answer)->height_m, 7.0);
  }
  EXPECT_GT(missing, 0);
}

TEST_P(HeightQueryTest, ASmallCacheGivesTheSameAnswers) {
  const auto height = [](const geo::Direction& d) { return 500.0 * d.n.x * d.n.y + 100.0 * std::cos(30.0 * d.n.z); };
  HeightQuery wide = query(4, height);
  HeightQuery narrow = query(4, height, 1);
  for (const geo::Direction& place : places()) {
    const auto a = wide.at(place);
    const auto b = narrow.at(place);
    ASSERT_TRUE(a.has_value() && b.has_value() && a->has_value() && b->has_value());
    EXPECT_EQ((*a)->height_m, (*b)->height_m);
  }
}

TEST_P(HeightQueryTest, NaNInNothingOut) {
  HeightQuery flat = query(1, [](const geo::Direction&) { return 1.0; });
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto answer = flat.at(geo::Direction{{nan, 0.0, 1.0}});
  ASSERT_TRUE(answer.has_value());
  EXPECT_FALSE(answer->has_value());
}

TEST(HeightQueryKind, ImageryIsRefused) {
  TemporaryFolder folder;
  writeColour(folder / "c.tif", degreesGrid(0, 0, 9, 9, 9, 9), [](int, int) { return raster::Rgba8{1, 2, 3, 255}; });
  BuildOptions options;
  options.output = folder / "c.tdb";
  options.inputs = {(folder / "c.tif").string()};
  options.kind = raster::Kind::imagery;
  const auto reader = builtPyramid(options);
  ASSERT_NE(reader, nullptr);
  EXPECT_FALSE(HeightQuery::create(reader).has_value());
}

INSTANTIATE_TEST_SUITE_P(Tilings, HeightQueryTest, ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion::pyramid::testing
