#include "raster/grid_fetch.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "raster/grid_fixture_test.h"
#include "raster/shared_cache.h"

namespace tellurion::raster {
namespace {

using namespace testing;

using Cache = SharedCache<int, int, std::hash<int>>;

Cache::Pointer boxed(int value) {
  return std::make_shared<const int>(value);
}
std::uint64_t thousandBytes(int /*value*/) {
  return 1000;
}

TEST(SharedCache, KeepsTheLatestWithinItsBudget) {
  Cache cache(10'000);
  int made = 0;
  const auto get = [&](int key) {
    return cache.get(
        key,
        [&] {
          ++made;
          return io::Result<Cache::Pointer>(boxed(key));
        },
        thousandBytes);
  };
  for (int key = 0; key < 50; ++key) {
    EXPECT_EQ(**get(key), key);
    EXPECT_EQ(**get(0), 0);  // Always in use.
    EXPECT_LE(cache.bytes(), 10'000u);
  }
  EXPECT_EQ(made, 50);
  EXPECT_TRUE(cache.find(0));
  EXPECT_TRUE(cache.find(49));
  EXPECT_FALSE(cache.find(10));
}

TEST(SharedCache, WhatSomebodyHoldsStays) {
  Cache cache(10'000);
  const auto get = [&](int key) {
    return *cache.get(
        key, [&] { return io::Result<Cache::Pointer>(boxed(key)); }, thousandBytes);
  };
  auto held = get(0);
  for (int key = 1; key < 50; ++key)
    get(key);
  EXPECT_TRUE(cache.find(0));
  held.reset();
  get(50);
  EXPECT_FALSE(cache.find(0));
  EXPECT_LE(cache.bytes(), 10'000u);
}

TEST(SharedCache, FailuresAreNotKeptAndNullsAre) {
  Cache cache(10'000);
  int made = 0;
  const auto failing = [&]() -> io::Result<Cache::Pointer> {
    ++made;
    return io::fail(io::Failure::Code::corrupt, "no");
  };
  EXPECT_FALSE(cache.get(1, failing, thousandBytes));
  EXPECT_FALSE(cache.get(1, failing, thousandBytes));
  EXPECT_EQ(made, 2);
  EXPECT_EQ(cache
                .get(
                    2, [] { return io::Result<Cache::Pointer>(nullptr); }, thousandBytes)
                .value(),
            nullptr);
  ASSERT_TRUE(cache.find(2));
  EXPECT_EQ(*cache.find(2), nullptr);
}

TEST(SharedCache, ManyThreadsMakeAValueOnce) {
  Cache cache(1'000'000);
  std::atomic<int> made = 0;
  std::vector<std::jthread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&] {
      for (int key = 0; key < 100; ++key) {
        const auto value = cache.get(
            key,
            [&] {
              ++made;
              return io::Result<Cache::Pointer>(boxed(key));
            },
            thousandBytes);
        EXPECT_EQ(**value, key);
      }
    });
  }
  threads.clear();
  EXPECT_EQ(made, 100);
}

/// Waits for a flag, for at most some seconds.
bool comes(const std::atomic<int>& flag, int value) {
  for (int i = 0; i < 5000 && flag != value; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return flag == value;
}

TEST(GridFetch, APreparedTileIsReadyOnceAndLoads) {
  const ScratchFolder folder;
  auto service = lonLatService(4);
  service.kind = Kind::imagery;
  // Where a level has none, what stands in for it is prepared too.
  writeImages(service, folder, [](const GridImageId& id) { return id.level < 2 || id.column % 2 == 0; });
  std::atomic<int> requests = 0;
  service.request = [inner = service.request, &requests](const GridImageId& id) {
    ++requests;
    return inner(id);
  };
  const tiling::Tiling tiling(tiling::Scheme::cube);
  const auto source = sourceOrDie(service, tiling.scheme());
  auto random = geo::seededGenerator();
  int prepared = 0;
  for (int i = 0; i < 40; ++i) {
    const auto id = randomTile(random, tiling, static_cast<int>(random() % 3));
    std::atomic<int> ready = 0;
    const auto preparation = source->prepare(id, 1.0, [&] { ++ready; });
    if (preparation) {
      ++prepared;
      preparation->setPriority(2.0);
      ASSERT_TRUE(comes(ready, 1));
    }
    const int before = requests;
    EXPECT_TRUE(source->load(id));
    EXPECT_EQ(requests, before) << "load asked for something that was not prepared";
    EXPECT_EQ(ready, preparation ? 1 : 0);
    std::atomic<int> readyAgain = 0;
    const auto again = source->prepare(id, 1.0, [&] { ++readyAgain; });
    EXPECT_EQ(again != nullptr, preparation != nullptr);
    ASSERT_TRUE(comes(readyAgain, again ? 1 : 0));
    EXPECT_EQ(requests, before) << "asked for again, though it is at hand";
  }
  EXPECT_GT(prepared, 3);
}

/// A frame asks for a hundred tiles at a time: neither which images these need nor their requests are its thread's
/// work.
TEST(GridFetch, WhoPreparesDoesNoneOfTheWork) {
  const ScratchFolder folder;
  auto service = lonLatService(4);
  service.kind = Kind::imagery;
  writeImages(service, folder);
  std::atomic<int> onCallers = 0;
  std::atomic<int> requests = 0;
  service.request = [inner = service.request, &onCallers, &requests,
                     caller = std::this_thread::get_id()](const GridImageId& id) {
    ++requests;
    onCallers += std::this_thread::get_id() == caller ? 1 : 0;
    return inner(id);
  };
  const tiling::Tiling tiling(tiling::Scheme::cube);
  const auto source = sourceOrDie(service, tiling.scheme());
  auto random = geo::seededGenerator();
  std::atomic<int> ready = 0;
  std::vector<std::unique_ptr<Preparation>> preparations;
  for (int i = 0; i < 100; ++i) {
    auto preparation = source->prepare(randomTile(random, tiling, 2), i, [&] { ++ready; });
    if (preparation) preparations.push_back(std::move(preparation));
  }
  EXPECT_GT(preparations.size(), 20u);
  EXPECT_TRUE(comes(ready, static_cast<int>(preparations.size())));
  EXPECT_GT(requests, 0);
  EXPECT_EQ(onCallers, 0);
}

/// Whatever is loaded meanwhile, and drives decoded images out of the memory.
TEST(GridFetch, APreparedTileLoadsWithoutWaitingHoweverLittleMemoryThereIs) {
  const ScratchFolder folder;
  auto service = lonLatService(4);
  service.kind = Kind::imagery;
  writeImages(service, folder);
  std::atomic<int> requests = 0;
  service.request = [inner = service.request, &requests](const GridImageId& id) {
    ++requests;
    return inner(id);
  };
  const tiling::Tiling tiling(tiling::Scheme::cube);
  const auto source = gridTileSource(service, tiling.scheme(), std::make_shared<io::Resources>(io::ResourceOptions{}),
                                     {.memoryBytes = 60'000, .tileCells = 32})
                          .value();
  auto random = geo::seededGenerator();
  int prepared = 0;
  for (int i = 0; i < 40; ++i) {
    const auto id = randomTile(random, tiling, 2);
    std::atomic<int> ready = 0;
    const auto preparation = source->prepare(id, 1.0, [&] { ++ready; });
    if (!preparation) continue;
    ++prepared;
    ASSERT_TRUE(comes(ready, 1));
    for (int other = 0; other < 4; ++other)
      EXPECT_TRUE(source->load(randomTile(random, tiling, 2)));
    const int before = requests;
    EXPECT_TRUE(source->load(id));
    EXPECT_EQ(requests, before) << "load asked for something that was prepared";
  }
  EXPECT_GT(prepared, 10);
}

TEST(GridFetch, DestroyedPreparationsCallNobody) {
  const ScratchFolder folder;
  auto service = lonLatService(4);
  service.kind = Kind::imagery;
  writeImages(service, folder);
  const tiling::Tiling tiling(tiling::Scheme::healpix);
  const auto source = sourceOrDie(service, tiling.scheme());
  auto random = geo::seededGenerator();
  for (int i = 0; i < 300; ++i) {
    const auto id = randomTile(random, tiling, static_cast<int>(random() % 4));
    auto alive = std::make_unique<std::atomic<bool>>(true);
    auto preparation = source->prepare(id, 1.0, [&alive = *alive] { EXPECT_TRUE(alive); });
    if (i % 3 == 0) std::this_thread::sleep_for(std::chrono::microseconds(50));
    preparation.reset();
    *alive = false;
  }
}

TEST(GridFetch, WhatTheParentShowsAlreadyIsNoTile) {
  const ScratchFolder folder;
  auto service = lonLatService(4);
  service.kind = Kind::imagery;
  // From level 2 on there is only the north.
  writeImages(service, folder, [](const GridImageId& id) { return id.level < 2 || id.row < (1 << id.level) / 2; });
  const tiling::Tiling tiling(tiling::Scheme::geographic);
  const auto source = sourceOrDie(service, tiling.scheme());
  const auto at = [&](double lat, int level) {
    return source->load(tiling.tileAt(geo::directionFromDegrees(lat, 20.0), level)).value();
  };
  // A tile of this tiling is an image of the next level.
  EXPECT_TRUE(at(20.0, 2));
  EXPECT_TRUE(at(-20.0, 0));
  EXPECT_FALSE(at(-20.0, 1));
  EXPECT_FALSE(at(-20.0, 2));
  // On the border it is there, and whole.
  const auto border = source->load(tiling.tileAt(geo::directionFromDegrees(0.1, 20.0), 1)).value();
  ASSERT_TRUE(border);
  for (const Rgba8& p : std::get<ImageryTile>(border->payload).pixels.samples)
    EXPECT_EQ(p.a, 255);
}

TEST(GridFetch, DamagedImagesAreFailuresThatNameThem) {
  const ScratchFolder folder;
  auto service = lonLatService(1);
  service.kind = Kind::imagery;
  writeImages(service, folder);
  std::ofstream(folder.file("lonlat_0_1_0")) << "<html>sorry</html>";
  const auto source = sourceOrDie(service, tiling::Scheme::geographic);
  const auto tile = source->load({.level = 0, .root = 1});
  ASSERT_FALSE(tile);
  EXPECT_NE(tile.error().where.find("lonlat_0_1_0"), std::string::npos) << io::describe(tile.error());
}

TEST(GridTileSource, ComplainsWhenNothingOfTheCoarsestLevelIsThere) {
  const tiling::Tiling tiling(tiling::Scheme::geographic);
  const auto complaintOf = [&](Kind kind, const std::function<bool(const GridImageId&)>& exists) {
    const ScratchFolder folder;
    auto service = lonLatService(3);
    service.kind = kind;
    service.heights.kind = HeightEncoding::Kind::terrarium;
    writeImages(service, folder, exists);
    const auto source = sourceOrDie(service, tiling.scheme());
    EXPECT_FALSE(source->complaint()) << "before anything was asked for";
    for (const std::uint8_t root : {std::uint8_t{1}, std::uint8_t{0}})
      for (const auto& id : {tiling::TileId{.level = 0, .root = root}, tiling::TileId{.level = 1, .root = root}})
        EXPECT_TRUE(source->load(id));
    return source->complaint();
  };
  for (const Kind kind : {Kind::imagery, Kind::elevation}) {
    const auto nothing = complaintOf(kind, [](const GridImageId&) { return false; });
    ASSERT_TRUE(nothing);
    EXPECT_NE(nothing->message.find("is the address right?"), std::string::npos);
    EXPECT_NE(nothing->where.find("lonlat_0_"), std::string::npos) << nothing->where;
    EXPECT_FALSE(complaintOf(kind, [](const GridImageId& id) { return id.level == 0; })) << "finer levels may lack";
    EXPECT_FALSE(complaintOf(kind, [](const GridImageId& id) { return id.level == 0 && id.column == 0; }));
    EXPECT_FALSE(complaintOf(kind, {}));
  }
}

TEST(GridTileSource, SenselessServicesAreRefused) {
  const auto refused = [](const std::function<void(GridService&)>& spoil) {
    auto service = lonLatService(3);
    service.request = [](const GridImageId&) { return io::ResourceRequest{}; };
    spoil(service);
    return !gridTileSource(service, tiling::Scheme::cube, localResources());
  };
  EXPECT_FALSE(refused([](GridService&) {}));
  EXPECT_TRUE(refused([](GridService& s) { s.levels.clear(); }));
  EXPECT_TRUE(refused([](GridService& s) { s.levels[1].pixelWidth = 0.0; }));
  EXPECT_TRUE(refused([](GridService& s) { s.levels[1].pixelHeight = std::nan(""); }));
  EXPECT_TRUE(refused([](GridService& s) { s.levels[1].imageWidth = 1 << 20; }));
  EXPECT_TRUE(refused([](GridService& s) { s.levels[1].endColumn = 0; }));
  EXPECT_TRUE(refused([](GridService& s) { s.levels[0].endRow = 1000; }));
  EXPECT_TRUE(refused([](GridService& s) { std::swap(s.levels[0], s.levels[2]); }));
  EXPECT_TRUE(refused([](GridService& s) { s.levels[0].columns = s.levels[0].endColumn = std::int64_t{1} << 40; }));
  EXPECT_TRUE(refused([](GridService& s) { s.plane = {MapPlane::Kind::other, "no such reference"}; }));
}

}  // namespace
}  // namespace tellurion::raster
