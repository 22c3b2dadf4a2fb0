#include "raster/band_levels.h"

#include <fmt/format.h>
#include <gdal_priv.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "raster/gdal_session.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

constexpr double kMostBlockBytes = 256.0 * (1u << 20u);
constexpr int kMostOverviews = 32;
/// Relative, of a 32-bit value and of its text with seven digits.
constexpr double kFloatRounding = 2.5e-7;

io::Result<void> checkBand(GDALRasterBand& band, const std::string& path) {
  const GDALDataType type = band.GetRasterDataType();
  if (type == GDT_Unknown || GDALDataTypeIsComplex(type) != 0) {
    return io::fail(Code::unsupported, "holds complex numbers; make a real band of them first (gdal_calc.py)", path);
  }
  int width = 0;
  int height = 0;
  band.GetBlockSize(&width, &height);
  const double bytes = double{1} * width * height * GDALGetDataTypeSizeBytes(type);
  if (width < 1 || height < 1) return io::fail(Code::corrupt, "has blocks without pixels", path);
  if (bytes > kMostBlockBytes) {
    return io::fail(Code::unsupported,
                    fmt::format("is stored in blocks of {} x {} pixels, too large to hold; store it in tiles first "
                                "(gdal_translate -co TILED=YES)",
                                width, height),
                    path);
  }
  return {};
}

/// A mask of the dataset or an alpha band; the mask that GDAL makes of NODATA values is left to us.
GDALRasterBand* maskOf(GDALRasterBand& band) {
  return (band.GetMaskFlags() & GMF_PER_DATASET) != 0 ? band.GetMaskBand() : nullptr;
}

std::optional<BandLevel> overviewLevel(const BandLevel& base, int overview) {
  BandLevel level;
  for (GDALRasterBand* band : base.bands) {
    if (overview >= band->GetOverviewCount()) return std::nullopt;
    GDALRasterBand* smaller = band->GetOverview(overview);
    if (smaller == nullptr || smaller->GetRasterDataType() != band->GetRasterDataType()) return std::nullopt;
    if (level.bands.empty()) {
      level.width = smaller->GetXSize();
      level.height = smaller->GetYSize();
    }
    if (smaller->GetXSize() != level.width || smaller->GetYSize() != level.height) return std::nullopt;
    level.bands.push_back(smaller);
  }
  if (level.width < 1 || level.height < 1 || level.width > base.width || level.height > base.height)
    return std::nullopt;
  const double across = static_cast<double>(base.width) / level.width;
  const double down = static_cast<double>(base.height) / level.height;
  const bool smallest = level.width < 4 || level.height < 4;
  if (!smallest && std::abs(across / down - 1.0) > 0.25) return std::nullopt;
  if (base.mask != nullptr) {
    level.mask = maskOf(*level.bands.front());
    if (level.mask == nullptr || level.mask->GetXSize() != level.width || level.mask->GetYSize() != level.height) {
      return std::nullopt;
    }
  }
  return level;
}

/// Floating point is rounded to; integers hold only themselves.
bool canHold(GDALDataType type, double value) {
  if (GDALDataTypeIsInteger(type) == 0) {
    const double largest = type == GDT_Float32 ? (1.0 + kFloatRounding) * static_cast<double>(std::numeric_limits<float>::max())
                                               : std::numeric_limits<double>::max();
    return !std::isfinite(value) || std::abs(value) <= largest;
  }
  if (!std::isfinite(value)) return false;
  int clamped = 0;
  int rounded = 0;
  GDALAdjustValueToDataType(type, value, &clamped, &rounded);
  return clamped == 0 && rounded == 0;
}

io::Result<void> read(GDALRasterBand& band, const Window& w, void* block, GDALDataType type, int spacing,
                      const std::string& path) {
  const GdalMessages messages;
  const auto row = static_cast<GSpacing>(spacing) * PixelStore<float>::kSide;
  if (band.RasterIO(GF_Read, w.col, w.row, w.width, w.height, block, w.width, w.height, type, spacing, row, nullptr) ==
      CE_None) {
    return {};
  }
  return tl::unexpected(
      messages.failure(Code::corrupt,
                       fmt::format("cannot be read at pixels {}..{}, {}..{}; the file is damaged or ends early", w.col,
                                   w.col + w.width - 1, w.row, w.row + w.height - 1),
                       path));
}

}  // namespace

io::Result<std::vector<BandLevel>> bandLevels(GDALDataset& dataset, const std::vector<int>& bands,
                                              const std::string& path) {
  BandLevel base{dataset.GetRasterXSize(), dataset.GetRasterYSize(), {}, nullptr};
  for (const int number : bands) {
    GDALRasterBand* band = dataset.GetRasterBand(number);
    if (band == nullptr) return io::fail(Code::corrupt, fmt::format("has no band {}", number), path);
    if (auto fit = checkBand(*band, path); !fit) return tl::unexpected(std::move(fit.error()));
    base.bands.push_back(band);
  }
  base.mask = maskOf(*base.bands.front());
  std::vector<BandLevel> levels{base};
  const int overviews = std::min(base.bands.front()->GetOverviewCount(), kMostOverviews);
  for (int i = 0; i < overviews; ++i) {
    if (auto level = overviewLevel(base, i)) levels.push_back(std::move(*level));
  }
  return levels;
}

io::Result<void> readValues(GDALRasterBand& band, const Window& window, double* block, const std::string& path) {
  return read(band, window, block, GDT_Float64, sizeof(double), path);
}

io::Result<void> readBytes(GDALRasterBand& band, const Window& window, std::uint8_t* block, int spacing,
                           const std::string& path) {
  return read(band, window, block, GDT_Byte, spacing, path);
}

NoDataValue::NoDataValue(double value, GDALRasterBand& band) {
  const GDALDataType type = band.GetRasterDataType();
  const double rounding = type == GDT_Float32 ? kFloatRounding : type == GDT_Float64 ? 1e-14 : 0.0;
  low_ = value - rounding * std::abs(value);
  high_ = value + rounding * std::abs(value);
}

io::Result<std::optional<NoDataValue>> noDataOf(GDALRasterBand& band, const std::optional<double>& given,
                                                const std::string& path) {
  if (given && !canHold(band.GetRasterDataType(), *given)) {
    return io::fail(
        Code::invalidArgument,
        fmt::format("stores {} values, which are never {:.17g}: --nodata names a value that is in the file; "
                    "where the inputs differ, build this one on its own and lay it over with --append",
                    GDALGetDataTypeName(band.GetRasterDataType()), *given),
        path);
  }
  if (given) return std::optional(NoDataValue(*given, band));
  int has = 0;
  const double own = band.GetNoDataValue(&has);
  if (has == 0) return std::optional<NoDataValue>{};
  return std::optional(NoDataValue(own, band));
}

}  // namespace tellurion::raster
