#include "render/context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>

#include <array>
#include <vector>

namespace tellurion::render {
namespace {

constexpr int kVersionNeeded = 45;
constexpr std::string_view kAdvice =
    "install a driver with OpenGL 4.5; on Debian 'apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri' brings one "
    "that needs no graphics card";

using MakeDisplay = EGLDisplay (*)();

EGLDisplay surfacelessDisplay() {
  if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) return EGL_NO_DISPLAY;
  return eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
}

EGLDisplay deviceDisplay() {
  if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration") ||
      !epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device"))
    return EGL_NO_DISPLAY;
  EGLDeviceEXT device = nullptr;
  EGLint count = 0;
  if (eglQueryDevicesEXT(1, &device, &count) != EGL_TRUE || count < 1) return EGL_NO_DISPLAY;
  return eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr);
}

EGLDisplay defaultDisplay() {
  return eglGetDisplay(EGL_DEFAULT_DISPLAY);
}

struct Platform {
  std::string_view name;
  MakeDisplay makeDisplay;
};
constexpr std::array kPlatforms{Platform{"surfaceless", surfacelessDisplay}, Platform{"device", deviceDisplay},
                                Platform{"default display", defaultDisplay}};

}  // namespace

struct HeadlessContext::Egl {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;

  Egl() = default;
  Egl(const Egl&) = delete;
  Egl& operator=(const Egl&) = delete;
  ~Egl() {
    if (context != EGL_NO_CONTEXT) {
      // Another one may be current by now: then that one stays.
      if (eglGetCurrentContext() == context) eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
      eglDestroyContext(display, context);
    }
    // The display is left as it is: EGL shares it between all users in the process.
  }

  /// Empty when all went well, else what did not.
  std::string open(MakeDisplay makeDisplay);
};

std::string HeadlessContext::Egl::open(MakeDisplay makeDisplay) {
  display = makeDisplay();
  if (display == EGL_NO_DISPLAY) return "not offered";
  EGLint major = 0;
  EGLint minor = 0;
  if (eglInitialize(display, &major, &minor) != EGL_TRUE) return "does not start";
  if (!epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context")) return "draws only into windows";
  if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) return "has OpenGL ES only";
  const std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (eglChooseConfig(display, wanted.data(), &config, 1, &count) != EGL_TRUE || count < 1) config = nullptr;
  const std::array<EGLint, 7> version{EGL_CONTEXT_MAJOR_VERSION,
                                      kVersionNeeded / 10,
                                      EGL_CONTEXT_MINOR_VERSION,
                                      kVersionNeeded % 10,
                                      EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                      EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                      EGL_NONE};
  context = eglCreateContext(display, config, EGL_NO_CONTEXT, version.data());
  if (context == EGL_NO_CONTEXT) return "has no OpenGL 4.5";
  if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) != EGL_TRUE) return "does not become current";
  return {};
}

HeadlessContext::HeadlessContext(std::unique_ptr<Egl> egl) : egl_(std::move(egl)) {}
HeadlessContext::~HeadlessContext() = default;
HeadlessContext::HeadlessContext(HeadlessContext&&) noexcept = default;
HeadlessContext& HeadlessContext::operator=(HeadlessContext&&) noexcept = default;

io::Result<HeadlessContext> HeadlessContext::create() {
  std::string complaints;
  for (const Platform& platform : kPlatforms) {
    auto egl = std::make_unique<Egl>();
    const std::string complaint = egl->open(platform.makeDisplay);
    if (complaint.empty()) {
      HeadlessContext context(std::move(egl));
      if (auto usable = checkCurrentContext(); !usable) return tl::unexpected(usable.error());
      return context;
    }
    complaints += fmt::format("{}{} {}", complaints.empty() ? "" : ", ", platform.name, complaint);
  }
  return io::fail(io::Failure::Code::unsupported,
                  fmt::format("no OpenGL without a window here ({}); {}", complaints, kAdvice), "EGL");
}

io::Result<void> checkCurrentContext() {
  const int version = epoxy_gl_version();
  if (epoxy_is_desktop_gl() && version >= kVersionNeeded) return {};
  return io::fail(
      io::Failure::Code::unsupported,
      fmt::format("the graphics driver has OpenGL {}.{}, and 4.5 is needed; {}", version / 10, version % 10, kAdvice),
      describeCurrentContext());
}

std::string describeCurrentContext() {
  const auto text = [](GLenum what) {
    const GLubyte* s = glGetString(what);
    return s != nullptr ? std::string(reinterpret_cast<const char*>(s)) : std::string("unknown");
  };
  return fmt::format("{}, OpenGL {}", text(GL_RENDERER), text(GL_VERSION));
}

}  // namespace tellurion::render
