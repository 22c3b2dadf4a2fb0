#include <gtest/gtest.h>

#include <chrono>

#include "geo/seed_test.h"
#include "scene/late_globe_test.h"

namespace tellurion::scene {
namespace {

using namespace std::chrono_literals;
using tiling::Scheme;
using tiling::TileId;

/// For so long a server holds up what joins: long enough for whoever gives up waiting to have done so.
constexpr auto kLong = 1200ms;

/// The level of what is drawn at each place; -1: nothing.
std::vector<int> levelsAt(const Frame& frame, const tiling::Tiling& tiling, const std::vector<geo::Direction>& places) {
  std::set<TileId> drawn;
  for (const DrawnTile& tile : frame.tiles)
    drawn.insert(tile.id);
  std::vector<int> out;
  for (const geo::Direction& d : places) {
    const TileId deepest = tiling.tileAt(d, 20);
    int level = 20;
    while (level >= 0 && drawn.count(deepest.ancestor(level)) == 0)
      --level;
    out.push_back(level);
  }
  return out;
}

std::size_t coarserPlaces(const std::vector<int>& now, const std::vector<int>& before) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < now.size(); ++i)
    count += now[i] < before[i] ? 1u : 0u;
  return count;
}

/// Of this machine, all that the view needs here; the frame is not complete for layers that are not here yet.
const Frame& settled(Globe& globe, const View& view) {
  const auto end = std::chrono::steady_clock::now() + 20s;
  const Frame* frame = &globe.update(view);
  while ((frame->statistics.tilesWanted != 0 || frame->tiles.size() < 20) && std::chrono::steady_clock::now() < end) {
    globe.waitForArrivals(10ms);
    frame = &globe.update(view);
  }
  EXPECT_EQ(frame->statistics.tilesWanted, 0);
  return *frame;
}

/// Fifty frames a second of one view.
class ByTheClock {
 public:
  ByTheClock(Globe& globe, const View& view) : globe_(globe), view_(view) {}

  const Frame& next() {
    globe_.waitForArrivals(5ms);
    return globe_.update(view_, {.time_s = time_s_ += 0.02});
  }
  /// As settled(), and nothing fades any more.
  const Frame& settled() {
    const Frame* frame = &next();
    while ((frame->statistics.tilesWanted != 0 || frame->tiles.size() < 20 || frame->morphing) && !isOver())
      frame = &next();
    return *frame;
  }
  bool isOver() const { return std::chrono::steady_clock::now() >= end_; }

 private:
  Globe& globe_;
  const View& view_;
  double time_s_ = 0.0;
  std::chrono::steady_clock::time_point end_ = std::chrono::steady_clock::now() + 240s;
};

class JoiningLayers : public testing::TestWithParam<Scheme> {
 protected:
  const tiling::Tiling tiling{GetParam()};
  const std::shared_ptr<ProceduralSource> planet =
      std::make_shared<ProceduralSource>(raster::Kind::elevation, GetParam(), 6);
};
INSTANTIATE_TEST_SUITE_P(All, JoiningLayers, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

/// Its coarsest tiles come, and then for long nothing or a tile now and then.
TEST_P(JoiningLayers, nothingGetsCoarserHoweverSlowlyALayerComes) {
  const View view = hillsView();
  const auto places = placesIn(view);
  auto random = geo::seededGenerator();
  Remote colours(raster::Kind::imagery, GetParam());
  Remote ground(raster::Kind::elevation, GetParam(), 7);
  const auto globe = globeOf(
      {.elevation = {planet, ground.source}, .imagery = {{.source = colours.source}}, .resources = {}}, GetParam());
  std::vector<int> levels = levelsAt(settled(*globe, view), tiling, places);
  for (const auto& server : {colours.server, ground.server})
    server->serve(tiling.rootCount());
  const auto start = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() < start + 2 * kLong) {
    const bool hangs = std::chrono::steady_clock::now() < start + kLong;
    if (!hangs && geo::uniform(random, 0, 1) < 0.1) colours.server->serve(1);
    if (!hangs && geo::uniform(random, 0, 1) < 0.1) ground.server->serve(1);
    const auto now = levelsAt(globe->update(view), tiling, places);
    ASSERT_EQ(coarserPlaces(now, levels), 0u) << "hangs: " << hangs;
    levels = now;
    globe->waitForArrivals(5ms);
  }
  const auto late = pictureOf(completed(*globe, view, {colours.server, ground.server}));
  expectAskedOnce(*colours.server);
  expectAskedOnce(*ground.server);
  const auto local = globeOf(
      {.elevation = {planet, ground.planet}, .imagery = {{.source = colours.planet}}, .resources = {}}, GetParam());
  EXPECT_EQ(late, pictureOf(completed(*local, view, {})));
}

