#include "render/warp_pass.h"

#include <epoxy/gl.h>

#include <array>

#include "render/shader.h"
#include "render/shader_texts.h"
#include "render/warp_shape.h"

namespace tellurion::render {

io::Result<WarpPass> WarpPass::create() {
  auto program = compileProgram({shaders::warp_vert}, {shaders::warp_direction, shaders::warp_frag});
  if (!program) return tl::unexpected(program.error());
  WarpPass pass;
  pass.program_ = std::move(*program);
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  pass.nothing_ = VertexArray(name);
  return pass;
}

void WarpPass::draw(const scene::Warp& warp, const FaceWindow& window, const RenderTarget& face,
                    const scene::PixelRect& piece, const RenderTarget& target) const {
  // Another look at the same texels that does not decode them: Mesa's software renderers do so a little wrong.
  GLuint name = 0;
  glGenTextures(1, &name);
  const Texture numbers(name);
  glTextureView(name, GL_TEXTURE_2D, face.colour(), GL_RGBA8, 0, 1, 0, 1);

  const GLuint program = program_.name();
  const auto place = [&](const char* uniform) { return glGetUniformLocation(program, uniform); };
  const geo::Vec4f shape = shapeOf(warp);
  const geo::Mat3f faceFromWarp(scene::kCubeFaces[window.face]);
  glProgramUniform4f(program, place("shape"), shape.x, shape.y, shape.z, shape.w);
  glProgramUniform3f(program, place("piece"), static_cast<float>(piece.left), static_cast<float>(piece.top),
                     static_cast<float>(piece.height));
  glProgramUniformMatrix3fv(program, place("faceFromWarp"), 1, GL_FALSE, &faceFromWarp[0][0]);
  glProgramUniform3f(program, place("faceWindow"), static_cast<float>(window.texels.left),
                     static_cast<float>(window.texels.top), static_cast<float>(window.side));

  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer());
  glViewport(0, 0, target.size().width, target.size().height);
  glEnable(GL_FRAMEBUFFER_SRGB);
  for (const GLenum off : std::array<GLenum, 4>{GL_DEPTH_TEST, GL_BLEND, GL_SCISSOR_TEST, GL_CULL_FACE})
    glDisable(off);
  glUseProgram(program);
  glBindTextureUnit(0, numbers.name());
  glBindSampler(0, 0);
  glBindVertexArray(nothing_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
}

}  // namespace tellurion::render
