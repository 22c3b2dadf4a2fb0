#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <map>
#include <set>
#include <string>
#include <thread>

#include "geo/body.h"
#include "io/other_threads_test.h"
#include "scene/globe.h"
#include "scene/remote_source_test.h"
#include "scene/screen_share.h"
#include "scene/view_from_test.h"

namespace tellurion::scene {
namespace {

using namespace std::chrono_literals;
using tiling::Scheme;
using tiling::TileId;
using Order = FakeServer::Order;

std::vector<geo::Direction> placesIn(const View& view) {
  constexpr int kColumns = 40;
  constexpr int kRows = 30;
  const geo::Ellipsoid earth = geo::earth().ellipsoid;
  const geo::Mat3 bodyFromView = glm::transpose(view.viewFromBody);
  const double y = std::tan(view.verticalFov.radians() / 2);
  const double x = y * view.viewport.width / view.viewport.height;
  std::vector<geo::Direction> out;
  for (int i = 0; i < kColumns * kRows; ++i) {
    const double right = 2.0 * (i % kColumns + 0.5) / kColumns - 1.0;
    const double up = 1.0 - 2.0 * (i / kColumns + 0.5) / kRows;
    const geo::Vec3 sight = bodyFromView * geo::Vec3(x * right, y * up, -1.0);
    if (const auto hit = earth.intersect({view.eye, sight}))
      out.push_back(earth.directionFromBody(view.eye + sight * *hit));
  }
  return out;
}

std::vector<TileId> tilesAt(const Frame& frame, const std::vector<geo::Direction>& places) {
  const tiling::Tiling tiling(Scheme::cube);
  std::set<TileId> drawn;
  for (const DrawnTile& tile : frame.tiles)
    drawn.insert(tile.id);
  std::vector<TileId> out;
  for (const geo::Direction& d : places) {
    TileId tile = tiling.tileAt(d, 20);
    while (tile.level > 0 && drawn.count(tile) == 0)
      tile = tile.parent();
    out.push_back(tile);
  }
  return out;
}

struct Planet {
  explicit Planet(Order order = Order::mostUrgent)
      : server(
            std::make_shared<FakeServer>(FakeServer::Line{.cancels = order == Order::mostUrgent, .remembers = true})),
        elevation(std::make_shared<RemoteSource>(
            std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 8), server)),
        imagery(std::make_shared<RemoteSource>(
            std::make_shared<ProceduralSource>(raster::Kind::imagery, Scheme::cube, 10), server)) {
    Scene scene;
    globe = Globe::fromLayers(scene, {.elevation = {elevation}, .imagery = {{.source = imagery}}, .resources = {}},
                              {.workers = 1, .cpuCacheBytes = std::uint64_t{4} << 30})
                .value();
  }
  /// Lets workers finish all that they can without the server, however busy the machine is.
  const Frame& settled(const View& view) {
    for (;;) {
      const Frame& frame = globe->update(view, {.morph = false});
      while (!io::othersSleep())
        std::this_thread::sleep_for(100us);
      if (!globe->waitForArrivals(0ms)) return frame;
    }
  }
  std::shared_ptr<FakeServer> server;
  std::shared_ptr<RemoteSource> elevation;
  std::shared_ptr<RemoteSource> imagery;
  std::unique_ptr<Globe> globe;
};

/// A line that brings one tile a tick. Passes by some views, then stays; counts the ticks from there until 90% of the
/// picture are final.
int ticksUntilFinal(Order order, const std::vector<View>& before, const View& view,
                    const std::vector<geo::Direction>& places, const std::vector<TileId>& final) {
  constexpr int kTicksEach = 12;
  constexpr int kMost = 3000;
  Planet p(order);
  for (const View& passing : before) {
    for (int tick = 0; tick < kTicksEach; ++tick) {
      p.server->serve(1, order);
      p.settled(passing);
    }
  }
  for (int tick = 0; tick < kMost; ++tick) {
    const std::vector<TileId> now = tilesAt(p.settled(view), places);
    std::size_t same = 0;
    for (std::size_t i = 0; i < final.size(); ++i)
      same += now[i] == final[i] ? 1u : 0u;
    if (10 * same >= 9 * final.size()) return tick;
    p.server->serve(1, order);
  }
  return kMost;
}

/// Ticks for the tiles that a picture of which 90% are final is made of, those over them and those that replace a tile
/// together, in the order that takes fewest: one after the other what is the largest part of the picture for each that
/// is still to come. asked: how often each tile is asked for.
int fewestTicks(const std::vector<TileId>& final, const std::map<TileId, int>& asked) {
  std::map<TileId, int> places;
  for (const TileId& tile : final)
    ++places[tile];
  std::set<TileId> here;
  const auto ticksFor = [&](const TileId& tile, bool take) {
    int ticks = 0;
    const auto add = [&](const TileId& each) {
      if (here.count(each) != 0 || asked.count(each) == 0) return;
      ticks += asked.at(each);
      if (take) here.insert(each);
    };
    add(tile.ancestor(0));
    for (int level = 1; level <= tile.level; ++level) {
      for (int q = 0; q < 4; ++q)
        add(tile.ancestor(level - 1).child(q));
    }
    return ticks;
  };
  int ticks = 0;
  for (std::size_t same = 0; 10 * same < 9 * final.size();) {
    const auto best = std::max_element(places.begin(), places.end(), [&](const auto& a, const auto& b) {
      return a.second * ticksFor(b.first, false) < b.second * ticksFor(a.first, false);
    });
    ticks += ticksFor(best->first, true);
    same += static_cast<std::size_t>(best->second);
    places.erase(best);
  }
  return ticks;
}

/// The time until 90% are final, as a share of that with a line that brings things in the order in which they were
/// asked for, and cancels nothing. Neither brings anything twice.
double shareOfTime(const char* name, const std::vector<View>& before, const View& view) {
  const auto places = placesIn(view);
  Planet all;
  const auto end = std::chrono::steady_clock::now() + 240s;
  while (!all.settled(view).complete && std::chrono::steady_clock::now() < end)
    all.server->serve(1000);
  const auto final = tilesAt(all.settled(view), places);
  const int urgent = ticksUntilFinal(Order::mostUrgent, before, view, places, final);
  const int inOrder = ticksUntilFinal(Order::firstCome, before, view, places, final);
  std::printf("%s: 90%% final after %d ticks, in the order of asking %d; needed at the least, from nothing, %d\n", name,
              urgent, inOrder, fewestTicks(final, all.server->asked()));
  return static_cast<double>(urgent) / inOrder;
}

TEST(RequestOrder, afterAFlightNinetyPercentAreFinalInHalfTheTime) {
  std::vector<View> flight;
  for (int i = 0; i < 20; ++i)
    flight.push_back(viewFrom(42.6 + 0.2 * i, 8.0, 20e3, 0, -25));
  EXPECT_LE(shareOfTime("flight", flight, viewFrom(46.6, 8.0, 20e3, 0, -25)), 0.5);
}

/// Much of what was asked for on the way is in the last picture too, so the order has less to save.
TEST(RequestOrder, afterALookAroundNinetyPercentAreFinalInThreeFifthsOfTheTime) {
  std::vector<View> around;
  for (int i = 0; i < 8; ++i)
    around.push_back(viewFrom(46.6, 8.0, 20e3, 20 + 45 * i, -12));
  EXPECT_LE(shareOfTime("look around", around, viewFrom(46.6, 8.0, 20e3, 20, -12)), 0.6);
}

/// All that is asked for is of the picture, so the order has the least to save: its floor is 0.38 here.
TEST(RequestOrder, fromNothingNinetyPercentAreFinalInLittleMoreThanHalfTheTime) {
  EXPECT_LE(shareOfTime("from nothing", {}, viewFrom(46.6, 8.0, 20e3, 0, -25)), 0.55);
}

TEST(ScreenShare, isThePartOfThePictureThatABoxCovers) {
  const View view = viewFrom(0, 0, 1000e3, 0, -90);
  const geo::BodyPosition below = geo::earth().ellipsoid.bodyFromDirection(geo::directionFromDegrees(0, 0), 0.0);
  // Flat, at 1000 km: the picture is 2 tan(22.5 degrees) 1000 km high there, 4/3 as wide.
  const double height_m = 2.0 * std::tan(geo::kPi / 8) * 1000e3;
  const auto boxOf = [&](double northSouth_m, double eastWest_m) {
    return OrientedBox{.centre = below,
                       .halfAxes = {geo::Vec3(0.0, eastWest_m / 2, 0.0), geo::Vec3(0.0, 0.0, northSouth_m / 2),
                                    geo::Vec3(1e-6, 0.0, 0.0)}};
  };
  EXPECT_NEAR(screenShare(boxOf(0.5 * height_m, 0.5 * height_m), view), 0.5 * 0.5 * 3 / 4, 1e-9);
  EXPECT_NEAR(screenShare(boxOf(9 * height_m, 0.5 * height_m), view), 0.5 * 3 / 4, 1e-9);
  OrientedBox beside = boxOf(0.1 * height_m, 0.1 * height_m);
  beside.centre = beside.centre + geo::Vec3(0.0, 0.0, height_m);
  EXPECT_EQ(screenShare(beside, view), 0.0);
  beside.centre = view.eye;
  EXPECT_EQ(screenShare(beside, view), 1.0);
}

}  // namespace
}  // namespace tellurion::scene
