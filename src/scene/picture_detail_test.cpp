// Pictures where the ground is finer than its imagery: tiles show their ancestors' pictures, and no larger ones are
// made.

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>

#include "raster/grid_tile_source.h"
#include "raster/live_raster.h"
#include "raster/service.h"
#include "scene/globe.h"
#include "scene/procedural_source_test.h"
#include "scene/view_from_test.h"

namespace tellurion::scene {
namespace {

using tiling::Scheme;

constexpr const char* kRaster = TELLURION_SHARED_DATA_DIR "/earth/bluemarble_may2004_2048x1024.jpg";
constexpr const char* kTree = TELLURION_SHARED_DATA_DIR "/earth/naturalearth2_tms/tilemapresource.xml";

/// Images of a tile service as they lie on this machine.
std::shared_ptr<const raster::TileSource> imagesOfAServer(Scheme scheme) {
  io::ResourceOptions options;
  options.cacheBytes = 0;
  auto resources = std::make_shared<io::Resources>(options);
  auto service = raster::openService({.source = kTree}, raster::Kind::imagery, geo::earth(), *resources);
  EXPECT_TRUE(service) << (service ? "" : io::describe(service.error()));
  return raster::gridTileSource(std::move(*service), scheme, std::move(resources)).value();
}

class PictureDetail : public testing::TestWithParam<Scheme> {
 protected:
  void SetUp() override {
    for (const char* path : {kRaster, kTree})
      if (!std::filesystem::exists(path)) GTEST_SKIP() << "no data beside the project";
  }

  /// Of these sources, down to a place from far away, as one who comes closer sees them.
  static void expectNoneInVain(const std::vector<std::shared_ptr<const raster::TileSource>>& sources) {
    Scene scene;
    scene.tiling = GetParam();
    GlobeLayers layers{.elevation = {std::make_shared<ProceduralSource>(raster::Kind::elevation, GetParam(), 14)},
                       .imagery = {}};
    for (const auto& source : sources)
      layers.imagery.push_back({.source = source});
    const auto globe = Globe::fromLayers(scene, std::move(layers)).value();
    std::vector<std::set<std::uint64_t>> pictures(sources.size());
    int below = 0;
    for (const double height_m : {8e6, 1e6, 1e5, 1e4}) {
      const Frame& frame = loaded(*globe, viewFrom(46.0, 8.0, height_m, 20, -60));
      std::vector<std::map<std::uint64_t, int>> levelOf(sources.size());
      for (const DrawnTile& tile : frame.tiles) {
        for (std::uint32_t i = 0; i < tile.pictureCount; ++i) {
          const DrawnPicture& drawn = frame.pictures[tile.firstPicture + i];
          const int finest = sources[drawn.layer]->info().maxLevel;
          // A window of half a picture is a level.
          const double share = static_cast<double>(drawn.window.scale.x) *
                               (raster::kImageryPixels + 2.0 * raster::kGutter) / raster::kImageryPixels;
          const int level = tile.id.level + static_cast<int>(std::lround(std::log2(share)));
          EXPECT_LE(level, finest);
          pictures[drawn.layer].insert(drawn.image->serial);
          below += tile.id.level > finest ? 1 : 0;
          const auto [known, isNew] = levelOf[drawn.layer].emplace(drawn.image->serial, level);
          EXPECT_EQ(known->second, level) << "one picture is of one tile";
        }
      }
    }
    EXPECT_GT(below, 100) << "ground finer than the data is looked at";
    for (std::size_t i = 0; i < sources.size(); ++i)
      EXPECT_LT(pictures[i].size(), 150u) << sources[i]->info().name;
  }

  static const Frame& loaded(Globe& globe, const View& view) {
    for (int i = 0; i < 3000; ++i) {
      if (const Frame& frame = globe.update(view); frame.complete) return frame;
      globe.waitForArrivals(std::chrono::milliseconds(100));
    }
    ADD_FAILURE() << "never complete";
    return globe.update(view);
  }
};

TEST_P(PictureDetail, NoneIsMadeWhereAnAncestorsHoldsAllThereIs) {
  expectNoneInVain(
      {raster::liveRaster(kRaster, raster::Kind::imagery, GetParam()).value(), imagesOfAServer(GetParam())});
}

INSTANTIATE_TEST_SUITE_P(Tilings, PictureDetail, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& test) { return std::string(tiling::nameOf(test.param)); });

}  // namespace
}  // namespace tellurion::scene
