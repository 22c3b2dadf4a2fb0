#include "pyramid/tile_maker.h"

#include <algorithm>

#include "pyramid/tile_places.h"

namespace tellurion::pyramid {

bool TileTask::hasChildren() const {
  return std::ranges::any_of(children, [](const auto& child) { return child.has_value(); });
}

io::Result<std::optional<TileRecord>> TileMaker::make(const TileTask& task) {
  return plan_.meta.kind == raster::Kind::elevation ? makeElevation(task) : makeImagery(task);
}

}  // namespace tellurion::pyramid
