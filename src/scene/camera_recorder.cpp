#include "scene/camera_recorder.h"

#include <algorithm>
#include <cmath>

#include "geo/body.h"

namespace tellurion::scene {
namespace {

using Key = CameraPath::Key;

constexpr double kSpacing_s = 1.0 / 30.0 - 1e-4;  // clocks are not that exact
constexpr double kLeastApart_s = 1e-3;  // a file has tenths of it
constexpr double kShare = 0.25;         // of the way between two moments, that the spline may be off
constexpr double kClose_m = 0.01;
const double kClose_rad = geo::Angle::degrees(0.01).radians();

bool isSame(const Camera& a, const Camera& b) {
  return a.position.lat == b.position.lat && a.position.lon == b.position.lon &&
         a.position.height_m == b.position.height_m && a.heading == b.heading && a.pitch == b.pitch && a.roll == b.roll;
}

struct Apart {
  double way_m = 0.0;
  double turn_rad = 0.0;
};

Apart between(const Camera& a, const Camera& b) {
  const geo::Ellipsoid& earth = geo::earth().ellipsoid;
  const auto turn = [](geo::Angle x, geo::Angle y) {
    return std::abs(std::remainder((x - y).radians(), 2.0 * geo::kPi));
  };
  return {.way_m = geo::length(earth.bodyFromGeodetic(a.position) - earth.bodyFromGeodetic(b.position)),
          .turn_rad = std::max({turn(a.heading, b.heading), turn(a.pitch, b.pitch), turn(a.roll, b.roll)})};
}

/// How far the path is off at moment i, which is not an end, as a multiple of what it may be.
double errorAt(const CameraPath& path, const std::vector<Key>& moments, std::size_t i) {
  const Camera& camera = moments[i].camera;
  const Apart off = between(path.at(CameraPath::Seconds(moments[i].seconds)), camera);
  const Apart before = between(moments[i - 1].camera, camera);
  const Apart after = between(moments[i + 1].camera, camera);
  return std::max(off.way_m / (kClose_m + kShare * std::max(before.way_m, after.way_m)),
                  off.turn_rad / (kClose_rad + kShare * std::max(before.turn_rad, after.turn_rad)));
}

/// The moment between two others where the path is off most; the first of them where it is good everywhere.
std::size_t worstBetween(const CameraPath& path, const std::vector<Key>& moments, std::size_t first, std::size_t last) {
  std::size_t worst = first;
  double most = 1.0;
  for (std::size_t i = first + 1; i < last; ++i) {
    const double error = errorAt(path, moments, i);
    if (error <= most) continue;
    most = error;
    worst = i;
  }
  return worst;
}

/// A key among the moments, and whether the path from there to the next must be looked at (again).
struct Chosen {
  std::size_t moment = 0;
  bool isDue = true;
};

/// The ends of the whole and of all stands.
std::vector<Chosen> endsOf(const std::vector<Key>& moments) {
  std::vector<Chosen> ends;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    const bool isStand = (i > 0 && isSame(moments[i - 1].camera, moments[i].camera)) ||
                         (i + 1 < moments.size() && isSame(moments[i].camera, moments[i + 1].camera));
    if (isStand || i == 0 || i + 1 == moments.size()) ends.push_back({i});
  }
  return ends;
}

std::vector<Key> keysAt(const std::vector<Chosen>& chosen, const std::vector<Key>& moments) {
  std::vector<Key> keys;
  keys.reserve(chosen.size());
  for (const Chosen& c : chosen)
    keys.push_back(moments[c.moment]);
  return keys;
}

/// A key more where the path is off most, between any two keys between which it is too far off; true if there was any.
bool refine(std::vector<Chosen>& chosen, const CameraPath& path, const std::vector<Key>& moments) {
  std::vector<Chosen> next;
  std::vector<std::size_t> added;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    next.push_back({chosen[i].moment, false});
    if (!chosen[i].isDue || i + 1 == chosen.size()) continue;
    const std::size_t worst = worstBetween(path, moments, chosen[i].moment, chosen[i + 1].moment);
    if (worst == chosen[i].moment) continue;
    added.push_back(next.size());
    next.push_back({worst, false});
  }
  // A key bends the spline up to the next but one on either side.
  for (const std::size_t at : added) {
    for (std::size_t i = std::max<std::size_t>(at, 2) - 2; i < std::min(at + 2, next.size()); ++i)
      next[i].isDue = true;
  }
  chosen = std::move(next);
  return !added.empty();
}

}  // namespace

void CameraRecorder::remember(const Key& moment) {
  if (moments_.empty() || moment.seconds - moments_.back().seconds > kLeastApart_s) moments_.push_back(moment);
}

void CameraRecorder::rememberLast() {
  if (last_.seconds - standsSince_.seconds >= kSpacing_s) {
    remember(standsSince_);
    remember(last_);
  } else if (last_.seconds - moments_.back().seconds >= kSpacing_s) {
    remember(last_);
  }
}

void CameraRecorder::add(const Camera& camera, double time_s) {
  if (moments_.empty()) {
    begin_s_ = time_s;
    last_ = standsSince_ = {.seconds = 0.0, .camera = camera};
    remember(last_);
    return;
  }
  const Key now{.seconds = time_s - begin_s_, .camera = camera};
  if (!isSame(camera, last_.camera)) {
    rememberLast();
    standsSince_ = now;
  }
  last_ = now;
}

std::vector<Key> CameraRecorder::keys() const {
  if (moments_.empty()) return {};
  CameraRecorder all = *this;
  all.rememberLast();
  all.remember(last_);
  std::vector<Chosen> chosen = endsOf(all.moments_);
  while (true) {
    std::vector<Key> keys = keysAt(chosen, all.moments_);
    const auto path = CameraPath::create(keys);
    if (!path || !refine(chosen, *path, all.moments_)) return keys;
  }
}

}  // namespace tellurion::scene
