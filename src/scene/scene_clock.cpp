#include "scene/scene_clock.h"

#include <algorithm>

namespace tellurion::scene {

std::optional<double> timeAfter(const SceneClock& clock, double seconds) {
  if (!clock.start_s) return std::nullopt;
  const double time_s = *clock.start_s + clock.rate * seconds;
  const bool hasEnd = clock.end_s && (*clock.end_s - *clock.start_s) * clock.rate > 0.0;
  if (!hasEnd) return time_s;
  return clock.rate > 0.0 ? std::min(time_s, *clock.end_s) : std::max(time_s, *clock.end_s);
}

}  // namespace tellurion::scene
