#include "raster/colour.h"

#include <array>
#include <cmath>
#include <vector>

namespace tellurion::raster {
namespace {

struct Tables {
  std::array<std::uint16_t, 256> linear{};
  std::vector<std::uint8_t> srgb = std::vector<std::uint8_t>(65536);

  Tables() {
    for (std::size_t i = 0; i < 256; ++i) {
      linear[i] = static_cast<std::uint16_t>(std::lround(linearLight(static_cast<double>(i) / 255.0) * 65535.0));
    }
    // A byte stands for the linear values on its side of the middle between it and its neighbours.
    std::size_t byte = 0;
    for (std::size_t value = 0; value < srgb.size(); ++value) {
      while (byte < 255 && 2 * value > std::size_t{linear[byte]} + linear[byte + 1])
        ++byte;
      srgb[value] = static_cast<std::uint8_t>(byte);
    }
  }
};

const Tables& tables() {
  static const Tables instance;
  return instance;
}

}  // namespace

double linearLight(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}
ColourTables colourTables() {
  return {.linear = tables().linear.data(), .srgb = tables().srgb.data()};
}
std::uint16_t linearFromSrgb(std::uint8_t value) {
  return tables().linear[value];
}
std::uint8_t srgbFromLinear(std::uint16_t linear) {
  return tables().srgb[linear];
}

Rgba8 over(Rgba8 top, Rgba8 bottom) {
  if (top.a == 255 || bottom.a == 0) return top.a == 0 ? bottom : top;
  if (top.a == 0) return bottom;
  // Coverages in units of 1 / 255^2, so that everything stays an integer.
  const std::uint64_t topPart = std::uint64_t{top.a} * 255;
  const std::uint64_t bottomPart = std::uint64_t{bottom.a} * (255u - top.a);
  const std::uint64_t whole = topPart + bottomPart;
  const auto blend = [&](std::uint8_t t, std::uint8_t b) {
    const std::uint64_t sum = topPart * linearFromSrgb(t) + bottomPart * linearFromSrgb(b);
    return srgbFromLinear(static_cast<std::uint16_t>((sum + whole / 2) / whole));
  };
  return {blend(top.r, bottom.r), blend(top.g, bottom.g), blend(top.b, bottom.b),
          static_cast<std::uint8_t>((whole + 127) / 255)};
}

}  // namespace tellurion::raster
