#include "scene/texture_image.h"

#include <algorithm>
#include <utility>

#include "raster/colour.h"
#include "raster/reduce.h"
#include "scene/terrain_mesh.h"

namespace tellurion::scene {
namespace {

using raster::Rgba8;
using Picture = raster::Raster<Rgba8>;

/// Colours are multiplied with coverage in linear light, so that what the GPU makes between a covered and an uncovered
/// texel has the colour of the covered one.
void premultiply(Picture& picture) {
  const raster::ColourTables tables = raster::colourTables();
  for (Rgba8& p : picture.samples) {
    if (p.a == 255) continue;
    const auto times = [&](std::uint8_t v) { return tables.srgb[(tables.linear[v] * p.a + 127u) / 255u]; };
    p = {times(p.r), times(p.g), times(p.b), p.a};
  }
}

void compressLevels(TextureImage& image) {
  const auto format = image.isOpaque ? raster::BlockFormat::bc1 : raster::BlockFormat::bc3;
  for (const Picture& mip : image.mips)
    image.blocks.push_back(raster::compressed(mip, format));
  image.mips.clear();
}

}  // namespace

std::shared_ptr<const TextureImage> textureFrom(Picture finest, bool compress) {
  auto image = std::make_shared<TextureImage>();
  image->serial = nextSerial();
  image->isOpaque = std::ranges::all_of(finest.samples, [](Rgba8 p) { return p.a == 255; });
  image->mips.push_back(std::move(finest));
  while (image->mips.back().width > 1 || image->mips.back().height > 1)
    image->mips.push_back(raster::halved(image->mips.back()));
  if (!image->isOpaque) std::ranges::for_each(image->mips, premultiply);
  if (compress) compressLevels(*image);
  return image;
}

std::uint64_t pixelBytes(const TextureImage& image) {
  std::uint64_t bytes = 0;
  for (const Picture& mip : image.mips)
    bytes += mip.samples.size() * sizeof(Rgba8);
  for (const raster::BlockPicture& level : image.blocks)
    bytes += level.bytes.size();
  return bytes;
}

Rgba8 meanOf(const TextureImage& image) {
  const auto middle = [](const Picture& smallest) { return smallest.at(smallest.width / 2, smallest.height / 2); };
  return image.blocks.empty() ? middle(image.mips.back()) : middle(raster::decompressed(image.blocks.back()));
}

}  // namespace tellurion::scene
