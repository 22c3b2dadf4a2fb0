// What a globe draws in updates that keep the cut of an earlier one.

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "scene/fake_tree_test.h"
#include "scene/late_globe_test.h"

namespace tellurion::scene {
namespace {

struct Flown {
  int frames = 0;
  int made = 0;  ///< updates that chose tiles
};

/// Straight on over hills, each frame complete before it counts; the surface is whole in all of them, and off by no
/// more than is allowed.
Flown flown(double metresAFrame, double degreesAFrame) {
  const auto hills = std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 8);
  const auto globe = globeOf({.elevation = {hills}});
  const Tiling tiling(Scheme::cube);
  CutOptions options{.tolerance_px = 4.0, .time_s = -1000.0};
  const auto viewAt = [&](int frame) {
    return viewFrom(46.0 + frame * metresAFrame / 111e3, 8.0, 40e3, 20.0 + degreesAFrame * frame, -60.0, kViewport);
  };
  for (bool isDone = false; !isDone; *options.time_s += 1.0) {
    isDone = globe->update(viewAt(0), options).complete;
    globe->waitForArrivals(std::chrono::milliseconds(100));
  }
  Flown out;
  for (int frame = 0; frame < 90; ++frame) {
    options.time_s = frame / 60.0;
    const Frame* drawn = &globe->update(viewAt(frame), options);
    ++out.frames;
    out.made += drawn->statistics.cutAge == 0 ? 1 : 0;
    while (drawn->statistics.tilesWanted > 0 && globe->waitForArrivals(std::chrono::seconds(10)))
      drawn = &globe->update(viewAt(frame), options);
    if (drawn->complete) {
      EXPECT_LE(drawn->statistics.maxScreenError_px, options.tolerance_px * 1.001);
    }
    expectWhole(*drawn, tiling, placesIn(viewAt(frame)));
  }
  return out;
}

TEST(KeptCut, mostFramesOfASteadyFlightChooseNothing) {
  const Flown steady = flown(8.0, 0.01);
  std::printf("%d of %d updates of a steady flight made a cut\n", steady.made, steady.frames);
  EXPECT_LE(2 * steady.made, steady.frames);
  const Flown turning = flown(8.0, 3.0);
  EXPECT_GE(turning.made, turning.frames - 2) << "no picture has so much to spare";
  const Flown resting = flown(0.0, 0.0);
  EXPECT_LE(resting.made, 6);
}

/// And how far they are off in the view that the cut was chosen for.
std::map<tiling::TileId, double> tilesOf(const Frame& frame) {
  std::map<tiling::TileId, double> tiles;
  for (const DrawnTile& tile : frame.tiles)
    tiles[tile.id] = tile.error_px;
  return tiles;
}

// Who draws as long as a frame says that it is not settled, and no longer, ends with the picture of that view alone.
TEST(KeptCut, anEyeThatComesToRestEndsWithACutOfItsOwn) {
  const auto hills = std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 8);
  CutOptions options{.tolerance_px = 4.0, .time_s = 0.0};
  int leftOvers = 0;  // pictures of the motion that were not yet that
  for (int frames = 20; frames < 24; ++frames) {
    const auto globe = globeOf({.elevation = {hills}});
    const auto viewAt = [&](int frame) {
      return viewFrom(46.0 + frame * 150.0 / 111e3, 8.0, 40e3, 20.0 + 0.05 * frame, -60.0, kViewport);
    };
    const Frame* drawn = nullptr;
    const auto draw = [&](const View& view, double seconds) {
      *options.time_s += seconds;
      drawn = &globe->update(view, options);
      while (drawn->statistics.tilesWanted > 0 && globe->waitForArrivals(std::chrono::seconds(10)))
        drawn = &globe->update(view, options);
    };
    for (int i = 0; i < 20; ++i)
      draw(viewAt(0), 1.0);
    for (int frame = 0; frame < frames; ++frame)
      draw(viewAt(frame), 1.0 / 60.0);
    const View end = drawn->view;
    const auto moving = tilesOf(*drawn);
    int more = 0;
    for (; drawn->unsettled && more < 1000; ++more)
      draw(end, 1.0 / 60.0);
    EXPECT_LT(more, 200) << "it comes to rest";
    const auto last = tilesOf(*drawn);
    const auto fresh = globeOf({.elevation = {hills}});
    CutOptions alone = options;
    for (bool isDone = false; !isDone; *alone.time_s += 1.0) {
      drawn = &fresh->update(end, alone);
      isDone = drawn->complete && !drawn->unsettled;
      fresh->waitForArrivals(std::chrono::milliseconds(100));
    }
    EXPECT_EQ(last, tilesOf(*drawn)) << frames;
    leftOvers += moving != last ? 1 : 0;
  }
  EXPECT_GT(leftOvers, 0) << "or this tests nothing";
}

TEST(KeptCut, whatIsAskedForCountsAtOnce) {
  const auto hills = std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 8);
  const auto globe = globeOf({.elevation = {hills}});
  const View view = hillsView();
  CutOptions options{.tolerance_px = 4.0, .time_s = 0.0};
  const auto rest = [&] {
    for (int i = 0; i < 2000 && !globe->update(view, options).complete; ++i, *options.time_s += 0.1)
      globe->waitForArrivals(std::chrono::milliseconds(100));
    *options.time_s += 0.1;
    return globe->update(view, options).statistics.cutAge;
  };
  const auto ageThen = [&] {
    *options.time_s += 0.1;
    return globe->update(view, options).statistics.cutAge;
  };
  EXPECT_GT(rest(), 0);
  globe->exaggeration() = 1.5;
  EXPECT_EQ(ageThen(), 0);
  EXPECT_GT(rest(), 0);
  options.tolerance_px = 3.0;
  EXPECT_EQ(ageThen(), 0);
  EXPECT_GT(rest(), 0);
  *options.time_s -= 5.0;
  EXPECT_EQ(ageThen(), 0) << "the clock was put back";
}

