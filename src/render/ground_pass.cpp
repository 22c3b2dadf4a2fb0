#include "render/ground_pass.h"

#include <epoxy/gl.h>

#include <array>
#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "render/render_target.h"
#include "render/shader.h"
#include "render/shader_texts.h"

namespace tellurion::render {
namespace {

namespace shading {
#include "render/shaders/constants.glsl"
}  // namespace shading

// Texture units, as the shaders of the terrain have them.
constexpr GLuint kColourUnit = 0;
constexpr GLuint kSecondUnit = 1;
constexpr GLuint kPictureUnit = 2;
constexpr GLuint kFirstReliefUnit = 3;
constexpr GLuint kFirstBlockUnit = kFirstReliefUnit + shading::kMostReliefBlocks;
constexpr GLuint kThirdUnit = 21;  // beyond those of the air
constexpr GLuint kUnits = kFirstBlockUnit + shading::kMostBlocks;

/// std140, as frame_block.glsl declares it.
struct FrameBlock {
  geo::Mat4f viewFromBody;
  geo::Vec4f projection;
  geo::Vec4f eyeRemainder;
  geo::Vec4f toSun_body;
  geo::Vec4f switches;
  geo::Vec4f offAxis;
};
static_assert(sizeof(FrameBlock) == 144);

FrameBlock blockOf(const scene::Frame& frame, const SnappedEye& eye) {
  const scene::View& view = frame.view;
  const scene::Sides sides = view.sides();
  const double xScale = 2.0 / sides.width();
  const double yScale = 2.0 / sides.height();
  const geo::Vec3 toSun = frame.light.toSun_body;
  return {.viewFromBody = geo::Mat4f(geo::Mat3f(view.viewFromBody)),
          .projection = {static_cast<float>(xScale), static_cast<float>(yScale), kNearPlane_m, 0.0f},
          .eyeRemainder = geo::Vec4f(eye.remainder, static_cast<float>(frame.vertexGrid_m)),
          .toSun_body = geo::Vec4f(geo::Vec3f(toSun), static_cast<float>(frame.light.ambient)),
          .switches = {frame.light.enabled ? 1.0f : 0.0f, static_cast<float>(frame.exaggeration - 1.0), 0.0f, 0.0f},
          .offAxis = {static_cast<float>(sides.middleX() * xScale), static_cast<float>(sides.middleY() * yScale), 0.0f,
                      0.0f}};
}

/// Of water only the coverage is read, which is not sRGB: a software renderer reads texels that it need not decode at a
/// fraction of the cost. It filters these in 8 bits, too coarse for the light of night lights. Else as
/// makeTextureArray() has it; a GPU's textures keep their own.
Sampler makeCoverageSampler() {
  if (!isSoftwareRenderer() || !epoxy_has_gl_extension("GL_EXT_texture_sRGB_decode")) return {};
  GLuint name = 0;
  glCreateSamplers(1, &name);
  glSamplerParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glSamplerParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glSamplerParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glSamplerParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glSamplerParameteri(name, GL_TEXTURE_SRGB_DECODE_EXT, GL_SKIP_DECODE_EXT);
  return Sampler(name);
}

Buffer emptyBuffer() {
  GLuint name = 0;
  glCreateBuffers(1, &name);
  return Buffer(name);
}

Texture emptyBufferTexture() {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &name);
  return Texture(name);
}

/// Replaces a buffer's content; the driver keeps the old one for draws that are still under way.
template <class T>
void stream(const Buffer& buffer, std::span<const T> values) {
  glNamedBufferData(buffer.name(), static_cast<GLsizeiptr>(values.size_bytes()), values.data(), GL_STREAM_DRAW);
}

void describeRecords(GLuint vao, GLuint buffer) {
  struct Field {
    GLuint attribute;
    GLint components;
    std::size_t offset;
  };
  constexpr std::array kFields{Field{3, 3, offsetof(TileRecord, originCoarse_rte)},
                               Field{4, 4, offsetof(TileRecord, originFine_rte)},
                               Field{5, 4, offsetof(TileRecord, colourWindow)},
                               Field{6, 4, offsetof(TileRecord, reliefWindow)},
                               Field{7, 4, offsetof(TileRecord, plain)},
                               Field{13, 4, offsetof(TileRecord, morph)},
                               Field{14, 4, offsetof(TileRecord, thirdWindow)},
                               Field{15, 4, offsetof(TileRecord, secondWindow)}};
  constexpr GLuint kLayers = 8;
  for (const Field& field : kFields) {
    glEnableVertexArrayAttrib(vao, field.attribute);
    glVertexArrayAttribFormat(vao, field.attribute, field.components, GL_FLOAT, GL_FALSE,
                              static_cast<GLuint>(field.offset));
    glVertexArrayAttribBinding(vao, field.attribute, kRecordBinding);
  }
  glEnableVertexArrayAttrib(vao, kLayers);
  glVertexArrayAttribIFormat(vao, kLayers, 4, GL_INT, offsetof(TileRecord, colourLayer));
  glVertexArrayAttribBinding(vao, kLayers, kRecordBinding);
  glVertexArrayBindingDivisor(vao, kRecordBinding, 1);
  glVertexArrayVertexBuffer(vao, kRecordBinding, buffer, 0, sizeof(TileRecord));
}

}  // namespace

