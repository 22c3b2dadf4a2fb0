#include "scene/layer_tiles.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "scene/procedural_source_test.h"

namespace tellurion::scene {
namespace {

using tiling::Scheme;
using tiling::TileId;

struct Opened {
  explicit Opened(std::uint64_t budgetBytes)
      : source(std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 6)),
        ledger(std::make_shared<LoadLedger>()),
        tiles(source, budgetBytes, ledger) {}

  std::shared_ptr<ProceduralSource> source;
  std::shared_ptr<LoadLedger> ledger;
  LayerTiles tiles;
};

TileId tile(std::uint32_t x, std::uint32_t y) {
  return {.level = 5, .root = 2, .x = x, .y = y};
}

TEST(LayerTiles, whoAsksForATileThatIsBeingLoadedWaitsForIt) {
  Opened o(1u << 20);
  o.source->delay = [](const TileId&) { std::this_thread::sleep_for(std::chrono::milliseconds(20)); };
  std::atomic<int> got{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] { got += o.tiles.get(tile(3, 4)) ? 1 : 0; });
  for (std::thread& t : threads)
    t.join();
  EXPECT_EQ(got, 4);
  EXPECT_EQ(o.source->requests().at(tile(3, 4)), 1);
}

TEST(LayerTiles, staysWithinItsBudgetAndLoadsAgainWhatWasEvicted) {
  constexpr std::uint64_t kBudget = 100000;
  Opened o(kBudget);
  for (std::uint32_t i = 0; i < 320; ++i) {
    ASSERT_TRUE(o.tiles.get(tile(i % 32, i / 32)));
    ASSERT_LE(o.tiles.bytes(), kBudget * 11 / 10 + 100) << "after " << i;
  }
  ASSERT_TRUE(o.tiles.get(tile(0, 0)));
  EXPECT_EQ(o.source->requests().at(tile(0, 0)), 2);
  EXPECT_EQ(o.source->requests().at(tile(31, 9)), 1);
}

TEST(LayerTiles, aFailureIsToldOnceAndNotTriedAgain) {
  Opened o(20000);
  o.source->failing = {tile(1, 1)};
  EXPECT_FALSE(o.tiles.get(tile(1, 1)));
  for (std::uint32_t i = 0; i < 128; ++i)
    o.tiles.get(tile(i % 32, 8 + i / 32));
  EXPECT_FALSE(o.tiles.get(tile(1, 1)));
  EXPECT_EQ(o.source->requests().at(tile(1, 1)), 1);
  EXPECT_EQ(o.ledger->takeFailures().size(), 1u);
  EXPECT_EQ(o.tiles.storedLevel(tile(1, 1)), 4);
}

TEST(LayerTiles, aTileThatItsParentListsMustBeThere) {
  Opened o(1u << 20);
  const TileId gone = tile(1, 1);
  // The parent is read while all is well, and lists it.
  ASSERT_TRUE(o.tiles.get(gone.parent()));
  o.source->stored = [&](const TileId& id) { return !id.isDescendantOf(gone); };
  EXPECT_FALSE(o.tiles.get(gone));
  const auto failures = o.ledger->takeFailures();
  ASSERT_EQ(failures.size(), 1u);
  EXPECT_NE(failures[0].failure.message.find("tile 5/2/1/1 is missing"), std::string::npos)
      << failures[0].failure.message;
  // One that nobody lists is just not there.
  ASSERT_TRUE(o.tiles.get(tile(5, 5).parent()));
  const TileId none = tile(5, 5).child(0).child(0);
  EXPECT_FALSE(o.tiles.get(none));
  EXPECT_TRUE(o.ledger->takeFailures().empty());
}

TEST(LoadLedger, tellsNoSecrets) {
  LoadLedger ledger;
  ledger.add({.failure = {.code = io::Failure::Code::ioError,
                          .message = "the server refused it",
                          .where = "https://me:hidden@h/wms?LAYERS=a&access_token=hidden"}});
  const auto failures = ledger.takeFailures();
  ASSERT_EQ(failures.size(), 1u);
  const std::string& where = failures.front().failure.where;
  EXPECT_EQ(where.find("hidden"), std::string::npos) << where;
  EXPECT_NE(where.find("LAYERS=a"), std::string::npos) << where;
}

}  // namespace
}  // namespace tellurion::scene
