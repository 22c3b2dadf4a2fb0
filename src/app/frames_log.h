#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "io/failure.h"
#include "scene/led_picture.h"

namespace tellurion::app {

/// What --frames-log writes: a line a frame that was shown, at once, so that a program that is killed leaves those
/// before. One thread only.
class FramesLog {
 public:
  /// Nothing where no path is given.
  static io::Result<std::optional<FramesLog>> open(const std::string& path);

  /// Called when it is shown. isReleased: with the others, not after it waited in vain.
  void add(std::uint64_t frame, const scene::LedPicture& picture, bool isReleased, bool isComplete);

 private:
  struct Closing {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  explicit FramesLog(std::FILE* file) : file_(file) {}
  std::unique_ptr<std::FILE, Closing> file_;
};

}  // namespace tellurion::app
