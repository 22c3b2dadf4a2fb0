#include "raster/point_reader.h"

#include <fmt/format.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <memory>
#include <span>
#include <string_view>
#include <tuple>

#include "raster/height_band.h"
#include "raster/parse_number.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;
using Names = std::vector<std::string>;

constexpr std::size_t kBatch = 4096;  ///< that are projected together
constexpr int kMostNamesTold = 12;
constexpr std::size_t kLongestNameTold = 40;

std::string lower(std::string_view text) {
  std::string result(trimmed(text));
  std::ranges::transform(result, result.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

/// The first column that has one of the names, which are in the order of how surely they mean it; -1: none.
int columnOf(const OGRFeatureDefn& columns, const Names& names) {
  for (const std::string& name : names) {
    for (int i = 0; i < columns.GetFieldCount(); ++i) {
      if (lower(columns.GetFieldDefn(i)->GetNameRef()) == name) return i;
    }
  }
  return -1;
}

Names joined(Names first, const Names& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

std::string namesIn(const OGRFeatureDefn& columns) {
  std::string names;
  for (int i = 0; i < std::min(columns.GetFieldCount(), kMostNamesTold); ++i)
    names += (i > 0 ? ", " : "") + std::string(columns.GetFieldDefn(i)->GetNameRef()).substr(0, kLongestNameTold);
  return columns.GetFieldCount() > kMostNamesTold ? names + ", ..." : names;
}

bool hasNoGeometry(OGRLayer& layer) {
  return wkbFlatten(layer.GetGeomType()) == wkbNone;
}

bool mayHaveZ(OGRLayer& layer) {
  return !hasNoGeometry(layer) &&
         (OGR_GT_HasZ(layer.GetGeomType()) != 0 || wkbFlatten(layer.GetGeomType()) == wkbUnknown);
}

bool anyZIsNotZero(OGRLayer& layer) {
  bool any = false;
  layer.ResetReading();
  while (!any) {
    const std::unique_ptr<OGRFeature> feature(layer.GetNextFeature());
    if (!feature) break;
    const OGRGeometry* geometry = feature->GetGeometryRef();
    if (geometry == nullptr || geometry->IsEmpty() != 0 || geometry->Is3D() == 0) continue;
    OGREnvelope3D box;
    geometry->getEnvelope(&box);
    any = box.MinZ != 0.0 || box.MaxZ != 0.0;
  }
  return any;
}

io::Result<PointColumns> columnsAsked(OGRLayer& layer, const Names& asked, const std::string& path) {
  const OGRFeatureDefn& columns = *layer.GetLayerDefn();
  std::vector<int> found;
  for (const std::string& name : asked) {
    found.push_back(columnOf(columns, {lower(name)}));
    if (found.back() >= 0) continue;
    return io::fail(
        Code::invalidArgument,
        fmt::format("has no column '{}'; there are: {}", name.substr(0, kLongestNameTold), namesIn(columns)), path);
  }
  if (asked.size() == 3) return PointColumns{.x = found[0], .y = found[1], .height = found[2], .heightIsZ = false};
  if (!hasNoGeometry(layer)) return PointColumns{.x = -1, .y = -1, .height = found[0], .heightIsZ = false};
  return io::fail(Code::invalidArgument, "has no geometry: name three columns, those of x, y and height", path);
}

std::optional<double> numberIn(const OGRFeature& feature, int column) {
  if (column < 0 || feature.IsFieldSetAndNotNull(column) == 0) return std::nullopt;
  if (feature.GetFieldDefnRef(column)->GetType() == OFTReal) {
    const double value = feature.GetFieldAsDouble(column);
    return std::isfinite(value) ? std::optional(value) : std::nullopt;
  }
  return parseNumber<double>(feature.GetFieldAsString(column));
}

}  // namespace

io::Result<PointColumns> columnsOf(OGRLayer& layer, bool isMap, const PointOptions& options, const std::string& path,
                                   std::vector<std::string>& warnings) {
  if (!options.columns.empty()) return columnsAsked(layer, options.columns, path);
  const OGRFeatureDefn& columns = *layer.GetLayerDefn();
  const Names mapX{"x", "easting", "east"};
  const Names mapY{"y", "northing", "north"};
  PointColumns found{.x = columnOf(columns, isMap ? mapX : joined({"lon", "longitude", "long", "lng"}, mapX)),
                     .y = columnOf(columns, isMap ? mapY : joined({"lat", "latitude"}, mapY)),
                     .height = columnOf(columns, {"height", "elevation", "elev", "ele", "altitude", "alt", "z", "h"}),
                     .heightIsZ = mayHaveZ(layer)};
  if (found.heightIsZ && found.height >= 0 && !anyZIsNotZero(layer)) {
    found.heightIsZ = false;
    warnings.push_back(fmt::format("its points' z is 0 everywhere: heights are taken from its column '{}'",
                                   columns.GetFieldDefn(found.height)->GetNameRef()));
  }
  const bool hasPlaces = !hasNoGeometry(layer) || (found.x >= 0 && found.y >= 0);
  if (hasPlaces && (found.heightIsZ || found.height >= 0)) return found;
  return io::fail(Code::unsupported,
                  fmt::format("its columns ({}) do not say where {} is: name them in its first line ({}), or with "
                              "--points-columns",
                              namesIn(columns), hasPlaces ? "the height" : "the place",
                              isMap ? "x, y, height" : "lon, lat, height"),
                  path);
}

PointReader::PointReader(const PointReference& reference, const PointColumns& columns,
                         const std::optional<double>& nodata, const PointSink& sink)
    : reference_(reference), columns_(columns), nodata_(nodata), sink_(sink) {
  std::tie(lowest_m_, highest_m_) = possibleHeights_m(reference.body);
}

io::Result<void> PointReader::take(const OGRFeature& feature, const std::string& path) {
  const OGRGeometry* geometry = columns_.x >= 0 ? nullptr : feature.GetGeometryRef();
  if (geometry == nullptr || geometry->IsEmpty() != 0) {
    const auto x = numberIn(feature, columns_.x);
    return takeAt(x, numberIn(feature, columns_.y), numberIn(feature, columns_.height));
  }
  const OGRwkbGeometryType type = wkbFlatten(geometry->getGeometryType());
  if (type == wkbPoint) return takePoint(*geometry->toPoint(), feature);
  if (type != wkbMultiPoint) {
    return io::fail(Code::unsupported,
                    "holds lines or areas; a layer of points is wanted (of lines: their corners, by ogr2ogr)", path);
  }
  for (const OGRPoint* point : *geometry->toMultiPoint()) {
    if (auto ok = takePoint(*point, feature); !ok) return ok;
  }
  return {};
}

io::Result<void> PointReader::takePoint(const OGRPoint& point, const OGRFeature& feature) {
  if (point.IsEmpty() != 0) return takeAt(std::nullopt, std::nullopt, std::nullopt);
  const bool isZ = columns_.heightIsZ && point.Is3D() != 0;
  return takeAt(point.getX(), point.getY(), isZ ? std::optional(point.getZ()) : numberIn(feature, columns_.height));
}

io::Result<void> PointReader::takeAt(std::optional<double> x, std::optional<double> y, std::optional<double> height_m) {
  if (height_m && nodata_ && *height_m == *nodata_) {
    count(Fault::nodata);
    return {};
  }
  if (!x || !y || !height_m || !std::isfinite(*x) || !std::isfinite(*y) || !std::isfinite(*height_m)) {
    count(Fault::noNumber);
    return {};
  }
  x_.push_back(*x);
  y_.push_back(*y);
  heights_m_.push_back(*height_m);
  return x_.size() < kBatch ? io::Result<void>{} : finish();
}

io::Result<void> PointReader::finish() {
  if (reference_.projection) reference_.projection->inverse(x_, y_);
  for (std::size_t i = 0; i < x_.size(); ++i) {
    if (!(x_[i] >= -360.0 && x_[i] <= 720.0 && std::abs(y_[i]) <= 90.0)) {
      count(Fault::elsewhere);
    } else if (!(heights_m_[i] >= lowest_m_ && heights_m_[i] <= highest_m_)) {
      count(Fault::impossible);
    } else {
      ++taken_;
      auto ok = sink_(geo::directionFromDegrees(y_[i], x_[i]), static_cast<float>(heights_m_[i]));
      if (!ok) return ok;
    }
  }
  x_.clear();
  y_.clear();
  heights_m_.clear();
  return {};
}

io::Result<void> PointReader::tell(const std::string& path, std::vector<std::string>& warnings) const {
  constexpr std::array<std::string_view, kFaults> kWhat{
      "lack a number for their place or height (columns are parted by commas, semicolons or tabs, and decimals have a "
      "point)",
      "have the height that means no data", "lie beyond 90 degrees of latitude or 360 of longitude",
      "have heights that the body cannot have"};
  for (std::size_t i = 0; taken_ > 0 && i < kFaults; ++i) {
    if (faults_[i] > 0) warnings.push_back(fmt::format("{} of its points {}: left out", faults_[i], kWhat[i]));
  }
  if (taken_ > 0) return {};
  const auto most = std::ranges::max_element(faults_);
  if (*most == 0) return io::fail(Code::invalidArgument, "holds no points", path);
  const auto which = static_cast<std::size_t>(most - faults_.begin());
  const bool isElsewhere = which == static_cast<std::size_t>(Fault::elsewhere);
  return io::fail(Code::invalidArgument,
                  fmt::format("holds no points that can be used: {} {}{}", *most, kWhat[which],
                              isElsewhere ? "; say what its coordinates are in (--points-srs EPSG:...)" : ""),
                  path);
}

}  // namespace tellurion::raster
