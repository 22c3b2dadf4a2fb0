#pragma once

#include <memory>
#include <string>

#include "io/failure.h"

namespace tellurion::render {

/// An OpenGL 4.5 core context without a window or a display server, through EGL: Mesa's surfaceless platform, else the
/// first graphics device that works, else the default display. Move-only; it is current on the thread that made it from
/// create() until its end and must outlive everything made in it. One thread only, and one context a thread.
class HeadlessContext {
 public:
  /// A failure says what was tried and what to install.
  static io::Result<HeadlessContext> create();
  ~HeadlessContext();
  HeadlessContext(HeadlessContext&&) noexcept;
  HeadlessContext& operator=(HeadlessContext&&) noexcept;

 private:
  struct Egl;
  explicit HeadlessContext(std::unique_ptr<Egl> egl);
  std::unique_ptr<Egl> egl_;
};

/// Whether the current context, whoever made it, can run the renderer: OpenGL 4.5 core.
io::Result<void> checkCurrentContext();

/// The current context's driver and version, for messages and benchmarks.
std::string describeCurrentContext();

}  // namespace tellurion::render
