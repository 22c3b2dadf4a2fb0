#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>

#include "io/failure.h"
#include "raster/raster.h"
#include "scene/camera.h"

namespace tellurion::app {

/// An ffmpeg process that makes an MP4 (H.264) of the pictures handed to it. The file appears under its name when
/// finish() has succeeded, not before. Move-only; one thread only. Linux and other POSIX systems.
class VideoPipe {
 public:
  /// Whether there is an ffmpeg; the failure says what to install.
  static io::Result<void> check(const std::filesystem::path& path);
  static io::Result<VideoPipe> open(const std::filesystem::path& path, scene::Viewport size, double framesPerSecond);
  ~VideoPipe();
  VideoPipe(VideoPipe&&) noexcept = default;
  VideoPipe& operator=(VideoPipe&&) noexcept = default;

  io::Result<void> write(const raster::Raster<raster::Rgba8>& picture);
  io::Result<void> finish();

 private:
  struct Close {
    void operator()(std::FILE* pipe) const;
  };
  VideoPipe(std::filesystem::path path, std::FILE* pipe) : path_(std::move(path)), pipe_(pipe) {}
  std::filesystem::path part() const { return path_.string() + ".part"; }

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Close> pipe_;
  std::vector<std::uint8_t> rgb_;
};

}  // namespace tellurion::app
