#include "raster/point_layer.h"

#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <utility>

#include "raster/gdal_session.h"
#include "raster/point_reader.h"
#include "raster/raster_kind.h"
#include "raster/spatial_reference.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

constexpr std::array<std::string_view, 2> kTables{".csv", ".tsv"};
constexpr std::array<std::string_view, 6> kShapes{".gpkg", ".shp", ".geojson", ".json", ".fgb", ".kml"};

std::string endingOf(const std::string& path) {
  std::string text = std::filesystem::path(path).extension().string();
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool isTable(const std::string& path) {
  return std::ranges::find(kTables, endingOf(path)) != kTables.end();
}

bool mayHoldPoints(OGRLayer& layer) {
  const OGRwkbGeometryType type = wkbFlatten(layer.GetGeomType());
  return type == wkbPoint || type == wkbMultiPoint || type == wkbUnknown || type == wkbNone;
}

io::Result<OGRLayer*> layerOf(GDALDataset& dataset, const std::string& path) {
  std::vector<OGRLayer*> layers;
  for (int i = 0; i < dataset.GetLayerCount(); ++i) {
    if (mayHoldPoints(*dataset.GetLayer(i))) layers.push_back(dataset.GetLayer(i));
  }
  if (layers.empty()) return io::fail(Code::unsupported, "holds neither a raster nor a layer of points", path);
  if (layers.size() == 1) return layers.front();
  return io::fail(Code::unsupported,
                  fmt::format("holds {} layers of points; take out the one that is wanted (ogr2ogr one.gpkg FILE '{}')",
                              layers.size(), layers.front()->GetName()),
                  path);
}

/// Of a table, what the file of the same name that ends in .prj says (WKT); it becomes one of its files.
io::Result<OGRSpatialReference> besideTable(const std::string& path, std::vector<std::string>& files) {
  constexpr std::size_t kLargest = 65536;
  const std::string name = std::filesystem::path(path).replace_extension(".prj").string();
  std::ifstream file(name, std::ios::binary);
  OGRSpatialReference reference;
  if (!isTable(path) || !file) return reference;
  std::string text(kLargest, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (reference.importFromWkt(text.c_str()) != OGRERR_NONE) {
    return io::fail(Code::unsupported, "is no spatial reference in WKT (gdalsrsinfo -o wkt EPSG:...)", name);
  }
  if (std::ranges::find(files, name) == files.end()) files.insert(std::ranges::upper_bound(files, name), name);
  return reference;
}

/// What the user says before what the layer says before what lies beside it; empty where nothing does.
io::Result<OGRSpatialReference> namedReference(OGRLayer& layer, const std::string& path, const std::string& asked,
                                               std::vector<std::string>& files) {
  if (asked.empty()) {
    const OGRSpatialReference* given = layer.GetSpatialRef();
    if (given != nullptr && !given->IsEmpty()) return OGRSpatialReference(*given);
    return besideTable(path, files);
  }
  OGRSpatialReference reference;
  const auto limits = OGRSpatialReference::SET_FROM_USER_INPUT_LIMITATIONS_get();
  if (reference.SetFromUserInput(asked.c_str(), limits) != OGRERR_NONE) {
    return io::fail(Code::invalidArgument,
                    fmt::format("'{}' is no spatial reference: EPSG:CODE, WKT or a PROJ string is wanted", asked));
  }
  return reference;
}

io::Result<void> readAll(OGRLayer& layer, PointReader& reader, const std::string& path) {
  layer.ResetReading();
  while (true) {
    const std::unique_ptr<OGRFeature> feature(layer.GetNextFeature());
    if (!feature) return reader.finish();
    if (auto ok = reader.take(*feature, path); !ok) return ok;
  }
}

/// What the points cover by a rough change of datum.
io::Result<std::optional<geo::GeoRect>> areaOf(OGRLayer& layer, const PointReference& rough,
                                               const PointColumns& columns, const std::string& path) {
  std::optional<geo::GeoRect> area;
  const PointSink unite = [&](const geo::Direction& place, float) -> io::Result<void> {
    const geo::Geodetic at = geo::geodeticFromDirection(place);
    const geo::GeoRect point{.south = at.lat, .north = at.lat, .west = at.lon, .width = {}};
    if (!area || !area->contains(at.lat, at.lon)) area = area ? area->united(point) : point;
    return {};
  };
  PointReader reader(rough, columns, std::nullopt, unite);
  if (auto ok = readAll(layer, reader, path); !ok) return tl::unexpected(ok.error());
  return area;
}

/// As it is good for all of the reference's own area.
io::Result<PointReference> referenceOf(const OGRSpatialReference& given, const std::string& path,
                                       const std::optional<geo::Body>& wanted, std::string& wkt,
                                       std::vector<std::string>& warnings) {
  if (given.IsEmpty()) {
    warnings.emplace_back(
        "no spatial reference: taken as longitude and latitude in degrees, on Earth unless --body names another");
    return PointReference{.body = wanted.value_or(geo::earth()), .isMap = false, .projection = std::nullopt};
  }
  OGRSpatialReference reference(given);
  reference.StripVertical();
  auto body = bodyOfReference(reference, path, wanted, warnings);
  if (!body) return tl::unexpected(std::move(body.error()));
  const std::string text = wktOf(reference);
  auto projection = body->onEarth ? Projection::fromWgs84(text, std::nullopt) : Projection::fromOwnGeographic(text);
  if (!projection) {
    projection.error().where = path;
    return tl::unexpected(std::move(projection.error()));
  }
  if (body->onEarth && !projection->isIdentity()) wkt = text;
  PointReference result{
      .body = std::move(body->body), .isMap = reference.IsGeographic() == 0, .projection = std::nullopt};
  if (!projection->isIdentity()) result.projection = std::move(*projection);
  return result;
}

}  // namespace

bool isPointFile(const std::string& path, const PointOptions& options) {
  if (isTable(path)) return options.asksForAnything() || !kindOfRaster(path);
  if (std::ranges::find(kShapes, endingOf(path)) == kShapes.end()) return false;
  return !kindOfRaster(path) && gdalOpenVector(path);
}

io::Result<PointLayerInfo> readPoints(const std::string& path, const RasterOptions& options, const PointOptions& points,
                                      const PointSink& sink) {
  const GdalMessages messages;
  const auto dataset = isTable(path) ? gdalOpenTable(path) : gdalOpenVector(path);
  if (!dataset) return tl::unexpected(dataset.error());
  const auto layer = layerOf(**dataset, path);
  if (!layer) return tl::unexpected(layer.error());
  PointLayerInfo info{.files = filesOf(**dataset), .body = geo::earth(), .warnings = {}};
  const auto named = namedReference(**layer, path, points.reference, info.files);
  if (!named) return tl::unexpected(named.error());
  std::string wktOnEarth;
  auto reference = referenceOf(*named, path, options.body, wktOnEarth, info.warnings);
  if (!reference) return tl::unexpected(std::move(reference.error()));
  const auto columns = columnsOf(**layer, reference->isMap, points, path, info.warnings);
  if (!columns) return tl::unexpected(columns.error());
  if (!wktOnEarth.empty()) {
    // Which change of datum is best depends on where the points lie.
    const auto area = areaOf(**layer, *reference, *columns, path);
    if (!area) return tl::unexpected(area.error());
    auto best = Projection::fromWgs84(wktOnEarth, *area);
    if (best) reference->projection = std::move(*best);
  }
  info.body = reference->body;
  PointReader reader(*reference, *columns, options.nodata, sink);
  if (auto ok = readAll(**layer, reader, path); !ok) return tl::unexpected(ok.error());
  if (messages.failed()) return tl::unexpected(messages.failure(Code::corrupt, "cannot be read to its end", path));
  if (auto ok = reader.tell(path, info.warnings); !ok) return tl::unexpected(ok.error());
  return info;
}

}  // namespace tellurion::raster
