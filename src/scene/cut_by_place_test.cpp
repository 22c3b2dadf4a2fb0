// Cuts that depend on their view alone: from frame to frame nothing jumps, and views from one eye agree.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <vector>

#include "scene/fake_tree_test.h"

namespace tellurion::scene {
namespace {

/// Errors fall from level to level, here faster, there slower.
double roughnessOf(const TileId& id) {
  double roughness = 1.0;
  for (int level = 1; level <= id.level; ++level) {
    const std::size_t dice = tiling::TileIdHash{}(id.ancestor(level)) * 0x9e3779b97f4a7c15u;
    roughness *= 0.7 + 0.7 * static_cast<double>(dice >> 40) / static_cast<double>(1 << 24);
  }
  return 4.0 * std::clamp(roughness, 0.05, 5.0);
}

/// Of which surface the ground is drawn at a place: a whole number where it is that of a level, on the way from its
/// parent's to its own in between. The same whichever of two tiles is said to lie there, if they look alike.
std::optional<double> surfaceAt(const Selection& s, const Tiling& tiling, const geo::Direction& d) {
  const tiling::RootPoint p = tiling.rootPoint(d);
  for (const SelectedTile& tile : s.drawn) {
    const double size = tiling::tileSize(tile.id.level);
    const double right = p.u / size - tile.id.x;
    const double down = p.v / size - tile.id.y;
    if (tile.id.root != p.root || std::min(right, down) < 0.0 || std::max(right, down) > 1.0) continue;
    const auto& m = tile.morph;
    const double top = std::lerp(static_cast<double>(m[0]), static_cast<double>(m[1]), right);
    const double bottom = std::lerp(static_cast<double>(m[2]), static_cast<double>(m[3]), right);
    return tile.id.level - 1 + std::lerp(top, bottom, down);
  }
  return std::nullopt;
}

bool isInPicture(const View& view, const geo::BodyPosition& p) {
  const geo::Vec3 v = view.viewFromBody * (p - view.eye);
  const double half_px = -v.z * view.pixelAngle() / 2.0;
  return v.z < 0.0 && std::abs(v.x) <= half_px * view.viewport.width && std::abs(v.y) <= half_px * view.viewport.height;
}

class CutByPlace : public testing::TestWithParam<Scheme> {
 protected:
  CutByPlace() { tree_.roughness = roughnessOf; }

  const Selection& cut(const View& view, const CutOptions& options) {
    return selector_.select(view, options, 500.0, tree_);
  }

