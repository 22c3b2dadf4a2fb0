#include <fmt/format.h>
#include <gtest/gtest.h>

#include "raster/grid_fixture_test.h"
#include "raster/image_file.h"
#include "raster/live_raster.h"

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

/// Roots are read on level 2; level 0 is two small images, which all roots together are made of.
TEST_P(GridTiles, AnOverviewIsAllRootsOutOfTheCoarsestLevel) {
  const ScratchFolder folder;
  auto service = lonLatService(4, 32);
  service.kind = Kind::imagery;
  writeImages(service, folder, [](const GridImageId& id) { return id.level == 0; });
  const auto overview = sourceOrDie(service, GetParam())->overview();
  ASSERT_NE(overview, nullptr);
  EXPECT_EQ(overview->info().maxLevel, 0);
  double worst = 0.0;
  for (int root = 0; root < tiling_.rootCount(); ++root) {
    const tiling::TileId id{.level = 0, .root = static_cast<std::uint8_t>(root)};
    const auto tile = overview->load(id);
    ASSERT_TRUE(tile && *tile) << root;
    EXPECT_EQ((*tile)->childMask, 0);
    forEachPlace(tiling_, id, Kind::imagery, kCells, [&](int column, int row, const geo::Direction& place) {
      const Rgba8 p = std::get<ImageryTile>((*tile)->payload).pixels.at(column, row);
      ASSERT_EQ(p.a, 255);
      worst = std::max(worst, largestDifference(p, smoothColour(place)));
    });
  }
  EXPECT_LT(worst, 6.0) << "pixels of 5.6 degrees, bilinear";
  // Where roots are read on the coarsest level themselves there is no cheaper look.
  auto coarse = lonLatService(3, 64);
  coarse.kind = Kind::imagery;
  writeImages(coarse, folder, [](const GridImageId&) { return false; });
  EXPECT_EQ(sourceOrDie(coarse, GetParam(), {.tileCells = 16})->overview(), nullptr);
}

