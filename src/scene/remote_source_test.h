#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include "raster/tile_source.h"
#include "scene/procedural_source_test.h"

namespace tellurion::scene {

/// A server that answers when the test says so: what is prepared waits in it. Thread-safe.
class FakeServer {
 public:
  struct Request {
    const void* source = nullptr;  ///< whose tile it is
    tiling::TileId id;
    double priority = 0.0;
    std::uint64_t arrival = 0;
    std::function<void()> ready;
    bool served = false;
    bool used = false;  ///< loaded from
    bool hasPlace = false;
  };
  enum class Order { mostUrgent, firstCome };
  struct Line {
    bool cancels = true;     ///< else what is let go of has its turn all the same, in the place where it stands
    bool remembers = false;  ///< what was brought once is at hand from then on, as from a cache on disk
    /// Connections: the most urgent who waits gets one that is free, and only who has one is answered; 0: no bound.
    std::size_t places = 0;
  };
  FakeServer() = default;
  explicit FakeServer(const Line& line) : line_(line) {}

  /// Null: at hand.
  std::shared_ptr<Request> ask(const void* source, const tiling::TileId& id, double priority,
                               std::function<void()> ready) {
    const std::lock_guard lock(mutex_);
    if (brought_.count({source, id}) != 0) return nullptr;
    const auto left = std::find_if(waiting_.begin(), waiting_.end(), [&](const auto& waiting) {
      return waiting->source == source && waiting->id == id && !waiting->ready;
    });
    if (left != waiting_.end()) {
      (*left)->ready = std::move(ready);
      return *left;
    }
    auto request = std::make_shared<Request>(Request{source, id, priority, arrivals_++, std::move(ready)});
    waiting_.push_back(request);
    ++asked_[id];
    givePlaces();
    return request;
  }
  void setPriority(Request& request, double priority) {
    const std::lock_guard lock(mutex_);
    request.priority = priority;
  }
  void drop(const std::shared_ptr<Request>& request) {
    const std::lock_guard lock(mutex_);
    if (!request->used) ++cancelled_;
    if (request->served) {
      std::erase(held_, request);
    } else if (line_.cancels) {
      std::erase(waiting_, request);
      givePlaces();
    } else {
      request->ready = nullptr;
    }
  }
  /// Whether it is at hand, or someone holds what was answered for it, which is used now.
  bool use(const void* source, const tiling::TileId& id) {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(held_.begin(), held_.end(),
                                    [&](const auto& held) { return held->source == source && held->id == id; });
    if (found == held_.end()) return brought_.count({source, id}) != 0;
    (*found)->used = true;
    return true;
  }

  /// Answers as many as these; returns how many.
  int serve(int count, Order order = Order::mostUrgent) {
    int served = 0;
    const std::lock_guard lock(mutex_);
    for (; served < count && !waiting_.empty(); ++served) {
      const auto next = std::min_element(waiting_.begin(), waiting_.end(), [&](const auto& a, const auto& b) {
        if (a->hasPlace != b->hasPlace) return a->hasPlace;
        if (order == Order::mostUrgent && a->priority != b->priority) return a->priority > b->priority;
        return a->arrival < b->arrival;
      });
      const std::shared_ptr<Request> request = *next;
      waiting_.erase(next);
      givePlaces();
      if (line_.remembers) brought_.insert({request->source, request->id});
      if (!request->ready) continue;
      request->served = true;
      answered_.insert(request->id);
      held_.push_back(request);
      request->ready();
    }
    return served;
  }
  std::size_t waiting() const {
    const std::lock_guard lock(mutex_);
    return waiting_.size();
  }
  /// Whose requests got a place, in that order.
  std::vector<const void*> begun() const {
    const std::lock_guard lock(mutex_);
    return begun_;
  }
  /// Answered, and not yet let go of by who asked.
  std::size_t holding() const {
    const std::lock_guard lock(mutex_);
    return held_.size();
  }
  /// Requests that were let go of before anybody loaded what they brought.
  int cancelled() const {
    const std::lock_guard lock(mutex_);
    return cancelled_;
  }
  /// Tiles that were answered for somebody.
  std::set<tiling::TileId> answered() const {
    const std::lock_guard lock(mutex_);
    return answered_;
  }
  /// How often each tile was asked for.
  std::map<tiling::TileId, int> asked() const {
    const std::lock_guard lock(mutex_);
    return asked_;
  }

