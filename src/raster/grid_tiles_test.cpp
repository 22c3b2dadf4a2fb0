#include <gtest/gtest.h>

#include "raster/grid_fixture_test.h"

namespace tellurion::raster {
namespace {

using namespace testing;

constexpr int kCells = 64;
constexpr std::array kSchemes{tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix};

class GridTiles : public ::testing::TestWithParam<tiling::Scheme> {
 protected:
  tiling::Tiling tiling_{GetParam()};

  /// Tiles with a pole, the date line or nothing much in them.
  std::vector<tiling::TileId> someTiles(std::mt19937_64& random, int deepest) const {
    std::vector<tiling::TileId> ids;
    for (int level = 0; level <= deepest; ++level) {
      for (const double lat : {90.0, -90.0, 89.0, -85.1, 40.0, 0.0})
        ids.push_back(tiling_.tileAt(geo::directionFromDegrees(lat, 180.0 - 1e-6), level));
      for (int i = 0; i < 4; ++i)
        ids.push_back(randomTile(random, tiling_, level));
    }
    return ids;
  }

  /// Every sample of tiles against the function; places without data only where `hasData` says so.
  void expectPicture(const TileSource& source, int deepest, const std::function<bool(const geo::Direction&)>& hasData) {
    auto random = geo::seededGenerator();
    double worst = 0.0;
    int compared = 0;
    for (const tiling::TileId& id : someTiles(random, deepest)) {
      const auto tile = source.load(id);
      ASSERT_TRUE(tile) << io::describe(tile.error());
      if (!tile->has_value()) continue;
      const auto& pixels = std::get<ImageryTile>((*tile)->payload).pixels;
      forEachPlace(tiling_, id, Kind::imagery, kCells, [&](int column, int row, const geo::Direction& place) {
        const Rgba8 p = pixels.at(column, row);
        if (p.a == 0) {
          EXPECT_FALSE(hasData(place)) << "level " << int{id.level} << " root " << int{id.root} << " " << id.x << ", "
                                       << id.y << " at " << column << ", " << row;
          return;
        }
        ++compared;
        // On a rim the mean is of the covered side alone.
        const double share = p.a == 255 ? 1.0 : 0.5;
        worst = std::max(worst, share * largestDifference(p, smoothColour(place)));
      });
      if (HasFailure()) return;
    }
    EXPECT_LT(worst, 1.5);
    EXPECT_GT(compared, 25000);
  }
};

TEST_P(GridTiles, LonLatIsThePicture) {
  const ScratchFolder folder;
  auto service = lonLatService(4, 60);
  service.kind = Kind::imagery;
  writeImages(service, folder);
  const auto source = sourceOrDie(service, GetParam());
  expectPicture(*source, source->info().maxLevel, [](const geo::Direction&) { return true; });
}

TEST_P(GridTiles, MercatorIsThePictureToItsLastLatitude) {
  const ScratchFolder folder;
  auto service = mercatorService(5);
  service.kind = Kind::imagery;
  writeImages(service, folder);
  const auto source = sourceOrDie(service, GetParam());
  expectPicture(*source, 4, [](const geo::Direction& d) { return std::abs(d.n.z) < std::tanh(geo::kPi) - 1e-6; });
}

TEST_P(GridTiles, AnyOtherPlaneIsThePicture) {
  const ScratchFolder folder;
  auto service = polarService(4);
  service.kind = Kind::imagery;
  service.bounds = geo::GeoRect::fromDegrees(-90.0, -180.0, -60.0, 180.0);
  writeImages(service, folder);
  const auto source = sourceOrDie(service, GetParam());
  expectPicture(*source, 5, [](const geo::Direction& d) { return d.n.z < -std::cos(25.0 * geo::kPi / 180.0); });
}

TEST_P(GridTiles, AreWhatTheSameRasterGivesAsAFile) {
  const ScratchFolder folder;
  auto service = lonLatService(4);
  service.kind = Kind::imagery;
  writeImages(service, folder);
  MadeRaster made{.width = 1024,
                  .height = 512,
                  .type = GDT_Byte,
                  .bands = 3,
                  .transform = {-180, 360.0 / 1024, 0, 90, 0, -360.0 / 1024}};
  made.value = [](int band, int col, int row) {
    const double lat = 90.0 - (row + 0.5) * 180.0 / 512;
    const double lon = -180.0 + (col + 0.5) * 360.0 / 1024;
    const Rgba8 p = pixelOf(smoothColour(geo::directionFromDegrees(lat, lon)));
    return static_cast<double>(band == 1 ? p.r : band == 2 ? p.g : p.b);
  };
  made.options = {"PHOTOMETRIC=RGB"};
  makeRaster(folder.file("same.tif"), made);
  auto file = openOrDie(folder.file("same.tif"), Kind::imagery);
  const auto source = sourceOrDie(service, GetParam());
  auto random = geo::seededGenerator();
  for (const tiling::TileId& id : someTiles(random, source->info().maxLevel)) {
    const auto tile = source->load(id).value();
    if (!tile) continue;
    const auto& pixels = std::get<ImageryTile>(tile->payload).pixels;
    std::vector<geo::Direction> places;
    std::vector<Rgba8> mine;
    forEachPlace(tiling_, id, Kind::imagery, kCells, [&](int column, int row, const geo::Direction& place) {
      places.push_back(place);
      mine.push_back(pixels.at(column, row));
    });
    std::vector<Rgba8> theirs(places.size());
    const geo::Angle spacing = tiling_.metrics(id.level).meanEdge / kCells;
    ASSERT_TRUE(file.sampleColours(places, spacing > file.info().finestSpacing ? spacing : geo::Angle(), theirs));
    for (std::size_t i = 0; i < places.size(); ++i) {
      EXPECT_NEAR(mine[i].r, theirs[i].r, 3) << i;
      EXPECT_NEAR(mine[i].g, theirs[i].g, 3) << i;
      EXPECT_NEAR(mine[i].b, theirs[i].b, 3) << i;
      EXPECT_EQ(theirs[i].a, mine[i].a);
    }
    if (HasFailure()) return;
  }
}

/// The sample `along` an edge, gutter not counted.
float onEdge(const Raster<float>& samples, tiling::Edge edge, int along) {
  switch (edge) {
    case tiling::Edge::top:
      return samples.at(along + 1, 1);
    case tiling::Edge::right:
      return samples.at(kCells + 1, along + 1);
    case tiling::Edge::bottom:
      return samples.at(along + 1, kCells + 1);
    case tiling::Edge::left:
      return samples.at(1, along + 1);
  }
  return kNoData;
}

TEST_P(GridTiles, HeightsAreTheSurfaceAndNeighboursShareTheirEdges) {
  const ScratchFolder folder;
  for (GridService service : {lonLatService(4), mercatorService(4), polarService(3)}) {
    service.kind = Kind::elevation;
    // A part is missing on finer levels, so that edges run between what two levels give.
    writeImages(service, folder, [](const GridImageId& id) { return id.level < 3 || (id.column + id.row) % 3 != 0; });
    const auto source = sourceOrDie(service, GetParam());
    double worst = 0.0;
    auto random = geo::seededGenerator();
    for (const tiling::TileId& id : someTiles(random, 3)) {
      const auto tile = source->load(id);
      ASSERT_TRUE(tile) << io::describe(tile.error());
      if (!*tile) continue;
      const auto& samples = std::get<ElevationTile>((*tile)->payload).samples;
      forEachPlace(tiling_, id, Kind::elevation, kCells, [&](int column, int row, const geo::Direction& place) {
        const float height = samples.at(column, row);
        const bool isInside = column > 0 && row > 0 && column + 1 < samples.width && row + 1 < samples.height;
        // On a rim a mean is of the side with data alone.
        if (isInside && !isNoData(height + samples.at(column - 1, row) + samples.at(column + 1, row) +
                                  samples.at(column, row - 1) + samples.at(column, row + 1))) {
          worst = std::max(worst, std::abs(static_cast<double>(height) - smoothHeight_m(place)) * (1 << id.level));
        }
      });
      for (const tiling::Edge edge : tiling::kEdges) {
        const auto across = tiling_.edgeNeighbour(id, edge);
        const auto beyond = source->load(across.tile).value();
        if (!beyond) continue;
        const auto& theirs = std::get<ElevationTile>(beyond->payload).samples;
        for (int i = 0; i <= kCells; ++i) {
          const float a = onEdge(samples, edge, i);
          const float b = onEdge(theirs, across.edge, across.reversed ? kCells - i : i);
          EXPECT_EQ(std::bit_cast<std::uint32_t>(a), std::bit_cast<std::uint32_t>(b)) << service.name << " " << i;
        }
      }
      if (HasFailure()) return;
    }
    // Pixels of 2 degrees are off a wave of 90 by that much, those of the next level by less than half.
    EXPECT_LT(worst, 20.0) << service.name;
  }
}

TEST_P(GridTiles, PresenceIsATreeThatLoadsKeep) {
  const ScratchFolder folder;
  auto service = mercatorService(3);
  service.kind = Kind::imagery;
  service.bounds = geo::GeoRect::fromDegrees(-30.0, 150.0, 70.0, -150.0);
  writeImages(service, folder);
  const auto source = sourceOrDie(service, GetParam());
  auto random = geo::seededGenerator();
  int stored = 0;
  for (int i = 0; i < 1000; ++i) {
    const auto id = randomTile(random, tiling_, 1 + static_cast<int>(random() % 6));
    const TilePresence own = *source->presence(id);
    const TilePresence above = *source->presence(id.parent());
    EXPECT_EQ(own.stored, above.stored && ((above.childMask >> id.quadrant()) & 1) != 0);
    if (id.level > source->info().maxLevel) {
      EXPECT_FALSE(own.stored);
    }
    if (!own.stored) {
      EXPECT_EQ(own.childMask, 0);
      EXPECT_FALSE(source->load(id).value().has_value());
    } else {
      ++stored;
      EXPECT_TRUE(service.bounds.intersects(tiling_.bounds(id)));
    }
  }
  EXPECT_GT(stored, 10);
  for (int root = 0; root < tiling_.rootCount(); ++root) {
    const tiling::TileId id{.root = static_cast<std::uint8_t>(root)};
    EXPECT_TRUE(source->presence(id)->stored);
    EXPECT_TRUE(source->load(id).value().has_value());
  }
}

INSTANTIATE_TEST_SUITE_P(Tilings, GridTiles, ::testing::ValuesIn(kSchemes),
                         [](const auto& each) { return std::string(tiling::nameOf(each.param)); });

}  // namespace
}  // namespace tellurion::raster
