#include "raster/land_mask.h"

#include <cpl_string.h>
#include <gdal_alg.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <ogrsf_frmts.h>

#include <array>
#include <memory>

#include "raster/gdal_session.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

struct FreeTransformation {
  void operator()(OGRCoordinateTransformation* t) const { OGRCoordinateTransformation::DestroyCT(t); }
};
using Transformation = std::unique_ptr<OGRCoordinateTransformation, FreeTransformation>;

/// From a layer's reference to longitude and latitude of the same or a near datum. Nothing: it is that already.
io::Result<Transformation> toLonLat(const OGRSpatialReference* reference, const std::string& path) {
  if (reference == nullptr || reference->IsGeographic() != 0) return Transformation();
  OGRSpatialReference from = *reference;
  from.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<OGRSpatialReference> to(from.CloneGeogCS());
  if (!to) return io::fail(Code::unsupported, "its spatial reference is not understood", path);
  to->SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  Transformation transformation(OGRCreateCoordinateTransformation(&from, to.get()));
  if (!transformation) return io::fail(Code::unsupported, "its spatial reference is not understood", path);
  return transformation;
}

/// A picture of bytes in memory that lies on the grid, moved by whole turns.
class Canvas {
 public:
  explicit Canvas(const LonLatGrid& grid) : mask(grid.width, grid.height), grid_(grid) {}

  io::Result<void> burn(OGRGeometry& geometry, const GdalMessages& messages, const std::string& path) {
    OGREnvelope box;
    geometry.getEnvelope(&box);
    const double west = grid_.bounds.west.degrees();
    const double east = west + grid_.bounds.width.degrees();
    for (const double turn : {-360.0, 0.0, 360.0}) {
      if (box.MaxX + turn < west || box.MinX + turn > east) continue;
      if (auto ok = burnAt(geometry, turn, messages, path); !ok) return ok;
    }
    return {};
  }

  Raster<std::uint8_t> mask;

 private:
  io::Result<void> burnAt(OGRGeometry& geometry, double turn, const GdalMessages& messages, const std::string& path) {
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("MEM");
    const DatasetPtr dataset(driver == nullptr ? nullptr
                                               : driver->Create("", grid_.width, grid_.height, 0, GDT_Byte, nullptr));
    if (!dataset) return tl::unexpected(messages.failure(Code::unsupported, "no room to draw its polygons", path));
    CPLStringList band;
    std::array<char, 32> address{};
    CPLPrintPointer(address.data(), mask.samples.data(), static_cast<int>(address.size()) - 1);
    band.SetNameValue("DATAPOINTER", address.data());
    if (dataset->AddBand(GDT_Byte, band.List()) != CE_None) {
      return tl::unexpected(messages.failure(Code::unsupported, "its polygons cannot be drawn", path));
    }
    std::array<double, 6> place{grid_.bounds.west.degrees() - turn,
                                grid_.bounds.width.degrees() / grid_.width,
                                0.0,
                                grid_.bounds.north.degrees(),
                                0.0,
                                -(grid_.bounds.north - grid_.bounds.south).degrees() / grid_.height};
    dataset->SetGeoTransform(place.data());
    int first = 1;
    double inside = 1.0;
    OGRGeometryH shape = OGRGeometry::ToHandle(&geometry);
    const CPLErr drawn = GDALRasterizeGeometries(GDALDataset::ToHandle(dataset.get()), 1, &first, 1, &shape, nullptr,
                                                 nullptr, &inside, nullptr, nullptr, nullptr);
    if (drawn != CE_None) return tl::unexpected(messages.failure(Code::corrupt, "a polygon cannot be drawn", path));
    return {};
  }

  LonLatGrid grid_;
};

bool isArea(const OGRGeometry* geometry) {
  if (geometry == nullptr || geometry->IsEmpty() != 0) return false;
  const OGRwkbGeometryType type = wkbFlatten(geometry->getGeometryType());
  return type == wkbPolygon || type == wkbMultiPolygon;
}

/// Metres and feet taken for degrees lie nowhere, and would cut all away.
bool isLonLat(const OGRGeometry& geometry) {
  constexpr double kRounding = 1e-6;
  OGREnvelope box;
  geometry.getEnvelope(&box);
  return box.MinX >= -360.0 - kRounding && box.MaxX <= 360.0 + kRounding && box.MinY >= -90.0 - kRounding &&
         box.MaxY <= 90.0 + kRounding;
}

io::Result<int> burnLayer(OGRLayer& layer, const std::string& path, const GdalMessages& messages, Canvas& canvas,
                          const std::stop_token& stop) {
  auto transformation = toLonLat(layer.GetSpatialRef(), path);
  if (!transformation) return tl::unexpected(transformation.error());
  int areas = 0;
  layer.ResetReading();
  while (true) {
    if (stop.stop_requested()) return io::fail(Code::cancelled, "stopped");
    const std::unique_ptr<OGRFeature> feature(layer.GetNextFeature());
    if (!feature) break;
    OGRGeometry* geometry = feature->GetGeometryRef();
    if (!isArea(geometry)) continue;
    if (*transformation && geometry->transform(transformation->get()) != OGRERR_NONE) {
      return tl::unexpected(messages.failure(Code::corrupt, "a polygon has no longitude and latitude", path));
    }
    if (!isLonLat(*geometry)) {
      return io::fail(
          Code::unsupported,
          "its coordinates are not longitude and latitude in degrees: say what they are (a shapefile's .prj)", path);
    }
    ++areas;
    if (auto ok = canvas.burn(*geometry, messages, path); !ok) return tl::unexpected(ok.error());
  }
  if (messages.failed()) return tl::unexpected(messages.failure(Code::corrupt, "cannot be read to its end", path));
  return areas;
}

}  // namespace

io::Result<Raster<std::uint8_t>> insidePolygons(const std::vector<std::string>& files, const LonLatGrid& grid,
                                                const std::stop_token& stop) {
  Canvas canvas(grid);
  for (const std::string& path : files) {
    const GdalMessages messages;
    const auto dataset = gdalOpenVector(path);
    if (!dataset) return tl::unexpected(dataset.error());
    int areas = 0;
    for (int i = 0; i < (*dataset)->GetLayerCount(); ++i) {
      const auto drawn = burnLayer(*(*dataset)->GetLayer(i), path, messages, canvas, stop);
      if (!drawn) return tl::unexpected(drawn.error());
      areas += *drawn;
    }
    if (areas == 0) {
      return io::fail(Code::unsupported,
                      "holds no polygons: a coastline of lines has no inside; name the polygons' file", path);
    }
  }
  return std::move(canvas.mask);
}

}  // namespace tellurion::raster
