#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/failure.h"
#include "io/net_address.h"

namespace tellurion::io {

struct StepFollowerOptions {
  NetAddress leader;
  std::string secret;  ///< the leader's; with one, no leader without it is followed
  /// Whether to follow a leader with this greeting; on the network's thread. May be empty.
  std::function<Result<void>(std::string_view greeting)> check = {};
  /// Called on the network's thread when newest(), status() or news() have something; quick. May be empty.
  std::function<void()> wake = {};
};

/// Follows a StepLeader: newest(), make one's picture of it, ready(), awaitRelease(), show it. A leader that is not
/// there, or is gone (also silent for two seconds), is tried again and again, after 50 ms at first and every second at
/// last. One thread only, but for the callbacks; a thread of its own speaks with the leader.
class StepFollower {
 public:
  static Result<std::unique_ptr<StepFollower>> follow(StepFollowerOptions options);
  /// May wait for the DNS, where the leader's name is being looked up.
  ~StepFollower();
  StepFollower(const StepFollower&) = delete;
  StepFollower& operator=(const StepFollower&) = delete;

  struct Step {
    std::uint64_t frame = 0;
    std::string state;             ///< as the leader published it
    std::uint64_t connection = 0;  ///< by which it came; answers to one that is gone go nowhere
  };
  /// What was not taken yet; of several, the last.
  std::optional<Step> newest();
  /// The picture of this frame is there. changes: with time it changes on its own, so another frame is of use.
  void ready(const Step& step, bool changes);
  enum class Release : std::uint8_t { shown, notYet, gone };
  /// shown: the leader shows it. gone: it will not say so any more. notYet: it has not, in this time.
  Release awaitRelease(const Step& step, std::chrono::milliseconds atMost);
  /// Data have come that another frame would show.
  void askForFrame();

  enum class Status : std::uint8_t { searching, following, lost, refused };
  /// refused: before it followed, the leader refused it or its greeting did not suit: for good.
  Status status() const;
  /// What became of the leader, for people, since the last call; the first 100. What led to `refused` is the last.
  std::vector<std::string> news();

 private:
  struct State;
  explicit StepFollower(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tellurion::io
