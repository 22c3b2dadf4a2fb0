#pragma once

// Image trees on disk, made for one test out of a function of place, and read through file:// addresses.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geo/seed_test.h"
#include "raster/codec.h"
#include "raster/grid_tile_source.h"
#include "raster/projection.h"
#include "raster/raster_fixture_test.h"
#include "raster/tile_places.h"

namespace tellurion::raster::testing {

/// Smooth on the whole sphere: no wave shorter than a fifth of a turn.
inline std::array<double, 3> smoothColour(const geo::Direction& d) {
  return {128.0 + 100.0 * std::sin(3.0 * d.n.x + 1.0), 128.0 + 90.0 * std::cos(4.0 * d.n.y + d.n.z),
          128.0 + 100.0 * std::sin(2.0 * d.n.z - 3.0 * d.n.y)};
}
inline double smoothHeight_m(const geo::Direction& d) {
  return 2000.0 * std::sin(3.0 * d.n.x + 1.0) + 1500.0 * std::cos(4.0 * d.n.y + d.n.z);
}
inline Rgba8 pixelOf(const std::array<double, 3>& colour) {
  const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround(v)); };
  return {byte(colour[0]), byte(colour[1]), byte(colour[2]), 255};
}
/// R * 256 + G + B / 256 - 32768.
inline Rgba8 terrariumOf(double height_m) {
  const auto code = static_cast<std::uint32_t>(std::lround((height_m + 32768.0) * 256.0));
  return {static_cast<std::uint8_t>(code >> 16u), static_cast<std::uint8_t>(code >> 8u),
          static_cast<std::uint8_t>(code), 255};
}
inline double largestDifference(const Rgba8& p, const std::array<double, 3>& colour) {
  return std::max({std::abs(p.r - colour[0]), std::abs(p.g - colour[1]), std::abs(p.b - colour[2])});
}

/// The inverse of a plane, one point at a time.
class PlaneInverse {
 public:
  PlaneInverse(const MapPlane& plane, const geo::Body& body)
      : plane_(plane), radius_m_(body.ellipsoid.semiMajorAxis_m()) {
    if (plane.kind == MapPlane::Kind::other)
      projection_ = Projection::fromWgs84(plane.definition, std::nullopt).value();
  }
  std::optional<geo::Direction> operator()(double x, double y) const {
    switch (plane_.kind) {
      case MapPlane::Kind::lonLat:
        break;
      case MapPlane::Kind::webMercator:
        x = x / radius_m_ * 180.0 / geo::kPi;
        y = std::atan(std::sinh(y / radius_m_)) * 180.0 / geo::kPi;
        break;
      case MapPlane::Kind::other:
        projection_->inverse({&x, 1}, {&y, 1});
        break;
    }
    if (!std::isfinite(x) || !std::isfinite(y) || std::abs(y) > 90.0) return std::nullopt;
    return geo::directionFromDegrees(y, x);
  }

 private:
  MapPlane plane_;
  double radius_m_;
  std::optional<Projection> projection_;
};

/// Levels that halve the pixel each time, over a rectangle.
inline std::vector<GridLevel> halvingLevels(double left, double top, double imageSide, int columns, int rows, int side,
                                            int count) {
  std::vector<GridLevel> levels;
  for (int i = 0; i < count; ++i) {
    const int times = 1 << i;
    levels.push_back({.left = left,
                      .top = top,
                      .pixelWidth = imageSide / times / side,
                      .pixelHeight = imageSide / times / side,
                      .imageWidth = side,
                      .imageHeight = side,
                      .columns = columns * times,
                      .rows = rows * times,
                      .endColumn = columns * times,
                      .endRow = rows * times});
  }
  return levels;
}

