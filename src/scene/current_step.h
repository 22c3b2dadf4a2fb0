#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>

#include "scene/layer_tiles.h"

namespace tellurion::scene {

/// The time step that a layer shows from now on: set by the globe, read by workers that make pictures. Thread-safe.
class CurrentStep {
 public:
  struct Now {
    std::shared_ptr<LayerTiles> tiles;  ///< null: the layer does not take part yet
    std::uint64_t edition = 0;          ///< another with each step
  };

  Now now() const {
    const std::lock_guard lock(mutex_);
    return now_;
  }
  void set(std::shared_ptr<LayerTiles> tiles) {
    const std::lock_guard lock(mutex_);
    now_ = {.tiles = std::move(tiles), .edition = now_.edition + 1};
  }

 private:
  mutable std::mutex mutex_;
  Now now_;
};

}  // namespace tellurion::scene
