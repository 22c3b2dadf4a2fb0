#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/frames_log.h"
#include "app/step_options.h"
#include "io/step_leader.h"
#include "scene/scene_file.h"

namespace tellurion::app {

/// The viewer's part in leading others: each of its frames is published before it is drawn, and released before it is
/// shown. Main thread only.
class Leading {
 public:
  /// wake: ends the window's sleep, from any thread.
  static io::Result<Leading> begin(const StepArguments& arguments, const scene::Scene& scene,
                                   std::function<void()> wake);

  void publish(scene::LedPicture picture);
  /// Milliseconds that others were waited for; nothing, and nothing happens, where no frame was published since.
  std::optional<double> release(bool isComplete);
  bool wantsFrame() const { return leader_->wantsFrame(); }
  /// Prints what happened among the followers; the last of it, if anything did.
  std::optional<std::string> tellNews();
  /// "3 followers, 1 late".
  std::string status() const;

 private:
  struct Published {
    std::uint64_t frame = 0;
    scene::LedPicture picture;
  };
  std::unique_ptr<io::StepLeader> leader_;
  std::optional<FramesLog> log_;
  std::optional<Published> published_;
};

}  // namespace tellurion::app
