#include "app/video_pipe.h"

#include <fmt/format.h>
#include <stdio.h>  // popen, pclose: POSIX

#include <array>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string_view>

namespace tellurion::app {
namespace {

std::string quotedForShell(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text)
    quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// Whether the boxes of an MP4 (ISO/IEC 14496-12, section 4.2) fill the file to its end, the index of its frames among
/// them. ffmpeg's exit status does not tell: it is 0 although the last of the file could not be written.
bool isWholeMp4(const std::filesystem::path& path) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  bool hasIndex = false;
  std::uintmax_t at = 0;
  while (!error && at < bytes) {
    std::array<unsigned char, 16> head{};
    file.seekg(static_cast<std::streamoff>(at));
    if (!file.read(reinterpret_cast<char*>(head.data()), 8)) return false;
    const auto number = [&](std::size_t first, std::size_t count) {
      std::uintmax_t out = 0;
      for (std::size_t i = first; i < first + count; ++i)
        out = out << 8u | head[i];
      return out;
    };
    std::uintmax_t size = number(0, 4);
    if (size == 1) {
      if (!file.read(reinterpret_cast<char*>(head.data()) + 8, 8)) return false;
      size = number(8, 8);
    }
    if (size < 8 || size > bytes - at) return false;
    hasIndex = hasIndex || std::string_view(reinterpret_cast<const char*>(head.data()) + 4, 4) == "moov";
    at += size;
  }
  return !error && hasIndex;
}

}  // namespace

void VideoPipe::Close::operator()(std::FILE* pipe) const {
  pclose(pipe);
}

io::Result<void> VideoPipe::check(const std::filesystem::path& path) {
  if (std::system("command -v ffmpeg >/dev/null 2>&1") == 0) return {};
  return io::fail(io::Failure::Code::notFound,
                  "an MP4 needs the program ffmpeg: apt-get install ffmpeg, or give a folder for PNGs", path.string());
}

io::Result<VideoPipe> VideoPipe::open(const std::filesystem::path& path, scene::Viewport size, double framesPerSecond) {
  if (const auto there = check(path); !there) return tl::unexpected(there.error());
  std::signal(SIGPIPE, SIG_IGN);  // an ffmpeg that ends early is a failure of write(), not our end
  // H.264 in 4:2:0 wants even sides; bit-exact so that the same frames give the same file.
  const std::string command = fmt::format(
      "exec ffmpeg -nostdin -loglevel error -y -f rawvideo -pixel_format rgb24 -video_size {}x{} -framerate {} -i "
      "pipe:0 "
      "-vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' -c:v libx264 -preset fast -crf 18 -pix_fmt yuv420p -threads 2 -fflags "
      "+bitexact "
      "-flags:v +bitexact -movflags +faststart -f mp4 {} 1>&2",
      size.width, size.height, framesPerSecond, quotedForShell("file:" + path.string() + ".part"));
  std::FILE* pipe = popen(command.c_str(), "w");
  if (pipe == nullptr) return io::fail(io::Failure::Code::ioError, "ffmpeg cannot be started", path.string());
  return VideoPipe(path, pipe);
}

VideoPipe::~VideoPipe() {
  if (!pipe_) return;
  pipe_.reset();
  std::error_code ignored;
  std::filesystem::remove(part(), ignored);
}

io::Result<void> VideoPipe::write(const raster::Raster<raster::Rgba8>& picture) {
  rgb_.clear();
  for (const raster::Rgba8& pixel : picture.samples)
    rgb_.insert(rgb_.end(), {pixel.r, pixel.g, pixel.b});
  if (std::fwrite(rgb_.data(), 1, rgb_.size(), pipe_.get()) == rgb_.size()) return {};
  return io::fail(io::Failure::Code::ioError, "ffmpeg took no more frames; its own message stands above",
                  path_.string());
}

io::Result<void> VideoPipe::finish() {
  const bool isWhole = pclose(pipe_.release()) == 0 && isWholeMp4(part());
  std::error_code error;
  if (isWhole) std::filesystem::rename(part(), path_, error);
  if (isWhole && !error) return {};
  std::filesystem::remove(part(), error);
  return io::fail(io::Failure::Code::ioError, "ffmpeg could not finish the file; its own message stands above",
                  path_.string());
}

}  // namespace tellurion::app
