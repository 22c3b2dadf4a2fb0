#include "raster/derived_tiles.h"

#include <gdal_utils.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include "geo/ellipsoid.h"
#include "geo/seed_test.h"
#include "raster/live_raster.h"
#include "raster/raster_fixture_test.h"
#include "raster/tile_places.h"

namespace tellurion::raster {
namespace {

using testing::ScratchFolder;

/// Hills out of a function, to a level; what is stored, and what has data, is up to the test.
class Hills final : public TileSource {
 public:
  Hills(tiling::Scheme scheme, int maxLevel, double frequency = 60.0) : tiling_(scheme), frequency_(frequency) {
    info_ = {.name = "hills", .kind = Kind::elevation, .scheme = scheme, .maxLevel = maxLevel};
  }

  void setBounds(const geo::GeoRect& bounds) { info_.bounds = bounds; }
  double heightAt(const geo::Direction& d) const {
    const double f = frequency_;
    return 60000.0 / f * (std::sin(f * d.n.x + 1.0) * std::cos(f * d.n.y) + std::sin(0.7 * f * d.n.z + 0.3)) + lift_m;
  }
  /// Metres a metre, as heightAt rises to the east and to the north.
  Rise riseAt(const geo::Direction& d) const {
    const geo::Ellipsoid& ellipsoid = info_.body.ellipsoid;
    const geo::Vec3 east = geo::normalize(geo::Vec3(-d.n.y, d.n.x, 0.0));
    const auto along = [&](const geo::Vec3& way) {
      constexpr double kStep = 1e-6;
      const geo::Direction ahead{geo::normalize(d.n + kStep * way)};
      const geo::Direction behind{geo::normalize(d.n - kStep * way)};
      return (heightAt(ahead) - heightAt(behind)) /
             geo::length(ellipsoid.bodyFromDirection(ahead) - ellipsoid.bodyFromDirection(behind));
    };
    return {along(east), along(geo::cross(d.n, east))};
  }

  const TileSourceInfo& info() const override { return info_; }
  std::optional<TilePresence> presence(const tiling::TileId& id) const override {
    if (!tells) return std::nullopt;
    TilePresence out{.stored = id.level <= info_.maxLevel && stored(id)};
    for (int q = 0; q < 4; ++q) {
      if (id.level < info_.maxLevel && stored(id.child(q))) out.childMask |= static_cast<std::uint8_t>(1u << q);
    }
    return out;
  }
  std::unique_ptr<Preparation> prepare(const tiling::TileId& id, double priority,
                                       std::function<void()> ready) const override {
    if (!prepares) return nullptr;
    const std::scoped_lock lock(mutex);
    prepared.insert(id);
    return prepares(id, priority, std::move(ready));
  }
  io::Result<std::optional<SourceTile>> load(const tiling::TileId& id) const override {
    {
      const std::scoped_lock lock(mutex);
      ++loads[id];
    }
    if (fails) return io::fail(io::Failure::Code::corrupt, "is damaged", "hills");
    if (id.level > info_.maxLevel || !stored(id)) return std::optional<SourceTile>{};
    const int side = sideOf(Kind::elevation, info_.tileCells);
    ElevationTile heights{Raster<float>(side, side, 1e5f)};  // a wild value where the gutter's corners promise nothing
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column) {
        const auto place = placeOf(tiling_, id, Kind::elevation, info_.tileCells, column, row);
        const bool isCorner = (row == 0 || row == side - 1) && (column == 0 || column == side - 1);
        if (!place || isCorner) continue;
        heights.samples.at(column, row) = hasData(*place) ? static_cast<float>(heightAt(*place)) : kNoData;
      }
    }
    SourceTile tile;
    tile.payload = std::move(heights);
    for (int q = 0; q < 4; ++q) {
      if (id.level < info_.maxLevel && stored(id.child(q))) tile.childMask |= static_cast<std::uint8_t>(1u << q);
    }
    return std::optional(std::move(tile));
  }

