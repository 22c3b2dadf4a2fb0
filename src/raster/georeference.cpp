#include "raster/georeference.h"

#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string_view>
#include <utility>

#include "raster/spatial_reference.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;
using Transform = std::array<double, 6>;

io::Result<Transform> readTransform(GDALDataset& dataset, const std::string& path) {
  Transform t{};
  if (dataset.GetGeoTransform(t.data()) != CE_None) {
    const char* how = dataset.GetGCPCount() > 0
                          ? "lies only by ground control points; warp it first (gdalwarp)"
                          : "does not say where it lies; put a world file beside it, or give it corners and a spatial "
                            "reference (gdal_translate -a_ullr W N E S -a_srs EPSG:4326)";
    return io::fail(Code::unsupported, how, path);
  }
  const bool finite = std::ranges::all_of(t, [](double v) { return std::isfinite(v); });
  const double determinant = t[1] * t[5] - t[2] * t[4];
  if (!finite || !std::isfinite(determinant) || determinant == 0.0) {
    return io::fail(Code::corrupt, "its georeference puts all pixels on a line or nowhere", path);
  }
  return t;
}

/// The corners' extent in x and y.
struct Extent {
  double minX, maxX, minY, maxY;
};
Extent extentOf(const Transform& t, GDALDataset& dataset) {
  const double w = dataset.GetRasterXSize();
  const double h = dataset.GetRasterYSize();
  const auto [minX, maxX] = std::minmax({t[0], t[0] + w * t[1], t[0] + h * t[2], t[0] + w * t[1] + h * t[2]});
  const auto [minY, maxY] = std::minmax({t[3], t[3] + w * t[4], t[3] + h * t[5], t[3] + w * t[4] + h * t[5]});
  return {minX, maxX, minY, maxY};
}

bool fitsDegrees(const Extent& e) {
  return e.minX >= -361.0 && e.maxX <= 721.0 && e.minY >= -91.0 && e.maxY <= 91.0;
}

bool hasProjection(const OGRSpatialReference& reference, std::initializer_list<std::string_view> names) {
  const char* name = reference.GetAttrValue("PROJECTION");
  return name != nullptr && std::ranges::find(names, std::string_view(name)) != names.end();
}

/// An equidistant cylindrical map of a sphere is longitude and latitude in other units: exactly, so PROJ is not needed,
/// and the map closes around the body and over the poles.
std::optional<Transform> asDegrees(const OGRSpatialReference& reference, const Transform& t) {
  if (!hasProjection(reference, {SRS_PT_EQUIRECTANGULAR}) || reference.GetInvFlattening() != 0.0) return std::nullopt;
  const double perUnit = reference.GetLinearUnits() / reference.GetSemiMajor() * (180.0 / geo::kPi);
  const double parallel = geo::Angle::degrees(reference.GetNormProjParm(SRS_PP_STANDARD_PARALLEL_1, 0.0)).radians();
  const double xPerUnit = perUnit / std::cos(parallel);
  const double lon0 = reference.GetNormProjParm(SRS_PP_CENTRAL_MERIDIAN, 0.0);
  const double lat0 = reference.GetNormProjParm(SRS_PP_LATITUDE_OF_ORIGIN, 0.0);
  const double east = reference.GetProjParm(SRS_PP_FALSE_EASTING, 0.0);
  const double north = reference.GetProjParm(SRS_PP_FALSE_NORTHING, 0.0);
  return Transform{lon0 + (t[0] - east) * xPerUnit, t[1] * xPerUnit, t[2] * xPerUnit,
                   lat0 + (t[3] - north) * perUnit, t[4] * perUnit,  t[5] * perUnit};
}

/// The way around the body along x, for maps on which a parallel is a straight line of one scale.
double turnOf(const OGRSpatialReference& reference, const Projection& projection) {
  if (!hasProjection(reference,
                     {SRS_PT_MERCATOR_1SP, SRS_PT_MERCATOR_2SP, SRS_PT_EQUIRECTANGULAR, SRS_PT_CYLINDRICAL_EQUAL_AREA,
                      SRS_PT_MILLER_CYLINDRICAL, SRS_PT_GALL_STEREOGRAPHIC})) {
    return 0.0;
  }
  const double lon0 = reference.GetNormProjParm(SRS_PP_CENTRAL_MERIDIAN, 0.0);
  std::array<double, 2> x{lon0, lon0 + 90.0};
  std::array<double, 2> y{0.0, 0.0};
  projection.forward(x, y);
  const double turn = 4.0 * (x[1] - x[0]);
  return std::isfinite(turn) && turn > 0.0 ? turn : 0.0;
}

