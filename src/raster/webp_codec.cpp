#include <webp/decode.h>
#include <webp/encode.h>

#include <memory>

#include "raster/image_formats.h"

namespace tellurion::raster {
namespace {

struct FreeWebp {
  void operator()(std::uint8_t* p) const { WebPFree(p); }
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
  const auto* pixels = reinterpret_cast<const std::uint8_t*>(image.samples.data());
  const int stride = image.width * static_cast<int>(sizeof(Rgba8));
  std::uint8_t* encoded = nullptr;
  const std::size_t size =
      quality >= 100 ? WebPEncodeLosslessRGBA(pixels, image.width, image.height, stride, &encoded)
                     : WebPEncodeRGBA(pixels, image.width, image.height, stride, static_cast<float>(quality), &encoded);
  const std::unique_ptr<std::uint8_t, FreeWebp> owner(encoded);
  if (size == 0) return io::fail(io::Failure::Code::ioError, "WebP: out of memory while encoding");
  const auto* bytes = reinterpret_cast<const std::byte*>(encoded);
  return std::vector<std::byte>(bytes, bytes + size);
}

}  // namespace tellurion::raster
