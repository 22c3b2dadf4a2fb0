#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "pyramid/export_run.h"
#include "raster/block_cache.h"
#include "raster/raster_writer.h"

namespace tellurion::pyramid {
namespace {

using Code = io::Failure::Code;
using raster::DegreesFrame;
using raster::RasterWriter;

constexpr std::uint64_t kBlockCacheBytes = std::uint64_t{128} << 20u;  // windows are written once; overviews read rows
constexpr double kFormatsSide = 2147483647.0;                          // pixels: what TIFF and GDAL count to

/// Degrees of a pixel that is as fine as the samples of a level: a quarter of a turn over a tile's samples, halved as
/// often as that takes. So it is the samples' own step around the geographic tiling's equator.
double stepOf(const ExportSamples& samples, int level) {
  double step = 90.0 / samples.info().tileCells;
  while (step > 1.1 * samples.spacing_degrees(level))
    step /= 2.0;
  return step;
}

/// The pixels of the grid that begins at 180 west, 90 north which hold an area.
io::Result<DegreesFrame> frameOf(const geo::GeoRect& area, double step) {
  constexpr double kSlack = 1e-6;  // of a pixel: an edge that is meant to be a pixel's is
  const double west = area.west.degrees();
  const double firstColumn = std::floor((west + 180.0) / step + kSlack);
  const double firstRow = std::floor((90.0 - area.north.degrees()) / step + kSlack);
  const double endColumn = std::ceil((west + area.width.degrees() + 180.0) / step - kSlack);
  const double endRow = std::ceil((90.0 - area.south.degrees()) / step - kSlack);
  const double width = std::min(endColumn - firstColumn, 360.0 / step);
  const double height = endRow - firstRow;
  if (width < 1.0 || height < 1.0) return io::fail(Code::invalidArgument, "the region is empty");
  if (width > kFormatsSide || height > kFormatsSide) {
    return io::fail(Code::invalidArgument,
                    fmt::format("{:.0f} x {:.0f} pixels are more than a raster can have; export a region, or a coarser "
                                "level",
                                width, height));
  }
  return DegreesFrame{.west_degrees = firstColumn * step - 180.0,
                      .north_degrees = 90.0 - firstRow * step,
                      .step_degrees = step,
                      .width = static_cast<int>(width),
                      .height = static_cast<int>(height)};
}

/// What is asked for, of what there is: both may cross the date line.
io::Result<geo::GeoRect> areaOf(const ExportRun& run) {
  const geo::GeoRect& bounds = run.samples.info().bounds;
  if (!run.options.region) return bounds;
  if (run.options.region->intersects(bounds)) return *run.options.region;
  return io::fail(Code::invalidArgument, "has no data in the region; 'tellurion info' tells where it has",
                  run.samples.info().name);
}

struct Window {
  int column = 0;
  int row = 0;
  int width = 0;
  int height = 0;
};

PlaceGrid placesOf(const DegreesFrame& frame, const Window& window) {
  PlaceGrid grid;
  for (int c = 0; c < window.width; ++c)
    grid.longitudes_degrees.push_back(frame.west_degrees + (window.column + c + 0.5) * frame.step_degrees);
  for (int r = 0; r < window.height; ++r)
    grid.latitudes_degrees.push_back(frame.north_degrees - (window.row + r + 0.5) * frame.step_degrees);
  grid.steps_degrees.assign(grid.latitudes_degrees.size(), frame.step_degrees);
  return grid;
}

struct MadeWindow {
  Window window;
  std::variant<raster::Raster<float>, raster::Raster<raster::Rgba8>> samples;
  bool isEmpty = false;
};

io::Result<MadeWindow> made(const ExportRun& run, const DegreesFrame& frame, const Window& window) {
  const PlaceGrid grid = placesOf(frame, window);
  const int deepest = std::min(run.options.maxLevel.value_or(tiling::kMaxLevel), run.samples.info().maxLevel);
  if (run.samples.info().kind == raster::Kind::elevation) {
    auto heights = run.samples.heights(grid, deepest);
    if (!heights) return tl::unexpected(heights.error());
    const bool isEmpty = std::ranges::all_of(heights->samples, raster::isNoData);
    return MadeWindow{.window = window, .samples = std::move(*heights), .isEmpty = isEmpty};
  }
  auto colours = run.samples.colours(grid, deepest);
  if (!colours) return tl::unexpected(colours.error());
  const bool isEmpty = std::ranges::all_of(colours->samples, [](const raster::Rgba8& p) { return p.a == 0; });
  return MadeWindow{.window = window, .samples = std::move(*colours), .isEmpty = isEmpty};
}

/// Blocks of the file, row by row.
class Windows {
 public:
  explicit Windows(const DegreesFrame& frame) : frame_(frame) {}
  std::uint64_t count() const { return across(frame_.width) * across(frame_.height); }
  std::optional<Window> next() {
    if (next_ == count()) return std::nullopt;
    const auto column = static_cast<int>(next_ % across(frame_.width)) * RasterWriter::kWindow;
    const auto row = static_cast<int>(next_ / across(frame_.width)) * RasterWriter::kWindow;
    ++next_;
    return Window{.column = column,
                  .row = row,
                  .width = std::min(RasterWriter::kWindow, frame_.width - column),
                  .height = std::min(RasterWriter::kWindow, frame_.height - row)};
  }

