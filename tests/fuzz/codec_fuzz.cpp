// Feeds the payload decoders with whatever libFuzzer invents. The first two bytes are the size that the caller states,
// the third which decoder; the rest is the payload.
#include <cstddef>
#include <cstdint>
#include <span>

#include "raster/codec.h"

namespace raster = tellurion::raster;

namespace {

void check(bool whole) {
  if (!whole) __builtin_trap();
}

/// What was decoded can be encoded, and comes back the same.
void elevation(std::span<const std::byte> bytes, int width, int height) {
  const auto heights = raster::decodeElevation(bytes, width, height);
  if (!heights) return;
  check(heights->samples.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const auto again = raster::decodeElevation(raster::encodeElevation(*heights, 0.0), width, height);
  check(again.has_value());
  for (std::size_t i = 0; i < heights->samples.size(); ++i) {
    const float a = heights->samples[i];
    const float b = again->samples[i];
    check(a == b || (raster::isNoData(a) && raster::isNoData(b)));
  }
}

void image(std::span<const std::byte> bytes) {
  const auto header = raster::readImageHeader(bytes);
  // Large pictures only cost time here.
  if (!header || header->width > 512 || header->height > 512) return;
  const auto picture = raster::decodeImage(bytes, header->width, header->height);
  if (picture) check(picture->width == header->width && picture->height == header->height);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 3) return 0;
  const auto bytes = std::as_bytes(std::span(data, size)).subspan(3);
  if (data[2] % 2 == 0) {
    elevation(bytes, 1 + data[0], 1 + data[1]);
  } else {
    image(bytes);
  }
  return 0;
}