  Tiling tiling_{GetParam()};
  FakeTree tree_{tiling_};
  Selector selector_{tiling_, kEarth};
};

INSTANTIATE_TEST_SUITE_P(All, CutByPlace, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

/// A tile is split, or takes the place of its children, only where both look the same, for whoever's sake it is.
TEST_P(CutByPlace, nothingJumps) {
  constexpr int kWalks = 4;
  constexpr int kSteps = 200;
  constexpr int kPlaces = 100;
  constexpr double kStep = 2e-4;  // of the way down to the highest ground
  constexpr double kHighest_m = 9000.0;
  constexpr double kMostJump = 0.15;
  std::mt19937_64 random = geo::seededGenerator();
  double worst = 0.0;
  double moved = 0.0;
  for (int walk = 0; walk < kWalks; ++walk) {
    const double height_m = kHighest_m + std::exp(geo::uniform(random, 8.0, 12.0));
    const double step_deg = kStep * (height_m - kHighest_m) / 111e3;
    const double lat = geo::uniform(random, -80.0, 80.0);
    const double lon = geo::uniform(random, -180.0, 180.0);
    const double heading = geo::uniform(random, 0.0, 360.0);
    const double pitch = geo::uniform(random, -60.0, -20.0);
    const auto viewAt = [&](int i) {
      return viewOver(lat + i * step_deg, lon, height_m - i * kStep * (height_m - kHighest_m), heading + i * 0.003,
                      pitch);
    };
    std::vector<geo::Direction> places;
    for (int k = 0; k < kPlaces; ++k) {
      const View view = viewAt(0);
      const double reach = view.pixelAngle() / 2.0;
      const geo::Vec3 way(geo::uniform(random, -1.0, 1.0) * reach * view.viewport.width,
                          geo::uniform(random, -1.0, 1.0) * reach * view.viewport.height, -1.0);
      const geo::Ray ray{view.eye, geo::normalize(glm::transpose(view.viewFromBody) * way)};
      if (const auto meets = kEarth.intersect(ray))
        places.push_back(kEarth.directionFromBody(ray.origin + ray.direction * *meets));
    }
    std::vector<std::optional<double>> before(places.size());
    for (int i = 0; i < kSteps; ++i) {
      const View view = viewAt(i);
      const Selection& now = cut(view, {.tolerance_px = 2.0, .maxTiles = 100000});
      for (std::size_t k = 0; k < places.size(); ++k) {
        const bool isSeen = isInPicture(view, kEarth.bodyFromDirection(places[k], 0.0));
        const auto surface = isSeen ? surfaceAt(now, tiling_, places[k]) : std::nullopt;
        const double jump = surface && before[k] ? std::abs(*surface - *before[k]) : 0.0;
        EXPECT_LE(jump, kMostJump) << "walk " << walk << ", step " << i << ", at " << *surface;
        worst = std::max(worst, jump);
        moved += jump;
        before[k] = surface;
      }
    }
  }
  std::printf(
      "largest step of a place %.3f of the way from one level's surface to the next; all together %.0f levels\n", worst,
      moved);
  EXPECT_GT(moved, 3.0);
}

/// The six views that together are all that an eye sees, turned anyhow.
std::array<View, 6> allAround(const geo::BodyPosition& eye, const geo::Mat3& turn, int size) {
  const std::array<std::array<geo::Vec3, 2>, 6> kRightAndUp{{{geo::Vec3(1, 0, 0), geo::Vec3(0, 1, 0)},
                                                             {geo::Vec3(-1, 0, 0), geo::Vec3(0, 1, 0)},
                                                             {geo::Vec3(0, 1, 0), geo::Vec3(0, 0, 1)},
                                                             {geo::Vec3(0, -1, 0), geo::Vec3(0, 0, 1)},
                                                             {geo::Vec3(0, 0, 1), geo::Vec3(1, 0, 0)},
                                                             {geo::Vec3(0, 0, -1), geo::Vec3(1, 0, 0)}}};
  std::array<View, 6> views;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const geo::Vec3 right = turn * kRightAndUp[i][0];
    const geo::Vec3 up = turn * kRightAndUp[i][1];
    views[i] = {.eye = eye,
                .viewFromBody = glm::transpose(geo::Mat3(right, up, geo::cross(right, up))),
                .verticalFov = geo::Angle::degrees(90.0),
                .viewport = {.width = size, .height = size}};
  }
  return views;
}

const SelectedTile* tileAt(const Selection& s, const Tiling& tiling, const geo::Direction& d) {
  for (const SelectedTile& tile : s.drawn) {
    if (tiling.tileAt(d, tile.id.level) == tile.id) return &tile;
  }
  return nullptr;
}

/// How far two pictures are apart where they meet.
struct Apart {
  long places = 0;
  long inLevel = 0;
  int mostLevels = 0;
  float mostMorph = 0.0f;  ///< of what is of one level

  void count(const SelectedTile& a, const SelectedTile& b) {
    ++places;
    const int levels = std::abs(a.id.level - b.id.level);
    inLevel += levels > 0 ? 1 : 0;
    mostLevels = std::max(mostLevels, levels);
    for (std::size_t c = 0; levels == 0 && c < a.morph.size(); ++c)
      mostMorph = std::max(mostMorph, std::abs(a.morph[c] - b.morph[c]));
  }
};

/// Six pictures around an eye, some along the axes of the body, some turned anyhow, compared along the twelve sides
/// where two of them meet.
class Dome : public CutByPlace {
 protected:
  static constexpr double kTolerance_px = 4.0;

