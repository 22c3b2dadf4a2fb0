#include "raster/raster_writer.h"

#include <cpl_string.h>
#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "raster/gdal_session.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

constexpr const char* kWriteFails = "cannot be written to its end; is there room?";
constexpr int kSmallestOverview = 256;

const char* driverOf(RasterFormat format) {
  switch (format) {
    case RasterFormat::geotiff:
      return "GTiff";
    case RasterFormat::cog:
      return "COG";
    case RasterFormat::geopackage:
      return "GPKG";
  }
  return "";
}

/// Longitude and latitude of a body, east first.
OGRSpatialReference referenceOf(const geo::Body& body) {
  OGRSpatialReference reference;
  reference.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const char* known = body == geo::earth()  ? "EPSG:4326"
                      : body == geo::mars() ? "IAU_2015:49900"
                      : body == geo::moon() ? "IAU_2015:30100"
                                            : nullptr;
  if (known != nullptr && reference.SetFromUserInput(known) == OGRERR_NONE) return reference;
  const double f = body.ellipsoid.flattening();
  reference.SetGeogCS(body.name.c_str(), body.name.c_str(), body.name.c_str(), body.ellipsoid.semiMajorAxis_m(),
                      f > 0.0 ? 1.0 / f : 0.0);
  return reference;
}

CPLStringList workingOptions(const RasterWriting& writing) {
  CPLStringList options;
  options.SetNameValue("TILED", "YES");
  options.SetNameValue("BLOCKXSIZE", fmt::format("{}", RasterWriter::kWindow).c_str());
  options.SetNameValue("BLOCKYSIZE", fmt::format("{}", RasterWriter::kWindow).c_str());
  options.SetNameValue("COMPRESS", "DEFLATE");
  options.SetNameValue("PREDICTOR", writing.kind == Kind::elevation ? "3" : "2");
  options.SetNameValue("BIGTIFF", "IF_SAFER");
  options.SetNameValue("SPARSE_OK", "TRUE");
  if (writing.kind == Kind::imagery) {
    options.SetNameValue("PHOTOMETRIC", "RGB");
    options.SetNameValue("ALPHA", "NON-PREMULTIPLIED");
  }
  // What is copied once more is read and thrown away.
  if (writing.format != RasterFormat::geotiff) options.SetNameValue("ZLEVEL", "1");
  return options;
}

CPLStringList cogOptions(const RasterWriting& writing) {
  CPLStringList options;
  options.SetNameValue("BLOCKSIZE", fmt::format("{}", RasterWriter::kWindow).c_str());
  options.SetNameValue("BIGTIFF", "IF_SAFER");
  options.SetNameValue("SPARSE_OK", "TRUE");
  options.SetNameValue("OVERVIEW_RESAMPLING", "AVERAGE");
  if (writing.kind == Kind::elevation || writing.pixels == ImageFormat::png) {
    options.SetNameValue("COMPRESS", "DEFLATE");
    options.SetNameValue("PREDICTOR", "YES");
    return options;
  }
  options.SetNameValue("COMPRESS", writing.pixels == ImageFormat::jpeg ? "JPEG" : "WEBP");
  options.SetNameValue("QUALITY", fmt::format("{}", writing.quality).c_str());
  options.SetNameValue("OVERVIEW_QUALITY", fmt::format("{}", writing.quality).c_str());
  return options;
}

CPLStringList geopackageOptions(const RasterWriting& writing) {
  CPLStringList options;
  options.SetNameValue("RASTER_TABLE", writing.kind == Kind::elevation ? "elevation" : "imagery");
  if (writing.kind == Kind::elevation) {
    options.SetNameValue("TILE_FORMAT", "TIFF");
    return options;
  }
  switch (writing.pixels) {
    case ImageFormat::jpeg:
      options.SetNameValue("TILE_FORMAT", "JPEG");
      break;
    case ImageFormat::png:
      options.SetNameValue("TILE_FORMAT", "PNG");
      break;
    case ImageFormat::webp:
      options.SetNameValue("TILE_FORMAT", "WEBP");
      break;
  }
  options.SetNameValue("QUALITY", fmt::format("{}", writing.quality).c_str());
  return options;
}

