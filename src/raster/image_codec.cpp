#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "raster/codec.h"
#include "raster/image_formats.h"

namespace tellurion::raster {
namespace {

bool startsWith(std::span<const std::byte> bytes, std::initializer_list<unsigned> magic) {
  return bytes.size() >= magic.size() &&
         std::equal(magic.begin(), magic.end(), bytes.begin(),
                    [](unsigned m, std::byte b) { return std::to_integer<unsigned>(b) == m; });
}

std::optional<ImageFormat> formatOf(std::span<const std::byte> bytes) {
  if (startsWith(bytes, {0xff, 0xd8, 0xff})) return ImageFormat::jpeg;
  if (startsWith(bytes, {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'})) return ImageFormat::png;
  if (startsWith(bytes, {'R', 'I', 'F', 'F'}) && bytes.size() >= 12 &&
      startsWith(bytes.subspan(8), {'W', 'E', 'B', 'P'})) {
    return ImageFormat::webp;
  }
  return std::nullopt;
}

bool isCodecSize(int width, int height) {
  return width >= 1 && height >= 1 && width <= kMaxCodecSide && height <= kMaxCodecSide;
}

io::Result<ImageSize> sizeOf(std::span<const std::byte> bytes, ImageFormat format) {
  switch (format) {
    case ImageFormat::jpeg:
      return jpegSize(bytes);
    case ImageFormat::png:
      return pngSize(bytes);
    case ImageFormat::webp:
      return webpSize(bytes);
  }
  return io::fail(io::Failure::Code::invalidArgument, "no such image format");
}

io::Result<void> decode(std::span<const std::byte> bytes, ImageFormat format, Raster<Rgba8>& image) {
  switch (format) {
    case ImageFormat::jpeg:
      return decodeJpeg(bytes, image);
    case ImageFormat::png:
      return decodePng(bytes, image);
    case ImageFormat::webp:
      return decodeWebp(bytes, image);
  }
  return io::fail(io::Failure::Code::invalidArgument, "no such image format");
}

}  // namespace

std::string_view nameOf(ImageFormat format) {
  switch (format) {
    case ImageFormat::jpeg:
      return "JPEG";
    case ImageFormat::png:
      return "PNG";
    case ImageFormat::webp:
      return "WebP";
  }
  return "?";
}

io::Failure wrongSize(ImageSize found, const Raster<Rgba8>& expected) {
  return {io::Failure::Code::corrupt,
          fmt::format("the picture has {} x {} pixels where {} x {} were expected", found.width, found.height,
                      expected.width, expected.height),
          {}};
}

io::Result<std::vector<std::byte>> encodeImage(const Raster<Rgba8>& image, ImageFormat format, int quality) {
  if (!isCodecSize(image.width, image.height)) {
    return io::fail(io::Failure::Code::invalidArgument,
                    fmt::format("a picture to encode has 1 to {} pixels a side, not {} x {}", kMaxCodecSide,
                                image.width, image.height));
  }
  quality = std::clamp(quality, 1, 100);
  switch (format) {
    case ImageFormat::jpeg:
      return encodeJpeg(image, quality);
    case ImageFormat::png:
      return encodePng(image);
    case ImageFormat::webp:
      return encodeWebp(image, quality);
  }
  return io::fail(io::Failure::Code::invalidArgument, "no such image format");
}

io::Result<Raster<Rgba8>> decodeImage(std::span<const std::byte> bytes, int width, int height) {
  if (!isCodecSize(width, height)) {
    return io::fail(io::Failure::Code::invalidArgument,
                    fmt::format("a picture has 1 to {} pixels a side, not {} x {}", kMaxCodecSide, width, height));
  }
  const auto format = formatOf(bytes);
  if (!format) return io::fail(io::Failure::Code::corrupt, "the picture is neither JPEG nor PNG nor WebP");
  // The size is looked at before memory is taken for the pixels.
  Raster<Rgba8> image;
  image.width = width;
  image.height = height;
  const auto size = sizeOf(bytes, *format);
  if (!size) return tl::unexpected(size.error());
  if (*size != ImageSize{width, height}) return tl::unexpected(wrongSize(*size, image));
  image.samples.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  if (auto done = decode(bytes, *format, image); !done) return tl::unexpected(std::move(done.error()));
  return image;
}

io::Result<ImageHeader> readImageHeader(std::span<const std::byte> bytes) {
  const auto format = formatOf(bytes);
  if (!format) return io::fail(io::Failure::Code::corrupt, "the picture is neither JPEG nor PNG nor WebP");
  const auto size = sizeOf(bytes, *format);
  if (!size) return tl::unexpected(size.error());
  return ImageHeader{*format, size->width, size->height};
}

}  // namespace tellurion::raster
