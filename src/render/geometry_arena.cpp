#include "render/geometry_arena.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tellurion::render {
namespace {

constexpr std::uint32_t kVertexBytes = sizeof(scene::TerrainVertex);
constexpr std::uint32_t kIndexBytes = sizeof(std::uint16_t);
constexpr std::uint64_t kFirstChunkBytes = 8u << 20u;  // most scenes outgrow it once, and its successor never
constexpr std::uint64_t kGrowth = 4;
constexpr std::uint64_t kNextChunkBytes = 24u << 20u;  // times the number of chunks there are and one
constexpr std::uint64_t kSmallChunkBytes = 1u << 20u;  // the last one of the budget, and steps beyond it
constexpr std::uint64_t kExcessShare = 8;              // such a step is at least that part of all there is
constexpr double kVertexShare = 0.7;                   // of a tile's geometry

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

std::uint32_t unitsIn(double bytes, std::uint32_t unitBytes, std::size_t atLeast) {
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::uint32_t>(std::clamp(bytes / unitBytes, static_cast<double>(atLeast), kMost));
}

}  // namespace

std::uint64_t bytesOf(const scene::TerrainMesh& mesh) {
  return mesh.vertices.size() * kVertexBytes + mesh.indices.size() * kIndexBytes;
}

GeometryArena::GeometryArena(std::uint64_t budgetBytes) : budget_(budgetBytes) {
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  vertexArray_ = VertexArray(name);
  describeVertices(name);
}

const MeshPlace* GeometryArena::upload(const scene::TerrainMesh& mesh, std::uint64_t frame, bool mayExceed) {
  if (mesh.vertices.empty() || mesh.indices.empty()) return nullptr;
  const auto place = makeRoom(mesh, frame, mayExceed);
  if (!place) return nullptr;
  const Chunk& chunk = chunks_[place->chunk];
  glNamedBufferSubData(chunk.vertexBuffer.name(), GLintptr{place->firstVertex} * kVertexBytes,
                       GLsizeiptr{place->vertexCount} * kVertexBytes, mesh.vertices.data());
  glNamedBufferSubData(chunk.indexBuffer.name(), GLintptr{place->firstIndex} * kIndexBytes,
                       GLsizeiptr{place->indexCount} * kIndexBytes, mesh.indices.data());
  return resident_.insert(mesh.serial, frame, *place);
}

std::optional<MeshPlace> GeometryArena::makeRoom(const scene::TerrainMesh& mesh, std::uint64_t frame, bool mayExceed) {
  for (std::uint32_t chunk = 0; chunk < chunks_.size(); ++chunk) {
    if (const auto place = placeIn(chunk, mesh)) return place;
  }
  if (growWithin(budget_ - std::min(bytes_, budget_), mesh)) return placeIn(last(), mesh);
  while (const auto evicted = resident_.evictOldest(frame)) {
    release(*evicted);
    if (const auto place = placeIn(evicted->chunk, mesh)) return place;
  }
  return mayExceed && growBeyond(mesh) ? placeIn(last(), mesh) : std::nullopt;
}

/// More room in the last chunk for a mesh that found none, of what is left of the budget.
bool GeometryArena::growWithin(std::uint64_t left, const scene::TerrainMesh& mesh) {
  if (chunks_.size() == 1) {
    // Only once, and only by a good part.
    const std::uint64_t before = chunks_.front().bytes();
    const std::uint64_t wanted = std::min(kGrowth * kFirstChunkBytes, before + left);
    if (wanted >= 2 * before && growLastChunk(wanted, mesh)) return true;
  }
  if (left < kSmallChunkBytes || chunks_.size() == kMostChunks) return false;
  return addChunk(std::min(nextChunkBytes(left), left), mesh);
}

/// Chunks that are left must do for all that is left; each then makes what there is as many times as large.
std::uint64_t GeometryArena::nextChunkBytes(std::uint64_t left) const {
  if (chunks_.empty()) return kFirstChunkBytes;
  const auto now = static_cast<double>(bytes_);
  const double times = std::pow(1.0 + static_cast<double>(left) / now, 1.0 / double(kMostChunks - chunks_.size()));
  const auto needed = static_cast<std::uint64_t>(std::ceil(now * (times - 1.0)));
  return std::max((chunks_.size() + 1) * kNextChunkBytes, needed);
}

