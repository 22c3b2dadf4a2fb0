#include "scene/quality_control.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "geo/seed_test.h"
#include "scene/picking.h"

namespace tellurion::scene {
namespace {

using geo::uniform;

/// A machine and its scene: a frame costs (fixed + ofQuality * quality^exponent) * load, give or take.
struct Plant {
  double fixed_ms = 5.0;
  double ofQuality_ms = 20.0;
  double exponent = 0.7;
  double noise = 0.2;    ///< the largest part that a frame is off, either way
  double spikes = 0.02;  ///< share of frames that take several times as long
  bool fades = true;     ///< tiles come and go with 0.3 s for each halving of the quality

  double cost_ms(double quality) const { return fixed_ms + ofQuality_ms * std::pow(quality, exponent); }

  /// The largest quality up to the ceiling that keeps to the time; 0: none does.
  double affordable(const QualityGoal& goal) const {
    if (cost_ms(goal.floor) > goal.frame_ms) return 0.0;
    const double most = (goal.frame_ms - fixed_ms) / ofQuality_ms;
    return std::min(std::pow(most, 1.0 / exponent), goal.ceiling);
  }
};

struct Played {
  double time_s;
  double quality;
};

/// A control with a plant, and time that goes by as its frames cost.
class Trial {
 public:
  Trial(const QualityGoal& goal, std::mt19937_64& random) : control_(goal), random_(random) {}

  void play(const Plant& plant, double seconds) {
    for (const double end = now_s_ + seconds; now_s_ < end;) {
      const double before = drawn_;
      const double most = plant.fades ? std::exp2(last_ms_ / 300.0) : std::numeric_limits<double>::infinity();
      drawn_ = std::clamp(control_.quality(), before / most, before * most);
      double cost_ms = plant.cost_ms(drawn_) * (1.0 + uniform(random_, -plant.noise, plant.noise));
      if (uniform(random_, 0.0, 1.0) < plant.spikes) cost_ms *= uniform(random_, 2.0, 8.0);
      add({.cost_ms = cost_ms});
    }
  }

  double add(FrameCost frame) {
    last_ms_ = frame.cost_ms;
    now_s_ += 1e-3 * frame.cost_ms;
    frame.time_s = now_s_;
    const double quality = control_.next(frame);
    played_.push_back({now_s_, quality});
    return quality;
  }

  void rest(double seconds) { now_s_ += seconds; }

  double quality() const { return control_.quality(); }
  double now_s() const { return now_s_; }
  QualityControl& control() { return control_; }

  int changesIn(double lastSeconds) const {
    int changes = 0;
    for (std::size_t i = 1; i < played_.size(); ++i)
      changes += played_[i].time_s > now_s_ - lastSeconds && played_[i].quality != played_[i - 1].quality ? 1 : 0;
    return changes;
  }

  double usualQuality(double lastSeconds) const {
    std::vector<double> qualities;
    for (const Played& p : played_) {
      if (p.time_s > now_s_ - lastSeconds) qualities.push_back(p.quality);
    }
    std::ranges::sort(qualities);
    return qualities[qualities.size() / 2];
  }

