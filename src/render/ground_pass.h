#pragma once

#include <cstdint>

#include "io/failure.h"
#include "render/draw_plan.h"
#include "render/gl_objects.h"
#include "render/gpu_residents.h"
#include "scene/frame.h"

namespace tellurion::render {

/// The vertex array's binding that a tile's record comes from.
inline constexpr unsigned int kRecordBinding = 1;

/// The programs that draw the ground, and the buffers that they read beside what GpuResidents holds. GL thread only.
class GroundPass {
 public:
  /// Compiles the shaders. The records of tiles become attributes of the vertex array of `geometry`.
  static io::Result<GroundPass> create(const GeometryArena& geometry, bool asOnAnyGpu);

  /// What is the same for a whole frame.
  void setFrame(const scene::Frame& frame, const SnappedEye& eye);
  /// Compiles the programs for ground in air, with a triangle of a mesh as in warmUp(). AirPass has bound what they
  /// read.
  io::Result<void> prepareAir(const MeshPlace& mesh, const GpuResidents& residents);
  /// Draws the plan's groups into what is bound, through the air where prepareAir() was called and AirPass has set the
  /// frame. The number of draw calls.
  int draw(const DrawPlan& plan, const GpuResidents& residents, bool inAir);
  /// Draws a triangle of a mesh with each program: drivers compile when something is drawn, and no frame shall wait for
  /// that.
  void warmUp(const MeshPlace& mesh, const GpuResidents& residents);

  unsigned int recordBuffer() const { return recordBuffer_.name(); }
  unsigned int commandBuffer() const { return commandBuffer_.name(); }
  unsigned int frameBlock() const { return frameBlock_.name(); }

 private:
  struct Programs {
    Program one;       ///< tiles of one picture
    Program lamps;     ///< of that and one of night lights
    Program water;     ///< or of water
    Program both;      ///< or of each
    Program layered;   ///< tiles of several pictures
    Program adjusted;  ///< likewise, where colours of some layer are adjusted
  };
  GroundPass(Programs programs, bool asOnAnyGpu);
  static io::Result<Programs> compilePrograms(bool asOnAnyGpu, bool inAir);
  void bindPictures(const GpuResidents& residents) const;
  void drawGroup(const DrawGroup& group, const Programs& programs, bool adjusts, const GpuResidents& residents) const;
  void drawWithEach(const Programs& programs, const MeshPlace& mesh, const GpuResidents& residents);

  Programs programs_;
  Programs airPrograms_;  ///< empty until prepareAir()
  bool asOnAnyGpu_;
  Buffer frameBlock_;
  Buffer recordBuffer_;
  Buffer commandBuffer_;
  Buffer pictureBuffer_;
  Texture pictureTexture_;
  Sampler coverageSampler_;  // how shaders read it
};

}  // namespace tellurion::render
