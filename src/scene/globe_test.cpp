#include "scene/globe.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <set>
#include <thread>
#include <unordered_set>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "scene/drawn_ground.h"
#include "scene/drawn_vertex.h"
#include "scene/procedural_source_test.h"
#include "scene/view_from_test.h"

namespace tellurion::scene {
namespace {

using namespace std::chrono_literals;
using tiling::Scheme;
using tiling::TileId;
using tiling::Tiling;

View randomView(std::mt19937_64& random) {
  const double height_m = 9000.0 * std::exp(geo::uniform(random, 0.0, 7.5));
  return viewFrom(geo::uniform(random, -90, 90), geo::uniform(random, -180, 180), height_m,
                  geo::uniform(random, 0, 360), geo::uniform(random, -90, -5));
}

struct Planet {
  std::shared_ptr<ProceduralSource> elevation;
  std::shared_ptr<ProceduralSource> imagery;
  std::unique_ptr<Globe> globe;
};

Planet planetOf(Scheme scheme, GlobeOptions options = {}, int depth = 6) {
  Planet p;
  p.elevation = std::make_shared<ProceduralSource>(raster::Kind::elevation, scheme, depth);
  p.imagery = std::make_shared<ProceduralSource>(raster::Kind::imagery, scheme, depth + 1);
  Scene scene;
  scene.tiling = scheme;
  GlobeLayers layers{.elevation = {p.elevation}, .imagery = {{.source = p.imagery}}};
  p.globe = Globe::fromLayers(scene, std::move(layers), options).value();
  return p;
}

const Frame& loaded(Globe& globe, const View& view, const CutOptions& options = {}) {
  const auto end = std::chrono::steady_clock::now() + 240s;
  while (std::chrono::steady_clock::now() < end) {
    const Frame& frame = globe.update(view, options);
    if (frame.complete) return frame;
    globe.waitForArrivals(1000ms);
  }
  ADD_FAILURE() << "never complete";
  return globe.update(view, options);
}

/// How many of the drawn tiles hold a place.
int coversOf(const std::unordered_set<TileId, tiling::TileIdHash>& drawn, const Tiling& tiling,
             const geo::Direction& d) {
  int covers = 0;
  const TileId deepest = tiling.tileAt(d, 20);
  for (int level = 0; level <= 20; ++level)
    covers += drawn.count(deepest.ancestor(level)) != 0 ? 1 : 0;
  return covers;
}

/// Where a point of the body is in the picture, pixels; nothing behind the eye.
std::optional<geo::Vec2> inPicture(const View& view, const geo::BodyPosition& p) {
  const geo::Vec3 v = view.viewFromBody * (p - view.eye);
  if (v.z > -1.0) return std::nullopt;
  const geo::Vec2 at = geo::Vec2(v.x, v.y) / (-v.z * view.pixelAngle());
  if (std::abs(at.x) > 0.5 * view.viewport.width || std::abs(at.y) > 0.5 * view.viewport.height) return std::nullopt;
  return at;
}

/// The hills there may be what the ray meets: they are neither beside the picture nor, being low, beyond the horizon.
bool mayShowHills(const View& view, const geo::Ellipsoid& earth, const geo::Direction& d) {
  constexpr double kDeepest_m = 5000.0;
  const geo::BodyPosition hill = earth.bodyFromDirection(d, hillsAt(d));
  return inPicture(view, hill) && !earth.horizon(view.eye, kDeepest_m).hides(hill);
}

/// Every place of the ellipsoid in the picture, with hills in it too, is covered by exactly one tile, and edges know
/// coarser neighbours.
void expectWhole(const Frame& frame, const Tiling& tiling, std::mt19937_64& random) {
  const geo::Ellipsoid earth = geo::earth().ellipsoid;
  std::unordered_set<TileId, tiling::TileIdHash> drawn;
  for (const DrawnTile& t : frame.tiles) {
    ASSERT_TRUE(drawn.insert(t.id).second);
    ASSERT_TRUE(t.mesh);
  }
  const geo::Mat3 bodyFromView = glm::transpose(frame.view.viewFromBody);
  const double y = std::tan(frame.view.verticalFov.radians() / 2);
  for (int i = 0; i < 400; ++i) {
    const geo::Vec3 sight =
        bodyFromView * geo::Vec3(geo::uniform(random, -y, y) * 4 / 3, geo::uniform(random, -y, y), -1.0);
    const auto hit = earth.intersect({frame.view.eye, sight});
    if (!hit) continue;
    const geo::Direction d = earth.directionFromBody(frame.view.eye + sight * *hit);
    if (!mayShowHills(frame.view, earth, d)) continue;
    ASSERT_EQ(coversOf(drawn, tiling, d), 1);
  }
  // The tiles of the margin are leaves of the cut too.
  for (const DrawnTile& t : frame.soon)
    drawn.insert(t.id);
  for (const DrawnTile& t : frame.tiles) {
    for (std::size_t e = 0; e < 4; ++e) {
      const TileId same = tiling.edgeNeighbour(t.id, tiling::kEdges[e]).tile;
      for (int level = 0; level + 1 < same.level; ++level)
        ASSERT_EQ(drawn.count(same.ancestor(level)), 0u) << "two levels apart";
      const bool coarser = same.level > 0 && drawn.count(same.parent()) != 0;
      ASSERT_EQ(((t.coarseEdges >> e) & 1) != 0, coarser);
    }
  }
}

using Bits = std::array<double, 3>;

/// That a side between two vertices lies on; nothing: inside of the tile.
std::optional<tiling::Edge> edgeOf(const TerrainVertex& a, const TerrainVertex& b) {
  if (a.t == 0 && b.t == 0) return tiling::Edge::top;
  if (a.s == kPlaceUnits && b.s == kPlaceUnits) return tiling::Edge::right;
  if (a.t == kPlaceUnits && b.t == kPlaceUnits) return tiling::Edge::bottom;
  if (a.s == 0 && b.s == 0) return tiling::Edge::left;
  return std::nullopt;
}

/// No crack: every side of a drawn triangle is the side of another one, the other way round and the same to the last
/// bit, unless what lies beyond is not drawn.
void expectWatertight(const Frame& frame, const Tiling& tiling) {
  std::set<TileId> drawn;
  std::set<std::pair<Bits, Bits>> sides;
  const auto forEachSide = [&](const auto& visit) {
    for (const DrawnTile& tile : frame.tiles) {
      const TerrainMesh& mesh = *tile.mesh;
      const auto place = [&](std::uint32_t i) {
        const geo::Vec3 p = drawnPosition(tile, mesh.vertices[mesh.indices[i]], frame).m;
        return Bits{p.x, p.y, p.z};
      };
      for (std::size_t group = 0; group < 5; ++group) {
        const bool coarse = group < 4 && ((tile.coarseEdges >> group) & 1) != 0;
        const IndexRange range = group == 4 ? mesh.interior : (coarse ? mesh.coarseEdge : mesh.fineEdge)[group];
        for (std::uint32_t i = range.first; i < range.first + range.count; i += 3) {
          for (std::uint32_t k = 0; k < 3; ++k)
            visit(tile, edgeOf(mesh.vertices[mesh.indices[i + k]], mesh.vertices[mesh.indices[i + (k + 1) % 3]]),
                  place(i + k), place(i + (k + 1) % 3));
        }
      }
    }
  };
  for (const DrawnTile& tile : frame.tiles)
    drawn.insert(tile.id);
  forEachSide([&](const DrawnTile&, std::optional<tiling::Edge>, const Bits& a, const Bits& b) {
    sides.insert({a, b});
  });
  int open = 0;
  forEachSide([&](const DrawnTile& tile, std::optional<tiling::Edge> edge, const Bits& a, const Bits& b) {
    if (a == b || sides.count({b, a}) != 0) return;
    bool isOpen = !edge;
    TileId beyond = edge ? tiling.edgeNeighbour(tile.id, *edge).tile : TileId{};
    for (; !isOpen && beyond.level > 0; beyond = beyond.parent())
      isOpen = drawn.count(beyond) != 0;
    open += isOpen || drawn.count(beyond) != 0 ? 1 : 0;
  });
  ASSERT_EQ(open, 0);
}

std::uint32_t trianglesIn(const Frame& frame) {
  std::uint32_t indices = 0;
  for (const DrawnTile& t : frame.tiles) {
    indices += t.mesh->interior.count;
    for (std::size_t e = 0; e < 4; ++e)
      indices += (((t.coarseEdges >> e) & 1) != 0 ? t.mesh->coarseEdge : t.mesh->fineEdge)[e].count;
  }
  return indices / 3;
}

class GlobeOnTiling : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(All, GlobeOnTiling, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

TEST_P(GlobeOnTiling, drawsTheWholeGlobeFromOrbit) {
  std::mt19937_64 random = geo::seededGenerator();
  Planet p = planetOf(GetParam());
  std::uint32_t most = 0;
  for (const auto& [lat, lon] : {std::pair(20, 10), {20, 80}, {90, 0}, {-90, 0}, {0, 130}, {-35, 130}, {60, -45}}) {
    const Frame& frame = loaded(*p.globe, viewFrom(lat, lon, 15e6, 0, -90));
    expectWhole(frame, Tiling(GetParam()), random);
    expectWatertight(frame, Tiling(GetParam()));
    EXPECT_LE(frame.statistics.maxScreenError_px, 1.0);
    const std::uint32_t triangles = trianglesIn(frame);
    EXPECT_LT(triangles, 6000u) << lat << ", " << lon;
    most = std::max(most, triangles);
  }
  std::printf("a globe from 15,000 km: %u triangles at most\n", most);
}

TEST_P(GlobeOnTiling, isWholeInEveryFrameWhileTilesArriveLateAndInRandomOrder) {
  std::mt19937_64 random = geo::seededGenerator();
  Planet p = planetOf(GetParam(), {.workers = 3, .cpuCacheBytes = std::uint64_t{4} << 30});
  std::atomic<unsigned> turn{0};
  p.elevation->delay = [&](const TileId&) {
    std::this_thread::sleep_for(std::chrono::microseconds((turn++ * 7919u) % 3000u));
  };
  const Tiling tiling(GetParam());
  // Whole means from when the roots are there.
  for (const double lon : {0.0, 90.0, 180.0, 270.0})
    loaded(*p.globe, viewFrom(0, lon, 30e6, 0, -90), {.tolerance_px = 1e6});
  for (int v = 0; v < 4; ++v) {
    const View view = randomView(random);
    for (int i = 0; i < 400; ++i) {
      const Frame& frame = p.globe->update(view, {.tolerance_px = 2.0});
      expectWhole(frame, tiling, random);
      if (i % 16 == 0) expectWatertight(frame, tiling);
      if (HasFatalFailure() || frame.complete) break;
      p.globe->waitForArrivals(20ms);
    }
  }
  for (const auto& source : {p.elevation, p.imagery}) {
    for (const auto& [id, count] : source->requests())
      EXPECT_EQ(count, 1) << "asked twice";
  }
}

/// The largest jump of a point of the ground between two frames of a flight, both seen from the later eye, pixels.
struct Jumps {
  double worst_px = 0.0;
  int compared = 0;
};

/// Descends over the hills, turning, 60 frames a second. `everyFrameWhole`: each frame waits for its data.
Jumps jumpsInFlight(Globe& globe, const Tiling& tiling, bool morph, bool everyFrameWhole, int frames,
                    bool remembers = true) {
  std::mt19937_64 random = geo::seededGenerator();
  std::vector<geo::Direction> places;
  for (int i = 0; i < 1500; ++i)
    places.push_back(geo::directionFromDegrees(47.0 + geo::uniform(random, -2, 2), 8.0 + geo::uniform(random, -2, 2)));
  std::vector<std::optional<geo::BodyPosition>> before(places.size());
  Jumps jumps;
  loaded(globe, viewFrom(46.6, 8.0, 4000e3, 0, -90));  // from when the roots are there
  for (int k = 0; k < frames; ++k) {
    const double t = k / 60.0;
    const View view = viewFrom(46.6 + 0.02 * t, 8.0, 80e3 * std::exp(-0.4 * t), 10.0 * t, -35);
    const CutOptions options{
        .tolerance_px = 3.0, .morph = morph, .time_s = remembers ? std::optional(t) : std::nullopt};
    const Frame* frame = &globe.update(view, options);
    for (int i = 0; everyFrameWhole && frame->statistics.tilesWanted > 0 && i < 1000; ++i) {
      globe.waitForArrivals(1000ms);
      frame = &globe.update(view, options);
    }
    if (!everyFrameWhole) globe.waitForArrivals(8ms);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto now = drawnPoint(*frame, tiling, places[i]);
      if (now && before[i]) {
        const auto a = inPicture(view, *before[i]);
        const auto b = inPicture(view, *now);
        if (a && b) {
          jumps.worst_px = std::max(jumps.worst_px, geo::length(*a - *b));
          ++jumps.compared;
        }
      }
      before[i] = now;
    }
  }
  return jumps;
}

TEST_P(GlobeOnTiling, nothingPopsInFlight) {
  Planet p = planetOf(GetParam());
  const Jumps jumps = jumpsInFlight(*p.globe, Tiling(GetParam()), true, true, 240);
  EXPECT_GT(jumps.compared, 10000);
  EXPECT_LE(jumps.worst_px, 0.5);
  Planet q = planetOf(GetParam());
  const Jumps without = jumpsInFlight(*q.globe, Tiling(GetParam()), false, true, 240);
  EXPECT_GT(without.worst_px, 0.5);
  std::printf("largest jump %.3f px, without morphing %.3f px\n", jumps.worst_px, without.worst_px);
  // By place alone, each frame for itself.
  const Jumps ofPlace = jumpsInFlight(*p.globe, Tiling(GetParam()), true, true, 240, false);
  EXPECT_LE(ofPlace.worst_px, 0.5);
  std::printf("largest jump of frames that remember nothing %.3f px\n", ofPlace.worst_px);
  // Tiles that come when they come, each asked for when it is missed.
  Planet late = planetOf(GetParam(), {.workers = 2});
  late.elevation->delay = [](const TileId&) { std::this_thread::sleep_for(2ms); };
  jumpsInFlight(*late.globe, Tiling(GetParam()), true, false, 240);
  EXPECT_GT(late.elevation->requests().size(), 50u);
  // Standing still, all comes and settles, and looks as if nothing had ever been different.
  const View last = viewFrom(46.6, 8.0, 17e3, 40.0, -35);
  const auto settled = [&](Globe& globe) {
    const Frame* frame = nullptr;
    int frames = 0;
    for (double t = 10.0; (frame == nullptr || !frame->complete) && frames < 2000; t += 1.0 / 60.0, ++frames) {
      frame = &globe.update(last, {.tolerance_px = 3.0, .time_s = t});
      globe.waitForArrivals(20ms);
    }
    EXPECT_TRUE(frame->complete) << frame->tiles.size() << " tiles, morphing " << frame->morphing;
    std::map<TileId, std::array<float, 4>> out;
    for (const DrawnTile& tile : frame->tiles)
      out.emplace(tile.id, tile.morph);
    return out;
  };
  Planet direct = planetOf(GetParam());
  EXPECT_EQ(settled(*late.globe), settled(*direct.globe));
}

/// It is not drawn as the mesh that was made with it: all of it is interior.
bool isPatched(const DrawnTile& tile) {
  return std::ranges::all_of(tile.mesh->fineEdge, [](const IndexRange& edge) { return edge.count == 0; });
}

/// Where the eye turns to, hardly anything has come yet: what was in the picture before stays as fine as it was, but
/// for what is fine enough coarser or on its way there.
TEST_P(GlobeOnTiling, groundThatWasFineStaysFineWhenTheEyeTurns) {
  std::mt19937_64 random = geo::seededGenerator();
  const Tiling tiling(GetParam());
  for (const double pitch : {-50.0, -15.0}) {
    Planet p = planetOf(GetParam(), {.workers = 2});
    const auto look = [&](double heading, double t) -> const Frame& {
      return p.globe->update(viewFrom(46.6, 8.0, 30e3, heading, pitch), {.time_s = t});
    };
    const auto end = std::chrono::steady_clock::now() + 240s;
    for (double t = 0.0; !look(0.0, t).complete && std::chrono::steady_clock::now() < end; t += 1.0)
      p.globe->waitForArrivals(20ms);
    std::set<TileId> before;
    for (const DrawnTile& tile : look(0.0, 1e6).tiles)
      before.insert(tile.id);
    int wanted = 0;
    int patches = 0;
    p.elevation->delay = [](const TileId&) { std::this_thread::sleep_for(30ms); };
    for (int k = 0; k < 5; ++k) {
      const Frame& frame = look(geo::uniform(random, -40, 40), 1e6 + k);
      expectWatertight(frame, tiling);
      for (const DrawnTile& tile : frame.tiles) {
        for (const TileId& id : before) {
          if (id.level > tile.id.level && id.isDescendantOf(tile.id)) {
            ASSERT_LE(tile.error_px, 2.0)
                << "was level " << static_cast<int>(id.level) << ", is " << static_cast<int>(tile.id.level);
          }
        }
      }
      wanted += frame.statistics.tilesWanted;
      patches += static_cast<int>(std::ranges::count_if(frame.tiles, isPatched));
    }
    EXPECT_GT(wanted, 0) << "else this says nothing";
    EXPECT_GT(patches, 0) << "likewise";
  }
}

/// With a clock no more is loaded of a view that stays than without: what it does not show is not held ready.
TEST_P(GlobeOnTiling, aViewByTheClockLoadsWhatItNeedsByPlace) {
  for (const auto& [height_m, pitch] : {std::pair(60e3, -35.0), {300e3, -60.0}}) {
    const View view = viewFrom(46.6, 8.0, height_m, 40.0, pitch);
    const Planet byPlace = planetOf(GetParam(), {.workers = 2});
    loaded(*byPlace.globe, view);
    const Planet byClock = planetOf(GetParam(), {.workers = 2});
    const auto end = std::chrono::steady_clock::now() + 30s;
    for (double t = 0.0; !byClock.globe->update(view, {.time_s = t}).complete; t += 0.1) {
      ASSERT_LT(std::chrono::steady_clock::now(), end) << "never complete";
      byClock.globe->waitForArrivals(20ms);
    }
    for (const auto source : {&Planet::elevation, &Planet::imagery}) {
      const std::size_t needed = ((byPlace.*source)->requests()).size();
      EXPECT_LE(((byClock.*source)->requests()).size(), needed + needed / 10);
    }
  }
}

TEST_P(GlobeOnTiling, regularMeshesAreWatertightToo) {
  std::mt19937_64 random = geo::seededGenerator();
  Planet p = planetOf(GetParam(), {.workers = 3, .regularMesh = true, .cpuCacheBytes = std::uint64_t{4} << 30});
  const Tiling tiling(GetParam());
  for (int v = 0; v < 2; ++v) {
    const View view = randomView(random);
    for (int i = 0; i < 400; ++i) {
      const Frame& frame = p.globe->update(view, {.tolerance_px = 16.0});
      if (i % 64 == 0 || frame.complete) expectWatertight(frame, tiling);
      if (HasFatalFailure() || frame.complete) break;
      p.globe->waitForArrivals(20ms);
    }
  }
}

TEST_P(GlobeOnTiling, theCompletedFrameDoesNotDependOnTheWayThere) {
  std::mt19937_64 random = geo::seededGenerator();
  const View view = randomView(random);
  const auto tilesOf = [&](const Frame& frame) {
    std::set<std::pair<TileId, int>> out;
    for (const DrawnTile& t : frame.tiles)
      out.insert({t.id, t.coarseEdges});
    return out;
  };
  Planet direct = planetOf(GetParam());
  const auto expected = tilesOf(loaded(*direct.globe, view));
  Planet wandering = planetOf(GetParam(), {.workers = 3});
  for (int i = 0; i < 5; ++i)
    wandering.globe->update(randomView(random));
  loaded(*wandering.globe, randomView(random));
  EXPECT_EQ(tilesOf(loaded(*wandering.globe, view)), expected);
}

TEST_P(GlobeOnTiling, groundHeightIsThatOfTheData) {
  std::mt19937_64 random = geo::seededGenerator();
  Planet p = planetOf(GetParam());
  const geo::Direction d = geo::directionFromDegrees(geo::uniform(random, -90, 90), geo::uniform(random, -180, 180));
  EXPECT_FALSE(p.globe->groundHeight_m(d));
  const geo::Geodetic g = geo::geodeticFromDirection(d);
  loaded(*p.globe, viewFrom(g.lat.degrees(), g.lon.degrees(), 20e3, 0, -90));
  EXPECT_NEAR(p.globe->groundHeight_m(d).value(), hillsAt(d), 30.0);
}

TEST(Globe, failingTilesAreReportedOnceAndDrawnFromAbove) {
  std::mt19937_64 random = geo::seededGenerator();
  Planet p = planetOf(Scheme::cube);
  const geo::Direction d = geo::directionFromDegrees(12, 34);
  const Tiling tiling(Scheme::cube);
  p.elevation->failing = {tiling.tileAt(d, 3)};
  p.imagery->failing = {tiling.tileAt(d, 2)};
  for (int i = 0; i < 3; ++i) {
    expectWhole(loaded(*p.globe, viewFrom(12, 34, 100e3, 0, -60)), tiling, random);
    loaded(*p.globe, viewFrom(12.5, 34, 120e3, 0, -70));
  }
  EXPECT_EQ(p.globe->failures().size(), 2u);
  EXPECT_EQ(p.elevation->requests().at(tiling.tileAt(d, 3)), 1);
  EXPECT_EQ(p.imagery->requests().at(tiling.tileAt(d, 2)), 1);
}

TEST(Globe, aSourceThatFailsAltogetherLeavesABareGlobe) {
  std::mt19937_64 random = geo::seededGenerator();
  Planet p = planetOf(Scheme::healpix);
  for (std::uint8_t root = 0; root < 12; ++root) {
    p.elevation->failing.insert(TileId{.level = 0, .root = root});
    p.imagery->failing.insert(TileId{.level = 0, .root = root});
  }
  expectWhole(loaded(*p.globe, viewFrom(0, 0, 15e6, 0, -90)), Tiling(Scheme::healpix), random);
  EXPECT_GE(p.globe->failures().size(), 2u);
}

TEST(Globe, whatIsNoLongerWantedIsCancelled) {
  Planet p = planetOf(Scheme::cube, {.workers = 1}, 9);
  loaded(*p.globe, viewFrom(0, 0, 15e6, 0, -90));
  p.elevation->delay = [](const TileId&) { std::this_thread::sleep_for(2ms); };
  for (int i = 0; i < 60; ++i)
    p.globe->update(viewFrom(-60, i * 6.0, 10e3, 0, -40));
  const auto before = p.elevation->requests().size();
  loaded(*p.globe, viewFrom(50, 100, 4000, 0, -90));
  const auto after = p.elevation->requests().size();
  EXPECT_LT(after - before, 400u);
}

TEST(Globe, bareEllipsoidNeedsNoLayers) {
  std::mt19937_64 random = geo::seededGenerator();
  Scene scene;
  const auto globe = Globe::fromLayers(scene, {}).value();
  const Frame& frame = loaded(*globe, viewFrom(10, 20, 2e6, 30, -50));
  expectWhole(frame, Tiling(scene.tiling), random);
  EXPECT_EQ(globe->groundHeight_m(geo::directionFromDegrees(10, 20)), 0.0);
}

TEST(Globe, staysWithinItsByteBudget) {
  Planet p = planetOf(Scheme::cube, {.workers = 2, .cpuCacheBytes = 80u << 20});
  std::uint64_t peak = 0;
  for (int i = 0; i < 24; ++i) {
    loaded(*p.globe, viewFrom(-60 + i * 5, i * 15.0, 40e3, 0, -60));
    peak = std::max(peak, p.globe->update(viewFrom(-60 + i * 5, i * 15.0, 40e3, 0, -60)).statistics.cpuCacheBytes);
  }
  EXPECT_LT(peak, std::uint64_t{81} << 20);
}

/// What a globe holds of a view that stays, by the clock, when all that it needs is there.
std::uint64_t heldAtRest_bytes(const GlobeOptions& options, const View& view) {
  const Planet p = planetOf(Scheme::cube, options);
  for (int i = 1; i < 1000; ++i) {
    const Frame& frame = p.globe->update(view, {.time_s = 0.1 * i});
    if (frame.complete) return frame.statistics.cpuCacheBytes;
    p.globe->waitForArrivals(10ms);
  }
  ADD_FAILURE() << "never complete";
  return 0;
}

/// Looking ahead holds tiles from update to update, and keeps pointers to them: under a budget that drops them all the
/// time none may go that it needs, and what it holds is soon let go: no more stays than what a view of the flight needs
/// at rest, and the budget. Under a sanitizer this finds a tile that went too early.
TEST(Globe, staysNearItsByteBudgetWhileItLooksAhead) {
  const GlobeOptions options{.workers = 2, .cpuCacheBytes = 24u << 20};
  constexpr int kFrames = 120;
  const auto viewAt = [](double time_s) { return viewFrom(20 + 1.5 * time_s, 15 + 4.0 * time_s, 60e3, 40, -35); };
  for (const double fps : {30.0, 4.0}) {
    std::uint64_t needed = 0;
    for (int i = 0; i < kFrames; i += 40)
      needed = std::max(needed, heldAtRest_bytes(options, viewAt(i / fps)));
    const Planet p = planetOf(Scheme::cube, options);
    std::uint64_t peak = 0;
    for (int i = 0; i < kFrames; ++i) {
      const double time_s = i / fps;
      const Frame& frame = p.globe->update(viewAt(time_s), {.time_s = time_s});
      peak = std::max(peak, frame.statistics.cpuCacheBytes);
      std::this_thread::sleep_for(10ms);  // some tiles come
    }
    expectWatertight(p.globe->update(viewAt(0.0)), Tiling(Scheme::cube));
    std::printf("at %.0f frames a second at most %.1f MiB, a view needs %.1f\n", fps,
                static_cast<double>(peak) / (1u << 20u), static_cast<double>(needed) / (1u << 20u));
    EXPECT_LT(peak, needed + options.cpuCacheBytes);
  }
}

/// Whatever comes when: what an update leaves is within the budget, but for what is in use, which is told.
TEST_P(GlobeOnTiling, noUpdateLeavesMoreThanItsByteBudget) {
  constexpr std::uint64_t kBudget = std::uint64_t{96} << 20;
  Planet p = planetOf(GetParam(), {.workers = 2, .cpuCacheBytes = kBudget});
  std::atomic<unsigned> turn{0};
  p.imagery->delay = [&](const TileId&) {
    std::this_thread::sleep_for(std::chrono::microseconds((turn++ * 7919u) % 3000u));
  };
  std::uint64_t peak = 0;
  for (int stop = 0; stop < 12; ++stop) {
    for (int i = 0; i < 20; ++i) {
      const View view = viewFrom(-60 + 10 * stop + 0.02 * i, 30.0 * stop, 40e3, 0, -60);
      const FrameStatistics& s = p.globe->update(view, {.time_s = stop + 0.03 * i}).statistics;
      ASSERT_LE(s.cpuCacheBytes, kBudget);
      ASSERT_EQ(s.cpuCacheOver_bytes, 0u);
      peak = std::max(peak, s.cpuCacheBytes);
      p.globe->waitForArrivals(20ms);
    }
  }
  EXPECT_GT(peak, kBudget / 2) << "nothing had to go";
}

TEST(Globe, aBudgetTooSmallForTheViewStillCompletesAndIsTold) {
  constexpr std::uint64_t kBudget = 1u << 20;
  Planet p = planetOf(Scheme::cube, {.workers = 2, .cpuCacheBytes = kBudget});
  const FrameStatistics& s = loaded(*p.globe, viewFrom(30, 15, 40e3, 0, -60)).statistics;
  EXPECT_GT(s.cpuCacheOver_bytes, 0u);
  EXPECT_EQ(s.cpuCacheBytes, kBudget + s.cpuCacheOver_bytes);
}

/// A planet that is bare but for a plateau at 4000 m around latitude and longitude 30.
Planet plateauOf(Scheme scheme, int depth) {
  Planet p;
  p.elevation = std::make_shared<ProceduralSource>(raster::Kind::elevation, scheme, depth);
  const geo::Direction middle = geo::directionFromDegrees(30, 30);
  const Tiling tiling(scheme);
  p.elevation->height = [=](const geo::Direction& d) {
    return geo::angleBetween(d, middle).degrees() < 0.4 ? 4000.0 : std::nan("");
  };
  p.elevation->stored = [=](const TileId& id) {
    const auto cap = tiling.cap(id);
    return geo::angleBetween(cap.centre, middle).degrees() < cap.radius.degrees() + 0.4;
  };
  Scene scene;
  scene.tiling = scheme;
  p.globe = Globe::fromLayers(scene, {.elevation = {p.elevation}, .imagery = {}}).value();
  return p;
}

TEST_P(GlobeOnTiling, theCliffAroundDataIsNotRefinedForEver) {
  Planet p = plateauOf(GetParam(), 9);
  const Frame& frame = loaded(*p.globe, viewFrom(29.5, 30, 30e3, 0, -45));
  expectWatertight(frame, Tiling(GetParam()));
  EXPECT_FALSE(frame.statistics.cappedByBudget);
  EXPECT_LE(frame.statistics.maxScreenError_px, 1.0);
  EXPECT_LT(frame.tiles.size(), 1500u);
  std::printf("a plateau's cliff: %zu tiles\n", frame.tiles.size());
}

TEST(Globe, aFrameThatSpendsItsBudgetOfTilesIsNotComplete) {
  Planet p = planetOf(Scheme::cube);
  const View view = viewFrom(30, 15, 40e3, 0, -60);
  loaded(*p.globe, view);
  const Frame& frame = p.globe->update(view, {.maxTiles = 10});
  EXPECT_FALSE(frame.complete);
  EXPECT_TRUE(frame.statistics.cappedByBudget);
  EXPECT_EQ(frame.statistics.tilesWanted, 0);
  EXPECT_GT(frame.statistics.maxScreenError_px, 1.0);
  EXPECT_TRUE(p.globe->update(view).complete);
}

/// Mountains of a small body, higher than what is assumed of a root that has not come: they rise over the limb from
/// behind.
TEST(Globe, rootsTallerThanAnyoneAssumesAreDrawn) {
  const Tiling tiling(Scheme::cube);
  const TileId behind = tiling.tileAt(geo::directionFromDegrees(0, 180), 0);
  Scene scene;
  scene.body = {.name = "pebble", .ellipsoid = geo::Ellipsoid(100e3, 0.0)};
  const auto source = std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 0, scene.body);
  source->height = [&](const geo::Direction& d) { return tiling.tileAt(d, 0) == behind ? 150e3 : 0.0; };
  const auto globe = Globe::fromLayers(scene, {.elevation = {source}, .imagery = {}}).value();
  const Camera camera{.position = {.height_m = 300e3}, .heading = {}, .pitch = geo::Angle::degrees(-90), .roll = {}};
  const View view = viewOf(camera, scene.body.ellipsoid, geo::Angle::degrees(45.0), {.width = 1024, .height = 768});
  const Frame& frame = loaded(*globe, view, {.tolerance_px = 1000.0});
  EXPECT_TRUE(std::any_of(frame.tiles.begin(), frame.tiles.end(),
                          [&](const DrawnTile& t) { return t.id.root == behind.root; }));
}

TEST(Globe, layersOfAnotherTilingOrBodyAreRefused) {
  Scene scene;
  scene.tiling = Scheme::healpix;
  const auto source = std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 3);
  const auto globe = Globe::fromLayers(scene, {.elevation = {source}, .imagery = {}});
  ASSERT_FALSE(globe);
  EXPECT_NE(globe.error().message.find("--tiling healpix"), std::string::npos);
  scene.tiling = Scheme::cube;
  scene.body = geo::mars();
  EXPECT_FALSE(Globe::fromLayers(scene, {.elevation = {source}, .imagery = {}}));
  scene.body = geo::earth();
  EXPECT_FALSE(Globe::fromLayers(scene, {.elevation = {}, .imagery = {{.source = source}}}));
}

TEST(Globe, deepZoomGoesOnBeyondTheData) {
  std::mt19937_64 random = geo::seededGenerator();
  Planet p = planetOf(Scheme::cube);
  const double ground = hillsAt(geo::directionFromDegrees(40, 40));
  const View view = viewFrom(40, 40, ground + 150.0, 20, -10);
  const Frame& frame = loaded(*p.globe, view);
  expectWhole(frame, Tiling(Scheme::cube), random);
  expectWatertight(frame, Tiling(Scheme::cube));
  EXPECT_LE(frame.statistics.maxScreenError_px, 1.0);
  std::printf("close to the ground: tiles %zu, deepest %d, update %.3f ms\n", frame.tiles.size(),
              static_cast<int>(std::max_element(frame.tiles.begin(), frame.tiles.end(),
                                                [](const auto& a, const auto& b) { return a.id.level < b.id.level; })
                                   ->id.level),
              p.globe->update(view).statistics.update_ms);
}

}  // namespace
}  // namespace tellurion::scene
