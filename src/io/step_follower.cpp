#include "io/step_follower.h"

#include <fmt/format.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "io/socket.h"
#include "io/step_wire.h"

namespace tellurion::io {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kConnect{2};    // to an address of the leader's
constexpr std::chrono::seconds kHandshake{3};  // until it is welcome
constexpr std::chrono::seconds kSilence{2};
constexpr std::chrono::milliseconds kHeartbeat{500};
constexpr std::chrono::milliseconds kFirstRetry{50};
constexpr std::chrono::milliseconds kLastRetry{1000};
constexpr std::size_t kMostNews = 100;

/// What the network's thread holds of a connection.
struct Link {
  Socket socket;
  StepHello hello;
  StepOpener opener{kLongestLeaderMessage};
  bool isGreeted = false;
  bool isWelcome = false;
  Clock::time_point came = Clock::now();
  Clock::time_point heard = came;
  Clock::time_point beaten = came;
};

}  // namespace

struct StepFollower::State {
  StepFollowerOptions options;
  SocketWaker waker;

  mutable std::mutex mutex;
  std::condition_variable released;
  Status status = Status::searching;
  bool hasFollowed = false;  ///< nothing refuses it for good any more
  StepSealer sealer;         ///< of the connection
  std::string unsent;
  std::uint64_t connection = 0;  ///< that greeted, counted
  std::optional<Step> step;
  std::uint64_t releasedFrame = 0;
  std::vector<std::string> tidings;
  std::string lastProblem;
  std::jthread thread;  // last: ends before what it uses

  void run(const std::stop_token& stop);
  Result<Link> connect(const std::stop_token& stop);
  Result<void> converse(Link& link, const std::stop_token& stop);
  Result<void> hear(Link& link);
  Result<void> take(Link& link, const StepMessage& message);
  Result<void> greet(Link& link, const StepMessage& message);
  Result<void> welcome(Link& link, const StepMessage& message);
  void setStatus(Status now, const std::string& why);
  void rest(std::chrono::milliseconds time, const std::stop_token& stop) const;
  void send(StepKind kind, std::string_view body);
};

void StepFollower::State::setStatus(Status now, const std::string& why) {
  {
    const std::scoped_lock lock(mutex);
    if (status == now && lastProblem == why) return;
    status = now;
    lastProblem = why;
    if (tidings.size() < kMostNews) tidings.push_back(why);
    released.notify_all();
  }
  if (options.wake) options.wake();
}

/// Where the mutex is held.
void StepFollower::State::send(StepKind kind, std::string_view body) {
  unsent += sealer.seal(kind, body);
}

void StepFollower::State::rest(std::chrono::milliseconds time, const std::stop_token& stop) const {
  const auto end = Clock::now() + time;
  for (auto now = Clock::now(); now < end && !stop.stop_requested(); now = Clock::now())
    waitForSockets({}, waker, std::chrono::ceil<std::chrono::milliseconds>(end - now));
}

Result<Link> StepFollower::State::connect(const std::stop_token& stop) {
  std::string problem = "has no address";
  for (std::size_t which = 0; !stop.stop_requested(); ++which) {
    auto socket = Socket::connectTo(options.leader, which);
    if (!socket) problem = socket.error().message;
    if (!socket && socket.error().code == Failure::Code::notFound) break;
    if (!socket) continue;
    if (!*socket) break;
    SocketWait wait{.socket = &**socket, .toWrite = true};
    const auto end = Clock::now() + kConnect;
    for (auto now = Clock::now(); now < end && !wait.canWrite && !wait.canRead && !stop.stop_requested();
         now = Clock::now())
      waitForSockets({&wait, 1}, waker, std::chrono::ceil<std::chrono::milliseconds>(end - now));
    problem = wait.canWrite || wait.canRead ? (*socket)->connectionProblem() : "does not answer";
    if (!problem.empty()) continue;
    Link link;
    link.socket = std::move(**socket);
    return link;
  }
  return fail(Failure::Code::ioError, problem);
}

