#include "render/heavens_pass.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "render/gl_objects.h"
#include "render/moon_disc.h"
#include "render/shader.h"
#include "render/shader_texts.h"

namespace tellurion::render {
namespace {

// A star of this magnitude is drawn at full light over the least spread; brighter ones are spread over more pixels, so
// that what a star adds to the picture follows its magnitude throughout.
constexpr double kFullMagnitude = 1.2;
constexpr double kLeastSpread_px = 0.7;
constexpr double kMostSpread_px = 12.0;
constexpr double kStarReach = 4.3;  // spreads to the corner of a star's square (star.vert.glsl)
constexpr double kDeepestGround_m = 20e3;
constexpr double kNoDisc = 2.0;  // a cosine that nothing has

/// As star.vert.glsl reads it.
struct StarVertex {
  geo::Vec3f direction_celestial;
  float spread_px = 0.0f;
  geo::Vec3f light;
};
static_assert(sizeof(StarVertex) == 28);

struct StarPrograms {
  Program program;
  GLint bodyFromCelestial = -1;
  GLint pixel = -1;
  GLint moon = -1;
};
struct DiscPrograms {
  Program program;
  GLint discs = -1;
  GLint pixel = -1;
  GLint first = -1;
  GLint toSun = -1;
};

StarVertex vertexOf(const scene::Star& star, double brightness_stops) {
  const double power =
      std::pow(10.0, -0.4 * (static_cast<double>(star.magnitude) - kFullMagnitude)) * std::exp2(brightness_stops);
  const double spread = std::min(std::sqrt(std::max(power, 1.0)), kMostSpread_px / kLeastSpread_px);
  return {.direction_celestial = star.direction_celestial,
          .spread_px = static_cast<float>(kLeastSpread_px * spread),
          .light = star.colour * static_cast<float>(std::min(power, 1.0))};
}

}  // namespace

struct HeavensPass::Parts {
  // Without air, and behind it.
  std::array<StarPrograms, 2> starPrograms;
  std::array<DiscPrograms, 2> discPrograms;
  VertexArray squares;  // of stars
  VertexArray nothing;  // discs have no vertices
  Buffer stars;
  std::vector<StarVertex> all;
  std::vector<StarVertex> seen;  // kept from frame to frame only for its memory
  std::uint64_t catalogue = 0;   // what `stars` are of
  double brightness_stops = 0.0;

  io::Result<void> compile();
  void bring(const scene::Sky& sky);
  void bringSeen(const scene::Frame& frame, double pixel);
};

io::Result<void> HeavensPass::Parts::compile() {
  const std::string alone = std::string(shaders::constants) + std::string(shaders::no_air);
  const std::string behind = std::string(shaders::constants) + std::string(shaders::air_structs) +
                             std::string(shaders::air_block) + std::string(shaders::air_model) +
                             std::string(shaders::air_ray) + std::string(shaders::air) +
                             std::string(shaders::behind_air);
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string& common = i == 0 ? alone : behind;
    auto star = compileProgram({common, shaders::frame_block, shaders::star_vert}, {shaders::star_frag});
    if (!star) return tl::unexpected(star.error());
    auto disc = compileProgram({common, shaders::frame_block, shaders::disc_vert},
                               {common, shaders::frame_block, shaders::disc_frag});
    if (!disc) return tl::unexpected(disc.error());
    starPrograms[i] = {.program = std::move(*star)};
    discPrograms[i] = {.program = std::move(*disc)};
    const auto place = [](const Program& program, const char* name) {
      return glGetUniformLocation(program.name(), name);
    };
    StarPrograms& s = starPrograms[i];
    s.bodyFromCelestial = place(s.program, "bodyFromCelestial");
    s.pixel = place(s.program, "pixel");
    s.moon = place(s.program, "moon");
    DiscPrograms& d = discPrograms[i];
    d.discs = place(d.program, "discs");
    d.pixel = place(d.program, "pixel");
    d.first = place(d.program, "first");
    d.toSun = place(d.program, "sunOfMoon_body");
  }
  return {};
}

void HeavensPass::Parts::bring(const scene::Sky& sky) {
  if (catalogue == sky.stars->serial && brightness_stops == sky.brightness_stops) return;
  catalogue = sky.stars->serial;
  brightness_stops = sky.brightness_stops;
  all.clear();
  for (const scene::Star& star : sky.stars->stars)
    all.push_back(vertexOf(star, brightness_stops));
  seen.reserve(all.size());
}

