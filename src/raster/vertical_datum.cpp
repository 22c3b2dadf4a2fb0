#include "raster/vertical_datum.h"

#include <fmt/format.h>
#include <proj.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "geo/geodetic.h"
#include "raster/proj_objects.h"
#include "raster/raster_file.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

/// The EPSG code behind a name; nothing: it is a file's.
std::optional<std::string> codeOf(const std::string& name) {
  if (name == "egm96") return "5773";
  if (name == "egm2008") return "3855";
  constexpr std::string_view kPrefix = "EPSG:";
  if (name.starts_with(kPrefix)) return name.substr(kPrefix.size());
  return std::nullopt;
}

struct UsedGrid {
  std::string name;
  std::string path;
  bool isThere = false;
};

std::vector<UsedGrid> gridsOf(PJ_CONTEXT* context, const PJ* operation) {
  std::vector<UsedGrid> grids;
  for (int i = 0; i < proj_coordoperation_get_grid_used_count(context, operation); ++i) {
    const char* name = nullptr;
    const char* path = nullptr;
    int isThere = 0;
    if (proj_coordoperation_get_grid_used(context, operation, i, &name, &path, nullptr, nullptr, nullptr, nullptr,
                                          &isThere) == 0) {
      continue;
    }
    grids.push_back({name == nullptr ? "" : name, path == nullptr ? "" : path, isThere != 0});
  }
  return grids;
}

io::Failure missingGrid(const std::string& name, const std::string& grid) {
  return {
      Code::notFound,
      fmt::format("--vertical-datum {}: the grid {} is not installed where PROJ looks (Debian's proj-data has EGM96 "
                  "alone); get it with 'projsync --file {}', or name a file with the geoid's heights: "
                  "--vertical-datum FILE.gtx or FILE.tif",
                  name, grid, grid),
      {}};
}

}  // namespace

class VerticalDatum::Grid {
 public:
  virtual ~Grid() = default;
  Grid() = default;
  Grid(const Grid&) = delete;
  Grid& operator=(const Grid&) = delete;
  /// NaN or infinite where there is no value.
  virtual io::Result<void> values(std::span<const geo::Direction> places, std::span<double> out) = 0;

  std::string name;
  std::vector<std::string> files;
};

/// A grid that GDAL reads.
class VerticalDatum::File final : public Grid {
 public:
  explicit File(RasterFile file) : file_(std::move(file)) {}

  io::Result<void> values(std::span<const geo::Direction> places, std::span<double> out) override {
    heights_.assign(places.size(), kNoData);
    if (auto ok = file_.sampleHeights(places, {}, heights_); !ok) return ok;
    std::ranges::transform(heights_, out.begin(), [](float h) { return static_cast<double>(h); });
    return {};
  }

 private:
  RasterFile file_;
  std::vector<float> heights_;
};

/// An operation of PROJ from heights over the datum to heights over WGS 84's ellipsoid.
class VerticalDatum::Operation final : public Grid {
 public:
  io::Result<void> create(const std::string& code, const geo::GeoRect& area) {
    PJ_CONTEXT* context = context_.get();
    const ProjOwned<PJ> vertical(proj_create_from_database(context, "EPSG", code.c_str(), PJ_CATEGORY_CRS, 0, nullptr));
    if (!vertical || proj_get_type(vertical.get()) != PJ_TYPE_VERTICAL_CRS) {
      return io::fail(Code::invalidArgument,
                      fmt::format("--vertical-datum {}: is no vertical reference that PROJ knows; give egm96, egm2008, "
                                  "the EPSG code of one (EPSG:5773), or a file",
                                  name));
    }
    const ProjOwned<PJ> source(proj_create(context, ("EPSG:4326+" + code).c_str()));
    const ProjOwned<PJ> target(proj_create(context, "EPSG:4979"));
    if (!source || !target) return io::fail(Code::unsupported, "PROJ's database lacks WGS 84; is proj-data whole?");
    return choose(source.get(), target.get(), area);
  }

  io::Result<void> values(std::span<const geo::Direction> places, std::span<double> out) override {
    lon_.resize(places.size());
    lat_.resize(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
      const geo::Geodetic place = geo::geodeticFromDirection(places[i]);
      lon_[i] = place.lon.degrees();
      lat_[i] = place.lat.degrees();
    }
    std::ranges::fill(out, 0.0);
    const std::size_t count = places.size();
    constexpr std::size_t kStride = sizeof(double);
    proj_trans_generic(operation_.get(), PJ_FWD, lon_.data(), kStride, count, lat_.data(), kStride, count, out.data(),
                       kStride, count, nullptr, 0, 0);
    return {};
  }

