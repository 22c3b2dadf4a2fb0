#include "render/debug_pass.h"

#include <epoxy/gl.h>

#include <array>
#include <cmath>

#include "raster/colour.h"
#include "render/shader.h"
#include "render/shader_texts.h"

namespace tellurion::render {
namespace {

using raster::Rgba8;
using scene::DebugView;

constexpr float kFill = 0.45f;         // how much a tint covers
constexpr float kLevelBorder = 1.0f;   // where the tint is of the level
constexpr float kErrorBorder = 0.55f;  // where it is of the error, and the border black
constexpr float kBoxLine = 0.9f;
constexpr Rgba8 kWire{255, 0, 200, 255};  // the ground has no such colour
constexpr Rgba8 kWireOverTint{0, 0, 0, 255};
constexpr float kWireStrength = 0.4f;  // most sides belong to two triangles and are drawn twice
constexpr Rgba8 kPyramid{255, 255, 255, 255};

// Steps of depth towards the eye: what is drawn again must not fall behind itself.
constexpr float kTintSteps = 4.0f;
constexpr float kWireSlope = 1.0f;
constexpr float kWireSteps = 16.0f;

constexpr int kLegendMargin = 8;
constexpr int kTallPicture = 1000;  // from here on letters are twice as large

geo::Vec4f linear(Rgba8 c, float strength) {
  const auto light = [](std::uint8_t srgb) { return static_cast<float>(raster::linearFromSrgb(srgb)) / 65535.0f; };
  return {light(c.r), light(c.g), light(c.b), strength};
}

/// As unpackUnorm4x8 reads it.
std::uint32_t packed(const geo::Vec4f& colour) {
  std::uint32_t out = 0;
  for (int i = 0; i < 4; ++i)
    out |= static_cast<std::uint32_t>(std::lround(255.0f * colour[i])) << (8 * i);
  return out;
}

Buffer emptyBuffer() {
  GLuint name = 0;
  glCreateBuffers(1, &name);
  return Buffer(name);
}

template <class T>
void stream(const Buffer& buffer, const std::vector<T>& values) {
  glNamedBufferData(buffer.name(), static_cast<GLsizeiptr>(values.size() * sizeof(T)), values.data(), GL_STREAM_DRAW);
}

/// The terrain's record with the whole tile as its window and other colours.
TileRecord debugRecord(TileRecord record, const geo::Vec4f& fill, const geo::Vec4f& border) {
  record.colourWindow = {0.0f, 0.0f, 1.0f, 1.0f};
  record.plain = fill;
  record.colourLayer = static_cast<std::int32_t>(packed(border));
  return record;
}

void setState() {
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
  glDepthFunc(GL_GEQUAL);
  glDepthMask(GL_FALSE);
}

void restoreState() {
  glDisable(GL_BLEND);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_TRUE);
  glBindVertexArray(0);
}

int legendPixelFor(const RenderTarget& target) {
  return target.size().height >= kTallPicture ? 2 : 1;
}

}  // namespace

DebugPass::DebugPass(Program tiles, Program lines)
    : tileProgram_(std::move(tiles)),
      lineProgram_(std::move(lines)),
      recordBuffer_(emptyBuffer()),
      lineBuffer_(emptyBuffer()) {
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  lineArray_ = VertexArray(name);
  for (const GLuint attribute : {0u, 1u}) {
    glEnableVertexArrayAttrib(name, attribute);
    glVertexArrayAttribBinding(name, attribute, 0);
  }
  glVertexArrayAttribFormat(name, 0, 3, GL_FLOAT, GL_FALSE, offsetof(LineEnd, position_rte));
  glVertexArrayAttribFormat(name, 1, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(LineEnd, colour));
  glVertexArrayVertexBuffer(name, 0, lineBuffer_.name(), 0, sizeof(LineEnd));
}

io::Result<DebugPass> DebugPass::create() {
  auto tiles = compileProgram({shaders::frame_block, shaders::terrain_vert}, {shaders::debug_tiles_frag});
  if (!tiles) return tl::unexpected(tiles.error());
  auto lines = compileProgram({shaders::frame_block, shaders::debug_lines_vert}, {shaders::debug_lines_frag});
  if (!lines) return tl::unexpected(lines.error());
  return DebugPass(std::move(*tiles), std::move(*lines));
}

int DebugPass::draw(const scene::Frame& frame, const DrawnTerrain& terrain, const RenderTarget& target) {
  const scene::DebugViews views = frame.debug.views;
  int drawCalls = 0;
  setState();
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, terrain.frameBlock);
  const bool tinted = views.has(DebugView::levels) || views.has(DebugView::error);
  if (tinted) {
    fillTints(frame, terrain);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(0.0f, kTintSteps);
    drawCalls += drawTiles(terrain);
    glDisable(GL_POLYGON_OFFSET_FILL);
  }
  if (views.has(DebugView::wireframe)) {
    fillWires(terrain, tinted);
    glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
    glEnable(GL_POLYGON_OFFSET_LINE);
    glPolygonOffset(kWireSlope, kWireSteps);
    drawCalls += drawTiles(terrain);
    glDisable(GL_POLYGON_OFFSET_LINE);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  }
  collectLines(frame);
  drawCalls += drawLines();
  restoreState();
  drawLegend(frame, target);
  return drawCalls;
}

