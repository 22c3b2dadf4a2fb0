#include "raster/service_url.h"

#include <gtest/gtest.h>

#include "raster/near_names.h"
#include "raster/time_extent.h"
#include "raster/url_template.h"

namespace tellurion::raster {
namespace {

TEST(ServiceUrl, QueryKeepsWhatIsThereAndReplacesItsOwnKeys) {
  EXPECT_EQ(withQuery("http://h/wms", {{"A", "1"}}), "http://h/wms?A=1");
  EXPECT_EQ(withQuery("http://h/wms?", {{"A", "1"}}), "http://h/wms?A=1");
  EXPECT_EQ(withQuery("http://h/wms?map=/x.map&", {{"A", "1"}}), "http://h/wms?map=/x.map&A=1");
  EXPECT_EQ(withQuery("http://h/wms?request=GetCapabilities&k=v#f", {{"REQUEST", "GetMap"}}),
            "http://h/wms?k=v&REQUEST=GetMap");
  EXPECT_EQ(withQuery("http://h/", {{"LAYERS", "a b,c&d:é"}}), "http://h/?LAYERS=a%20b,c%26d:%C3%A9");
  EXPECT_EQ(queryValue("http://h/?Service=W%20MS&x", "SERVICE"), "W MS");
  EXPECT_EQ(queryValue("http://h/?x", "X"), "");
  EXPECT_EQ(queryValue("http://h/?x", "y"), std::nullopt);
}

TEST(ServiceUrl, SecretsStayOutOfWhatIsShown) {
  EXPECT_EQ(withoutSecrets("https://me:pass@h:80/a?b=c"), "https://h:80/a?b=c");
  EXPECT_EQ(withoutSecrets("https://me:p@ss@h/a"), "https://h/a");
  EXPECT_EQ(withoutSecrets("https://h/a@b?x=1&access_token=abc&apiKey=def&SIG=x"),
            "https://h/a@b?x=1&access_token=***&apiKey=***&SIG=***");
  EXPECT_EQ(withoutSecrets("folder/{z}/{x}/{y}.png"), "folder/{z}/{x}/{y}.png");
}

TEST(ServiceUrl, CredentialsGoToTheSameHostOnly) {
  const char* source = "http://me:pw@h/wms?token=t&map=m";
  EXPECT_EQ(withCredentialsOf(source, "http://h/other?"), "http://me:pw@h/other?token=t");
  EXPECT_EQ(withCredentialsOf(source, "http://h/other?a=b"), "http://me:pw@h/other?a=b&token=t");
  EXPECT_EQ(withCredentialsOf(source, "http://h/other?Token=u"), "http://me:pw@h/other?Token=u");
  EXPECT_EQ(withCredentialsOf(source, "http://evil/other"), "http://evil/other");
  EXPECT_EQ(withCredentialsOf(source, "http://h.evil/other"), "http://h.evil/other");
  const char* safe = "https://me:pw@h/wms?token=t";
  EXPECT_EQ(withCredentialsOf(safe, "HTTPS://H/other?"), "HTTPS://me:pw@H/other?token=t");
  EXPECT_EQ(withCredentialsOf(source, "https://h/other?"), "https://me:pw@h/other?token=t");
  for (const char* inClear : {"http://h/other", "HTTP://h/other?a=b", "ftp://h/other"})
    EXPECT_EQ(withCredentialsOf(safe, inClear), inClear);
  EXPECT_EQ(withCredentialsOf("capabilities.xml", "http://h/wms"), "http://h/wms");
}

TEST(ServiceUrl, ReferencesAreResolved) {
  EXPECT_EQ(resolvedUrl("http://h/a/b.xml?q", "c"), "http://h/a/c");
  EXPECT_EQ(resolvedUrl("http://h/a/b.xml", "/c/d"), "http://h/c/d");
  EXPECT_EQ(resolvedUrl("http://h", "c"), "http://h/c");
  EXPECT_EQ(resolvedUrl("https://h/a", "//o/c"), "https://o/c");
  EXPECT_EQ(resolvedUrl("http://h/a", "http://o/c"), "http://o/c");
  EXPECT_EQ(resolvedUrl("file:///a/b.xml", "0"), "file:///a/0");
}

TEST(ServiceUrl, LocalPaths) {
  EXPECT_EQ(localPath("file:///a%20b/c"), "/a b/c");
  EXPECT_EQ(localPath("a/b"), "a/b");
  EXPECT_EQ(localPath("http://h/a"), std::nullopt);
  EXPECT_EQ(fileUrl("/a b/{z}/../{x}"), "file:///a%20b/{x}");
  for (const char* path : {"/a b/%41", "/é/ü?#&"})
    EXPECT_EQ(localPath(fileUrl(path)), path);
}

TEST(UrlTemplate, FillsNamesWhateverTheirCapitals) {
  const UrlTemplate url("http://h/{Z}/{x}/{-y}.png{");
  EXPECT_TRUE(url.has("z"));
  EXPECT_FALSE(url.has("y"));
  EXPECT_EQ(url.filled([](std::string_view name) { return "<" + std::string(name) + ">"; }),
            "http://h/<z>/<x>/<-y>.png{");
}

TEST(NearNames, FindsWhatWasMeant) {
  const std::vector<std::string> names = {"bluemarble", "dem", "roads", "topp:states"};
  EXPECT_EQ(editDistance("kitten", "sitting"), 3u);
  EXPECT_EQ(editDistance("", "abc"), 3u);
  EXPECT_EQ(nearNames("blue_marble", names, 3), std::vector<std::string>{"bluemarble"});
  EXPECT_EQ(nearNames("states", names, 3), std::vector<std::string>{"topp:states"});
  EXPECT_EQ(whatElseThereIs("DEN", names), "; did you mean 'dem'?");
  EXPECT_EQ(whatElseThereIs("xyz", names), "; there are bluemarble, dem, roads, topp:states");
  EXPECT_EQ(whatElseThereIs("x", {}), "; there is none");
}

TEST(TimeExtent, InstantsOfEveryPrecision) {
  EXPECT_EQ(secondsOfTime("1970"), 0.0);
  EXPECT_EQ(secondsOfTime("1970-01-02"), 86400.0);
  EXPECT_EQ(secondsOfTime("2000-02-29T12:00:00.5Z"), 951825600.5);
  EXPECT_EQ(secondsOfTime("20000229T12Z"), 951825600.0);
  EXPECT_EQ(secondsOfTime("2000-02-29T14:00:00+02:00"), 951825600.0);
  for (const char* wrong : {"", "current", "2001-02-29", "2000-13", "2000-01-01T25", "2000-01-01x", "20", "-2000"})
    EXPECT_EQ(secondsOfTime(wrong), std::nullopt) << wrong;
}

TEST(TimeExtent, ListsAndSpans) {
  const auto extent = parseTimeExtent(" 1999-01-01 , 2000-01-01/2000-12-31/P1D,,\n");
  ASSERT_EQ(extent.size(), 2u);
  EXPECT_EQ(extent[0].start, "1999-01-01");
  EXPECT_EQ(extent[1].period, "P1D");
  EXPECT_TRUE(offersTime(extent, "1999"));
  EXPECT_TRUE(offersTime(extent, "2000-06-01T00:00:00Z"));
  EXPECT_FALSE(offersTime(extent, "1999-06-01"));
  EXPECT_FALSE(offersTime(extent, "2001-01-01"));
  EXPECT_TRUE(offersTime(extent, "current"));
  EXPECT_EQ(lastTime(extent), "2000-12-31");
  EXPECT_EQ(describeTimes(extent), "2 spans of time, 1999-01-01 to 2000-12-31");
  EXPECT_EQ(describeTimes(std::span(extent).subspan(1)), "2000-01-01 to 2000-12-31 every P1D");
}

}  // namespace
}  // namespace tellurion::raster
