#include "raster/picture_file.h"

#include <algorithm>
#include <string_view>

#include "io/crc32.h"
#include "raster/codec.h"
#include "raster/tiff_layout.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;
using namespace std::string_view_literals;

/// Servers add a little behind a picture.
constexpr std::size_t kMostAfter = 1024;

std::string_view lettersOf(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

auto endsEarly() {
  return io::fail(Code::corrupt, "the image ends before it is complete");
}

std::size_t byteAt(std::string_view letters, std::size_t i) {
  return static_cast<unsigned char>(letters[i]);
}

std::uint32_t crcOf(std::string_view letters) {
  io::Crc32 crc;
  crc.add(std::as_bytes(std::span(letters)));
  return crc.value();
}

std::uint32_t bigEndian32(std::string_view letters, std::size_t at) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < 4; ++i)
    number = number << 8U | static_cast<std::uint32_t>(byteAt(letters, at + i));
  return number;
}

io::Result<void> checkPngChunks(std::string_view letters) {
  constexpr std::size_t kHead = 8;     // of the file, and of a chunk
  constexpr std::size_t kAround = 12;  // length, name and checksum of a chunk
  for (std::size_t at = kHead; letters.size() - at >= kAround;) {
    const std::size_t length = bigEndian32(letters, at);
    if (length > letters.size() - at - kAround) return endsEarly();
    if (crcOf(letters.substr(at + 4, length + 4)) != bigEndian32(letters, at + kHead + length))
      return io::fail(Code::corrupt, "the image is damaged: a checksum of the PNG is wrong");
    if (letters.substr(at + 4, 4) == "IEND") return {};
    at += kAround + length;
  }
  return endsEarly();
}

io::Result<ImageSize> sizeOfGif(std::string_view letters) {
  const std::size_t last = letters.find_last_not_of('\0');
  if (letters.size() < 10 || letters[last] != ';') return endsEarly();
  const auto number = [&](std::size_t i) {
    return static_cast<int>(byteAt(letters, i) | byteAt(letters, i + 1) << 8U);
  };
  return ImageSize{.width = number(6), .height = number(8)};
}

bool hasJpegEnd(std::string_view letters) {
  return letters.substr(letters.size() - std::min(letters.size(), kMostAfter)).find("\xFF\xD9") != letters.npos;
}

bool hasWebpLength(std::string_view letters) {
  std::size_t size = 8;
  for (std::size_t i = 0; i < 4; ++i)
    size += byteAt(letters, 4 + i) << (8 * i);
  return letters.size() >= size;
}

io::Result<void> checkEnd(std::string_view letters, ImageFormat format) {
  switch (format) {
    case ImageFormat::png:
      return checkPngChunks(letters);
    case ImageFormat::jpeg:
      return hasJpegEnd(letters) ? io::Result<void>{} : endsEarly();
    case ImageFormat::webp:
      return hasWebpLength(letters) ? io::Result<void>{} : endsEarly();
  }
  return {};
}

}  // namespace

std::optional<PictureFormat> pictureFormatOf(std::span<const std::byte> bytes) {
  const std::string_view letters = lettersOf(bytes);
  if (letters.starts_with("\xFF\xD8\xFF")) return PictureFormat::jpeg;
  if (letters.starts_with("\x89PNG\r\n\x1A\n")) return PictureFormat::png;
  if (letters.starts_with("RIFF") && letters.substr(0, 12).ends_with("WEBP")) return PictureFormat::webp;
  if (letters.starts_with("GIF87a") || letters.starts_with("GIF89a")) return PictureFormat::gif;
  for (const std::string_view start : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv})
    if (letters.starts_with(start)) return PictureFormat::tiff;
  return std::nullopt;
}

io::Result<ImageSize> sizeOfWholePicture(std::span<const std::byte> bytes) {
  const auto format = pictureFormatOf(bytes);
  if (format == PictureFormat::tiff) return sizeOfWholeTiff(bytes);
  if (format == PictureFormat::gif) return sizeOfGif(lettersOf(bytes));
  const auto header = readImageHeader(bytes);
  if (!header) return tl::unexpected(header.error());
  if (auto whole = checkEnd(lettersOf(bytes), header->format); !whole) return tl::unexpected(std::move(whole.error()));
  return ImageSize{.width = header->width, .height = header->height};
}

}  // namespace tellurion::raster
