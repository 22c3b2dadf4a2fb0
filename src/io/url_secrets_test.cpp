#include "io/url_secrets.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <utility>

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

TEST(UrlSecrets, PathsHoldSecretsToo) {
  constexpr const char* kUuid = "3f2504e0-4f89-11d3-9a0c-0305e82c3301";
  for (const auto& [url, shown] : std::initializer_list<std::pair<std::string, std::string>>{
           {"https://h/wms/token/abc/map", "https://h/wms/token/***/map"},
           {"https://h/ApiKey/abc", "https://h/ApiKey/***"},
           {"https://u:p@h/token=abc/x.png", "https://h/token=***/x.png"},
           {"https://h/" + std::string(kUuid) + "/1/2/3.png", "https://h/***/1/2/3.png"},
           {"https://h/d41d8cd98f00b204e9800998ecf8427e/1/2", "https://h/***/1/2"}}) {
    EXPECT_EQ(withoutSecrets(url), shown);
    EXPECT_NE(keptUrl(url), url) << "and what is kept does not tell it either";
    EXPECT_NE(keptUrl(url), keptUrl(url + "x"));
  }
  // What is no secret stays, or nobody could tell layers apart.
  for (const char* plain :
       {"https://h/wmts/epsg4326/best/MODIS_Terra_CorrectedReflectance_TrueColor/default/2012-07-09/250m/0/0/0.jpg",
        "https://h/keys/7/authority/9", "https://h/token", "http://h:80/a/b.c/20240607T120000Z.png", "file:///key/abc",
        "/data/key/abc", "http://h/{z}/{x}/{y}.png"})
    EXPECT_EQ(withoutSecrets(plain), plain);
}

TEST(UrlSecrets, WhatAServerQuotesOfUsIsNotTold) {
  EXPECT_EQ(quotedWithoutSecrets("404: no such page (http://me:pass@h/token/abc?key=def&l=1), sorry"),
            "404: no such page (http://h/token/***?key=***&l=1), sorry");
  EXPECT_EQ(quotedWithoutSecrets("/wms?apikey=abc is refused; token=abc, layer=a"),
            "/wms?apikey=*** is refused; token=***, layer=a");
  for (const char* plain : {"", "Welcome", "The layer 'a' is not there, says the test.", "a/b = c", "1/2, x=3"})
    EXPECT_EQ(quotedWithoutSecrets(plain), plain);
}

}  // namespace
}  // namespace tellurion::io
