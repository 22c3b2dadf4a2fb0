#pragma once

#include <vector>

#include "scene/camera.h"
#include "scene/select.h"

namespace tellurion::scene {

/// The same cut at a quality > 0 of its own 1: what may be off by so many pixels (tolerance, spacing of samples) may be
/// off by 1 / quality as much. Texels too where the quality is under 1; above it none finer than the cut's own are
/// asked for.
CutOptions atQuality(CutOptions cut, double quality);

/// Pixels of the picture for one of the window, along a side, where automatic quality has fallen to the `share` (0 to
/// 1) of its ceiling: as many as are asked for (`full`) down to half of it, for twice as large errors of the ground are
/// seen less than pixels are; below that fewer, to a half as many. At least kLeastResolution.
double resolutionAt(double share, double full);
inline constexpr double kLeastResolution = 0.5;
inline constexpr double kMostResolution = 2.0;

/// The view in a picture of so many pixels for one. The ground is chosen as before: errors count in pixels of the view.
View atResolution(View view, double resolution);

/// What automatic quality has to do.
struct QualityGoal {
  double frame_ms = 33.0;  ///< what a frame may cost, > 0
  double floor = 0.1;      ///< never below this, however slow frames are; > 0, or the ceiling where that is lower
  double ceiling = 1.0;    ///< nor above this, however much room there is; > 0
};

/// What one frame has cost.
struct FrameCost {
  double time_s = 0.0;  ///< when it was done, on a clock that never goes back
  double cost_ms = 0.0;
  /// Its tiles made the cost. False where it waited for the screen, or spent its time on copying what had arrived: such
  /// a frame is left out.
  bool isRepresentative = true;
  /// Hardly a tile of it was missing. Else it is cheaper than its quality comes to be, and says nothing about room.
  bool isWhole = true;
};

/// Moves the quality so that frames keep to their time. What may be relied on (quality_control_test):
///  - down within half a second, or five frames, when they cost twice too much, in steps that follow how much; up
///    within seconds when there is room; where it is close only after two seconds' look, so that noise of 20% moves
///    little;
///  - medians of several frames decide: single slow frames do nothing;
///  - with a steady load it comes to rest, and stays exactly constant but for rare attempts: a quality that was found
///    too dear is tried again after 8 s at the earliest, then 16, 32 ... up to 300 s, unless frames have become much
///    cheaper since. At rest frames keep to their time, unless the floor is too slow as well.
/// Qualities are the ceiling times powers of 2^(-1/4). After a change of quality, and after a pause of more than half a
/// second between frames, it waits until late tiles have faded out (CutOptions::fade_s) before it counts again.
/// One thread only.
class QualityControl {
 public:
  explicit QualityControl(const QualityGoal& goal = {});

  double quality() const;

  /// Takes in a frame that was drawn at quality(), and gives the quality for the next one.
  double next(const FrameCost& frame);

  /// Keeps the quality where the new goal allows it; forgets what was learnt.
  void setGoal(const QualityGoal& goal);

 private:
  struct Sample {
    double time_s;
    double cost_ms;
    bool isWhole;
  };
  /// What is known of a quality.
  struct Rung {
    double tooDear_ms = 0.0;    ///< what frames cost when it was left because of that
    double belowIt_ms = 0.0;    ///< and what they cost one rung lower then; 0: not known yet
    double triedAgain_s = 0.0;  ///< not before
    double pause_s = 0.0;       ///< the last wait until then
  };

  double qualityOf(int rung) const;
  void takeIn(const FrameCost& frame);
  void settle(double now_s, int rungs);
  double median(std::size_t latest);
  std::size_t samplesSince(double time_s) const;
  bool goDown(double now_s);
  void goUp(double now_s);
  static bool mayTry(Rung& rung, double now_s, double cost_ms);
  void leave(double now_s, double cost_ms);

  QualityGoal goal_;
  std::vector<Rung> rungs_;  ///< the ceiling first
  int rung_ = 0;
  std::vector<Sample> samples_;  ///< at this rung, since it has settled; oldest first
  std::vector<double> sorted_;
  double last_s_ = 0.0;         ///< the last frame
  double looked_s_ = 0.0;       ///< when it last judged them
  double settledFrom_s_ = 0.0;  ///< frames count from here
  bool hasBegun_ = false;
};

}  // namespace tellurion::scene