 private:
  QualityControl control_;
  std::mt19937_64& random_;
  std::vector<Played> played_;
  double now_s_ = 100.0;
  double last_ms_ = 0.0;
  double drawn_ = control_.quality();
};

std::string told(const Plant& p) {
  return testing::PrintToString(p.fixed_ms) + " + " + testing::PrintToString(p.ofQuality_ms) + " * Q^" +
         testing::PrintToString(p.exponent);
}

Plant randomPlant(std::mt19937_64& random) {
  const double whole_ms = std::exp2(uniform(random, 2.0, 8.0));
  const double share = uniform(random, 0.0, 0.8);
  return {.fixed_ms = share * whole_ms,
          .ofQuality_ms = (1.0 - share) * whole_ms,
          .exponent = uniform(random, 0.3, 2.0),
          .fades = uniform(random, 0.0, 1.0) < 0.7};
}

TEST(AtQuality, DividesWhatMayBeOffInPixels) {
  const CutOptions cut{.tolerance_px = 2.0, .maxSpacing_px = 10.0};
  const CutOptions half = atQuality(cut, 0.5);
  EXPECT_EQ(half.tolerance_px, 4.0);
  EXPECT_EQ(half.maxSpacing_px, 20.0);
  EXPECT_EQ(half.texelTolerance_px, 2.0);
  const CutOptions twice = atQuality(cut, 2.0);
  EXPECT_EQ(twice.tolerance_px, 1.0);
  EXPECT_EQ(twice.texelTolerance_px, 1.0);
  EXPECT_EQ(atQuality({}, 0.1).maxSpacing_px, CutOptions{}.maxSpacing_px);
}

TEST(Resolution, KeepsThePictureAndItsErrors) {
  auto random = geo::seededGenerator();
  const geo::Ellipsoid body = geo::Ellipsoid(6378137.0, 1.0 / 298.257);
  for (int i = 0; i < 200; ++i) {
    const Viewport size{.width = 50 + static_cast<int>(uniform(random, 0, 3000)),
                        .height = 50 + static_cast<int>(uniform(random, 0, 2000))};
    Camera camera;
    camera.position = {.lat = geo::Angle::degrees(uniform(random, -89, 89)),
                       .lon = geo::Angle::degrees(uniform(random, -179, 179)),
                       .height_m = uniform(random, 100, 1e7)};
    camera.pitch = geo::Angle::degrees(uniform(random, -90, 0));
    const View view = viewOf(camera, body, geo::Angle::degrees(uniform(random, 10, 100)), size);
    const double resolution = uniform(random, kLeastResolution, kMostResolution);
    const View other = atResolution(view, resolution);
    EXPECT_DOUBLE_EQ(other.pixelAngle(), view.pixelAngle());
    EXPECT_NEAR(other.viewport.width, size.width * resolution, 0.5);
    EXPECT_NEAR(other.viewport.height, size.height * resolution, 0.5);
    const geo::BodyPosition point =
        view.eye + geo::Vec3(uniform(random, -1, 1), uniform(random, -1, 1), -uniform(random, 1, 100)) *
                       view.viewFromBody;  // v * M is transpose(M) * v
    const auto before = pixelOf(view, point);
    const auto after = pixelOf(other, point);
    ASSERT_TRUE(before && after);
    EXPECT_NEAR(after->x / other.viewport.width, before->x / size.width, 1e-9);
    EXPECT_NEAR(after->y / other.viewport.height, before->y / size.height, 1e-9);
  }
}

TEST(Resolution, FallsAfterTheTolerance) {
  for (const double full : {0.5, 1.0, 1.3, 2.0}) {
    EXPECT_EQ(resolutionAt(1.0, full), full);
    EXPECT_EQ(resolutionAt(0.5, full), full);
    EXPECT_EQ(resolutionAt(0.01, full), std::max(kLeastResolution, full / 2));
    for (double share = 1.0; share > 0.1; share *= 0.9)
      EXPECT_LE(resolutionAt(0.9 * share, full), resolutionAt(share, full));
  }
}

TEST(QualityControl, staysAtTheCeilingWhereThereIsRoom) {
  auto random = geo::seededGenerator();
  Trial trial({}, random);
  trial.play({.fixed_ms = 2.0, .ofQuality_ms = 20.0}, 60.0);
  EXPECT_EQ(trial.quality(), 1.0);
  EXPECT_EQ(trial.changesIn(60.0), 0);
}

TEST(QualityControl, settlesAndThenStandsStill) {
  auto random = geo::seededGenerator();
  const QualityGoal goal;
  int atRest = 0;
  int restless = 0;
  int dearOnes = 0;
  constexpr int kPlants = 200;
  for (int i = 0; i < kPlants; ++i) {
    const Plant plant = randomPlant(random);
    SCOPED_TRACE(told(plant));
    Trial trial(goal, random);
    trial.play(plant, 240.0);
    restless += trial.changesIn(60.0) > 6 ? 1 : 0;
    atRest += trial.changesIn(60.0) == 0 ? 1 : 0;
    const double quality = trial.usualQuality(60.0);
    const double best = plant.affordable(goal);
    if (best == 0.0) {
      EXPECT_EQ(quality, goal.floor);
      ++dearOnes;
      continue;
    }
    EXPECT_LE(plant.cost_ms(quality), 1.05 * goal.frame_ms);
    // Not lower than needed: near the best, or near the time.
    EXPECT_TRUE(quality > best / 1.5 || plant.cost_ms(quality) > 0.8 * goal.frame_ms)
        << quality << " of " << best << ", " << plant.cost_ms(quality) << " ms";
  }
  // In the last of four minutes: no change mostly, else up to three tries and the ways back, all but never more.
  EXPECT_GT(atRest, kPlants * 8 / 10);
  EXPECT_LE(restless, kPlants / 50);
  EXPECT_GT(dearOnes, kPlants / 20);
  std::printf("at rest: %d of %d, restless: %d, too slow at the floor: %d\n", atRest, kPlants, restless, dearOnes);
}

TEST(QualityControl, reactsWithinHalfASecond) {
  auto random = geo::seededGenerator();
  for (const double frame_ms : {5.0, 16.0, 33.0, 100.0}) {
    SCOPED_TRACE(frame_ms);
    Trial trial({.frame_ms = frame_ms}, random);
    const Plant light{.fixed_ms = 0.0, .ofQuality_ms = 0.7 * frame_ms, .spikes = 0.0};
    trial.play(light, 20.0);
    EXPECT_EQ(trial.quality(), 1.0);
    Plant heavy = light;
    heavy.ofQuality_ms = 2.2 * frame_ms;
    // Or within five frames, where those take longer.
    trial.play(heavy, std::max(0.5, 5.5e-3 * heavy.ofQuality_ms));
    EXPECT_LE(trial.quality(), 0.6);
    trial.play(heavy, 6.0);
    EXPECT_LE(heavy.cost_ms(trial.quality()), 1.1 * frame_ms);
  }
}

TEST(QualityControl, climbsBackWithinSeconds) {
  auto random = geo::seededGenerator();
  for (int i = 0; i < 50; ++i) {
    Trial trial({}, random);
    Plant plant{.fixed_ms = 1.0, .ofQuality_ms = 15.0, .exponent = uniform(random, 0.3, 2.0)};
    SCOPED_TRACE(told(plant));
    Plant heavy = plant;
    heavy.fixed_ms *= 20.0;
    heavy.ofQuality_ms *= 20.0;
    trial.play(heavy, 60.0);
    EXPECT_LT(trial.quality(), 0.5);
    trial.play(plant, 7.0);
    EXPECT_EQ(trial.quality(), 1.0);
  }
}

TEST(QualityControl, triesWhatWasTooDearMoreAndMoreRarely) {
  auto random = geo::seededGenerator();
  // The next quality up is over its time by what only a try can tell.
  const Plant plant{.fixed_ms = 0.0, .ofQuality_ms = 34.5, .exponent = 1.0, .noise = 0.05};
  Trial trial({}, random);
  trial.play(plant, 60.0);
  const int early = trial.changesIn(60.0);
  trial.play(plant, 540.0);
  const int late = trial.changesIn(300.0);
  EXPECT_GE(early, 3);
  EXPECT_LE(early, 9);
  EXPECT_LE(late, 4);
}

TEST(QualityControl, singleSlowFramesDoNothing) {
  auto random = geo::seededGenerator();
  Trial trial({}, random);
  for (int i = 0; i < 600; ++i) {
    trial.play({.fixed_ms = 0.0, .ofQuality_ms = 30.0, .noise = 0.02, .spikes = 0.0}, 0.2);
    trial.add({.cost_ms = 300.0});
  }
  EXPECT_EQ(trial.changesIn(1e6), 0);
}

TEST(QualityControl, framesThatDoNotCountDoNothing) {
  auto random = geo::seededGenerator();
  Trial trial({}, random);
  for (int i = 0; i < 300; ++i)
    trial.add({.cost_ms = 200.0, .isRepresentative = false});
  EXPECT_EQ(trial.quality(), 1.0);
}

TEST(QualityControl, framesThatLackTilesMakeNoRoom) {
  auto random = geo::seededGenerator();
  Trial trial({}, random);
  trial.play({.fixed_ms = 0.0, .ofQuality_ms = 200.0}, 10.0);
  const double quality = trial.quality();
  EXPECT_LT(quality, 0.5);
  for (int i = 0; i < 300; ++i)
    trial.add({.cost_ms = 5.0, .isWhole = false});
  EXPECT_EQ(trial.quality(), quality);
  for (int i = 0; i < 3000; ++i)
    trial.add({.cost_ms = 5.0});
  EXPECT_EQ(trial.quality(), 1.0);
}

TEST(QualityControl, aPauseChangesNothingButWhatCounts) {
  auto random = geo::seededGenerator();
  Trial trial({}, random);
  const Plant plant{.fixed_ms = 0.0, .ofQuality_ms = 100.0, .noise = 0.05, .spikes = 0.0};
  trial.play(plant, 30.0);
  const double quality = trial.quality();
  for (int i = 0; i < 20; ++i) {
    trial.rest(1.0);
    // Tiles of the full quality that the pause had brought fade out.
    for (int frame = 0; frame < 8; ++frame)
      trial.add({.cost_ms = 100.0});
    EXPECT_EQ(trial.quality(), quality);
    trial.play(plant, 0.3);
    EXPECT_EQ(trial.quality(), quality);
  }
}

TEST(QualityControl, triesNothingWithoutRoom) {
  auto random = geo::seededGenerator();
  Trial trial({}, random);
  trial.play({.fixed_ms = 0.0, .ofQuality_ms = 34.5, .exponent = 0.3, .noise = 0.0, .spikes = 0.0}, 300.0);
  EXPECT_EQ(trial.changesIn(300.0), 1);
}

TEST(QualityControl, keepsToItsRange) {
  auto random = geo::seededGenerator();
  for (int i = 0; i < 100; ++i) {
    const double ceiling = std::exp2(uniform(random, -4.0, 4.0));
    const QualityGoal goal{.frame_ms = 20.0, .floor = std::exp2(uniform(random, -6.0, 4.0)), .ceiling = ceiling};
    Trial trial(goal, random);
    EXPECT_EQ(trial.quality(), ceiling);
    trial.play(randomPlant(random), 20.0);
    EXPECT_LE(trial.quality(), ceiling);
    EXPECT_GE(trial.quality(), std::min(goal.floor, ceiling));
  }
}

TEST(QualityControl, framesSlowerThanItsLooksAreHeard) {
  auto random = geo::seededGenerator();
  Trial trial({}, random);
  trial.play({.fixed_ms = 0.0, .ofQuality_ms = 5000.0, .spikes = 0.0}, 200.0);
  EXPECT_EQ(trial.quality(), QualityGoal{}.floor);
}

TEST(QualityControl, aNewGoalKeepsTheQualityWhereItMay) {
  auto random = geo::seededGenerator();
  Trial trial({}, random);
  trial.play({.fixed_ms = 0.0, .ofQuality_ms = 100.0}, 30.0);
  const double quality = trial.quality();
  trial.control().setGoal({.ceiling = 2.0});
  EXPECT_NEAR(trial.quality(), quality, 1e-12);
  trial.control().setGoal({.ceiling = 0.05});
  EXPECT_EQ(trial.quality(), 0.05);
}

}  // namespace
}  // namespace tellurion::scene
