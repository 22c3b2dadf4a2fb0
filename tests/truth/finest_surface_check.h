#pragma once

#include <memory>

#include "truth/finest_surface.h"
#include "truth/random_cameras.h"

namespace tellurion::truth {

/// Expects that the finest ground over a place is the one that height queries of the database tell (the two differ only
/// beside tiles that are not stored), and that its rays end on it and nowhere before, along those of `cameras`.
void expectSound(const FinestSurface& ground, const std::shared_ptr<const raster::TileSource>& database,
                 RandomCameras cameras);

}  // namespace tellurion::truth