/// Of both views the error fills the tile and the level colours its border.
void DebugPass::fillTints(const scene::Frame& frame, const DrawnTerrain& terrain) {
  const bool levels = frame.debug.views.has(DebugView::levels);
  const bool error = frame.debug.views.has(DebugView::error);
  records_.clear();
  for (std::size_t i = 0; i < terrain.tiles.size(); ++i) {
    const scene::DrawnTile& tile = *terrain.tiles[i].tile;
    const Rgba8 ofLevel = scene::levelColour(tile.id.level);
    const Rgba8 fill = error ? scene::errorColour(tile.error_px, frame.debug.tolerance_px) : ofLevel;
    const geo::Vec4f border = levels ? linear(ofLevel, kLevelBorder) : linear({0, 0, 0, 255}, kErrorBorder);
    records_.push_back(debugRecord(terrain.records[i], linear(fill, kFill), border));
  }
}

void DebugPass::fillWires(const DrawnTerrain& terrain, bool overTints) {
  const geo::Vec4f colour = linear(overTints ? kWireOverTint : kWire, kWireStrength);
  records_.clear();
  for (const TileRecord& record : terrain.records)
    records_.push_back(debugRecord(record, colour, geo::Vec4f(0.0f)));
}

int DebugPass::drawTiles(const DrawnTerrain& terrain) {
  const GLuint vertexArray = terrain.geometry->vertexArray();
  stream(recordBuffer_, records_);
  glUseProgram(tileProgram_.name());
  glVertexArrayVertexBuffer(vertexArray, terrain.recordBinding, recordBuffer_.name(), 0, sizeof(TileRecord));
  glBindVertexArray(vertexArray);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, terrain.commandBuffer);
  for (const CommandRun& run : terrain.runs) {
    terrain.geometry->bind(run.chunk);
    glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_SHORT, run.offset(), static_cast<GLsizei>(run.count), 0);
  }
  glVertexArrayVertexBuffer(vertexArray, terrain.recordBinding, terrain.recordBuffer, 0, sizeof(TileRecord));
  return static_cast<int>(terrain.runs.size());
}

void DebugPass::collectLines(const scene::Frame& frame) {
  const auto add = [&](const geo::BodyPosition& from, const geo::BodyPosition& to, std::uint32_t colour) {
    for (const geo::BodyPosition& end : {from, to})
      lineEnds_.push_back({.position_rte = geo::Vec3f(end - frame.view.eye), .colour = colour});
  };
  lineEnds_.clear();
  for (std::size_t i = 0; i < frame.debug.boxes.size() && i < frame.tiles.size(); ++i) {
    const std::uint32_t colour = packed(linear(scene::levelColour(frame.tiles[i].id.level), kBoxLine));
    const scene::OrientedBox& box = frame.debug.boxes[i];
    for (unsigned corner = 0; corner < scene::OrientedBox::kCorners; ++corner) {
      for (const unsigned axis : {1u, 2u, 4u}) {
        if ((corner & axis) == 0) add(box.corner(corner), box.corner(corner | axis), colour);
      }
    }
  }
  if (!frame.debug.frozenCut) return;
  for (const scene::Segment& line : frame.debug.frozenPyramid)
    add(line.from, line.to, packed(linear(kPyramid, 1.0f)));
}

int DebugPass::drawLines() {
  if (lineEnds_.empty()) return 0;
  stream(lineBuffer_, lineEnds_);
  glUseProgram(lineProgram_.name());
  glBindVertexArray(lineArray_.name());
  glLineWidth(1.0f);
  glDrawArrays(GL_LINES, 0, static_cast<GLsizei>(lineEnds_.size()));
  return 1;
}

void DebugPass::drawLegend(const scene::Frame& frame, const RenderTarget& target) {
  const LegendContent content = legendContentOf(frame);
  if (!content.views.any()) return;
  const int pixel = legendPixelFor(target);
  if (!(content == legendContent_) || pixel != legendPixel_) renewLegend(content, pixel);
  const scene::Viewport size = target.size();
  if (!legendTexture_ || 2 * legendSize_.width > size.width || 2 * legendSize_.height > size.height) return;
  const int left = kLegendMargin;
  const int top = size.height - kLegendMargin;  // rows count from the bottom here, those of the legend from its top
  glBlitNamedFramebuffer(legendFramebuffer_.name(), target.framebuffer(), 0, 0, legendSize_.width, legendSize_.height,
                         left, top, left + legendSize_.width, top - legendSize_.height, GL_COLOR_BUFFER_BIT,
                         GL_NEAREST);
}

void DebugPass::renewLegend(const LegendContent& content, int pixel) {
  legendContent_ = content;
  legendPixel_ = pixel;
  legendTexture_ = Texture();
  const raster::Raster<Rgba8> picture = legendPicture(legendRows(content), pixel);
  legendSize_ = {picture.width, picture.height};
  if (picture.samples.empty()) return;
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &name);
  legendTexture_ = Texture(name);
  glTextureStorage2D(name, 1, GL_SRGB8_ALPHA8, picture.width, picture.height);
  glTextureSubImage2D(name, 0, 0, 0, picture.width, picture.height, GL_RGBA, GL_UNSIGNED_BYTE, picture.samples.data());
  glCreateFramebuffers(1, &name);
  legendFramebuffer_ = Framebuffer(name);
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, legendTexture_.name(), 0);
}

}  // namespace tellurion::render
