#pragma once

#include <cstddef>
#include <list>
#include <mutex>
#include <utility>

#include "raster/raster_file.h"

namespace tellurion::raster {

/// Raster files by number, opened when they are needed and lent to one thread at a time; of those that come back the
/// latest used stay open. Thread-safe.
class OpenFiles {
 public:
  explicit OpenFiles(std::size_t most) : most_(most) {}

  /// Runs use(RasterFile&) -> io::Result<void> with file `number`; open() -> io::Result<RasterFile> where none is idle.
  template <class Open, class Use>
  io::Result<void> with(int number, const Open& open, const Use& use) {
    std::list<Slot> mine = take(number);
    if (mine.empty()) {
      auto opened = open();
      if (!opened) return tl::unexpected(std::move(opened.error()));
      mine.push_back({number, std::move(*opened)});
    }
    auto done = use(mine.front().file);
    give(mine);
    return done;
  }

 private:
  struct Slot {
    int number;
    RasterFile file;
  };

  std::list<Slot> take(int number) {
    std::list<Slot> taken;
    const std::scoped_lock lock(mutex_);
    for (auto at = idle_.begin(); at != idle_.end(); ++at) {
      if (at->number != number) continue;
      taken.splice(taken.begin(), idle_, at);
      break;
    }
    return taken;
  }

  void give(std::list<Slot>& mine) {
    std::list<Slot> closing;  // Closing takes time, so outside the lock.
    const std::scoped_lock lock(mutex_);
    idle_.splice(idle_.begin(), mine);
    if (idle_.size() > most_) closing.splice(closing.begin(), idle_, std::prev(idle_.end()));
  }

  std::size_t most_;
  std::mutex mutex_;
  std::list<Slot> idle_;  ///< the latest used is in front
};

}  // namespace tellurion::raster
