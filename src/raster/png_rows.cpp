#include "raster/png_rows.h"

#include <fmt/format.h>
#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "io/output_file.h"

namespace tellurion::raster {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr int kMostSide = 1'000'000;

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

}  // namespace

struct PngRows::Parts {
  fs::path path;
  fs::path part;  ///< empty: a device
  std::unique_ptr<std::FILE, CloseFile> file;
  png_structp png = nullptr;
  png_infop info = nullptr;
  int width = 0;
  int height = 0;
  int rows = 0;  ///< written
  bool finished = false;
  std::string message;  ///< libpng's
  std::vector<std::uint8_t> row;

  Parts() = default;
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;
  ~Parts() {
    if (png != nullptr) png_destroy_write_struct(&png, &info);
    file.reset();
    std::error_code ignored;
    if (!finished && !part.empty()) fs::remove(part, ignored);
  }

  static void keepMessage(png_structp png, png_const_charp text) {
    static_cast<Parts*>(png_get_error_ptr(png))->message = text;
    png_longjmp(png, 1);
  }
  static void ignoreWarning(png_structp, png_const_charp) {}

  // libpng's failures are long jumps: these have nothing that would want to be destroyed.
  bool begin() {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_init_io(png, file.get());
    png_set_user_limits(png, kMostSide, kMostSide);
    png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_compression_level(png, 3);
    png_write_info(png, info);
    return true;
  }
  bool writeRow() {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_write_row(png, row.data());
    return true;
  }
  bool end() {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_write_end(png, info);
    return true;
  }
  tl::unexpected<io::Failure> failed() const {
    return io::fail(Code::ioError,
                    fmt::format("cannot be written: {} (does the folder exist, is there room?)",
                                message.empty() ? std::string(std::strerror(errno)) : message),
                    path.string());
  }
};

PngRows::PngRows(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
PngRows::~PngRows() = default;
PngRows::PngRows(PngRows&&) noexcept = default;
PngRows& PngRows::operator=(PngRows&&) noexcept = default;

io::Result<PngRows> PngRows::create(const fs::path& path, int width, int height) {
  if (width < 1 || height < 1 || width > kMostSide || height > kMostSide)
    return io::fail(Code::invalidArgument, fmt::format("a PNG has sides from 1 to {}", kMostSide), path.string());
  auto parts = std::make_unique<Parts>();
  parts->path = path;
  parts->width = width;
  parts->height = height;
  parts->row.resize(static_cast<std::size_t>(width) * 3);
  if (!io::isDevice(path)) parts->part = path.string() + ".part";
  parts->file.reset(std::fopen((parts->part.empty() ? path : parts->part).c_str(), "wb"));
  if (!parts->file) return parts->failed();
  parts->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, parts.get(), Parts::keepMessage, Parts::ignoreWarning);
  if (parts->png != nullptr) parts->info = png_create_info_struct(parts->png);
  if (parts->info == nullptr) return io::fail(Code::ioError, "no memory to write a PNG", path.string());
  if (!parts->begin()) return parts->failed();
  return PngRows(std::move(parts));
}

io::Result<void> PngRows::write(const Raster<Rgba8>& rows) {
  Parts& p = *parts_;
  if (rows.width != p.width || p.rows + rows.height > p.height)
    return io::fail(Code::invalidArgument, "rows that are not of this picture", p.path.string());
  for (int row = 0; row < rows.height; ++row) {
    for (int col = 0; col < rows.width; ++col) {
      const Rgba8& pixel = rows.at(col, row);
      std::uint8_t* out = &p.row[static_cast<std::size_t>(col) * 3];
      out[0] = pixel.r;
      out[1] = pixel.g;
      out[2] = pixel.b;
    }
    if (!p.writeRow()) return p.failed();
    ++p.rows;
  }
  return {};
}

io::Result<void> PngRows::finish() {
  Parts& p = *parts_;
  if (p.rows != p.height)
    return io::fail(Code::invalidArgument, fmt::format("{} of {} rows came", p.rows, p.height), p.path.string());
  const bool isEnded = p.end();
  const bool isClosed = std::fclose(p.file.release()) == 0;
  if (!isEnded || !isClosed) return p.failed();
  std::error_code error;
  if (!p.part.empty()) std::filesystem::rename(p.part, p.path, error);
  if (error) return io::fail(Code::ioError, "cannot be put in place: " + error.message(), p.path.string());
  p.finished = true;
  return {};
}

}  // namespace tellurion::raster
