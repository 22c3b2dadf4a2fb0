#include "io/step_leader.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <list>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "io/socket.h"
#include "io/step_wire.h"

namespace tellurion::io {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kHandshake{3};  // from the first byte to joining
constexpr std::chrono::milliseconds kHeartbeat{500};
constexpr std::chrono::seconds kSilence{5};  // after which a follower is gone
constexpr std::size_t kMostUnsent_bytes = 1 << 20;
constexpr std::size_t kMostNews = 100;

struct Peer {
  Socket socket;
  std::string name;
  StepSealer sealer;
  StepOpener opener{kLongestFollowerMessage};
  StepHello hello;         ///< what it was sent
  bool isGreeted = false;  ///< its hello has come
  bool isMember = false;
  bool isLast = false;  ///< ends once what is to be sent has been
  std::string unsent;
  std::string leaving;  ///< why; not empty: to be taken out
  Clock::time_point came = Clock::now();
  Clock::time_point heard = came;
  std::uint64_t given = 0;  ///< the frame that it has not answered for; 0: none
  Clock::time_point givenAt;
  bool isSwift = false;  ///< its last answer came within the patience
  bool isLate = false;   ///< and that has been told
};

}  // namespace

struct StepLeader::State {
  StepLeaderOptions options;
  Socket listener;
  SocketWaker waker;

  mutable std::mutex mutex;
  std::condition_variable answered;
  std::list<Peer> peers;
  std::uint64_t frame = 0;     ///< the newest
  std::uint64_t released = 0;  ///< so far
  std::string newest;          ///< its message
  Clock::time_point published;
  Clock::duration ownTime{};  ///< that the leader took for its own picture
  bool wantsFrame = false;
  std::vector<std::string> news;
  std::jthread thread;  // last: ends before what it uses

  void run(const std::stop_token& stop);
  void tell(std::string what);
  void letIn();
  void hear(Peer& peer);
  void take(Peer& peer, const StepMessage& message);
  void greet(Peer& peer, const StepMessage& message);
  void refuse(Peer& peer, StepRefusal why);
  void takeReady(Peer& peer, const StepMessage& message);
  void give(Peer& peer);
  void send(Peer& peer, const std::string& bytes);
  void flush(Peer& peer) const;
  void mind(Peer& peer, bool isHeartbeat);
  bool isAwaited(const Peer& peer) const { return peer.leaving.empty() && peer.given == frame && peer.isSwift; }
};

void StepLeader::State::tell(std::string what) {
  if (news.size() < kMostNews) news.push_back(std::move(what));
}

void StepLeader::State::flush(Peer& peer) const {
  while (!peer.unsent.empty() && peer.leaving.empty()) {
    const auto sent = peer.socket.send(peer.unsent);
    if (!sent) peer.leaving = sent.error().message;
    if (!sent || *sent == 0) break;
    peer.unsent.erase(0, *sent);
  }
  if (peer.unsent.size() > kMostUnsent_bytes) peer.leaving = "it takes nothing any more";
  if (peer.isLast && peer.unsent.empty() && peer.leaving.empty()) peer.leaving = "refused";
}

void StepLeader::State::send(Peer& peer, const std::string& bytes) {
  peer.unsent += bytes;
  flush(peer);
}

void StepLeader::State::letIn() {
  while (auto socket = listener.accept()) {
    Peer& peer = peers.emplace_back();
    peer.socket = std::move(*socket);
    peer.name = peer.socket.otherSide();
    const auto nonce = unguessableBytes();
    if (!nonce || peers.size() > 2 * options.mostFollowers) {  // so many may be on their way in
      peers.pop_back();
      continue;
    }
    peer.hello = {.hasSecret = !options.secret.empty(), .nonce = *nonce};
    send(peer, peer.sealer.seal(StepKind::hello, encode(peer.hello)));
  }
}

void StepLeader::State::refuse(Peer& peer, StepRefusal why) {
  constexpr std::string_view kReasons[] = {"", "another version of the protocol", "another secret", "no secret",
                                           "there are as many followers as may be"};
  tell(fmt::format("{} is refused: {}", peer.name, kReasons[static_cast<std::size_t>(why)]));
  peer.isLast = true;
  const char code = static_cast<char>(why);
  send(peer, peer.sealer.seal(StepKind::refused, {&code, 1}));
}

