#include "scene/camera_recorder.h"

namespace tellurion::scene {
namespace {

constexpr double kSpacing_s = 1.0 / 30.0;

bool isSame(const Camera& a, const Camera& b) {
  return a.position.lat == b.position.lat && a.position.lon == b.position.lon &&
         a.position.height_m == b.position.height_m && a.heading == b.heading && a.pitch == b.pitch && a.roll == b.roll;
}

}  // namespace

void CameraRecorder::add(const Camera& camera, double time_s) {
  if (!begin_s_) begin_s_ = time_s;
  const CameraPath::Key now{.seconds = time_s - *begin_s_, .camera = camera};
  if (kept_.empty()) {
    kept_.push_back(now);
    return;
  }
  const bool stands = isSame(camera, last_ ? last_->camera : kept_.back().camera);
  const bool stood = last_ && isSame(last_->camera, kept_.back().camera);
  // A stand ends where the next move begins; what stopped between two kept moments is kept where it stopped.
  const bool ends = last_ && stands != stood && last_->seconds - kept_.back().seconds > 1e-3;
  if (ends) kept_.push_back(*last_);
  last_ = now;
  if (!stands && now.seconds - kept_.back().seconds >= kSpacing_s) {
    kept_.push_back(now);
    last_.reset();
  }
}

std::vector<CameraPath::Key> CameraRecorder::keys() const {
  std::vector<CameraPath::Key> all = kept_;
  if (last_ && last_->seconds - kept_.back().seconds > 1e-3) all.push_back(*last_);
  return all;
}

}  // namespace tellurion::scene