 private:
  /// The best operation that knows both datums and whose grids are all there.
  io::Result<void> choose(const PJ* source, const PJ* target, const geo::GeoRect& area) {
    PJ_CONTEXT* context = context_.get();
    const auto found = projOperations(context, source, target, area, MissingGrids::kept);
    std::string missing;
    const int count = found ? proj_list_get_count(found.get()) : 0;
    for (int i = 0; i < count; ++i) {
      const ProjOwned<PJ> candidate(proj_list_get(context, found.get(), i));
      // A ballpark operation takes heights as they are, which is what this option is there to end.
      if (!candidate || proj_coordoperation_has_ballpark_transformation(context, candidate.get()) != 0) continue;
      const auto grids = gridsOf(context, candidate.get());
      const auto absent = std::ranges::find(grids, false, &UsedGrid::isThere);
      if (absent != grids.end()) {
        if (missing.empty()) missing = absent->name;
        continue;
      }
      operation_.reset(proj_normalize_for_visualization(context, candidate.get()));
      if (!operation_) continue;
      for (const UsedGrid& grid : grids)
        files.push_back(grid.path);
      return {};
    }
    if (!missing.empty()) return tl::unexpected(missingGrid(name, missing));
    return io::fail(
        Code::unsupported,
        fmt::format("--vertical-datum {}: PROJ knows no way from its heights to the ellipsoid there; name a "
                    "file with the geoid's heights",
                    name));
  }

  ProjOwned<PJ_CONTEXT> context_ = quietProjContext();
  ProjOwned<PJ> operation_;  // goes before the context
  std::vector<double> lon_;
  std::vector<double> lat_;
};

VerticalDatum::VerticalDatum(std::unique_ptr<Grid> grid) : grid_(std::move(grid)) {}
VerticalDatum::VerticalDatum(VerticalDatum&&) noexcept = default;
VerticalDatum& VerticalDatum::operator=(VerticalDatum&&) noexcept = default;
VerticalDatum::~VerticalDatum() = default;

io::Result<VerticalDatum> VerticalDatum::open(const std::string& name, const geo::Body& body,
                                              const geo::GeoRect& area) {
  if (const auto code = codeOf(name)) {
    if (!(body.ellipsoid == geo::earth().ellipsoid)) {
      return io::fail(Code::invalidArgument,
                      fmt::format("--vertical-datum {} is Earth's, and the input lies on {}; name a file with the "
                                  "heights of that body's geoid",
                                  name, body.name));
    }
    auto operation = std::make_unique<Operation>();
    operation->name = name;
    if (auto ok = operation->create(*code, area); !ok) return tl::unexpected(ok.error());
    return VerticalDatum(std::move(operation));
  }
  auto file = RasterFile::open(name, Kind::elevation, {.nodata = std::nullopt, .body = body});
  if (!file) {
    io::Failure failure = file.error();
    failure.message = "--vertical-datum, neither egm96, egm2008, EPSG:CODE nor a grid: " + failure.message;
    return tl::unexpected(std::move(failure));
  }
  auto grid = std::make_unique<File>(std::move(*file));
  grid->name = name;
  grid->files = {name};
  return VerticalDatum(std::move(grid));
}

io::Result<void> VerticalDatum::heightsOfZero(std::span<const geo::Direction> places, std::span<double> out) {
  if (out.size() != places.size()) return io::fail(Code::invalidArgument, "as many heights as places are needed");
  if (auto ok = grid_->values(places, out); !ok) return ok;
  const auto hole = std::ranges::find_if(out, [](double h) { return !std::isfinite(h); });
  if (hole == out.end()) return {};
  const geo::Geodetic where = geo::geodeticFromDirection(places[static_cast<std::size_t>(hole - out.begin())]);
  return io::fail(Code::invalidArgument,
                  fmt::format("--vertical-datum {}: has no value at {:.4f},{:.4f}; name a grid that covers all inputs",
                              grid_->name, where.lat.degrees(), where.lon.degrees()));
}

const std::vector<std::string>& VerticalDatum::files() const {
  return grid_->files;
}

}  // namespace tellurion::raster
