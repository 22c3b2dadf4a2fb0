#include "raster/gdal_session.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>

#include "raster/virtual_raster.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

constexpr GIntBig kGdalCacheBytes = GIntBig{256} << 20u;
constexpr std::size_t kMostWarnings = 16;

/// Drivers that read the file they are given, and files of fixed names or of their own format beside it. Left out is
/// what opens whatever a file names, with whatever driver fits (MRF, TIL, ISIS3, ERS, ...), what has links to
/// other files inside (HDF5, PCIDSK, ...), and all services and databases.
constexpr std::array kDrivers{
    "GTiff",   "SRTMHGT",  "PDS",    "PDS4",     "ISIS2",  "VICAR",   "ENVI",        "EHdr",          "AAIGrid",
    "AIG",     "HFA",      "NITF",   "JPEG",     "PNG",    "WEBP",    "GIF",         "BIGGIF",        "BMP",
    "PNM",     "SGI",      "JP2KAK", "JP2ECW",   "GPKG",   "MBTiles", "netCDF",      "GRIB",          "DTED",
    "USGSDEM", "XYZ",      "LAN",    "GTX",      "GSAG",   "GSBG",    "GS7BG",       "SAGA",          "RST",
    "BT",      "PCRaster", "ACE2",   "BYN",      "SIGDEM", "ROI_PAC", "RRASTER",     "Leveller",      "NWT_GRD",
    "ZMap",    "HF2",      "BLX",    "Terragen", "GXF",    "ISG",     "JP2OpenJPEG", "GRASSASCIIGrid"};
/// The same for shapes. (GML's would fetch schemas that a file names.)
constexpr std::array kVectorDrivers{"ESRI Shapefile", "GeoJSON", "GPKG", "FlatGeobuf", "KML"};
constexpr std::array kTableDrivers{"CSV"};
/// For images in memory: these read what they are given and nothing else.
constexpr std::array kMemoryDrivers{"GTiff", "PNG", "GIF"};
/// These open nothing: they write.
constexpr std::array kWritingDrivers{"COG"};
/// Is asked by MBTiles', and reads no rasters itself, so no side file is opened with it.
constexpr std::string_view kTablesDriver = "SQLite";
/// Drivers above decode into it.
constexpr std::string_view kMemoryDriver = "MEM";
constexpr std::string_view kVirtualDriver = "VRT";

bool isAllowed(std::string_view name) {
  return std::ranges::find(kDrivers, name) != kDrivers.end();
}

/// Opens virtual rasters that checkVirtualRaster() lets pass. Their driver stays registered, or it would register
/// itself again, but opens nothing for GDAL: so neither a side file nor a source of a mosaic can be a virtual raster.
GDALDataset* (*openVirtual)(GDALOpenInfo*) = nullptr;

/// Side files (.ovr, .msk, .aux.xml) are opened by GDAL itself, with every driver that it knows: so it knows no others.
void forgetOtherDrivers() {
  for (int i = GDALGetDriverCount() - 1; i >= 0; --i) {
    const GDALDriverH driver = GDALGetDriver(i);
    const std::string_view name = GDALGetDriverShortName(driver);
    const bool isForVectors = std::ranges::find(kVectorDrivers, name) != kVectorDrivers.end();
    const bool isForWriting = std::ranges::find(kWritingDrivers, name) != kWritingDrivers.end();
    const bool isForTables = name == kTableDrivers.front();
    if (name == kMemoryDriver || name == kTablesDriver || isAllowed(name) || isForVectors || isForTables ||
        isForWriting) {
      continue;
    }
    if (name == kVirtualDriver) {
      GDALDriver& virtualRasters = *GDALDriver::FromHandle(driver);
      openVirtual = std::exchange(virtualRasters.pfnOpen, nullptr);
      virtualRasters.pfnIdentify = nullptr;
      continue;
    }
    GDALDeregisterDriver(driver);
    GDALDestroyDriver(driver);
  }
}

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
    forgetOtherDrivers();
  });
}

template <std::size_t kCount>
CPLStringList namesOf(const std::array<const char*, kCount>& drivers) {
  CPLStringList names;
  for (const char* name : drivers)
    names.AddString(name);
  return names;
}

/// What GDAL would take for more than the name of a file.
bool isPlainName(const std::string& path) {
  return !path.empty() && path.find("://") == std::string::npos && !path.starts_with("/vsi") && !path.starts_with('<');
}

/// Whether all files of a raster lie in the folder of the one that was named, or below. Names as they are written:
/// links are the user's own.
bool staysInItsFolder(GDALDataset& dataset, const std::string& path) {
  const auto whole = [](const std::filesystem::path& name) {
    std::error_code error;
    return std::filesystem::absolute(name, error).lexically_normal();
  };
  const std::filesystem::path named = whole(path);
  const std::filesystem::path folder = named.parent_path();
  for (const std::string& name : filesOf(dataset)) {
    const std::filesystem::path file = whole(name);
    const auto [end, other] = std::ranges::mismatch(folder, file);
    if (end != folder.end()) return false;
  }
  return true;
}

DatasetPtr openVirtualRaster(const std::string& path) {
  if (openVirtual == nullptr) return nullptr;
  GDALOpenInfo info(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR);
  DatasetPtr dataset(openVirtual(&info));
  if (dataset && *dataset->GetDescription() == '\0') dataset->SetDescription(path.c_str());
  return dataset;
}

