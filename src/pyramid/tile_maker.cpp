#include "pyramid/tile_maker.h"

#include <algorithm>

#include "raster/tile_places.h"

namespace tellurion::pyramid {

std::size_t cacheBytesPerFile(int jobs, std::size_t inputs) {
  constexpr std::size_t kTotal = std::size_t{512} << 20u;
  constexpr std::size_t kLeast = std::size_t{1} << 20u;
  constexpr std::size_t kMost = std::size_t{64} << 20u;
  const std::size_t files =
      std::clamp<std::size_t>(inputs, 1, kMostOpenFiles) * static_cast<std::size_t>(std::max(jobs, 1));
  return std::clamp(kTotal / files, kLeast, kMost);
}

bool TileTask::hasChildren() const {
  return std::ranges::any_of(children, [](const auto& child) { return child.has_value(); });
}

io::Result<std::optional<TileRecord>> TileMaker::make(const TileTask& task) {
  return plan_.meta.kind == raster::Kind::elevation ? makeElevation(task) : makeImagery(task);
}

}  // namespace tellurion::pyramid
