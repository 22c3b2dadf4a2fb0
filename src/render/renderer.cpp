#include "render/renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "raster/colour.h"
#include "render/context.h"
#include "render/debug_pass.h"
#include "render/shader.h"
#include "render/shader_texts.h"
#include "render/terrain_pass.h"

namespace tellurion::render {
namespace {

namespace shading {
#include "render/shaders/constants.glsl"
}  // namespace shading

constexpr GLuint kRecordBinding = 1;
// Texture units, as the shaders of the terrain have them.
constexpr GLuint kColourUnit = 0;
constexpr GLuint kReliefUnit = 1;
constexpr GLuint kPictureUnit = 2;
constexpr GLuint kFirstBlockUnit = 3;
constexpr std::uint64_t kSixteenth = 16;
constexpr std::uint64_t kMeshShare = 6;
constexpr std::uint64_t kColourShare = 9;
constexpr std::uint64_t kReliefShare = 1;

/// std140, as frame_block.glsl declares it.
struct FrameBlock {
  geo::Mat4f viewFromBody;
  geo::Vec4f projection;
  geo::Vec4f eyeRemainder;
  geo::Vec4f toSun_body;
  geo::Vec4f switches;
};
static_assert(sizeof(FrameBlock) == 128);

FrameBlock blockOf(const scene::Frame& frame, const SnappedEye& eye) {
  const scene::View& view = frame.view;
  const double yScale = 1.0 / std::tan(view.verticalFov.radians() / 2.0);
  const double xScale = yScale * view.viewport.height / view.viewport.width;
  const geo::Vec3 toSun = frame.light.toSun_body;
  return {.viewFromBody = geo::Mat4f(geo::Mat3f(view.viewFromBody)),
          .projection = {static_cast<float>(xScale), static_cast<float>(yScale), kNearPlane_m, 0.0f},
          .eyeRemainder = geo::Vec4f(eye.remainder, static_cast<float>(frame.vertexGrid_m)),
          .toSun_body = geo::Vec4f(geo::Vec3f(toSun), static_cast<float>(frame.light.ambient)),
          .switches = {frame.light.enabled ? 1.0f : 0.0f, static_cast<float>(frame.exaggeration - 1.0), 0.0f, 0.0f}};
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

std::span<const scene::DrawnPicture> picturesOf(const scene::Frame& frame, const scene::DrawnTile& tile) {
  return {frame.pictures.data() + tile.firstPicture, tile.pictureCount};
}

/// Replaces a buffer's content; the driver keeps the old one for draws that are still under way.
template <class T>
void stream(const Buffer& buffer, const T* values, std::size_t count) {
  glNamedBufferData(buffer.name(), static_cast<GLsizeiptr>(count * sizeof(T)), values, GL_STREAM_DRAW);
}

void describeRecords(GLuint vao, GLuint buffer) {
  struct Field {
    GLuint attribute;
    GLint components;
    std::size_t offset;
  };
  constexpr std::array kFields{Field{3, 3, offsetof(TileRecord, originCoarse_rte)},
                               Field{4, 3, offsetof(TileRecord, originFine_rte)},
                               Field{5, 4, offsetof(TileRecord, colourWindow)},
                               Field{6, 4, offsetof(TileRecord, reliefWindow)},
                               Field{7, 4, offsetof(TileRecord, plain)},
                               Field{13, 4, offsetof(TileRecord, morph)},
                               Field{14, 1, offsetof(TileRecord, parentStep_m)}};
  constexpr GLuint kLayers = 8;
  for (const Field& field : kFields) {
    glEnableVertexArrayAttrib(vao, field.attribute);
    glVertexArrayAttribFormat(vao, field.attribute, field.components, GL_FLOAT, GL_FALSE,
                              static_cast<GLuint>(field.offset));
    glVertexArrayAttribBinding(vao, field.attribute, kRecordBinding);
  }
  glEnableVertexArrayAttrib(vao, kLayers);
  glVertexArrayAttribIFormat(vao, kLayers, 3, GL_INT, offsetof(TileRecord, colourLayer));
  glVertexArrayAttribBinding(vao, kLayers, kRecordBinding);
  glVertexArrayBindingDivisor(vao, kRecordBinding, 1);
  glVertexArrayVertexBuffer(vao, kRecordBinding, buffer, 0, sizeof(TileRecord));
}

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

/// A tile in the order of drawing: by what one draw call may read, then from near to far.
struct Turn {
  std::uint32_t chunk = 0;
  bool isLayered = false;
  std::uint32_t colourBlock = 0;  ///< tiles of several pictures read all blocks
  std::uint32_t reliefBlock = 0;
  float distance = 0.0f;
  std::uint32_t tile = 0;

  auto group() const { return std::tie(chunk, isLayered, colourBlock, reliefBlock); }
  bool operator<(const Turn& o) const {
    return std::tuple_cat(group(), std::tie(distance, tile)) < std::tuple_cat(o.group(), std::tie(o.distance, o.tile));
  }
};

/// One program for tiles of one picture, two for tiles of several: colours are adjusted, or not.
struct Programs {
  Program one;
  Program layered;
  Program adjusted;
};

io::Result<Programs> compilePrograms(bool asOnAnyGpu) {
  constexpr std::string_view kAdjusted = "#define ADJUSTED\n";
  const std::string_view blocks = isSoftwareRenderer() && !asOnAnyGpu ? shaders::blocks_software : shaders::blocks;
  const auto compiled = [&](std::string_view define, std::string_view sampling, std::string_view main) {
    return compileProgram(
        {shaders::frame_block, shaders::terrain_vert},
        {define, shaders::constants, shaders::frame_block, shaders::lighting, shaders::ground, sampling, main});
  };
  const std::string layers = std::string(blocks) + std::string(shaders::layers);
  auto one = compiled("", "", shaders::terrain_frag);
  if (!one) return tl::unexpected(one.error());
  auto layered = compiled("", layers, shaders::terrain_layers_frag);
  if (!layered) return tl::unexpected(layered.error());
  auto adjusted = compiled(kAdjusted, layers, shaders::terrain_layers_frag);
  if (!adjusted) return tl::unexpected(adjusted.error());
  return Programs{std::move(*one), std::move(*layered), std::move(*adjusted)};
}

}  // namespace

struct Renderer::Parts final : scene::Residency {
  explicit Parts(Programs terrainPrograms, std::uint64_t budget);

