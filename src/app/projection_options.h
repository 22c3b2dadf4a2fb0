#pragma once

#include <CLI/CLI.hpp>
#include <chrono>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "app/studio.h"
#include "render/picture_maker.h"
#include "scene/projector_channels.h"

namespace tellurion::app {

/// How directions become a picture, for `render` and `fly`.
struct ProjectionArguments {
  std::string projection = "perspective";
  double aperture_degrees = 180.0;
  double tilt_degrees = 0.0;
  std::optional<double> eyeSeparation_m;
  std::string frustum;  ///< a file of channels
  std::string channel;
  int piece_px = 0;  ///< side of the largest part drawn at once; 0: what suits
};

/// --projection, --aperture, --tilt, --eye-separation, --frustum, --channel and --piece, checked as they are read.
void addProjectionOptions(CLI::App& command, ProjectionArguments& arguments);

/// What the options ask for, checked against each other: wrong use ends the subcommand. Sets the picture's size where
/// it was not given and 1024x768 does not suit the projection.
struct PictureRequest {
  scene::PictureShape shape;
  std::vector<scene::ProjectorChannel> channels;  ///< of --frustum; empty: none
  std::size_t channel = 0;                        ///< the one that is drawn
  std::vector<scene::PixelRect> pieces;
};
io::Result<PictureRequest> requestOf(const CLI::App& command, const ProjectionArguments& arguments,
                                     PictureArguments& picture);

/// How long a frame is waited for.
struct Patience {
  std::chrono::duration<double> timeout;
  std::stop_token stop;
};

/// Of the picture from a camera of this studio. Waits for the ground under the eye where a stereo pair asks for its
/// height above it.
std::vector<scene::EyePicture> eyesOf(const PictureRequest& request, const scene::Camera& camera, Studio& studio,
                                      const PictureArguments& picture, const Patience& patience);

/// A frame that was waited for, before it is drawn; what fails here ends the picture.
using FrameCheck = std::function<io::Result<void>(const scene::Frame& frame)>;
/// The next rows of a picture, as wide as it is.
using RowSink = std::function<io::Result<void>(const render::PicturePiece& rows)>;

/// Waits for the frames of the eyes, and draws the picture from its top. A picture in several pieces shows its progress
/// on a terminal.
io::Result<void> drawPicture(const PictureRequest& request, const std::vector<scene::EyePicture>& eyes, Studio& studio,
                             render::PictureMaker& maker, const PictureArguments& picture, const Patience& patience,
                             bool withDistances, const FrameCheck& check, const RowSink& sink);

}  // namespace tellurion::app
