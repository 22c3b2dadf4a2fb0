#include "app/video_pipe.h"

#include <fmt/format.h>
#include <stdio.h>  // popen, pclose: POSIX

#include <csignal>
#include <cstdlib>

namespace tellurion::app {
namespace {

std::string quotedForShell(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text)
    quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
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
  const int status = pclose(pipe_.release());
  std::error_code error;
  if (status == 0) std::filesystem::rename(part(), path_, error);
  if (status == 0 && !error) return {};
  std::filesystem::remove(part(), error);
  return io::fail(io::Failure::Code::ioError, "ffmpeg could not finish the file; its own message stands above",
                  path_.string());
}

}  // namespace tellurion::app
