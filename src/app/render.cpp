#include <fmt/format.h>

#include <memory>
#include <optional>

#include "app/debug_options.h"
#include "app/frame_figures.h"
#include "app/output_names.h"
#include "app/progress.h"
#include "app/studio.h"
#include "app/subcommands.h"
#include "raster/image_file.h"

namespace tellurion::app {
namespace {

struct Arguments {
  PictureArguments picture;
  DebugOptions debug;
  std::string camera;
  std::string output;
  std::string depth;
  std::string stats;
  double timeout_s = 120.0;
};

/// A wrong name would be found out after minutes, or not at all.
void checkOutputs(const Arguments& a) {
  if (endingOf(a.output) != ".png" && !isDevice(a.output)) {
    wrongUse("render", fmt::format("-o '{}': the picture is a PNG; give it a name that ends in .png (and convert it "
                                   "afterwards where another format is needed)",
                                   a.output));
  }
  keepApart("render", "-o", a.output, "--depth", a.depth);
  keepApart("render", "-o", a.output, "--stats", a.stats);
  keepApart("render", "--depth", a.depth, "--stats", a.stats);
  keepApart("render", "-o", a.output, "SCENE", a.picture.scene);
  keepApart("render", "--depth", a.depth, "SCENE", a.picture.scene);
  keepApart("render", "--stats", a.stats, "SCENE", a.picture.scene);
}

void warnOfGround(const scene::Globe& globe, const scene::View& view) {
  const double below_m = depthBelowGround_m(globe, view);
  if (below_m > 0.0)
    fmt::print(stderr,
               "tellurion render: warning: the eye is {:.1f} m below the ground at its place; raise the HEIGHT of "
               "--camera to look at it from above\n",
               below_m);
}

scene::View viewFor(const Arguments& arguments, const geo::Ellipsoid& ellipsoid) {
  return scene::viewOf(*scene::parseCamera(arguments.camera), ellipsoid, arguments.picture.verticalFov(),
                       arguments.picture.viewport());
}

io::Result<void> writeDepth(const Arguments& arguments, const Studio& studio, const scene::View& view) {
  if (arguments.depth.empty()) return {};
  return raster::writeTiffFloat(arguments.depth, render::readDistance(studio.target, view));
}

/// The drawing that copies meshes and textures to the GPU says little of a frame's cost: with --stats it is drawn
/// again.
io::Result<void> writeStats(const Arguments& arguments, Studio& studio, const scene::Frame& frame) {
  if (arguments.stats.empty()) return {};
  FrameFigures figures = drawMeasured(studio.renderer, studio.target, frame);
  figures.quality = arguments.picture.quality;
  return writeTextFile(arguments.stats, jsonOf(figures));
}

io::Result<std::vector<std::string>> render(const Arguments& arguments) {
  checkOutputs(arguments);
  const InterruptStop interrupt;
  auto studio = openStudio(arguments.picture, interrupt.token());
  if (!studio) return tl::unexpected(studio.error());
  if (const auto shown = showDebug(arguments.debug, arguments.picture, *studio); !shown)
    return tl::unexpected(shown.error());
  scene::Globe& globe = *studio->globe;
  const scene::View view = viewFor(arguments, globe.body().ellipsoid);
  const scene::Frame& frame = settledFrame(globe, view, arguments.picture.cutAtQuality(),
                                           std::chrono::duration<double>(arguments.timeout_s), interrupt.token());
  if (interrupt.token().stop_requested())
    return io::fail(io::Failure::Code::cancelled, "stopped; nothing is written", arguments.output);
  warnOfBudget("render", arguments.picture, frame.statistics);
  warnOfGround(globe, view);
  warnOfMemory("render", arguments.picture, studio->renderer.draw(frame, studio->target));
  if (const auto written = writeStats(arguments, *studio, frame); !written) return tl::unexpected(written.error());
  if (const auto written = writeDepth(arguments, *studio, view); !written) return tl::unexpected(written.error());
  if (const auto written = raster::writePng(arguments.output, render::readColour(studio->target)); !written)
    return tl::unexpected(written.error());
  return shortcomings(arguments.picture, globe, frame);
}

}  // namespace

void addRender(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("render", "Render one complete picture, without a display");
  addPictureArguments(*command, arguments->picture, Pace::eachComplete);
  command
      ->add_option(
          "--camera", arguments->camera,
          "LAT,LON,HEIGHT,HEADING,PITCH,ROLL: degrees, and metres above the ellipsoid; heading clockwise from north, "
          "pitch 0 at the horizon and -90 straight down; the last ones may be left out: HEADING 0, PITCH -90, ROLL 0")
      ->required()
      ->check(cameraProblem);
  command->add_option("-o,--output", arguments->output, "The PNG to write; its name ends in .png")->required();
  command->add_option("--depth", arguments->depth,
                      "A float32 TIFF of metres from the eye to the surface, NaN for sky, to write too");
  command->add_option("--stats", arguments->stats, "A JSON file of figures to write too");
  command->add_option("--timeout", arguments->timeout_s, "Seconds to wait for all that the view needs")
      ->check(between(0.0, 1e6))
      ->capture_default_str();
  addDebugOptions(*command, arguments->debug);
  command->footer(
      "When the time is over first, what is there is written, what is missing is said, and the exit status is 1.\n"
      "An eye below the ground gives a picture and a warning. Ctrl-C or SIGTERM stops without a picture;\n"
      "a raster that was being built into the cache goes on there on the next run.\n\n"
      "Example: Everest from the south, once ./bootstrap demo has made the tile databases\n"
      "  tellurion render data/earth.toml --camera 27.75,86.82,9500,20,-12,0 --size 1024x768 -o everest.png");
  command->callback([arguments] {
    const auto lacking = render(*arguments);
    if (!lacking) failRun("render", io::describe(lacking.error()));
    if (lacking->empty()) return;
    std::string message = arguments->output + " is written, but not all of it is there";
    for (const std::string& line : *lacking)
      message += "\n  " + line;
    failRun("render", message);
  });
}

}  // namespace tellurion::app