io::Result<GroundPass::Programs> GroundPass::compilePrograms(bool asOnAnyGpu, bool inAir) {
  const std::string_view blocks = isSoftwareRenderer() && !asOnAnyGpu ? shaders::blocks_software : shaders::blocks;
  const std::string_view light = isSoftwareRenderer() ? shaders::exact_light_software : shaders::exact_light;
  const std::string layers = std::string(blocks) + std::string(light) + std::string(shaders::layers);
  const std::string airBlock = std::string(shaders::air_structs) + std::string(shaders::air_block);
  const std::string air = std::string(shaders::air_model) + std::string(shaders::air_ray) + std::string(shaders::air);
  io::Result<void> fine;
  const auto compiled = [&](std::string_view define, std::string_view sampling, std::string_view main) {
    const std::string_view airDefine = inAir ? "#define AIR\n" : "";
    const std::string_view block = inAir ? std::string_view(airBlock) : "";
    const std::string_view functions = inAir ? std::string_view(air) : "";
    auto program = compileProgram({define, airDefine, block, shaders::frame_block, shaders::terrain_vert},
                                  {define, airDefine, shaders::constants, block, shaders::frame_block,
                                   shaders::lighting, functions, sampling, shaders::ground, main});
    if (!program) fine = tl::unexpected(program.error());
    return program ? std::move(*program) : Program();
  };
  Programs programs{
      .one = compiled("", shaders::one_block, shaders::terrain_frag),
      .lamps = compiled("#define SECOND\n", shaders::one_block, shaders::terrain_frag),
      .water = compiled("#define SECOND\n#define MIRROR\n", shaders::one_block, shaders::terrain_frag),
      .both = compiled("#define SECOND\n#define THIRD\n#define MIRROR\n", shaders::one_block, shaders::terrain_frag),
      .layered = compiled("#define MIRROR\n", layers, shaders::terrain_layers_frag),
      .adjusted = compiled("#define MIRROR\n#define ADJUSTED\n", layers, shaders::terrain_layers_frag)};
  if (!fine) return tl::unexpected(fine.error());
  return programs;
}

GroundPass::GroundPass(Programs programs, bool asOnAnyGpu)
    : programs_(std::move(programs)),
      asOnAnyGpu_(asOnAnyGpu),
      frameBlock_(emptyBuffer()),
      recordBuffer_(emptyBuffer()),
      commandBuffer_(emptyBuffer()),
      pictureBuffer_(emptyBuffer()),
      pictureTexture_(emptyBufferTexture()),
      coverageSampler_(makeCoverageSampler()) {}

io::Result<GroundPass> GroundPass::create(const GeometryArena& geometry, bool asOnAnyGpu) {
  auto programs = compilePrograms(asOnAnyGpu, false);
  if (!programs) return tl::unexpected(programs.error());
  GroundPass pass(std::move(*programs), asOnAnyGpu);
  describeRecords(geometry.vertexArray(), pass.recordBuffer());
  return pass;
}

void GroundPass::setFrame(const scene::Frame& frame, const SnappedEye& eye) {
  const FrameBlock block = blockOf(frame, eye);
  stream(frameBlock_, std::span(&block, 1));
}

io::Result<void> GroundPass::prepareAir(const MeshPlace& mesh, const GpuResidents& residents) {
  auto programs = compilePrograms(asOnAnyGpu_, true);
  if (!programs) return tl::unexpected(programs.error());
  airPrograms_ = std::move(*programs);
  drawWithEach(airPrograms_, mesh, residents);
  return {};
}