/// None for what one tile shows whole.
std::vector<int> overviewFactors(int width, int height) {
  std::vector<int> factors;
  if (std::max(width, height) <= kSmallestOverview) return factors;
  for (int factor = 2; std::max(width, height) / factor >= kSmallestOverview / 2; factor *= 2)
    factors.push_back(factor);
  return factors;
}

/// A part of the work, for GDAL.
struct Stage {
  const WritingProgress* progress;
  double from;
  double to;

  static int CPL_STDCALL report(double share, const char* /*message*/, void* data) {
    const Stage& stage = *static_cast<const Stage*>(data);
    if (stage.progress == nullptr || !*stage.progress) return TRUE;
    return (*stage.progress)(stage.from + (stage.to - stage.from) * share) ? TRUE : FALSE;
  }
};

}  // namespace

struct RasterWriter::State {
  std::string output;
  DegreesFrame frame;
  RasterWriting writing;
  std::string written;  ///< where windows go: the output itself, or the scratch file
  double nodata = std::numeric_limits<double>::quiet_NaN();
  DatasetPtr dataset;

  bool holds(int column, int row, int width, int height) const {
    return column >= 0 && row >= 0 && width > 0 && height > 0 && column <= frame.width - width &&
           row <= frame.height - height;
  }
  io::Result<void> close(const GdalMessages& messages);
  io::Result<void> copy(const GdalMessages& messages, const WritingProgress& progress);
  io::Result<void> addOverviews(const GdalMessages& messages, GDALDataset& made, const WritingProgress& progress);
};

RasterWriter::RasterWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
RasterWriter::RasterWriter(RasterWriter&&) noexcept = default;
RasterWriter& RasterWriter::operator=(RasterWriter&&) noexcept = default;
RasterWriter::~RasterWriter() {
  const GdalMessages messages;  // closing may complain
  if (state_) state_->dataset.reset();
}

io::Result<RasterWriter> RasterWriter::create(const std::string& output, const std::string& scratch,
                                              const DegreesFrame& frame, const RasterWriting& writing) {
  const GdalMessages messages;
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  if (driver == nullptr || GetGDALDriverManager()->GetDriverByName(driverOf(writing.format)) == nullptr) {
    return io::fail(Code::unsupported, fmt::format("this GDAL has no {} driver", driverOf(writing.format)), output);
  }
  auto state = std::make_unique<State>();
  state->output = output;
  state->frame = frame;
  state->writing = writing;
  state->written = writing.format == RasterFormat::geotiff ? output : scratch;
  if (writing.format == RasterFormat::geopackage) {
    state->nodata = static_cast<double>(std::numeric_limits<float>::lowest());
  }
  const bool isElevation = writing.kind == Kind::elevation;
  state->dataset.reset(driver->Create(state->written.c_str(), frame.width, frame.height, isElevation ? 1 : 4,
                                      isElevation ? GDT_Float32 : GDT_Byte, workingOptions(writing).List()));
  if (!state->dataset) return tl::unexpected(messages.failure(Code::ioError, "cannot be written", state->written));
  std::array<double, 6> transform{frame.west_degrees, frame.step_degrees, 0.0, frame.north_degrees, 0.0,
                                  -frame.step_degrees};
  const OGRSpatialReference reference = referenceOf(writing.body);
  bool isSet = state->dataset->SetGeoTransform(transform.data()) == CE_None &&
               state->dataset->SetSpatialRef(&reference) == CE_None;
  if (isElevation) {
    isSet = isSet && state->dataset->GetRasterBand(1)->SetNoDataValue(state->nodata) == CE_None;
    state->dataset->GetRasterBand(1)->SetUnitType("m");
  }
  if (!isSet) return tl::unexpected(messages.failure(Code::ioError, "cannot be placed on its body", state->written));
  return RasterWriter(std::move(state));
}

