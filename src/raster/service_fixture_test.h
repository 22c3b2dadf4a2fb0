#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include "raster/parse_number.h"
#include "raster/service.h"
#include "raster/service_url.h"

namespace tellurion::raster {

inline std::string sharedDocument(const std::string& name) {
  return (std::filesystem::path(TELLURION_SHARED_DATA_DIR) / "ogc" / name).string();
}

inline bool haveSharedDocuments() {
  return std::filesystem::exists(sharedDocument("wms"));
}

inline std::string urlOf(const GridService& service, int level, std::int64_t column, std::int64_t row) {
  return service.request({level, column, row}).url;
}

/// The message of a service that must not open.
inline std::string refusalOf(const io::Result<GridService>& service) {
  return service ? "no failure" : io::describe(service.error());
}

inline GridService opened(const ServiceLayer& entry, Kind kind = Kind::imagery, const geo::Body& body = geo::earth()) {
  io::Resources resources{io::ResourceOptions{}};
  auto service = openService(entry, kind, body, resources);
  EXPECT_TRUE(service) << refusalOf(service);
  return service ? *std::move(service) : GridService{};
}

inline std::string refusal(const ServiceLayer& entry, Kind kind = Kind::imagery) {
  io::Resources resources{io::ResourceOptions{}};
  return refusalOf(openService(entry, kind, geo::earth(), resources));
}

/// What every grid must be, whatever the protocol.
inline void expectSoundGrid(const GridService& service) {
  ASSERT_FALSE(service.levels.empty());
  EXPECT_FALSE(service.name.empty());
  double coarser = INFINITY;
  for (std::size_t i = 0; i < service.levels.size(); ++i) {
    const GridLevel& level = service.levels[i];
    EXPECT_GT(level.pixelWidth, 0.0);
    EXPECT_GT(level.pixelHeight, 0.0);
    EXPECT_LE(level.pixelWidth, coarser) << "coarsest first";
    coarser = level.pixelWidth;
    EXPECT_LE(0, level.firstColumn);
    EXPECT_LT(level.firstColumn, level.endColumn);
    EXPECT_LE(level.endColumn, level.columns);
    EXPECT_LE(0, level.firstRow);
    EXPECT_LT(level.firstRow, level.endRow);
    EXPECT_LE(level.endRow, level.rows);
    const auto request = service.request({static_cast<int>(i), level.firstColumn, level.endRow - 1});
    EXPECT_NE(request.url.find("://"), std::string::npos) << request.url;
    EXPECT_EQ(request.url.find('{'), std::string::npos) << request.url;
    EXPECT_TRUE(request.check);
    EXPECT_GT(request.maxBytes, 0u);
    EXPECT_LT(request.maxBytes, std::uint64_t{1} << 33);
  }
}

}  // namespace tellurion::raster
