#include "raster/height_band.h"

#include <fmt/format.h>
#include <gdal_priv.h>

#include <array>
#include <cmath>
#include <string_view>

#include "raster/raster.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;
constexpr std::size_t kSide = PixelStore<float>::kSide;

bool isColour(GDALColorInterp meaning) {
  return meaning == GCI_PaletteIndex ||
         (meaning >= GCI_RedBand && meaning <= GCI_BlackBand && meaning != GCI_AlphaBand);
}

struct Unit {
  std::string_view name;
  double metres;
};
constexpr std::array kUnits{Unit{"", 1.0},
                            Unit{"m", 1.0},
                            Unit{"metre", 1.0},
                            Unit{"metres", 1.0},
                            Unit{"meter", 1.0},
                            Unit{"meters", 1.0},
                            Unit{"METER", 1.0},
                            Unit{"METERS", 1.0},
                            Unit{"ft", 0.3048},
                            Unit{"foot", 0.3048},
                            Unit{"feet", 0.3048},
                            Unit{"Foot", 0.3048},
                            Unit{"km", 1000.0},
                            Unit{"KILOMETER", 1000.0},
                            Unit{"cm", 0.01},
                            Unit{"US survey foot", 1200.0 / 3937.0},
                            Unit{"us-ft", 1200.0 / 3937.0},
                            Unit{"ftUS", 1200.0 / 3937.0}};

double metresOf(const char* unit, std::vector<std::string>& warnings) {
  for (const Unit& known : kUnits) {
    if (known.name == unit) return known.metres;
  }
  warnings.push_back(fmt::format("the unit of its heights, \"{}\", is not known: taken as metres", unit));
  return 1.0;
}

}  // namespace

std::pair<double, double> possibleHeights_m(const geo::Body& body) {
  if (body == geo::earth()) return {-12000.0, 9000.0};
  if (body == geo::mars() || body == geo::moon()) return {-15000.0, 30000.0};
  return {-body.ellipsoid.semiMinorAxis_m(), body.ellipsoid.semiMajorAxis_m()};
}

io::Result<HeightBand> HeightBand::open(GDALDataset& dataset, const std::string& path,
                                        const std::optional<double>& nodata, const geo::Body& body,
                                        std::vector<std::string>& warnings) {
  if (dataset.GetRasterCount() < 1) return io::fail(Code::unsupported, "has no bands", path);
  GDALRasterBand& band = *dataset.GetRasterBand(1);
  if (isColour(band.GetColorInterpretation())) {
    return io::fail(Code::invalidArgument, "holds colours and not heights; build it with --kind imagery", path);
  }
  HeightBand heights;
  auto levels = bandLevels(dataset, {1}, path);
  if (!levels) return tl::unexpected(std::move(levels.error()));
  heights.path_ = path;
  heights.levels_ = std::move(*levels);
  if (dataset.GetRasterCount() > 1 && heights.levels_.front().mask == nullptr) {
    warnings.push_back(fmt::format("has {} bands: the first is taken as the elevation", dataset.GetRasterCount()));
  }
  auto noData = noDataOf(band, nodata, path);
  if (!noData) return tl::unexpected(std::move(noData.error()));
  heights.nodata_ = *noData;
  const double unit_m = metresOf(band.GetUnitType(), warnings);
  heights.scale_ = band.GetScale() * unit_m;
  heights.offset_m_ = band.GetOffset() * unit_m;
  if (!std::isfinite(heights.scale_) || heights.scale_ == 0.0 || !std::isfinite(heights.offset_m_)) {
    return io::fail(Code::corrupt, "its scale or offset is not a number", path);
  }
  const double radius_m = body.ellipsoid.semiMajorAxis_m();
  if (std::abs(heights.offset_m_ / radius_m - 1.0) < 0.01) {
    heights.offset_m_ -= radius_m;
    warnings.push_back(fmt::format("stores distances from the body's centre: {:.10g} m are taken off", radius_m));
  }
  if (GDALDataTypeIsInteger(band.GetRasterDataType()) != 0) heights.quantum_m_ = std::abs(heights.scale_);
  std::tie(heights.lowest_m_, heights.highest_m_) = possibleHeights_m(body);
  return heights;
}

float HeightBand::heightOf(double stored) {
  if (!std::isfinite(stored) || (nodata_ && nodata_->matches(stored))) return kNoData;
  const double height_m = stored * scale_ + offset_m_;
  if (height_m >= lowest_m_ && height_m <= highest_m_) return static_cast<float>(height_m);
  metImpossible_ = true;
  return kNoData;
}

io::Result<void> HeightBand::read(const Window& window, float* block) {
  const BandLevel& level = levels_[static_cast<std::size_t>(window.level)];
  values_.resize(kSide * kSide);
  if (auto done = readValues(*level.bands.front(), window, values_.data(), path_); !done) return done;
  if (level.mask != nullptr) {
    mask_.resize(kSide * kSide);
    if (auto done = readBytes(*level.mask, window, mask_.data(), 1, path_); !done) return done;
  }
  for (std::size_t row = 0; row < static_cast<std::size_t>(window.height); ++row) {
    for (std::size_t i = row * kSide; i < row * kSide + static_cast<std::size_t>(window.width); ++i) {
      block[i] = level.mask != nullptr && mask_[i] == 0 ? kNoData : heightOf(values_[i]);
    }
  }
  return {};
}

}  // namespace tellurion::raster
