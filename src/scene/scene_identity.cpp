#include "scene/scene_identity.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "io/url_secrets.h"

namespace tellurion::scene {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestTold = 200;

/// Other machines may keep their files elsewhere, but they are to be the same.
std::string told(const std::string& source) {
  if (source.find("://") != std::string::npos) return io::withoutSecrets(source);
  const fs::path path(source);
  const std::string name = path.has_filename() ? path.filename().string() : path.parent_path().filename().string();
  std::error_code error;
  const bool isFile = fs::is_regular_file(path, error);
  const std::uintmax_t size = isFile ? fs::file_size(path, error) : 0;
  return isFile && !error ? fmt::format("{} of {} bytes", name, size) : name;
}

std::string told(const std::string& source, const raster::ServiceLayer& service) {
  return service.layer.empty() ? told(source) : fmt::format("{}#{}", told(source), service.layer);
}

std::string told(const ImageryLayer& layer) {
  const auto nameOfRole = [&] {
    switch (layer.look.role) {
      case LayerRole::colour:
        return "";
      case LayerRole::nightLights:
        return "night lights, ";
      case LayerRole::water:
        return "water, ";
    }
    return "";
  };
  std::string line = fmt::format("imagery: {}{}", nameOfRole(), layer.name.empty() ? "" : layer.name + ", ");
  if (layer.derived)
    return line + (layer.derived->of ? "made of " + told(layer.derived->of->source, layer.derived->of->service)
                                     : "made of the elevation");
  if (layer.times.empty()) line += told(layer.source, layer.service);
  for (const std::string& further : layer.alsoFrom)
    line += " and " + told(further);
  if (!layer.times.empty())
    line += fmt::format("{} times from {} to {}", layer.times.size(), told(layer.times.front().source),
                        told(layer.times.back().source));
  return line;
}

std::string_view firstLine(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

/// What came over a network is not to move a terminal's cursor.
std::string quoted(std::string_view line) {
  std::string text(line.substr(0, kLongestTold));
  std::ranges::replace_if(
      text, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, '?');
  return text.empty() ? "nothing more" : "'" + text + "'";
}

}  // namespace

std::string identityOf(const Scene& scene) {
  const geo::Ellipsoid& ellipsoid = scene.body.ellipsoid;
  std::string text = fmt::format("body: {}, {} m, flattening {}\ntiling: {}\n", scene.body.name,
                                 ellipsoid.semiMajorAxis_m(), ellipsoid.flattening(), tiling::nameOf(scene.tiling));
  for (const ElevationLayer& layer : scene.elevation) {
    text += "elevation: " + told(layer.source, layer.service);
    text += layer.seam_m ? fmt::format(", seam of {} m\n", *layer.seam_m) : "\n";
  }
  for (const ImageryLayer& layer : scene.imagery)
    text += told(layer) + "\n";
  const Atmosphere& air = scene.air.atmosphere;
  if (air != Atmosphere{})
    text += fmt::format("air: {} to {} m, gas {} {} m, aerosol {} {} m {} {}, ozone {} {} m {} m, ground {}, sun {}\n",
                        air.bottom_m, air.top_m, air.gasDepth, air.gasHeight_m, air.aerosolDepth, air.aerosolHeight_m,
                        air.aerosolAlbedo, air.aerosolForward, air.ozoneDepth, air.ozoneMiddle_m, air.ozoneReach_m,
                        air.groundAlbedo, air.sunRadius_degrees);
  if (scene.sky.stars) text += fmt::format("sky: {} stars\n", scene.sky.stars->stars.size());
  return text;
}

std::string differenceOf(std::string_view leaders, std::string_view own) {
  while (!leaders.empty() || !own.empty()) {
    const std::string_view theirs = firstLine(leaders);
    const std::string_view ours = firstLine(own);
    if (theirs != ours)
      return fmt::format("the leader shows another scene: it has {}, this machine {}; give all machines the same",
                         quoted(theirs), quoted(ours));
  }
  return "";
}

}  // namespace tellurion::scene
