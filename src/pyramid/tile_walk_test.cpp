// The walk against a look at every tile of a level.
#include "pyramid/tile_walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "pyramid/database.h"
#include "pyramid/synthetic_rasters_test.h"

namespace tellurion::pyramid::testing {
namespace {

using tiling::Scheme;
using tiling::TileId;

constexpr std::size_t kMostOpen = 8;
constexpr std::size_t kCacheBytes = 1 << 20;

std::vector<TileId> tilesOfLevel(const tiling::Tiling& tiling, int level) {
  std::vector<TileId> tiles;
  const std::uint32_t side = 1u << static_cast<unsigned>(level);
  for (int root = 0; root < tiling.rootCount(); ++root) {
    for (std::uint32_t y = 0; y < side; ++y) {
      for (std::uint32_t x = 0; x < side; ++x)
        tiles.push_back({static_cast<std::uint8_t>(level), static_cast<std::uint8_t>(root), x, y});
    }
  }
  return tiles;
}

class TileWalkTest : public ::testing::TestWithParam<Scheme> {
 protected:
  /// A coarse one over the Alps and, far finer, one across the date line.
  BuildPlan plan() const {
    writeElevation(folder_ / "coarse.tif", degreesGrid(2, 40, 18, 50, 32, 20), [](int, int) { return 500.0; });
    writeElevation(folder_ / "fine.tif", degreesGrid(179, -1, 182, 2, 60, 60), [](int, int) { return 10.0; });
    BuildOptions options;
    options.inputs = {(folder_ / "coarse.tif").string(), (folder_ / "fine.tif").string()};
    options.output = folder_ / "out.tdb";
    options.scheme = GetParam();
    auto planned = planBuild(options, std::nullopt);
    EXPECT_TRUE(planned.has_value());
    return std::move(*planned);
  }
  static std::vector<Candidate> walked(const BuildPlan& plan, int level, TileDatabase* base = nullptr,
                                       std::int64_t after = 0) {
    InputSet inputs(plan, kMostOpen, kCacheBytes);
    TileWalk walk(plan, inputs, base, level, after);
    std::vector<Candidate> candidates;
    while (true) {
      auto next = walk.next();
      EXPECT_TRUE(next.has_value());
      if (!next || !*next) return candidates;
      candidates.push_back(std::move(**next));
    }
  }
  /// Whether any of many places of the tile lies in the input.
  static bool isReached(const BuildPlan& plan, int input, const TileId& id) {
    constexpr int kGrid = 24;
    const geo::GeoRect& bounds = plan.inputs[static_cast<std::size_t>(input)].bounds;
    const auto share = [](int i) { return (i + 0.5) / kGrid; };
    for (int row = 0; row < kGrid; ++row) {
      for (int column = 0; column < kGrid; ++column) {
        const auto g =
            geo::geodeticFromDirection(plan.tiling().direction(tiling::rootPointIn(id, share(column), share(row))));
        if (bounds.contains(g.lat, g.lon)) return true;
      }
    }
    return false;
  }
  static bool mayReach(const BuildPlan& plan, int input, const TileId& id) {
    return plan.inputs[static_cast<std::size_t>(input)].bounds.intersects(plan.tiling().bounds(id));
  }

  TemporaryFolder folder_;
};

TEST_P(TileWalkTest, FindsEveryTileThatADeepEnoughInputReaches) {
  const BuildPlan plan = this->plan();
  ASSERT_LT(plan.inputs[0].depth, plan.inputs[1].depth);
  for (int level = 0; level <= std::min(5, plan.deepestLevel); ++level) {
    std::map<TileId, std::vector<int>> found;
    for (const Candidate& candidate : walked(plan, level))
      found[candidate.id] = candidate.inputs;
    for (const TileId& id : tilesOfLevel(plan.tiling(), level)) {
      const auto candidate = found.find(id);
      bool isDue = false;
      for (const int input : {0, 1}) {
        if (!isReached(plan, input, id)) continue;
        isDue = isDue || plan.inputs[static_cast<std::size_t>(input)].depth >= level;
        // A tile that is made is told of every input that reaches it, the coarser ones too.
        if (candidate != found.end()) {
          EXPECT_EQ(std::ranges::count(candidate->second, input), 1);
        }
      }
      EXPECT_TRUE(!isDue || candidate != found.end()) << nameOf(id);
    }
  }
}

TEST_P(TileWalkTest, GoesNowhereElse) {
  const BuildPlan plan = this->plan();
  for (int level = 0; level <= plan.deepestLevel; ++level) {
    const auto candidates = walked(plan, level);
    EXPECT_FALSE(candidates.empty());
    for (const Candidate& candidate : candidates) {
      EXPECT_TRUE(std::ranges::any_of(candidate.inputs, [&](int input) {
        return plan.inputs[static_cast<std::size_t>(input)].depth >= level && mayReach(plan, input, candidate.id);
      })) << nameOf(candidate.id);
      for (const int input : candidate.inputs) {
        bool isNear = mayReach(plan, input, candidate.id);
        for (const tiling::Edge edge : tiling::kEdges)
          isNear = isNear || mayReach(plan, input, plan.tiling().edgeNeighbour(candidate.id, edge).tile);
        EXPECT_TRUE(isNear) << nameOf(candidate.id);
      }
    }
  }
}

TEST_P(TileWalkTest, InTheOrderOfRowsAndAgainFromAnyOfThem) {
  const BuildPlan plan = this->plan();
  const int level = plan.inputs[0].depth;
  const auto all = walked(plan, level);
  ASSERT_GT(all.size(), 4U);
  for (std::size_t i = 1; i < all.size(); ++i)
    ASSERT_LT(rowNumberOf(all[i - 1].id), rowNumberOf(all[i].id));
  for (std::size_t done = 0; done <= all.size(); done += 3) {
    const auto rest = walked(plan, level, nullptr, done == 0 ? 0 : rowNumberOf(all[done - 1].id));
    ASSERT_EQ(rest.size(), all.size() - done);
    for (std::size_t i = 0; i < rest.size(); ++i) {
      EXPECT_EQ(rest[i].id, all[done + i].id);
      EXPECT_EQ(rest[i].inputs, all[done + i].inputs);
    }
  }
}

TEST_P(TileWalkTest, TheEstimateOfFewIsTheirCount) {
  const BuildPlan plan = this->plan();
  InputSet inputs(plan, kMostOpen, kCacheBytes);
  for (int level = 0; level <= plan.deepestLevel; ++level) {
    const auto estimated = estimatedCandidates(plan, inputs, nullptr, level);
    ASSERT_TRUE(estimated.has_value());
    EXPECT_EQ(*estimated, walked(plan, level).size());
  }
}

TEST_P(TileWalkTest, AnInputThatIsGoneIsAFailure) {
  const BuildPlan plan = this->plan();
  std::filesystem::remove(folder_ / "fine.tif");
  InputSet inputs(plan, kMostOpen, kCacheBytes);
  TileWalk walk(plan, inputs, nullptr, plan.deepestLevel);
  io::Result<std::optional<Candidate>> next = walk.next();
  while (next && *next)
    next = walk.next();
  EXPECT_FALSE(next.has_value());
}

INSTANTIATE_TEST_SUITE_P(Tilings, TileWalkTest, ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion::pyramid::testing
