#include "io/url_secrets.h"

#include <gtest/gtest.h>

namespace tellurion::io {
namespace {

TEST(UrlSecrets, KeptUrlsTellNoneAndKeepAccountsApart) {
  const std::string mine = keptUrl("https://me:pass@h:80/a?b=c&apiKey=def#x");
  EXPECT_EQ(mine.substr(0, mine.find('#')), "https://h:80/a?b=c&apiKey=***");
  for (const char* other : {"https://me:other@h:80/a?b=c&apiKey=def#x", "https://you:pass@h:80/a?b=c&apiKey=def#x",
                            "https://me:pass@h:80/a?b=c&apiKey=geh#x", "https://h:80/a?b=c&apiKey=def#x"})
    EXPECT_NE(mine, keptUrl(other));
  EXPECT_EQ(mine, keptUrl("https://me:pass@h:80/a?b=c&apiKey=def#x"));
  for (const char* plain : {"http://h/a?b=c&&d#e", "http://h", "file:///a@b", "https://h/a@b?x=1@2"})
    EXPECT_EQ(keptUrl(plain), plain);
}

}  // namespace
}  // namespace tellurion::io
