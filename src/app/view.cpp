#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "app/config_file.h"
#include "app/follow_loop.h"
#include "app/progress.h"
#include "app/shipped_places.h"
#include "app/step_options.h"
#include "app/studio.h"
#include "app/subcommands.h"
#include "app/view_loop.h"
#include "app/view_start.h"
#include "scene/scene_identity.h"
#include "scene/star_catalogue.h"

namespace tellurion::app {
namespace {

struct ViewArguments {
  PictureArguments picture{.size = "1280x800", .automaticQuality = true};
  std::string camera;
  std::string path;      ///< key frames to begin with
  std::string places;    ///< further ones
  double uiScale = 0.0;  ///< WindowOptions::uiScale
  int screen = 0;        ///< WindowOptions::screen
  bool fresh = false;    ///< nothing is remembered, neither from before nor for later
  bool hasSize = false;  ///< --size was given
  StepArguments step;
};

// Without the folder, where the scene is one file.
std::string titleOf(const std::string& scene) {
  const bool several = scene.find(',') != std::string::npos;
  return (several ? scene : std::filesystem::path(scene).filename().string()) + " - Tellurion";
}

scene::View startView(const ViewArguments& arguments, const scene::Scene& scene) {
  const geo::Angle fov = arguments.picture.verticalFov();
  const auto given = scene::parseCamera(arguments.camera);
  return scene::viewOf(given ? *given : startCamera(scene, fov), scene.body.ellipsoid, fov,
                       arguments.picture.viewport());
}

ViewQuality qualityFrom(const PictureArguments& picture) {
  return {.full = picture.quality,
          .isAutomatic = picture.automaticQuality,
          .frame_ms = picture.frame_ms,
          .resolution = picture.resolution};
}

io::Result<scene::Gazetteer> placesOf(const ViewArguments& arguments, const std::string& body) {
  scene::Gazetteer places;
  if (const auto shipped = shippedPlaces(body); !shipped.empty()) {
    if (const auto added = places.add(shipped, body, "places"); !added) return tl::unexpected(added.error());
  }
  if (arguments.places.empty()) return places;
  if (const auto added = places.addFile(arguments.places, body); !added) return tl::unexpected(added.error());
  return places;
}

constexpr const char* kMemoryFile = "viewer.toml";

/// What cannot be understood is told and put aside.
scene::ViewerMemory readMemory() {
  const auto text = readConfig(kMemoryFile);
  if (text && !*text) return {};
  const auto memory = text ? scene::parseViewerMemory(**text, configPath(kMemoryFile))
                           : io::Result<scene::ViewerMemory>(tl::unexpected(text.error()));
  if (memory) return *memory;
  fmt::print(stderr, "tellurion view: warning: {}; kept as {}, and begun anew\n", io::describe(memory.error()),
             setAsideConfig(kMemoryFile));
  return {};
}

void writeMemory(const scene::ViewerMemory& memory) {
  const auto written = writeConfig(kMemoryFile, scene::formatViewerMemory(memory));
  if (!written) fmt::print(stderr, "tellurion view: warning: {}\n", io::describe(written.error()));
}

/// A window with all that draws in it.
struct Stage {
  ViewWindow window;
  std::unique_ptr<scene::Globe> globe;
  render::Renderer renderer;
};

io::Result<Stage> openStage(const ViewArguments& arguments, const scene::Scene& scene, const InterruptStop& interrupt) {
  auto window = ViewWindow::open(
      titleOf(scene.name),
      {.size = arguments.picture.viewport(), .uiScale = arguments.uiScale, .screen = arguments.screen});
  if (!window) return tl::unexpected(window.error());
  auto globe = openGlobe(scene, arguments.picture, interrupt.token());
  if (!globe) return tl::unexpected(globe.error());
  auto renderer = render::Renderer::create(arguments.picture.renderer());
  if (!renderer) return tl::unexpected(renderer.error());
  if (scene.air.enabled) {
    if (const auto ready = renderer->prepareAir(); !ready) return tl::unexpected(ready.error());
  }
  if (scene.sky.enabled) {
    if (const auto ready = renderer->prepareSky(); !ready) return tl::unexpected(ready.error());
  }
  // For V, that of this window or of one that it follows, to switch on.
  if (!scene.sky.enabled && !(*globe)->sky().stars) (*globe)->sky().stars = scene::brightStars();
  return Stage{std::move(*window), std::move(*globe), std::move(*renderer)};
}

io::Result<FollowedChannel> channelOf(const StepArguments& asked) {
  if (asked.frustum.empty()) return FollowedChannel{};
  auto channels = scene::readChannels(asked.frustum);
  if (!channels) return tl::unexpected(channels.error());
  const auto which = scene::channelNamed(*channels, asked.channel, asked.frustum);
  if (!which) return tl::unexpected(which.error());
  return FollowedChannel{.all = std::move(*channels), .which = *which};
}

io::Result<void> follow(const ViewArguments& arguments, const scene::Scene& scene) {
  const StepArguments& asked = arguments.step;
  auto channel = channelOf(asked);
  if (!channel) return tl::unexpected(channel.error());
  auto secret = readStepSecret(asked);
  if (!secret) return tl::unexpected(secret.error());
  const auto leader = io::parseNetAddress(asked.follow);
  if (!leader) return tl::unexpected(leader.error());
  auto log = FramesLog::open(asked.framesLog);
  if (!log) return tl::unexpected(log.error());
  const InterruptStop interrupt;
  auto stage = openStage(arguments, scene, interrupt);
  if (!stage) return tl::unexpected(stage.error());
  const std::stop_callback closeOnStop(interrupt.token(), [&] { stage->window.closeSoon(); });
  const auto check = [own = scene::identityOf(scene)](std::string_view greeting) -> io::Result<void> {
    std::string difference = scene::differenceOf(greeting, own);
    if (difference.empty()) return {};
    return io::fail(io::Failure::Code::invalidArgument, std::move(difference));
  };
  const auto link = io::StepFollower::follow(
      {.leader = *leader, .secret = std::move(*secret), .check = check, .wake = [&] { stage->window.wake(); }});
  if (!link) return tl::unexpected(link.error());
  FollowLoop loop(stage->window, *stage->globe, std::move(stage->renderer), **link, titleOf(scene.name),
                  arguments.picture.cut(), std::move(*channel), std::move(*log));
  return loop.run();
}

io::Result<void> view(ViewArguments arguments) {
  const auto scene =
      scene::openScene(arguments.picture.scene, arguments.picture.settings, arguments.picture.globe().online);
  if (!scene) return tl::unexpected(scene.error());
  if (arguments.step.follows()) return follow(arguments, *scene);
  auto places = placesOf(arguments, scene->body.name);
  if (!places) return tl::unexpected(places.error());
  std::vector<scene::KeyFrame> frames;
  if (!arguments.path.empty()) {
    const auto path = scene::readCameraPath(arguments.path);
    if (!path) return tl::unexpected(path.error());
    frames = scene::keyFramesOf(path->keys());
  }
  const scene::ViewerMemory memory = arguments.fresh ? scene::ViewerMemory() : readMemory();
  if (memory.window && !arguments.hasSize)
    arguments.picture.size = fmt::format("{}x{}", memory.window->width, memory.window->height);
  const InterruptStop interrupt;
  auto stage = openStage(arguments, *scene, interrupt);
  if (!stage) return tl::unexpected(stage.error());
  const std::stop_callback closeOnStop(interrupt.token(), [&] { stage->window.closeSoon(); });
  std::optional<Leading> leading;
  if (arguments.step.leads()) {
    auto begun = Leading::begin(arguments.step, *scene, [&] { stage->window.wake(); });
    if (!begun) return tl::unexpected(begun.error());
    leading = std::move(*begun);
  }
  ViewLoop loop(stage->window, *stage->globe, scene->tiling, titleOf(scene->name), std::move(stage->renderer),
                startView(arguments, *scene), arguments.picture.cut(), qualityFrom(arguments.picture),
                clockOf(*scene, arguments.picture), std::move(*places), arguments.picture.offline);
  if (leading) loop.lead(*leading);
  if (!frames.empty()) loop.travel().setKeyFrames(std::move(frames));
  if (!arguments.fresh) loop.remember(memory);
  const auto done = loop.run();
  if (!arguments.fresh && loop.remembered() != memory) writeMemory(loop.remembered());
  return done;
}

}  // namespace

void addView(CLI::App& program) {
  auto arguments = std::make_shared<ViewArguments>();
  CLI::App* command = program.add_subcommand("view", "Opens an interactive window on a scene (docs/viewer.md)");
  addPictureArguments(*command, arguments->picture, Pace::realTime);
  addUploadsArgument(*command, arguments->picture);
  command
      ->add_option("--camera", arguments->camera,
                   "LAT,LON,HEIGHT,HEADING,PITCH,ROLL in degrees and metres, of which the last ones may be left out "
                   "(HEADING 0, PITCH -90, ROLL 0); without it, above the data")
      ->check(cameraProblem);
  command
      ->add_option("--path", arguments->path,
                   "CSV: seconds,lat,lon,height_m,heading,pitch,roll: key frames to begin with (J shows them)")
      ->check(CLI::ExistingFile);
  command
      ->add_option("--places", arguments->places,
                   "CSV: name,lat,lon and size_km, population: further places that G finds (docs/viewer.md)")
      ->check(CLI::ExistingFile);
  command
      ->add_flag("--fullscreen{1}", arguments->screen,
                 "Fill the main screen, or with --fullscreen=N the N-th, in its own size in place of --size")
      ->type_name("N");
  command
      ->add_option("--ui-scale", arguments->uiScale,
                   "How large letters and panels are, 1 for an ordinary screen; else as the screen asks for")
      ->check(between(0.5, 8.0));
  command->add_flag("--fresh", arguments->fresh,
                    "Begin as the first time, and remember nothing of this window: its size and open panels");
  addStepOptions(*command, arguments->step);
  command->footer(
      "In the window H shows the controls. C prints the camera as --camera takes it.\n\n"
      "Example: Earth, once ./bootstrap demo has made its tile databases\n"
      "  tellurion view data/earth.toml");
  command->callback([arguments, command] {
    checkStepOptions(*command, arguments->step);
    arguments->hasSize = command->count("--size") > 0;
    if (const auto done = view(*arguments); !done) failRun("view", io::describe(done.error()));
  });
}

}  // namespace tellurion::app