inline GridService lonLatService(int levels, int side = 64) {
  GridService service{.name = "lonlat", .levels = halvingLevels(-180.0, 90.0, 180.0, 2, 1, side, levels)};
  return service;
}
inline GridService mercatorService(int levels, int side = 64) {
  const double half = geo::kPi * geo::earth().ellipsoid.semiMajorAxis_m();
  GridService service{.name = "mercator", .levels = halvingLevels(-half, half, 2.0 * half, 1, 1, side, levels)};
  service.plane.kind = MapPlane::Kind::webMercator;
  return service;
}
/// The south to 65 degrees and some more in the corners.
inline GridService polarService(int levels, int side = 64) {
  GridService service{.name = "polar", .levels = halvingLevels(-2.8e6, 2.8e6, 5.6e6, 1, 1, side, levels)};
  service.plane = {MapPlane::Kind::other, "EPSG:3031"};
  return service;
}

/// Writes all images of a service that `exists` keeps, as PNG, and has the service ask for them.
inline void writeImages(GridService& service, const ScratchFolder& folder,
                        const std::function<bool(const GridImageId&)>& exists = {}) {
  const std::string path = folder.file(service.name);
  const PlaneInverse inverse(service.plane, service.body);
  const auto nameOf = [path](const GridImageId& id) {
    return path + "_" + std::to_string(id.level) + "_" + std::to_string(id.column) + "_" + std::to_string(id.row);
  };
  for (int z = 0; z < static_cast<int>(service.levels.size()); ++z) {
    const GridLevel& l = service.levels[static_cast<std::size_t>(z)];
    for (std::int64_t i = 0; i < l.columns * l.rows; ++i) {
      const GridImageId id{z, i % l.columns, i / l.columns};
      if (exists && !exists(id)) continue;
      Raster<Rgba8> image(l.imageWidth, l.imageHeight);
      for (int row = 0; row < l.imageHeight; ++row) {
        for (int col = 0; col < l.imageWidth; ++col) {
          const double x = l.left + (static_cast<double>(id.column * l.imageWidth + col) + 0.5) * l.pixelWidth;
          const double y = l.top - (static_cast<double>(id.row * l.imageHeight + row) + 0.5) * l.pixelHeight;
          const auto place = inverse(x, y);
          if (!place) continue;
          image.at(col, row) =
              service.kind == Kind::imagery ? pixelOf(smoothColour(*place)) : terrariumOf(smoothHeight_m(*place));
        }
      }
      const auto bytes = encodeImage(image, ImageFormat::png, 100).value();
      std::ofstream(nameOf(id), std::ios::binary)
          .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    }
  }
  if (service.kind == Kind::elevation) service.heights.kind = HeightEncoding::Kind::terrarium;
  service.request = [nameOf](const GridImageId& id) {
    return io::ResourceRequest{.url = "file://" + nameOf(id), .dataset = "test"};
  };
}

inline std::shared_ptr<io::Resources> localResources() {
  return std::make_shared<io::Resources>(io::ResourceOptions{});
}

inline std::shared_ptr<const TileSource> sourceOrDie(const GridService& service, tiling::Scheme scheme,
                                                     const GridTileOptions& options = {.tileCells = 64}) {
  auto source = gridTileSource(service, scheme, localResources(), options);
  if (!source) {
    ADD_FAILURE() << io::describe(source.error());
    std::abort();
  }
  return *source;
}

/// Calls visit(column, row, place) for the samples of a tile, gutter included but for its corners.
template <class Visit>
void forEachPlace(const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind, int cells, const Visit& visit) {
  const int side = sideOf(kind, cells);
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      if ((row == 0 || row == side - 1) && (column == 0 || column == side - 1)) continue;
      if (const auto place = placeOf(tiling, id, kind, cells, column, row)) visit(column, row, *place);
    }
  }
}

inline tiling::TileId randomTile(std::mt19937_64& random, const tiling::Tiling& tiling, int level) {
  const auto side = std::uint32_t{1} << level;
  const auto pick = [&](std::uint32_t count) { return static_cast<std::uint32_t>(random() % count); };
  return {.level = static_cast<std::uint8_t>(level),
          .root = static_cast<std::uint8_t>(pick(static_cast<std::uint32_t>(tiling.rootCount()))),
          .x = pick(side),
          .y = pick(side)};
}

}  // namespace tellurion::raster::testing
