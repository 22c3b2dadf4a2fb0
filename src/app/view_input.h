#pragma once

#include <variant>
#include <vector>

#include "scene/picking.h"

// What a person's hand does, as plain data, free of the window system. Positions are pixels of the picture.
namespace tellurion::app {

enum class MouseButton { left, middle, right };

enum class ViewKey {
  plus,
  minus,
  left,
  right,
  up,
  down,
  north,
  reset,
  light,
  printCamera,
  help,
  screenshot,
  quit,
  escape,
  wireframe,
  levels,
  error,
  boxes,
  freeze,
  statistics,
  higher,
  lower,
  finer,
  coarser,
  automatic,
  layers,
  play,
  earlier,
  later,
  air,
  goTo,
  bookmarks,
  addKeyFrame,
  keyFrames,
  record,
  inertia,
  settings,
  walk,
  fly,
  sources,
};

/// Keys that count while they are down, in the modes that walk and fly.
enum class MotionKey { ahead, back, left, right, up, down, faster };
inline constexpr int kMotionKeys = 7;

struct Modifiers {
  bool shift = false;
  bool control = false;
};

struct ButtonChanged {
  MouseButton button = MouseButton::left;
  bool down = false;
  Modifiers modifiers;
  scene::PixelPosition at;
  double seconds = 0.0;  ///< when, on any steady clock
};

struct CursorMoved {
  scene::PixelPosition at;
  double seconds = 0.0;  ///< when, on the clock of ButtonChanged
};

struct CursorLeft {};

struct WheelTurned {
  double steps = 0.0;  ///< positive away from the hand: zoom in
  scene::PixelPosition at;
};

struct KeyPressed {
  ViewKey key = ViewKey::help;
  Modifiers modifiers;
};

struct MotionKeyChanged {
  MotionKey key = MotionKey::ahead;
  bool down = false;
};

/// The window was resized, uncovered or brought back.
struct PictureLost {};

/// A panel has got a button or the wheel.
struct PanelTouched {};

using InputEvent = std::variant<ButtonChanged, CursorMoved, CursorLeft, WheelTurned, KeyPressed, MotionKeyChanged,
                                PictureLost, PanelTouched>;

}  // namespace tellurion::app
