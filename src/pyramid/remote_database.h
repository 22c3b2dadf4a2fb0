#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "io/resources.h"
#include "raster/tile_source.h"

namespace tellurion::pyramid {

/// Whether an address is that of a tile database on a server: http, https, s3 or file, its path ends in ".tdb".
bool isRemoteDatabase(std::string_view url);

/// What the objects that exportObjects() wrote, wherever they lie (docs/remote-databases.md), say of themselves, as
/// their server gave it once. Immutable.
class RemoteContents {
 public:
  virtual ~RemoteContents() = default;
  /// Its name is the address.
  virtual const raster::TileSourceInfo& info() const = 0;
};

/// Asks for the contents and waits for them, so for a thread of its own. Fails on contents that cannot be had or are
/// damaged.
io::Result<std::shared_ptr<const RemoteContents>> askRemoteContents(const std::string& url, io::Resources& resources);

/// Asks for nothing by itself: tells what is stored without waiting; tiles come as they are prepared. A tile that the
/// server lacks though the contents list it is a failure of that tile. Thread-safe. contents: of askRemoteContents().
std::shared_ptr<const raster::TileSource> remoteDatabase(const std::shared_ptr<const RemoteContents>& contents,
                                                         const std::shared_ptr<io::Resources>& resources);

/// Both in one.
io::Result<std::shared_ptr<const raster::TileSource>> openRemoteDatabase(
    const std::string& url, const std::shared_ptr<io::Resources>& resources);

}  // namespace tellurion::pyramid
