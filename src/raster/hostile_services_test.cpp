#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <unordered_set>

#include "geo/seed_test.h"
#include "raster/raster_fixture_test.h"
#include "raster/service_fixture_test.h"
#include "raster/service_offers.h"
#include "raster/wms_capabilities.h"

// Documents that are well-formed and mean harm: each has a limit, or costs no more than its length.
namespace tellurion::raster {
namespace {

std::string repeated(int count, const auto& part) {
  std::string text;
  for (int i = 0; i < count; ++i)
    text += part(i);
  return text;
}

io::Result<ServiceOffers> listed(const std::string& document) {
  const testing::ScratchFolder folder;
  const std::string path = folder.file("service.xml");
  std::ofstream(path) << document;
  io::Resources resources{io::ResourceOptions{}};
  ServiceLayer entry;
  entry.source = path;
  return listService(entry, resources);
}

std::string messageOf(const io::Result<ServiceOffers>& offers) {
  return offers ? fmt::format("{} layers", offers->layers.size()) : io::describe(offers.error());
}

std::string wms(const std::string& layers) {
  return "<WMS_Capabilities version='1.3.0'><Capability>" + layers + "</Capability></WMS_Capabilities>";
}

std::string wmts(const std::string& contents) {
  return "<Capabilities><Contents>" + contents + "</Contents></Capabilities>";
}

std::size_t bytesOf(const ServiceOffers& offers) {
  std::size_t bytes = offers.layers.capacity() * sizeof(LayerOffer);
  for (const LayerOffer& layer : offers.layers)
    for (const auto* list : {&layer.crs, &layer.formats, &layer.styles, &layer.matrixSets})
      bytes += list->capacity() * sizeof(std::string);
  return bytes;
}

TEST(HostileServices, aLongListAtTheRootIsNotCopiedIntoEveryLayer) {
  const auto offers = listed(
      wms("<Layer>" + repeated(8000, [](int i) { return fmt::format("<CRS>EPSG:{}</CRS>", 20000 + i); }) +
          repeated(19000, [](int i) { return fmt::format("<Layer><Name>l{}</Name></Layer>", i); }) + "</Layer>"));
  ASSERT_TRUE(offers) << messageOf(offers);
  ASSERT_EQ(offers->layers.size(), 19001u);
  EXPECT_EQ(offers->layers.back().crsCount, 8000u);
  EXPECT_LT(bytesOf(*offers), std::size_t{80} << 20) << "what they keep, used or not";
}

TEST(HostileServices, whatIsListedOfALayerIsWhatItInherits) {
  // Against the definition: the lists of a layer and all around it, each name once, the nearest first.
  auto random = geo::seededGenerator();
  for (int round = 0; round < 100; ++round) {
    std::string layers;
    int depth = 0;
    for (int i = 0; i < 40; ++i) {
      while (depth > 0 && geo::uniform(random, 0.0, 1.0) < 0.4) {
        layers += "</Layer>";
        --depth;
      }
      layers += fmt::format("<Layer><Name>l{}</Name>", i) +
                repeated(static_cast<int>(geo::uniform(random, 0.0, 12.0)), [&](int) {
                  return fmt::format("<CRS>EPSG:{}</CRS><Style><Name>s{}</Name></Style>",
                                     3850 + static_cast<int>(geo::uniform(random, 0.0, 90.0)),
                                     static_cast<int>(geo::uniform(random, 0.0, 90.0)));
                });
      ++depth;
    }
    for (; depth > 0; --depth)
      layers += "</Layer>";
    const std::string document = wms(layers);
    const auto root = parseXml(std::as_bytes(std::span(document)), "doc");
    ASSERT_TRUE(root);
    const auto capabilities = parseWmsCapabilities(*root, "doc");
    ASSERT_TRUE(capabilities);
    const auto offers = listed(document);
    ASSERT_TRUE(offers) << messageOf(offers);
    ASSERT_EQ(offers->layers.size(), capabilities->layers.size());
    for (std::size_t i = 0; i < offers->layers.size(); ++i) {
      const WmsLayer& layer = capabilities->layers[i];
      std::vector<std::string> crs;
      std::vector<std::string> styles;
      for (const WmsLayer* each = &layer; each != nullptr;
           each = each->parent < 0 ? nullptr : &capabilities->layers[static_cast<std::size_t>(each->parent)]) {
        for (const std::string& one : each->crs)
          if (std::ranges::find(crs, one) == crs.end()) crs.push_back(one);
        for (const WmsStyle& one : each->styles)
          if (each == &layer || std::ranges::find(styles, one.name) == styles.end()) styles.push_back(one.name);
      }
      const WmsLayer whole = capabilities->withInherited(layer);
      EXPECT_EQ(whole.crs, crs);
      ASSERT_EQ(whole.styles.size(), styles.size());
      for (std::size_t k = 0; k < styles.size(); ++k)
        EXPECT_EQ(whole.styles[k].name, styles[k]);
      EXPECT_EQ(offers->layers[i].crsCount, crs.size());
      EXPECT_EQ(offers->layers[i].styleCount, std::unordered_set<std::string>(styles.begin(), styles.end()).size());
      std::ranges::stable_sort(crs, {}, [](const std::string& name) { return name == "EPSG:3857" ? 0 : 1; });
      crs.resize(std::min<std::size_t>(64, crs.size()));
      EXPECT_EQ(offers->layers[i].crs, crs);
    }
  }
}

TEST(HostileServices, listsAreBoundedInAll) {
  const auto nested = [](int layers, int boxes) {
    return wms(repeated(layers,
                        [&](int i) {
                          return fmt::format("<Layer><Name>l{}</Name>", i) +
                                 repeated(boxes, [&](int k) { return fmt::format("<CRS>X:{}_{}</CRS>", i, k); });
                        }) +
               repeated(layers, [](int) { return "</Layer>"; }));
  };
  const auto deep = listed(nested(60, 4000));
  ASSERT_TRUE(deep) << messageOf(deep);
  EXPECT_EQ(deep->layers.back().crsCount, 240'000u);
  EXPECT_NE(messageOf(listed(nested(64, 4000))).find("more than 250000 styles, references, boxes and dimensions"),
            std::string::npos);
  EXPECT_NE(messageOf(listed(nested(1, 9000))).find("more than 8192 parts"), std::string::npos);
  const auto words =
      listed(wms("<Layer><CRS>" + repeated(9000, [](int i) { return fmt::format("X:{} ", i); }) + "</CRS></Layer>"));
  EXPECT_NE(messageOf(words).find("more than 8192 parts"), std::string::npos) << messageOf(words);
  const auto dimensions =
      listed(wms("<Layer>" + repeated(65, [](int i) { return fmt::format("<Dimension name='d{}'>1</Dimension>", i); }) +
                 "</Layer>"));
  EXPECT_NE(messageOf(dimensions).find("64 dimensions"), std::string::npos) << messageOf(dimensions);
  const auto wide = listed(wms("<Layer>" + repeated(64, [](int i) { return fmt::format("<CRS>X:{:0150}</CRS>", i); }) +
                               repeated(15000, [](int) { return "<Layer/>"; }) + "</Layer>"));
  EXPECT_NE(messageOf(wide).find("offer more than can be listed"), std::string::npos) << messageOf(wide);
}

TEST(HostileServices, longTextsAreNotHandedDown) {
  const auto offers = listed(wms("<Layer><Dimension name='time' default='" + std::string(100'000, '1') + "'>" +
                                 std::string(100'000, '2') + "</Dimension>" +
                                 repeated(1000, [](int) { return "<Layer/>"; }) + "</Layer>"));
  ASSERT_TRUE(offers) << messageOf(offers);
  for (const LayerOffer& layer : offers->layers) {
    EXPECT_FALSE(layer.times.empty());
    EXPECT_LT(layer.times.size() + layer.defaultTime.size(), 1000u);
  }
}

TEST(HostileServices, tileServicesHaveLimits) {
  const auto maps = [](int count) {
    return "<TileMapService><TileMaps>" +
           repeated(count,
                    [](int i) {
                      return fmt::format("<TileMap title='t{}' srs='EPSG:3857' href='http://h/{}/g'/>", i / 2, i);
                    }) +
           "</TileMaps></TileMapService>";
  };
  const auto all = listed(maps(20'000));
  ASSERT_TRUE(all) << messageOf(all);
  EXPECT_EQ(all->layers[7].name, "7/g") << "two have its title";
  EXPECT_NE(messageOf(listed(maps(20'001))).find("more than 20000 tile maps"), std::string::npos);
  const auto sets = [](int links, int count) {
    return wmts("<Layer>" +
                repeated(links,
                         [](int i) {
                           return fmt::format(
                               "<TileMatrixSetLink><TileMatrixSet>s{}</TileMatrixSet></TileMatrixSetLink>", i);
                         }) +
                "</Layer>" + repeated(count, [](int i) {
                  return fmt::format(
                      "<TileMatrixSet><Identifier>s{}</Identifier><SupportedCRS>EPSG:{}</SupportedCRS>"
                      "</TileMatrixSet>",
                      i, i);
                }));
  };
  const auto many = listed(sets(4096, 4096));
  ASSERT_TRUE(many) << messageOf(many);
  EXPECT_EQ(many->layers[0].crsCount, 4094u) << "3587, 3785 and 3857 are one";
  EXPECT_LE(many->layers[0].matrixSets.size(), 64u);
  EXPECT_NE(messageOf(listed(sets(4097, 1))).find("more than 4096 parts"), std::string::npos);
  EXPECT_NE(messageOf(listed(sets(1, 4097))).find("more than 4096 tile matrix sets"), std::string::npos);
}

}  // namespace
}  // namespace tellurion::raster
