#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "io/failure.h"
#include "io/keyed_hash.h"

// What a leader and its followers say to each other (docs/several-machines.md has the bytes): StepLeader, StepFollower.
namespace tellurion::io {

/// Both sides must have the same.
inline constexpr std::uint32_t kStepVersion = 1;
/// Of a message's body: a leader's, and a follower's.
inline constexpr std::size_t kLongestLeaderMessage = 256 * 1024;
inline constexpr std::size_t kLongestFollowerMessage = 64;
/// Of the secret that both sides share.
inline constexpr std::size_t kShortestSecret = 16;
inline constexpr std::size_t kLongestSecret = 4096;

enum class StepKind : std::uint8_t {
  hello = 1,    ///< both, first: StepHello
  join = 2,     ///< follower: empty, the first message under its key
  welcome = 3,  ///< leader: what the follower checks before it follows
  frame = 4,    ///< leader: its number (8 bytes), and what is to be shown
  release = 5,  ///< leader: show this number (8 bytes), and those before
  ready = 6,    ///< follower: has drawn this number (8 bytes); 1 byte: 1, its picture goes on to change
  again = 7,    ///< follower: has got data that another frame would show
  alive = 8,    ///< both: nothing new
  refused = 9,  ///< leader: StepRefusal (1 byte); the last message
};
inline constexpr auto kLastStepKind = StepKind::refused;

enum class StepRefusal : std::uint8_t { version = 1, wrongSecret = 2, needsSecret = 3, tooMany = 4 };

/// For people, as a follower tells it.
std::string describe(StepRefusal refusal);

struct StepMessage {
  StepKind kind = StepKind::alive;
  std::string body;
};

struct StepHello {
  std::uint32_t version = kStepVersion;
  bool hasSecret = false;
  Digest nonce{};
};
std::string encode(const StepHello& hello);
/// Nothing: it is no hello of this protocol. One of another version may have anything but its version wrong.
std::optional<StepHello> decodeHello(std::string_view body);

/// The keys of a connection's two directions, of the secret and both nonces.
struct StepKeys {
  Digest leader;
  Digest follower;
};
StepKeys stepKeys(std::string_view secret, const StepHello& leader, const StepHello& follower);

/// Makes messages into bytes. Those under a key have an HMAC-SHA256 over their number, so none can be changed, left
/// out, repeated or put elsewhere; they can be read by anybody. Refusals have none: they are for those who have no key.
/// A value.
class StepSealer {
 public:
  void setKey(const Digest& key) { key_ = key; }
  std::string seal(StepKind kind, std::string_view body = {});

 private:
  std::optional<Digest> key_;
  std::uint64_t number_ = 0;
};

/// And bytes into messages. Safe on any bytes: what is held is never more than one message and what was just added.
class StepOpener {
 public:
  explicit StepOpener(std::size_t longestBody) : longestBody_(longestBody) {}
  void setKey(const Digest& key) { key_ = key; }
  void add(std::string_view bytes) { bytes_.append(bytes); }
  /// Nothing: more bytes are needed. Fails for good on a message that is too long, of no kind, or whose key is another.
  Result<std::optional<StepMessage>> next();

 private:
  std::size_t longestBody_;
  std::optional<Digest> key_;
  std::uint64_t number_ = 0;
  std::string bytes_;
};

/// Bodies.
std::string encodeNumber(std::uint64_t number, std::string_view then = {});
struct NumberAndRest {
  std::uint64_t number = 0;
  std::string_view rest;  ///< of the body
};
std::optional<NumberAndRest> decodeNumber(std::string_view body);

}  // namespace tellurion::io
