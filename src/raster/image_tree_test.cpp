#include "raster/image_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "geo/seed_test.h"

namespace tellurion::raster {
namespace {

using geo::Angle;

constexpr std::array kSchemes{tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix};

geo::Direction anywhere(std::mt19937_64& random) {
  const double z = geo::uniform(random, -1.0, 1.0);
  const double lon = geo::uniform(random, -180.0, 180.0);
  return geo::directionFromLatLon(Angle::radians(std::asin(z)), Angle::degrees(lon));
}

/// From a few metres to half a planet, anywhere, some at the poles and some across the date line.
PlacedImage anyImage(std::mt19937_64& random) {
  const double height = 90.0 * std::pow(10.0, geo::uniform(random, -7.0, 0.0));
  const auto place = geo::geodeticFromDirection(anywhere(random));
  const double south = std::clamp(place.lat.degrees() - 0.5 * height, -90.0, 90.0);
  const double north = std::clamp(place.lat.degrees() + 0.5 * height, -90.0, 90.0);
  const double widest = height / std::max(std::cos(place.lat.radians()), 1e-3);
  const double west = place.lon.degrees();
  PlacedImage image{.bounds = geo::GeoRect::fromDegrees(south, west, north, west + std::min(widest, 360.0))};
  image.cap = capAround(image.bounds);
  image.deepestLevel = static_cast<int>(random() % 25);
  return image;
}

TEST(ImageTree, CapsHoldTheirRectangles) {
  auto random = geo::seededGenerator();
  for (int i = 0; i < 3000; ++i) {
    const PlacedImage image = anyImage(random);
    const Angle lat = image.bounds.south + (image.bounds.north - image.bounds.south) * geo::uniform(random, 0.0, 1.0);
    const Angle lon = image.bounds.west + image.bounds.width * geo::uniform(random, 0.0, 1.0);
    EXPECT_LE(geo::angleBetween(image.cap.centre, geo::directionFromLatLon(lat, lon)).radians(),
              image.cap.radius.radians() + 1e-12);
  }
}

TEST(ImageTree, FindsWhatALookAtEveryImageFinds) {
  auto random = geo::seededGenerator();
  for (const tiling::Scheme scheme : kSchemes) {
    const tiling::Tiling tiling(scheme);
    ImageTree tree(scheme);
    for (int i = 0; i < 3000; ++i)
      tree.insert(anyImage(random));
    std::size_t found = 0;
    for (int i = 0; i < 300; ++i) {
      const int level = static_cast<int>(random() % 24);
      // Half of them where an image is, for deep tiles elsewhere are all alike.
      const geo::Direction place =
          i % 2 == 0 ? anywhere(random) : tree.image(static_cast<int>(random() % tree.size())).cap.centre;
      const tiling::TileId id = tiling.tileAt(place, level);
      const tiling::Cap cap = tiling.cap(id);
      const Angle least = tiling.metrics(level).meanEdge / 16.0;
      std::vector<int> expected;
      bool isTouched = false;
      for (int k = 0; k < static_cast<int>(tree.size()); ++k) {
        const PlacedImage& image = tree.image(k);
        if (geo::angleBetween(cap.centre, image.cap.centre) > cap.radius * 1.05 + image.cap.radius) continue;
        if (image.cap.radius * 2.0 >= least) expected.push_back(k);
        isTouched = isTouched || (image.deepestLevel >= level && image.bounds.intersects(tiling.bounds(id)));
      }
      std::vector<int> got = tree.touching(id, least);
      std::ranges::sort(got);
      EXPECT_EQ(got, expected) << tiling::nameOf(scheme) << " level " << level;
      EXPECT_EQ(tree.isTouched(id, level), isTouched);
      found += got.size();
    }
    EXPECT_GT(found, 1000u);
  }
}

}  // namespace
}  // namespace tellurion::raster
