#include "io/resources.h"

#include <chrono>
#include <condition_variable>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>

#include "io/resource_desk.h"

namespace tellurion::io {

struct Resources::State {
  explicit State(const ResourceOptions& options) : desk(std::make_shared<ResourceDesk>(options)) {}
  std::shared_ptr<ResourceDesk> desk;
  std::mutex waitMutex;
  std::condition_variable waitEnds;
  bool waitsAreCancelled = false;
};

// Both outlive the Resources: a ticket may be let go of later.
struct Resources::Ticket::State {
  std::shared_ptr<ResourceDesk> desk;
  std::shared_ptr<ResourceWaiter> waiter;
  ~State() { desk->leave(waiter); }
};

Resources::Resources(const ResourceOptions& options) : state_(std::make_unique<State>(options)) {}
Resources::~Resources() {
  state_->desk->close();
}

Resources::Ticket::Ticket() = default;
Resources::Ticket::Ticket(Ticket&&) noexcept = default;
Resources::Ticket& Resources::Ticket::operator=(Ticket&&) noexcept = default;
Resources::Ticket::~Ticket() = default;

void Resources::Ticket::setPriority(double priority) const {
  if (state_) state_->desk->setPriority(state_->waiter, priority);
}

Resources::Ticket Resources::get(const ResourceRequest& request, double priority, Ready ready) {
  Ticket ticket;
  auto waiter = state_->desk->get(request, priority, std::move(ready));
  ticket.state_.reset(new Ticket::State{state_->desk, std::move(waiter)});
  return ticket;
}

Executor::Task Resources::plan(double priority, std::function<void()> work) {
  return state_->desk->plan(priority, std::move(work));
}

void Resources::forget(const ResourceRequest& request) {
  state_->desk->forget(request);
}

Result<std::shared_ptr<const Resource>> Resources::wait(const ResourceRequest& request, double timeout_s) {
  std::optional<Result<std::shared_ptr<const Resource>>> result;
  // Its destruction waits for a callback that runs, so what that touches lives long enough.
  const Ticket ticket = get(request, std::numeric_limits<double>::max(), [&](auto answer) {
    const std::scoped_lock lock(state_->waitMutex);
    result = std::move(answer);
    state_->waitEnds.notify_all();
  });
  std::unique_lock lock(state_->waitMutex);
  const bool ended = state_->waitEnds.wait_for(lock, std::chrono::duration<double>(timeout_s),
                                               [&] { return result.has_value() || state_->waitsAreCancelled; });
  if (result) return *std::move(result);
  lock.unlock();
  if (ended) return fail(Failure::Code::cancelled, "is not waited for any more", request.url);
  return tl::unexpected(state_->desk->timedOut(request, timeout_s));
}

void Resources::cancelWaits() {
  const std::scoped_lock lock(state_->waitMutex);
  state_->waitsAreCancelled = true;
  state_->waitEnds.notify_all();
}

ResourceStatistics Resources::statistics() const {
  return state_->desk->statistics();
}

std::vector<Failure> Resources::troubles() const {
  return state_->desk->troubles();
}

}  // namespace tellurion::io
