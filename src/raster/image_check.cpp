#include "raster/image_check.h"

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "raster/picture_file.h"
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
    if (text) return io::fail(Code::ioError, "the server says: " + io::quotedWithoutSecrets(*text));
  }
  const std::string title = io::quotedWithoutSecrets(titleOfPage(letters));
  return io::fail(Code::corrupt, title.empty() ? std::string("a document came instead of an image")
                                               : fmt::format("a page came instead of an image: '{}'", title));
}

io::Result<bool> checkSize(int width, int height, const ExpectedImage& expected) {
  if (width == expected.width && height == expected.height) return true;
  return io::fail(Code::corrupt, fmt::format("the image has {} x {} pixels, not the {} x {} expected (tile_pixels)",
                                             width, height, expected.width, expected.height));
}

io::Result<bool> checkPicture(const io::Resource& resource, const ExpectedImage& expected) {
  const auto format = pictureFormatOf(resource.bytes);
  if (!format) {
    return io::fail(
        Code::corrupt,
        fmt::format("what came is no image that is known here (PNG, JPEG, WebP, TIFF, GIF); the server calls it "
                    "'{}', it has {} bytes",
                    onOneLine(resource.contentType), resource.bytes.size()));
  }
  if (expected.kind == Kind::elevation && format == PictureFormat::jpeg)
    return io::fail(Code::unsupported, "heights came as a JPEG, which changes them; ask for another format");
  if (expected.kind == Kind::elevation && format == PictureFormat::gif)
    return io::fail(Code::unsupported, "heights came as a GIF, which has 256 colours; ask for another format");
  const auto size = sizeOfWholePicture(resource.bytes);
  if (!size) return tl::unexpected(size.error());
  return checkSize(size->width, size->height, expected);
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
    return io::fail(Code::ioError, "the server says: " +
                                       io::quotedWithoutSecrets(onOneLine(letters.substr(first, kLongestComplaint))));
  if (expected.rawSampleBytes > 0 && !pictureFormatOf(resource.bytes)) {
    return io::fail(Code::corrupt,
                    fmt::format("raw heights of {} bytes came, not the {} of {} x {} samples; zipped "
                                "tiles are not read",
                                letters.size(), samples * static_cast<std::size_t>(expected.rawSampleBytes),
                                expected.width, expected.height));
  }
  return checkPicture(resource, expected);
}

}  // namespace tellurion::raster
