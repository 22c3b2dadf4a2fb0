#pragma once

#include <cstdint>

namespace tellurion::raster {

/// While it lives, the cache of file blocks that all RasterFiles of the process share (raster_file.h) holds no more
/// than this; an environment variable GDAL_CACHEMAX is stronger. One at a time.
class BlockCacheLimit {
 public:
  explicit BlockCacheLimit(std::uint64_t bytes);
  ~BlockCacheLimit();
  BlockCacheLimit(const BlockCacheLimit&) = delete;
  BlockCacheLimit& operator=(const BlockCacheLimit&) = delete;

 private:
  std::int64_t before_;
};

}  // namespace tellurion::raster
