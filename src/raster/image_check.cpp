#include "raster/image_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "raster/codec.h"
#include "raster/service_exception.h"
#include "raster/service_url.h"
#include "raster/xml_document.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

constexpr std::size_t kLongestComplaint = std::size_t{1} << 16;  // bytes of an error page that are looked at

std::string_view lettersOf(const io::Resource& resource) {
  return {reinterpret_cast<const char*>(resource.bytes.data()), resource.bytes.size()};
}

/// What stands between <title> and </title>; empty: nothing.
std::string titleOfPage(std::string_view page) {
  const std::string lower = lowered(page.substr(0, kLongestComplaint));
  const std::size_t begin = lower.find("<title>");
  if (begin == lower.npos) return {};
  const std::size_t end = lower.find("</title>", begin);
  return onOneLine(page.substr(begin + 7, (end == lower.npos ? lower.size() : end) - begin - 7));
}

io::Result<bool> answerInMarkup(const io::Resource& resource, std::string_view letters, bool ready) {
  if (resource.bytes.size() <= kLongestComplaint) {
    const auto root = parseXml(resource.bytes, {});
    const auto text = root ? serviceExceptionText(*root) : std::nullopt;
    if (text && ready && serviceExceptionCode(*root) == "TileOutOfRange") return false;
    if (text) return io::fail(Code::ioError, "the server says: " + *text);
  }
  const std::string title = titleOfPage(letters);
  return io::fail(Code::corrupt, title.empty() ? std::string("a document came instead of an image")
                                               : fmt::format("a page came instead of an image: '{}'", title));
}

io::Result<bool> checkSize(int width, int height, const ExpectedImage& expected) {
  if (width == expected.width && height == expected.height) return true;
  return io::fail(Code::corrupt, fmt::format("the image has {} x {} pixels, not the {} x {} expected (tile_pixels)",
                                             width, height, expected.width, expected.height));
}

bool isTiff(std::string_view letters) {
  using namespace std::string_view_literals;
  return letters.starts_with("II*\0"sv) || letters.starts_with("MM\0*"sv) || letters.starts_with("II+\0"sv) ||
         letters.starts_with("MM\0+"sv);
}

/// GIF has no decoder of ours behind readImageHeader: last resort, by GDAL (service_image.h).
io::Result<bool> checkGif(std::string_view letters, const ExpectedImage& expected) {
  if (expected.kind == Kind::elevation)
    return io::fail(Code::unsupported, "heights came as a GIF, which has 256 colours; ask for another format");
  if (letters.size() < 10) return io::fail(Code::corrupt, "the image ends before it is complete");
  const auto number = [&](std::size_t i) {
    return static_cast<unsigned char>(letters[i]) + 256 * static_cast<unsigned char>(letters[i + 1]);
  };
  if (auto right = checkSize(number(6), number(8), expected); !right) return right;
  const std::size_t last = letters.find_last_not_of('\0');
  if (letters[last] != ';') return io::fail(Code::corrupt, "the image ends before it is complete");
  return true;
}

/// Whether the trailer of the format is there; servers may add a few bytes behind it.
bool isComplete(std::string_view letters, ImageFormat format) {
  constexpr std::size_t kMostAfter = 1024;
  const std::string_view tail = letters.substr(letters.size() - std::min(letters.size(), kMostAfter));
  switch (format) {
    case ImageFormat::png:
      return tail.find("IEND\xAE\x42\x60\x82") != tail.npos;
    case ImageFormat::jpeg:
      return tail.find("\xFF\xD9") != tail.npos;
    case ImageFormat::webp: {
      std::size_t size = 8;
      for (std::size_t i = 0; i < 4; ++i)
        size += static_cast<std::size_t>(static_cast<unsigned char>(letters[4 + i])) << (8 * i);
      return letters.size() >= size;
    }
  }
  return false;
}

io::Result<bool> checkPicture(const io::Resource& resource, std::string_view letters, const ExpectedImage& expected) {
  const auto header = readImageHeader(resource.bytes);
  if (!header) {
    return io::fail(
        Code::corrupt,
        fmt::format("what came is no image that is known here (PNG, JPEG, WebP, TIFF, GIF); the server calls it "
                    "'{}', it has {} bytes",
                    onOneLine(resource.contentType), resource.bytes.size()));
  }
  if (expected.kind == Kind::elevation && header->format == ImageFormat::jpeg)
    return io::fail(Code::unsupported, "heights came as a JPEG, which changes them; ask for another format");
  if (auto right = checkSize(header->width, header->height, expected); !right) return right;
  if (!isComplete(letters, header->format)) return io::fail(Code::corrupt, "the image ends before it is complete");
  return true;
}

}  // namespace

io::Result<bool> checkImage(const io::Resource& resource, const ExpectedImage& expected) {
  const std::string_view letters = lettersOf(resource);
  if (letters.empty()) {
    if (expected.ready) return false;
    return io::fail(Code::corrupt, "the answer is empty");
  }
  const auto samples = static_cast<std::size_t>(expected.width) * static_cast<std::size_t>(expected.height);
  if (expected.rawSampleBytes > 0 && letters.size() == samples * static_cast<std::size_t>(expected.rawSampleBytes))
    return true;
  const std::size_t first = letters.find_first_not_of("\xEF\xBB\xBF \t\r\n");
  if (first != letters.npos && letters[first] == '<') return answerInMarkup(resource, letters, expected.ready);
  if (first != letters.npos && letters[first] == '{')
    return io::fail(Code::ioError, "the server says: " + onOneLine(letters.substr(first, kLongestComplaint)));
  if (isTiff(letters)) return true;
  if (letters.starts_with("GIF87a") || letters.starts_with("GIF89a")) return checkGif(letters, expected);
  if (expected.rawSampleBytes > 0) {
    return io::fail(Code::corrupt,
                    fmt::format("raw heights of {} bytes came, not the {} of {} x {} samples; zipped "
                                "tiles are not read",
                                letters.size(), samples * static_cast<std::size_t>(expected.rawSampleBytes),
                                expected.width, expected.height));
  }
  return checkPicture(resource, letters, expected);
}

}  // namespace tellurion::raster