/// Tiles of 90 degrees, as World Wind's, of fewer pixels: eight images in place of the 32 or more that roots read. Of
/// 36 degrees they are too many to be seen before the roots.
TEST_P(GridTiles, AnOverviewMayHaveSeveralImagesWhereRootsNeedFarMore) {
  const ScratchFolder folder;
  for (const int columns : {4, 10}) {
    GridService service{.name = fmt::format("world {}", columns),
                        .kind = Kind::imagery,
                        .levels = halvingLevels(-180.0, 90.0, 360.0 / columns, columns, columns / 2, 16, 4)};
    writeImages(service, folder, [](const GridImageId& id) { return id.level == 0; });
    const auto overview = sourceOrDie(service, GetParam())->overview();
    ASSERT_EQ(overview != nullptr, columns == 4);
    if (!overview) continue;
    for (int root = 0; root < tiling_.rootCount(); ++root) {
      const auto tile = overview->load({.level = 0, .root = static_cast<std::uint8_t>(root)});
      ASSERT_TRUE(tile && *tile) << root;
    }
  }
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

/// Real images of a map server (JPEG, rows from the south), against one raster put together of them.
TEST_P(GridTiles, OfARealTreeAreItsPicture) {
  const std::filesystem::path tree = TELLURION_SHARED_DATA_DIR "/earth/naturalearth2_tms";
  if (!std::filesystem::exists(tree)) GTEST_SKIP() << "no data beside the project";
  const ScratchFolder folder;
  auto service = lonLatService(3, 256);
  service.kind = Kind::imagery;
  const auto pathOf = [tree](const GridImageId& id) {
    const std::int64_t row = (std::int64_t{1} << id.level) - 1 - id.row;
    return (tree / std::to_string(id.level) / std::to_string(id.column) / (std::to_string(row) + ".jpg")).string();
  };
  service.request = [pathOf](const GridImageId& id) {
    return io::ResourceRequest{
        .url = "file://" + std::filesystem::canonical(pathOf(id)).string(), .dataset = "", .check = {}};
  };
  Raster<Rgba8> whole(2048, 1024);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 8; ++column) {
      const auto image = readImageFile(pathOf({2, column, row})).value();
      for (int r = 0; r < 256; ++r)
        std::copy_n(image.row(r).begin(), 256, &whole.at(column * 256, row * 256 + r));
    }
  }
  MadeRaster made{.width = 2048,
                  .height = 1024,
                  .type = GDT_Byte,
                  .bands = 3,
                  .transform = {-180, 360.0 / 2048, 0, 90, 0, -360.0 / 2048}};
  made.value = [&](int band, int col, int row) {
    const Rgba8 p = whole.at(col, row);
    return static_cast<double>(band == 1 ? p.r : band == 2 ? p.g : p.b);
  };
  made.options = {"PHOTOMETRIC=RGB"};
  makeRaster(folder.file("same.tif"), made);
  const auto live = liveRaster(folder.file("same.tif"), Kind::imagery, GetParam()).value();
  const auto source = sourceOrDie(service, GetParam(), {.tileCells = 0});
  auto random = geo::seededGenerator();
  for (const tiling::TileId& id : someTiles(random, source->info().maxLevel)) {
    const auto mine = source->load(id);
    ASSERT_TRUE(mine) << io::describe(mine.error());
    const auto theirs = live->load(id).value();
    if (!*mine || !theirs) continue;
    const auto& a = std::get<ImageryTile>((*mine)->payload).pixels;
    const auto& b = std::get<ImageryTile>(theirs->payload).pixels;
    double sum = 0.0;
    for (std::size_t i = 0; i < a.samples.size(); ++i) {
      const Rgba8& p = a.samples[i];
      const Rgba8& q = b.samples[i];
      sum += std::abs(p.r - q.r) + std::abs(p.g - q.g) + std::abs(p.b - q.b);
    }
    // The server's coarser images are its own reductions of the finest, sharper than a mean.
    const double most = id.level == source->info().maxLevel ? 1.5 : 5.0;
    EXPECT_LT(sum / (3.0 * static_cast<double>(a.samples.size())), most) << "level " << int{id.level};
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

/// From a root to a place, by what each tile says of its children; the last tile that there is.
std::optional<SourceTile> deepestTile(const TileSource& source, const geo::Direction& place) {
  const tiling::Tiling tiling(source.info().scheme);
  std::optional<SourceTile> deepest;
  for (int level = 0; level <= source.info().maxLevel; ++level) {
    const tiling::TileId id = tiling.tileAt(place, level);
    if (deepest && ((deepest->childMask >> id.quadrant()) & 1) == 0) return deepest;
    auto tile = source.load(id).value();
    if (!tile) return deepest;
    deepest = std::move(tile);
  }
  return deepest;
}

TEST_P(GridTiles, LeadDownToWhatIsSmallOrBeginsFine) {
  const ScratchFolder folder;
  const geo::Direction place = geo::directionFromDegrees(44.6, 10.4);
  GridService small{.name = "small", .kind = Kind::imagery, .levels = halvingLevels(10.0, 45.0, 1.0, 1, 1, 64, 3)};
  small.bounds = geo::GeoRect::fromDegrees(44.0, 10.0, 45.0, 11.0);
  GridService fine{.name = "fine", .kind = Kind::imagery, .levels = halvingLevels(-180.0, 90.0, 1.0, 360, 180, 64, 3)};
  for (GridService service : {small, fine}) {
    writeImages(service, folder, [&](const GridImageId& id) {
      const std::int64_t times = std::int64_t{1} << id.level;
      return service.name == "small" || (id.column / times / 10 == 19 && id.row / times / 10 == 4);
    });
    const auto source = sourceOrDie(service, GetParam());
    const auto tile = deepestTile(*source, place);
    ASSERT_TRUE(tile);
    EXPECT_EQ(tile->childMask, 0);
    const auto& pixels = std::get<ImageryTile>(tile->payload).pixels.samples;
    EXPECT_TRUE(std::ranges::any_of(pixels, [](const Rgba8& p) { return p.a == 255; })) << service.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Tilings, GridTiles, ::testing::ValuesIn(kSchemes),
                         [](const auto& each) { return std::string(tiling::nameOf(each.param)); });

}  // namespace
}  // namespace tellurion::raster
