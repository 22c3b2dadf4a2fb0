#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "render/gl_objects.h"
#include "render/range_allocator.h"
#include "render/resident_set.h"
#include "scene/frame.h"

namespace tellurion::render {

/// Where a mesh lies in the arena: a chunk of it, and in that, in vertices and indices.
struct MeshPlace {
  std::uint32_t chunk = 0;
  std::uint32_t firstVertex = 0;
  std::uint32_t vertexCount = 0;
  std::uint32_t firstIndex = 0;
  std::uint32_t indexCount = 0;
};

/// What a copy of a mesh takes.
std::uint64_t bytesOf(const scene::TerrainMesh& mesh);

/// All meshes that are on the GPU, in chunks: a vertex and an index buffer each, so that meshes of a chunk go out in
/// one draw call. The first chunk is small and grows once, into one that is enough for most scenes; each further one is
/// larger than the one before, and the last that there may be has what is left of the budget. At the budget the meshes
/// used longest ago leave. What a frame needs always gets in, over the budget if it must: a hole in the ground is
/// worse. A further chunk is made for that, or the last one grows, by an eighth of all there is. GL thread only.
class GeometryArena {
 public:
  static constexpr std::size_t kMostChunks = 4;

  explicit GeometryArena(std::uint64_t budgetBytes);

  /// The place of a mesh that is here already, kept for this frame; null when it is not.
  const MeshPlace* touch(std::uint64_t serial, std::uint64_t frame) { return resident_.touch(serial, frame); }
  /// Copies a mesh that is not here yet. Null only when the GPU has no memory left at all, or when the budget may not
  /// be exceeded. The mesh may be dropped after.
  const MeshPlace* upload(const scene::TerrainMesh& mesh, std::uint64_t frame, bool mayExceed = true);

  /// Attributes 0 to 2 and 9 to 12, as terrain.vert.glsl names them.
  unsigned int vertexArray() const { return vertexArray_.name(); }
  /// Lets the vertex array read a chunk.
  void bind(std::uint32_t chunk) const;
  std::uint64_t bytes() const { return bytes_; }
  const ResidentSet<MeshPlace>& resident() const { return resident_; }

 private:
  struct Chunk {
    Buffer vertexBuffer;
    Buffer indexBuffer;
    RangeAllocator vertices;
    RangeAllocator indices;

    std::uint64_t bytes() const;
  };
  std::optional<MeshPlace> makeRoom(const scene::TerrainMesh& mesh, std::uint64_t frame, bool mayExceed);
  std::optional<MeshPlace> placeIn(std::uint32_t chunk, const scene::TerrainMesh& mesh);
  bool growWithin(std::uint64_t left, const scene::TerrainMesh& mesh);
  bool growBeyond(const scene::TerrainMesh& mesh);
  std::uint64_t nextChunkBytes(std::uint64_t left) const;
  bool addChunk(std::uint64_t bytes, const scene::TerrainMesh& mesh);
  bool growLastChunk(std::uint64_t bytes, const scene::TerrainMesh& mesh);
  std::uint32_t last() const;
  void release(const MeshPlace& place);

  std::uint64_t budget_;
  std::uint64_t bytes_ = 0;
  std::vector<Chunk> chunks_;
  VertexArray vertexArray_;
  ResidentSet<MeshPlace> resident_;
};

}  // namespace tellurion::render