  Apart compared(double margin) {
    constexpr int kDomes = 6;
    std::mt19937_64 random = geo::seededGenerator();
    Apart apart;
    for (int i = 0; i < kDomes; ++i) {
      const double height_m = 9000.0 + std::exp(geo::uniform(random, 7.0, 14.0));
      const geo::BodyPosition eye =
          viewOver(geo::uniform(random, -90.0, 90.0), geo::uniform(random, -180.0, 180.0), height_m, 0, 0).eye;
      const geo::Mat3 turn = i % 2 == 0 ? geo::Mat3(1.0) : randomView(random).viewFromBody;
      const auto views = allAround(eye, turn, 1024);
      std::array<Selection, 6> cuts;
      for (std::size_t k = 0; k < views.size(); ++k) {
        cuts[k] = cut(views[k], {.tolerance_px = kTolerance_px, .maxTiles = 100000, .margin = margin});
        EXPECT_LE(cuts[k].maxScreenError_px, kTolerance_px * (1.0 + 1e-9));
      }
      for (std::size_t a = 0; a < views.size(); ++a) {
        for (std::size_t b = a + 1; b < views.size(); ++b)
          alongTheSide(views[a], views[b], cuts[a], cuts[b], random, apart);
      }
    }
    return apart;
  }

 private:
  void alongTheSide(const View& a, const View& b, const Selection& cutA, const Selection& cutB, std::mt19937_64& random,
                    Apart& apart) {
    constexpr int kPlaces = 200;
    const geo::Vec3 lookA = -glm::transpose(a.viewFromBody)[2];
    const geo::Vec3 lookB = -glm::transpose(b.viewFromBody)[2];
    if (geo::dot(lookA, lookB) < -0.5) return;  // back to back
    const geo::Vec3 side = geo::cross(lookA, lookB);
    for (int k = 0; k < kPlaces; ++k) {
      const geo::Ray ray{a.eye, geo::normalize(lookA + lookB + side * geo::uniform(random, -1.0, 1.0))};
      const auto meets = kEarth.intersect(ray);
      if (!meets) continue;
      const geo::Direction d = kEarth.directionFromBody(ray.origin + ray.direction * *meets);
      const SelectedTile* inA = tileAt(cutA, tiling_, d);
      const SelectedTile* inB = tileAt(cutB, tiling_, d);
      ASSERT_TRUE(inA != nullptr && inB != nullptr);
      apart.count(*inA, *inB);
    }
  }
};
INSTANTIATE_TEST_SUITE_P(All, Dome, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

/// Chosen all around the eye, tiles and how they morph are a function of the eye alone, to the last bit.
TEST_P(Dome, picturesChosenAllAroundAreOne) {
  const Apart apart = compared(std::numeric_limits<double>::infinity());
  EXPECT_GT(apart.places, 3000);
  EXPECT_EQ(apart.inLevel, 0);
  EXPECT_EQ(apart.mostMorph, 0.0f);
}

/// And one eye that sees all around has just these, so one cut serves all faces of a dome's picture.
TEST_P(Dome, anEyeThatSeesAllAroundDrawsTheSame) {
  std::mt19937_64 random = geo::seededGenerator();
  for (const double height_m : {10000.0, 50000.0, 3e6}) {
    const geo::BodyPosition eye =
        viewOver(geo::uniform(random, -90.0, 90.0), geo::uniform(random, -180.0, 180.0), height_m, 0, 0).eye;
    const auto views = allAround(eye, randomView(random).viewFromBody, 1024);
    View around = views[0];
    around.isAllAround = true;
    const CutOptions options{.tolerance_px = kTolerance_px, .maxTiles = 100000};
    const Selection whole = cut(around, options);
    std::size_t drawn = 0;
    for (const View& view : views) {
      CutOptions infinite = options;
      infinite.margin = std::numeric_limits<double>::infinity();
      for (const SelectedTile& tile : cut(view, infinite).drawn) {
        const auto same = std::ranges::find(whole.drawn, tile.id, &SelectedTile::id);
        ASSERT_TRUE(same != whole.drawn.end());
        EXPECT_EQ(same->morph, tile.morph);
        ++drawn;
      }
    }
    EXPECT_GE(drawn, whole.drawn.size());
  }
}

/// Else each is within the tolerance, and what neighbours beyond one of the pictures ask for may differ by a level.
TEST_P(Dome, othersAreALevelApartAtMost) {
  const Apart apart = compared(CutOptions{}.margin);
  std::printf("%ld of %ld places are of another level\n", apart.inLevel, apart.places);
  EXPECT_LE(apart.mostLevels, 1);
  EXPECT_LE(5 * apart.inLevel, apart.places);
}

}  // namespace
}  // namespace tellurion::scene