void StepLeader::State::greet(Peer& peer, const StepMessage& message) {
  const auto hello = message.kind == StepKind::hello ? decodeHello(message.body) : std::nullopt;
  if (!hello) {
    peer.leaving = "is no follower";
    return;
  }
  peer.isGreeted = true;
  if (hello->version != kStepVersion) return refuse(peer, StepRefusal::version);
  if (hello->hasSecret != peer.hello.hasSecret)
    return refuse(peer, hello->hasSecret ? StepRefusal::wrongSecret : StepRefusal::needsSecret);
  if (options.secret.empty()) return;
  const StepKeys keys = stepKeys(options.secret, peer.hello, *hello);
  peer.sealer.setKey(keys.leader);
  peer.opener.setKey(keys.follower);
}

void StepLeader::State::give(Peer& peer) {
  peer.given = frame;
  peer.givenAt = Clock::now();
  send(peer, peer.sealer.seal(StepKind::frame, newest));
  if (frame <= released) send(peer, peer.sealer.seal(StepKind::release, encodeNumber(frame)));
}

void StepLeader::State::takeReady(Peer& peer, const StepMessage& message) {
  const auto ready = decodeNumber(message.body);
  if (!ready || ready->number != peer.given || peer.given == 0 || ready->rest.size() != 1) {
    peer.leaving = "answered for a frame that it was not given";
    return;
  }
  peer.given = 0;
  const bool wasSwift = peer.isSwift;
  peer.isSwift = wasSwift || Clock::now() - peer.givenAt <= options.patience + ownTime;
  if (peer.isSwift && !wasSwift) tell(fmt::format("{} is in step", peer.name));
  if (peer.isSwift) peer.isLate = false;
  if (ready->rest.front() != 0) wantsFrame = true;
  if (ready->number < frame) give(peer);
  answered.notify_all();
}

void StepLeader::State::take(Peer& peer, const StepMessage& message) {
  if (peer.isLast) return;
  if (!peer.isGreeted) return greet(peer, message);
  if (!peer.isMember) {
    if (message.kind != StepKind::join || !message.body.empty()) {
      peer.leaving = "did not join";
      return;
    }
    if (std::ranges::count_if(peers, &Peer::isMember) >= static_cast<std::ptrdiff_t>(options.mostFollowers))
      return refuse(peer, StepRefusal::tooMany);
    peer.isMember = true;
    tell(fmt::format("{} follows", peer.name));
    send(peer, peer.sealer.seal(StepKind::welcome, options.greeting));
    if (frame > 0) give(peer);
    wantsFrame = true;
    return;
  }
  switch (message.kind) {
    case StepKind::ready:
      return takeReady(peer, message);
    case StepKind::again:
      wantsFrame = true;
      return;
    case StepKind::alive:
      return;
    case StepKind::hello:
    case StepKind::join:
    case StepKind::welcome:
    case StepKind::frame:
    case StepKind::release:
    case StepKind::refused:
      peer.leaving = "says what no follower says";
  }
}

void StepLeader::State::hear(Peer& peer) {
  const auto bytes = peer.socket.receive();
  if (!bytes) {
    peer.leaving = bytes.error().message;
    return;
  }
  peer.heard = Clock::now();
  peer.opener.add(*bytes);
  while (peer.leaving.empty()) {
    const auto message = peer.opener.next();
    if (!message && peer.isGreeted && !peer.isMember && !peer.isLast) return refuse(peer, StepRefusal::wrongSecret);
    if (!message) peer.leaving = message.error().message;
    if (!message || !*message) break;
    take(peer, **message);
  }
}

void StepLeader::State::mind(Peer& peer, bool isHeartbeat) {
  const auto now = Clock::now();
  if (!peer.isMember && now - peer.came > kHandshake) peer.leaving = "took too long to join";
  if (peer.isMember && now - peer.heard > kSilence) peer.leaving = "is silent";
  if (isHeartbeat && peer.isMember) send(peer, peer.sealer.seal(StepKind::alive));
}