  std::function<bool(const tiling::TileId&)> stored = [](const tiling::TileId&) { return true; };
  std::function<bool(const geo::Direction&)> hasData = [](const geo::Direction&) { return true; };
  std::function<std::unique_ptr<Preparation>(const tiling::TileId&, double, std::function<void()>)> prepares;
  double lift_m = 0.0;
  bool tells = false;
  bool fails = false;
  mutable std::mutex mutex;
  mutable std::map<tiling::TileId, int> loads;
  mutable std::set<tiling::TileId> prepared;

 private:
  tiling::Tiling tiling_;
  double frequency_;
  TileSourceInfo info_;
};

std::shared_ptr<const TileSource> derived(std::vector<std::shared_ptr<const TileSource>> heights,
                                          HeightColours colours) {
  std::vector<DerivedHeights> each;
  for (auto& source : heights)
    each.push_back({.source = std::move(source)});
  auto made = derivedTileSource(each, std::move(colours));
  EXPECT_TRUE(made) << io::describe(made.error());
  return *made;
}

SourceTile tileOf(const TileSource& source, const tiling::TileId& id) {
  auto loaded = source.load(id);
  EXPECT_TRUE(loaded && *loaded) << int{id.level} << '/' << int{id.root} << '/' << id.x << '/' << id.y;
  return loaded && *loaded ? std::move(**loaded) : SourceTile{.payload = ImageryTile{Raster<Rgba8>(258, 258)}};
}

Raster<Rgba8> pixelsOf(const TileSource& source, const tiling::TileId& id) {
  return std::get<ImageryTile>(tileOf(source, id).payload).pixels;
}

Palette greyBetween(double low_m, double high_m) {
  return {{{low_m, {0, 0, 0, 255}}, {high_m, {255, 255, 255, 255}}}};
}
SlopeColours greySlope() {
  const auto ramp = slopeRamp();
  return {.stops = {ramp.begin(), ramp.end()}};
}