 private:
  static std::uint64_t across(int pixels) {
    return (static_cast<std::uint64_t>(pixels) + RasterWriter::kWindow - 1) / RasterWriter::kWindow;
  }
  DegreesFrame frame_;
  std::uint64_t next_ = 0;
};

raster::RasterFormat rasterFormatOf(ExportFormat format) {
  switch (format) {
    case ExportFormat::cog:
      return raster::RasterFormat::cog;
    case ExportFormat::geopackage:
      return raster::RasterFormat::geopackage;
    case ExportFormat::geotiff:
    case ExportFormat::mbtiles:
    case ExportFormat::xyz:
    case ExportFormat::quantizedMesh:
      break;
  }
  return raster::RasterFormat::geotiff;
}

/// Writes all windows; how many had data.
io::Result<std::uint64_t> writeWindows(const ExportRun& run, const DegreesFrame& frame, RasterWriter& writer) {
  Windows windows(frame);
  std::uint64_t written = 0;
  const auto next = [&](OrderedWork<io::Result<MadeWindow>>& work) {
    const auto window = windows.next();
    if (window) work.push([&run, &frame, window = *window] { return made(run, frame, window); });
    return window.has_value();
  };
  const auto take = [&](const io::Result<MadeWindow>& piece) -> io::Result<void> {
    if (!piece) return tl::unexpected(piece.error());
    if (piece->isEmpty) return {};
    ++written;
    return std::visit(
        [&](const auto& samples) { return writer.write(piece->window.column, piece->window.row, samples); },
        piece->samples);
  };
  if (auto ok = inOrder<io::Result<MadeWindow>>(run, windows.count(), next, take); !ok)
    return tl::unexpected(ok.error());
  return written;
}

}  // namespace

io::Result<ExportReport> exportRaster(const ExportRun& run, ExportPlace& place) {
  const raster::BlockCacheLimit limit(kBlockCacheBytes);
  const raster::TileSourceInfo& info = run.samples.info();
  const auto area = areaOf(run);
  if (!area) return tl::unexpected(area.error());
  const auto frame =
      frameOf(*area, stepOf(run.samples, std::min(run.options.maxLevel.value_or(info.maxLevel), tiling::kMaxLevel)));
  if (!frame) return tl::unexpected(frame.error());
  const auto most = mostUnasked(run);
  if (!most) return tl::unexpected(most.error());
  const double pixelsOfTile = static_cast<double>(info.tileCells) * info.tileCells;
  if (static_cast<double>(frame->width) * frame->height / pixelsOfTile > static_cast<double>(*most)) {
    return tl::unexpected(tooMagnified(run, *most));
  }
  const bool isPackage = run.options.format == ExportFormat::geopackage;
  const std::filesystem::path path = place.inside(isPackage ? "raster.gpkg" : "raster.tif");
  auto writer = RasterWriter::create(path.string(), place.inside("windows.tif").string(), *frame,
                                     {.format = rasterFormatOf(run.options.format),
                                      .kind = info.kind,
                                      .body = info.body,
                                      .pixels = run.options.pixels,
                                      .quality = run.options.quality});
  if (!writer) return tl::unexpected(writer.error());
  const auto written = writeWindows(run, *frame, *writer);
  if (!written) return tl::unexpected(written.error());
  if (*written == 0) {
    return io::fail(Code::invalidArgument, "has no data there: nothing to export; 'tellurion info' tells where it has",
                    info.name);
  }
  const auto finishing = [&](double share) {
    if (run.progress)
      run.progress({.done = static_cast<std::uint64_t>(share * 1000.0), .total = 1000, .isFinishing = true});
    return !run.stop.stop_requested();
  };
  if (auto ok = writer->finish(finishing); !ok) {
    return tl::unexpected(ok.error().code == Code::cancelled ? run.stopped() : ok.error());
  }
  if (auto ok = place.publish(path); !ok) return tl::unexpected(ok.error());
  return ExportReport{.width = frame->width, .height = frame->height, .step_degrees = frame->step_degrees};
}

}  // namespace tellurion::pyramid
