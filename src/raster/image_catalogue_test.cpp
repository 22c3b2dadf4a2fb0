#include "raster/image_catalogue.h"

#include <gtest/gtest.h>

#include <fstream>

#include "geo/seed_test.h"
#include "raster/grid_fixture_test.h"
#include "raster/live_raster.h"

namespace tellurion::raster {
namespace {

using namespace testing;

constexpr int kCells = 64;
constexpr std::array kSchemes{tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix};

/// An image of one colour, 64 x 64 pixels, its number in its colour.
struct FlatImage {
  double west, north, side;
  Rgba8 colour;
  bool holds(double lat, double lon, double rim) const {
    return lon > west + rim && lon < west + side - rim && lat < north - rim && lat > north - side + rim;
  }
};

std::vector<FlatImage> someImages(std::mt19937_64& random, int count) {
  std::vector<FlatImage> images;
  for (int i = 0; i < count; ++i) {
    // No two of a size; some inside others.
    const double side = 60.0 * std::pow(0.6, i);
    const double within = std::min(side * 4.0, 120.0);
    const double west = i < 4 ? geo::uniform(random, -170.0, 100.0) : images[static_cast<std::size_t>(i) - 3].west;
    const double north = i < 4 ? geo::uniform(random, -10.0, 80.0) : images[static_cast<std::size_t>(i) - 3].north;
    const auto byte = [&](int f) { return static_cast<std::uint8_t>((i + 1) * f % 251); };
    images.push_back({west + geo::uniform(random, 0.0, 0.1) * within,
                      north - geo::uniform(random, 0.0, 0.1) * within,
                      side,
                      {byte(7), byte(31), byte(101), 255}});
  }
  return images;
}

void writeImage(const FlatImage& image, const std::string& path) {
  MadeRaster made{.width = 64,
                  .height = 64,
                  .type = GDT_Byte,
                  .bands = 3,
                  .transform = {image.west, image.side / 64, 0, image.north, 0, -image.side / 64}};
  made.options = {"PHOTOMETRIC=RGB"};
  made.value = [&](int band, int, int) {
    return static_cast<double>(band == 1 ? image.colour.r : band == 2 ? image.colour.g : image.colour.b);
  };
  makeRaster(path, made);
}

TEST(ImageCatalogue, TheFinestImageWinsAtEverySample) {
  const ScratchFolder folder;
  auto random = geo::seededGenerator();
  // The last is a metre across, with pixels of two centimetres.
  const auto images = someImages(random, 30);
  std::filesystem::create_directories(folder.file("deep/er"));
  for (std::size_t i = 0; i < images.size(); ++i)
    writeImage(images[i], folder.file((i % 2 == 0 ? "deep/er/" : "") + std::to_string(100 + i) + ".tif"));
  std::ofstream(folder.file("readme")) << "no raster";
  for (const tiling::Scheme scheme : kSchemes) {
    const tiling::Tiling tiling(scheme);
    CatalogueOptions options{.openFiles = 3, .tileCells = kCells};
    const auto catalogue = openCatalogue(folder.file(""), Kind::imagery, scheme, options);
    ASSERT_TRUE(catalogue) << io::describe(catalogue.error());
    EXPECT_EQ(catalogue->images, images.size());
    EXPECT_EQ(catalogue->warnings.size(), 1u);
    int compared = 0;
    for (std::size_t i = 2; i < images.size(); i += 9) {
      const FlatImage& target = images[i];
      const geo::Direction middle =
          geo::directionFromDegrees(target.north - 0.5 * target.side, target.west + 0.5 * target.side);
      for (int level = 0; level <= catalogue->tiles->info().maxLevel; level += 2) {
        const tiling::TileId id = tiling.tileAt(middle, level);
        const auto tile = catalogue->tiles->load(id).value();
        if (!tile) continue;
        const double spacing = tiling.metrics(level).largestEdge.degrees() / kCells;
        const auto& pixels = std::get<ImageryTile>(tile->payload).pixels;
        forEachPlace(tiling, id, Kind::imagery, kCells, [&](int column, int row, const geo::Direction& place) {
          const auto at = geo::geodeticFromDirection(place);
          const double lat = at.lat.degrees();
          const double lon = at.lon.degrees();
          // Brute force over all; samples near a rim of any are left out, and images that are too small may be.
          const double rim = 1.5 * spacing / std::max(0.1, std::cos(at.lat.radians()));
          const FlatImage* finest = nullptr;
          for (const FlatImage& image : images) {
            if (image.side < tiling.metrics(level).meanEdge.degrees() / 8) continue;
            if (image.holds(lat, lon, -rim) != image.holds(lat, lon, rim)) return;
            if (image.holds(lat, lon, 0.0)) finest = &image;
          }
          for (const FlatImage& image : images) {
            if (image.side < tiling.metrics(level).meanEdge.degrees() / 8 && image.holds(lat, lon, -rim)) return;
          }
          EXPECT_EQ(pixels.at(column, row), finest != nullptr ? finest->colour : Rgba8{});
          ++compared;
        });
        if (HasFailure()) return;
      }
    }
    EXPECT_GT(compared, 50000);
  }
}

TEST(ImageCatalogue, ListsAndHeights) {
  const ScratchFolder folder;
  const auto heights = [&](const char* name, double west, double side, double value) {
    MadeRaster made{.width = 32, .height = 32, .transform = {west, side / 32, 0, 10, 0, -side / 32}};
    made.value = [value](int, int col, int) { return col < 4 ? -9999.0 : value; };
    made.tune = [](GDALDataset& d) { d.GetRasterBand(1)->SetNoDataValue(-9999.0); };
    makeRaster(folder.file(name), made);
  };
  heights("wide.tif", 0.0, 20.0, 100.0);
  heights("narrow.tif", 5.0, 5.0, 700.0);
  std::ofstream(folder.file("list.txt")) << "# two models\n  wide.tif \n\nnarrow.tif # the finer\nnone.tif\n";
  const auto catalogue =
      openCatalogue(folder.file("list.txt"), Kind::elevation, tiling::Scheme::cube, {.tileCells = kCells});
  ASSERT_TRUE(catalogue) << io::describe(catalogue.error());
  EXPECT_EQ(catalogue->images, 2u);
  EXPECT_EQ(catalogue->warnings.size(), 1u);
  const tiling::Tiling tiling(tiling::Scheme::cube);
  const auto heightAt = [&](double lat, double lon) {
    const auto place = geo::directionFromDegrees(lat, lon);
    int level = catalogue->tiles->info().maxLevel;
    while (!catalogue->tiles->presence(tiling.tileAt(place, level))->stored)
      --level;
    const auto id = tiling.tileAt(place, level);
    const auto tile = catalogue->tiles->load(id).value();
    const auto point = tiling.rootPoint(place);
    const int column = static_cast<int>((point.u / tiling::tileSize(level) - id.x) * kCells) + 1;
    const int row = static_cast<int>((point.v / tiling::tileSize(level) - id.y) * kCells) + 1;
    return std::get<ElevationTile>(tile->payload).samples.at(column, row);
  };
  EXPECT_EQ(heightAt(8.0, 15.0), 100.0f);
  EXPECT_EQ(heightAt(8.0, 8.0), 700.0f);
  EXPECT_EQ(heightAt(8.0, 5.3), 100.0f);  // The finer one has none there.
}

TEST(ImageCatalogue, NothingInItIsAFailure) {
  const ScratchFolder folder;
  EXPECT_FALSE(openCatalogue(folder.file(""), Kind::imagery, tiling::Scheme::cube));
  EXPECT_FALSE(openCatalogue(folder.file("none"), Kind::imagery, tiling::Scheme::cube));
  std::ofstream(folder.file("list")) << "# empty\n";
  EXPECT_FALSE(openCatalogue(folder.file("list"), Kind::imagery, tiling::Scheme::cube));
}

TEST(LiveRaster, IsTheFileOnAllTilings) {
  const ScratchFolder folder;
  MadeRaster made{.width = 720, .height = 360, .transform = {-180, 0.5, 0, 90, 0, -0.5}};
  made.value = [](int, int col, int row) {
    return smoothHeight_m(geo::directionFromDegrees(90.0 - (row + 0.5) * 0.5, -180.0 + (col + 0.5) * 0.5));
  };
  makeRaster(folder.file("a.tif"), made);
  auto random = geo::seededGenerator();
  for (const tiling::Scheme scheme : kSchemes) {
    const tiling::Tiling tiling(scheme);
    const auto source = liveRaster(folder.file("a.tif"), Kind::elevation, scheme).value();
    EXPECT_TRUE(source->presence(tiling::TileId{})->stored);
    for (int level = 0; level <= source->info().maxLevel; ++level) {
      const auto id = randomTile(random, tiling, level);
      const auto tile = source->load(id).value();
      ASSERT_TRUE(tile);
      EXPECT_EQ(tile->childMask, level < source->info().maxLevel ? 15 : 0);
      EXPECT_EQ(tile->statistics.error_m > 0.0f, level < source->info().maxLevel);
      const auto& samples = std::get<ElevationTile>(tile->payload).samples;
      double worst = 0.0;
      forEachPlace(tiling, id, Kind::elevation, kElevationCells, [&](int column, int row, const geo::Direction& place) {
        worst = std::max(worst, std::abs(static_cast<double>(samples.at(column, row)) - smoothHeight_m(place)));
      });
      EXPECT_LT(worst, 20.0) << "level " << level;
    }
    EXPECT_FALSE(source->load({.level = static_cast<std::uint8_t>(source->info().maxLevel + 1)}).value());
  }
}

/// What the estimate promises and what a finer look finds, on real mountains.
TEST(LiveRaster, EstimatesAreOfTheRightSize) {
  const std::string path = TELLURION_SHARED_DATA_DIR "/earth/srtm3_alps_N46E008.tif";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no data beside the project";
  const tiling::Tiling tiling(tiling::Scheme::cube);
  const auto source = liveRaster(path, Kind::elevation, tiling::Scheme::cube).value();
  const int deepest = source->info().maxLevel;
  auto id = tiling.tileAt(geo::directionFromDegrees(46.5, 8.5), deepest - 3);
  for (; id.level < deepest; id = id.child(0)) {
    const auto tile = source->load(id).value();
    const auto& coarse = std::get<ElevationTile>(tile->payload).samples;
    double worst = 0.0;
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const auto below = source->load(id.child(quadrant)).value();
      const auto& fine = std::get<ElevationTile>(below->payload).samples;
      for (int row = 0; row <= kElevationCells; ++row) {
        for (int column = 0; column <= kElevationCells; ++column) {
          const double x = (quadrant & 1) * kElevationCells / 2 + column / 2.0 + 1.0;
          const double y = (quadrant >> 1) * kElevationCells / 2 + row / 2.0 + 1.0;
          const int c = static_cast<int>(x);
          const int r = static_cast<int>(y);
          const double s = x - c;
          const double t = y - r;
          const auto at = [&](int dc, int dr) { return static_cast<double>(coarse.at(c + dc, r + dr)); };
          const double between =
              (at(0, 0) * (1 - s) + at(1, 0) * s) * (1 - t) + (at(0, 1) * (1 - s) + at(1, 1) * s) * t;
          worst = std::max(worst, std::abs(between - static_cast<double>(fine.at(column + 1, row + 1))));
        }
      }
    }
    // Within a factor of three either way of what one level below shows.
    EXPECT_GT(static_cast<double>(tile->statistics.error_m), worst / 3.0) << int{id.level};
    EXPECT_LT(static_cast<double>(tile->statistics.error_m), worst * 3.0) << int{id.level};
  }
}

}  // namespace
}  // namespace tellurion::raster
