// The tilings against programs of others: the HEALPix C library, and PROJ's s2, healpix and eqc projections on the unit
// sphere.
#include <chealpix.h>
#include <gtest/gtest.h>
#include <proj.h>

#include <limits>
#include <memory>

#include "tiling/healpix_pixels.h"
#include "tiling/places_test.h"

namespace tellurion::tiling {
namespace {

struct ContextDeleter {
  void operator()(PJ_CONTEXT* c) const { proj_context_destroy(c); }
};
struct ProjectionDeleter {
  void operator()(PJ* p) const { proj_destroy(p); }
};

class Projection {
 public:
  explicit Projection(const std::string& definition)
      : context_(proj_context_create()), projection_(proj_create(context_.get(), definition.c_str())) {}
  bool valid() const { return projection_ != nullptr; }
  geo::Vec2 at(const geo::Direction& d) const {
    const geo::Geodetic g = geo::geodeticFromDirection(d);
    const PJ_COORD out = proj_trans(projection_.get(), PJ_FWD, proj_coord(g.lon.radians(), g.lat.radians(), 0.0, 0.0));
    return geo::Vec2(out.xy.x, out.xy.y);
  }

 private:
  std::unique_ptr<PJ_CONTEXT, ContextDeleter> context_;
  std::unique_ptr<PJ, ProjectionDeleter> projection_;
};

geo::Vec3 normalized(const double* v) {
  return geo::normalize(geo::Vec3(v[0], v[1], v[2]));
}

TEST(HealpixReference, PixelCentresOfAllOrders) {
  auto random = geo::seededGenerator();
  const Tiling tiling(Scheme::healpix);
  for (int order = 0; order <= kMaxLevel; ++order) {
    const std::uint64_t pixels = std::uint64_t{12} << (2 * order);
    const int count = pixels < 3000 ? static_cast<int>(pixels) : 3000;
    for (int i = 0; i < count; ++i) {
      const std::uint64_t pixel = pixels < 3000 ? static_cast<std::uint64_t>(i) : random() % pixels;
      double centre[3];
      pix2vec_nest64(std::int64_t{1} << order, static_cast<std::int64_t>(pixel), centre);
      const TileId id = tileFromHealpixNested(order, pixel);
      ASSERT_EQ(healpixNested(id), pixel);
      const geo::Direction ours = tiling.direction(rootPointIn(id, 0.5, 0.5));
      ASSERT_LT(geo::angleBetween(ours, {normalized(centre)}).radians(), 4e-15) << order << " " << pixel;
    }
  }
}

TEST(HealpixReference, PixelOfADirectionAtAllOrders) {
  auto random = geo::seededGenerator();
  const Tiling tiling(Scheme::healpix);
  int elsewhere = 0;
  for (int order = 0; order <= kMaxLevel; ++order) {
    for (int i = 0; i < 10000; ++i) {
      geo::Direction d = randomDirection(random);
      if (i % 5 == 0)
        d = geo::directionFromDegrees(90.0 - std::exp(geo::uniform(random, -25.0, 3.0)),
                                      geo::uniform(random, 0.0, 360.0));
      const TileId ours = tiling.tileAt(d, order);
      std::int64_t theirs = 0;
      vec2pix_nest64(std::int64_t{1} << order, &d.n.x, &theirs);
      if (healpixNested(ours) == static_cast<std::uint64_t>(theirs)) continue;
      // Within rounding of a border both are right: theirs must hold the direction up to that.
      const Cap cap = tiling.cap(tileFromHealpixNested(order, static_cast<std::uint64_t>(theirs)));
      ASSERT_LT(geo::angleBetween(cap.centre, d).radians(), cap.radius.radians() + 4e-15) << order;
      ++elsewhere;
    }
  }
  EXPECT_LE(elsewhere, 10);
}

// Batches are the same to the last bit as what they are batches of, and so as exact as that.
TEST(HealpixReference, BatchesAreWhatPlacesAreOneByOne) {
  auto random = geo::seededGenerator();
  const Tiling tiling(Scheme::healpix);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<geo::Direction> places{
      {geo::Vec3(nan, 0.0, 1.0)}, {geo::Vec3(0.0, nan, 1.0)}, {geo::Vec3(1.0, 0.0, nan)}};
  for (int octant = -8; octant <= 8; ++octant) {
    for (const double lat : {-90.0, -geo::kPi, -1e-14, 0.0, 1e-300, 41.810314895778596, 66.4, 90.0 - 1e-13, 90.0})
      places.push_back(geo::directionFromDegrees(lat, 22.5 * octant));
  }
  while (places.size() < 5000)
    places.push_back(randomDirection(random));
  for (const int order : {0, 1, 7, 20, kMaxLevel}) {
    // Corners and middles of sides of pixels, where other pixels begin.
    std::vector<geo::Direction> all = places;
    for (int i = 0; i < 1000; ++i) {
      const TileId id = tiling.tileAt(randomDirection(random), order);
      all.push_back(tiling.direction(rootPointIn(id, 0.5 * static_cast<double>(randomBelow(random, 3)),
                                                 0.5 * static_cast<double>(randomBelow(random, 3)))));
    }
    std::vector<std::uint64_t> pixels(all.size());
    healpixNestedAt(all, order, pixels);
    for (std::size_t i = 0; i < all.size(); ++i) {
      ASSERT_LT(pixels[i], std::uint64_t{12} << (2 * order));
      ASSERT_EQ(pixels[i], healpixNestedAt(all[i], order)) << order << " " << i;
      ASSERT_EQ(pixels[i], healpixNested(tiling.tileAt(all[i], order))) << order << " " << i;
    }
    std::vector<geo::Direction> centres(pixels.size());
    healpixCentres(pixels, order, centres);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      ASSERT_EQ(centres[i], healpixCentre(pixels[i], order));
      ASSERT_EQ(centres[i], tiling.direction(rootPointIn(tileFromHealpixNested(order, pixels[i]), 0.5, 0.5)));
      ASSERT_EQ(healpixNestedAt(centres[i], order), pixels[i]) << order;
    }
  }
}

TEST(HealpixReference, EveryPixelOfTheLowOrdersIsATileOnce) {
  const Tiling tiling(Scheme::healpix);
  for (int order = 0; order <= 4; ++order) {
    std::vector<bool> seen(std::size_t{12} << (2 * order));
    for (const TileId& id : allTiles(tiling, order)) {
      const std::uint64_t pixel = healpixNested(id);
      ASSERT_LT(pixel, seen.size());
      ASSERT_FALSE(seen[pixel]);
      seen[pixel] = true;
      ASSERT_EQ(tileFromHealpixNested(order, pixel), id);
    }
  }
}

TEST(HealpixReference, ProjsPlane) {
  const Projection projection("+proj=healpix +R=1 +lon_0=0");
  ASSERT_TRUE(projection.valid());
  auto random = geo::seededGenerator();
  const Tiling tiling(Scheme::healpix);
  for (int i = 0; i < 100000; ++i) {
    const int root = static_cast<int>(randomBelow(random, 12));
    const RootPoint p{root, geo::uniform(random, 0.0, 1.0), geo::uniform(random, 0.0, 1.0)};
    const geo::Vec2 xy = projection.at(tiling.direction(p));
    const double middle = 2.0 * (root % 4) + (root / 4 == 1 ? 0.0 : 1.0);
    const double x = geo::kPi / 4.0 * (middle + p.u - p.v);
    const double y = geo::kPi / 4.0 * (2.0 - root / 4 - p.u - p.v);
    ASSERT_NEAR(std::remainder(xy.x - x, 2.0 * geo::kPi), 0.0, 1e-12) << root << " " << p.u << " " << p.v;
    ASSERT_NEAR(xy.y, y, 1e-12) << root << " " << p.u << " " << p.v;
  }
}

TEST(CubeReference, ProjsS2WithTheTangentMapping) {
  struct Face {
    const char* centre;
    geo::Vec2 (*proj)(double u, double v);  // where PROJ's own axes of that face put a place
  };
  const auto upright = [](double u, double v) { return geo::Vec2(u, 1.0 - v); };
  const auto turned = [](double u, double v) { return geo::Vec2(v, u); };
  const auto north = [](double u, double v) { return geo::Vec2(1.0 - v, 1.0 - u); };
  const std::array<Face, 6> faces{{{"+lat_0=0 +lon_0=0", upright},
                                   {"+lat_0=0 +lon_0=90", upright},
                                   {"+lat_0=0 +lon_0=180", turned},
                                   {"+lat_0=0 +lon_0=-90", turned},
                                   {"+lat_0=90 +lon_0=0", north},
                                   {"+lat_0=-90 +lon_0=0", upright}}};
  auto random = geo::seededGenerator();
  const Tiling tiling(Scheme::cube);
  for (int root = 0; root < 6; ++root) {
    const Face& face = faces[static_cast<std::size_t>(root)];
    const Projection projection(std::string("+proj=s2 +UVtoST=tangent +R=1 ") + face.centre);
    ASSERT_TRUE(projection.valid());
    for (int i = 0; i < 20000; ++i) {
      const RootPoint p{root, geo::uniform(random, 0.0, 1.0), geo::uniform(random, 0.0, 1.0)};
      const geo::Vec2 actual = projection.at(tiling.direction(p));
      const geo::Vec2 expected = face.proj(p.u, p.v);
      ASSERT_NEAR(actual.x, expected.x, 1e-12) << root << " " << p.u << " " << p.v;
      ASSERT_NEAR(actual.y, expected.y, 1e-12) << root << " " << p.u << " " << p.v;
    }
  }
}

TEST(GeographicReference, ProjsEquirectangularBetweenTheParallelsOf45Degrees) {
  const Projection projection("+proj=eqc +R=1");
  ASSERT_TRUE(projection.valid());
  auto random = geo::seededGenerator();
  const Tiling tiling(Scheme::geographic);
  for (int i = 0; i < 100000; ++i) {
    const int root = static_cast<int>(randomBelow(random, 4));
    const RootPoint p{root, geo::uniform(random, 0.0, 1.0), geo::uniform(random, 0.0, 1.0)};
    const geo::Vec2 xy = projection.at(tiling.direction(p));
    ASSERT_NEAR(std::remainder(xy.x - geo::kPi / 2.0 * (root + p.u - 0.5), 2.0 * geo::kPi), 0.0, 1e-12);
    ASSERT_NEAR(xy.y, geo::kPi / 2.0 * (0.5 - p.v), 1e-12);
  }
}

// The equations of docs/tilings.md, with colatitude and longitude from PROJ's azimuthal projection: distance and angle
// from the pole.
TEST(GeographicReference, CapsOnProjsAzimuthalEquidistantPlane) {
  auto random = geo::seededGenerator();
  const Tiling tiling(Scheme::geographic);
  const double octant = geo::kPi / 4.0;
  for (const int root : {4, 5}) {
    const double side = root == 4 ? 1.0 : -1.0;  // looked at from outside, the south's longitudes run the other way
    const Projection projection(root == 4 ? "+proj=aeqd +lat_0=90 +R=1" : "+proj=aeqd +lat_0=-90 +R=1");
    ASSERT_TRUE(projection.valid());
    for (int i = 0; i < 50000; ++i) {
      const double size = i % 2 == 0 ? 1.0 : std::exp(geo::uniform(random, -12.0, 0.0));
      const RootPoint p{root, 0.5 + 0.5 * size * geo::uniform(random, -1.0, 1.0),
                        0.5 + 0.5 * size * geo::uniform(random, -1.0, 1.0)};
      const double x = 2.0 * p.u - 1.0;
      const double y = 2.0 * p.v - 1.0;
      const geo::Vec2 plane = projection.at(tiling.direction(p));
      const double c = std::hypot(plane.x, plane.y) / octant;
      const double m = std::max(std::fabs(x), std::fabs(y));
      const double r = std::hypot(x, y);
      ASSERT_NEAR(c, (1.0 - c * c) * r + c * c * m, 1e-11);
      // From the meridian in the middle of the quarter, eastwards.
      const double middle = std::fabs(y) > std::fabs(x) ? (y * side > 0.0 ? 0.0 : 4.0) : (x > 0.0 ? 2.0 : -2.0);
      const double longitude = std::atan2(plane.x, -side * plane.y) / octant;
      const double across = std::remainder(longitude - middle, 8.0);
      const double turned = std::remainder(std::atan2(x, side * y) / octant - middle, 8.0);
      const double along = std::tan(turned * octant);
      ASSERT_NEAR(across, (1.0 - c * c) * turned + c * c * along, 1e-10) << root << " " << x << " " << y;
    }
  }
}

}  // namespace
}  // namespace tellurion::tiling
