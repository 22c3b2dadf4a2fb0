#include "scene/sky_entry.h"

#include "scene/source_entry.h"

namespace tellurion::scene {
namespace {

constexpr double kMostStops = 20.0;

std::shared_ptr<const StarCatalogue> starsFrom(const Entry& entry, const std::filesystem::path& folder) {
  if (!entry.isText()) return asBoolean(entry) ? brightStars() : nullptr;
  auto read = readStarFile(sourceAt(entry, folder));
  if (!read) throw EntryFault{std::move(read.error())};
  return std::make_shared<const StarCatalogue>(std::move(*read));
}

}  // namespace

SkySettings readSky(const Entry& table, const std::filesystem::path& folder) {
  allow(table, {"enabled", "stars", "brightness", "discs"});
  SkySettings out{.enabled = booleanAt(table, "enabled", true), .stars = {}, .brightness_stops = 0.0, .discs = true};
  const Entry* stars = find(table, "stars");
  out.stars = stars ? starsFrom(*stars, folder) : brightStars();
  out.brightness_stops = numberAt(table, "brightness", -kMostStops, kMostStops, 0.0);
  out.discs = booleanAt(table, "discs", true);
  return out;
}

}  // namespace tellurion::scene