class DerivedTiles : public ::testing::TestWithParam<tiling::Scheme> {};
INSTANTIATE_TEST_SUITE_P(AllTilings, DerivedTiles,
                         ::testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

/// A tile with a pole, tiles on the date line, and any.
std::vector<tiling::TileId> someTiles(tiling::Scheme scheme, int level, std::mt19937_64& random) {
  const tiling::Tiling tiling(scheme);
  std::vector<tiling::TileId> out;
  for (const auto& [lat, lon] : {std::pair(89.9, 45.0), std::pair(-89.9, -120.0), std::pair(10.0, 179.999),
                                 std::pair(-50.0, -179.999), std::pair(45.0001, 0.0)})
    out.push_back(tiling.tileAt(geo::directionFromDegrees(lat, lon), level));
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  for (int i = 0; i < 1; ++i) {
    const geo::Direction d{geo::normalize(geo::Vec3(part(random), part(random), part(random) + 1e-9))};
    out.push_back(tiling.tileAt(d, level));
  }
  return out;
}

TEST_P(DerivedTiles, AreWhatTheGroundsOwnDerivativesSay) {
  auto random = geo::seededGenerator();
  const auto hills = std::make_shared<Hills>(GetParam(), 5);
  const Hillshade light{
      .sunAzimuth = geo::Angle::degrees(70.0), .sunAltitude = geo::Angle::degrees(30.0), .exaggeration = 3.0};
  const auto shade = derived({hills}, light);
  const auto slope = derived({hills}, greySlope());
  const auto palette = derived({hills}, greyBetween(-2100.0, 2100.0));
  const geo::Vec3 sun = sunOf(light);
  const tiling::Tiling tiling(GetParam());
  for (const tiling::TileId& id : someTiles(GetParam(), 3, random)) {
    const auto shades = pixelsOf(*shade, id);
    const auto slopes = pixelsOf(*slope, id);
    const auto heights = pixelsOf(*palette, id);
    for (int row = 0; row < shades.height; row += 7) {
      for (int column = 0; column < shades.width; column += 7) {
        const auto place = placeOf(tiling, id, Kind::imagery, kImageryPixels, column, row);
        if (!place || ((row == 0 || row == 257) && (column == 0 || column == 257))) continue;
        const Rise rise = hills->riseAt(*place);
        ASSERT_NEAR(int{shades.at(column, row).r}, int{shadeOf(sun, 3.0, rise).r}, 2) << column << ' ' << row;
        ASSERT_NEAR(int{slopes.at(column, row).r}, 255.0 * (1.0 - slopeOf(rise, 1.0).degrees() / 90.0), 1.0);
        ASSERT_NEAR(int{heights.at(column, row).r}, 255.0 * (hills->heightAt(*place) + 2100.0) / 4200.0, 1.1);
        ASSERT_EQ(heights.at(column, row).a, 255);
      }
    }
  }
}

/// Pixel `along` an edge, `depth` pixels in from it; -1 is the gutter.
Rgba8 beside(const Raster<Rgba8>& pixels, tiling::Edge edge, int along, int depth) {
  const int near = kGutter + depth;
  const int far = kGutter + kImageryPixels - 1 - depth;
  const int place = kGutter + along;
  switch (edge) {
    case tiling::Edge::top:
      return pixels.at(place, near);
    case tiling::Edge::bottom:
      return pixels.at(place, far);
    case tiling::Edge::left:
      return pixels.at(near, place);
    case tiling::Edge::right:
      return pixels.at(far, place);
  }
  return {};
}

TEST_P(DerivedTiles, NeighboursAgreeAcrossEdges) {
  auto random = geo::seededGenerator();
  const tiling::Tiling tiling(GetParam());
  // To level 5 there are heights for each pixel of level 3; level 0 of the last is made of heights far apart.
  for (const auto& [deepest, level] : {std::pair(5, 3), std::pair(0, 0)}) {
    const auto hills = std::make_shared<Hills>(GetParam(), deepest, deepest == 0 ? 20.0 : 200.0);
    for (const HeightColours& colours :
         {HeightColours(Hillshade{.exaggeration = 5.0}), HeightColours(greyBetween(-3000.0, 3000.0))}) {
      const auto source = derived({hills}, colours);
      for (const tiling::TileId& id : someTiles(GetParam(), level, random)) {
        const auto own = pixelsOf(*source, id);
        for (const tiling::Edge edge : tiling::kEdges) {
          const auto other = tiling.edgeNeighbour(id, edge);
          const auto beyond = pixelsOf(*source, other.tile);
          // Where heights are far apart, what lies by a corner is made without the sample beyond the corner.
          const int margin = deepest == 0 ? 4 : 1;
          for (int i = margin; i < kImageryPixels - margin; ++i) {
            const int there = other.reversed ? kImageryPixels - 1 - i : i;
            ASSERT_NEAR(int{beside(own, edge, i, -1).r}, int{beside(beyond, other.edge, there, 0).r}, 1)
                << int{id.level} << '/' << int{id.root} << '/' << id.x << '/' << id.y << " edge "
                << static_cast<int>(edge) << " pixel " << i;
          }
        }
      }
    }
  }
}

TEST_P(DerivedTiles, AreTransparentWhereThereAreNoHeights) {
  const auto hills = std::make_shared<Hills>(GetParam(), 4);
  hills->hasData = [](const geo::Direction& d) { return d.n.x > 0.1; };
  const tiling::Tiling tiling(GetParam());
  for (const HeightColours& colours : {HeightColours(Hillshade{}), HeightColours(greyBetween(-3000.0, 3000.0))}) {
    const auto source = derived({hills}, colours);
    for (int root = 0; root < tiling.rootCount(); ++root) {
      const tiling::TileId id{.level = 0, .root = static_cast<std::uint8_t>(root)};
      const auto pixels = pixelsOf(*source, id);
      for (int row = 1; row <= kImageryPixels; ++row) {
        for (int column = 1; column <= kImageryPixels; ++column) {
          const double x = placeOf(tiling, id, Kind::imagery, kImageryPixels, column, row)->n.x;
          if (std::abs(x - 0.1) < 0.01) continue;
          ASSERT_EQ(pixels.at(column, row).a, x > 0.1 ? 255 : 0);
        }
      }
    }
  }
}

TEST_P(DerivedTiles, ThereAreAsManyAsThereAreHeightsFor) {
  const auto hills = std::make_shared<Hills>(GetParam(), 4);
  // The quarter of a root that is under its child 1, and all roots.
  hills->stored = [](const tiling::TileId& id) {
    return id.level == 0 || (id.root == 2 && id.ancestor(1).quadrant() == 1);
  };
  for (const bool tells : {false, true}) {
    hills->tells = tells;
    const auto source = derived({hills}, Hillshade{});
    EXPECT_EQ(source->info().maxLevel, 2);
    EXPECT_EQ(source->info().kind, Kind::imagery);
    EXPECT_EQ(source->presence({}).has_value(), tells);
    std::vector<tiling::TileId> todo{{.level = 0, .root = 0}, {.level = 0, .root = 2}};
    int count = 0;
    while (!todo.empty()) {
      const tiling::TileId id = todo.back();
      todo.pop_back();
      ++count;
      const SourceTile tile = tileOf(*source, id);
      if (tells) {
        EXPECT_TRUE(source->presence(id)->stored);
        EXPECT_EQ(source->presence(id)->childMask, tile.childMask);
      }
      for (int q = 0; q < 4 && id.level < 3; ++q) {
        if (((tile.childMask >> q) & 1u) != 0) {
          todo.push_back(id.child(q));
        } else {
          const auto none = source->load(id.child(q));
          EXPECT_TRUE(none && !*none);
          EXPECT_TRUE(!tells || !source->presence(id.child(q))->stored);
        }
      }
    }
    EXPECT_EQ(count, 2 + 1 + 4);
  }
}

TEST_P(DerivedTiles, LaterHeightsLieOverEarlierOnes) {
  const auto below = std::make_shared<Hills>(GetParam(), 2);
  const auto above = std::make_shared<Hills>(GetParam(), 4);
  above->lift_m = 20000.0;
  above->hasData = [](const geo::Direction& d) { return d.n.z > 0.0; };
  const auto source = derived({below, above}, greyBetween(-2500.0, 22500.0));
  const tiling::Tiling tiling(GetParam());
  for (const double lat : {-60.0, -20.0, 30.0, 80.0}) {
    const geo::Direction d = geo::directionFromDegrees(lat, 33.0);
    const tiling::TileId id = tiling.tileAt(d, 2);
    const auto pixels = pixelsOf(*source, id);
    for (int i = 8; i < 256; i += 16) {
      const auto place = placeOf(tiling, id, Kind::imagery, kImageryPixels, i, i);
      if (std::abs(place->n.z) < 0.02) continue;
      const double height_m = (place->n.z > 0.0 ? *above : *below).heightAt(*place);
      EXPECT_NEAR(int{pixels.at(i, i).r}, 255.0 * (height_m + 2500.0) / 25000.0, 1.0);
    }
  }
}

TEST(DerivedTiles, NoHeightIsLoadedTwiceForATile) {
  const auto hills = std::make_shared<Hills>(tiling::Scheme::cube, 3);
  hills->stored = [](const tiling::TileId& id) { return id.level < 3 || id.x % 2 == 0; };
  const auto source = derived({hills}, Hillshade{});
  tileOf(*source, {.level = 1, .root = 1});
  for (const auto& [id, times] : hills->loads)
    EXPECT_EQ(times, 1) << int{id.level} << '/' << id.x << '/' << id.y;
  EXPECT_EQ(hills->loads.size(), 16u + 4u);
}

/// Is ready when the test says so.
struct Gate {
  struct Waiting final : Preparation {
    explicit Waiting(std::atomic<int>& count) : living(count) { ++living; }
    ~Waiting() override { --living; }
    Waiting(const Waiting&) = delete;
    Waiting& operator=(const Waiting&) = delete;
    void setPriority(double priority) override { lastPriority = priority; }
    std::atomic<int>& living;
    double lastPriority = 0.0;
  };
  std::vector<std::function<void()>> readies;
  std::atomic<int> living{0};
  std::unique_ptr<Preparation> prepare(std::function<void()> ready) {
    readies.push_back(std::move(ready));
    return std::make_unique<Waiting>(living);
  }
};

TEST(DerivedTiles, AreReadyWhenAllTheirHeightsAre) {
  const auto hills = std::make_shared<Hills>(tiling::Scheme::cube, 6);
  hills->tells = true;
  Gate gate;
  hills->prepares = [&](const tiling::TileId& id, double, std::function<void()> ready) {
    return id.level == 5 ? gate.prepare(std::move(ready)) : nullptr;  // what lies above is there already
  };
  const auto source = derived({hills}, Hillshade{});
  std::atomic<int> calls{0};
  const tiling::TileId id{.level = 3, .root = 1, .x = 3, .y = 5};
  auto preparation = source->prepare(id, 1.0, [&] { ++calls; });
  ASSERT_NE(preparation, nullptr);
  ASSERT_EQ(gate.readies.size(), 16u);
  // Nothing that load() reads is missing.
  hills->loads.clear();
  tileOf(*source, id);
  for (const auto& [tile, times] : hills->loads)
    EXPECT_TRUE(hills->prepared.contains(tile));
  for (std::size_t i = 0; i < gate.readies.size(); ++i) {
    EXPECT_EQ(calls, 0);
    gate.readies[i]();
  }
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(gate.living, 16);
  preparation.reset();
  EXPECT_EQ(gate.living, 0);
}

TEST(DerivedTiles, PartsThatAreReadyAtOnceDoNotCallFromWithin) {
  const auto hills = std::make_shared<Hills>(tiling::Scheme::cube, 6);
  hills->tells = true;
  Gate gate;
  std::vector<std::jthread> network;
  hills->prepares = [&](const tiling::TileId& id, double, std::function<void()> ready) -> std::unique_ptr<Preparation> {
    if (id.x % 2 == 0) return nullptr;
    network.emplace_back(std::move(ready));
    return gate.prepare([] {});
  };
  const auto source = derived({hills}, Hillshade{});
  const auto own = std::this_thread::get_id();
  for (int round = 0; round < 20; ++round) {
    std::atomic<int> calls{0};
    auto preparation = source->prepare({.level = 2, .root = 0}, 1.0, [&] {
      EXPECT_NE(std::this_thread::get_id(), own);
      ++calls;
    });
    network.clear();
    EXPECT_EQ(calls, 1);
  }
  hills->prepares = [](const auto&, double, auto) { return nullptr; };
  EXPECT_EQ(source->prepare({.level = 2, .root = 0}, 1.0, [] { FAIL(); }), nullptr);
}

/// 20 km over the ground and half a degree round: without a seam its edge is a wall of one pixel.
TEST(DerivedTiles, ALocalModelEndsInASeamAsTheGroundDoes) {
  const tiling::Tiling tiling(tiling::Scheme::cube);
  const geo::Direction middle = geo::directionFromDegrees(46, 8);
  constexpr double kRadius_degrees = 0.5;
  constexpr int kDepth = 9;
  const auto below = std::make_shared<Hills>(tiling::Scheme::cube, kDepth);
  for (const bool tells : {false, true}) {
    const auto above = std::make_shared<Hills>(tiling::Scheme::cube, kDepth);
    above->lift_m = 20000.0;
    above->tells = tells;
    above->setBounds(geo::GeoRect::fromDegrees(45.5, 7.28, 46.5, 8.72));
    above->hasData = [&](const geo::Direction& d) { return geo::angleBetween(d, middle).degrees() < kRadius_degrees; };
    above->stored = [&](const tiling::TileId& id) {
      const auto cap = tiling.cap(id);
      return geo::angleBetween(cap.centre, middle).degrees() < kRadius_degrees + cap.radius.degrees();
    };
    std::array<int, 2> steepest{};
    for (const bool hasSeam : {false, true}) {
      const auto source = derivedTileSource({{below}, {above, hasSeam ? 20e3 : 0.0}}, greyBetween(-2500.0, 22500.0));
      ASSERT_TRUE(source) << io::describe(source.error());
      for (int i = 0; i < 8; ++i) {  // from the middle across the border to the east
        const auto pixels = pixelsOf(**source, tiling.tileAt(geo::directionFromDegrees(46, 8.0 + 0.1 * i), kDepth - 2));
        for (int column = 1; column < pixels.width; ++column) {
          const int step = std::abs(pixels.at(column, 128).r - pixels.at(column - 1, 128).r);
          steepest[hasSeam ? 1 : 0] = std::max(steepest[hasSeam ? 1 : 0], step);
        }
      }
    }
    EXPECT_GT(steepest[0], 80) << "of 204, the whole height: a pixel is the mean of its cell's corners";
    // Who tells what is stored tells it of whole tiles: the seam lies where they end, and the data end inside them.
    EXPECT_LT(steepest[1], tells ? 60 : 12);
    EXPECT_GT(steepest[1], 2);
  }
}

TEST(DerivedTiles, FailWhenTheirHeightsDo) {
  const auto hills = std::make_shared<Hills>(tiling::Scheme::cube, 3);
  hills->fails = true;
  const auto tile = derived({hills}, Hillshade{})->load({});
  ASSERT_FALSE(tile);
  EXPECT_EQ(tile.error().message, "is damaged");
  const auto geographic = std::make_shared<Hills>(tiling::Scheme::geographic, 3);
  EXPECT_FALSE(derivedTileSource({{hills}, {geographic}}, Hillshade{}));
  EXPECT_FALSE(derivedTileSource({{derived({geographic}, Hillshade{})}}, Hillshade{}));
  EXPECT_FALSE(derivedTileSource({}, Hillshade{}));
}

/// What gdaldem makes of heights.
class DemTool {
 public:
  DemTool(std::vector<float> heights, int width, int height, double pixelWidth_m, double pixelHeight_m)
      : heights_(std::move(heights)), width_(width), height_(height) {
    GDALAllRegister();
    data_ = GetGDALDriverManager()->GetDriverByName("MEM")->Create("", width, height, 1, GDT_Float32, nullptr);
    std::array<double, 6> transform{0.0, pixelWidth_m, 0.0, 0.0, 0.0, -pixelHeight_m};
    data_->SetGeoTransform(transform.data());
    EXPECT_EQ(data_->GetRasterBand(1)->RasterIO(GF_Write, 0, 0, width, height, heights_.data(), width, height,
                                                GDT_Float32, 0, 0, nullptr),
              CE_None);
  }
  ~DemTool() { GDALClose(data_); }
  DemTool(const DemTool&) = delete;
  DemTool& operator=(const DemTool&) = delete;

  std::vector<float> run(const char* what, const char* colours, const std::vector<const char*>& arguments) const {
    CPLStringList list;
    for (const char* argument : arguments)
      list.AddString(argument);
    list.AddString("-of");
    list.AddString("MEM");
    GDALDEMProcessingOptions* options = GDALDEMProcessingOptionsNew(list.List(), nullptr);
    GDALDatasetH made = GDALDEMProcessing("", data_, what, colours, options, nullptr);
    GDALDEMProcessingOptionsFree(options);
    std::vector<float> out(heights_.size(), -1.0f);
    EXPECT_NE(made, nullptr);
    if (made == nullptr) return out;
    EXPECT_EQ(GDALRasterIO(GDALGetRasterBand(made, 1), GF_Read, 0, 0, width_, height_, out.data(), width_, height_,
                           GDT_Float32, 0, 0),
              CE_None);
    GDALClose(made);
    return out;
  }

 private:
  std::vector<float> heights_;
  int width_;
  int height_;
  GDALDataset* data_;
};

struct Difference {
  double sum = 0.0;
  double largest = 0.0;
  int count = 0;
  void add(double a, double b) {
    sum += std::abs(a - b);
    largest = std::max(largest, std::abs(a - b));
    ++count;
  }
  double mean() const { return sum / count; }
};

/// A tile of the geographic tiling against gdaldem on heights of the same file, taken at half the pixels' distance: its
/// window of three samples then is a pixel. In bands, since gdaldem takes pixels to be equally wide everywhere.
void compareWithGdaldem(const std::string& path, double lat, double lon) {
  const tiling::Tiling tiling(tiling::Scheme::geographic);
  const auto live = liveRaster(path, Kind::elevation, tiling::Scheme::geographic);
  ASSERT_TRUE(live) << io::describe(live.error());
  const Hillshade light{.exaggeration = 2.0};
  const auto shade = derived({*live}, light);
  const auto slope = derived({*live}, greySlope());
  const auto palette = derived(
      {*live},
      Palette{
          {{-6000.0, {0, 0, 0, 255}}, {0.0, {60, 0, 0, 255}}, {1000.0, {200, 0, 0, 255}}, {9000.0, {255, 0, 0, 255}}}});
  const ScratchFolder folder;
  std::ofstream(folder.file("ramp.txt")) << "-6000 0 0 0\n0 60 0 0\n1000 200 0 0\n9000 255 0 0\n";

  const tiling::TileId id = tiling.tileAt(geo::directionFromDegrees(lat, lon), shade->info().maxLevel);
  const auto shades = pixelsOf(*shade, id);
  const auto slopes = pixelsOf(*slope, id);
  const auto colours = pixelsOf(*palette, id);
  auto file = testing::openOrDie(path, Kind::elevation);
  const geo::GeoRect bounds = tiling.bounds(id);
  const double step = bounds.width.degrees() / 512.0;
  constexpr int kSide = 513;
  constexpr int kBand = 8;
  Difference ofShade;
  Difference ofSlope;
  Difference ofColour;
  for (int first = 0; first < kImageryPixels; first += kBand) {
    const int rows = 2 * kBand + 1;
    std::vector<geo::Direction> places;
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < kSide; ++column) {
        places.push_back(geo::directionFromDegrees(bounds.north.degrees() - (2 * first + row) * step,
                                                   bounds.west.degrees() + column * step));
      }
    }
    std::vector<float> heights(places.size(), kNoData);
    ASSERT_TRUE(file.sampleHeights(places, geo::Angle(), heights));
    const geo::Ellipsoid ellipsoid = geo::earth().ellipsoid;
    const auto middle = static_cast<std::size_t>(rows / 2 * kSide + kSide / 2);
    const auto distance_m = [&](std::size_t other) {
      return geo::length(ellipsoid.bodyFromDirection(places[middle]) - ellipsoid.bodyFromDirection(places[other]));
    };
    const DemTool tool(heights, kSide, rows, distance_m(middle + 1), distance_m(middle + kSide));
    const auto theirShade = tool.run("hillshade", nullptr, {"-z", "2"});
    const auto theirSlope = tool.run("slope", nullptr, {});
    const auto theirColour = tool.run("color-relief", folder.file("ramp.txt").c_str(), {});
    for (int row = 0; row < kBand; ++row) {
      for (int column = 0; column < kImageryPixels; ++column) {
        const auto at = static_cast<std::size_t>((2 * row + 1) * kSide + 2 * column + 1);
        bool isKnown = true;
        for (const int beside : {-kSide - 1, -kSide, -kSide + 1, -1, 0, 1, kSide - 1, kSide, kSide + 1})
          isKnown = isKnown && !isNoData(heights[at + static_cast<std::size_t>(beside)]);
        if (!isKnown || colours.at(column + 1, first + row + 1).a == 0) continue;
        ofShade.add(shades.at(column + 1, first + row + 1).r, static_cast<double>(theirShade[at]));
        ofSlope.add(90.0 * (1.0 - slopes.at(column + 1, first + row + 1).r / 255.0),
                    static_cast<double>(theirSlope[at]));
        ofColour.add(colours.at(column + 1, first + row + 1).r, static_cast<double>(theirColour[at]));
      }
    }
  }
  std::printf(
      "%s: hillshade mean %.3f largest %.0f, slope mean %.3f largest %.2f degrees, palette mean %.3f largest "
      "%.0f\n",
      std::filesystem::path(path).filename().c_str(), ofShade.mean(), ofShade.largest, ofSlope.mean(), ofSlope.largest,
      ofColour.mean(), ofColour.largest);
  EXPECT_GT(ofShade.count, kImageryPixels * kImageryPixels / 2);
  // The file's samples and the tile's do not lie at the same places: what is left is between them.
  EXPECT_LT(ofShade.mean(), 2.0);
  EXPECT_LT(ofSlope.mean(), 0.5);
  EXPECT_LT(ofColour.mean(), 0.6);
}

TEST(DerivedTiles, LookLikeGdaldem) {
  const std::filesystem::path folder(TELLURION_SHARED_DATA_DIR "/earth");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no shared data";
  compareWithGdaldem((folder / "srtm3_everest_N27E086.tif").string(), 27.6, 86.6);
  compareWithGdaldem((folder / "etopo5_dem_5min.tif").string(), 30.0, 85.0);
  compareWithGdaldem((folder / "etopo5_dem_5min.tif").string(), -20.0, -70.0);
}

}  // namespace
}  // namespace tellurion::raster
