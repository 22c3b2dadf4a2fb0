#pragma once

#include <cstdint>
#include <optional>

#include "render/gl_objects.h"
#include "render/range_allocator.h"
#include "render/resident_set.h"
#include "scene/frame.h"

namespace tellurion::render {

/// Where a mesh lies in the arena, in vertices and indices.
struct MeshPlace {
  std::uint32_t firstVertex = 0;
  std::uint32_t vertexCount = 0;
  std::uint32_t firstIndex = 0;
  std::uint32_t indexCount = 0;
};

/// All meshes that are on the GPU, in one vertex and one index buffer, so that any of them go out in one draw call.
/// Buffers start small and double; at the budget those used longest ago leave. What a frame needs always gets in, over
/// the budget if it must: a hole in the ground is worse. GL thread only.
class GeometryArena {
 public:
  explicit GeometryArena(std::uint64_t budgetBytes);

  /// The place of a mesh that is here already, kept for this frame; null when it is not.
  const MeshPlace* touch(std::uint64_t serial, std::uint64_t frame) { return resident_.touch(serial, frame); }
  /// Copies a mesh that is not here yet. Null only when the GPU has no memory left at all. The mesh may be dropped
  /// after.
  const MeshPlace* upload(const scene::TerrainMesh& mesh, std::uint64_t frame);

  /// Attributes 0 to 2 and 9 to 12, as terrain.vert.glsl names them; element buffer bound. Its buffers change when the
  /// arena grows.
  unsigned int vertexArray() const { return vertexArray_.name(); }
  std::uint64_t bytes() const;
  std::size_t meshCount() const { return resident_.size(); }

 private:
  struct Line {  // one growing buffer and who has which part of it
    Buffer buffer;
    RangeAllocator ranges;
    std::uint32_t unitBytes = 0;
    std::uint32_t unitsInBudget = 0;
  };
  std::optional<std::uint32_t> makeRoom(Line& line, std::uint32_t count, std::uint64_t frame);
  bool growLine(Line& line, std::uint32_t count);
  void bindBuffers();
  void release(const MeshPlace& place);

  Line vertices_;
  Line indices_;
  VertexArray vertexArray_;
  ResidentSet<MeshPlace> resident_;
};

}  // namespace tellurion::render
