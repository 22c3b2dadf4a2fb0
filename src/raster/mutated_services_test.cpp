#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <string_view>

#include "geo/seed_test.h"
#include "raster/raster_fixture_test.h"
#include "raster/service_fixture_test.h"
#include "raster/service_offers.h"

// Real documents of servers with random damage: whatever it is, there is an answer within bounds, and what opens is
// sound. Under the sanitizers this is where a slip of the parsers shows; TELLURION_TEST_SEED=random takes other damage.
namespace tellurion::raster {
namespace {

namespace fs = std::filesystem;

std::string textOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Values that servers write, and that nobody does.
constexpr std::array<std::string_view, 24> kValues = {"0",
                                                      "-1",
                                                      "1e308",
                                                      "-1e308",
                                                      "nan",
                                                      "inf",
                                                      "4294967296",
                                                      "9223372036854775808",
                                                      "0.28e-400",
                                                      "",
                                                      " ",
                                                      "-180 -90 180 90",
                                                      "EPSG:4326",
                                                      "EPSG:3857",
                                                      "EPSG:0",
                                                      "CRS:84",
                                                      "urn:ogc:def:crs:EPSG::4326",
                                                      "image/png",
                                                      "2004-01-01/2005-01-01/PT0S",
                                                      "1000-01-01/9999-01-01/PT1S",
                                                      "&#0;",
                                                      "&amp;",
                                                      "http://127.0.0.1:1/{TileMatrix}/{TileRow}/{TileCol}",
                                                      "\xc3\xa9"};
/// What ends or begins something that does not.
constexpr std::array<std::string_view, 8> kMarks = {
    "<Layer>", "</Layer>", "<!--", "<![CDATA[", "<!DOCTYPE a [<!ENTITY b 'c'>]>", "&b;", "\xff\xfe", "\""};

/// Random damage; most of it leaves a document that is well-formed, so that more than the reader of XML is tried.
class Damage {
 public:
  explicit Damage(std::mt19937_64& random) : random_(random) {}

  std::string to(std::string text, const std::string& other) {
    for (std::size_t i = 1 + upTo(5); i > 0; --i)
      wound(text, other);
    if (random_() % 4 == 0) breakMarks(text);
    return text;
  }

 private:
  struct Span {
    std::size_t begin = 0;
    std::size_t size = 0;
  };

  std::size_t upTo(std::size_t most) { return random_() % (most + 1); }

  /// The text of an element or the value of an attribute.
  Span value(const std::string& text) {
    const std::size_t before = text.find_first_of(">\"", upTo(text.size()));
    if (before == text.npos) return {};
    const std::size_t end = text.find_first_of("<>\"", before + 1);
    const bool isValue =
        end != text.npos && (text[end] == '<' ? text[before] == '>' : text[end] == '"' && text[before] == '"');
    return isValue ? Span{before + 1, end - before - 1} : Span{};
  }

  /// From a tag to the next end of that name.
  Span element(const std::string& text) {
    const std::size_t begin = text.find('<', upTo(text.size()));
    if (begin == text.npos) return {};
    const std::size_t nameEnd = text.find_first_of(" />\r\n\t", begin);
    if (nameEnd == text.npos || nameEnd < begin + 2) return {};
    const std::string end = "</" + text.substr(begin + 1, nameEnd - begin - 1) + ">";
    const std::size_t at = text.find(end, nameEnd);
    return at == text.npos ? Span{} : Span{begin, at + end.size() - begin};
  }

  void wound(std::string& text, const std::string& other) {
    switch (random_() % 5) {
      case 0:
      case 1:
        if (const Span at = value(text); at.begin > 0)
          text.replace(at.begin, at.size, kValues[random_() % kValues.size()]);
        break;
      case 2:
        if (const Span at = element(text); at.size > 0) text.erase(at.begin, at.size);
        break;
      case 3:
        if (const Span at = element(text); at.size > 0) text.insert(at.begin, text.substr(at.begin, at.size));
        break;
      case 4:
        if (const Span at = element(text), from = element(other); at.size > 0)
          text.replace(at.begin, at.size, other, from.begin, from.size);
        break;
    }
  }

