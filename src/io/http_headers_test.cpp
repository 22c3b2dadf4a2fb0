#include "io/http_headers.h"

#include <gtest/gtest.h>

#include <random>

namespace tellurion::io {
namespace {

constexpr UnixSeconds kNow = 1'700'000'000;  // Tue, 14 Nov 2023 22:13:20 GMT
constexpr UnixSeconds kDay_s = 86'400;

HttpHeaders headersOf(std::initializer_list<std::string> lines) {
  HttpHeaders headers;
  for (const std::string& line : lines)
    headers.read(line + "\r\n");
  return headers;
}

UnixSeconds lifetime(std::initializer_list<std::string> lines) {
  return freshnessOf(headersOf(lines), kNow).expires - kNow;
}

TEST(HttpHeaders, NamesInAnyCaseAndAStatusLineBeginsAnew) {
  HttpHeaders headers = headersOf(
      {"HTTP/1.1 302 Found", "ETag: \"a\"", "cOnTeNt-TyPe:  Image/PNG ; charset=x ", "Server: x", "nonsense"});
  EXPECT_EQ(headers.etag, "\"a\"");
  EXPECT_EQ(mimeType(headers.contentType), "image/png");
  headers.read("HTTP/2 200 \r\n");
  EXPECT_EQ(headers.etag, "");
  EXPECT_EQ(headers.contentType, "");
}

TEST(HttpHeaders, Freshness) {
  EXPECT_EQ(lifetime({}), kDay_s);
  EXPECT_EQ(lifetime({"Cache-Control: max-age=60"}), 60);
  EXPECT_EQ(lifetime({"Cache-Control: public, Max-Age = 60 , immutable"}), 60);
  EXPECT_EQ(lifetime({"Cache-Control: public", "Cache-Control: max-age=60"}), 60);
  EXPECT_EQ(lifetime({"Cache-Control: max-age=60", "Expires: Tue, 14 Nov 2023 23:13:20 GMT"}), 60);
  EXPECT_EQ(lifetime({"Cache-Control: max-age=60", "Age: 20"}), 40);
  EXPECT_EQ(lifetime({"Cache-Control: max-age=60", "Age: 200"}), 0);
  EXPECT_EQ(lifetime({"Cache-Control: no-cache, max-age=60"}), 0);
  EXPECT_EQ(lifetime({"Cache-Control: max-age=99999999999999999999999"}), 365 * kDay_s);
  EXPECT_EQ(lifetime({"Cache-Control: max-age=-5"}), kDay_s);
  EXPECT_EQ(lifetime({"Cache-Control: max-age=soon"}), kDay_s);
  EXPECT_EQ(lifetime({"Expires: Tue, 14 Nov 2023 23:13:20 GMT"}), 3600);
  EXPECT_EQ(lifetime({"Date: Tue, 14 Nov 2023 20:13:20 GMT", "Expires: Tue, 14 Nov 2023 20:14:20 GMT"}), 60)
      << "a clock that is wrong";
  EXPECT_EQ(lifetime({"Expires: 0"}), 0);
  EXPECT_EQ(lifetime({"Expires: Sun, 06 Nov 1994 08:49:37 GMT"}), 0);
  EXPECT_EQ(lifetime({"Expires: Fri, 01 Jan 9999 00:00:00 GMT"}), 365 * kDay_s);
  EXPECT_TRUE(freshnessOf(headersOf({}), kNow).store);
  EXPECT_FALSE(freshnessOf(headersOf({"Cache-Control: max-age=60, no-store"}), kNow).store);
}

TEST(HttpHeaders, RetryAfter) {
  const auto retry = [](const std::string& value) { return retryAfter_s(headersOf({"Retry-After: " + value}), kNow); };
  EXPECT_FALSE(retryAfter_s({}, kNow));
  EXPECT_FALSE(retry("later"));
  EXPECT_FALSE(retry(""));
  EXPECT_FALSE(retry("-5"));
  EXPECT_EQ(retry("7"), 7.0);
  EXPECT_EQ(retry("0"), 0.0);
  EXPECT_EQ(retry("1000000"), 600.0);
  EXPECT_EQ(retry("99999999999999999999999"), 600.0);
  EXPECT_EQ(retry("Tue, 14 Nov 2023 22:14:20 GMT"), 60.0);
  EXPECT_EQ(retry("Tue, 14 Nov 2023 22:00:00 GMT"), 0.0);
}

TEST(HttpHeaders, AnyBytesAreTaken) {
  std::mt19937 random(3);
  const std::string alphabet = "Cache-Control:Expires, max-age=0123456789\"\r\n\t\0;=";
  for (int i = 0; i < 20'000; ++i) {
    HttpHeaders headers;
    std::string line = i % 2 == 0 ? "Cache-Control:" : i % 3 == 0 ? "Expires:" : "Retry-After:";
    for (unsigned n = static_cast<unsigned>(random() % 40); n > 0; --n)
      line += alphabet[random() % alphabet.size()];
    headers.read(line);
    const UnixSeconds expires = freshnessOf(headers, kNow).expires;
    EXPECT_GE(expires, kNow) << line;
    EXPECT_LE(expires, kNow + 366 * kDay_s) << line;
    const auto wait = retryAfter_s(headers, kNow);
    EXPECT_TRUE(!wait || (*wait >= 0.0 && *wait <= 600.0)) << line;
  }
}

}  // namespace
}  // namespace tellurion::io
