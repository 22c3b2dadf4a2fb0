#include "render/air_pass.h"

#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "raster/colour.h"
#include "render/air_model.h"
#include "render/air_tables.h"
#include "render/moon_disc.h"
#include "render/shader.h"
#include "render/shader_texts.h"
#include "render/sky_part.h"

namespace tellurion::render {
namespace {

using namespace air_shading;

// As the shaders have them.
constexpr GLuint kAirBinding = 1;
constexpr GLuint kTransmittanceUnit = 0;  // of the shader that makes the table of a view
constexpr GLuint kGlowUnit = 1;
constexpr GLuint kLightImage = 0;
constexpr GLuint kDepthImage = 1;
constexpr GLuint kLightUnit = 18;  // of ground and sky, beyond all that ground reads
constexpr GLuint kDepthUnit = 19;
constexpr GLuint kGroundLightUnit = 20;
constexpr GLint kGroundSamplers = 19;
constexpr int kGroupSide = 8;

// Exposure where the scene leaves it to the eye. Of what ground has less light than in half the sun, eyes and pictures
// make up for half, as counted in stops, so that dusk is darker than day and yet to be seen.
constexpr double kDayLight = 0.5;
constexpr double kLeastLight = 1e-5;
constexpr double kMadeUp = 0.5;
constexpr double kMostStops = 9.0;
// As shares of the air's height: below the first it counts in full, above the second not at all.
constexpr double kWithinAir = 0.1;
constexpr double kOutOfAir = 0.6;

/// std140, as air_block.glsl declares it.
struct AirBlock {
  AirModel air;
  AirView view;
};
static_assert(sizeof(AirBlock) == 12 * sizeof(geo::Vec4f));
using BlockBits = std::array<std::uint32_t, sizeof(AirBlock) / sizeof(std::uint32_t)>;

double smooth(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

Texture makeTexture(GLenum target, GLenum format, int width, int height, int depth) {
  GLuint name = 0;
  glCreateTextures(target, 1, &name);
  Texture texture(name);
  if (depth > 0) {
    glTextureStorage3D(name, 1, format, width, height, depth);
  } else {
    glTextureStorage2D(name, 1, format, width, height);
  }
  for (const GLenum wrap : std::array<GLenum, 3>{GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
    glTextureParameteri(name, wrap, GL_CLAMP_TO_EDGE);
  for (const GLenum filter : std::array<GLenum, 2>{GL_TEXTURE_MAG_FILTER, GL_TEXTURE_MIN_FILTER})
    glTextureParameteri(name, filter, GL_LINEAR);
  return texture;
}

}  // namespace

struct AirPass::Parts {
  Program viewProgram;
  Program skyProgram;
  GLint background = -1;
  GLint moon = -1;
  GLint rows = -1;
  GLint bandCount = -1;
  GLint firstColumn = -1;
  SkyPart skyPart;
  VertexArray nothing;  // the sky has no vertices
  Buffer block;
  Texture transmittance;
  Texture glow;
  Texture groundLight;
  Texture light;
  Texture depth;
  // What the tables are of.
  std::optional<scene::Atmosphere> atmosphere;
  double radius_m = 0.0;
  AirTables tables;
  std::optional<BlockBits> eyesOwn;  // what `light` and `depth` are of

  void makeTables(const scene::Atmosphere& of, double radius);
  void makeView(const AirBlock& of);
  void bind(const AirBlock& of);
  double exposure(const scene::Air& air, const EyeInAir& eye) const;
};

void AirPass::Parts::makeTables(const scene::Atmosphere& of, double radius) {
  if (atmosphere == of && radius_m == radius) return;
  atmosphere = of;
  radius_m = radius;
  eyesOwn.reset();
  tables = makeAirTables(of, radius);
  glTextureSubImage2D(transmittance.name(), 0, 0, 0, kTransmittanceWidth, kTransmittanceHeight, GL_RGBA, GL_FLOAT,
                      tables.transmittance.data());
  glTextureSubImage2D(glow.name(), 0, 0, 0, kGlowSide, kGlowSide, GL_RGBA, GL_FLOAT, tables.glow.data());
  glTextureSubImage3D(groundLight.name(), 0, 0, 0, 0, kGroundLightWidth, kGroundLightHeight, 2, GL_RGBA, GL_FLOAT,
                      tables.groundLight.data());
}

/// Of an eye that only turns, and of all pictures of one eye (cube faces, pieces), the tables stay.
void AirPass::Parts::makeView(const AirBlock& of) {
  AirBlock own = of;
  own.view.up.w = 0.0f;  // exposure and the size of pixels are not the tables'
  own.view.toSun.w = 0.0f;
  const auto bits = std::bit_cast<BlockBits>(own);
  if (eyesOwn == bits) return;
  eyesOwn = bits;
  glUseProgram(viewProgram.name());
  glBindTextureUnit(kTransmittanceUnit, transmittance.name());
  glBindTextureUnit(kGlowUnit, glow.name());
  glBindSampler(kTransmittanceUnit, 0);
  glBindSampler(kGlowUnit, 0);
  glBindImageTexture(kLightImage, light.name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(kDepthImage, depth.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glDispatchCompute(kViewAzimuths / kGroupSide, kViewRows / kGroupSide, 1);
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

/// All that ground and sky read.
void AirPass::Parts::bind(const AirBlock& of) {
  glNamedBufferData(block.name(), sizeof(of), &of, GL_STREAM_DRAW);
  glBindBufferBase(GL_UNIFORM_BUFFER, kAirBinding, block.name());
  makeView(of);
  const std::array<std::pair<GLuint, GLuint>, 3> units{
      {{kLightUnit, light.name()}, {kDepthUnit, depth.name()}, {kGroundLightUnit, groundLight.name()}}};
  for (const auto& [unit, texture] : units) {
    glBindTextureUnit(unit, texture);
    glBindSampler(unit, 0);
  }
}

double AirPass::Parts::exposure(const scene::Air& air, const EyeInAir& eye) const {
  if (air.exposure_stops) return std::exp2(*air.exposure_stops);
  const double inAir = 1.0 - smooth(kWithinAir, kOutOfAir, eye.height_m / air.atmosphere.top_m);
  const double onGround = groundLightAt(tables, air.atmosphere, radius_m, eye.height_m, eye.sunCosine);
  const double stops = kMadeUp * std::log2(kDayLight / std::max(onGround, kLeastLight));
  return std::exp2(inAir * std::clamp(stops, 0.0, kMostStops));
}

AirPass::AirPass(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
AirPass::~AirPass() = default;
AirPass::AirPass(AirPass&&) noexcept = default;
AirPass& AirPass::operator=(AirPass&&) noexcept = default;

io::Result<AirPass> AirPass::create() {
  GLint samplers = 0;
  glGetIntegerv(GL_MAX_TEXTURE_IMAGE_UNITS, &samplers);
  if (samplers < kGroundSamplers)
    return io::fail(io::Failure::Code::unsupported,
                    fmt::format("this graphics driver lets a shader read {} textures, ground in air needs {}: draw "
                                "without (atmosphere.enabled = false)",
                                samplers, kGroundSamplers));
  auto view = compileComputeProgram(
      {shaders::air_structs, shaders::air_block, shaders::air_model, shaders::air_ray, shaders::air_view_comp});
  if (!view) return tl::unexpected(view.error());
  const std::string common = std::string(shaders::constants) + std::string(shaders::air_structs) +
                             std::string(shaders::air_block) + std::string(shaders::air_model) +
                             std::string(shaders::air_ray) + std::string(shaders::air);
  auto sky = compileProgram({common, shaders::frame_block, shaders::sky_vert}, {common, shaders::sky_frag});
  if (!sky) return tl::unexpected(sky.error());
  auto parts = std::make_unique<Parts>();
  parts->viewProgram = std::move(*view);
  parts->skyProgram = std::move(*sky);
  parts->background = glGetUniformLocation(parts->skyProgram.name(), "background");
  parts->rows = glGetUniformLocation(parts->skyProgram.name(), "rows");
  parts->bandCount = glGetUniformLocation(parts->skyProgram.name(), "bandCount");
  parts->firstColumn = glGetUniformLocation(parts->skyProgram.name(), "firstColumn");
  parts->moon = glGetUniformLocation(parts->skyProgram.name(), "moon_body");
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  parts->nothing = VertexArray(name);
  glCreateBuffers(1, &name);
  parts->block = Buffer(name);
  parts->transmittance = makeTexture(GL_TEXTURE_2D, GL_RGBA32F, kTransmittanceWidth, kTransmittanceHeight, 0);
  parts->glow = makeTexture(GL_TEXTURE_2D, GL_RGBA32F, kGlowSide, kGlowSide, 0);
  parts->groundLight = makeTexture(GL_TEXTURE_2D_ARRAY, GL_RGBA32F, kGroundLightWidth, kGroundLightHeight, 2);
  parts->light = makeTexture(GL_TEXTURE_3D, GL_RGBA32F, kViewAzimuths, kViewRows, kViewDistances);
  parts->depth = makeTexture(GL_TEXTURE_2D, GL_RGBA32F, kViewRows, kViewDistances, 0);
  if (ranOutOfMemory())
    return io::fail(io::Failure::Code::ioError, "the graphics driver has no memory for the tables of the air");
  return AirPass(std::move(parts));
}

void AirPass::setFrame(const scene::Frame& frame) {
  Parts& p = *parts_;
  const scene::Atmosphere& atmosphere = frame.air.atmosphere;
  p.makeTables(atmosphere, frame.ellipsoid.meanRadius_m());
  const EyeInAir eye = eyeInAir(frame.ellipsoid, frame.view.eye, frame.light.toSun_body);
  AirBlock block{.air = airModelOf(atmosphere, p.radius_m), .view = airViewOf(atmosphere, frame.ellipsoid, eye)};
  block.view.up.w = static_cast<float>(p.exposure(frame.air, eye));
  block.view.toSun.w = static_cast<float>(frame.view.pixelAngle());
  p.skyPart = skyPartOf(frame.view, block.view);
  p.bind(block);
}

void AirPass::warmUp() {
  parts_->bind(AirBlock{});
  drawSky({});
}

int AirPass::drawSky(const scene::Frame& frame) const {
  const Parts& p = *parts_;
  const auto light = [&](std::size_t i) {
    return static_cast<float>(raster::linearLight(static_cast<double>(frame.background[i])));
  };
  glUseProgram(p.skyProgram.name());
  glProgramUniform3f(p.skyProgram.name(), p.background, light(0), light(1), light(2));
  const MoonDisc disc = moonDiscOf(frame).value_or(MoonDisc{});
  const geo::Vec4f moon(geo::Vec3f(disc.towards_body), static_cast<float>(disc.radius_rad));
  glProgramUniform4fv(p.skyProgram.name(), p.moon, 1, &moon[0]);
  const SkyPart& sky = p.skyPart;
  glProgramUniform1iv(p.skyProgram.name(), p.rows, static_cast<GLsizei>(sky.rows.size()), sky.rows.data());
  glProgramUniform1i(p.skyProgram.name(), p.bandCount, sky.bandCount);
  glProgramUniform1i(p.skyProgram.name(), p.firstColumn, sky.firstColumn);
  glBindVertexArray(p.nothing.name());
  glDepthMask(GL_FALSE);
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 2 * (sky.columnCount + 1), sky.bandCount + 1);
  glDepthMask(GL_TRUE);
  glBindVertexArray(0);
  return 1;
}

}  // namespace tellurion::render