  std::uint64_t missingBytes(const scene::TerrainMesh& mesh) const override;
  std::uint64_t missingColourBytes(const scene::TextureImage& image) const override;
  std::uint64_t missingReliefBytes(const scene::TextureImage& image) const override;
  std::uint64_t missingBytes(const TexturePool& pool, const scene::TextureImage& image) const;
  std::uint64_t departures() const override;

  void makeResident(const scene::Frame& frame, RenderStatistics& statistics);
  void copySoon(const scene::Frame& frame, RenderStatistics& statistics);
  void orderTiles();
  void colourTiles(const scene::Frame& frame);
  void writeCommands(const scene::Frame& frame, const SnappedEye& eye, RenderStatistics& statistics);
  void bindPictures();
  io::Result<void> warmUp();
  void drawGroups(RenderStatistics& statistics);
  void drawDebug(const scene::Frame& frame, const RenderTarget& target, RenderStatistics& statistics);
  GLuint textureOf(const TexturePool& pool, std::uint32_t block) const;

  Programs programs;
  GeometryArena geometry;
  TexturePool colours;
  TexturePool reliefs;
  // Where no block exists yet: of the kind of blocks, or a driver may compile its shaders again once there is one.
  Texture noColours;
  Texture noReliefs;
  Buffer frameBlock;
  Buffer recordBuffer;
  Buffer commandBuffer;
  Buffer pictureBuffer;
  Texture pictureTexture;          // how shaders read it
  std::optional<DebugPass> debug;  // once it was asked for
  std::uint64_t frameNumber = 0;
  // Kept from frame to frame only for their memory:
  std::vector<ResidentTile> tiles;
  std::vector<ResidentPicture> pictures;  // of Frame::pictures
  std::vector<PictureRecord> pictureRecords;
  bool adjusts = false;                // some layer's colours, in this frame
  std::vector<std::uint64_t> refused;  // serials of this frame's pictures without room
  std::uint64_t framesWithRefused = 0;
  std::vector<Turn> turns;
  std::vector<TileRecord> records;
  std::vector<DrawCommand> commands;
  struct Group {
    Turn nearest;
    CommandRun run;
  };
  std::vector<Group> groups;
  std::vector<CommandRun> chunkRuns;
};

Renderer::Parts::Parts(Programs terrainPrograms, std::uint64_t budget)
    : programs(std::move(terrainPrograms)),
      geometry(budget / kSixteenth * kMeshShare),
      colours(budget / kSixteenth * kColourShare, true),
      reliefs(budget / kSixteenth * kReliefShare, false),
      noColours(makeTextureArray({.width = 3, .height = 3, .mips = 2, .srgb = true}, 1)),
      noReliefs(makeTextureArray({.width = 3, .height = 3, .mips = 1, .srgb = false}, 1)),
      frameBlock(emptyBuffer()),
      recordBuffer(emptyBuffer()),
      commandBuffer(emptyBuffer()),
      pictureBuffer(emptyBuffer()),
      pictureTexture(emptyBufferTexture()) {
  describeRecords(geometry.vertexArray(), recordBuffer.name());
}

std::uint64_t Renderer::Parts::missingBytes(const scene::TerrainMesh& mesh) const {
  return geometry.resident().holds(mesh.serial) ? 0 : bytesOf(mesh);
}
std::uint64_t Renderer::Parts::missingColourBytes(const scene::TextureImage& image) const {
  return missingBytes(colours, image);
}
std::uint64_t Renderer::Parts::missingReliefBytes(const scene::TextureImage& image) const {
  return missingBytes(reliefs, image);
}
std::uint64_t Renderer::Parts::missingBytes(const TexturePool& pool, const scene::TextureImage& image) const {
  const bool fine = pool.resident().holds(image.serial) || std::ranges::find(refused, image.serial) != refused.end();
  return fine ? 0 : bytesOf(image);
}

// Serials of pictures that found no room count as there for one frame.
std::uint64_t Renderer::Parts::departures() const {
  return 1 + geometry.resident().evictions() + colours.resident().evictions() + reliefs.resident().evictions() +
         framesWithRefused;
}

// Only what there is room and time for: it is not missed yet.
void Renderer::Parts::copySoon(const scene::Frame& frame, RenderStatistics& statistics) {
  std::uint64_t left = frame.soonCopies_bytes;
  const auto bring = [&](auto& pool, const auto& payload, auto... mayExceed) {
    if (payload == nullptr || pool.touch(payload->serial, frameNumber) != nullptr) return;
    const std::uint64_t bytes = bytesOf(*payload);
    if (bytes > left || pool.upload(*payload, frameNumber, mayExceed...) == nullptr) return;
    left -= bytes;
    ++statistics.uploads;
    statistics.uploadBytes += bytes;
  };
  for (const scene::DrawnTile& tile : frame.soon) {
    bring(geometry, tile.mesh, false);
    bring(reliefs, tile.relief);
    for (const scene::DrawnPicture& picture : picturesOf(frame, tile)) {
      if (frame.looks[picture.layer].visible) bring(colours, picture.image);
    }
  }
  // Layers that are not visible now may be in the next frame.
  for (const scene::DrawnTile& tile : frame.tiles) {
    for (const scene::DrawnPicture& picture : picturesOf(frame, tile)) {
      if (!frame.looks[picture.layer].visible) bring(colours, picture.image);
    }
  }
}

// What is here already is touched before anything is copied, so that no copy drives out what this frame needs.
void Renderer::Parts::makeResident(const scene::Frame& frame, RenderStatistics& statistics) {
  ++frameNumber;
  if (!refused.empty()) ++framesWithRefused;
  refused.clear();
  tiles.clear();
  pictures.clear();
  for (const scene::DrawnPicture& picture : frame.pictures)
    pictures.push_back({.picture = &picture});
  const auto visible = [&](const scene::DrawnTile& tile, const auto& visit) {
    for (std::size_t i = tile.firstPicture; i < tile.firstPicture + tile.pictureCount; ++i) {
      if (frame.looks[frame.pictures[i].layer].visible) visit(pictures[i]);
    }
  };
  for (const scene::DrawnTile& tile : frame.tiles) {
    if (tile.mesh == nullptr) continue;
    tiles.push_back({.tile = &tile,
                     .mesh = geometry.touch(tile.mesh->serial, frameNumber),
                     .relief = tile.relief ? reliefs.touch(tile.relief->serial, frameNumber) : nullptr});
    visible(tile, [&](ResidentPicture& p) { p.place = colours.touch(p.picture->image->serial, frameNumber); });
  }
  const auto bring = [&](auto& pool, const auto& payload, auto& place) {
    if (place != nullptr || payload == nullptr) return;
    place = pool.touch(payload->serial, frameNumber);  // another tile of this frame may have brought it
    if (place != nullptr) return;
    place = pool.upload(*payload, frameNumber);
    if (place != nullptr) {
      ++statistics.uploads;
      statistics.uploadBytes += bytesOf(*payload);
    } else {
      ++statistics.tilesWithoutRoom;
      refused.push_back(payload->serial);
    }
  };
  for (ResidentTile& tile : tiles) {
    bring(geometry, tile.tile->mesh, tile.mesh);
    bring(reliefs, tile.tile->relief, tile.relief);
    visible(*tile.tile, [&](ResidentPicture& p) { bring(colours, p.picture->image, p.place); });
  }
  copySoon(frame, statistics);
  std::erase_if(tiles, [](const ResidentTile& tile) { return tile.mesh == nullptr; });
}

void Renderer::Parts::orderTiles() {
  turns.clear();
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const geo::Vec3f origin = records[i].originCoarse_rte;
    const TexturePlace* colour = tiles[i].colours.isLayered ? nullptr : tiles[i].colours.one.place;
    turns.push_back({.chunk = tiles[i].mesh->chunk,
                     .isLayered = tiles[i].colours.isLayered,
                     .colourBlock = colour != nullptr ? colour->block : 0,
                     .reliefBlock = tiles[i].relief != nullptr ? tiles[i].relief->block : 0,
                     .distance = origin.x * origin.x + origin.y * origin.y + origin.z * origin.z,
                     .tile = static_cast<std::uint32_t>(i)});
  }
  std::sort(turns.begin(), turns.end());
}

void Renderer::Parts::colourTiles(const scene::Frame& frame) {
  pictureRecords.clear();
  adjusts = false;
  for (const scene::LayerLook& look : frame.looks)
    adjusts = adjusts || (look.visible && !look.nightLights && look.adjusts());
  for (ResidentTile& tile : tiles) {
    const std::span ofTile(pictures.data() + tile.tile->firstPicture, tile.tile->pictureCount);
    tile.colours = coloursOf(ofTile, frame.looks, lampsMayBurn(*tile.tile->mesh, frame.light), pictureRecords);
  }
}

void Renderer::Parts::writeCommands(const scene::Frame& frame, const SnappedEye& eye, RenderStatistics& statistics) {
  records.clear();
  commands.clear();
  groups.clear();
  chunkRuns.clear();
  const geo::Vec3f ground = bareGround(frame);
  for (const ResidentTile& tile : tiles)
    records.push_back(recordOf(tile, eye, ground));
  orderTiles();
  for (const Turn& turn : turns) {
    const CommandRun empty{.chunk = turn.chunk, .first = commands.size(), .count = 0};
    if (groups.empty() || groups.back().nearest.group() != turn.group())
      groups.push_back({.nearest = turn, .run = empty});
    if (chunkRuns.empty() || chunkRuns.back().chunk != turn.chunk) chunkRuns.push_back(empty);
    appendCommands(tiles[turn.tile], turn.tile, commands);
    groups.back().run.count = commands.size() - groups.back().run.first;
    chunkRuns.back().count = commands.size() - chunkRuns.back().first;
  }
  std::ranges::sort(groups, {}, [](const Group& group) { return group.nearest.distance; });
  for (const DrawCommand& command : commands)
    statistics.triangles += command.count / 3;
  statistics.tilesDrawn = static_cast<int>(tiles.size());
}

GLuint Renderer::Parts::textureOf(const TexturePool& pool, std::uint32_t block) const {
  if (block < pool.blockCount()) return pool.texture(block);
  return &pool == &colours ? noColours.name() : noReliefs.name();
}

/// For tiles of several pictures, whatever blocks those lie in.
void Renderer::Parts::bindPictures() {
  stream(pictureBuffer, pictureRecords.data(), pictureRecords.size());
  glTextureBuffer(pictureTexture.name(), GL_RGBA32F, pictureBuffer.name());
  glBindTextureUnit(kPictureUnit, pictureTexture.name());
  for (GLuint i = 0; i < shading::kMostBlocks; ++i)
    glBindTextureUnit(kFirstBlockUnit + i, textureOf(colours, i));
}

void Renderer::Parts::drawGroups(RenderStatistics& statistics) {
  stream(recordBuffer, records.data(), records.size());
  stream(commandBuffer, commands.data(), commands.size());
  if (!pictureRecords.empty()) bindPictures();
  glBindVertexArray(geometry.vertexArray());
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, frameBlock.name());
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commandBuffer.name());
  for (GLuint unit = 0; unit < kFirstBlockUnit + shading::kMostBlocks; ++unit)
    glBindSampler(unit, 0);
  const Program& layered = adjusts ? programs.adjusted : programs.layered;
  for (const Group& group : groups) {
    glUseProgram(group.nearest.isLayered ? layered.name() : programs.one.name());
    geometry.bind(group.run.chunk);
    glBindTextureUnit(kColourUnit, textureOf(colours, group.nearest.colourBlock));
    glBindTextureUnit(kReliefUnit, textureOf(reliefs, group.nearest.reliefBlock));
    glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_SHORT, group.run.offset(),
                                static_cast<GLsizei>(group.run.count), 0);
    ++statistics.drawCalls;
  }
  glBindVertexArray(0);
}