/// What is shown does not collapse for what joins, whose levels may disagree.
TEST_P(JoiningLayers, byTheClockNothingGetsCoarserForGroundThatIsNotNested) {
  const View view = hillsView();
  const auto places = placesIn(view);
  Remote colours(raster::Kind::imagery, GetParam());
  Remote ground(raster::Kind::elevation, GetParam());
  ground.planet->setNested(false);
  const auto globe = globeOf(
      {.elevation = {planet, ground.source}, .imagery = {{.source = colours.source}}, .resources = {}}, GetParam());
  ByTheClock shown{*globe, view};
  const Frame* frame = &shown.settled();
  const auto levels = levelsAt(*frame, tiling, places);
  while (!frame->complete && !shown.isOver()) {
    colours.server->serve(20);
    ground.server->serve(20);
    frame = &shown.next();
    ASSERT_EQ(coarserPlaces(levelsAt(*frame, tiling, places), levels), 0u);
  }
  EXPECT_TRUE(frame->complete);
}

bool oneHoldsTheOther(const TileId& a, const TileId& b) {
  const int level = std::min(a.level, b.level);
  return a.ancestor(level) == b.ancestor(level);
}

/// Pictures join; the ground, which is here, stays as exact as it was where it was seen. (What lay just beyond the
/// picture, as its finer tiles told, counts as seen and may be off until they are here with their pictures.)
TEST_P(JoiningLayers, byTheClockPicturesThatJoinLeaveTheErrorWithinTheTolerance) {
  const View view = hillsView();
  Remote colours(raster::Kind::imagery, GetParam(), 7);
  const auto globe =
      globeOf({.elevation = {planet}, .imagery = {{.source = colours.source}}, .resources = {}}, GetParam());
  const double tolerance_px = CutOptions().tolerance_px;
  ByTheClock shown{*globe, view};
  const Frame* frame = &shown.settled();
  ASSERT_LE(frame->statistics.maxScreenError_px, tolerance_px);
  std::vector<TileId> seen;
  for (const DrawnTile& tile : frame->tiles)
    seen.push_back(tile.id);
  while (!frame->complete && !shown.isOver()) {
    colours.server->serve(20);
    frame = &shown.next();
    for (const DrawnTile& tile : frame->tiles) {
      const bool wasSeen = std::ranges::any_of(seen, [&](const TileId& id) { return oneHoldsTheOther(id, tile.id); });
      if (wasSeen) {
        ASSERT_LE(tile.error_px, tolerance_px) << "shows pictures: " << showsPictures(*frame);
      }
    }
  }
  EXPECT_TRUE(frame->complete);
  EXPECT_TRUE(showsPictures(*frame));
}

/// The eye goes on, and sees what is there without the layer as fine as ever.
TEST_P(JoiningLayers, whatIsShownGoesOnBecomingFinerWhileALayerHangs) {
  const View there = viewFrom(44.0, 11.0, 60e3, 20, -35, kViewport);
  Remote colours(raster::Kind::imagery, GetParam());
  const auto globe =
      globeOf({.elevation = {planet}, .imagery = {{.source = colours.source}}, .resources = {}}, GetParam());
  settled(*globe, hillsView());
  const auto places = placesIn(there);
  const auto local = globeOf({.elevation = {planet}, .imagery = {}, .resources = {}}, GetParam());
  const auto asked = levelsAt(completed(*local, there, {}), tiling, places);
  ASSERT_NE(levelsAt(globe->update(there), tiling, places), asked) << "there is something to load";
  ASSERT_TRUE(comesTrue(*globe, hillsView(), [&](const Frame&) { return colours.server->waiting() > 0; }));
  colours.server->serve(tiling.rootCount());
  EXPECT_TRUE(comesTrue(*globe, there, [&](const Frame& frame) {
    return levelsAt(frame, tiling, places) == asked && !showsPictures(frame);
  }));
  completed(*globe, there, {colours.server});
}

