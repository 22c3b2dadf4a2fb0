#include "app/debug_options.h"

namespace tellurion::app {
namespace {

std::string viewsProblem(const std::string& text) {
  const auto parsed = scene::parseDebugViews(text);
  return parsed ? "" : io::describe(parsed.error());
}

}  // namespace

void addDebugOptions(CLI::App& command, DebugOptions& options) {
  command
      .add_option("--debug", options.views,
                  "VIEW[,VIEW...] to draw over the picture: wireframe (the triangles), levels (tiles by level), error "
                  "(tiles by screen error, from blue over green at the tolerance to red), boxes (that tiles are culled "
                  "by)")
      ->check(viewsProblem);
  command
      .add_option("--freeze-at", options.freezeAt,
                  "LAT,LON,HEIGHT,HEADING,PITCH,ROLL: choose the tiles for this camera, and draw them as the other one "
                  "sees them, with the pyramid of this one's picture in white")
      ->check(cameraProblem);
}

io::Result<void> showDebug(const DebugOptions& options, const PictureArguments& picture, Studio& studio) {
  if (options.views.empty() && options.freezeAt.empty()) return {};
  scene::Globe& globe = *studio.globe;
  if (!options.views.empty()) globe.debugViews() = *scene::parseDebugViews(options.views);
  if (!options.freezeAt.empty()) {
    globe.freezeCut(scene::viewOf(*scene::parseCamera(options.freezeAt), globe.body().ellipsoid, picture.verticalFov(),
                                  picture.viewport()));
  }
  return studio.renderer.prepareDebugViews();
}

}  // namespace tellurion::app
