#include "scene/source_fit.h"

#include <fmt/format.h>

#include <utility>

namespace tellurion::scene {

std::optional<io::Failure> misfit(const raster::TileSourceInfo& info, const tiling::Tiling& tiling,
                                  const geo::Body& body, raster::Kind kind, int cells) {
  const auto wrong = [&](std::string message) {
    return io::Failure{io::Failure::Code::invalidArgument, std::move(message), info.name};
  };
  if (info.kind != kind)
    return wrong(fmt::format("holds {}, but the scene uses it as {}", raster::nameOf(info.kind), raster::nameOf(kind)));
  if (info.scheme != tiling.scheme())
    return wrong(fmt::format("is tiled as {}, the scene as {}; build it again with --tiling {}",
                             tiling::nameOf(info.scheme), tiling::nameOf(tiling.scheme()),
                             tiling::nameOf(tiling.scheme())));
  if (!(info.body.ellipsoid == body.ellipsoid))
    return wrong(fmt::format("is of the body {}, the scene of {}", info.body.name, body.name));
  if (info.tileCells != cells)
    return wrong(fmt::format("has {} cells a side of a tile, the layer before it {}", info.tileCells, cells));
  return std::nullopt;
}

bool isMeshable(int cells) {
  return cells >= 4 && cells <= 128 && (cells & (cells - 1)) == 0;
}

}  // namespace tellurion::scene
