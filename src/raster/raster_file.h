#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geo/body.h"
#include "geo/geo_rect.h"
#include "io/failure.h"
#include "raster/raster.h"
#include "raster/tile.h"
#include "tiling/tiling.h"

namespace tellurion::raster {

/// What a person may know better than the file, and the memory that it may take.
struct RasterOptions {
  std::optional<double> nodata;   ///< in place of the file's own NODATA values; as stored, before scale and offset
  std::optional<geo::Body> body;  ///< in place of what the file's spatial reference says
  /// The user named the file: the sources of a mosaic (VRT) may lie anywhere, and else in its folder or below only.
  bool sourcesAnywhere = false;
  std::size_t cacheBytes = std::size_t{64} << 20u;  ///< decoded blocks that are kept; a few are kept in any case
};

struct RasterInfo {
  std::string path;
  std::vector<std::string> files;  ///< all that it is read from: world file, overviews, label, ... beside it; sorted
  int width = 0;                   ///< pixels
  int height = 0;                  ///< pixels
  int bands = 0;
  geo::GeoRect bounds;  ///< holds the pixels' full area
  geo::Angle
      finestSpacing;  ///< the largest, over the raster, of a pixel's smaller side, as an angle on the unit sphere
  geo::Body body = geo::earth();
  bool bodyIsAssumed = false;         ///< no spatial reference names it: RasterOptions does, or else it is Earth
  double heightQuantum_m = 0.0;       ///< elevation: metres between two stored integers; 0 for floating point
  std::vector<std::string> warnings;  ///< what was assumed, sentences without a full stop; may grow while sampling
};

/// A raster file that GDAL reads, in any spatial reference, sampled at places on its body. One thread only; move-only.
/// Opening the same file once a thread is fine. Safe on untrusted files as far as GDAL's drivers are: sizes are bounded
/// before they are believed, only plain local files are opened (no /vsi path, no URL), with drivers of a list (GeoTIFF,
/// HGT, PDS, ENVI, HFA, JPEG, PNG, JPEG 2000, GeoPackage, MBTiles, netCDF, GRIB, ... : gdal_session.cpp) that read what
/// they are given and files beside it, never what these name elsewhere; a raster whose files lie outside its folder is
/// refused, and GDAL and PROJ stay off the network. A virtual raster (VRT) is opened where it is a plain mosaic
/// (virtual_raster.h). The first file that is opened takes all other drivers out of this
/// process's GDAL, for side files are opened with any driver that GDAL knows. (netCDF's library may follow links inside
/// netCDF-4 files to other local files.)
///
/// Memory: decoded blocks of 256 x 256 samples are kept up to RasterOptions::cacheBytes a file, whatever the raster's
/// size, besides GDAL's own block cache, which all files share (held to 256 MiB unless GDAL_CACHEMAX says otherwise).
///
/// A sample depends on the direction and the footprint alone, never on the other samples of a call, to the last bit.
///
/// Places. A direction's latitude and longitude are taken to the file's spatial reference: on Earth with PROJ's best
/// transformation from WGS 84 for the raster's area, on other bodies as they are. Longitudes are taken modulo 360
/// degrees to where the raster lies. A raster without a spatial reference whose extent fits degrees is taken as
/// longitude and latitude. A pixel has data over its full area (clamped in the outer half pixel). A raster that runs
/// all around in longitude continues across its seam, and across a pole that it reaches, on the other side.
///
/// NODATA of elevation: NaN, infinities, the band's NODATA value, a mask or an alpha of 0, and heights that the body
/// cannot have (a void without its tag: Earth beyond -12000..9000 m, Mars and Moon beyond -15000..30000 m, others
/// beyond their radius); the last with a warning. Heights are value * scale + offset in the band's unit (metres or
/// feet, survey feet, kilometres, centimetres); an offset that is the body's radius (PDS) is taken off again.
///
/// Colour: the bands marked red, green and blue; else a palette; else grey; else the first three bands of three or
/// more, else the first. Coverage: alpha band, else mask; else 0 where all colour bands hold their NODATA value. Bytes
/// are sRGB. Wider types are scaled linearly to 0..255: from 0 to the largest value of the stated bits (NBITS) or of a
/// PNG, else from the 0.5th to the 99.5th percentile of a sparse sample of all colour bands together (a warning says
/// which values).
class RasterFile {
 public:
  /// Failures name the file: notFound, unsupported (no georeference, no such driver, ...), corrupt, invalidArgument.
  static io::Result<RasterFile> open(const std::string& path, Kind kind, const RasterOptions& options = {});
  RasterFile(RasterFile&&) noexcept;
  RasterFile& operator=(RasterFile&&) noexcept;
  ~RasterFile();

  const RasterInfo& info() const;

  /// Conservative: false only when no place of the tile, its edges included, lies in the raster or as near to it as
  /// `within`.
  bool mayTouch(const tiling::Tiling& tiling, const tiling::TileId& id, geo::Angle within = {}) const;

  /// Heights in metres, one for each direction; out (of the same size) is written only where there is data.
  /// footprint 0: bilinear between the four nearest samples; NODATA when the nearest is NODATA, else over those of the
  /// four that have data. Else: the mean over a square of that angular side (at least a pixel), of the pixels weighted
  /// with the area of theirs inside; NODATA when less than half of the square has data. Overviews are used when the
  /// square is wide. Fails when the file cannot be read on; out is then partly written.
  io::Result<void> sampleHeights(std::span<const geo::Direction> directions, geo::Angle footprint,
                                 std::span<float> out);

  /// Colours, by the same rules in linear light and weighted with coverage; the result is laid over what out holds. The
  /// coverage of a mean is the share of the square that is covered.
  io::Result<void> sampleColours(std::span<const geo::Direction> directions, geo::Angle footprint,
                                 std::span<Rgba8> out);

  /// Heights as sampleHeights gives them, of samples of an elevation tile with its gutter (raster/tile.h): those at
  /// `indices`, ascending; corners of the gutter that no single place owns must not be among them. A sample that
  /// several tiles share gets the same bits from each. They are those of sampleHeights but where the raster is one of
  /// longitudes and latitudes and the tiling geographic: there no direction is made first, which is many times faster,
  /// and places differ by some 1e-15 of a turn.
  io::Result<void> sampleTile(const tiling::Tiling& tiling, const tiling::TileId& id, int cells,
                              std::span<const std::size_t> indices, geo::Angle footprint, std::span<float> out);

  /// The same for colours, row by row; out, of the size of indices, is laid over. Exact in the gutter; elsewhere beside
  /// the place by less than 1/256 of a pixel, which is many times faster. Corners of the gutter that no single place
  /// owns get nothing.
  io::Result<void> sampleTile(const tiling::Tiling& tiling, const tiling::TileId& id, int cells,
                              std::span<const std::size_t> indices, geo::Angle footprint, std::span<Rgba8> out);

 private:
  struct State;
  explicit RasterFile(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tellurion::raster
