#include "raster/service_entry.h"

#include <gtest/gtest.h>

namespace tellurion::raster {
namespace {

TEST(ServiceEntry, AnImageHasABoundForItsBytes) {
  constexpr std::uint64_t kMost = std::uint64_t{128} << 20;
  std::uint64_t before = 0;
  for (const int side : {1, 256, 512, 1024, 2048, 4096}) {
    const auto request = imageRequest("http://h/a", "d", {Kind::elevation, side, side, 4, false});
    const auto pixels = static_cast<std::uint64_t>(side) * static_cast<std::uint64_t>(side);
    EXPECT_GE(request.maxBytes, 4 * pixels) << "raw heights of 4 bytes fit";
    EXPECT_GE(request.maxBytes, before);
    EXPECT_LE(request.maxBytes, kMost);
    before = request.maxBytes;
  }
  EXPECT_EQ(before, kMost);
  // However large a server says that its images are.
  EXPECT_EQ(imageRequest("http://h/a", "d", {Kind::imagery, 1 << 30, 1 << 30, 0, false}).maxBytes, kMost);
}

}  // namespace
}  // namespace tellurion::raster
