#include "render/geometry_arena.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <limits>

namespace tellurion::render {
namespace {

constexpr std::uint32_t kVertexBytes = sizeof(scene::TerrainVertex);
constexpr std::uint32_t kIndexBytes = sizeof(std::uint16_t);
constexpr std::uint32_t kFirstUnits = 1u << 17u;  // 5 MiB of vertices
constexpr double kVertexShare = 0.7;              // of a tile's geometry

void describeVertices(GLuint vao) {
  using V = scene::TerrainVertex;
  struct Field {
    GLuint attribute;
    GLint components;
    GLenum type;
    GLboolean normalised;
    std::size_t offset;
  };
  constexpr std::array kFields{Field{0, 3, GL_FLOAT, GL_FALSE, offsetof(V, position_tile)},
                               Field{1, 3, GL_SHORT, GL_TRUE, offsetof(V, up_body)},
                               Field{2, 1, GL_UNSIGNED_SHORT, GL_FALSE, offsetof(V, s)},
                               Field{9, 3, GL_SHORT, GL_FALSE, offsetof(V, fine_tile)},
                               Field{10, 1, GL_UNSIGNED_SHORT, GL_FALSE, offsetof(V, t)},
                               Field{11, 4, GL_SHORT, GL_FALSE, offsetof(V, toParent)},
                               Field{12, 1, GL_FLOAT, GL_FALSE, offsetof(V, height_m)}};
  for (const Field& f : kFields) {
    glEnableVertexArrayAttrib(vao, f.attribute);
    glVertexArrayAttribFormat(vao, f.attribute, f.components, f.type, f.normalised, static_cast<GLuint>(f.offset));
    glVertexArrayAttribBinding(vao, f.attribute, 0);
  }
}

std::uint32_t unitsIn(double bytes, std::uint32_t unitBytes) {
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::uint32_t>(std::clamp(bytes / unitBytes, 1.0, kMost));
}

}  // namespace

GeometryArena::GeometryArena(std::uint64_t budgetBytes) {
  const auto budget = static_cast<double>(budgetBytes);
  vertices_.unitBytes = kVertexBytes;
  vertices_.unitsInBudget = unitsIn(budget * kVertexShare, kVertexBytes);
  indices_.unitBytes = kIndexBytes;
  indices_.unitsInBudget = unitsIn(budget * (1.0 - kVertexShare), kIndexBytes);
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  vertexArray_ = VertexArray(name);
  describeVertices(name);
}

std::uint64_t GeometryArena::bytes() const {
  return std::uint64_t{vertices_.ranges.capacity()} * kVertexBytes +
         std::uint64_t{indices_.ranges.capacity()} * kIndexBytes;
}

const MeshPlace* GeometryArena::upload(const scene::TerrainMesh& mesh, std::uint64_t frame) {
  MeshPlace place;
  place.vertexCount = static_cast<std::uint32_t>(mesh.vertices.size());
  place.indexCount = static_cast<std::uint32_t>(mesh.indices.size());
  if (place.vertexCount == 0 || place.indexCount == 0) return nullptr;
  const auto firstVertex = makeRoom(vertices_, place.vertexCount, frame);
  if (!firstVertex) return nullptr;
  const auto firstIndex = makeRoom(indices_, place.indexCount, frame);
  if (!firstIndex) {
    vertices_.ranges.release(*firstVertex, place.vertexCount);
    return nullptr;
  }
  place.firstVertex = *firstVertex;
  place.firstIndex = *firstIndex;
  glNamedBufferSubData(vertices_.buffer.name(), GLintptr{place.firstVertex} * kVertexBytes,
                       GLsizeiptr{place.vertexCount} * kVertexBytes, mesh.vertices.data());
  glNamedBufferSubData(indices_.buffer.name(), GLintptr{place.firstIndex} * kIndexBytes,
                       GLsizeiptr{place.indexCount} * kIndexBytes, mesh.indices.data());
  return resident_.insert(mesh.serial, frame, place);
}

std::optional<std::uint32_t> GeometryArena::makeRoom(Line& line, std::uint32_t count, std::uint64_t frame) {
  while (true) {
    if (const auto first = line.ranges.allocate(count)) return first;
    const bool mayGrow = line.ranges.capacity() < line.unitsInBudget;
    if (mayGrow && growLine(line, count)) continue;
    if (const auto evicted = resident_.evictOldest(frame)) {
      release(*evicted);
    } else if (!growLine(line, count)) {
      return std::nullopt;
    }
  }
}

void GeometryArena::release(const MeshPlace& place) {
  vertices_.ranges.release(place.firstVertex, place.vertexCount);
  indices_.ranges.release(place.firstIndex, place.indexCount);
}

// Doubles up to the budget; beyond it only by what is asked for.
bool GeometryArena::growLine(Line& line, std::uint32_t count) {
  const std::uint64_t old = line.ranges.capacity();
  const std::uint64_t doubled = std::max<std::uint64_t>({kFirstUnits, 2 * old, old + count});
  const std::uint64_t wanted = old < line.unitsInBudget ? std::min<std::uint64_t>(doubled, line.unitsInBudget)
                                                        : old + std::max(count, kFirstUnits / 4);
  if (wanted > std::numeric_limits<std::int32_t>::max()) return false;
  Buffer larger = makeBuffer(wanted * line.unitBytes);
  if (!larger) return false;
  if (old > 0) {
    glCopyNamedBufferSubData(line.buffer.name(), larger.name(), 0, 0, static_cast<GLsizeiptr>(old * line.unitBytes));
  }
  line.buffer = std::move(larger);
  line.ranges.grow(static_cast<std::uint32_t>(wanted));
  bindBuffers();
  return true;
}

void GeometryArena::bindBuffers() {
  if (vertices_.buffer) {
    glVertexArrayVertexBuffer(vertexArray_.name(), 0, vertices_.buffer.name(), 0, GLsizei{kVertexBytes});
  }
  if (indices_.buffer) glVertexArrayElementBuffer(vertexArray_.name(), indices_.buffer.name());
}

}  // namespace tellurion::render
