#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/view_input.h"
#include "io/failure.h"
#include "scene/viewer_memory.h"

namespace tellurion::app {

struct WindowOptions {
  scene::Viewport size;  ///< of the picture in the window; a full screen has its own
  double uiScale = 0.0;  ///< of letters and panels, 1: letters 13 units high; 0: as the screen asks for
  int screen = 0;        ///< filled by the window, 1 is the main one; 0: none is
};

/// A window with an OpenGL 4.5 core context, current on the thread that opened it until the window's end, and Dear
/// ImGui for panels in it. One at a time, main thread only, move-only.
class ViewWindow {
 public:
  /// Fails where there is no display, its driver has no OpenGL 4.5, or there is no such screen; the message says what
  /// to do instead. The window is made smaller where it would not fit the screen.
  static io::Result<ViewWindow> open(const std::string& title, const WindowOptions& options);
  ~ViewWindow();
  ViewWindow(ViewWindow&&) noexcept;
  ViewWindow& operator=(ViewWindow&&) noexcept;

  /// The window is hidden until then.
  void appear();

  void setTitle(const std::string& title);

  bool closing() const;
  void close();
  /// From any thread: wait() ends, and closing() is true.
  void closeSoon();
  /// From any thread: wait() ends.
  void wake();

  /// Width and height in the window system's units; nothing of one that fills its screen, or is minimised or maximised.
  std::optional<scene::ViewerMemory::Size> ordinarySize() const;
  /// Pixels of the picture, which on dense screens are more than the window system's units; 0 by 0 while minimised.
  scene::Viewport pictureSize() const;

  /// Sleeps until something happens or the time is over; without a time until something happens.
  void wait(std::optional<std::chrono::milliseconds> atMost);
  std::vector<InputEvent> takeEvents();

  /// While a panel with a field of text is open, keys are the panel's and no controls; they wait until the field is
  /// there. Keys that open such a panel (ViewKey::goTo, sources) begin it. Also without it a field that is clicked gets
  /// them.
  void expectText(bool expected);
  /// While keys lead the eye, W, A, S, D by their place on the keyboard, the arrows, Page Up and Down and Shift are
  /// told as MotionKeyChanged and nothing else; those that are down when it begins are told then.
  void expectMotion(bool expected);
  /// Something typed waits for the next beginPanels(). Each takes one: Dear ImGui hears of a key no more than one
  /// change a drawing, and keeps the rest for later ones, which a program that sleeps would not make.
  bool hasTyped() const;

  /// Between the two, ImGui calls draw panels, in the window system's units. endPanels() draws them over the picture in
  /// the window's framebuffer.
  void beginPanels();
  void endPanels();
  /// Shows what was drawn; waits for the screen, by its rate where the driver does not.
  void show();

  void copyToClipboard(const std::string& text);

 private:
  struct State;
  explicit ViewWindow(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tellurion::app
