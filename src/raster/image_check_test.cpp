#include "raster/image_check.h"

#include <gtest/gtest.h>

#include "raster/codec.h"
#include "raster/service_exception.h"

namespace tellurion::raster {
namespace {

constexpr ExpectedImage kTile{Kind::imagery, 16, 16, 0, true};

io::Resource resourceOf(std::string_view text, std::string type = "image/png") {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {{bytes.begin(), bytes.end()}, std::move(type)};
}

std::string outcome(const io::Resource& resource, const ExpectedImage& expected) {
  const auto good = checkImage(resource, expected);
  return good ? *good ? "good" : "nothing" : good.error().message;
}

io::Resource picture(ImageFormat format, int side) {
  Raster<Rgba8> image(side, side);
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column)
      image.at(column, row) = {static_cast<std::uint8_t>(column * 16), static_cast<std::uint8_t>(row * 16), 7, 255};
  return {encodeImage(image, format, 90).value(), "image/x"};
}

TEST(ImageCheck, PicturesAreGoodWholeAndBadWhenTheyEndEarly) {
  for (const ImageFormat format : {ImageFormat::png, ImageFormat::jpeg, ImageFormat::webp}) {
    io::Resource whole = picture(format, 16);
    EXPECT_EQ(outcome(whole, kTile), "good") << nameOf(format);
    whole.bytes.push_back(std::byte{0});
    EXPECT_EQ(outcome(whole, kTile), "good") << "a byte more";
    whole.bytes.pop_back();
    while (whole.bytes.size() > 1) {
      whole.bytes.pop_back();
      EXPECT_FALSE(checkImage(whole, kTile)) << nameOf(format) << " cut to " << whole.bytes.size();
    }
  }
}

TEST(ImageCheck, SizesAndKindsMustBeRight) {
  EXPECT_NE(outcome(picture(ImageFormat::png, 32), kTile).find("32 x 32 pixels, not the 16 x 16"), std::string::npos);
  ExpectedImage heights = kTile;
  heights.kind = Kind::elevation;
  EXPECT_EQ(outcome(picture(ImageFormat::png, 16), heights), "good");
  EXPECT_NE(outcome(picture(ImageFormat::jpeg, 16), heights).find("JPEG"), std::string::npos);
  heights.rawSampleBytes = 2;
  EXPECT_EQ(outcome(resourceOf(std::string(512, '<')), heights), "good");  // looks like XML, has the size
  EXPECT_NE(outcome(resourceOf(std::string(500, 'x')), heights).find("500 bytes came, not the 512"), std::string::npos);
}

TEST(ImageCheck, GifsAreKnownByTheirFirstAndLastBytes) {
  const std::string gif("GIF89a\x10\0\x10\0\0\0\0,;", 15);
  EXPECT_EQ(outcome(resourceOf(gif, "image/gif"), kTile), "good");
  EXPECT_EQ(outcome(resourceOf(gif + std::string(3, '\0'), "image/gif"), kTile), "good") << "a few bytes more";
  for (std::size_t length = 6; length < gif.size(); ++length)
    EXPECT_FALSE(checkImage(resourceOf(gif.substr(0, length)), kTile)) << length;
  ExpectedImage other = kTile;
  other.width = 17;
  EXPECT_NE(outcome(resourceOf(gif), other).find("16 x 16 pixels, not the 17 x 16"), std::string::npos);
  other = kTile;
  other.kind = Kind::elevation;
  EXPECT_NE(outcome(resourceOf(gif), other).find("256 colours"), std::string::npos);
}

TEST(ImageCheck, QuotesWhatTheServerSaysInstead) {
  const char* wms =
      "<?xml version='1.0'?>\n<!DOCTYPE ServiceExceptionReport SYSTEM 'http://h/x.dtd'>\n<ServiceExceptionReport>\n"
      "<ServiceException code='LayerNotDefined'>\n  no layer\n  here.\n</ServiceException></ServiceExceptionReport>";
  EXPECT_EQ(outcome(resourceOf(wms), kTile), "the server says: LayerNotDefined: no layer here");
  const char* range =
      "<ows:ExceptionReport xmlns:ows='o'><ows:Exception exceptionCode='TileOutOfRange'><ows:ExceptionText>Row"
      "</ows:ExceptionText></ows:Exception></ows:ExceptionReport>";
  EXPECT_EQ(outcome(resourceOf(range), kTile), "nothing");
  ExpectedImage drawn = kTile;
  drawn.ready = false;
  EXPECT_EQ(outcome(resourceOf(range), drawn), "the server says: TileOutOfRange: Row");
  EXPECT_EQ(outcome(resourceOf("\n<html><head><TITLE>502 Bad\nGateway</TITLE></head>"), kTile),
            "a page came instead of an image: '502 Bad Gateway'");
  EXPECT_EQ(outcome(resourceOf("{\"error\": \"no key\"}"), kTile), "the server says: {\"error\": \"no key\"}");
  EXPECT_EQ(outcome(resourceOf(""), kTile), "nothing");
  EXPECT_EQ(outcome(resourceOf(""), drawn), "the answer is empty");
  EXPECT_NE(outcome(resourceOf("BM............", "image/bmp"), kTile).find("no image that is known"),
            std::string::npos);
}

TEST(ImageCheck, WhatIsQuotedIsShortAndOnOneLine) {
  const std::string text = onOneLine(std::string(200, 'x') + "\x1b[31m\r\n" + std::string(5000, 'y') + "é");
  EXPECT_LE(text.size(), 310u);
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
  EXPECT_EQ(text.find('\n'), std::string::npos);
  for (std::size_t n = 290; n < 310; ++n) {  // no half letter at the cut
    const std::string cut = onOneLine(std::string(n, 'x') + "ééééééééé");
    EXPECT_NE(static_cast<unsigned char>(cut[cut.size() - 4]) & 0xC0, 0xC0);
  }
}

TEST(ImageCheck, WhatAServerQuotesOfTheRequestIsNotTold) {
  for (const char* said :
       {"<html><title>No http://me:word@h/wms?token=abc123</title></html>", "{\"error\": \"token=abc123\"}",
        "<ServiceExceptionReport><ServiceException>/wms?layers=a&amp;token=abc123 is refused"
        "</ServiceException></ServiceExceptionReport>"}) {
    const std::string told = outcome(resourceOf(said, "text/html"), kTile);
    EXPECT_EQ(told.find("abc123"), told.npos) << told;
    EXPECT_EQ(told.find("word"), told.npos) << told;
    EXPECT_NE(told.find("token=***"), told.npos) << told;
  }
}

}  // namespace
}  // namespace tellurion::raster
