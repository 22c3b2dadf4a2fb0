#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/progress.h"
#include "app/subcommands.h"
#include "app/view_loop.h"
#include "app/view_start.h"

namespace tellurion::app {
namespace {

constexpr int kLargestSide = 16384;

struct ViewOptions {
  std::string scene;
  std::string camera;
  std::string size = "1280x800";
  double fov_degrees = 45.0;
  double tolerance_px = 1.0;
};

std::optional<scene::Viewport> sizeFrom(const std::string& text) {
  scene::Viewport size;
  const char* end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  if (width.ec != std::errc() || width.ptr == end || *width.ptr != 'x') return std::nullopt;
  const auto height = std::from_chars(width.ptr + 1, end, size.height);
  if (height.ec != std::errc() || height.ptr != end) return std::nullopt;
  const auto fine = [](int side) { return side >= 1 && side <= kLargestSide; };
  return fine(size.width) && fine(size.height) ? std::optional(size) : std::nullopt;
}

std::string sizeProblem(const std::string& text) {
  return sizeFrom(text) ? "" : fmt::format("'{}' is not WIDTHxHEIGHT in pixels, like 1280x800", text);
}

std::string cameraProblem(const std::string& text) {
  const auto parsed = scene::parseCamera(text);
  return parsed ? "" : io::describe(parsed.error());
}

/// Rasters of the scene being made into databases, one line each on the terminal.
class BuildLines {
 public:
  void operator()(std::string_view what, double share) {
    constexpr std::uint64_t kWhole = 100;
    if (!line_ || what != what_) {
      line_.reset();
      what_ = what;
      line_.emplace(what_);
    }
    line_->show(static_cast<std::uint64_t>(share * kWhole), kWhole, "parts");
    if (share >= 1.0) line_.reset();
  }

 private:
  std::string what_;
  std::optional<ProgressLine> line_;
};

// Without the folder, where the scene is one file.
std::string titleOf(const std::string& scene) {
  const bool several = scene.find(',') != std::string::npos;
  return (several ? scene : std::filesystem::path(scene).filename().string()) + " - Tellurion";
}

scene::View startView(const ViewOptions& options, const scene::Scene& scene, scene::Viewport size) {
  const geo::Angle fov = geo::Angle::degrees(options.fov_degrees);
  const auto given = scene::parseCamera(options.camera);
  return scene::viewOf(given ? *given : startCamera(scene, fov), scene.body.ellipsoid, fov, size);
}

io::Result<void> view(const ViewOptions& options) {
  const scene::Viewport size = sizeFrom(options.size).value_or(scene::Viewport{});
  const auto scene = scene::openScene(options.scene);
  if (!scene) return tl::unexpected(scene.error());
  auto window = ViewWindow::open(titleOf(scene->name), size);
  if (!window) return tl::unexpected(window.error());
  BuildLines lines;
  const auto globe = scene::Globe::open(*scene, {}, std::ref(lines));
  if (!globe) return tl::unexpected(globe.error());
  auto renderer = render::Renderer::create();
  if (!renderer) return tl::unexpected(renderer.error());
  const scene::View start = startView(options, *scene, size);
  return ViewLoop(*window, **globe, scene->tiling, titleOf(scene->name), std::move(*renderer), start,
                  {.tolerance_px = options.tolerance_px})
      .run();
}

}  // namespace

void addView(CLI::App& program) {
  auto options = std::make_shared<ViewOptions>();
  CLI::App* command = program.add_subcommand("view", "Opens an interactive window on a scene (docs/viewer.md)");
  command->add_option("SCENE", options->scene, "A scene file, a tile database, a raster, or several joined by commas")
      ->required();
  command
      ->add_option("--camera", options->camera,
                   "LAT,LON,HEIGHT,HEADING,PITCH,ROLL in degrees and metres; else above the data")
      ->check(cameraProblem);
  command->add_option("--size", options->size, "WIDTHxHEIGHT of the window")->check(sizeProblem)->capture_default_str();
  command->add_option("--fov", options->fov_degrees, "Vertical field of view in degrees")
      ->capture_default_str()
      ->check(CLI::Range(0.01, 170.0));
  command->add_option("--tolerance", options->tolerance_px, "Geometric error on screen that is fine, in pixels")
      ->capture_default_str()
      ->check(CLI::Range(0.05, 100.0));
  command->footer("In the window H shows the controls. C prints the camera as --camera takes it.");
  command->callback([options] {
    const auto done = view(*options);
    if (done) return;
    fmt::print(stderr, "tellurion view: {}\n", io::describe(done.error()));
    throw CLI::RuntimeError(1);
  });
}

}  // namespace tellurion::app
