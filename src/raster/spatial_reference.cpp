#include "raster/spatial_reference.h"

#include <cpl_conv.h>
#include <fmt/format.h>
#include <ogr_spatialref.h>

#include <array>
#include <cmath>

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

/// Relative difference of axes up to which an ellipsoid is taken for a body's: Clarke's and Bessel's for Earth, the
/// polar and the mean radii of Mars and the Moon.
constexpr double kSameBody = 0.01;

geo::Body bodyOf(const OGRSpatialReference& reference) {
  const double axis_m = reference.GetSemiMajor();
  for (const geo::Body& known : {geo::earth(), geo::mars(), geo::moon()}) {
    if (std::abs(axis_m / known.ellipsoid.semiMajorAxis_m() - 1.0) < kSameBody) return known;
  }
  const double inverse = reference.GetInvFlattening();
  const char* name = reference.GetAttrValue("SPHEROID");
  return {name != nullptr ? name : "body", geo::Ellipsoid(axis_m, inverse > 1.0 ? 1.0 / inverse : 0.0)};
}

bool isEarthLike(const OGRSpatialReference& reference) {
  return std::abs(reference.GetSemiMajor() / geo::earth().ellipsoid.semiMajorAxis_m() - 1.0) < kSameBody;
}

}  // namespace

bool hasDegrees(const OGRSpatialReference& reference) {
  return std::abs(reference.GetAngularUnits() / geo::Angle::degrees(1.0).radians() - 1.0) < 1e-9;
}

std::string wktOf(const OGRSpatialReference& reference) {
  char* text = nullptr;
  const std::array<const char*, 2> options{"FORMAT=WKT2_2019", nullptr};
  reference.exportToWkt(&text, options.data());
  std::string wkt = text != nullptr ? text : "";
  CPLFree(text);
  return wkt;
}

io::Result<ReferencedBody> bodyOfReference(const OGRSpatialReference& reference, const std::string& path,
                                           const std::optional<geo::Body>& body, std::vector<std::string>& warnings) {
  if (reference.IsLocal() != 0 || reference.IsGeocentric() != 0) {
    return io::fail(Code::unsupported, "its spatial reference is not a map of a body; warp it to one first", path);
  }
  const geo::Body own = bodyOf(reference);
  if (!std::isfinite(own.ellipsoid.semiMajorAxis_m()) || own.ellipsoid.semiMajorAxis_m() < 1.0) {
    return io::fail(Code::corrupt, "its spatial reference has no sensible ellipsoid", path);
  }
  ReferencedBody base{.body = body.value_or(own)};
  if (std::abs(base.body.ellipsoid.semiMajorAxis_m() / own.ellipsoid.semiMajorAxis_m() - 1.0) > kSameBody) {
    // WGS 84 is what programs write that know no other body; nobody writes the Moon's by mistake.
    if (!isEarthLike(reference)) {
      return io::fail(Code::invalidArgument,
                      fmt::format("lies on {} ({:.10g} m) by its spatial reference, and --body says {}; leave --body "
                                  "out, or correct the reference (gdal_edit.py -a_srs)",
                                  own.name, own.ellipsoid.semiMajorAxis_m(), base.body.name),
                      path);
    }
    warnings.push_back(fmt::format(
        "its spatial reference is Earth's ({:.10g} m), and --body says {}: its latitudes and longitudes are taken as "
        "{}'s; if it does show Earth, leave --body out and build it again",
        own.ellipsoid.semiMajorAxis_m(), base.body.name, base.body.name));
  }
  base.onEarth = isEarthLike(reference) && base.body == geo::earth();
  return base;
}

}  // namespace tellurion::raster
