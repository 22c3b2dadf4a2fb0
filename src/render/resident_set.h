#pragma once

#include <cstdint>
#include <list>
#include <optional>
#include <unordered_map>

namespace tellurion::render {

/// What has a copy in GPU memory, by serial number, in the order of last use. touch() touches no heap. Place says where
/// the copy is; the set does not know what that means.
template <class Place>
class ResidentSet {
 public:
  /// The place of a resident, now used in `frame`; null when it has none. Stable until evicted.
  const Place* touch(std::uint64_t serial, std::uint64_t frame) {
    const auto found = bySerial_.find(serial);
    if (found == bySerial_.end()) return nullptr;
    found->second->lastFrame = frame;
    byUse_.splice(byUse_.end(), byUse_, found->second);
    return &found->second->place;
  }

  bool holds(std::uint64_t serial) const { return bySerial_.contains(serial); }

  const Place* insert(std::uint64_t serial, std::uint64_t frame, Place place) {
    byUse_.push_back({serial, frame, place});
    bySerial_.emplace(serial, std::prev(byUse_.end()));
    return &byUse_.back().place;
  }

  /// Forgets the one used longest ago and gives its place, which is free then; nothing when all are of `frame`.
  std::optional<Place> evictOldest(std::uint64_t frame) {
    if (byUse_.empty() || byUse_.front().lastFrame >= frame) return std::nullopt;
    const Place place = byUse_.front().place;
    bySerial_.erase(byUse_.front().serial);
    byUse_.pop_front();
    ++evictions_;
    return place;
  }
  std::uint64_t evictions() const { return evictions_; }  ///< so far

  std::size_t size() const { return bySerial_.size(); }

 private:
  struct Entry {
    std::uint64_t serial = 0;
    std::uint64_t lastFrame = 0;
    Place place;
  };
  std::list<Entry> byUse_;  // front: longest ago
  std::unordered_map<std::uint64_t, typename std::list<Entry>::iterator> bySerial_;
  std::uint64_t evictions_ = 0;
};

}  // namespace tellurion::render