/// So slowly over the hills that an update in two keeps its cut.
View strolling(int frame) {
  return viewFrom(46.0 + frame * 8.0 / 111e3, 8.0, 40e3, 20.0 + 0.01 * frame, -60.0, kViewport);
}

// What has come is taken up at the latest when the cut is made again, and nobody who waits for it sleeps meanwhile.
TEST(KeptCut, nobodySleepsOverWhatHasCome) {
  constexpr std::chrono::seconds kLong{60};
  const auto hills = std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 8);
  const auto globe = globeOf({.elevation = {hills}});
  CutOptions options{.tolerance_px = 4.0, .time_s = 0.0};
  int kept = 0;
  for (int frame = 0; frame < 300; ++frame, *options.time_s += 1.0 / 60.0) {
    const Frame* drawn = &globe->update(strolling(frame), options);
    kept += drawn->statistics.cutAge > 0 ? 1 : 0;
    if (drawn->statistics.tilesWanted == 0) continue;
    const auto before = std::chrono::steady_clock::now();
    ASSERT_TRUE(globe->waitForArrivals(kLong)) << "something is on its way, frame " << frame;
    ASSERT_LT(std::chrono::steady_clock::now() - before, kLong) << "frame " << frame;
  }
  const Frame& last = globe->update(strolling(300), options);
  EXPECT_EQ(last.statistics.tilesWanted, 0) << "it never caught up";
  EXPECT_GT(kept, 100);
}

TEST(KeptCut, withoutAClockEachUpdateIsForItself) {
  const auto hills = std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 8);
  const auto globe = globeOf({.elevation = {hills}});
  CutOptions byClock{.tolerance_px = 4.0, .time_s = 0.0};
  int frame = 0;
  for (int kept = 0; kept < 2; ++frame, *byClock.time_s += 1.0 / 60.0) {
    ASSERT_LT(frame, 1000);
    kept += globe->update(strolling(frame), byClock).statistics.cutAge > 0 ? 1 : 0;
    globe->waitForArrivals(std::chrono::milliseconds(100));
  }
  CutOptions alone = byClock;
  alone.time_s.reset();
  const auto completedBy = [&](Globe& one, const View& view) {
    const Frame* drawn = &one.update(view, alone);
    EXPECT_EQ(drawn->statistics.cutAge, 0);
    while (!drawn->complete && one.waitForArrivals(std::chrono::seconds(60)))
      drawn = &one.update(view, alone);
    EXPECT_EQ(drawn->statistics.cutAge, 0);
    return tilesOf(*drawn);
  };
  const auto fresh = globeOf({.elevation = {hills}});
  for (int more = 0; more < 3; ++more)
    EXPECT_EQ(completedBy(*globe, strolling(frame + more)), completedBy(*fresh, strolling(frame + more)));
  EXPECT_EQ(globe->update(strolling(frame + 3), byClock).statistics.cutAge, 0) << "what was kept was of another time";
}

// What a kept cut draws is never let go of, and what comes meanwhile makes room all the same.
TEST(KeptCut, keepsItsTilesAndTheByteBudget) {
  const auto hills = std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 8);
  const Tiling tiling(Scheme::cube);
  const auto viewAt = [](int frame) {
    return viewFrom(46.0 + frame * 1000.0 / 111e3, 8.0, 200e3, 20.0, -60.0, kViewport);
  };
  // By place alone, so that all of it is drawn.
  const auto needed_bytes = [&](Globe& globe, const View& view) {
    while (!globe.update(view, {.tolerance_px = 0.4}).complete)
      globe.waitForArrivals(std::chrono::milliseconds(100));
    return globe.update(view, {.tolerance_px = 0.4}).statistics.cpuCacheBytes;
  };
  GlobeOptions tight = roomy();
  tight.cpuCacheBytes = 14 * needed_bytes(*globeOf({.elevation = {hills}}), viewAt(0)) / 10;
  const auto globe = globeOf({.elevation = {hills}}, Scheme::cube, tight);
  needed_bytes(*globe, viewAt(0));
  CutOptions options{.tolerance_px = 0.4, .time_s = 0.0};
  constexpr int kThere = 400;
  int kept = 0;
  std::uint64_t most_bytes = 0, requests = 0;
  for (int frame = 0; frame < 2 * kThere; ++frame, *options.time_s += 1.0 / 60.0) {
    const View view = viewAt(frame < kThere ? frame : 2 * kThere - frame);
    const Frame& drawn = globe->update(view, options);
    kept += drawn.statistics.cutAge > 0 ? 1 : 0;
    most_bytes = std::max(most_bytes, drawn.statistics.cpuCacheBytes);
    EXPECT_EQ(drawn.statistics.cpuCacheOver_bytes, 0u);
    requests = drawn.statistics.requests;
    expectWhole(drawn, tiling, placesIn(view, 8, 6));
    globe->waitForArrivals(std::chrono::milliseconds(2));
  }
  EXPECT_GT(kept, kThere / 4);
  EXPECT_LE(most_bytes, tight.cpuCacheBytes);
  std::printf("%d of %d updates kept a cut; %llu tiles, at most %llu of %llu bytes\n", kept, 2 * kThere,
              static_cast<unsigned long long>(requests), static_cast<unsigned long long>(most_bytes),
              static_cast<unsigned long long>(tight.cpuCacheBytes));
}

}  // namespace
}  // namespace tellurion::scene
