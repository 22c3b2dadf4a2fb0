#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "io/resources.h"
#include "raster/tile_source.h"

namespace tellurion::pyramid {

/// Whether an address is that of a tile database on a server: http, https, s3 or file, its path ends in ".tdb".
bool isRemoteDatabase(std::string_view url);

/// The objects that exportObjects() wrote, wherever they lie (docs/remote-databases.md). Asks for the contents and
/// waits for them, so for a thread of its own. Tells what it stores without waiting; tiles come as they are prepared.
/// Fails on contents that cannot be had or are damaged; a tile that the server lacks though its contents list it is a
/// failure of that tile. Thread-safe.
io::Result<std::shared_ptr<const raster::TileSource>> openRemoteDatabase(
    const std::string& url, const std::shared_ptr<io::Resources>& resources);

}  // namespace tellurion::pyramid
