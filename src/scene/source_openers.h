#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/executor.h"
#include "scene/doorbell.h"
#include "scene/globe_layers.h"

namespace tellurion::scene {

/// Opens the sources of layers and of their time steps on threads of its own, which do little but wait: two of a server
/// at a time, so that a server that hangs keeps no other's sources shut, as long as fewer than 16 hang. One
/// thread only; its destruction waits for what has begun.
class SourceOpeners {
 public:
  /// On its way, or here.
  class Opening {
   public:
    /// Once: nothing until it has come.
    std::optional<io::Result<LayerSource::Pointer>> take();

   private:
    friend class SourceOpeners;
    std::string server_;  ///< empty: it waits for no server
    std::atomic<bool> done_{false};
    io::Result<LayerSource::Pointer> source_;
  };

  /// most: of sources that may be on their way at a time where no server holds them up: one a layer. The bell is rung
  /// when one has come; it must outlive them.
  SourceOpeners(std::size_t most, Doorbell& bell);

  /// The source is not open, does not wait for others (LayerSource::waitsFor), and its server has a place free.
  bool mayOpen(const LayerSource& source) const;
  /// Who lets go of it leaves its server's place taken until it has come. Only while mayOpen().
  std::shared_ptr<Opening> open(const LayerSource& source);

 private:
  Doorbell& bell_;
  std::vector<std::shared_ptr<Opening>> underway_;
  io::Executor executor_;  ///< last: its threads use what stands above
};

}  // namespace tellurion::scene
