#include "app/frames_log.h"

#include <fmt/format.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "io/keyed_hash.h"

namespace tellurion::app {
namespace {

/// Tells pictures apart to the last bit.
std::string digestOf(const scene::LedPicture& picture) {
  constexpr std::size_t kBytes = 8;
  std::string text;
  const io::Digest digest = io::keyedHash("picture", encode(picture));
  for (std::size_t i = 0; i < kBytes; ++i)
    text += fmt::format("{:02x}", static_cast<unsigned char>(digest[i]));
  return text;
}

}  // namespace

io::Result<std::optional<FramesLog>> FramesLog::open(const std::string& path) {
  if (path.empty()) return std::optional<FramesLog>();
  std::FILE* const file = std::fopen(path.c_str(), "w");
  if (file == nullptr)
    return io::fail(io::Failure::Code::ioError, fmt::format("cannot be written: {}", std::strerror(errno)), path);
  FramesLog log(file);
  fmt::print(file, "frame,shown_s,eye_x_m,eye_y_m,eye_z_m,clock_s,picture,released,complete\n");
  std::fflush(file);
  return std::optional(std::move(log));
}

void FramesLog::add(std::uint64_t frame, const scene::LedPicture& picture, bool isReleased, bool isComplete) {
  const std::chrono::duration<double> now = std::chrono::steady_clock::now().time_since_epoch();
  const geo::Vec3& eye = picture.eye.m;
  fmt::print(file_.get(), "{},{:.6f},{},{},{},{},{},{:d},{:d}\n", frame, now.count(), eye.x, eye.y, eye.z,
             picture.clock_s ? fmt::format("{}", *picture.clock_s) : "", digestOf(picture), isReleased, isComplete);
  std::fflush(file_.get());
}

}  // namespace tellurion::app
