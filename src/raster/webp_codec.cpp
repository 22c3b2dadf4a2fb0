#include <webp/decode.h>
#include <webp/encode.h>

#include <memory>

#include "raster/image_formats.h"

namespace tellurion::raster {
namespace {

/// 0 to 9; the usual 6 takes four times as long for 4% less.
constexpr int kLosslessEffort = 2;

struct FreePicture {
  void operator()(WebPPicture* p) const { WebPPictureFree(p); }
};
struct FreeWriter {
  void operator()(WebPMemoryWriter* w) const { WebPMemoryWriterClear(w); }
};

const std::uint8_t* raw(std::span<const std::byte> bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

}  // namespace

io::Result<ImageSize> webpSize(std::span<const std::byte> bytes) {
  WebPBitstreamFeatures features{};
  if (WebPGetFeatures(raw(bytes), bytes.size(), &features) != VP8_STATUS_OK) {
    return io::fail(io::Failure::Code::corrupt, "WebP: its header is damaged");
  }
  if (features.has_animation != 0) {
    return io::fail(io::Failure::Code::unsupported, "WebP: it is an animation, give a still picture");
  }
  return ImageSize{features.width, features.height};
}

io::Result<void> decodeWebp(std::span<const std::byte> bytes, Raster<Rgba8>& image) {
  const auto size = webpSize(bytes);
  if (!size) return tl::unexpected(size.error());
  if (*size != ImageSize{image.width, image.height}) return tl::unexpected(wrongSize(*size, image));
  auto* pixels = reinterpret_cast<std::uint8_t*>(image.samples.data());
  const std::size_t room = image.samples.size() * sizeof(Rgba8);
  const int stride = image.width * static_cast<int>(sizeof(Rgba8));
  if (WebPDecodeRGBAInto(raw(bytes), bytes.size(), pixels, room, stride) == nullptr) {
    return io::fail(io::Failure::Code::corrupt, "WebP: its image data is damaged or ends early");
  }
  return {};
}

io::Result<std::vector<std::byte>> encodeWebp(const Raster<Rgba8>& image, int quality) {
  if (image.width > WEBP_MAX_DIMENSION || image.height > WEBP_MAX_DIMENSION) {
    return io::fail(io::Failure::Code::invalidArgument, "WebP: a picture has at most 16383 pixels a side");
  }
  WebPConfig config;
  WebPPicture picture;
  WebPMemoryWriter writer;
  if (WebPConfigPreset(&config, WEBP_PRESET_DEFAULT, static_cast<float>(quality)) == 0 ||
      WebPPictureInit(&picture) == 0) {
    return io::fail(io::Failure::Code::unsupported, "WebP: another libwebp is installed than this was built for");
  }
  if (quality >= 100) WebPConfigLosslessPreset(&config, kLosslessEffort);
  WebPMemoryWriterInit(&writer);
  const std::unique_ptr<WebPPicture, FreePicture> ownsPicture(&picture);
  const std::unique_ptr<WebPMemoryWriter, FreeWriter> ownsWriter(&writer);
  picture.use_argb = quality >= 100 ? 1 : 0;
  picture.width = image.width;
  picture.height = image.height;
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &writer;
  const auto* pixels = reinterpret_cast<const std::uint8_t*>(image.samples.data());
  const int stride = image.width * static_cast<int>(sizeof(Rgba8));
  if (WebPPictureImportRGBA(&picture, pixels, stride) == 0 || WebPEncode(&config, &picture) == 0) {
    return io::fail(io::Failure::Code::ioError, "WebP: out of memory while encoding");
  }
  const auto* bytes = reinterpret_cast<const std::byte*>(writer.mem);
  return std::vector<std::byte>(bytes, bytes + writer.size);
}

}  // namespace tellurion::raster
