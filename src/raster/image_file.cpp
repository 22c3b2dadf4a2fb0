#include "raster/image_file.h"

#include <fmt/format.h>

#include <fstream>
#include <functional>
#include <system_error>

#include "raster/codec.h"
#include "raster/gdal_session.h"

namespace tellurion::raster {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr std::uintmax_t kMaxImageFileBytes = std::uintmax_t{1} << 30u;

/// A device, a pipe: something that a file must not be moved over.
bool takesBytesOnly(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

/// A failure to write the file beside it, told of the file that was asked for.
io::Failure toldOf(const fs::path& path, io::Failure failure, const fs::path& part) {
  const std::string name = part.string();
  for (std::string* text : {&failure.where, &failure.message}) {
    for (auto at = text->find(name); at != std::string::npos; at = text->find(name, at))
      text->replace(at, name.size(), path.string());
  }
  return failure;
}

/// Lets `write` make a file beside `path`, then moves it there.
io::Result<void> writeWhole(const fs::path& path, const std::function<io::Result<void>(const fs::path&)>& write) {
  fs::path part = path;
  part += ".part";
  std::error_code error;
  if (auto written = write(part); !written) {
    fs::remove(part, error);
    return tl::unexpected(toldOf(path, std::move(written.error()), part));
  }
  fs::rename(part, path, error);
  if (!error) return {};
  const std::string why = error.message();
  fs::remove(part, error);
  return io::fail(Code::ioError, "cannot be put in place: " + why, path.string());
}

io::Result<void> writeBytes(const fs::path& path, std::span<const std::byte> bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) return io::fail(Code::ioError, "cannot be written: does the folder exist, is there room?", path.string());
  return {};
}

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
  if (takesBytesOnly(path)) return writeBytes(path, *bytes);
  return writeWhole(path, [&](const fs::path& part) { return writeBytes(part, *bytes); });
}

io::Result<void> writeTiffFloat(const fs::path& path, const Raster<float>& values) {
  if (takesBytesOnly(path))
    return io::fail(Code::invalidArgument, "a TIFF cannot be written to a device", path.string());
  return writeWhole(path, [&](const fs::path& part) { return gdalWriteFloatTiff(part.string(), values); });
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
