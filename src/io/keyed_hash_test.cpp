#include "io/keyed_hash.h"

#include <gtest/gtest.h>

#include <array>

namespace tellurion::io {
namespace {

std::string hexOf(const Digest& digest) {
  constexpr std::array kDigits{'0', '1', '2', '3', '4', '5', '6', '7', '8', '9', 'a', 'b', 'c', 'd', 'e', 'f'};
  std::string text;
  for (const char c : digest) {
    const auto byte = static_cast<unsigned char>(c);
    text += {kDigits[byte >> 4], kDigits[byte & 15]};
  }
  return text;
}

/// RFC 4231, test cases 1, 2 and 6.
TEST(KeyedHash, isThatOfTheRfc) {
  EXPECT_EQ(hexOf(keyedHash(std::string(20, '\x0b'), "Hi There")),
            "b0344c61d8db38535ca8afceaf0bf12b881dc200c9833da726e9376c2e32cff7");
  EXPECT_EQ(hexOf(keyedHash("Jefe", "what do ya want for nothing?")),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
  EXPECT_EQ(hexOf(keyedHash(std::string(131, '\xaa'), "Test Using Larger Than Block-Size Key - Hash Key First")),
            "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54");
}

TEST(KeyedHash, comparesAllOfIt) {
  const Digest digest = keyedHash("k", "t");
  for (std::size_t i = 0; i < digest.size(); ++i) {
    Digest other = digest;
    other[i] = static_cast<char>(other[i] ^ 1);
    EXPECT_FALSE(isSameDigest(textOf(digest), textOf(other))) << i;
  }
  EXPECT_TRUE(isSameDigest(textOf(digest), textOf(keyedHash("k", "t"))));
  EXPECT_FALSE(isSameDigest(textOf(digest), textOf(digest).substr(1)));
}

TEST(KeyedHash, unguessableBytesAreNeverTheSame) {
  EXPECT_NE(unguessableBytes().value(), unguessableBytes().value());
}

}  // namespace
}  // namespace tellurion::io
