#include "truth/proof_planets.h"

#include <filesystem>

namespace tellurion::truth {
namespace {

std::string embedded(const std::string& file) {
  return TELLURION_SOURCE_DIR "/data/" + file;
}

}  // namespace

std::vector<Planet> planets(const std::string& collection) {
  std::vector<Planet> all{
      {.body = geo::earth(),
       .rasters = {embedded("earth/etopo5_dem_10min.tif"), embedded("earth/srtm3_everest_N27E086_filled.tif")},
       .places = {{.name = "earth", .where = geo::GeoRect::whole(), .finestSample_m = 18553.0},
                  {.name = "everest",
                   .where = geo::GeoRect::fromDegrees(27.02, 86.02, 27.98, 86.98),
                   .finestSample_m = 92.8}}},
      {.body = geo::mars(),
       .rasters = {embedded("mars/mola_dem_4ppd.tif")},
       .places = {{.name = "mars", .where = geo::GeoRect::whole(), .finestSample_m = 14819.0}}}};
  const std::filesystem::path folder(collection);
  const auto gabilan = folder / "earth/gabilan_lidar_dem_1m.tif";
  const auto crater = folder / "mars/gale_hrsc_dem_660m.tif";
  const auto floor = folder / "mars/gale_hirise_dem_1m.tif";
  if (collection.empty()) return all;
  if (std::filesystem::exists(gabilan)) {
    all[0].rasters.push_back(gabilan);
    all[0].places.push_back({.name = "gabilan",
                             .where = geo::GeoRect::fromDegrees(35.921, -120.824, 35.927, -120.815),
                             .finestSample_m = 1.0});
  }
  if (std::filesystem::exists(crater) && std::filesystem::exists(floor)) {
    all[1].rasters.push_back(crater);
    all[1].rasters.push_back(floor);
    all[1].places.push_back({.name = "gale",
                             .where = geo::GeoRect::fromDegrees(-4.6694, 137.3675, -4.6642, 137.3730),
                             .finestSample_m = 1.0});
  }
  return all;
}

Planet planetWithVoids(const std::string& collection) {
  Planet planet = planets({}).front();
  const auto published = std::filesystem::path(collection) / "earth/srtm3_everest_N27E086.tif";
  if (!collection.empty() && std::filesystem::exists(published)) planet.rasters.back() = published;
  planet.places = {{.name = "border",
                    .where = geo::GeoRect::fromDegrees(26.8, 85.8, 28.2, 87.2),
                    .finestSample_m = planet.places.back().finestSample_m}};
  return planet;
}

}  // namespace tellurion::truth
