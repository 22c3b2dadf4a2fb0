// Answers of queries where tiles meet: edges and corners, faces, and tiles of other depths; batches and threads beside
// single questions; the error bound; nearest samples and colours beside the stored tiles themselves.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <thread>

#include "geo/seed_test.h"
#include "pyramid/colour_query.h"
#include "pyramid/synthetic_rasters_test.h"

namespace tellurion::pyramid::testing {
namespace {

using tiling::Scheme;
using tiling::TileId;

geo::Direction anywhere(std::mt19937_64& random) {
  const double z = geo::uniform(random, -1.0, 1.0);
  return geo::directionFromDegrees(std::asin(z) * 180.0 / geo::kPi, geo::uniform(random, -180.0, 180.0));
}

/// A place that is `step` radians from another, this way or that.
geo::Direction moved(const geo::Direction& d, const geo::Vec3& way, double step) {
  return {geo::normalize(d.n + way * step)};
}

/// The globe at 2 degrees, a part of it at 1/4 degree that crosses the borders of faces of every tiling, and a smaller
/// one at 1/16: tiles of three depths side by side.
class QueryJoins : public ::testing::TestWithParam<Scheme> {
 protected:
  static std::shared_ptr<const PyramidReader> build(const TemporaryFolder& folder, Scheme scheme) {
    const auto write = [&](const char* name, double west, double south, double east, double north, double degrees) {
      const int width = static_cast<int>((east - west) / degrees);
      const int height = static_cast<int>((north - south) / degrees);
      writeElevation(folder / name, degreesGrid(west, south, east, north, width, height), [=](int column, int row) {
        const double lat = north - (row + 0.5) * degrees;
        const double lon = west + (column + 0.5) * degrees;
        return hills(lat, lon) + 300.0 * std::sin(lat * 9.0) * std::cos(lon * 7.0);
      });
      return (folder / name).string();
    };
    BuildOptions options{
        .output = folder / "joins.tdb",
        .inputs = {write("globe.tif", -180, -90, 180, 90, 2.0), write("part.tif", 20, 10, 70, 60, 0.25),
                   write("small.tif", 41, 30, 49, 47, 0.0625)},
        .kind = raster::Kind::elevation,
        .scheme = scheme};
    return builtPyramid(options);
  }
  /// Made by the first test that asks: to build takes longer than most tests here.
  static std::shared_ptr<const PyramidReader> database(Scheme scheme) {
    struct Made {
      TemporaryFolder folder;
      std::shared_ptr<const PyramidReader> reader;
    };
    static std::map<Scheme, Made> made;
    Made& of = made[scheme];
    if (!of.reader) of.reader = build(of.folder, scheme);
    return of.reader;
  }
  void SetUp() override {
    reader_ = database(GetParam());
    ASSERT_NE(reader_, nullptr);
    query_ = std::make_unique<HeightQuery>(std::move(*HeightQuery::create(reader_)));
    tiles_ = storedTiles(*reader_);
  }
  HeightAnswer answer(const geo::Direction& d, const HeightQuestion& question = {}) const {
    const auto found = query_->at(d, question);
    EXPECT_TRUE(found && *found);
    return found && *found ? **found : HeightAnswer{};
  }

