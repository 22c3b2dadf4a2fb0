#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "raster/raster_file.h"
#include "raster/tile_source.h"

namespace tellurion::raster {

struct CatalogueOptions {
  RasterOptions raster;        ///< its cacheBytes are shared by all open files
  std::size_t openFiles = 32;  ///< kept open at a time, at least one; each loading thread may have one more
  int threads = 0;             ///< that read headers; 0: one for each core but one
  int tileCells = 0;           ///< 0: the usual for the kind
};

struct ImageCatalogue {
  std::shared_ptr<const TileSource> tiles;
  std::size_t images = 0;
  std::vector<std::string> warnings;  ///< "PATH: sentence", of files that are left out
};

/// Many raster files as one source: all that lie in a folder, however deep, or that a text file names a line each
/// (beside it unless the path is absolute; # begins a comment). Headers are read once, here; of thousands of files few
/// are open at a time. At each sample the image with the finest pixels that has data there wins, of equally fine ones
/// the later by name or line. An image less than a sixteenth of a tile across is not in it: it begins to show deeper
/// down. Heights' errors are estimates (estimatedStatistics).
///
/// Fails when nothing in it can be opened; single files that cannot, or that lie on another body than the first, are
/// left out with a warning. `source` is Thread-safe.
io::Result<ImageCatalogue> openCatalogue(const std::string& source, Kind kind, tiling::Scheme scheme,
                                         const CatalogueOptions& options = {});

}  // namespace tellurion::raster
