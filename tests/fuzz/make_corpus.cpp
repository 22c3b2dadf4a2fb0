// Writes a few small valid payloads of each kind into a folder: where the fuzzer starts from.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "raster/codec.h"

namespace raster = tellurion::raster;

namespace {

void write(const std::filesystem::path& folder, const std::string& name, int width, int height, char decoder,
           const std::vector<std::byte>& payload) {
  std::ofstream file(folder / name, std::ios::binary);
  file.put(static_cast<char>(width - 1));
  file.put(static_cast<char>(height - 1));
  file.put(decoder);
  file.write(reinterpret_cast<const char*>(payload.data()), static_cast<std::streamsize>(payload.size()));
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fputs("usage: make_corpus FOLDER\n", stderr);
    return 2;
  }
  const std::filesystem::path folder = arguments[1];
  std::filesystem::create_directories(folder);
  raster::Raster<float> heights(19, 17);
  raster::Raster<raster::Rgba8> picture(19, 17);
  for (int row = 0; row < 17; ++row) {
    for (int col = 0; col < 19; ++col) {
      heights.at(col, row) =
          col * row % 7 == 6 ? raster::kNoData : std::round(100.0f * std::sin(0.1f * static_cast<float>(col + row)));
      const auto v = static_cast<std::uint8_t>(col * 13 + row);
      picture.at(col, row) = {v, static_cast<std::uint8_t>(255 - v), 7, static_cast<std::uint8_t>(row * 15)};
    }
  }
  write(folder, "elevation_steps", 19, 17, 0, raster::encodeElevation(heights, 1.0));
  write(folder, "elevation_floats", 19, 17, 0, raster::encodeElevation(heights, 0.0));
  for (const auto format : {raster::ImageFormat::jpeg, raster::ImageFormat::png, raster::ImageFormat::webp}) {
    for (const int quality : {60, 100}) {
      const auto payload = raster::encodeImage(picture, format, quality);
      if (!payload) return 1;
      write(folder, std::string(nameOf(format)) + std::to_string(quality), 19, 17, 1, *payload);
    }
  }
  return 0;
}
