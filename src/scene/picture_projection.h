#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "scene/camera.h"

/// How the directions around an eye become a picture (docs/projections.md). All of it is told in view axes: x right, y
/// up, z backwards.
namespace tellurion::scene {

enum class Projection { perspective, fisheye, equirectangular, cube, stereo };

/// In pixels of a picture; row 0 is the top.
struct PixelRect {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;
  friend bool operator==(const PixelRect&, const PixelRect&) = default;
};

/// What both have; of width or height 0 where that is nothing.
PixelRect overlapOf(const PixelRect& a, const PixelRect& b);

/// From the view axes of a camera to those of one that looks along a side of a cube around it: right, left, up, down,
/// back, front. Up has its lower edge at the front, down its upper one.
extern const std::array<geo::Mat3, 6> kCubeFaces;

/// What is asked for.
struct PictureShape {
  Projection projection = Projection::perspective;
  Viewport size;                                         ///< of the whole picture
  geo::Angle verticalFov = geo::Angle::degrees(45.0);    ///< of perspective and stereo
  geo::Angle aperture = geo::Angle::degrees(180.0);      ///< of the fisheye: across its circle, at most 360 degrees
  geo::Angle tilt;                                       ///< of the fisheye: how far its middle leans to the front
  std::optional<double> eyeSeparation_m = std::nullopt;  ///< of stereo; nothing: by the height (eyeSeparation_m())
};

/// What is wrong with the size for the projection, and which would do; empty: nothing.
std::string sizeProblem(const PictureShape& shape);

/// A rectangle of a picture that is a perspective picture of its own.
struct Pane {
  PixelRect place;
  View view;  ///< its viewport is the place's size
};

/// Directions bent into a picture: an angle from the middle (fisheye) or longitude and latitude (equirectangular).
struct Warp {
  Projection projection = Projection::fisheye;
  Viewport size;
  geo::Angle aperture;
};

/// Radians from a pixel to the next along the side that is the same all over the picture: outwards in a fisheye, from
/// the top to the bottom in an equirectangular picture.
double pixelAngle(const Warp& warp);

/// What one eye sees of a picture: panes side by side, or one warp.
struct EyePicture {
  View cut;                     ///< that the ground, and a sun that goes with the camera, are chosen for
  std::vector<Pane> panes;      ///< empty: a warp
  Warp warp;                    ///< its middle lies along -z of its axes
  geo::Mat3 warpFromView{1.0};  ///< from the axes of `cut`
};

/// The eyes that a camera's picture needs: two for stereo, else one. `camera`: eye and axes; its picture does not
/// count. height_m: of the eye above the ground, for eyeSeparation_m().
std::vector<EyePicture> eyesOf(const PictureShape& shape, const View& camera, double height_m);

/// Metres between two eyes that see ground at height_m as people see things at arm's length times two: a thirtieth of
/// it, and at least a person's own 0.065 m.
double eyeSeparation_m(double height_m);

/// The distance at which both eyes' pictures show a point at the same place, in separations of the eyes. What is
/// infinitely far is apart by one in this number of the tangent, 1.9 degrees.
inline constexpr double kEyesMeet = 30.0;

/// The view whose picture is a rectangle of another's.
View partOf(const View& whole, const PixelRect& rect);

}  // namespace tellurion::scene
