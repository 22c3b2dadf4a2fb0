#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "io/failure.h"
#include "io/net_address.h"

namespace tellurion::io {

struct StepLeaderOptions {
  NetAddress address;
  /// That followers must have too. Empty: none, and only where no other machine can reach the address.
  std::string secret;
  /// What a follower checks before it follows; at most 256 KiB.
  std::string greeting;
  /// How much longer than the leader itself those in step may take for a frame. Who takes longer runs behind until he
  /// keeps up again, and nobody waits for him.
  std::chrono::milliseconds patience{100};
  std::size_t mostFollowers = 64;
  /// Called on the network's thread when wantsFrame() or news() have something; quick. May be empty.
  std::function<void()> wake = {};
};

/// Has others show the same at the same time: publish() what is to be shown, make one's own picture of it, release(),
/// show it. Followers make theirs meanwhile, and show it when released (a swap lock). One thread only, but for `wake`;
/// a thread of its own speaks with the followers, so all of these but release() return at once.
class StepLeader {
 public:
  /// Fails where the address cannot be listened on, and where another machine could reach it and there is no secret.
  static Result<std::unique_ptr<StepLeader>> listen(StepLeaderOptions options);
  ~StepLeader();
  StepLeader(const StepLeader&) = delete;
  StepLeader& operator=(const StepLeader&) = delete;

  std::uint16_t port() const;

  /// Gives the next frame to all followers that have done the last, and its number, from 1 on. What others are given,
  /// once they have, is the newest. state: at most 256 KiB less 8.
  std::uint64_t publish(std::string state);
  /// Waits for those in step; then all that have drawn it show it.
  void release();

  /// Another frame would be of use: somebody has come, has got data, or has not done with fading it in.
  bool wantsFrame() const;

  struct Counts {
    int followers = 0;
    int inStep = 0;
  };
  Counts counts() const;
  /// Who came, ran late, caught up, was refused or left, for people, since the last call; the first 100.
  std::vector<std::string> news();

 private:
  struct State;
  explicit StepLeader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tellurion::io