/// Draws a triangle with each program: drivers compile when something is drawn, and no frame shall wait for that.
io::Result<void> Renderer::Parts::warmUp() {
  const auto target = RenderTarget::create({.width = 1, .height = 1});
  if (!target) return tl::unexpected(target.error());
  scene::TerrainMesh mesh{.serial = std::numeric_limits<std::uint64_t>::max()};
  mesh.vertices.resize(3);
  mesh.indices = {0, 1, 2};
  const MeshPlace* place = geometry.upload(mesh, frameNumber);
  if (place == nullptr) return {};  // the first frame will tell
  const FrameBlock block{};
  stream(frameBlock, &block, 1);
  setState(*target);
  records.assign(1, TileRecord{.pictureCount = 1});
  pictureRecords.assign(1, PictureRecord{});
  commands.assign(
      1, DrawCommand{
             .count = 3, .firstIndex = place->firstIndex, .baseVertex = static_cast<std::int32_t>(place->firstVertex)});
  RenderStatistics unused;
  for (const bool isLayered : {false, true}) {
    groups.assign(1, Group{.nearest = {.chunk = place->chunk, .isLayered = isLayered},
                           .run = {.chunk = place->chunk, .first = 0, .count = 1}});
    for (const bool adjusted : {false, true}) {
      adjusts = adjusted;
      drawGroups(unused);
    }
  }
  return {};
}

