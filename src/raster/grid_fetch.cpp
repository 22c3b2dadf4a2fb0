#include "raster/grid_fetch.h"

#include <chrono>
#include <condition_variable>
#include <unordered_set>
#include <utility>

namespace tellurion::raster {
namespace {

bool isMissing(const GridFetch::Arrival& arrival) {
  return arrival && *arrival == nullptr;
}

}  // namespace

/// Lives as long as its preparation; callbacks know it weakly.
struct GridFetch::Batch : std::enable_shared_from_this<GridFetch::Batch> {
  std::shared_ptr<GridFetch> fetch;
  std::function<void()> ready;

  std::mutex mutex;
  io::Executor::Task plan;  ///< set before anybody else knows of the batch
  std::vector<io::Resources::Ticket> tickets;
  std::vector<std::shared_ptr<const Arrival>> held;
  std::vector<std::shared_ptr<const void>> decoded;  ///< likewise
  std::unordered_set<GridImageId, GridImageIdHash> seen;
  std::size_t pending = 0;
  double priority = 0.0;
  bool closed = false;

  /// What is asked for first.
  void begin(const std::vector<GridImageId>& ids) {
    std::vector<GridImageId> missing;
    {
      const std::scoped_lock lock(mutex);
      if (closed) return;
      missing = open(ids);
      pending = missing.size();
      if (missing.empty()) return ready();
    }
    ask(missing);
  }

  /// Of some images and their stand-ins those that have to be asked for; what is at hand is held.
  std::vector<GridImageId> open(std::vector<GridImageId> ids) {
    std::vector<GridImageId> missing;
    while (!ids.empty()) {
      const GridImageId id = ids.back();
      ids.pop_back();
      if (!seen.insert(id).second) continue;
      bool isThere = true;
      if (auto found = fetch->decoded_(id)) {
        isThere = *found != nullptr;
        decoded.push_back(std::move(*found));
      } else if (auto arrival = fetch->arrived(id)) {
        isThere = !isMissing(*arrival);
        held.push_back(std::move(arrival));
      } else {
        missing.push_back(id);
      }
      if (isThere) continue;
      const auto under = fetch->geometry_->imagesUnder(id);
      ids.insert(ids.end(), under.begin(), under.end());
    }
    return missing;
  }

  /// Without the lock: Resources may call back at once, on its own thread.
  void ask(const std::vector<GridImageId>& ids) {
    for (const GridImageId& id : ids) {
      auto ticket =
          fetch->resources_->get(fetch->request_(id), priorityNow(), [weak = weak_from_this(), id](Arrival arrival) {
            if (const auto batch = weak.lock()) batch->take(id, std::move(arrival));
          });
      const std::scoped_lock lock(mutex);
      if (closed) return;
      tickets.push_back(std::move(ticket));
    }
  }
  double priorityNow() {
    const std::scoped_lock lock(mutex);
    return priority;
  }

  void take(const GridImageId& id, Arrival arrival) {
    const bool isGone = isMissing(arrival);
    auto shared = std::make_shared<const Arrival>(std::move(arrival));
    fetch->keep(id, shared);
    std::vector<GridImageId> standIns;
    bool done = false;
    {
      const std::scoped_lock lock(mutex);
      if (closed) return;
      held.push_back(std::move(shared));
      if (isGone) standIns = open(fetch->geometry_->imagesUnder(id));
      pending += standIns.size();
      done = --pending == 0;
    }
    ask(standIns);
    if (!done) return;
    // A ticket that is being handed over while its batch is closed is not waited for by who closes it.
    const std::scoped_lock lock(mutex);
    if (!closed) ready();
  }
};

class GridFetch::Held final : public Preparation {
 public:
  explicit Held(std::shared_ptr<Batch> batch) : batch_(std::move(batch)) {}
  ~Held() override {
    batch_->plan.cancel();
    std::vector<io::Resources::Ticket> tickets;
    {
      const std::scoped_lock lock(batch_->mutex);
      batch_->closed = true;
      tickets.swap(batch_->tickets);
    }
    // They wait for callbacks that run, so outside the lock.
    tickets.clear();
  }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;

