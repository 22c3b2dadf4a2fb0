#pragma once

#include <initializer_list>
#include <string_view>

#include "io/failure.h"
#include "render/gl_objects.h"

namespace tellurion::render {

/// Compiles and links a program. Each stage is the concatenation of its parts, after the version line. A failure
/// carries the driver's message; our shaders are tested, so it means a driver below OpenGL 4.5 or a broken one.
io::Result<Program> compileProgram(std::initializer_list<std::string_view> vertexParts,
                                   std::initializer_list<std::string_view> fragmentParts);

/// The same of a program of one stage, a compute shader.
io::Result<Program> compileComputeProgram(std::initializer_list<std::string_view> parts);

}  // namespace tellurion::render
