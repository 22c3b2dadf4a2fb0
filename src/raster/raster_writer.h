#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "geo/body.h"
#include "io/failure.h"
#include "raster/codec.h"
#include "raster/raster.h"
#include "raster/tile.h"

class GDALDataset;

namespace tellurion::raster {

/// Pixels in equal steps of longitude and latitude, row 0 north.
struct DegreesFrame {
  double west_degrees = 0.0;  ///< of the outer corner of pixel (0, 0)
  double north_degrees = 0.0;
  double step_degrees = 0.0;  ///< a pixel's side
  int width = 0;
  int height = 0;
};

/// What a raster is handed over in: a tiled GeoTIFF without overviews; a cloud-optimised one with; a GeoPackage with
/// overviews (imagery: tiles; elevation: a tiled gridded coverage of 32-bit floating point).
enum class RasterFormat : std::uint8_t { geotiff, cog, geopackage };

struct RasterWriting {
  RasterFormat format = RasterFormat::geotiff;
  Kind kind = Kind::elevation;
  geo::Body body = geo::earth();
  /// Imagery, not for geotiff: how pixels are compressed. PNG stands for "without loss".
  ImageFormat pixels = ImageFormat::png;
  int quality = 85;  ///< 1..100, of JPEG and WebP
};

/// Of the work that finish() does, 0..1; false asks it to stop.
using WritingProgress = std::function<bool(double)>;

/// A raster of longitude and latitude that is written window by window, in any order, in memory that does not depend on
/// its size. The spatial reference is EPSG:4326 on Earth, the IAU's of 2015 on Mars and the Moon, else one of the
/// body's own ellipsoid. Heights are float32; NODATA is NaN (in a GeoPackage, which knows no NaN, the lowest float32).
/// Colours have an alpha band (with JPEG, in a GeoTIFF, a mask). Move-only, one thread only.
class RasterWriter {
 public:
  static constexpr int kWindow = 512;  ///< side of the blocks that it is written in; windows on them are cheapest

  /// `output` and, but for geotiff, `scratch` are new files, which are not removed on failure.
  static io::Result<RasterWriter> create(const std::string& output, const std::string& scratch,
                                         const DegreesFrame& frame, const RasterWriting& writing);
  RasterWriter(RasterWriter&&) noexcept;
  RasterWriter& operator=(RasterWriter&&) noexcept;
  ~RasterWriter();

  /// `column` and `row` are those of the window's first pixel; it must lie in the frame. What is not written has no
  /// data.
  io::Result<void> write(int column, int row, const Raster<float>& heights);
  io::Result<void> write(int column, int row, const Raster<Rgba8>& colours);

  /// Ends the file; nothing may be written after. Fails with cancelled when `progress` says so.
  io::Result<void> finish(const WritingProgress& progress);

 private:
  struct State;
  explicit RasterWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tellurion::raster