  void breakMarks(std::string& text) {
    const std::size_t at = upTo(text.size());
    switch (random_() % 4) {
      case 0:
        if (at < text.size()) text[at] = static_cast<char>(random_() & 0xffu);
        break;
      case 1:
        text.erase(at, upTo(200));
        break;
      case 2:
        text.insert(at, kMarks[random_() % kMarks.size()]);
        break;
      case 3:
        text.resize(at);
        break;
    }
  }

  std::mt19937_64& random_;
};

std::size_t bytesOf(const ServiceOffers& offers) {
  std::size_t bytes =
      offers.layers.capacity() * sizeof(LayerOffer) + offers.title.capacity() + offers.abstract.capacity();
  for (const LayerOffer& layer : offers.layers) {
    for (const auto* list : {&layer.crs, &layer.formats, &layer.styles, &layer.matrixSets})
      for (const std::string& text : *list)
        bytes += sizeof(std::string) + text.capacity();
    for (const auto* text :
         {&layer.name, &layer.title, &layer.abstract, &layer.times, &layer.defaultTime, &layer.attribution})
      bytes += text->capacity();
  }
  return bytes;
}

/// Counts of what became of the documents.
struct Outcome {
  int refused = 0;
  int listed = 0;
  int opened = 0;
};

void look(const std::string& path, std::mt19937_64& random, Outcome& outcome) {
  io::Resources resources{io::ResourceOptions{.offline = true}};
  ServiceLayer entry;
  entry.source = path;
  const auto offers = listService(entry, resources);
  if (!offers) {
    ++outcome.refused;
    EXPECT_GT(offers.error().message.size(), 10u) << offers.error().message;
    EXPECT_LT(offers.error().message.size(), 2000u);
    return;
  }
  ++outcome.listed;
  EXPECT_LE(bytesOf(*offers), std::size_t{64} << 20);
  if (offers->layers.empty()) return;
  const ServiceLayer& chosen = offers->layers[random() % offers->layers.size()].entry;
  for (const Kind kind : {Kind::imagery, Kind::elevation}) {
    const auto service = openService(chosen, kind, geo::earth(), resources);
    if (!service) {
      EXPECT_GT(service.error().message.size(), 10u) << service.error().message;
      continue;
    }
    ++outcome.opened;
    expectSoundGrid(*service);
  }
}

TEST(MutatedServices, areReadOrRefusedAndWhatOpensIsSound) {
  if (!haveSharedDocuments()) GTEST_SKIP() << "no shared data";
  constexpr std::size_t kLongest = 100'000;  // of a document that is damaged, so that many are
  constexpr int kRounds = 12;
  std::vector<std::string> documents;
  for (const auto& file : fs::recursive_directory_iterator(sharedDocument("")))
    if (file.path().extension() == ".xml" && file.file_size() < kLongest) documents.push_back(file.path());
  std::ranges::sort(documents);
  ASSERT_GT(documents.size(), 40u);
  auto random = geo::seededGenerator();
  const testing::ScratchFolder folder;
  const std::string path = folder.file("service.xml");
  Damage damage(random);
  Outcome outcome;
  for (int round = 0; round < kRounds; ++round) {
    for (const std::string& document : documents) {
      const std::string damaged = damage.to(textOf(document), textOf(documents[random() % documents.size()]));
      std::ofstream(path, std::ios::binary) << damaged;
      look(path, random, outcome);
      if (HasFailure()) {
        const std::string kept = (fs::temp_directory_path() / "tellurion_damaged_service.xml").string();
        std::ofstream(kept, std::ios::binary) << damaged;
        FAIL() << "of " << document << ", damaged in round " << round << "; it is kept as " << kept;
      }
    }
  }
  fmt::print("{} refused, {} listed, {} layers opened\n", outcome.refused, outcome.listed, outcome.opened);
  EXPECT_GT(outcome.refused, 10 * kRounds);
  EXPECT_GT(outcome.listed, 10 * kRounds) << "damage that is too deep tries nothing";
  EXPECT_GT(outcome.opened, 10 * kRounds);
}

}  // namespace
}  // namespace tellurion::raster