Result<void> StepFollower::State::greet(Link& link, const StepMessage& message) {
  const auto refuse = [](std::string why) { return fail(Failure::Code::invalidArgument, std::move(why)); };
  const auto hello = message.kind == StepKind::hello ? decodeHello(message.body) : std::nullopt;
  if (!hello) return refuse("what listens there is no leader of Tellurion");
  if (hello->version != kStepVersion) return refuse(describe(StepRefusal::version));
  if (hello->hasSecret && options.secret.empty()) return refuse(describe(StepRefusal::needsSecret));
  if (!hello->hasSecret && !options.secret.empty())
    return refuse("the leader has no secret, but this follower was given one: give it to the leader too");
  const auto nonce = unguessableBytes();
  if (!nonce) return tl::unexpected(nonce.error());
  link.hello = {.hasSecret = hello->hasSecret, .nonce = *nonce};
  link.isGreeted = true;
  const std::scoped_lock lock(mutex);
  send(StepKind::hello, encode(link.hello));
  if (hello->hasSecret) {
    const StepKeys keys = stepKeys(options.secret, *hello, link.hello);
    sealer.setKey(keys.follower);
    link.opener.setKey(keys.leader);
  }
  send(StepKind::join, {});
  return {};
}

Result<void> StepFollower::State::welcome(Link& link, const StepMessage& message) {
  if (options.check) {
    if (const auto fine = options.check(message.body); !fine)
      return fail(Failure::Code::invalidArgument, fine.error().message, fine.error().where);
  }
  link.isWelcome = true;
  {
    const std::scoped_lock lock(mutex);
    hasFollowed = true;
    ++connection;
    releasedFrame = 0;
    step.reset();
  }
  setStatus(Status::following, "following " + formatNetAddress(options.leader));
  return {};
}

Result<void> StepFollower::State::take(Link& link, const StepMessage& message) {
  if (message.kind == StepKind::refused && message.body.size() == 1)
    return fail(Failure::Code::invalidArgument, describe(static_cast<StepRefusal>(message.body.front())));
  if (!link.isGreeted) return greet(link, message);
  if (!link.isWelcome && message.kind == StepKind::welcome) return welcome(link, message);
  const auto number = decodeNumber(message.body);
  const std::scoped_lock lock(mutex);
  if (link.isWelcome && message.kind == StepKind::frame && number) {
    step = Step{.frame = number->number, .state = std::string(number->rest), .connection = connection};
  } else if (link.isWelcome && message.kind == StepKind::release && number && number->rest.empty()) {
    releasedFrame = std::max(releasedFrame, number->number);
    released.notify_all();
  } else if (!link.isWelcome || message.kind != StepKind::alive) {
    return fail(Failure::Code::corrupt, "it says what no leader says");
  }
  return {};
}

Result<void> StepFollower::State::hear(Link& link) {
  const auto bytes = link.socket.receive();
  if (!bytes) return tl::unexpected(bytes.error());
  link.heard = Clock::now();
  link.opener.add(*bytes);
  for (;;) {
    const auto message = link.opener.next();
    if (!message) return tl::unexpected(message.error());
    if (!*message) break;
    if (auto taken = take(link, **message); !taken) return taken;
  }
  const bool isNew = [&] {
    const std::scoped_lock lock(mutex);
    return step.has_value();
  }();
  if (isNew && options.wake) options.wake();
  return {};
}

Result<void> StepFollower::State::converse(Link& link, const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    SocketWait wait{.socket = &link.socket};
    {
      const std::scoped_lock lock(mutex);
      const auto now = Clock::now();
      if (link.isWelcome && now - link.beaten >= kHeartbeat) {
        send(StepKind::alive, {});
        link.beaten = now;
      }
      const auto sent = link.socket.send(unsent);
      if (!sent) return tl::unexpected(sent.error());
      unsent.erase(0, *sent);
      wait.toWrite = !unsent.empty();
    }
    waitForSockets({&wait, 1}, waker, kHeartbeat);
    if (wait.canRead) {
      if (auto heard = hear(link); !heard) return heard;
    }
    if (!link.isWelcome && Clock::now() - link.came > kHandshake)
      return fail(Failure::Code::ioError, "what listens there does not greet");
    if (link.isWelcome && Clock::now() - link.heard > kSilence) return fail(Failure::Code::ioError, "it is silent");
  }
  return {};
}