/// Of most views most stars lie beside the picture or behind the ground, and telling that here is far cheaper than
/// there.
void HeavensPass::Parts::bringSeen(const scene::Frame& frame, double pixel) {
  const scene::Sides sides = frame.view.sides();
  const double x = std::max(std::abs(sides.left), std::abs(sides.right));
  const double y = std::max(std::abs(sides.bottom), std::abs(sides.top));
  // Squares reach three spreads to either side, and corners further.
  const double room = kStarReach * kMostSpread_px * pixel;
  const double around = std::cos(std::min(std::atan(std::hypot(x, y)) + room, geo::kPi));
  const double r = geo::length(frame.view.eye.m);
  const double solid = frame.ellipsoid.semiMinorAxis_m() - kDeepestGround_m * std::max(frame.exaggeration, 1.0);
  const double hidden = !frame.tiles.empty() && solid > 0.0 && r > solid ? std::asin(solid / r) - room : 0.0;
  const double behind = hidden > 0.0 ? std::cos(hidden) : kNoDisc;
  const geo::Mat3 celestialFromBody = glm::transpose(frame.sky.bodyFromCelestial);
  const geo::Vec3f axis(celestialFromBody * glm::transpose(frame.view.viewFromBody) * geo::Vec3(0.0, 0.0, -1.0));
  const geo::Vec3f down(celestialFromBody * (frame.view.eye.m / -r));
  seen.clear();
  for (const StarVertex& star : all) {
    if (static_cast<double>(geo::dot(star.direction_celestial, axis)) > around &&
        static_cast<double>(geo::dot(star.direction_celestial, down)) < behind)
      seen.push_back(star);
  }
  glNamedBufferData(stars.name(), static_cast<GLsizeiptr>(seen.size() * sizeof(StarVertex)), seen.data(),
                    GL_STREAM_DRAW);
}

HeavensPass::HeavensPass(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
HeavensPass::~HeavensPass() = default;
HeavensPass::HeavensPass(HeavensPass&&) noexcept = default;
HeavensPass& HeavensPass::operator=(HeavensPass&&) noexcept = default;

io::Result<HeavensPass> HeavensPass::create() {
  auto parts = std::make_unique<Parts>();
  if (const auto ready = parts->compile(); !ready) return tl::unexpected(ready.error());
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  parts->nothing = VertexArray(name);
  glCreateBuffers(1, &name);
  parts->stars = Buffer(name);
  glCreateVertexArrays(1, &name);
  parts->squares = VertexArray(name);
  glVertexArrayVertexBuffer(name, 0, parts->stars.name(), 0, sizeof(StarVertex));
  glVertexArrayBindingDivisor(name, 0, 1);
  const std::array<std::pair<GLint, GLuint>, 2> attributes{{{4, 0}, {3, offsetof(StarVertex, light)}}};
  for (GLuint i = 0; i < attributes.size(); ++i) {
    glEnableVertexArrayAttrib(name, i);
    glVertexArrayAttribFormat(name, i, attributes[i].first, GL_FLOAT, GL_FALSE, attributes[i].second);
    glVertexArrayAttribBinding(name, i, 0);
  }
  return HeavensPass(std::move(parts));
}

int HeavensPass::draw(const scene::Frame& frame, bool inAir) {
  const scene::Sky& sky = frame.sky;
  if (sky.isEmpty()) return 0;
  Parts& p = *parts_;
  // Of this picture, whatever others have agreed on: of finer ones there would be nothing to see.
  const auto pixel = static_cast<float>(frame.view.sides().height() / frame.view.viewport.height);
  const auto four = [](const geo::Vec3& v, double w) { return geo::Vec4f(geo::Vec3f(v), static_cast<float>(w)); };
  // The sun, then the Moon, of which one far behind another body is as good as none.
  std::array<geo::Vec4f, 2> discs{four(frame.light.toSun_body, sky.sunRadius_radians), {}};
  geo::Vec4f moon = four({0.0, 0.0, 1.0}, kNoDisc);
  int last = 1;
  if (const auto disc = moonDiscOf(frame)) {
    discs[1] = four(disc->towards_body, disc->radius_rad);
    moon = four(disc->towards_body, std::cos(disc->radius_rad));
    last = 2;
  }
  const int first = inAir || sky.sunRadius_radians <= 0.0 ? 1 : 0;
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_ONE, GL_ONE, GL_ZERO, GL_ONE);
  glBlendEquation(GL_FUNC_ADD);
  glDepthMask(GL_FALSE);
  int drawCalls = 0;
  if (sky.stars) {
    p.bring(sky);
    p.bringSeen(frame, static_cast<double>(pixel));
    const StarPrograms& s = p.starPrograms[inAir ? 1 : 0];
    const geo::Mat3f turn(sky.bodyFromCelestial);
    glUseProgram(s.program.name());
    glProgramUniformMatrix3fv(s.program.name(), s.bodyFromCelestial, 1, GL_FALSE, &turn[0][0]);
    glProgramUniform1f(s.program.name(), s.pixel, pixel);
    glProgramUniform4fv(s.program.name(), s.moon, 1, &moon[0]);
    glBindVertexArray(p.squares.name());
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(p.seen.size()));
    ++drawCalls;
  }
  if (first < last) {
    const DiscPrograms& d = p.discPrograms[inAir ? 1 : 0];
    glUseProgram(d.program.name());
    glProgramUniform4fv(d.program.name(), d.discs, 2, &discs[0][0]);
    glProgramUniform1f(d.program.name(), d.pixel, pixel);
    glProgramUniform1i(d.program.name(), d.first, first);
    const geo::Vec3f toSun(sky.toSun.value_or(frame.light.toSun_body));
    glProgramUniform3fv(d.program.name(), d.toSun, 1, &toSun[0]);
    glBindVertexArray(p.nothing.name());
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, last - first);
    ++drawCalls;
  }
  glBindVertexArray(0);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  return drawCalls;
}

}  // namespace tellurion::render
