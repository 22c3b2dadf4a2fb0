#pragma once

#include <cstddef>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "io/failure.h"

namespace tellurion::raster {

/// Objects that one thread at a time may use, lent out: as many as are asked for at once, of which a few are kept.
/// Thread-safe.
template <class T>
class Pool {
 public:
  explicit Pool(std::size_t mostKept) : mostKept_(mostKept) {}

  /// Runs use(T&) -> io::Result<...> with an object of the pool, or one from make() -> io::Result<T>.
  template <class Make, class Use>
  auto with(const Make& make, const Use& use) -> decltype(use(std::declval<T&>())) {
    std::optional<T> object = take();
    if (!object) {
      io::Result<T> made = make();
      if (!made) return tl::unexpected(std::move(made.error()));
      object.emplace(std::move(*made));
    }
    auto result = use(*object);
    give(std::move(*object));
    return result;
  }

  void give(T object) {
    const std::scoped_lock lock(mutex_);
    if (idle_.size() < mostKept_) idle_.push_back(std::move(object));
  }

 private:
  std::optional<T> take() {
    const std::scoped_lock lock(mutex_);
    if (idle_.empty()) return std::nullopt;
    std::optional<T> object(std::move(idle_.back()));
    idle_.pop_back();
    return object;
  }

  std::size_t mostKept_;
  std::mutex mutex_;
  std::vector<T> idle_;
};

}  // namespace tellurion::raster
