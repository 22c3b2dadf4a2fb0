#include "raster/wms_service.h"

#include <fmt/format.h>

#include <random>

#include "raster/service_entry.h"
#include "raster/service_fixture_test.h"
#include "raster/xml_document.h"

namespace tellurion::raster {
namespace {

std::string document(const std::string& version, const std::string& layers, const std::string& service = {}) {
  const std::string root = version == "1.3.0" ? "WMS_Capabilities" : "WMT_MS_Capabilities";
  return fmt::format(
      "<{0} version='{1}'><Service><Title>T</Title>{3}</Service><Capability><Request><GetMap>"
      "<Format>image/jpeg</Format><Format>image/png</Format><Format>image/tiff</Format>"
      "<DCPType><HTTP><Get><OnlineResource href='http://h/map?m=1&amp;'/></Get></HTTP></DCPType></GetMap></Request>{2}"
      "</Capability></{0}>",
      root, version, layers, service);
}

WmsCapabilities parsed(const std::string& text) {
  const auto root = parseXml(std::as_bytes(std::span(text)), "doc");
  EXPECT_TRUE(root) << io::describe(root.error());
  const auto capabilities = parseWmsCapabilities(*root, "doc");
  EXPECT_TRUE(capabilities) << io::describe(capabilities.error());
  return capabilities.value_or(WmsCapabilities{});
}

io::Result<GridService> served(const std::string& text, const ServiceLayer& entry, Kind kind = Kind::imagery,
                               const geo::Body& body = geo::earth()) {
  return wmsService(parsed(text), entry, kind, body, "http://h/caps");
}

std::string layerA(const std::string& inside, const std::string& crs = "<CRS>EPSG:4326</CRS>") {
  return "<Layer><Name>a</Name>" + crs + inside + "</Layer>";
}

std::vector<double> boxOf(const std::string& url) {
  return parseNumbers(queryValue(url, "BBOX").value_or(""));
}

ServiceLayer entryOf(const std::string& layer) {
  ServiceLayer entry;
  entry.layer = layer;
  return entry;
}

TEST(WmsService, AsksInTheOrderOfTheVersionsAxes) {
  // 06-042, 6.7.4: in 1.3.0 EPSG:4326 has latitude first, CRS:84 longitude; before, all have longitude first.
  const auto old = served(document("1.1.1", layerA("", "<SRS>EPSG:4326</SRS>")), entryOf("a"));
  ASSERT_TRUE(old) << refusalOf(old);
  EXPECT_EQ(urlOf(*old, 0, 1, 0),
            "http://h/map?m=1&SERVICE=WMS&VERSION=1.1.1&REQUEST=GetMap&LAYERS=a&STYLES=&SRS=EPSG:4326&WIDTH=512&"
            "HEIGHT=512&FORMAT=image/png&TRANSPARENT=TRUE&BBOX=0,-90,180,90");
  const auto latitudeFirst = served(document("1.3.0", layerA("")), entryOf("a"));
  ASSERT_TRUE(latitudeFirst);
  EXPECT_EQ(urlOf(*latitudeFirst, 1, 0, 1),
            "http://h/map?m=1&SERVICE=WMS&VERSION=1.3.0&REQUEST=GetMap&LAYERS=a&STYLES=&CRS=EPSG:4326&WIDTH=512&"
            "HEIGHT=512&FORMAT=image/png&TRANSPARENT=TRUE&BBOX=-90,-180,0,-90");
  const auto longitudeFirst =
      served(document("1.3.0", layerA("", "<CRS>EPSG:4326</CRS><CRS>CRS:84</CRS>")), entryOf("a"));
  ASSERT_TRUE(longitudeFirst);
  EXPECT_EQ(queryValue(urlOf(*longitudeFirst, 0, 0, 0), "CRS"), "CRS:84");
  EXPECT_EQ(queryValue(urlOf(*longitudeFirst, 1, 0, 1), "BBOX"), "-180,-90,-90,0");
  const auto both = served(document("1.1.1", layerA("", "<SRS>CRS:84 EPSG:4326</SRS>")), entryOf("a"));
  ASSERT_TRUE(both);
  EXPECT_EQ(queryValue(urlOf(*both, 0, 0, 0), "SRS"), "EPSG:4326") << "MapServer lists CRS:84 in 1.1.1 and refuses it";
  // New Zealand's grid: northing first, by PROJ.
  const auto zealand = served(
      document("1.3.0",
               layerA("<BoundingBox CRS='EPSG:2193' minx='4700000' miny='1000000' maxx='6200000' maxy='2100000'/>",
                      "<CRS>EPSG:2193</CRS>")),
      entryOf("a"));
  ASSERT_TRUE(zealand) << refusalOf(zealand);
  EXPECT_EQ(zealand->plane.kind, MapPlane::Kind::other);
  EXPECT_EQ(queryValue(urlOf(*zealand, 0, 0, 0), "BBOX"), "4194304,0,6291456,2097152");
  expectSoundGrid(*zealand);
}

TEST(WmsService, EveryUserAsksForTheSameImages) {
  std::mt19937 random(20240607);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (int i = 0; i < 200; ++i) {
    const double west = -180.0 + 300.0 * share(random);
    const double south = -90.0 + 150.0 * share(random);
    const double east = west + 0.001 + (180.0 - west - 0.001) * share(random);
    const double north = south + 0.001 + (90.0 - south - 0.001) * share(random);
    const std::string box = fmt::format(
        "<EX_GeographicBoundingBox><westBoundLongitude>{}</westBoundLongitude><eastBoundLongitude>{}</"
        "eastBoundLongitude>"
        "<southBoundLatitude>{}</southBoundLatitude><northBoundLatitude>{}</northBoundLatitude></"
        "EX_GeographicBoundingBox>",
        west, east, south, north);
    const auto service = served(document("1.3.0", layerA(box, "<CRS>CRS:84</CRS>")), entryOf("a"));
    ASSERT_TRUE(service) << refusalOf(service);
    const int before = static_cast<int>(service->levels.size()) - 23;  // small maps of everything
    EXPECT_EQ(before, east - west >= 90.0 && north - south >= 45.0 ? 2 : 0);
    for (int level : {0, 3, 9, 22}) {
      const GridLevel& grid = service->levels[static_cast<std::size_t>(before + level)];
      const auto first = boxOf(urlOf(*service, before + level, grid.firstColumn, grid.firstRow));
      const auto last = boxOf(urlOf(*service, before + level, grid.endColumn - 1, grid.endRow - 1));
      ASSERT_EQ(first.size(), 4u);
      const double side = 180.0 / std::exp2(level);
      EXPECT_EQ(std::remainder(first[0], side), 0.0) << "multiples of the side, whatever the layer's box";
      EXPECT_EQ(first[2] - first[0], side);
      const double slack = side * 2e-6;
      EXPECT_LE(first[0], west + slack);
      EXPECT_GE(first[3], north - slack);
      EXPECT_GE(last[2], east - slack);
      EXPECT_LE(last[1], south + slack);
      EXPECT_GT(first[2], west - slack) << "and no image that the layer does not touch";
      EXPECT_LT(last[0], east + slack);
    }
  }
}

std::string boxed(double west, double south, double east, double north) {
  return fmt::format(
      "<EX_GeographicBoundingBox><westBoundLongitude>{}</westBoundLongitude><eastBoundLongitude>{}</eastBoundLongitude>"
      "<southBoundLatitude>{}</southBoundLatitude><northBoundLatitude>{}</northBoundLatitude>"
      "</EX_GeographicBoundingBox>",
      west, east, south, north);
}

TEST(WmsService, AWideLayerBeginsWithSmallMapsOfEverything) {
  for (const char* crs : {"CRS:84", "EPSG:3857"}) {
    const bool isSquare = std::string(crs) == "EPSG:3857";
    const std::string reference = fmt::format("<CRS>{}</CRS>", crs);
    const auto wide = served(document("1.3.0", layerA(boxed(-180, -80, 180, 80), reference)), entryOf("a"));
    ASSERT_TRUE(wide) << refusalOf(wide);
    expectSoundGrid(*wide);
    const std::string first = urlOf(*wide, 0, 0, 0);
    EXPECT_EQ(queryValue(first, "WIDTH"), "256");
    EXPECT_EQ(queryValue(first, "HEIGHT"), isSquare ? "256" : "128");
    const auto box = boxOf(first);
    ASSERT_EQ(box.size(), 4u);
    const double half = isSquare ? 20037508.342789244 : 180.0;
    EXPECT_NEAR(box[0], -half, 1e-6);
    EXPECT_NEAR(box[2], half, 1e-6);
    EXPECT_NEAR(box[3], isSquare ? half : 90.0, 1e-6);
    // From level to level pixels halve, also where the grid that all share begins.
    for (std::size_t i = 1; i < wide->levels.size(); ++i)
      EXPECT_EQ(wide->levels[i].pixelWidth, 0.5 * wide->levels[i - 1].pixelWidth);
    const int shared = isSquare ? 1 : 2;
    EXPECT_EQ(queryValue(urlOf(*wide, shared, 0, 0), "WIDTH"), "512");
    EXPECT_EQ(wide->levels[static_cast<std::size_t>(shared)].columns, isSquare ? 1 : 2);
    // Where it would not be worth its request, or not be given.
    EXPECT_EQ(
        queryValue(urlOf(*served(document("1.3.0", layerA(boxed(5, 45, 11, 48), reference)), entryOf("a")), 0, 0, 0),
                   "WIDTH"),
        "512");
    for (const char* limit : {"<MaxScaleDenominator>1e8</MaxScaleDenominator>"}) {
      const auto limited =
          served(document("1.3.0", layerA(boxed(-180, -80, 180, 80) + limit, reference)), entryOf("a"));
      ASSERT_TRUE(limited) << refusalOf(limited);
      EXPECT_EQ(limited->levels.front().imageWidth, 512);
    }
    ServiceLayer entry = entryOf("a");
    entry.minLevel = 0;
    const auto counted = served(document("1.3.0", layerA(boxed(-180, -80, 180, 80), reference)), entry);
    EXPECT_EQ(counted->levels.front().imageWidth, 512) << "min_level counts those of the grid";
  }
}

TEST(WmsService, LevelsKeepToTheScaleLimits) {
  // A pixel of 180/512 degrees at level 0; denominators count 0.28 mm and 111319.49 m a degree.
  const auto limited = served(
      document("1.3.0",
               layerA("<MinScaleDenominator>1000</MinScaleDenominator><MaxScaleDenominator>1e6</MaxScaleDenominator>")),
      entryOf("a"));
  ASSERT_TRUE(limited);
  for (const GridLevel& level : limited->levels) {
    const double denominator = level.pixelWidth * 111319.49079327357 / 0.00028;
    EXPECT_GE(denominator, 1000.0);
    EXPECT_LE(denominator, 1e6);
  }
  EXPECT_EQ(limited->levels.size(), 10u);  // 1e6 / 2^10 < 1000
  // 1.1.1: metres along the diagonal of a pixel.
  const auto hinted =
      served(document("1.1.1", layerA("<ScaleHint min='10' max='1000'/>", "<SRS>EPSG:4326</SRS>")), entryOf("a"));
  ASSERT_TRUE(hinted);
  EXPECT_LE(hinted->levels.front().pixelWidth * 111319.49 * std::sqrt(2.0), 1000.0);
  EXPECT_GE(hinted->levels.back().pixelWidth * 111319.5 * std::sqrt(2.0), 10.0);
  ServiceLayer entry = entryOf("a");
  entry.minLevel = 2;
  entry.maxLevel = 4;
  const auto bounded = served(document("1.3.0", layerA("")), entry);
  ASSERT_TRUE(bounded);
  EXPECT_EQ(bounded->levels.size(), 3u);
  EXPECT_EQ(queryValue(urlOf(*bounded, 0, 0, 0), "BBOX"), "45,-180,90,-135");
}

TEST(WmsService, TheEarthsMercatorOnMars) {
  const auto service =
      served(document("1.3.0", layerA("", "<CRS>EPSG:3857</CRS>")), entryOf("a"), Kind::imagery, geo::mars());
  ASSERT_TRUE(service) << refusalOf(service);
  EXPECT_NEAR(service->levels[0].left, -geo::kPi * 3396190.0, 1e-6) << "the plane is the body's";
  const auto box = boxOf(urlOf(*service, 0, 0, 0));
  ASSERT_EQ(box.size(), 4u);
  EXPECT_NEAR(box[0], -20037508.342789244, 1e-6) << "the server's is the Earth's";
  EXPECT_NEAR(box[3], 20037508.342789244, 1e-6);
}

TEST(WmsService, InheritsStylesReferencesDimensionsAndLimits) {
  const WmsCapabilities capabilities = parsed(
      document("1.3.0",
               "<Layer><Title>root</Title><CRS>CRS:84</CRS><Style><Name>s0</Name></Style>"
               "<Dimension name='time' units='ISO8601' default='2000'>1999,2000</Dimension>"
               "<Attribution><Title>all of us</Title></Attribution><MaxScaleDenominator>5</MaxScaleDenominator>"
               "<BoundingBox CRS='CRS:84' minx='0' miny='0' maxx='1' maxy='1'/>"
               "<Layer><Name>a</Name><CRS>EPSG:4326</CRS><Style><Name>s1</Name></Style><Style><Name>s0</Name></Style>"
               "<BoundingBox CRS='CRS:84' minx='0' miny='0' maxx='2' maxy='2'/></Layer>"
               "<Layer><Name>b</Name><Dimension name='TIME' units='ISO8601'>2001</Dimension></Layer></Layer>"));
  ASSERT_EQ(capabilities.layers.size(), 3u);
  const WmsLayer a = capabilities.withInherited(*capabilities.layer("a"));
  EXPECT_EQ(a.crs, (std::vector<std::string>{"EPSG:4326", "CRS:84"}));
  ASSERT_EQ(a.styles.size(), 2u);
  EXPECT_EQ(a.attribution, "all of us");
  EXPECT_EQ(a.maxScaleDenominator, 5.0);
  ASSERT_EQ(a.boxes.size(), 1u);
  EXPECT_EQ(a.boxes[0].values[2], 2.0);
  ASSERT_NE(a.dimension("time"), nullptr);
  EXPECT_EQ(a.dimension("time")->defaultValue, "2000");
  const WmsLayer b = capabilities.withInherited(*capabilities.layer("b"));
  EXPECT_EQ(b.dimension("time")->values, "2001");
  EXPECT_EQ(b.dimension("time")->defaultValue, "");
}

TEST(WmsService, TimesStylesAndFormats) {
  const std::string text = document(
      "1.3.0", layerA("<Style><Name>red</Name></Style><Dimension name='time' units='ISO8601'>2000-01-01/2001-01-01/P1D"
                      "</Dimension><Dimension name='elevation' units='m'>500,400</Dimension>"
                      "<Dimension name='run' units='' default='1'>1,2</Dimension>"));
  const auto last = served(text, entryOf("a"));
  ASSERT_TRUE(last);
  EXPECT_EQ(queryValue(urlOf(*last, 0, 0, 0), "TIME"), "2001-01-01") << "no default: the last";
  EXPECT_EQ(queryValue(urlOf(*last, 0, 0, 0), "ELEVATION"), "500");
  EXPECT_EQ(queryValue(urlOf(*last, 0, 0, 0), "DIM_RUN"), std::nullopt) << "the server has a default";
  ServiceLayer entry = entryOf("a");
  entry.time = "2000-06-01";
  entry.style = "red";
  entry.format = "image/jpg";
  const auto chosen = served(text, entry);
  ASSERT_TRUE(chosen) << refusalOf(chosen);
  const std::string url = urlOf(*chosen, 0, 0, 0);
  EXPECT_EQ(queryValue(url, "TIME"), "2000-06-01");
  EXPECT_EQ(queryValue(url, "STYLES"), "red");
  EXPECT_EQ(queryValue(url, "FORMAT"), "image/jpeg");
  EXPECT_EQ(queryValue(url, "TRANSPARENT"), "FALSE");
  EXPECT_NE(last->name, chosen->name) << "caches keep them apart";
  const auto heights = served(text, entryOf("a"), Kind::elevation);
  ASSERT_TRUE(heights);
  EXPECT_EQ(queryValue(urlOf(*heights, 0, 0, 0), "FORMAT"), "image/tiff");
  EXPECT_EQ(queryValue(urlOf(*heights, 0, 0, 0), "TRANSPARENT"), std::nullopt);
}

TEST(WmsService, SaysWhatThereIsInstead) {
  const std::string text = document(
      "1.3.0",
      layerA("<Style><Name>red</Name></Style><Dimension name='time' units='ISO8601'>2000/2001/P1D</Dimension>") +
          "<Layer><Name>blue marble</Name></Layer>");
  const auto told = [&](auto change) {
    ServiceLayer entry = entryOf("a");
    change(entry);
    return refusalOf(served(text, entry));
  };
  EXPECT_EQ(told([](auto& e) { e.layer = "bluemarble"; }),
            "there is no layer 'bluemarble'; did you mean 'blue marble'?");
  EXPECT_EQ(told([](auto& e) { e.layer = ""; }), "name a layer (layer, or URL#LAYER); there are a, blue marble");
  EXPECT_EQ(told([](auto& e) { e.layer = "a,x"; }), "there is no layer 'x'; there are a, blue marble");
  EXPECT_EQ(told([](auto& e) { e.style = "read"; }), "layer 'a' has no style 'read'; did you mean 'red'?");
  EXPECT_EQ(told([](auto& e) { e.format = "image/bmp"; }),
            "there is no format 'image/bmp'; there are image/jpeg, image/png, image/tiff");
  EXPECT_EQ(told([](auto& e) { e.crs = "EPSG:3031"; }), "layer 'a' is not offered in 'EPSG:3031'; there is EPSG:4326");
  EXPECT_EQ(told([](auto& e) { e.time = "1999"; }), "layer 'a' has no time 1999; it has 2000 to 2001 every P1D");
  EXPECT_EQ(told([](auto& e) { e.version = "1.0.0"; }),
            "maps are asked for in WMS 1.1.0, 1.1.1 and 1.3.0, not in '1.0.0'");
  EXPECT_EQ(told([](auto& e) { e.encoding = "terarium"; }),
            "there is no encoding 'terarium'; did you mean 'terrarium'?");
  EXPECT_EQ(told([](auto& e) { e.byteOrder = "middle"; }), "there is no byte order 'middle'; there are little and big");
}

std::string sizeOf(const std::string& url) {
  return queryValue(url, "WIDTH").value_or("") + "x" + queryValue(url, "HEIGHT").value_or("");
}

/// A layer with these attributes and its box in longitude and latitude, and as it is.
std::string limited(const std::string& attributes, const std::string& inside) {
  return "<Layer " + attributes + "><Name>a</Name>" + inside + "</Layer>";
}

TEST(WmsService, MapsThatAreOnlyGivenWholeAreAskedForWhole) {
  const std::string box =
      "<CRS>EPSG:4326</CRS><EX_GeographicBoundingBox><westBoundLongitude>-179.95</"
      "westBoundLongitude><eastBoundLongitude>"
      "179.95</eastBoundLongitude><southBoundLatitude>-60.1</southBoundLatitude><northBoundLatitude>75.3"
      "</northBoundLatitude></EX_GeographicBoundingBox>";
  const auto fixed =
      served(document("1.3.0", limited("noSubsets='1' fixedWidth='700' fixedHeight='300'", box)), entryOf("a"));
  ASSERT_TRUE(fixed) << io::describe(fixed.error());
  ASSERT_EQ(fixed->levels.size(), 1u);
  const GridLevel& level = fixed->levels[0];
  EXPECT_EQ(level.imageWidth, 700);
  EXPECT_EQ(level.imageHeight, 300);
  EXPECT_EQ(level.columns * level.rows, 1);
  EXPECT_DOUBLE_EQ(level.left + 700 * level.pixelWidth, 179.95);
  EXPECT_DOUBLE_EQ(level.top - 300 * level.pixelHeight, -60.1);
  const std::string url = urlOf(*fixed, 0, 0, 0);
  EXPECT_EQ(queryValue(url, "BBOX"), "-60.1,-179.95,75.3,179.95") << "to the digit, in the version's order";
  EXPECT_EQ(sizeOf(url), "700x300");

  // Of any size: as large as may be, in the shape of the box.
  const auto free = served(document("1.3.0", limited("noSubsets='1'", box), "<MaxWidth>2000</MaxWidth>"), entryOf("a"));
  ASSERT_TRUE(free);
  EXPECT_EQ(free->levels[0].imageWidth, 2000);
  EXPECT_NEAR(free->levels[0].imageHeight, 2000 * 135.4 / 359.9, 1.0);
  ServiceLayer small = entryOf("a");
  small.tilePixels = 256;
  EXPECT_EQ(served(document("1.3.0", limited("noSubsets='1'", box)), small)->levels[0].imageWidth, 256);

  // Its own box in the reference counts, not what we make of longitude and latitude.
  const auto mercator = served(document("1.3.0", limited("noSubsets='1'",
                                                         "<CRS>EPSG:3857</CRS><BoundingBox CRS='EPSG:3857' "
                                                         "minx='-1000' miny='2000' maxx='3000' maxy='6000'/>")),
                               entryOf("a"));
  ASSERT_TRUE(mercator);
  EXPECT_EQ(queryValue(urlOf(*mercator, 0, 0, 0), "BBOX"), "-1000,2000,3000,6000");
  EXPECT_NE(
      refusalOf(served(document("1.3.0", limited("noSubsets='1' fixedWidth='9000'", box)), entryOf("a"))).find("9000"),
      std::string::npos);
}

TEST(WmsService, MapsOfOneSizeAreAskedForInThatSize) {
  const auto found =
      served(document("1.3.0", limited("fixedWidth='400' fixedHeight='200'", "<CRS>EPSG:4326</CRS>")), entryOf("a"));
  ASSERT_TRUE(found);
  for (int i = 0; i < 3; ++i) {
    const GridLevel& level = found->levels[static_cast<std::size_t>(i)];
    EXPECT_DOUBLE_EQ(level.pixelWidth * level.imageWidth, std::ldexp(180.0, -i));
    EXPECT_DOUBLE_EQ(level.pixelHeight * level.imageHeight, std::ldexp(180.0, -i));
    EXPECT_EQ(sizeOf(urlOf(*found, i, 0, 0)), "400x200");
  }
}

TEST(WmsService, GifIsTheLastResort) {
  const auto formatOf = [](const std::string& formats, Kind kind, const std::string& encoding = {}) {
    ServiceLayer entry;
    entry.encoding = encoding;
    std::vector<std::string> offered;
    for (std::size_t at = 0; at < formats.size(); at = formats.find(' ', at) + 1) {
      offered.push_back(formats.substr(at, formats.find(' ', at) - at));
      if (formats.find(' ', at) == formats.npos) break;
    }
    return chooseFormat(entry, kind, offered).value_or("none");
  };
  EXPECT_EQ(formatOf("image/gif image/jpeg", Kind::imagery), "image/jpeg");
  EXPECT_EQ(formatOf("image/gif image/svg+xml", Kind::imagery), "image/gif");
  EXPECT_EQ(formatOf("image/gif image/png", Kind::imagery), "image/png");
  EXPECT_EQ(formatOf("image/gif image/jpeg", Kind::elevation), "none");
  EXPECT_EQ(formatOf("image/gif image/png8", Kind::elevation, "terrarium"), "none") << "256 colours are no heights";
  EXPECT_EQ(formatOf("image/png8 image/png", Kind::elevation, "mapbox"), "image/png");
  EXPECT_EQ(formatOf("image/bil image/jpeg", Kind::elevation), "image/bil");
}

TEST(WmsService, SmallServersGetSmallImages) {
  const auto small =
      served(document("1.3.0", layerA(""), "<MaxWidth>400</MaxWidth><MaxHeight>300</MaxHeight>"), entryOf("a"));
  ASSERT_TRUE(small);
  EXPECT_EQ(small->levels[0].imageWidth, 256);
  EXPECT_EQ(queryValue(urlOf(*small, 0, 0, 0), "WIDTH"), "256");
}

TEST(WmsService, EveryNamedLayerOfEveryDocumentOpens) {
  if (!haveSharedDocuments()) GTEST_SKIP() << "no shared data";
  int layers = 0;
  for (const auto& file : std::filesystem::directory_iterator(sharedDocument("wms"))) {
    io::Resources resources{io::ResourceOptions{}};
    const std::string name = file.path().filename();
    if (name.find("wms100") == 0 || name.find("huge") != name.npos) continue;
    ServiceLayer entry;
    entry.source = file.path();
    entry.layer = "there is no such layer";
    EXPECT_NE(refusal(entry).find("there is no layer"), std::string::npos) << refusal(entry);
    for (const char* known : {"wms130_ogc_sample.xml:Clouds", "wms111_nasa_jpl_onearth.xml:BMNG",
                              "wms130_mapserver_mesonet_bom.xml:nexrad_base_reflect",
                              "wms130_root_crs_inheritance.xml:", "wms130_esri_arcgis.xml:0"}) {
      const std::string_view text = known;
      if (text.substr(0, text.find(':')) != name || text.ends_with(':')) continue;
      entry.layer = text.substr(text.find(':') + 1);
      expectSoundGrid(opened(entry));
      ++layers;
    }
  }
  EXPECT_EQ(layers, 4);
}

}  // namespace
}  // namespace tellurion::raster