bool GeometryArena::growBeyond(const scene::TerrainMesh& mesh) {
  const std::uint64_t step = std::max(kSmallChunkBytes, bytes_ / kExcessShare);
  return chunks_.size() < kMostChunks ? addChunk(step, mesh) : growLastChunk(chunks_.back().bytes() + step, mesh);
}

std::uint32_t GeometryArena::last() const {
  return static_cast<std::uint32_t>(chunks_.size() - 1);
}

std::optional<MeshPlace> GeometryArena::placeIn(std::uint32_t chunk, const scene::TerrainMesh& mesh) {
  const auto vertexCount = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto indexCount = static_cast<std::uint32_t>(mesh.indices.size());
  Chunk& c = chunks_[chunk];
  const auto firstVertex = c.vertices.allocate(vertexCount);
  if (!firstVertex) return std::nullopt;
  const auto firstIndex = c.indices.allocate(indexCount);
  if (!firstIndex) {
    c.vertices.release(*firstVertex, vertexCount);
    return std::nullopt;
  }
  return MeshPlace{.chunk = chunk,
                   .firstVertex = *firstVertex,
                   .vertexCount = vertexCount,
                   .firstIndex = *firstIndex,
                   .indexCount = indexCount};
}

void GeometryArena::release(const MeshPlace& place) {
  chunks_[place.chunk].vertices.release(place.firstVertex, place.vertexCount);
  chunks_[place.chunk].indices.release(place.firstIndex, place.indexCount);
}

/// Of about `bytes`; the mesh fits in.
bool GeometryArena::addChunk(std::uint64_t bytes, const scene::TerrainMesh& mesh) {
  const auto share = static_cast<double>(bytes);
  const std::uint32_t vertices = unitsIn(share * kVertexShare, kVertexBytes, mesh.vertices.size());
  const std::uint32_t indices = unitsIn(share * (1.0 - kVertexShare), kIndexBytes, mesh.indices.size());
  Chunk chunk{.vertexBuffer = makeBuffer(std::uint64_t{vertices} * kVertexBytes),
              .indexBuffer = makeBuffer(std::uint64_t{indices} * kIndexBytes),
              .vertices = RangeAllocator(vertices),
              .indices = RangeAllocator(indices)};
  if (!chunk.vertexBuffer || !chunk.indexBuffer) return false;
  bytes_ += chunk.bytes();
  chunks_.push_back(std::move(chunk));
  return true;
}

/// To about `bytes`; the mesh fits in behind what is there, which stays where it is.
bool GeometryArena::growLastChunk(std::uint64_t bytes, const scene::TerrainMesh& mesh) {
  Chunk& chunk = chunks_.back();
  const std::uint64_t before = chunk.bytes();
  const auto share = static_cast<double>(bytes);
  const std::uint32_t vertices =
      unitsIn(share * kVertexShare, kVertexBytes, chunk.vertices.capacity() + mesh.vertices.size());
  const std::uint32_t indices =
      unitsIn(share * (1.0 - kVertexShare), kIndexBytes, chunk.indices.capacity() + mesh.indices.size());
  Buffer vertexBuffer = grownBuffer(chunk.vertexBuffer, std::uint64_t{chunk.vertices.capacity()} * kVertexBytes,
                                    std::uint64_t{vertices} * kVertexBytes);
  Buffer indexBuffer = grownBuffer(chunk.indexBuffer, std::uint64_t{chunk.indices.capacity()} * kIndexBytes,
                                   std::uint64_t{indices} * kIndexBytes);
  if (!vertexBuffer || !indexBuffer) return false;
  chunk.vertexBuffer = std::move(vertexBuffer);
  chunk.indexBuffer = std::move(indexBuffer);
  chunk.vertices.grow(vertices);
  chunk.indices.grow(indices);
  bytes_ += chunk.bytes() - before;
  return true;
}

std::uint64_t GeometryArena::Chunk::bytes() const {
  return std::uint64_t{vertices.capacity()} * kVertexBytes + std::uint64_t{indices.capacity()} * kIndexBytes;
}

void GeometryArena::bind(std::uint32_t chunk) const {
  glVertexArrayVertexBuffer(vertexArray_.name(), 0, chunks_[chunk].vertexBuffer.name(), 0, GLsizei{kVertexBytes});
  glVertexArrayElementBuffer(vertexArray_.name(), chunks_[chunk].indexBuffer.name());
}

}  // namespace tellurion::render
