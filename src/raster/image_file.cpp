#include "raster/image_file.h"

#include <fmt/format.h>

#include <fstream>
#include <system_error>

#include "io/output_file.h"
#include "raster/codec.h"
#include "raster/gdal_session.h"

namespace tellurion::raster {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr std::uintmax_t kMaxImageFileBytes = std::uintmax_t{1} << 30u;

io::Result<std::vector<std::byte>> readBytes(const fs::path& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) return io::fail(Code::notFound, "cannot be read: " + error.message(), path.string());
  if (size > kMaxImageFileBytes) return io::fail(Code::unsupported, "is larger than 1 GiB", path.string());
  std::vector<std::byte> bytes(size);
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!file) return io::fail(Code::ioError, "cannot be read to its end", path.string());
  return bytes;
}

}  // namespace

io::Result<void> writePng(const fs::path& path, const Raster<Rgba8>& image) {
  auto bytes = encodeImage(image, ImageFormat::png, 100);
  if (!bytes) {
    bytes.error().where = path.string();
    return tl::unexpected(std::move(bytes.error()));
  }
  return io::writeWhole(path, {reinterpret_cast<const char*>(bytes->data()), bytes->size()});
}

io::Result<void> writeTiffFloat(const fs::path& path, const Raster<float>& values) {
  if (io::isDevice(path)) return io::fail(Code::invalidArgument, "a TIFF cannot be written to a device", path.string());
  return io::writeWhole(path, [&](const fs::path& part) { return gdalWriteFloatTiff(part.string(), values); });
}

io::Result<Raster<Rgba8>> readImageFile(const fs::path& path) {
  const auto bytes = readBytes(path);
  if (!bytes) return tl::unexpected(bytes.error());
  auto image = readImageHeader(*bytes).and_then(
      [&](const ImageHeader& header) { return decodeImage(*bytes, header.width, header.height); });
  if (!image) image.error().where = path.string();
  return image;
}

}  // namespace tellurion::raster
