#include "io/step_wire.h"

#include <fmt/format.h>

#include "io/byte_stream.h"

namespace tellurion::io {
namespace {

constexpr std::string_view kMagic = "TLRNSTEP";
constexpr std::size_t kLength_bytes = 4;
constexpr std::size_t kRefusal_bytes = 2;

std::string numbered(std::uint64_t number, std::string_view kindAndBody) {
  ByteWriter text;
  text.add(number);
  text.addBytes(kindAndBody);
  return text.bytes();
}

}  // namespace

std::string describe(StepRefusal refusal) {
  switch (refusal) {
    case StepRefusal::version:
      return "the leader speaks another version of the protocol: use the same release of Tellurion on all machines";
    case StepRefusal::wrongSecret:
      return "the leader has another secret: give all machines the same";
    case StepRefusal::needsSecret:
      return "the leader asks for a secret: give it with --secret-file, or in TELLURION_STEP_SECRET";
    case StepRefusal::tooMany:
      return "the leader has as many followers as it takes";
  }
  return "the leader refuses, for a reason that this release does not know";
}

std::string encode(const StepHello& hello) {
  ByteWriter body;
  body.addBytes(kMagic);
  body.add(hello.version);
  body.addBool(hello.hasSecret);
  body.addBytes(textOf(hello.nonce));
  return body.bytes();
}

std::optional<StepHello> decodeHello(std::string_view body) {
  ByteReader reader(body);
  if (reader.takeBytes(kMagic.size()) != kMagic) return std::nullopt;
  StepHello hello{.version = reader.take<std::uint32_t>()};
  if (!reader.isGood()) return std::nullopt;
  if (hello.version != kStepVersion) return hello;
  hello.hasSecret = reader.takeBool();
  const std::string_view nonce = reader.takeBytes(hello.nonce.size());
  if (!reader.isAtEnd()) return std::nullopt;
  nonce.copy(hello.nonce.data(), hello.nonce.size());
  return hello;
}

StepKeys stepKeys(std::string_view secret, const StepHello& leader, const StepHello& follower) {
  const auto key = [&](std::string_view direction) {
    return keyedHash(secret, std::string(direction).append(encode(leader)).append(encode(follower)));
  };
  return {.leader = key("tellurion step, from the leader"), .follower = key("tellurion step, from a follower")};
}

std::string StepSealer::seal(StepKind kind, std::string_view body) {
  ByteWriter message;
  message.add(static_cast<std::uint8_t>(kind));
  message.addBytes(body);
  if (key_ && kind != StepKind::refused)
    message.addBytes(textOf(keyedHash(textOf(*key_), numbered(number_++, message.bytes()))));
  ByteWriter all;
  all.add(static_cast<std::uint32_t>(message.bytes().size()));
  all.addBytes(message.bytes());
  return all.bytes();
}

Result<std::optional<StepMessage>> StepOpener::next() {
  const auto bad = [](const char* what) { return fail(Failure::Code::corrupt, what); };
  if (bytes_.size() < kLength_bytes) return std::optional<StepMessage>();
  ByteReader reader(bytes_);
  const std::size_t length = reader.take<std::uint32_t>();
  const bool isRefusal = length == kRefusal_bytes && reader.rest().starts_with(static_cast<char>(StepKind::refused));
  const std::size_t sealed = key_ && !isRefusal ? Digest{}.size() : 0;
  if (length < 1 + sealed || length > 1 + longestBody_ + sealed) return bad("sent a message of an impossible length");
  if (reader.rest().size() < length) return std::optional<StepMessage>();
  const std::string_view message = reader.takeBytes(length);
  const std::string_view kindAndBody = message.substr(0, length - sealed);
  if (sealed > 0 && !isSameDigest(message.substr(length - sealed),
                                  textOf(keyedHash(textOf(*key_), numbered(number_++, kindAndBody)))))
    return bad("sent a message under another secret");
  const auto kind = static_cast<std::uint8_t>(kindAndBody.front());
  if (kind == 0 || kind > static_cast<std::uint8_t>(kLastStepKind)) return bad("sent a message of an unknown kind");
  StepMessage opened{.kind = static_cast<StepKind>(kind), .body = std::string(kindAndBody.substr(1))};
  bytes_.erase(0, kLength_bytes + length);
  return std::optional(std::move(opened));
}

std::string encodeNumber(std::uint64_t number, std::string_view then) {
  ByteWriter body;
  body.add(number);
  body.addBytes(then);
  return body.bytes();
}

std::optional<NumberAndRest> decodeNumber(std::string_view body) {
  ByteReader reader(body);
  const auto number = reader.take<std::uint64_t>();
  return reader.isGood() ? std::optional(NumberAndRest{.number = number, .rest = reader.rest()}) : std::nullopt;
}

}  // namespace tellurion::io
