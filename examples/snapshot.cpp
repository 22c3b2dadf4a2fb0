// Renders a whole planet to a PNG, without a display:  snapshot earth.toml earth.png
#include <chrono>
#include <cstdio>

#include "raster/image_file.h"
#include "render/context.h"
#include "render/renderer.h"
#include "scene/globe.h"

using namespace tellurion;

namespace {

int complain(const io::Failure& failure) {
  std::fprintf(stderr, "snapshot: %s\n", io::describe(failure).c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: snapshot SCENE PICTURE.png\n");
    return 2;
  }
  const auto scene = scene::openScene(argv[1]);
  if (!scene) return complain(scene.error());
  auto globe = scene::Globe::open(*scene);
  if (!globe) return complain(globe.error());

  const auto context = render::HeadlessContext::create();
  if (!context) return complain(context.error());
  auto renderer = render::Renderer::create();
  if (!renderer) return complain(renderer.error());

  const scene::Viewport size{.width = 1024, .height = 768};
  const auto target = render::RenderTarget::create(size);
  if (!target) return complain(target.error());

  // Three radii above the Gulf of Guinea, straight down.
  const geo::Ellipsoid& ellipsoid = (*globe)->body().ellipsoid;
  const scene::Camera camera{.position = {.height_m = 3.0 * ellipsoid.semiMajorAxis_m()}, .pitch = geo::Angle::degrees(-90)};
  const scene::View view = scene::viewOf(camera, ellipsoid, geo::Angle::degrees(45), size);

  // A frame can be drawn at any time; here we wait for the finest that this view needs.
  while (!(*globe)->update(view).complete)
    if (!(*globe)->waitForArrivals(std::chrono::seconds(30))) break;
  renderer->draw((*globe)->update(view), *target);

  if (const auto written = raster::writePng(argv[2], render::readColour(*target)); !written) return complain(written.error());
  std::printf("%s\n", argv[2]);
  return 0;
}