void StepLeader::State::run(const std::stop_token& stop) {
  auto lastHeartbeat = Clock::now();
  std::vector<SocketWait> waits;
  while (!stop.stop_requested()) {
    waits.assign({{.socket = &listener}});
    {
      const std::scoped_lock lock(mutex);
      for (const Peer& peer : peers)
        waits.push_back({.socket = &peer.socket, .toWrite = !peer.unsent.empty()});
    }
    waitForSockets(waits, waker, kHeartbeat);
    bool hasNews = false;
    {
      const std::scoped_lock lock(mutex);
      const bool wanted = wantsFrame;
      const bool isHeartbeat = Clock::now() - lastHeartbeat >= kHeartbeat;
      if (isHeartbeat) lastHeartbeat = Clock::now();
      auto wait = waits.begin() + 1;
      for (Peer& peer : peers) {
        if (peer.leaving.empty() && wait->canRead) hear(peer);
        flush(peer);
        mind(peer, isHeartbeat);
        ++wait;
      }
      for (const Peer& peer : peers) {
        if (!peer.leaving.empty() && peer.isMember) tell(fmt::format("{} has left: {}", peer.name, peer.leaving));
      }
      if (std::erase_if(peers, [](const Peer& peer) { return !peer.leaving.empty(); }) > 0) answered.notify_all();
      if (waits.front().canRead) letIn();
      hasNews = (wantsFrame && !wanted) || !news.empty();
    }
    if (hasNews && options.wake) options.wake();
  }
}

StepLeader::StepLeader(std::unique_ptr<State> state) : state_(std::move(state)) {}

StepLeader::~StepLeader() {
  state_->thread.request_stop();
  state_->waker.wake();
}

Result<std::unique_ptr<StepLeader>> StepLeader::listen(StepLeaderOptions options) {
  auto listener = Socket::listenOn(options.address);
  if (!listener) return tl::unexpected(listener.error());
  if (options.secret.empty() && !listener->isLoopback())
    return fail(Failure::Code::invalidArgument,
                "other machines can reach this address, so a secret has to guard it: give the leader and all followers "
                "the same with --secret-file, or in TELLURION_STEP_SECRET",
                formatNetAddress(options.address));
  auto waker = SocketWaker::create();
  if (!waker) return tl::unexpected(waker.error());
  auto state = std::make_unique<State>();
  state->options = std::move(options);
  state->listener = std::move(*listener);
  state->waker = std::move(*waker);
  state->thread = std::jthread([all = state.get()](const std::stop_token& stop) { all->run(stop); });
  return std::unique_ptr<StepLeader>(new StepLeader(std::move(state)));
}

std::uint16_t StepLeader::port() const {
  return state_->listener.port();
}

std::uint64_t StepLeader::publish(std::string state) {
  State& all = *state_;
  const std::scoped_lock lock(all.mutex);
  ++all.frame;
  all.newest = encodeNumber(all.frame, state);
  all.published = Clock::now();
  all.wantsFrame = false;
  for (Peer& peer : all.peers) {
    if (peer.isMember && !peer.isLast && peer.leaving.empty() && peer.given == 0) all.give(peer);
  }
  all.waker.wake();
  return all.frame;
}

void StepLeader::release() {
  State& all = *state_;
  std::unique_lock lock(all.mutex);
  all.ownTime = Clock::now() - all.published;
  all.answered.wait_for(lock, all.options.patience, [&all] {
    return std::ranges::none_of(all.peers, [&all](const Peer& peer) { return all.isAwaited(peer); });
  });
  all.released = all.frame;
  for (Peer& peer : all.peers) {
    if (!peer.isMember || peer.isLast || !peer.leaving.empty()) continue;
    if (all.isAwaited(peer)) {
      peer.isSwift = false;
      peer.isLate = true;
      all.tell(fmt::format("{} is late: nobody waits for it until it keeps up", peer.name));
    }
    all.send(peer, peer.sealer.seal(StepKind::release, encodeNumber(all.released)));
  }
  all.waker.wake();
}

bool StepLeader::wantsFrame() const {
  const std::scoped_lock lock(state_->mutex);
  return state_->wantsFrame;
}

StepLeader::Counts StepLeader::counts() const {
  const std::scoped_lock lock(state_->mutex);
  const auto& peers = state_->peers;
  return {
      .followers = static_cast<int>(std::ranges::count_if(peers, &Peer::isMember)),
      .inStep = static_cast<int>(std::ranges::count_if(peers, [](const Peer& p) { return p.isMember && p.isSwift; }))};
}

std::vector<std::string> StepLeader::news() {
  const std::scoped_lock lock(state_->mutex);
  return std::exchange(state_->news, {});
}

}  // namespace tellurion::io
