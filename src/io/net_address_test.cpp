#include "io/net_address.h"

#include <gtest/gtest.h>

namespace tellurion::io {
namespace {

TEST(NetAddress, readsWhatItWrites) {
  for (const char* text : {"127.0.0.1:0", "dome-2.example.org:65535", "[::1]:7311", "[fe80::1%eth0]:1"}) {
    const auto address = parseNetAddress(text);
    ASSERT_TRUE(address) << text;
    EXPECT_EQ(formatNetAddress(*address), text);
  }
  EXPECT_EQ(parseNetAddress("7311").value(), (NetAddress{.host = "127.0.0.1", .port = 7311}));
  EXPECT_EQ(parseNetAddress("[::1]:1").value(), (NetAddress{.host = "::1", .port = 1}));
}

TEST(NetAddress, refusesTheRest) {
  for (const std::string& text :
       {std::string(""), std::string(":1"), std::string("host"), std::string("host:"), std::string("host:65536"),
        std::string("host:-1"), std::string("host: 1"), std::string("::1:7311"), std::string("[]:1"),
        std::string("[::1]"), std::string("a b:1"), std::string("a\n:1"), std::string(300, 'a') + ":1"}) {
    const auto address = parseNetAddress(text);
    ASSERT_FALSE(address) << text;
    EXPECT_NE(address.error().message.find("HOST:PORT"), std::string::npos);
  }
}

}  // namespace
}  // namespace tellurion::io
