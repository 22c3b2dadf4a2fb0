#include "render/shader.h"

#include <epoxy/gl.h>
#include <fmt/format.h>

#include <array>
#include <span>
#include <string>
#include <vector>

namespace tellurion::render {
namespace {

constexpr std::string_view kVersion = "#version 450 core\n";

/// A shader object lives only until its program is linked.
class Stage {
 public:
  Stage(GLenum kind, std::initializer_list<std::string_view> parts) : name_(glCreateShader(kind)) {
    std::vector<const GLchar*> texts{kVersion.data()};
    std::vector<GLint> lengths{static_cast<GLint>(kVersion.size())};
    for (const std::string_view part : parts) {
      texts.push_back(part.data());
      lengths.push_back(static_cast<GLint>(part.size()));
    }
    glShaderSource(name_, static_cast<GLsizei>(texts.size()), texts.data(), lengths.data());
    glCompileShader(name_);
  }
  ~Stage() { glDeleteShader(name_); }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  GLuint name() const { return name_; }

  std::string complaint() const {
    GLint ok = GL_FALSE;
    glGetShaderiv(name_, GL_COMPILE_STATUS, &ok);
    if (ok == GL_TRUE) return {};
    std::string log(2048, '\0');
    GLsizei length = 0;
    glGetShaderInfoLog(name_, static_cast<GLsizei>(log.size()), &length, log.data());
    log.resize(static_cast<std::size_t>(length));
    return log.empty() ? "no reason given" : log;
  }

 private:
  GLuint name_;
};

io::Result<Program> linked(std::span<const Stage> stages) {
  for (const Stage& stage : stages) {
    const std::string complaint = stage.complaint();
    if (complaint.empty()) continue;
    return io::fail(io::Failure::Code::unsupported,
                    fmt::format("the graphics driver cannot compile a shader: {}", complaint));
  }
  Program program(glCreateProgram());
  for (const Stage& stage : stages)
    glAttachShader(program.name(), stage.name());
  glLinkProgram(program.name());
  for (const Stage& stage : stages)
    glDetachShader(program.name(), stage.name());
  GLint ok = GL_FALSE;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &ok);
  if (ok == GL_TRUE) return program;
  std::string log(2048, '\0');
  GLsizei length = 0;
  glGetProgramInfoLog(program.name(), static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  return io::fail(io::Failure::Code::unsupported, fmt::format("the graphics driver cannot link a shader: {}", log));
}

}  // namespace

io::Result<Program> compileProgram(std::initializer_list<std::string_view> vertexParts,
                                   std::initializer_list<std::string_view> fragmentParts) {
  const std::array<Stage, 2> stages{Stage(GL_VERTEX_SHADER, vertexParts), Stage(GL_FRAGMENT_SHADER, fragmentParts)};
  return linked(stages);
}

io::Result<Program> compileComputeProgram(std::initializer_list<std::string_view> parts) {
  const std::array<Stage, 1> stages{Stage(GL_COMPUTE_SHADER, parts)};
  return linked(stages);
}

}  // namespace tellurion::render
