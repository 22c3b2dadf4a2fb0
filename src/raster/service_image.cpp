#include "raster/service_image.h"

#include <fmt/format.h>
#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <utility>

#include "raster/codec.h"
#include "raster/colour_bands.h"
#include "raster/gdal_session.h"
#include "raster/height_band.h"
#include "raster/picture_file.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;
constexpr int kSide = PixelStore<float>::kSide;

bool isA(PictureFormat format, const io::Resource& resource) {
  return pictureFormatOf(resource.bytes) == format;
}

bool isRaw(const io::Resource& resource, int width, int height) {
  const std::size_t samples = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const bool fits = resource.bytes.size() == 2 * samples || resource.bytes.size() == 4 * samples;
  const std::string& type = resource.contentType;
  return fits && (type.empty() || type.find("bil") != std::string::npos || type == "application/octet-stream" ||
                  type == "image/raw");
}

/// Calls visit(window) for windows of a size that bands read at a time.
template <class Visit>
io::Result<void> forEachWindow(int width, int height, const Visit& visit) {
  for (int row = 0; row < height; row += kSide) {
    for (int col = 0; col < width; col += kSide) {
      const Window window{0, col, row, std::min(kSide, width - col), std::min(kSide, height - row)};
      if (io::Result<void> done = visit(window); !done) return done;
    }
  }
  return {};
}

template <class T>
void paste(const std::vector<T>& block, const Window& window, Raster<T>& image) {
  for (int row = 0; row < window.height; ++row) {
    const T* from = block.data() + static_cast<std::ptrdiff_t>(row) * kSide;
    std::copy_n(from, window.width, &image.at(window.col, window.row + row));
  }
}

io::Result<Raster<Rgba8>> decodeWithGdal(const io::Resource& resource, int width, int height) {
  const GdalMessages messages;
  auto dataset = gdalOpenBytes(resource.bytes, width, height);
  if (!dataset) return tl::unexpected(std::move(dataset.error()));
  for (int band = 1; band <= (**dataset).GetRasterCount(); ++band) {
    if ((**dataset).GetRasterBand(band)->GetRasterDataType() != GDT_Byte) {
      return io::fail(Code::unsupported, "a picture of a server has bytes; ask for PNG or JPEG");
    }
  }
  std::vector<std::string> warnings;
  auto bands = ColourBands::open(**dataset, {}, std::nullopt, warnings);
  if (!bands) return tl::unexpected(std::move(bands.error()));
  Raster<Rgba8> image(width, height);
  std::vector<Rgba8> block(static_cast<std::size_t>(kSide) * kSide);
  auto done = forEachWindow(width, height, [&](const Window& window) -> io::Result<void> {
    if (auto read = bands->read(window, block.data()); !read) return read;
    paste(block, window, image);
    return {};
  });
  if (!done) return tl::unexpected(std::move(done.error()));
  return image;
}

/// value * scale + offset where that is a height that the body can have.
class HeightScale {
 public:
  HeightScale(double scale, double offset_m, const geo::Body& body)
      : scale_(scale), offset_m_(offset_m), possible_m_(possibleHeights_m(body)) {}
  float operator()(double stored) const {
    const double height_m = stored * scale_ + offset_m_;
    const bool isPossible = height_m >= possible_m_.first && height_m <= possible_m_.second;
    return isPossible ? static_cast<float>(height_m) : kNoData;
  }

 private:
  double scale_;
  double offset_m_;
  std::pair<double, double> possible_m_;
};

template <class T>
double numberAt(const std::byte* bytes, bool bigEndian) {
  std::array<std::byte, sizeof(T)> ordered;
  std::copy_n(bytes, sizeof(T), ordered.begin());
  if (bigEndian) std::ranges::reverse(ordered);
  T value;
  std::memcpy(&value, ordered.data(), sizeof(T));
  return static_cast<double>(value);
}

Raster<float> decodeRaw(const io::Resource& resource, int width, int height, const HeightEncoding& encoding,
                        const HeightScale& scale) {
  Raster<float> heights(width, height, kNoData);
  const bool isFloat = resource.bytes.size() == 4 * heights.samples.size();
  const std::byte* bytes = resource.bytes.data();
  for (std::size_t i = 0; i < heights.samples.size(); ++i) {
    const double stored = isFloat ? numberAt<float>(bytes + 4 * i, encoding.bigEndian)
                                  : numberAt<std::int16_t>(bytes + 2 * i, encoding.bigEndian);
    if (!encoding.nodata || stored != *encoding.nodata) heights.samples[i] = scale(stored);
  }
  return heights;
}