int GroundPass::draw(const DrawPlan& plan, const GpuResidents& residents, bool inAir) {
  stream(recordBuffer_, plan.records());
  stream(commandBuffer_, plan.commands());
  stream(pictureBuffer_, plan.pictureRecords());
  bindPictures(residents);
  glBindVertexArray(residents.geometry().vertexArray());
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, frameBlock_.name());
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commandBuffer_.name());
  for (GLuint unit = 0; unit < kUnits; ++unit)
    glBindSampler(unit, 0);
  for (const DrawGroup& group : plan.groups())
    drawGroup(group, inAir ? airPrograms_ : programs_, plan.adjusts(), residents);
  for (const GLuint unit : {kSecondUnit, kThirdUnit})
    glBindSampler(unit, 0);
  glBindVertexArray(0);
  return static_cast<int>(plan.groups().size());
}

/// For tiles of several pictures, whatever blocks those lie in.
void GroundPass::bindPictures(const GpuResidents& residents) const {
  glTextureBuffer(pictureTexture_.name(), GL_RGBA32F, pictureBuffer_.name());
  glBindTextureUnit(kPictureUnit, pictureTexture_.name());
  for (GLuint i = 0; i < shading::kMostBlocks; ++i)
    glBindTextureUnit(kFirstBlockUnit + i, residents.colours().texture(i));
}

void GroundPass::drawGroup(const DrawGroup& group, const Programs& programs, bool adjusts,
                           const GpuResidents& residents) const {
  switch (group.kind) {
    case TileColours::Kind::one:
      glUseProgram(programs.one.name());
      break;
    case TileColours::Kind::lamps:
      glUseProgram(programs.lamps.name());
      break;
    case TileColours::Kind::water:
      glUseProgram(programs.water.name());
      break;
    case TileColours::Kind::both:
      glUseProgram(programs.both.name());
      break;
    case TileColours::Kind::layered:
      glUseProgram(adjusts ? programs.adjusted.name() : programs.layered.name());
      break;
  }
  glBindSampler(kSecondUnit, group.kind == TileColours::Kind::water ? coverageSampler_.name() : 0);
  glBindSampler(kThirdUnit, coverageSampler_.name());
  glBindTextureUnit(kSecondUnit, residents.colours().texture(group.secondBlock));
  glBindTextureUnit(kThirdUnit, residents.colours().texture(group.thirdBlock));
  residents.geometry().bind(group.run.chunk);
  glBindTextureUnit(kColourUnit, residents.colours().texture(group.colourBlock));
  // All of them for tiles that read all blocks, whose group names the first; the others read the first unit.
  for (GLuint i = 0; i < shading::kMostReliefBlocks; ++i)
    glBindTextureUnit(kFirstReliefUnit + i, residents.reliefs().texture(i == 0 ? group.reliefBlock : i));
  glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_SHORT, group.run.offset(),
                              static_cast<GLsizei>(group.run.count), 0);
}

void GroundPass::warmUp(const MeshPlace& mesh, const GpuResidents& residents) {
  drawWithEach(programs_, mesh, residents);
}

void GroundPass::drawWithEach(const Programs& programs, const MeshPlace& mesh, const GpuResidents& residents) {
  const FrameBlock block{};
  const TileRecord record{.pictureCount = 1};
  const PictureRecord picture{};
  const DrawCommand command{
      .count = 3, .firstIndex = mesh.firstIndex, .baseVertex = static_cast<std::int32_t>(mesh.firstVertex)};
  stream(frameBlock_, std::span(&block, 1));
  stream(recordBuffer_, std::span(&record, 1));
  stream(commandBuffer_, std::span(&command, 1));
  stream(pictureBuffer_, std::span(&picture, 1));
  bindPictures(residents);
  glBindVertexArray(residents.geometry().vertexArray());
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, frameBlock_.name());
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commandBuffer_.name());
  using Kind = TileColours::Kind;
  for (const Kind kind : {Kind::one, Kind::lamps, Kind::water, Kind::both, Kind::layered}) {
    const DrawGroup group{.kind = kind,
                          .secondBlock = residents.colours().blockOfCoverage(),
                          .thirdBlock = residents.colours().blockOfCoverage(),
                          .run = {.chunk = mesh.chunk, .first = 0, .count = 1}};
    drawGroup(group, programs, false, residents);
    if (kind == Kind::layered) drawGroup(group, programs, true, residents);
  }
  glBindVertexArray(0);
}

}  // namespace tellurion::render