  void setPriority(double priority) override {
    batch_->plan.setPriority(priority);
    const std::scoped_lock lock(batch_->mutex);
    batch_->priority = priority;
    for (const io::Resources::Ticket& ticket : batch_->tickets)
      ticket.setPriority(priority);
  }

 private:
  std::shared_ptr<Batch> batch_;
};

std::shared_ptr<GridFetch::Batch> GridFetch::batch(double priority, std::function<void()> ready) {
  auto batch = std::make_shared<Batch>();
  batch->fetch = shared_from_this();
  batch->ready = std::move(ready);
  batch->priority = priority;
  return batch;
}

GridFetch::GridFetch(std::shared_ptr<const GridGeometry> geometry, MakeRequest request,
                     std::shared_ptr<io::Resources> resources, Decoded decoded)
    : geometry_(std::move(geometry)),
      request_(std::move(request)),
      resources_(std::move(resources)),
      decoded_(std::move(decoded)) {}

std::unique_ptr<Preparation> GridFetch::fetch(const std::vector<GridImageId>& ids, double priority,
                                              std::function<void()> ready) {
  auto batch = this->batch(priority, std::move(ready));
  const std::vector<GridImageId> missing = batch->open(ids);
  if (missing.empty()) return nullptr;
  batch->pending = missing.size();
  auto held = std::make_unique<Held>(batch);
  batch->ask(missing);
  return held;
}

std::unique_ptr<Preparation> GridFetch::fetchPlanned(Plan plan, double priority, std::function<void()> ready) {
  auto batch = this->batch(priority, std::move(ready));
  auto held = std::make_unique<Held>(batch);
  batch->plan = resources_->plan(priority, [weak = batch->weak_from_this(), plan = std::move(plan)] {
    const auto ids = plan();
    if (const auto planned = weak.lock()) planned->begin(ids);
  });
  return held;
}

io::Result<std::unique_ptr<Preparation>> GridFetch::fetchAndWait(const std::vector<GridImageId>& ids) {
  struct Waiter {
    std::mutex mutex;
    std::condition_variable come;
    bool done = false;
  };
  const auto waiter = std::make_shared<Waiter>();
  // Whoever waits here wants it now.
  constexpr double kUrgent = 1e12;
  auto held = fetch(ids, kUrgent, [waiter] {
    const std::scoped_lock lock(waiter->mutex);
    waiter->done = true;
    waiter->come.notify_all();
  });
  if (!held) return held;
  std::unique_lock lock(waiter->mutex);
  const bool done =
      waiter->come.wait_for(lock, std::chrono::duration<double>(kPatience_s), [&] { return waiter->done; });
  lock.unlock();
  if (!done) return tl::unexpected(lateness());
  return held;
}

io::Failure GridFetch::lateness() const {
  const auto troubles = resources_->troubles();
  if (!troubles.empty()) return troubles.front();
  return {io::Failure::Code::ioError, "the server is too slow: nothing has come for a minute", {}};
}

std::shared_ptr<const GridFetch::Arrival> GridFetch::arrived(const GridImageId& id) const {
  const std::scoped_lock lock(mutex_);
  const auto found = arrivals_.find(id);
  return found == arrivals_.end() ? nullptr : found->second.lock();
}

void GridFetch::reject(const GridImageId& id) {
  {
    const std::scoped_lock lock(mutex_);
    arrivals_.erase(id);
  }
  resources_->forget(request_(id));
}

GridFetch::Arrival GridFetch::wait(const GridImageId& id, double patience_s) const {
  return resources_->wait(request_(id), patience_s);
}

void GridFetch::keep(const GridImageId& id, const std::shared_ptr<const Arrival>& arrival) {
  const std::scoped_lock lock(mutex_);
  arrivals_[id] = arrival;
  if (arrivals_.size() < sweepAt_) return;
  std::erase_if(arrivals_, [](const auto& entry) { return entry.second.expired(); });
  sweepAt_ = std::max<std::size_t>(256, 2 * arrivals_.size());
}

}  // namespace tellurion::raster