io::Result<Raster<float>> decodeBand(const io::Resource& resource, int width, int height,
                                     const HeightEncoding& encoding, const geo::Body& body) {
  if (isRaw(resource, width, height) && !isA(PictureFormat::tiff, resource) && !isA(PictureFormat::png, resource)) {
    return decodeRaw(resource, width, height, encoding, HeightScale(encoding.scale, encoding.offset_m, body));
  }
  const GdalMessages messages;
  auto dataset = gdalOpenBytes(resource.bytes, width, height);
  if (!dataset) return tl::unexpected(std::move(dataset.error()));
  GDALRasterBand& band = *(**dataset).GetRasterBand(1);
  const auto levels = bandLevels(**dataset, {1}, {});
  if (!levels) return tl::unexpected(levels.error());
  const BandLevel& full = levels->front();
  const auto nodata = noDataOf(band, encoding.nodata, {});
  if (!nodata) return tl::unexpected(nodata.error());
  const HeightScale scale(encoding.scale * band.GetScale(), encoding.scale * band.GetOffset() + encoding.offset_m,
                          body);
  Raster<float> heights(width, height, kNoData);
  std::vector<double> values(static_cast<std::size_t>(kSide) * kSide);
  std::vector<std::uint8_t> mask(full.mask != nullptr ? values.size() : 0);
  auto done = forEachWindow(width, height, [&](const Window& window) -> io::Result<void> {
    if (auto read = readValues(band, window, values.data(), {}); !read) return read;
    if (full.mask != nullptr) {
      if (auto read = readBytes(*full.mask, window, mask.data(), 1, {}); !read) return read;
    }
    for (int row = 0; row < window.height; ++row) {
      for (int col = 0; col < window.width; ++col) {
        const auto i = static_cast<std::size_t>(row) * kSide + static_cast<std::size_t>(col);
        if ((full.mask != nullptr && mask[i] == 0) || (*nodata && (*nodata)->matches(values[i]))) continue;
        heights.at(window.col + col, window.row + row) = scale(values[i]);
      }
    }
    return {};
  });
  if (!done) return tl::unexpected(std::move(done.error()));
  return heights;
}

/// Metres that the 24-bit number of a colour stands for: number * scale + offset.
HeightScale scaleOf(HeightEncoding::Kind kind, const geo::Body& body) {
  switch (kind) {
    case HeightEncoding::Kind::terrarium:
      return {1.0 / 256.0, -32768.0, body};
    case HeightEncoding::Kind::mapboxRgb:
      return {0.1, -10000.0, body};
    case HeightEncoding::Kind::centimetreRgb:
      return {1.0 / 1600.0, -1000.0, body};
    case HeightEncoding::Kind::band:
      break;
  }
  return {1.0, 0.0, body};
}

}  // namespace

io::Result<Raster<Rgba8>> decodeServiceImage(const io::Resource& resource, int width, int height,
                                             const std::optional<Rgba8>& transparent) {
  const auto format = pictureFormatOf(resource.bytes);
  auto image = format == PictureFormat::gif || format == PictureFormat::tiff
                   ? decodeWithGdal(resource, width, height)
                   : decodeImage(resource.bytes, width, height);
  if (image && transparent) {
    for (Rgba8& p : image->samples) {
      if (p.r == transparent->r && p.g == transparent->g && p.b == transparent->b) p = {};
    }
  }
  return image;
}

io::Result<Raster<float>> decodeServiceHeights(const io::Resource& resource, int width, int height,
                                               const HeightEncoding& encoding, const geo::Body& body) {
  if (encoding.kind == HeightEncoding::Kind::band) return decodeBand(resource, width, height, encoding, body);
  if (isA(PictureFormat::jpeg, resource)) {
    return io::fail(Code::unsupported, "heights in colours do not survive JPEG; ask for PNG or WebP");
  }
  auto image = decodeServiceImage(resource, width, height, std::nullopt);
  if (!image) return tl::unexpected(std::move(image.error()));
  const HeightScale scale = scaleOf(encoding.kind, body);
  Raster<float> heights(width, height, kNoData);
  for (std::size_t i = 0; i < heights.samples.size(); ++i) {
    const Rgba8& p = image->samples[i];
    const double number = p.r * 65536.0 + p.g * 256.0 + p.b;
    if (p.a != 0 && number != encoding.nodata) heights.samples[i] = scale(number);
  }
  return heights;
}

}  // namespace tellurion::raster