io::Result<void> RasterWriter::write(int column, int row, const Raster<float>& heights) {
  const GdalMessages messages;
  if (!state_->dataset || state_->writing.kind != Kind::elevation ||
      !state_->holds(column, row, heights.width, heights.height)) {
    return io::fail(Code::invalidArgument, "no window of this raster of heights", state_->output);
  }
  std::vector<float> samples = heights.samples;
  for (float& h : samples)
    if (isNoData(h)) h = static_cast<float>(state_->nodata);
  const CPLErr result =
      state_->dataset->GetRasterBand(1)->RasterIO(GF_Write, column, row, heights.width, heights.height, samples.data(),
                                                  heights.width, heights.height, GDT_Float32, 0, 0, nullptr);
  if (result == CE_None) return {};
  return tl::unexpected(messages.failure(Code::ioError, kWriteFails, state_->written));
}

io::Result<void> RasterWriter::write(int column, int row, const Raster<Rgba8>& colours) {
  const GdalMessages messages;
  if (!state_->dataset || state_->writing.kind != Kind::imagery ||
      !state_->holds(column, row, colours.width, colours.height)) {
    return io::fail(Code::invalidArgument, "no window of this raster of colours", state_->output);
  }
  std::vector<Rgba8> pixels = colours.samples;
  const CPLErr result = state_->dataset->RasterIO(GF_Write, column, row, colours.width, colours.height, pixels.data(),
                                                  colours.width, colours.height, GDT_Byte, 4, nullptr, sizeof(Rgba8),
                                                  static_cast<GSpacing>(sizeof(Rgba8)) * colours.width, 1, nullptr);
  if (result == CE_None) return {};
  return tl::unexpected(messages.failure(Code::ioError, kWriteFails, state_->written));
}

io::Result<void> RasterWriter::State::close(const GdalMessages& messages) {
  dataset->FlushCache(true);
  dataset.reset();
  if (!messages.failed()) return {};
  return tl::unexpected(messages.failure(Code::ioError, kWriteFails, written));
}

io::Result<void> RasterWriter::State::addOverviews(const GdalMessages& messages, GDALDataset& made,
                                                   const WritingProgress& progress) {
  std::vector<int> factors = overviewFactors(frame.width, frame.height);
  if (factors.empty()) return {};
  Stage stage{&progress, 0.5, 1.0};
  if (made.BuildOverviews("AVERAGE", static_cast<int>(factors.size()), factors.data(), 0, nullptr, Stage::report,
                          &stage, nullptr) == CE_None) {
    return {};
  }
  return tl::unexpected(messages.failure(Code::ioError, kWriteFails, output));
}

io::Result<void> RasterWriter::State::copy(const GdalMessages& messages, const WritingProgress& progress) {
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName(driverOf(writing.format));
  const bool isPackage = writing.format == RasterFormat::geopackage;
  const CPLStringList options = isPackage ? geopackageOptions(writing) : cogOptions(writing);
  DatasetPtr source(GDALDataset::Open(written.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!source) return tl::unexpected(messages.failure(Code::ioError, "cannot be read again", written));
  Stage stage{&progress, 0.0, isPackage ? 0.5 : 1.0};
  DatasetPtr made(driver->CreateCopy(output.c_str(), source.get(), FALSE, options.List(), Stage::report, &stage));
  if (!made) return tl::unexpected(messages.failure(Code::ioError, kWriteFails, output));
  if (isPackage) {
    if (auto ok = addOverviews(messages, *made, progress); !ok) return ok;
  }
  made->FlushCache(true);
  made.reset();
  if (!messages.failed()) return {};
  return tl::unexpected(messages.failure(Code::ioError, kWriteFails, output));
}

io::Result<void> RasterWriter::finish(const WritingProgress& progress) {
  const GdalMessages messages;
  if (!state_->dataset) return io::fail(Code::invalidArgument, "is finished already", state_->output);
  if (auto ok = state_->close(messages); !ok) return ok;
  if (state_->writing.format == RasterFormat::geotiff) return {};
  bool isStopped = false;
  const WritingProgress watched = [&](double share) {
    isStopped = progress && !progress(share);
    return !isStopped;
  };
  auto copied = state_->copy(messages, watched);
  if (isStopped) return io::fail(Code::cancelled, "stopped", state_->output);
  return copied;
}

}  // namespace tellurion::raster
