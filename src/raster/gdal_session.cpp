#include "raster/gdal_session.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <fmt/format.h>
#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <mutex>
#include <string_view>
#include <utility>

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

constexpr GIntBig kGdalCacheBytes = GIntBig{256} << 20u;
constexpr std::size_t kMostWarnings = 16;

/// Drivers that read other places than the file they are given: other files by name, servers, databases.
constexpr std::array kFarReachingDrivers{"VRT",    "DERIVED", "GTI",    "WMS",    "WMTS",          "WCS",       "HTTP",
                                         "OGCAPI", "STACIT",  "STACTA", "NGW",    "PLMOSAIC",      "PLSCENES",  "EEDA",
                                         "EEDAI",  "DAAS",    "RDA",    "TileDB", "PostGISRaster", "GeoRaster", "SDE"};

void prepareGdal() {
  static std::once_flag once;
  std::call_once(once, [] {
    // Sidecar files may name overviews anywhere; nothing is fetched whatever they say.
    CPLSetConfigOption("CPL_VSIL_CURL_ALLOWED_FILENAME", "/vsicurl/none");
    // A JPEG that ends early is an error and not a grey area.
    if (CPLGetConfigOption("GDAL_ERROR_ON_LIBJPEG_WARNING", nullptr) == nullptr) {
      CPLSetConfigOption("GDAL_ERROR_ON_LIBJPEG_WARNING", "YES");
    }
    if (CPLGetConfigOption("GDAL_CACHEMAX", nullptr) == nullptr) {
      GDALSetCacheMax64(std::min(GDALGetCacheMax64(), kGdalCacheBytes));
    }
    GDALAllRegister();
  });
}

CPLStringList allowedDrivers() {
  CPLStringList names;
  for (int i = 0; i < GDALGetDriverCount(); ++i) {
    const GDALDriverH driver = GDALGetDriver(i);
    const std::string_view name = GDALGetDriverShortName(driver);
    const bool reachesFar = std::ranges::any_of(kFarReachingDrivers, [&](const char* far) { return name == far; });
    if (!reachesFar && GDALGetMetadataItem(driver, GDAL_DCAP_RASTER, nullptr) != nullptr) names.AddString(name.data());
  }
  return names;
}

/// What GDAL would take for more than the name of a file.
bool isPlainName(const std::string& path) {
  return !path.empty() && path.find("://") == std::string::npos && !path.starts_with("/vsi") && !path.starts_with('<');
}

}  // namespace

GdalMessages::GdalMessages() {
  prepareGdal();
  CPLPushErrorHandlerEx([](CPLErr severity, CPLErrorNum number, const char* text) { collect(severity, number, text); },
                        this);
}

GdalMessages::~GdalMessages() {
  CPLPopErrorHandler();
}

void GdalMessages::collect(int severity, int /*number*/, const char* text) {
  auto& messages = *static_cast<GdalMessages*>(CPLGetErrorHandlerUserData());
  if (severity >= CE_Failure) {
    messages.lastError_ = text;
  } else if (severity == CE_Warning && messages.warnings_.size() < kMostWarnings) {
    messages.warnings_.emplace_back(text);
  }
}

io::Failure GdalMessages::failure(Code code, std::string what, std::string where) const {
  if (!lastError_.empty()) what += fmt::format(" (GDAL: {})", lastError_);
  std::ranges::replace(what, '\n', ' ');
  return {code, std::move(what), std::move(where)};
}

void CloseDataset::operator()(GDALDataset* dataset) const {
  GDALClose(GDALDataset::ToHandle(dataset));
}

io::Result<DatasetPtr> gdalOpen(const std::string& path, std::vector<std::string>& warnings) {
  const GdalMessages messages;
  if (!isPlainName(path)) {
    return io::fail(Code::invalidArgument, "is not the name of a local file; copy the data here first", path);
  }
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return io::fail(Code::notFound, "there is no such file", path);
  const CPLStringList drivers = allowedDrivers();
  DatasetPtr dataset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR,
                                       drivers.List(), nullptr, nullptr));
  warnings.insert(warnings.end(), messages.warnings().begin(), messages.warnings().end());
  if (dataset) return dataset;
  return tl::unexpected(messages.failure(
      Code::unsupported,
      "cannot be opened as a raster; a raw image is opened by its label (.LBL, .hdr), and for a virtual raster "
      "(VRT) or a service the raster files themselves are wanted",
      path));
}

io::Result<void> gdalWriteFloatTiff(const std::string& path, const Raster<float>& values) {
  const GdalMessages messages;
  if (values.width < 1 || values.height < 1) return io::fail(Code::invalidArgument, "nothing to write", path);
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  if (driver == nullptr) return io::fail(Code::unsupported, "this GDAL has no GTiff driver", path);
  CPLStringList options;
  options.SetNameValue("COMPRESS", "DEFLATE");
  options.SetNameValue("PREDICTOR", "3");
  DatasetPtr dataset(driver->Create(path.c_str(), values.width, values.height, 1, GDT_Float32, options.List()));
  if (!dataset) return tl::unexpected(messages.failure(Code::ioError, "cannot be written", path));
  GDALRasterBand* band = dataset->GetRasterBand(1);
  band->SetNoDataValue(std::numeric_limits<double>::quiet_NaN());
  // GDAL does not write to the buffer of a write, its type only lacks the const.
  auto* samples = const_cast<float*>(values.samples.data());
  const CPLErr written = band->RasterIO(GF_Write, 0, 0, values.width, values.height, samples, values.width,
                                        values.height, GDT_Float32, 0, 0, nullptr);
  dataset->FlushCache(true);
  dataset.reset();
  if (written != CE_None || messages.failed()) {
    return tl::unexpected(messages.failure(Code::ioError, "cannot be written to its end; is there room?", path));
  }
  return {};
}

}  // namespace tellurion::raster
