#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "io/failure.h"
#include "pyramid/map_tiles.h"
#include "raster/codec.h"

namespace tellurion::pyramid {

/// What a set of map tiles says about itself.
struct TileSetFacts {
  std::string name;
  MapScheme scheme = MapScheme::mercator;
  raster::ImageFormat format = raster::ImageFormat::png;
  int minZoom = 0;
  int maxZoom = 0;
  geo::GeoRect bounds = geo::GeoRect::whole();
};

/// West, south, east, north in degrees, cut to what the scheme has; what crosses the date line runs all around, for
/// these formats have no other way to say it.
std::string boundsText(const TileSetFacts& facts);

/// Where the encoded tiles of an export go, one after another. One thread only.
class TileSet {
 public:
  virtual ~TileSet() = default;
  virtual io::Result<void> put(const MapTile& tile, std::span<const std::byte> bytes) = 0;
  virtual io::Result<void> finish() = 0;
};

/// A new MBTiles file (1.3): one SQLite file, rows counted from the south.
io::Result<std::unique_ptr<TileSet>> createMbtiles(const std::filesystem::path& path, const TileSetFacts& facts);

/// A new folder of files ZOOM/X/Y.ext, rows counted from the north, and tiles.json, which describes them.
io::Result<std::unique_ptr<TileSet>> createTileFolder(const std::filesystem::path& path, const TileSetFacts& facts);

/// Writes a file whole, the folders above it too.
io::Result<void> writeWholeFile(const std::filesystem::path& path, std::span<const std::byte> bytes);

/// The ending of a format's files, without a dot: jpg, png, webp.
std::string endingOf(raster::ImageFormat format);

}  // namespace tellurion::pyramid