 private:
  void givePlaces() {
    const auto isWaiting = [](const auto& request) { return !request->hasPlace; };
    const auto taken = [&] {
      return waiting_.size() - static_cast<std::size_t>(std::count_if(waiting_.begin(), waiting_.end(), isWaiting));
    };
    while (taken() < std::min(line_.places, waiting_.size())) {
      const auto next = std::max_element(waiting_.begin(), waiting_.end(), [&](const auto& a, const auto& b) {
        if (a->hasPlace != b->hasPlace) return a->hasPlace;
        return a->priority < b->priority;
      });
      (*next)->hasPlace = true;
      begun_.push_back((*next)->source);
    }
  }

  Line line_;
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<Request>> waiting_;
  std::map<tiling::TileId, int> asked_;
  std::set<tiling::TileId> answered_;
  std::set<std::pair<const void*, tiling::TileId>> brought_;  ///< where it remembers
  std::vector<std::shared_ptr<Request>> held_;
  std::vector<const void*> begun_;
  std::uint64_t arrivals_ = 0;
  int cancelled_ = 0;
};

/// A procedural planet behind a server. A load that was not prepared fails, as from a dead server: nobody may count on
/// it.
class RemoteSource final : public raster::TileSource {
 public:
  RemoteSource(std::shared_ptr<ProceduralSource> planet, std::shared_ptr<FakeServer> server)
      : planet_(std::move(planet)), server_(std::move(server)) {}

  const raster::TileSourceInfo& info() const override { return planet_->info(); }
  std::optional<raster::TilePresence> presence(const tiling::TileId& id) const override {
    const int deepest = info().maxLevel;
    if (id.level > deepest || !planet_->stored(id)) return raster::TilePresence{};
    raster::TilePresence told{.stored = true};
    for (int q = 0; q < 4; ++q) {
      if (id.level < deepest && planet_->stored(id.child(q)))
        told.childMask = static_cast<std::uint8_t>(told.childMask | (1 << q));
    }
    return told;
  }
  std::unique_ptr<raster::Preparation> prepare(const tiling::TileId& id, double priority,
                                               std::function<void()> ready) const override {
    auto request = server_->ask(this, id, priority, std::move(ready));
    return request ? std::make_unique<Waiting>(server_, std::move(request)) : nullptr;
  }
  io::Result<std::optional<raster::SourceTile>> load(const tiling::TileId& id) const override {
    if (server_->use(this, id)) return planet_->load(id);
    ++unprepared_;
    return io::fail(io::Failure::Code::ioError, "was not prepared", info().name);
  }
  std::shared_ptr<const raster::TileSource> overview() const override { return overviewSource; }
  int unpreparedLoads() const { return unprepared_; }

  std::shared_ptr<const raster::TileSource> overviewSource;  ///< what overview() gives

 private:
  class Waiting final : public raster::Preparation {
   public:
    Waiting(std::shared_ptr<FakeServer> server, std::shared_ptr<FakeServer::Request> request)
        : server_(std::move(server)), request_(std::move(request)) {}
    ~Waiting() override { server_->drop(request_); }
    void setPriority(double priority) override { server_->setPriority(*request_, priority); }

   private:
    std::shared_ptr<FakeServer> server_;
    std::shared_ptr<FakeServer::Request> request_;
  };

  std::shared_ptr<ProceduralSource> planet_;
  std::shared_ptr<FakeServer> server_;
  mutable std::atomic<int> unprepared_ = 0;
};

}  // namespace tellurion::scene
