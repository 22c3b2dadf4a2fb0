#include "raster/xml_document.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace tellurion::raster {
namespace {

std::span<const std::byte> bytesOf(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

std::string textOf(std::string_view document) {
  const auto root = parseXml(bytesOf(document), "doc");
  return root ? root->text : "failed: " + io::describe(root.error());
}

std::string messageOf(std::string_view document) {
  const auto root = parseXml(bytesOf(document), "doc");
  return root ? "no failure" : io::describe(root.error());
}

std::string utf16(std::string_view ascii, bool big, bool mark) {
  std::string bytes;
  const auto put = [&](unsigned unit) {
    bytes += static_cast<char>(big ? unit >> 8 : unit & 0xFF);
    bytes += static_cast<char>(big ? unit & 0xFF : unit >> 8);
  };
  if (mark) put(0xFEFF);
  for (const char c : ascii) {
    if (c == '@') {  // stands for a letter beyond the first plane, U+1F30D
      put(0xD83C);
      put(0xDF0D);
    } else {
      put(static_cast<unsigned char>(c));
    }
  }
  return bytes;
}

TEST(XmlDocument, ReadsLocalNamesTextsAndAttributes) {
  const auto root = parseXml(
      bytesOf("<?xml version='1.0'?><!-- a > b --><w:A xmlns:w='u' x:href='1' b='&lt;2&amp;'>  t<![CDATA[<&]]>&#x41;"
              "<c>one</c><w:c>two</w:c><d><e>deep</e></d> </w:A>"),
      "doc");
  ASSERT_TRUE(root) << io::describe(root.error());
  EXPECT_EQ(root->name, "A");
  EXPECT_EQ(root->text, "t<&A");
  EXPECT_EQ(root->attribute("href"), "1");
  EXPECT_EQ(root->attribute("b"), "<2&");
  EXPECT_EQ(root->attribute("none"), "");
  EXPECT_EQ(root->all("c").size(), 2u);
  EXPECT_EQ(root->textOf("d/e"), "deep");
  EXPECT_EQ(root->textOf("d/f"), "");
  EXPECT_EQ(root->find("d/f/g"), nullptr);
}

TEST(XmlDocument, Encodings) {
  EXPECT_EQ(textOf("<a>\xC3\xA9\xE2\x82\xAC</a>"), "é€");
  EXPECT_EQ(textOf("\xEF\xBB\xBF<a>\xC3\xA9</a>"), "é");
  EXPECT_EQ(textOf("<?xml version='1.0' encoding='ISO-8859-1'?><a>\xE9\xA4</a>"), "é¤");
  EXPECT_EQ(textOf("<?xml version='1.0' encoding='ISO-8859-15'?><a>\xE9\xA4\xBD</a>"), "é€œ");
  EXPECT_EQ(textOf("<?xml version='1.0' encoding=\"Windows-1252\"?><a>\xE9\x80\x9C</a>"), "é€œ");
  for (const bool big : {false, true})
    for (const bool mark : {false, true})
      EXPECT_EQ(textOf(utf16("<?xml version='1.0' encoding='UTF-16'?><a>x@</a>", big, mark)), "x🌍");
  // Marks and declarations that are not true of the bytes.
  EXPECT_EQ(textOf("\xFF\xFE<?xml version='1.0' encoding='ISO-8859-1'?><a>\xE9</a>"), "é");
  EXPECT_EQ(textOf("<?xml version='1.0' encoding='utf-16'?><a>\xC3\xA9</a>"), "é");
}

TEST(XmlDocument, SaysWhatIsWrongAndInWhichLine) {
  EXPECT_EQ(messageOf("<a>\n<b>\n\xE9</b></a>").substr(0, 35), "doc: line 3: the bytes are not UTF-");
  EXPECT_NE(messageOf("<?xml version='1.0' encoding='EBCDIC'?><a/>").find("'ebcdic' is not one of UTF-8"),
            std::string::npos);
  EXPECT_EQ(messageOf(""), "doc: the document is empty");
  EXPECT_EQ(messageOf("  \n "), "doc: the document is empty");
  EXPECT_EQ(messageOf("<a>\n<b>\n</a>").substr(0, 12), "doc: line 3:");
  EXPECT_EQ(messageOf("<a>\n<b>\n<c></c>"), "doc: line 3: the document ends before it is complete; was it cut short?");
}

TEST(XmlDocument, EntitiesAreNeverExpanded) {
  std::string bomb = "<!DOCTYPE a [<!ENTITY l0 \"lol\">";
  for (int i = 1; i < 30; ++i) {
    bomb += "<!ENTITY l" + std::to_string(i) + " \"";
    for (int k = 0; k < 10; ++k)
      bomb += "&l" + std::to_string(i - 1) + ";";
    bomb += "\">";
  }
  bomb += "]><a>&l29;</a>";
  EXPECT_EQ(textOf(bomb), "&l29;");
  EXPECT_EQ(textOf("<!DOCTYPE a [<!ENTITY x SYSTEM \"file:///etc/hostname\">]><a>&x;</a>"), "&x;");
}

TEST(XmlDocument, MegabytesOfNestingFailAtOnce) {
  const auto repeated = [](std::string_view part, std::size_t bytes) {
    std::string text;
    while (text.size() < bytes)
      text += part;
    return text;
  };
  constexpr std::size_t kMegabyte = std::size_t{1} << 20;
  for (const char* part : {"<a>", "<a b='c'>", "<a><b/>", "<!DOCTYPE a [", "<![CDATA[", "<!--", "<?x ", "<a x=\"", "<",
                           "<!DOCTYPE [<![", "&#x41;", "<a b=''/><c>"}) {
    for (const std::size_t size : {kMegabyte, 4 * kMegabyte, 40 * kMegabyte})
      EXPECT_FALSE(parseXml(bytesOf(repeated(part, size)), "doc")) << part << size;
  }
  const std::string balanced = repeated("<a>", kMegabyte * 3 / 4) + repeated("</a>", kMegabyte);
  EXPECT_NE(messageOf(balanced).find("nests deeper than 128"), std::string::npos);
  EXPECT_NE(messageOf("<r>" + repeated("<a/>", 16 * kMegabyte) + "</r>").find("more than 1000000"), std::string::npos);
  std::string deepest;
  for (int i = 0; i < kMaxXmlDepth; ++i)
    deepest = "<a>" + deepest + "</a>";
  EXPECT_EQ(messageOf(deepest), "no failure");
  EXPECT_NE(messageOf("<a>" + deepest + "</a>"), "no failure");
}

TEST(XmlDocument, EveryCutDocumentIsAFailure) {
  const std::filesystem::path folder = std::filesystem::path(TELLURION_SHARED_DATA_DIR) / "ogc";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no shared data";
  std::size_t cuts = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".xml") continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    ASSERT_TRUE(parseXml(bytesOf(text), "doc")) << entry.path();
    const std::size_t end = text.rfind('<');
    const std::size_t step = std::max<std::size_t>(text.size() / 23, 1);
    for (std::size_t cut = 0; cut < end; cut += step, ++cuts)
      EXPECT_FALSE(parseXml(bytesOf(std::string_view(text).substr(0, cut)), "doc"))
          << entry.path() << " cut at " << cut;
  }
  EXPECT_GT(cuts, 1000u);
}

}  // namespace
}  // namespace tellurion::raster
