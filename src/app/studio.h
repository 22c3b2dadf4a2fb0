#pragma once

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "render/context.h"
#include "render/renderer.h"
#include "scene/globe.h"

namespace tellurion::app {

/// What every subcommand that makes pictures takes.
struct PictureArguments {
  std::string scene;
  std::vector<std::string> settings;  ///< KEY=VALUE, in place of what the scene file says
  std::string size = "1024x768";
  double fov_degrees = 45.0;
  double tolerance_px = 1.0;
  double verticesPerPixel = 0.0;  ///< instead of the tolerance; 0: the tolerance counts
  double quality = 1.0;           ///< divides what may be off in pixels (scene::atQuality)
  bool automaticQuality = false;  ///< it may be lowered to hold frame_ms
  double frame_ms = 33.0;         ///< what a frame may take then
  double resolution = 1.0;        ///< pixels of the picture for one of the window, along a side (scene::atResolution)
  std::string mesh = "bisected";  ///< or "regular"
  std::string background;         ///< RRGGBB; empty: what the scene says
  double exaggeration = 1.0;
  std::string time;  ///< ISO 8601; empty: what the scene says
  bool noMorph = false;
  int maxTiles = scene::CutOptions{}.maxTiles;
  std::int64_t maxTriangles = 0;  ///< 0: any number
  int maxMebibytes = 0;           ///< likewise
  double gpuMemory_MiB = 512.0;
  bool compressTextures = false;
  bool offline = false;    ///< servers are not asked: only what is kept of them on this machine
  bool firstCome = false;  ///< servers are asked in the order in which tiles became wanted, and nothing is cancelled
  int onlineCache_MiB = 2048;  ///< on disk, of what servers gave; 0: nothing is kept
  double uploads_MiB = 8.0;    ///< copied to the GPU for one frame at most; 0: no limit

  scene::CutOptions cut() const;           ///< at quality 1
  scene::CutOptions cutAtQuality() const;  ///< at the quality that was asked for
  scene::GlobeOptions globe() const;
  render::RendererOptions renderer() const;
  scene::Viewport viewport() const;
  geo::Angle verticalFov() const { return geo::Angle::degrees(fov_degrees); }
};

enum class Pace {
  eachComplete,  ///< a picture waits for what it needs
  realTime,      ///< `--quality auto`, --frame-ms and --resolution have a meaning
};

/// SCENE, --set, --size, --fov, --tolerance, --vertices-per-pixel, --quality, --mesh, --background, --exaggeration,
/// --time,
/// --no-morph, the budgets, --offline, --cache-mib, --gpu-memory and --compress-textures, in real time --frame-ms and
/// --resolution too, checked as they are read: what is wrong is wrong use.
void addPictureArguments(CLI::App& command, PictureArguments& arguments, Pace pace);

/// --uploads, for what draws in real time; pictures that wait for their data copy what they need.
void addUploadsArgument(CLI::App& command, PictureArguments& arguments);

/// A check for an option that holds a number; CLI11's own range lets NaN through.
CLI::Validator between(double low, double high);

/// A check for an option that holds a camera.
std::string cameraProblem(const std::string& text);

/// A scene's globe, with the background that was asked for; rasters in the scene are built first, with progress on the
/// terminal, unless a stop is asked for.
io::Result<std::unique_ptr<scene::Globe>> openGlobe(const scene::Scene& scene, const PictureArguments& arguments,
                                                    const std::stop_token& stop);

/// The scene's clock, set as the arguments say.
scene::SceneClock clockOf(const scene::Scene& scene, const PictureArguments& arguments);

/// A globe and all that draws it without a window. What lives in the context stands after it and so ends before it.
struct Studio {
  std::unique_ptr<scene::Globe> globe;
  scene::SceneClock clock;  ///< as it starts
  render::HeadlessContext context;
  render::Renderer renderer;
};

io::Result<Studio> openStudio(const PictureArguments& arguments, const std::stop_token& stop);

/// To what it shows after so many seconds of a path.
void setClock(Studio& studio, double seconds);

/// Updates the globe until nothing finer is wanted for the view, the time is over, nothing is on its way any more, or a
/// stop is asked for. The frame says whether it is complete.
const scene::Frame& settledFrame(scene::Globe& globe, const scene::View& view, const scene::CutOptions& cut,
                                 std::chrono::duration<double> timeout, const std::stop_token& stop = {});

/// Says on stderr that pictures of the ground had no room on the GPU, if so; of one frame of several, `where` says
/// which
/// ("in 3 of 20 frames, ").
void warnOfMemory(const char* command, const PictureArguments& arguments, const render::RenderStatistics& drawn,
                  const std::string& where = {});

/// What keeps a frame from being what was asked for, a line each; empty when it is.
std::vector<std::string> shortcomings(const PictureArguments& arguments, const scene::Globe& globe,
                                      const scene::Frame& frame);

/// Says on stderr how far off the picture is, if a budget did not reach the tolerance; `where` likewise.
void warnOfBudget(const char* command, const PictureArguments& arguments, const scene::FrameStatistics& frame,
                  const std::string& where = {});

/// How far the eye is below the loaded ground at its place, metres; 0 above it, or where no ground is loaded.
double depthBelowGround_m(const scene::Globe& globe, const scene::View& view);

/// Prints "tellurion COMMAND: MESSAGE" and ends the subcommand with status 1.
[[noreturn]] void failRun(const char* command, const std::string& message);

/// The same with status 2, for arguments that do not go together.
[[noreturn]] void wrongUse(const char* command, const std::string& message);

/// Wrong use where two arguments, told by their options, name the same file.
void keepApart(const char* command, const char* option, const std::string& name, const char* other,
               const std::string& otherName);

}  // namespace tellurion::app
