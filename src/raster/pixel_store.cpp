#include "raster/pixel_store.h"

namespace tellurion::raster {

int levelFor(const std::vector<GridTopology>& levels, const PixelBox& box) {
  const GridTopology& full = levels.front();
  int best = 0;
  for (std::size_t i = 1; i < levels.size(); ++i) {
    const double columns = (box.right - box.left) * levels[i].width / full.width;
    const double rows = (box.bottom - box.top) * levels[i].height / full.height;
    if (columns < 2.0 || rows < 2.0) continue;
    if (levels[i].width < levels[static_cast<std::size_t>(best)].width) best = static_cast<int>(i);
  }
  return best;
}

}  // namespace tellurion::raster
