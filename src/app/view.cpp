#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "app/progress.h"
#include "app/studio.h"
#include "app/subcommands.h"
#include "app/view_loop.h"
#include "app/view_start.h"

namespace tellurion::app {
namespace {

struct ViewArguments {
  PictureArguments picture{.size = "1280x800", .automaticQuality = true};
  std::string camera;
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

io::Result<void> view(const ViewArguments& arguments) {
  const auto scene = scene::openScene(arguments.picture.scene, arguments.picture.settings, arguments.picture.globe().online);
  if (!scene) return tl::unexpected(scene.error());
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
  return ViewLoop(*window, **globe, scene->tiling, titleOf(scene->name), std::move(*renderer),
                  startView(arguments, *scene), arguments.picture.cut(), qualityFrom(arguments.picture),
                  clockOf(*scene, arguments.picture))
      .run();
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
  command->footer(
      "In the window H shows the controls. C prints the camera as --camera takes it.\n\n"
      "Example: Earth, once ./bootstrap demo has made its tile databases\n"
      "  tellurion view data/earth.toml");
  command->callback([arguments] {
    if (const auto done = view(*arguments); !done) failRun("view", io::describe(done.error()));
  });
}

}  // namespace tellurion::app