void Renderer::Parts::drawDebug(const scene::Frame& frame, const RenderTarget& target, RenderStatistics& statistics) {
  if (!debug || !(frame.debug.views.any() || frame.debug.frozenCut)) return;
  statistics.drawCalls += debug->draw(frame,
                                      {.geometry = &geometry,
                                       .recordBinding = kRecordBinding,
                                       .recordBuffer = recordBuffer.name(),
                                       .commandBuffer = commandBuffer.name(),
                                       .frameBlock = frameBlock.name(),
                                       .runs = chunkRuns,
                                       .tiles = tiles,
                                       .records = records},
                                      target);
}

Renderer::Renderer(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

io::Result<Renderer> Renderer::create(const RendererOptions& options) {
  if (auto usable = checkCurrentContext(); !usable) return tl::unexpected(usable.error());
  auto programs = compilePrograms(options.asOnAnyGpu);
  if (!programs) return tl::unexpected(programs.error());
  auto parts = std::make_unique<Parts>(std::move(*programs), options.gpuBudgetBytes);
  if (auto ready = parts->warmUp(); !ready) return tl::unexpected(ready.error());
  return Renderer(std::move(parts));
}

RenderStatistics Renderer::draw(const scene::Frame& frame, const RenderTarget& target) {
  const auto start = std::chrono::steady_clock::now();
  RenderStatistics statistics;
  Parts& p = *parts_;
  p.makeResident(frame, statistics);
  statistics.upload_ms = millisecondsSince(start);
  const auto submitStart = std::chrono::steady_clock::now();
  const SnappedEye eye = snappedEye(frame.view.eye);
  const FrameBlock block = blockOf(frame, eye);
  stream(p.frameBlock, &block, 1);
  setState(target);
  clear(frame, target.framebuffer());
  p.colourTiles(frame);
  p.writeCommands(frame, eye, statistics);
  p.drawGroups(statistics);
  p.drawDebug(frame, target, statistics);
  statistics.gpuBytes = p.geometry.bytes() + p.colours.bytes() + p.reliefs.bytes();
  statistics.submit_ms = millisecondsSince(submitStart);
  return statistics;
}

const scene::Residency& Renderer::residency() const {
  return *parts_;
}

io::Result<void> Renderer::prepareDebugViews() {
  if (parts_->debug) return {};
  auto pass = DebugPass::create();
  if (!pass) return tl::unexpected(pass.error());
  parts_->debug = std::move(*pass);
  return {};
}

void finish() {
  glFinish();
}

}  // namespace tellurion::render
