#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "geo/ellipsoid.h"
#include "raster/raster.h"
#include "scene/camera.h"
#include "scene/oriented_box.h"

// What a frame can show of how it was made, over its picture (docs/rendering.md).
namespace tellurion::scene {

enum class DebugView {
  wireframe,  ///< the sides of all triangles
  levels,     ///< tiles in the colour of their level, with their borders
  error,      ///< tiles in the heat of their screen error
  boxes,      ///< the boxes that the cut culls and measures by
};
inline constexpr std::array kDebugViews{DebugView::wireframe, DebugView::levels, DebugView::error, DebugView::boxes};

/// As --debug names it.
std::string_view nameOf(DebugView view);

/// A set of debug views; empty at first.
class DebugViews {
 public:
  bool has(DebugView view) const { return (bits_ & bit(view)) != 0; }
  bool any() const { return bits_ != 0; }
  void add(DebugView view) { bits_ |= bit(view); }
  void toggle(DebugView view) { bits_ ^= bit(view); }
  friend bool operator==(const DebugViews&, const DebugViews&) = default;

 private:
  static unsigned bit(DebugView view) { return 1u << static_cast<unsigned>(view); }
  unsigned bits_ = 0;
};

/// "wireframe,levels": names with commas between them. A failure says which name is none, and which there are.
io::Result<DebugViews> parseDebugViews(std::string_view text);

/// Levels that follow each other differ most in hue; 0 to 12 are all told apart. sRGB, opaque.
raster::Rgba8 levelColour(int level);

/// From blue at 0 over cyan to green at the tolerance; above it orange, red from twice the tolerance on. sRGB, opaque.
raster::Rgba8 errorColour(double error_px, double tolerance_px);

struct Segment {
  geo::BodyPosition from;
  geo::BodyPosition to;
};

/// A view's pyramid from outside: four sides from the eye to where the corners of its picture meet the ellipsoid, and
/// the four lines between those. A corner in the sky lies as far from the eye as the ellipsoid's horizon does, or as
/// its centre where the eye is inside.
std::array<Segment, 8> pyramidOf(const View& view, const geo::Ellipsoid& ellipsoid);

/// What the renderer draws over a frame's tiles.
struct DebugOverlay {
  DebugViews views;
  double tolerance_px = 1.0;               ///< of the cut, what errors are compared with
  std::vector<OrientedBox> boxes;          ///< of Frame::tiles, one for each, in the view `boxes`; else empty
  std::optional<View> frozenCut;           ///< the cut was made for this view, not for the one that is drawn
  std::array<Segment, 8> frozenPyramid{};  ///< of frozenCut
};

}  // namespace tellurion::scene
