#include "raster/map_reference.h"

#include <gtest/gtest.h>

#include <vector>

namespace tellurion::raster {
namespace {

using References = std::vector<std::string>;

std::string bodyOf(const References& references) {
  const auto body = bodyOfReferences(references);
  return body ? body->name : "";
}

TEST(MapReference, TheIausCodesTellTheBody) {
  EXPECT_EQ(bodyOf({"EPSG:4326", "IAU_2015:49900"}), "mars");
  EXPECT_EQ(bodyOf({"IAU2000:49910", "IAU2000:49911"}), "mars");
  EXPECT_EQ(bodyOf({"urn:ogc:def:crs:IAU:2015:30100"}), "moon");
  EXPECT_EQ(bodyOf({"http://www.opengis.net/def/crs/IAU/2015/30135"}), "moon");
  EXPECT_EQ(bodyOf({"IAU_2015:39900"}), "earth");
  for (const References& silent : {References{}, References{"EPSG:4326", "CRS:84"}, References{"IAU_2015:19900"},
                                   References{"IAU_2015:49900", "IAU_2015:30100"}, References{"IAU_2015:"},
                                   References{"IAU:mars"}, References{"IAU_2015:99999999999999999999"}})
    EXPECT_EQ(bodyOf(silent), "") << (silent.empty() ? "" : silent.front());
}

}  // namespace
}  // namespace tellurion::raster
