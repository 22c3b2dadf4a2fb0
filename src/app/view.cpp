#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "app/progress.h"
#include "app/shipped_places.h"
#include "app/studio.h"
#include "app/subcommands.h"
#include "app/view_loop.h"
#include "app/view_start.h"

namespace tellurion::app {
namespace {

struct ViewArguments {
  PictureArguments picture{.size = "1280x800", .automaticQuality = true};
  std::string camera;
  std::string path;    ///< key frames to begin with
  std::string places;  ///< further ones
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
  return {.full = picture.quality, .isAutomatic = picture.automaticQuality, .frame_ms = picture.frame_ms};
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

io::Result<void> view(const ViewArguments& arguments) {
  const auto scene =
      scene::openScene(arguments.picture.scene, arguments.picture.settings, arguments.picture.globe().online);
  if (!scene) return tl::unexpected(scene.error());
  auto places = placesOf(arguments, scene->body.name);
  if (!places) return tl::unexpected(places.error());
  std::vector<scene::KeyFrame> frames;
  if (!arguments.path.empty()) {
    const auto path = scene::readCameraPath(arguments.path);
    if (!path) return tl::unexpected(path.error());
    frames = scene::keyFramesOf(path->keys());
  }
  auto window = ViewWindow::open(titleOf(scene->name), arguments.picture.viewport());
  if (!window) return tl::unexpected(window.error());
  const InterruptStop interrupt;
  auto globe = openGlobe(*scene, arguments.picture, interrupt.token());
  if (!globe) return tl::unexpected(globe.error());
  auto renderer = render::Renderer::create(arguments.picture.renderer());
  if (!renderer) return tl::unexpected(renderer.error());
  if (scene->air.enabled) {
    if (const auto ready = renderer->prepareAir(); !ready) return tl::unexpected(ready.error());
  }
  if (scene->sky.enabled) {
    if (const auto ready = renderer->prepareSky(); !ready) return tl::unexpected(ready.error());
  }
  const std::stop_callback closeOnStop(interrupt.token(), [&window] { window->closeSoon(); });
  ViewLoop loop(*window, **globe, scene->tiling, titleOf(scene->name), std::move(*renderer),
                startView(arguments, *scene), arguments.picture.cut(), qualityFrom(arguments.picture),
                clockOf(*scene, arguments.picture), std::move(*places));
  if (!frames.empty()) loop.travel().setKeyFrames(std::move(frames));
  return loop.run();
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
  command->footer(
      "In the window H shows the controls. C prints the camera as --camera takes it.\n\n"
      "Example: Earth, once ./bootstrap demo has made its tile databases\n"
      "  tellurion view data/earth.toml");
  command->callback([arguments] {
    if (const auto done = view(*arguments); !done) failRun("view", io::describe(done.error()));
  });
}

}  // namespace tellurion::app
