#pragma once

#include "scene/tile_record.h"

namespace tellurion::scene {

/// Records that no update uses any more, the longest unused first: linked through themselves, so that one that is used
/// again leaves without a search, and nothing is allocated. One thread only.
class UnusedRecords {
 public:
  UnusedRecords() = default;
  UnusedRecords(const UnusedRecords&) = delete;
  UnusedRecords& operator=(const UnusedRecords&) = delete;

  /// Null: there is none.
  TileRecord* oldest() const { return oldest_; }

  void add(TileRecord& r) {
    r.isUnused = true;
    r.olderUnused = newest_;
    r.newerUnused = nullptr;
    (newest_ != nullptr ? newest_->newerUnused : oldest_) = &r;
    newest_ = &r;
  }
  /// Of a record that is among them.
  void remove(TileRecord& r) {
    (r.olderUnused != nullptr ? r.olderUnused->newerUnused : oldest_) = r.newerUnused;
    (r.newerUnused != nullptr ? r.newerUnused->olderUnused : newest_) = r.olderUnused;
    r.olderUnused = r.newerUnused = nullptr;
    r.isUnused = false;
  }

 private:
  TileRecord* oldest_ = nullptr;
  TileRecord* newest_ = nullptr;
};

}  // namespace tellurion::scene