/// What to say of a file that holds several rasters and is none itself; nothing where it is one.
std::optional<io::Failure> severalRasters(GDALDataset& dataset, const std::string& path) {
  const CPLStringList parts(CSLDuplicate(dataset.GetMetadata("SUBDATASETS")));
  const char* first = parts.FetchNameValue("SUBDATASET_1_NAME");
  if (dataset.GetRasterCount() > 0 || first == nullptr) return std::nullopt;
  return io::Failure{Code::unsupported,
                     fmt::format("holds {} rasters; take out the one that is wanted (gdal_translate '{}' one.tif)",
                                 parts.size() / 2, first),
                     path};
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

std::vector<std::string> filesOf(GDALDataset& dataset) {
  const CPLStringList list(dataset.GetFileList());
  std::vector<std::string> names;
  for (int i = 0; i < list.size(); ++i)
    names.emplace_back(list[i]);
  std::ranges::sort(names);
  return names;
}

io::Result<DatasetPtr> gdalOpen(const std::string& path, std::vector<std::string>& warnings, bool sourcesAnywhere) {
  const GdalMessages messages;
  if (!isPlainName(path)) {
    return io::fail(Code::invalidArgument, "is not the name of a local file; copy the data here first", path);
  }
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return io::fail(Code::notFound, "there is no such file", path);
  DatasetPtr dataset;
  const bool isMosaic = isVirtualRaster(path);
  if (isMosaic) {
    if (auto ok = checkVirtualRaster(path, sourcesAnywhere); !ok) return tl::unexpected(ok.error());
    dataset = openVirtualRaster(path);
    // A source that cannot be opened is left out by GDAL, as if there were none.
    if (messages.failed()) {
      return tl::unexpected(messages.failure(Code::corrupt, "is a mosaic (VRT) of which a part cannot be read", path));
    }
  } else {
    const CPLStringList drivers = namesOf(kDrivers);
    dataset.reset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR,
                                    drivers.List(), nullptr, nullptr));
  }
  warnings.insert(warnings.end(), messages.warnings().begin(), messages.warnings().end());
  if (dataset) {
    if (const auto several = severalRasters(*dataset, path)) return tl::unexpected(*several);
  }
  if (dataset && ((isMosaic && sourcesAnywhere) || staysInItsFolder(*dataset, path))) return dataset;
  if (dataset) {
    return io::fail(Code::unsupported, "names files outside its own folder; put them beside it", path);
  }
  if (std::filesystem::is_directory(path, error))
    return io::fail(Code::invalidArgument, "is a folder; name the raster files in it", path);
  return tl::unexpected(messages.failure(
      Code::unsupported,
      "cannot be opened as a raster; a raw image is opened by its label (.LBL, .hdr), and for a virtual raster that is "
      "no VRT (MRF, ...) or a service the raster files themselves are wanted",
      path));
}

namespace {

io::Result<DatasetPtr> openShapes(const std::string& path, const CPLStringList& drivers, const char* failed) {
  const GdalMessages messages;
  if (!isPlainName(path)) {
    return io::fail(Code::invalidArgument, "is not the name of a local file; copy the data here first", path);
  }
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return io::fail(Code::notFound, "there is no such file", path);
  DatasetPtr dataset(GDALDataset::Open(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR,
                                       drivers.List(), nullptr, nullptr));
  if (dataset && staysInItsFolder(*dataset, path)) return dataset;
  if (dataset) {
    return io::fail(Code::unsupported, "names files outside its own folder; put them beside it", path);
  }
  return tl::unexpected(messages.failure(Code::unsupported, failed, path));
}

}  // namespace

io::Result<DatasetPtr> gdalOpenVector(const std::string& path) {
  return openShapes(path, namesOf(kVectorDrivers),
                    "cannot be opened as vectors (Shapefile, GeoJSON, GeoPackage, FlatGeobuf, KML)");
}

io::Result<DatasetPtr> gdalOpenTable(const std::string& path) {
  return openShapes(path, namesOf(kTableDrivers), "cannot be opened as a table of text with a line of names");
}

MemoryDataset::MemoryDataset(DatasetPtr dataset, std::string name)
    : dataset_(std::move(dataset)), name_(std::move(name)) {}
MemoryDataset::MemoryDataset(MemoryDataset&&) noexcept = default;
MemoryDataset::~MemoryDataset() {
  if (!dataset_) return;
  dataset_.reset();
  VSIUnlink(name_.c_str());
}

io::Result<MemoryDataset> gdalOpenBytes(std::span<const std::byte> bytes, int width, int height) {
  const GdalMessages messages;
  static std::atomic<std::uint64_t> count{0};
  std::string name = fmt::format("/vsimem/tellurion/{}", ++count);
  // GDAL does not write to what is opened for reading, its type only lacks the const.
  auto* memory = const_cast<GByte*>(reinterpret_cast<const GByte*>(bytes.data()));
  if (VSILFILE* file = VSIFileFromMemBuffer(name.c_str(), memory, bytes.size(), FALSE)) VSIFCloseL(file);
  const CPLStringList drivers = namesOf(kMemoryDrivers);
  const CPLConfigOptionSetter noNeighbours("GDAL_DISABLE_READDIR_ON_OPEN", "EMPTY_DIR", false);
  DatasetPtr dataset(
      GDALDataset::Open(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers.List(), nullptr, nullptr));
  if (!dataset) {
    VSIUnlink(name.c_str());
    return tl::unexpected(messages.failure(Code::corrupt, "the image is damaged, or of a format that is not read", {}));
  }
  const int foundWidth = dataset->GetRasterXSize();
  const int foundHeight = dataset->GetRasterYSize();
  MemoryDataset opened(std::move(dataset), std::move(name));
  if (foundWidth == width && foundHeight == height) return opened;
  return io::fail(Code::corrupt, fmt::format("the image has {} x {} pixels where {} x {} were expected", foundWidth,
                                             foundHeight, width, height));
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