/// Longitude and latitude of a grid of pixels, roughly; nothing when none has any.
std::optional<geo::GeoRect> roughArea(const Projection& projection, const Extent& e) {
  constexpr std::size_t kSide = 9;
  std::array<double, kSide * kSide> x{};
  std::array<double, kSide * kSide> y{};
  for (std::size_t i = 0; i < x.size(); ++i) {
    const std::size_t col = i % kSide;
    const std::size_t row = i / kSide;
    x[i] = e.minX + (e.maxX - e.minX) * static_cast<double>(col) / (kSide - 1);
    y[i] = e.minY + (e.maxY - e.minY) * static_cast<double>(row) / (kSide - 1);
  }
  projection.inverse(x, y);
  std::optional<geo::GeoRect> area;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i]) || std::abs(y[i]) > 90.0) continue;
    const geo::GeoRect point{geo::Angle::degrees(y[i]), geo::Angle::degrees(y[i]),
                             geo::wrappedLongitude(geo::Angle::degrees(x[i])), geo::Angle()};
    area = area ? area->united(point) : point;
  }
  return area;
}

io::Result<Georeference> withoutReference(const Transform& t, GDALDataset& dataset, const std::string& path,
                                          const std::optional<geo::Body>& body, std::vector<std::string>& warnings) {
  const Extent e = extentOf(t, dataset);
  if (!fitsDegrees(e)) {
    return io::fail(
        Code::unsupported,
        fmt::format("has no spatial reference, and its extent ({:.10g}, {:.10g} .. {:.10g}, {:.10g}) does not "
                    "fit degrees; give it one (gdal_edit.py -a_srs EPSG:...)",
                    e.minX, e.minY, e.maxX, e.maxY),
        path);
  }
  warnings.emplace_back(
      "no spatial reference: taken as longitude and latitude in degrees, on Earth unless --body names another");
  return Georeference{t, std::nullopt, 360.0, body.value_or(geo::earth()), true};
}

io::Result<Georeference> geographicReference(Georeference base, const OGRSpatialReference& reference,
                                             const Extent& extent, bool onEarth, const std::string& path) {
  if (onEarth) {
    const bool degrees = hasDegrees(reference) && fitsDegrees(extent);
    std::optional<geo::GeoRect> area;
    if (degrees) area = geo::GeoRect::fromDegrees(extent.minY, extent.minX, extent.maxY, extent.maxX);
    auto projection = Projection::fromWgs84(wktOf(reference), area);
    if (!projection) return tl::unexpected(std::move(projection.error()));
    if (!projection->isIdentity()) {
      base.projection = std::move(*projection);
      return base;
    }
  }
  if (!hasDegrees(reference))
    return io::fail(Code::unsupported, "its longitudes and latitudes are not in degrees", path);
  if (!fitsDegrees(extent)) {
    return io::fail(Code::corrupt,
                    fmt::format("says that it is in degrees, but runs from {:.10g}, {:.10g} to {:.10g}, {:.10g}",
                                extent.minX, extent.minY, extent.maxX, extent.maxY),
                    path);
  }
  base.turn = 360.0;
  return base;
}

io::Result<Georeference> projectedReference(Georeference base, const OGRSpatialReference& reference,
                                            const Extent& extent, bool onEarth, const std::string& path) {
  if (!onEarth && !hasDegrees(reference)) {
    return io::fail(Code::unsupported, "its longitudes and latitudes are not in degrees", path);
  }
  if (!onEarth) {
    if (const auto degrees = asDegrees(reference, base.transform)) {
      base.transform = *degrees;
      base.turn = 360.0;
      return base;
    }
  }
  const std::string wkt = wktOf(reference);
  auto projection = onEarth ? Projection::fromWgs84(wkt, std::nullopt) : Projection::fromOwnGeographic(wkt);
  if (onEarth && projection) {
    // Which change of datum is best depends on where the raster lies.
    if (const auto area = roughArea(*projection, extent)) projection = Projection::fromWgs84(wkt, area);
  }
  if (!projection) return tl::unexpected(std::move(projection.error()));
  base.turn = turnOf(reference, *projection);
  base.projection = std::move(*projection);
  return base;
}

}  // namespace

io::Result<Georeference> readGeoreference(GDALDataset& dataset, const std::string& path,
                                          const std::optional<geo::Body>& body, std::vector<std::string>& warnings) {
  const auto transform = readTransform(dataset, path);
  if (!transform) return tl::unexpected(transform.error());
  const OGRSpatialReference* given = dataset.GetSpatialRef();
  if (given == nullptr || given->IsEmpty()) return withoutReference(*transform, dataset, path, body, warnings);
  OGRSpatialReference reference(*given);
  reference.StripVertical();
  auto found = bodyOfReference(reference, path, body, warnings);
  if (!found) return tl::unexpected(std::move(found.error()));
  Georeference base{*transform, std::nullopt, 0.0, std::move(found->body)};
  const bool onEarth = found->onEarth;
  const Extent extent = extentOf(*transform, dataset);
  const bool geographic = reference.IsGeographic() != 0 && reference.IsDerivedGeographic() == 0;
  auto result = geographic ? geographicReference(std::move(base), reference, extent, onEarth, path)
                           : projectedReference(std::move(base), reference, extent, onEarth, path);
  if (!result) result.error().where = path;
  return result;
}

}  // namespace tellurion::raster
