#include "render/renderer.h"

#include <epoxy/gl.h>

#include <array>
#include <chrono>
#include <limits>
#include <optional>

#include "raster/colour.h"
#include "render/air_pass.h"
#include "render/context.h"
#include "render/debug_pass.h"
#include "render/draw_plan.h"
#include "render/gpu_residents.h"
#include "render/ground_pass.h"
#include "render/heavens_pass.h"

namespace tellurion::render {
namespace {

void clear(const scene::Frame& frame, GLuint framebuffer) {
  const auto linear = [&](std::size_t i) {
    return static_cast<float>(raster::linearLight(static_cast<double>(frame.background[i])));
  };
  const std::array<GLfloat, 4> colour{linear(0), linear(1), linear(2), 1.0f};
  const GLfloat infinity = 0.0f;
  glClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, colour.data());
  glClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &infinity);
}

void setState(const RenderTarget& target) {
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer());
  glViewport(0, 0, target.size().width, target.size().height);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_FRAMEBUFFER_SRGB);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GEQUAL);  // a needle's depth may come out as nothing, which is the sky's
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  // The far sides of hills are hidden anyway. Culled, they would take some near ones along: Mesa tells faces apart
  // before it rounds corners to its lattice of a 256th of a pixel, which turns needles over, and a cliff seen along its
  // wall is all needles.
  glDisable(GL_CULL_FACE);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  for (const GLenum off : std::array<GLenum, 4>{GL_BLEND, GL_SCISSOR_TEST, GL_STENCIL_TEST, GL_PRIMITIVE_RESTART})
    glDisable(off);
}

double millisecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// Serials of triangles that no frame has.
constexpr std::uint64_t kWarmUpMesh = std::numeric_limits<std::uint64_t>::max();
constexpr std::uint64_t kAirWarmUpMesh = kWarmUpMesh - 1;

/// Calls back with a triangle on the GPU and a target of one pixel, where drivers may compile what they have to.
template <class Draw>
io::Result<void> warmUp(GpuResidents& residents, std::uint64_t serial, Draw draw) {
  const auto target = RenderTarget::create({.width = 1, .height = 1});
  if (!target) return tl::unexpected(target.error());
  scene::TerrainMesh mesh{.serial = serial};
  mesh.vertices.resize(3);
  mesh.indices = {0, 1, 2};
  const MeshPlace* place = residents.geometry().upload(mesh, 0);
  if (place == nullptr) return io::fail(io::Failure::Code::ioError, "the graphics driver has no memory left");
  setState(*target);
  return draw(*place);
}

}  // namespace

static_assert(GeometryArena::kMostChunks <= kMostDrawCalls);

struct Renderer::Parts {
  GpuResidents residents;
  GroundPass ground;
  DrawPlan plan;                       // kept from frame to frame only for its memory
  std::optional<DebugPass> debug;      // once it was asked for
  std::optional<AirPass> air;          // likewise
  std::optional<HeavensPass> heavens;  // likewise

  int drawDebug(const scene::Frame& frame, const RenderTarget& target);
};

/// The number of draw calls.
int Renderer::Parts::drawDebug(const scene::Frame& frame, const RenderTarget& target) {
  if (!debug || !(frame.debug.views.any() || frame.debug.frozenCut)) return 0;
  return debug->draw(frame,
                     {.geometry = &residents.geometry(),
                      .recordBinding = kRecordBinding,
                      .recordBuffer = ground.recordBuffer(),
                      .commandBuffer = ground.commandBuffer(),
                      .frameBlock = ground.frameBlock(),
                      .runs = plan.chunkRuns(),
                      .tiles = residents.tiles(),
                      .records = plan.records()},
                     target);
}

Renderer::Renderer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

io::Result<Renderer> Renderer::create(const RendererOptions& options) {
  if (auto usable = checkCurrentContext(); !usable) return tl::unexpected(usable.error());
  if (options.compressedPictures && !readsCompressedPictures())
    return tl::unexpected(io::Failure{.code = io::Failure::Code::unsupported,
                                      .message = "this graphics driver reads no compressed textures "
                                                 "(EXT_texture_compression_s3tc and EXT_texture_sRGB): draw without"});
  GpuResidents residents(options.gpuBudgetBytes, options.compressedPictures);
  auto ground = GroundPass::create(residents.geometry(), options.asOnAnyGpu);
  if (!ground) return tl::unexpected(ground.error());
  const auto ready = warmUp(residents, kWarmUpMesh, [&](const MeshPlace& mesh) {
    ground->warmUp(mesh, residents);
    return io::Result<void>();
  });
  if (!ready) return tl::unexpected(ready.error());
  return Renderer(std::unique_ptr<Parts>(new Parts{.residents = std::move(residents),
                                                   .ground = std::move(*ground),
                                                   .plan = {},
                                                   .debug = {},
                                                   .air = {},
                                                   .heavens = {}}));
}

RenderStatistics Renderer::draw(const scene::Frame& frame, const RenderTarget& target) {
  const auto start = std::chrono::steady_clock::now();
  Parts& p = *parts_;
  const CopyCounts copies = p.residents.bring(frame);
  const double upload_ms = millisecondsSince(start);
  const auto submitStart = std::chrono::steady_clock::now();
  const SnappedEye eye = snappedEye(frame.view.eye);
  p.plan.make(frame, p.residents.tiles(), p.residents.pictures(), eye);
  p.ground.setFrame(frame, eye);
  const bool inAir = p.air && frame.air.enabled && frame.light.enabled;
  if (inAir) p.air->setFrame(frame);
  setState(target);
  clear(frame, target.framebuffer());
  int drawCalls = p.ground.draw(p.plan, p.residents, inAir);
  if (inAir) drawCalls += p.air->drawSky(frame);
  if (p.heavens) drawCalls += p.heavens->draw(frame, inAir);
  drawCalls += p.drawDebug(frame, target);
  return {.tilesDrawn = static_cast<int>(p.residents.tiles().size()),
          .triangles = p.plan.triangles(),
          .drawCalls = drawCalls,
          .tilesWithoutRoom = copies.withoutRoom,
          .uploads = copies.copies,
          .uploadBytes = copies.bytes,
          .gpuBytes = p.residents.bytes(),
          .upload_ms = upload_ms,
          .submit_ms = millisecondsSince(submitStart)};
}

const scene::Residency& Renderer::residency() const {
  return parts_->residents;
}

io::Result<void> Renderer::prepareDebugViews() {
  if (parts_->debug) return {};
  auto pass = DebugPass::create();
  if (!pass) return tl::unexpected(pass.error());
  parts_->debug = std::move(*pass);
  return {};
}

io::Result<void> Renderer::prepareSky() {
  if (parts_->heavens) return {};
  auto heavens = HeavensPass::create();
  if (!heavens) return tl::unexpected(heavens.error());
  parts_->heavens = std::move(*heavens);
  return {};
}

io::Result<void> Renderer::prepareAir() {
  Parts& p = *parts_;
  if (p.air) return {};
  auto air = AirPass::create();
  if (!air) return tl::unexpected(air.error());
  const auto ready = warmUp(p.residents, kAirWarmUpMesh, [&](const MeshPlace& mesh) {
    air->warmUp();
    return p.ground.prepareAir(mesh, p.residents);
  });
  if (!ready) return tl::unexpected(ready.error());
  p.air = std::move(*air);
  return {};
}

bool readsCompressedPictures() {
  return readsBlocks();
}

void finish() {
  glFinish();
}

}  // namespace tellurion::render