/// Whichever of them hangs, the other shows as fine as it is, and what hung is there once its server is well.
TEST_P(JoiningLayers, oneThatHangsKeepsNoOtherOut) {
  const View view = hillsView();
  const auto places = placesIn(view);
  for (const bool lowerHangs : {false, true}) {
    Remote lower(raster::Kind::imagery, GetParam());
    Remote upper(raster::Kind::imagery, GetParam(), 5);
    const auto globe = globeOf(
        {.elevation = {planet}, .imagery = {{.source = lower.source}, {.source = upper.source}}, .resources = {}},
        GetParam());
    const auto levels = levelsAt(settled(*globe, view), tiling, places);
    Remote& hanging = lowerHangs ? lower : upper;
    Remote& well = lowerHangs ? upper : lower;
    hanging.server->serve(tiling.rootCount());
    std::size_t coarser = 0;
    const auto showsTheOther = [&](const Frame& frame) {
      well.server->serve(1000);
      coarser += coarserPlaces(levelsAt(frame, tiling, places), levels);
      return std::ranges::all_of(frame.tiles, [](const DrawnTile& tile) { return tile.pictureCount == 1; });
    };
    EXPECT_TRUE(comesTrue(*globe, view, showsTheOther)) << "lower hangs: " << lowerHangs;
    EXPECT_EQ(coarser, 0u);
    EXPECT_FALSE(globe->lateLayers().empty());
    const auto late = pictureOf(completed(*globe, view, {lower.server, upper.server}));
    const auto local = globeOf(
        {.elevation = {planet}, .imagery = {{.source = lower.planet}, {.source = upper.planet}}, .resources = {}},
        GetParam());
    EXPECT_EQ(late, pictureOf(completed(*local, view, {})));
  }
}

/// Added while the globe is shown, it joins like any other, on top, and nothing of what is shown suffers.
TEST_P(JoiningLayers, oneThatIsAddedJoinsAsIfItHadBeenThere) {
  const View view = hillsView();
  const auto places = placesIn(view);
  Remote lower(raster::Kind::imagery, GetParam());
  Remote upper(raster::Kind::imagery, GetParam(), 5);
  const auto globe =
      globeOf({.elevation = {planet}, .imagery = {{.source = lower.planet}}, .resources = {}}, GetParam());
  const auto before = pictureOf(completed(*globe, view, {}));
  const auto levels = levelsAt(globe->update(view), tiling, places);
  const LayerSource::Opening opening = [&]() -> io::Result<LayerSource::Pointer> {
    return LayerSource::Pointer(upper.source);
  };
  const LayerLook look{.opacity = 0.5};
  ASSERT_TRUE(globe->addImagery({.source = LayerSource(opening, "http://there/map"), .look = look, .name = "added"}));
  EXPECT_EQ(globe->imageryNames().back(), "added");
  EXPECT_EQ(globe->imageryLooks().back().opacity, 0.5);
  EXPECT_EQ(globe->imageryOrder().back(), 1u);
  for (int i = 0; i < 30; ++i) {
    const Frame& frame = globe->update(view);
    EXPECT_GT(frame.statistics.layersComing, 0);
    EXPECT_EQ(pictureOf(frame), before);
    globe->waitForArrivals(5ms);
  }
  std::size_t coarser = 0;
  EXPECT_TRUE(comesTrue(*globe, view, [&](const Frame& frame) {
    upper.server->serve(2);
    coarser += coarserPlaces(levelsAt(frame, tiling, places), levels);
    return frame.complete;
  }));
  EXPECT_EQ(coarser, 0u);
  expectAskedOnce(*upper.server);
  const auto together = globeOf({.elevation = {planet},
                                 .imagery = {{.source = lower.planet}, {.source = upper.planet, .look = look}},
                                 .resources = {}},
                                GetParam());
  EXPECT_EQ(pictureOf(completed(*globe, view, {})), pictureOf(completed(*together, view, {})));
}

TEST(JoiningLayers, whatDoesNotFitIsNotAdded) {
  const View view = hillsView();
  Remote colours(raster::Kind::imagery);
  const auto globe = globeOf({.elevation = {}, .imagery = {{.source = colours.planet}}, .resources = {}});
  const auto before = pictureOf(completed(*globe, view, {}));
  const auto other = std::make_shared<ProceduralSource>(raster::Kind::imagery, Scheme::healpix, 3);
  const auto refused = globe->addImagery({.source = colours.planet, .alsoFrom = {other}});
  ASSERT_FALSE(refused);
  EXPECT_NE(io::describe(refused.error()).find("healpix"), std::string::npos) << io::describe(refused.error());
  EXPECT_FALSE(globe->addImagery(ImageryLayer{.name = {}, .source = "/no/such/raster.tif"}));
  EXPECT_FALSE(globe->addImagery(ImageryLayer{.derived = DerivedImagery{}})) << "of the heights of the scene";
  EXPECT_EQ(globe->imageryLooks().size(), 1u);
  EXPECT_EQ(globe->imageryNames().size(), 1u);
  EXPECT_EQ(globe->imageryOrder().size(), 1u);
  EXPECT_EQ(pictureOf(completed(*globe, view, {})), before);
}

}  // namespace
}  // namespace tellurion::scene
