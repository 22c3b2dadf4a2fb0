#include "io/step_wire.h"

#include <gtest/gtest.h>

#include "geo/seed_test.h"

namespace tellurion::io {
namespace {

std::string randomBytes(std::mt19937_64& random, std::size_t size) {
  std::string bytes(size, '\0');
  for (char& c : bytes)
    c = static_cast<char>(random() & 0xffu);
  return bytes;
}

Digest someKey(std::mt19937_64& random) {
  return keyedHash(randomBytes(random, 8), "key");
}

/// All messages in a stream that comes in pieces of any size; the failure ends it.
Result<std::vector<StepMessage>> openAll(StepOpener opener, std::string_view stream, std::mt19937_64& random) {
  std::vector<StepMessage> all;
  while (!stream.empty()) {
    const std::size_t piece = std::min<std::size_t>(1 + random() % 50, stream.size());
    opener.add(stream.substr(0, piece));
    stream.remove_prefix(piece);
    for (;;) {
      auto message = opener.next();
      if (!message) return tl::unexpected(message.error());
      if (!*message) break;
      all.push_back(std::move(**message));
    }
  }
  return all;
}

class StepWire : public testing::TestWithParam<bool> {
 protected:
  StepSealer sealer() const {
    StepSealer sealer;
    if (GetParam()) sealer.setKey(key);
    return sealer;
  }
  StepOpener opener(std::size_t longest = kLongestLeaderMessage) const {
    StepOpener opener(longest);
    if (GetParam()) opener.setKey(key);
    return opener;
  }
  std::mt19937_64 random = geo::seededGenerator();
  Digest key = someKey(random);
};
INSTANTIATE_TEST_SUITE_P(, StepWire, testing::Bool(),
                         [](const auto& one) { return one.param ? "underAKey" : "withoutAKey"; });

TEST_P(StepWire, whatIsSealedIsOpened) {
  StepSealer seal = sealer();
  std::string stream;
  std::vector<StepMessage> sent;
  for (int i = 0; i < 200; ++i) {
    const auto kind = static_cast<StepKind>(1 + random() % 8);
    sent.push_back({.kind = kind, .body = randomBytes(random, random() % 300)});
    stream += seal.seal(kind, sent.back().body);
  }
  const auto opened = openAll(opener(), stream, random);
  ASSERT_TRUE(opened);
  ASSERT_EQ(opened->size(), sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    EXPECT_EQ((*opened)[i].kind, sent[i].kind);
    EXPECT_EQ((*opened)[i].body, sent[i].body);
  }
}

TEST_P(StepWire, anyBytesAreBorne) {
  for (int i = 0; i < 2000; ++i) {
    std::string stream = randomBytes(random, random() % 400);
    if (i % 2 == 0) {  // of a length that may be
      stream = sealer().seal(StepKind::frame, stream);
      stream[random() % stream.size()] = static_cast<char>(random());
    }
    const auto opened = openAll(opener(), stream, random);
    if (opened) {
      EXPECT_LE(opened->size(), stream.size() / 5);
    }
  }
}

TEST_P(StepWire, aMessageThatIsTooLongIsRefusedByItsLengthAlone) {
  StepOpener open = opener(kLongestFollowerMessage);
  open.add(sealer().seal(StepKind::ready, std::string(kLongestFollowerMessage + 1, 'x')).substr(0, 5));
  EXPECT_FALSE(open.next());
  StepOpener none = opener();
  none.add(std::string(4, '\0'));
  EXPECT_FALSE(none.next());
}

TEST(StepMessages, underAKeyNothingCanBeChangedLeftOutRepeatedOrTurnedRound) {
  std::mt19937_64 random = geo::seededGenerator();
  const Digest key = someKey(random);
  StepSealer seal;
  seal.setKey(key);
  const std::string first = seal.seal(StepKind::frame, "first");
  const std::string second = seal.seal(StepKind::frame, "second");
  const auto opens = [&](const std::string& stream, const Digest& with) {
    StepOpener opener(kLongestLeaderMessage);
    opener.setKey(with);
    return openAll(opener, stream, random).has_value();
  };
  EXPECT_TRUE(opens(first + second, key));
  EXPECT_FALSE(opens(second, key)) << "left out";
  EXPECT_FALSE(opens(first + first, key)) << "repeated";
  EXPECT_FALSE(opens(first + second, someKey(random))) << "another key";
  const StepHello leader{.nonce = someKey(random)}, follower{.nonce = someKey(random)};
  const StepKeys keys = stepKeys("a secret of theirs", leader, follower);
  EXPECT_NE(keys.leader, keys.follower);
  EXPECT_NE(keys.leader, stepKeys("a secret of ours..", leader, follower).leader);
  EXPECT_NE(keys.leader, stepKeys("a secret of theirs", {.nonce = someKey(random)}, follower).leader);
  EXPECT_NE(keys.leader, stepKeys("a secret of theirs", leader, {.nonce = someKey(random)}).leader);
  for (std::size_t i = 4; i < first.size(); ++i) {
    std::string changed = first;
    changed[i] = static_cast<char>(changed[i] ^ (1 << random() % 8));
    EXPECT_FALSE(opens(changed, key)) << i;
  }
}

TEST(StepMessages, refusalsNeedNoKey) {
  std::mt19937_64 random = geo::seededGenerator();
  StepOpener opener(kLongestLeaderMessage);
  opener.setKey(someKey(random));
  opener.add(StepSealer().seal(StepKind::refused, "\2"));
  const auto message = opener.next();
  ASSERT_TRUE(message && *message);
  EXPECT_EQ((*message)->kind, StepKind::refused);
  for (int code = 0; code < 256; ++code)
    EXPECT_FALSE(describe(static_cast<StepRefusal>(code)).empty());
}

TEST(StepMessages, hellosOfOtherVersionsAreKnownAsSuch) {
  std::mt19937_64 random = geo::seededGenerator();
  StepHello hello{.hasSecret = true, .nonce = someKey(random)};
  const auto again = decodeHello(encode(hello));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->nonce, hello.nonce);
  EXPECT_TRUE(again->hasSecret);
  hello.version = kStepVersion + 1;
  const auto other = decodeHello(encode(hello) + "and more");
  ASSERT_TRUE(other);
  EXPECT_EQ(other->version, kStepVersion + 1);
  EXPECT_FALSE(decodeHello("HTTP/1.1 400 Bad Request"));
  hello.version = kStepVersion;
  const std::string whole = encode(hello);
  for (std::size_t length = 0; length < whole.size(); ++length)
    EXPECT_FALSE(decodeHello(whole.substr(0, length))) << length;
  EXPECT_FALSE(decodeHello(whole + "x"));
}

TEST(StepMessages, numbers) {
  const auto number = decodeNumber(encodeNumber(0xfedcba9876543210u, "rest"));
  ASSERT_TRUE(number);
  EXPECT_EQ(number->number, 0xfedcba9876543210u);
  EXPECT_FALSE(decodeNumber("1234567"));
}

}  // namespace
}  // namespace tellurion::io
