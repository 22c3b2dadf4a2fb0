#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>

#include "app/debug_options.h"
#include "app/frame_figures.h"
#include "app/output_names.h"
#include "app/progress.h"
#include "app/projection_options.h"
#include "app/studio.h"
#include "app/subcommands.h"
#include "io/output_file.h"
#include "raster/image_file.h"
#include "raster/png_rows.h"

namespace tellurion::app {
namespace {

struct Arguments {
  PictureArguments picture;
  ProjectionArguments projection;
  DebugOptions debug;
  std::string camera;
  std::string output;
  std::string depth;
  std::string stats;
  double timeout_s = 120.0;
};

/// A wrong name would be found out after minutes, or not at all.
void checkNames(const Arguments& a) {
  if (endingOf(a.output) != ".png" && !io::isDevice(a.output)) {
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

/// Only pictures of one piece have those that are made for one eye's window.
void checkTogether(const Arguments& a, const PictureRequest& request) {
  const bool isPlain = request.shape.projection == scene::Projection::perspective && request.channels.empty();
  const bool hasDebug = !a.debug.views.empty() || !a.debug.freezeAt.empty();
  if (hasDebug && !(isPlain && request.pieces.size() == 1))
    wrongUse("render", fmt::format("--debug and --freeze-at are for perspective pictures of at most {}x{}",
                                   request.pieces.front().width, request.pieces.front().height));
  constexpr std::int64_t kMostDistances = std::int64_t{1} << 28;
  const scene::Viewport size = request.shape.size;
  if (!a.depth.empty() && std::int64_t{size.width} * size.height > kMostDistances)
    wrongUse("render",
             fmt::format("--depth is written whole, for pictures of at most {} pixels: make it smaller than {}x{}",
                         kMostDistances, size.width, size.height));
}

/// The picture as it comes, from its top: at once where it comes at once, else row by row.
class PictureFile {
 public:
  PictureFile(const Arguments& arguments, scene::Viewport size) : arguments_(arguments), size_(size) {
    if (!arguments.depth.empty()) distances_m_ = raster::Raster<float>(size.width, size.height);
  }
  io::Result<void> take(const render::PicturePiece& rows) {
    std::ranges::copy(rows.distances_m.samples,
                      distances_m_.samples.begin() + std::ptrdiff_t{rows.place.top} * size_.width);
    if (rows.place.height == size_.height) {
      colours_ = rows.colours;
      return {};
    }
    if (!rows_) {
      auto made = raster::PngRows::create(arguments_.output, size_.width, size_.height);
      if (!made) return tl::unexpected(made.error());
      rows_ = std::move(*made);
    }
    return rows_->write(rows.colours);
  }
  io::Result<void> finish() {
    if (!arguments_.depth.empty()) {
      if (const auto written = raster::writeTiffFloat(arguments_.depth, distances_m_); !written) return written;
    }
    return rows_ ? rows_->finish() : raster::writePng(arguments_.output, colours_);
  }

 private:
  const Arguments& arguments_;
  scene::Viewport size_;
  raster::Raster<raster::Rgba8> colours_;
  raster::Raster<float> distances_m_;
  std::optional<raster::PngRows> rows_;
};

/// What one run of `render` knows of its picture besides the pixels.
struct Told {
  FrameFigures figures;  ///< of the scene, those of the last eye
  bool isTold = false;   ///< of one eye at least
  std::vector<std::string> lacking;
};

io::Result<std::vector<std::string>> render(const CLI::App& command, Arguments& arguments) {
  checkNames(arguments);
  const auto request = requestOf(command, arguments.projection, arguments.picture);
  if (!request) return tl::unexpected(request.error());
  checkTogether(arguments, *request);
  if (const auto can = checkOutputs({arguments.output, arguments.depth, arguments.stats}); !can)
    return tl::unexpected(can.error());
  const InterruptStop interrupt;
  auto studio = openStudio(arguments.picture, interrupt.token());
  if (!studio) return tl::unexpected(studio.error());
  auto maker = render::PictureMaker::create();
  if (!maker) return tl::unexpected(maker.error());
  if (const auto shown = showDebug(arguments.debug, arguments.picture, *studio); !shown)
    return tl::unexpected(shown.error());
  const Patience patience{std::chrono::duration<double>(arguments.timeout_s), interrupt.token()};
  const auto eyes = eyesOf(*request, *scene::parseCamera(arguments.camera), *studio, arguments.picture, patience);
  PictureFile file(arguments, request->shape.size);
  std::optional<Told> told;
  const auto check = [&](const scene::Frame& frame) -> io::Result<void> {
    if (interrupt.token().stop_requested())
      return io::fail(io::Failure::Code::cancelled, "stopped; nothing is written", arguments.output);
    if (!told) {
      warnOfBudget("render", arguments.picture, frame.statistics);
      warnOfGround(*studio->globe, frame.view);
      told = Told{};
    }
    const bool isFirst = !told->isTold;
    told->isTold = true;
    told->figures.scene = frame.statistics;
    told->figures.complete = (isFirst || told->figures.complete) && frame.complete && frame.statistics.failures == 0;
    if (told->lacking.empty()) told->lacking = shortcomings(arguments.picture, *studio->globe, frame);
    return {};
  };
  const auto take = [&](const render::PicturePiece& rows) {
    render::add(rows.drawn, told->figures.render);
    return file.take(rows);
  };
  const auto draw = [&](const FrameCheck& each, const RowSink& sink) {
    return drawPicture(*request, eyes, *studio, *maker, arguments.picture, patience, !arguments.depth.empty(), each,
                       sink);
  };
  if (const auto drawn = draw(check, take); !drawn) return tl::unexpected(drawn.error());
  warnOfMemory("render", arguments.picture, told->figures.render);
  if (!arguments.stats.empty()) {
    // The drawing that copies meshes and textures to the GPU says little of a picture's cost: it is drawn again.
    told->figures.render = {};
    const auto start = std::chrono::steady_clock::now();
    const auto drawn = draw([](const scene::Frame&) { return io::Result<void>(); },
                            [&](const render::PicturePiece& rows) {
                              render::add(rows.drawn, told->figures.render);
                              return io::Result<void>();
                            });
    if (!drawn) return tl::unexpected(drawn.error());
    render::finish();
    const std::chrono::duration<double, std::milli> drawing = std::chrono::steady_clock::now() - start;
    told->figures.frame_ms = drawing.count();
    told->figures.quality = arguments.picture.quality;
    if (const auto written = io::writeWhole(arguments.stats, jsonOf(told->figures)); !written)
      return tl::unexpected(written.error());
  }
  if (const auto written = file.finish(); !written) return tl::unexpected(written.error());
  return told->lacking;
}

}  // namespace

void addRender(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("render", "Render one complete picture, without a display");
  addPictureArguments(*command, arguments->picture, Pace::eachComplete);
  addProjectionOptions(*command, arguments->projection);
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
      "  tellurion render data/earth.toml --camera 27.75,86.82,9500,20,-12,0 --size 1024x768 -o everest.png\n"
      "A dome master of the same, the dome leaning forward by 30 degrees:\n"
      "  tellurion render data/earth.toml --camera 27.75,86.82,9500,20,0,0 --projection fisheye --tilt 30 --size "
      "2048x2048 -o dome.png");
  command->callback([arguments, command] {
    const auto lacking = render(*command, *arguments);
    if (!lacking) failRun("render", io::describe(lacking.error()));
    if (lacking->empty()) return;
    std::string message = arguments->output + " is written, but not all of it is there";
    for (const std::string& line : *lacking)
      message += "\n  " + line;
    failRun("render", message);
  });
}

}  // namespace tellurion::app
