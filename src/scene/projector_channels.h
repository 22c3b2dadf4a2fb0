#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/picture_projection.h"

namespace tellurion::scene {

/// One projector (or screen) of several around an eye: where its axis points, told from the camera, and where the sides
/// of its picture lie, told from that axis.
struct ProjectorChannel {
  std::string name;
  Sides sides;
  geo::Angle heading;  ///< to the right of the camera's axis, about the camera's up
  geo::Angle pitch;    ///< up, about its own right
  geo::Angle roll;     ///< to the right, about its own axis
};

/// TOML (docs/projections.md): one [[channel]] or more. At most 1 MiB and 256 channels.
io::Result<std::vector<ProjectorChannel>> readChannels(const std::string& path);
io::Result<std::vector<ProjectorChannel>> parseChannels(std::string_view text, const std::string& path);

/// Which of them --channel names; an empty name does where there is but one. `path` is what a failure tells.
io::Result<std::size_t> channelNamed(const std::vector<ProjectorChannel>& channels, std::string_view name,
                                     const std::string& path);

/// The channel's picture from the camera's eye. The ground is chosen all around the eye, and for the smallest pixel of
/// all channels drawn at this size: so all of them draw the same tiles, with the same morphs.
EyePicture pictureOf(const ProjectorChannel& channel, const std::vector<ProjectorChannel>& all, const View& camera,
                     Viewport size);

}  // namespace tellurion::scene