  std::shared_ptr<const PyramidReader> reader_;
  std::unique_ptr<HeightQuery> query_;
  std::vector<TileId> tiles_;
  tiling::Tiling tiling_{GetParam()};
  std::mt19937_64 random_ = geo::seededGenerator();
};

// Across every border of tiles, at the finest and at each level. The steepest ground here falls by 3 m a metre, so
// 1e-12 of a turn (6 micrometres) tell a step from a slope.
TEST_P(QueryJoins, NoStepWhereTilesMeet) {
  constexpr double kStep = 1e-12;
  constexpr double kSlack_m = 1e-3;  // rounding of heights to float32, and the slope
  int acrossDepths = 0;
  for (int i = 0; i < 20000; ++i) {
    const TileId id = tiles_[random_() % tiles_.size()];
    const double along = i % 3 == 0 ? static_cast<double>(random_() % 2) : geo::uniform(random_, 0.0, 1.0);
    const std::array<tiling::RootPoint, 4> borders{
        tiling::rootPointIn(id, along, 0.0), tiling::rootPointIn(id, along, 1.0), tiling::rootPointIn(id, 0.0, along),
        tiling::rootPointIn(id, 1.0, along)};
    const geo::Direction border = tiling_.direction(borders[random_() % 4]);
    const geo::Vec3 way = geo::normalize(geo::cross(border.n, anywhere(random_).n));
    const HeightQuestion question{.level = i % 2 == 0 ? std::optional<int>() : std::optional<int>(id.level)};
    const HeightAnswer here = answer(border, question);
    const HeightAnswer there = answer(moved(border, way, kStep), question);
    const HeightAnswer beyond = answer(moved(border, way, -kStep), question);
    acrossDepths += there.level != beyond.level ? 1 : 0;
    ASSERT_NEAR(here.height_m, there.height_m, kSlack_m) << here.level << " " << there.level << " step " << i;
    ASSERT_NEAR(here.height_m, beyond.height_m, kSlack_m) << here.level << " " << beyond.level << " step " << i;
  }
  EXPECT_GT(acrossDepths, 200);
}

TEST_P(QueryJoins, TheErrorBoundHoldsAtEveryLevelAndSamplingForTheFinest) {
  int sharp = 0;
  for (int i = 0; i < 20000; ++i) {
    const geo::Direction d =
        i % 2 == 0 ? anywhere(random_)
                   : geo::directionFromDegrees(geo::uniform(random_, 8, 62), geo::uniform(random_, 18, 72));
    const HeightAnswer finest = answer(d);
    EXPECT_FALSE(finest.hasFiner);
    for (const Sampling sampling : {Sampling::bilinear, Sampling::nearest}) {
      const HeightAnswer coarse = answer(d, {.level = i % (finest.level + 1), .sampling = sampling});
      ASSERT_EQ(coarse.level, i % (finest.level + 1));
      ASSERT_EQ(coarse.hasFiner, coarse.level < finest.level);
      const double off = std::abs(coarse.height_m - finest.height_m);
      ASSERT_LE(off, coarse.errorBound_m + finest.errorBound_m + 2e-3) << coarse.level << " of " << finest.level;
      sharp += off > 0.3 * coarse.errorBound_m && coarse.errorBound_m > 1.0 ? 1 : 0;
    }
  }
  EXPECT_GT(sharp, 100);  // the bound is no empty one
}

TEST_P(QueryJoins, SpacingIsTheLevels) {
  const geo::Direction d = geo::directionFromDegrees(40.0, 45.0);
  for (int level = 0; level < reader_->info().maxLevel; ++level) {
    const double coarse = answer(d, {.level = level}).spacing_m;
    EXPECT_NEAR(coarse, 2.0 * answer(d, {.level = level + 1}).spacing_m, 1e-6 * coarse);
    // A square of as much ground as a tile has on average.
    const double radius_m = 6371e3;
    const double tiles = tiling_.rootCount() * std::exp2(2 * level);
    EXPECT_NEAR(coarse, radius_m * std::sqrt(4.0 * geo::kPi / tiles) / 64.0, 1e-3 * coarse);
  }
}

// Brute force: the stored tile that is deepest over a place, its samples, and the one that is nearest.
TEST_P(QueryJoins, NearestIsTheStoredSample) {
  for (int i = 0; i < 3000; ++i) {
    const geo::Direction d = anywhere(random_);
    const HeightAnswer found = answer(d, {.sampling = Sampling::nearest});
    const tiling::RootPoint p = tiling_.rootPoint(d);
    TileId deepest{};
    for (const TileId& id : tiles_) {
      const TileId over = tiling_.tileAt(d, id.level);
      if (over == id && id.level >= deepest.level) deepest = id;
    }
    ASSERT_EQ(found.level, deepest.level);
    const double scale = std::exp2(deepest.level);
    const auto column = static_cast<int>(std::lround((p.u * scale - deepest.x) * 64.0));
    const auto row = static_cast<int>(std::lround((p.v * scale - deepest.y) * 64.0));
    ASSERT_EQ(found.height_m, static_cast<double>(heightsOf(loaded(*reader_, deepest)).at(column + 1, row + 1)));
  }
}

TEST_P(QueryJoins, BatchesAndThreadsAnswerTheSame) {
  std::vector<geo::Direction> places;
  for (int i = 0; i < 20000; ++i)
    places.push_back(i % 100 == 7 ? places.back() : anywhere(random_));
  places[17].n.x = std::nan("");
  const HeightQuestion question{.withNormals = true};
  std::vector<std::optional<HeightAnswer>> alone(places.size());
  for (std::size_t i = 0; i < places.size(); ++i)
    alone[i] = *query_->at(places[i], question);
  EXPECT_FALSE(alone[17]);
  const auto isSame = [](const std::optional<HeightAnswer>& a, const std::optional<HeightAnswer>& b) {
    return a.has_value() == b.has_value() &&
           (!a || (a->height_m == b->height_m && a->normal_enu == b->normal_enu && a->level == b->level &&
                   a->errorBound_m == b->errorBound_m && a->hasFiner == b->hasFiner));
  };
  // A cache of some ten tiles, so that threads evict each other's.
  const auto small = HeightQuery::create(reader_, 300'000);
  ASSERT_TRUE(small);
  std::vector<std::size_t> wrong(4, places.size());
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < wrong.size(); ++t) {
      threads.emplace_back([&, t] {
        std::size_t off = 0;
        if (t % 2 == 0) {
          std::vector<std::optional<HeightAnswer>> answers(places.size());
          if (!small->at(places, answers, question)) return;
          for (std::size_t i = 0; i < places.size(); ++i)
            off += isSame(answers[i], alone[i]) ? 0u : 1u;
        } else {
          for (std::size_t i = t; i < places.size(); i += 11) {
            const auto found = small->at(places[i], question);
            off += found && isSame(*found, alone[i]) ? 0u : 1u;
          }
        }
        wrong[t] = off;
      });
    }
  }
  EXPECT_EQ(wrong, std::vector<std::size_t>(4, 0));
  std::vector<std::optional<HeightAnswer>> none;
  EXPECT_TRUE(query_->at(std::span<const geo::Direction>{}, none));
}

INSTANTIATE_TEST_SUITE_P(Tilings, QueryJoins, ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

class ColourQueries : public ::testing::TestWithParam<Scheme> {};

TEST_P(ColourQueries, AreThePixelsOfTheDeepestTile) {
  const TemporaryFolder folder;
  writeColour(folder / "c.tif", degreesGrid(-30, 20, 60, 60, 720, 320), [](int column, int row) {
    const bool isBare = column % 90 < 9;
    return raster::Rgba8{static_cast<std::uint8_t>(column % 251), static_cast<std::uint8_t>(row % 241), 77,
                         static_cast<std::uint8_t>(isBare ? 0 : 255)};
  });
  const BuildOptions options{.output = folder / "c.tdb",
                             .inputs = {(folder / "c.tif").string()},
                             .kind = raster::Kind::imagery,
                             .scheme = GetParam()};
  const auto reader = builtPyramid(options);
  ASSERT_NE(reader, nullptr);
  EXPECT_FALSE(HeightQuery::create(reader));
  const auto query = ColourQuery::create(reader);
  ASSERT_TRUE(query);
  const tiling::Tiling tiling(GetParam());
  auto random = geo::seededGenerator();
  std::vector<geo::Direction> places;
  for (int i = 0; i < 3000; ++i)
    places.push_back(geo::directionFromDegrees(geo::uniform(random, 15.0, 65.0), geo::uniform(random, -35.0, 65.0)));
  std::vector<std::optional<ColourAnswer>> nearest(places.size());
  ASSERT_TRUE(query->at(places, nearest, {.sampling = Sampling::nearest}));
  int covered = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const TileId id = tiling.tileAt(places[i], reader->info().maxLevel);
    const auto tile = reader->load(id);
    ASSERT_TRUE(tile);
    if (!nearest[i]) continue;
    ++covered;
    ASSERT_TRUE(*tile);
    const auto& pixels = pixelsOf(**tile);
    const int size = pixels.width - 2;
    const tiling::RootPoint p = tiling.rootPoint(places[i]);
    const double scale = std::exp2(id.level);
    const int column = 1 + static_cast<int>((p.u * scale - id.x) * size);
    const int row = 1 + static_cast<int>((p.v * scale - id.y) * size);
    ASSERT_EQ(nearest[i]->colour, pixels.at(column, row));
    ASSERT_EQ(nearest[i]->level, id.level);
    // Between the centres of pixels, so within what the pixels around have.
    const auto between = query->at(places[i]);
    ASSERT_TRUE(between);
    if (!*between) continue;
    int least = 255;
    int most = 0;
    for (int k = 0; k < 9; ++k) {
      const raster::Rgba8 around = pixels.at(column - 1 + k % 3, row - 1 + k / 3);
      if (around.a == 0) continue;
      least = std::min<int>(least, around.r);
      most = std::max<int>(most, around.r);
    }
    ASSERT_GE((*between)->colour.r, least);
    ASSERT_LE((*between)->colour.r, most);
  }
  EXPECT_GT(covered, 1500);
  EXPECT_LT(covered, 2800);
  EXPECT_FALSE(*query->at(geo::directionFromDegrees(-45.0, 100.0)));
}

INSTANTIATE_TEST_SUITE_P(Tilings, ColourQueries, ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

TEST(ColourQueryKind, ElevationIsRefused) {
  const TemporaryFolder folder;
  writeElevation(folder / "h.tif", degreesGrid(0, 0, 9, 9, 9, 9), [](int, int) { return 1.0; });
  const BuildOptions options{
      .output = folder / "h.tdb", .inputs = {(folder / "h.tif").string()}, .kind = raster::Kind::elevation};
  const auto reader = builtPyramid(options);
  ASSERT_NE(reader, nullptr);
  EXPECT_FALSE(ColourQuery::create(reader));
}

}  // namespace
}  // namespace tellurion::pyramid::testing
