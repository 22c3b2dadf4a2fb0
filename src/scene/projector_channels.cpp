#include "scene/projector_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "scene/entry.h"
#include "scene/scene_toml.h"

namespace tellurion::scene {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr std::uintmax_t kLargestFile = 1u << 20;
constexpr std::size_t kMostChannels = 256;
constexpr double kSteepest_degrees = 89.0;

double degreesAt(const Entry& table, std::string_view key, double low, double high) {
  const Entry* entry = find(table, key);
  if (entry == nullptr) complain(table.where, fmt::format("a [[channel]] needs '{}', degrees", key));
  return asNumber(*entry, low, high);
}

double tangentAt(const Entry& table, std::string_view key) {
  return std::tan(geo::Angle::degrees(degreesAt(table, key, -kSteepest_degrees, kSteepest_degrees)).radians());
}

ProjectorChannel channelFrom(const Entry& table) {
  allow(asTable(table),
        {"name", "left_degrees", "right_degrees", "bottom_degrees", "top_degrees", "heading", "pitch", "roll"});
  const auto turn = [&](std::string_view key, double most) {
    return geo::Angle::degrees(numberAt(table, key, -most, most, 0.0));
  };
  ProjectorChannel channel{.name = textAt(table, "name").value_or(""),
                           .sides = {.left = tangentAt(table, "left_degrees"),
                                     .right = tangentAt(table, "right_degrees"),
                                     .bottom = tangentAt(table, "bottom_degrees"),
                                     .top = tangentAt(table, "top_degrees")},
                           .heading = turn("heading", 360.0),
                           .pitch = turn("pitch", 180.0),
                           .roll = turn("roll", 360.0)};
  if (channel.name.empty()) complain(table.where, "a [[channel]] needs a 'name', which --channel asks for");
  if (!(channel.sides.left < channel.sides.right && channel.sides.bottom < channel.sides.top))
    complain(
        table.where,
        "left_degrees must be less than right_degrees, and bottom_degrees less than top_degrees; left of and below "
        "the channel's axis is negative");
  return channel;
}

std::vector<ProjectorChannel> channelsFrom(const Entry& root) {
  allow(root, {"channel"});
  const std::vector<const Entry*> tables = tablesAt(root, "channel");
  if (tables.empty()) complain(root.where, "has no [[channel]]");
  if (tables.size() > kMostChannels) complain(root.where, fmt::format("has more than {} channels", kMostChannels));
  std::vector<ProjectorChannel> channels;
  for (const Entry* table : tables) {
    channels.push_back(channelFrom(*table));
    const auto isSame = [&](const ProjectorChannel& c) { return c.name == channels.back().name; };
    if (std::ranges::count_if(channels, isSame) > 1)
      complain(table->where, fmt::format("there are two channels '{}'", channels.back().name));
  }
  return channels;
}

geo::Mat3 channelFromView(const ProjectorChannel& channel) {
  const auto heading = geo::sinCos(channel.heading);
  const auto pitch = geo::sinCos(channel.pitch);
  const auto roll = geo::sinCos(channel.roll);
  const geo::Vec3 level(heading.cos, 0.0, heading.sin);
  const geo::Vec3 forward(pitch.cos * heading.sin, pitch.sin, -pitch.cos * heading.cos);
  const geo::Vec3 upright = geo::cross(level, forward);
  const geo::Vec3 right = level * roll.cos - upright * roll.sin;
  const geo::Vec3 up = upright * roll.cos + level * roll.sin;
  return glm::transpose(geo::Mat3(right, up, -forward));
}

}  // namespace

io::Result<std::vector<ProjectorChannel>> parseChannels(std::string_view text, const std::string& path) {
  const auto root = readToml(text, path, {});
  if (!root) return tl::unexpected(root.error());
  try {
    return channelsFrom(*root);
  } catch (const EntryFault& fault) {
    io::Failure failure = fault.failure;
    if (failure.where.empty()) failure.where = path;
    return tl::unexpected(std::move(failure));
  }
}

io::Result<std::vector<ProjectorChannel>> readChannels(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) return io::fail(Code::notFound, "the file of channels cannot be read: " + error.message(), path);
  if (size > kLargestFile) return io::fail(Code::invalidArgument, "a file of channels has at most 1 MiB", path);
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) return io::fail(Code::ioError, "the file of channels cannot be read", path);
  return parseChannels(text.str(), path);
}

io::Result<std::size_t> channelNamed(const std::vector<ProjectorChannel>& channels, std::string_view name,
                                     const std::string& path) {
  if (name.empty() && channels.size() == 1) return 0;
  std::string names;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i].name == name) return i;
    names += (i == 0 ? "" : ", ") + channels[i].name;
  }
  return io::fail(Code::invalidArgument,
                  name.empty() ? "say which channel with --channel: " + names
                               : fmt::format("has no channel '{}'; it has {}", name, names),
                  path);
}

EyePicture pictureOf(const ProjectorChannel& channel, const std::vector<ProjectorChannel>& all, const View& camera,
                     Viewport size) {
  const auto viewOf = [&](const ProjectorChannel& c) {
    View view = camera;
    view.viewport = size;
    view.offAxis = c.sides;
    view.agreedPixelAngle.reset();
    return view;
  };
  View view = viewOf(channel);
  double smallest = view.pixelAngle();
  for (const ProjectorChannel& each : all)
    smallest = std::min(smallest, viewOf(each).pixelAngle());
  view.agreedPixelAngle = smallest;
  view.viewFromBody = channelFromView(channel) * camera.viewFromBody;
  EyePicture eye{.cut = camera, .panes = {{.place = {0, 0, size.width, size.height}, .view = view}}, .warp = {}};
  eye.cut.agreedPixelAngle = smallest;
  eye.cut.isAllAround = true;
  return eye;
}

}  // namespace tellurion::scene
