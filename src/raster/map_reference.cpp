#include "raster/map_reference.h"

#include <fmt/format.h>
#include <proj.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>

#include "geo/angle.h"
#include "raster/parse_number.h"
#include "raster/service_url.h"

namespace tellurion::raster {
namespace {

constexpr double kEarthRadius_m = 6378137.0;  // the standards' 0.28 mm pixel is measured on WGS 84's semi-major axis
constexpr double kMetresPerDegree = kEarthRadius_m * geo::kPi / 180.0;

struct FreeProj {
  void operator()(PJ_CONTEXT* c) const { proj_context_destroy(c); }
  void operator()(PJ* p) const { proj_destroy(p); }
};

std::string inCapitals(std::string_view text) {
  std::string capitals(text);
  for (char& c : capitals)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return capitals;
}

/// The last of the parts that a separator makes.
std::string_view lastPart(std::string_view text, char separator) {
  const std::size_t at = text.rfind(separator);
  return at == text.npos ? text : text.substr(at + 1);
}

std::string commonName(std::string_view authority, std::string_view code) {
  if (authority == "OGC" || authority == "CRS")
    return code == "CRS84" || code == "84" ? "CRS:84" : fmt::format("CRS:{}", code);
  // OSGEO:41001 is what tile map services call it.
  for (const char* mercator : {"3857", "900913", "3785", "102100", "102113", "3587", "41001"})
    if ((authority == "EPSG" || authority == "ESRI" || authority == "OSGEO") && code == mercator) return "EPSG:3857";
  return fmt::format("{}:{}", authority, code);
}

bool isOwnLonLat(std::string_view name, bool onEarth) {
  if (name == "CRS:84" || name == "EPSG:4326") return true;
  // IAU2000:49900 and its like: the codes of a body's own longitude and latitude end in 00.
  return !onEarth && name.starts_with("IAU") && name.ends_with("00");
}

struct Axes {
  bool northFirst = false;
  double unit = 1.0;  ///< metres, or radians
};

std::optional<Axes> axesOf(const std::string& name, bool& geographic) {
  const std::unique_ptr<PJ_CONTEXT, FreeProj> context(proj_context_create());
  proj_log_level(context.get(), PJ_LOG_NONE);
  proj_context_set_enable_network(context.get(), 0);
  const std::unique_ptr<PJ, FreeProj> reference(proj_create(context.get(), name.c_str()));
  if (!reference || proj_is_crs(reference.get()) == 0) return std::nullopt;
  const PJ_TYPE type = proj_get_type(reference.get());
  geographic = type == PJ_TYPE_GEOGRAPHIC_2D_CRS;
  if (!geographic && type != PJ_TYPE_PROJECTED_CRS) return std::nullopt;
  const std::unique_ptr<PJ, FreeProj> system(proj_crs_get_coordinate_system(context.get(), reference.get()));
  const char* axis = nullptr;
  Axes axes;
  if (!system || proj_cs_get_axis_info(context.get(), system.get(), 0, &axis, nullptr, nullptr, &axes.unit, nullptr,
                                       nullptr, nullptr) == 0) {
    return std::nullopt;
  }
  // The direction does not tell: both axes of a polar map may point "north".
  const std::string first = lowered(axis);
  axes.northFirst = first.find("north") != first.npos || first.find("latitude") != first.npos;
  return axes;
}

}  // namespace

std::string referenceName(std::string_view crs) {
  constexpr const char* kSpace = " \t\r\n";
  const std::size_t begin = crs.find_first_not_of(kSpace);
  if (begin == crs.npos) return {};
  const std::string name = inCapitals(crs.substr(begin, crs.find_last_not_of(kSpace) - begin + 1));
  const std::string_view all = name;
  for (const std::string_view urn : {"URN:OGC:DEF:CRS:", "URN:X-OGC:DEF:CRS:", "URN:OPENGIS:DEF:CRS:"}) {
    if (!all.starts_with(urn)) continue;
    const std::string_view rest = all.substr(urn.size());
    return commonName(rest.substr(0, rest.find(':')), lastPart(rest, ':'));
  }
  if (const std::size_t at = all.find("/DEF/CRS/"); at != all.npos) {
    const std::string_view rest = all.substr(at + 9);
    return commonName(rest.substr(0, rest.find('/')), lastPart(rest, '/'));
  }
  if (const std::size_t at = all.find("EPSG.XML#"); at != all.npos) return commonName("EPSG", all.substr(at + 9));
  const std::size_t colon = all.find(':');
  if (colon == all.npos) return all == "CRS84" || all == "WGS84" ? "CRS:84" : name;
  return commonName(all.substr(0, colon), all.substr(colon + 1));
}

std::optional<geo::Body> bodyOfReferences(std::span<const std::string> references) {
  std::optional<geo::Body> body;
  for (const std::string& crs : references) {
    const std::string name = referenceName(crs);
    if (!name.starts_with("IAU")) continue;
    // A hundred codes for each body of NAIF's numbers.
    const auto code = parseNumber<int>(lastPart(name, ':'));
    if (!code) continue;
    const int number = *code / 100;
    const auto named = geo::bodyByName(number == 399 ? "earth" : number == 301 ? "moon" : number == 499 ? "mars" : "");
    if (!named || (body && !(*body == *named))) return std::nullopt;
    body = named;
  }
  return body;
}

io::Result<MapReference> mapReference(std::string_view crs, const geo::Body& body) {
  const bool onEarth = body == geo::earth();
  MapReference reference;
  reference.name = referenceName(crs);
  if (reference.name == "EPSG:3857") {
    reference.plane.kind = MapPlane::Kind::webMercator;
    reference.planePerUnit = body.ellipsoid.semiMajorAxis_m() / kEarthRadius_m;
    return reference;
  }
  if (isOwnLonLat(reference.name, onEarth)) {
    reference.metresPerUnit = kMetresPerDegree;
    reference.northFirst = reference.name == "EPSG:4326" || reference.name.starts_with("IAU_2015");
    return reference;
  }
  bool geographic = false;
  const auto axes = axesOf(reference.name, geographic);
  if (!axes) {
    return io::fail(io::Failure::Code::unsupported,
                    fmt::format("the coordinate reference '{}' is not known here; ask for another one (crs)", crs));
  }
  reference.plane.kind = MapPlane::Kind::other;
  reference.plane.definition = reference.name;
  reference.northFirst = axes->northFirst;
  reference.metresPerUnit = geographic ? axes->unit * kEarthRadius_m : axes->unit;
  return reference;
}

}  // namespace tellurion::raster
