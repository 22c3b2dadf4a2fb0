#include "app/screenshot.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "raster/image_file.h"

namespace tellurion::app {
namespace {

constexpr int kMostScreenshots = 100000;

}  // namespace

std::string saveScreenshot(const render::RenderTarget& target) {
  for (int i = 1; i < kMostScreenshots; ++i) {
    const std::filesystem::path path = fmt::format("tellurion-{:04}.png", i);
    std::error_code ignored;
    if (std::filesystem::exists(path, ignored)) continue;
    const auto written = raster::writePng(path, render::readColour(target));
    const std::string where = std::filesystem::absolute(path, ignored).string();
    fmt::print(stderr, "{}\n", written ? "screenshot: " + where : io::describe(written.error()));
    return written ? "saved " + where : "not saved: " + io::describe(written.error());
  }
  return "not saved: the folder has too many screenshots";
}

}  // namespace tellurion::app
