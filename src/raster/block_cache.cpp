#include "raster/block_cache.h"

#include <cpl_conv.h>
#include <gdal_priv.h>

#include "raster/gdal_session.h"

namespace tellurion::raster {
namespace {

bool isUsersOwn() {
  return CPLGetConfigOption("GDAL_CACHEMAX", nullptr) != nullptr;
}

}  // namespace

BlockCacheLimit::BlockCacheLimit(std::uint64_t bytes) {
  const GdalMessages prepared;
  before_ = GDALGetCacheMax64();
  if (!isUsersOwn()) GDALSetCacheMax64(static_cast<GIntBig>(bytes));
}

BlockCacheLimit::~BlockCacheLimit() {
  if (!isUsersOwn()) GDALSetCacheMax64(before_);
}

}  // namespace tellurion::raster