void StepFollower::State::run(const std::stop_token& stop) {
  auto retry = kFirstRetry;
  const std::string leader = formatNetAddress(options.leader);
  while (!stop.stop_requested()) {
    auto link = connect(stop);
    {
      const std::scoped_lock lock(mutex);
      sealer = {};
      unsent.clear();
    }
    const auto ended = link ? converse(*link, stop) : tl::unexpected(link.error());
    if (stop.stop_requested()) return;
    const bool wasFollowing = link && link->isWelcome;
    const io::Failure failure = ended ? io::Failure{} : ended.error();
    bool isLost = false;
    {
      const std::scoped_lock lock(mutex);
      isLost = hasFollowed;
    }
    if (!isLost && failure.code == Failure::Code::invalidArgument)
      return setStatus(Status::refused, fmt::format("{}: {}", leader, io::describe(failure)));
    if (isLost)
      setStatus(Status::lost, fmt::format("{}: the leader is lost: {}; the last picture stays, and it is looked for",
                                          leader, io::describe(failure)));
    else
      setStatus(Status::searching,
                fmt::format("{}: no leader yet: {}; it is looked for", leader, io::describe(failure)));
    if (wasFollowing) retry = kFirstRetry;
    rest(retry, stop);
    retry = std::min(2 * retry, kLastRetry);
  }
}

StepFollower::StepFollower(std::unique_ptr<State> state) : state_(std::move(state)) {}

StepFollower::~StepFollower() {
  state_->thread.request_stop();
  state_->waker.wake();
}

Result<std::unique_ptr<StepFollower>> StepFollower::follow(StepFollowerOptions options) {
  auto waker = SocketWaker::create();
  if (!waker) return tl::unexpected(waker.error());
  auto state = std::make_unique<State>();
  state->options = std::move(options);
  state->waker = std::move(*waker);
  state->thread = std::jthread([all = state.get()](const std::stop_token& stop) { all->run(stop); });
  return std::unique_ptr<StepFollower>(new StepFollower(std::move(state)));
}

std::optional<StepFollower::Step> StepFollower::newest() {
  const std::scoped_lock lock(state_->mutex);
  return std::exchange(state_->step, std::nullopt);
}

void StepFollower::ready(const Step& step, bool changes) {
  {
    const std::scoped_lock lock(state_->mutex);
    if (state_->status != Status::following || step.connection != state_->connection) return;
    const char change = changes ? 1 : 0;
    state_->send(StepKind::ready, encodeNumber(step.frame, {&change, 1}));
  }
  state_->waker.wake();
}

StepFollower::Release StepFollower::awaitRelease(const Step& step, std::chrono::milliseconds atMost) {
  const State& all = *state_;
  const auto isGone = [&] { return all.status != Status::following || step.connection != all.connection; };
  std::unique_lock lock(all.mutex);
  state_->released.wait_for(lock, atMost, [&] { return isGone() || all.releasedFrame >= step.frame; });
  if (isGone()) return Release::gone;
  return all.releasedFrame >= step.frame ? Release::shown : Release::notYet;
}

void StepFollower::askForFrame() {
  {
    const std::scoped_lock lock(state_->mutex);
    if (state_->status != Status::following) return;
    state_->send(StepKind::again, {});
  }
  state_->waker.wake();
}

StepFollower::Status StepFollower::status() const {
  const std::scoped_lock lock(state_->mutex);
  return state_->status;
}

std::vector<std::string> StepFollower::news() {
  const std::scoped_lock lock(state_->mutex);
  return std::exchange(state_->tidings, {});
}

}  // namespace tellurion::io
