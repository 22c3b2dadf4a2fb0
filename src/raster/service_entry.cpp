#include "raster/service_entry.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "raster/near_names.h"
#include "raster/service_url.h"

namespace tellurion::raster {
namespace {

/// The best first. Names as servers have them, without parameters.
constexpr std::array kImageryFormats = {"image/png",  "image/png8",    "image/webp", "image/jpeg",
                                        "image/tiff", "image/geotiff", "image/gif"};
/// What no height in a colour survives: few colours, or others.
constexpr std::array kLossyFormats = {"image/jpeg", "image/png8", "image/gif"};
constexpr std::array kHeightFormats = {"image/tiff",        "image/geotiff",     "image/tiff16",
                                       "application/bil32", "application/bil16", "application/bil",
                                       "image/bil",         "image/png16",       "image/png"};

std::string withoutParameters(std::string_view format) {
  std::string name = lowered(format.substr(0, format.find(';')));
  while (name.ends_with(' '))
    name.pop_back();
  return name == "image/jpg" ? "image/jpeg" : name;
}

const std::string* findFormat(std::string_view wanted, std::span<const std::string> offered) {
  auto found = std::ranges::find(offered, wanted);
  if (found == offered.end())
    found = std::ranges::find_if(offered, [&](const auto& format) { return lowered(format) == lowered(wanted); });
  if (found == offered.end())
    found =
        std::ranges::find_if(offered, [&](const auto& f) { return withoutParameters(f) == withoutParameters(wanted); });
  return found == offered.end() ? nullptr : &*found;
}

std::string joined(std::span<const std::string> names) {
  constexpr std::size_t kMost = 12;
  return fmt::format("{}{}", fmt::join(names.subspan(0, std::min(kMost, names.size())), ", "),
                     names.size() > kMost ? ", ..." : "");
}

}  // namespace

io::Result<HeightEncoding> heightEncoding(const ServiceLayer& layer) {
  HeightEncoding heights;
  heights.scale = layer.scale.value_or(1.0);
  heights.offset_m = layer.offset_m.value_or(0.0);
  heights.nodata = layer.nodata;
  if (layer.byteOrder == "big") {
    heights.bigEndian = true;
  } else if (!layer.byteOrder.empty() && layer.byteOrder != "little") {
    return io::fail(io::Failure::Code::invalidArgument,
                    fmt::format("there is no byte order '{}'; there are little and big", layer.byteOrder));
  }
  const std::vector<std::string> names = {"band", "terrarium", "mapbox", "centimetre"};
  constexpr std::array kKinds = {HeightEncoding::Kind::band, HeightEncoding::Kind::terrarium,
                                 HeightEncoding::Kind::mapboxRgb, HeightEncoding::Kind::centimetreRgb};
  if (layer.encoding.empty()) return heights;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] != layer.encoding) continue;
    heights.kind = kKinds[i];
    return heights;
  }
  return io::fail(io::Failure::Code::invalidArgument,
                  fmt::format("there is no encoding '{}'{}", layer.encoding, whatElseThereIs(layer.encoding, names)));
}

geo::GeoRect boundsOf(const ServiceLayer& layer, const std::optional<std::array<double, 4>>& server_degrees) {
  const auto& box = layer.bounds_degrees ? layer.bounds_degrees : server_degrees;
  if (!box) return geo::GeoRect::whole();
  const auto& [west, south, east, north] = *box;
  return geo::GeoRect::fromDegrees(std::clamp(south, -90.0, 90.0), west, std::clamp(north, -90.0, 90.0), east);
}

io::Result<std::string> chooseFormat(const ServiceLayer& layer, Kind kind, std::span<const std::string> offered) {
  if (!layer.format.empty()) {
    if (offered.empty()) return layer.format;
    if (const std::string* found = findFormat(layer.format, offered)) return *found;
    return io::fail(io::Failure::Code::notFound,
                    fmt::format("there is no format '{}'; there are {}", layer.format, joined(offered)));
  }
  const bool coloured = !layer.encoding.empty() && layer.encoding != "band";
  const bool wantsHeights = kind == Kind::elevation && !coloured;
  const std::span<const char* const> wanted =
      wantsHeights ? std::span<const char* const>(kHeightFormats) : std::span<const char* const>(kImageryFormats);
  if (offered.empty()) return std::string(wantsHeights ? "image/tiff" : "image/png");
  for (const char* format : wanted) {
    const std::string* found = findFormat(format, offered);
    const bool lossy =
        kind == Kind::elevation && std::ranges::find(kLossyFormats, std::string_view(format)) != kLossyFormats.end();
    if (found != nullptr && !lossy) return *found;
  }
  return io::fail(io::Failure::Code::unsupported,
                  fmt::format("none of the formats offered can be used for {}: {}", nameOf(kind), joined(offered)));
}

int rawSampleBytes(std::string_view format) {
  const std::string name = withoutParameters(format);
  if (name.ends_with("bil32")) return 4;
  return name.ends_with("bil16") || name.ends_with("bil") ? 2 : 0;
}

std::string extensionOf(std::string_view format) {
  const std::string name = withoutParameters(format);
  const std::string last = name.substr(name.rfind('/') == name.npos ? 0 : name.rfind('/') + 1);
  if (last == "jpeg") return "jpg";
  if (last.starts_with("png")) return "png";
  if (last.ends_with("tiff")) return "tif";
  return last.starts_with("bil") ? "bil" : last;
}

io::ResourceRequest imageRequest(std::string url, const std::string& dataset, const ExpectedImage& expected) {
  constexpr std::uint64_t kMostBytesAPixel = 16;
  constexpr std::uint64_t kMostBesides = std::uint64_t{1} << 20;
  constexpr std::uint64_t kMostBytes = std::uint64_t{128} << 20;  // 4096 x 4096 pixels of 8 bytes
  io::ResourceRequest request;
  request.url = std::move(url);
  request.dataset = dataset;
  const std::uint64_t pixels = static_cast<std::uint64_t>(expected.width) * static_cast<std::uint64_t>(expected.height);
  request.maxBytes = std::min(std::min(pixels, kMostBytes) * kMostBytesAPixel + kMostBesides, kMostBytes);
  request.check = [expected](const io::Resource& resource) { return checkImage(resource, expected); };
  return request;
}

}  // namespace tellurion::raster
