#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "geo/body.h"
#include "geo/local_frame.h"
#include "io/failure.h"

namespace tellurion::scene {

/// Where the eye is and where it looks. heading clockwise from north, pitch 0 at the horizon and -90 degrees straight
/// down, roll about the view axis, positive to the right.
struct Camera {
  geo::Geodetic position;
  geo::Angle heading;
  geo::Angle pitch;
  geo::Angle roll;
};

struct Viewport {
  int width = 1024;  ///< pixels
  int height = 768;
};

/// "LAT,LON,HEIGHT,HEADING,PITCH,ROLL", degrees and metres above the ellipsoid. Trailing values may be left out from
/// HEADING on (north, -90, 0).
io::Result<Camera> parseCamera(std::string_view text);
/// What parseCamera reads, with all six numbers; exact to a tenth of a millimetre on Earth.
std::string formatCamera(const Camera& camera);

/// Where the sides of a picture lie: tangents of the angles from the view axis, right and up positive. left < right,
/// bottom < top.
struct Sides {
  double left = -1.0;
  double right = 1.0;
  double bottom = -1.0;
  double top = 1.0;

  double width() const { return right - left; }
  double height() const { return top - bottom; }
  double middleX() const { return 0.5 * (left + right); }
  double middleY() const { return 0.5 * (bottom + top); }
  friend bool operator==(const Sides&, const Sides&) = default;
};

/// A camera placed on a body. View axes: x right, y up, z backwards (the eye looks along -z).
struct View {
  geo::BodyPosition eye;
  geo::Mat3 viewFromBody;  ///< rotation only; positions are made relative to the eye first, in double
  geo::Angle verticalFov;
  Viewport viewport;
  /// In place of the sides that verticalFov and the viewport give, which are symmetric and of square pixels.
  std::optional<Sides> offAxis{};
  /// Radians that count as a pixel for all that is told in pixels (pixelAngle()); else those of this picture. For
  /// pictures that are to agree with each other.
  std::optional<double> agreedPixelAngle{};
  /// The ground is chosen for an eye that sees in all directions at once, as one picture of all of them needs it. Of
  /// the picture's sides and viewport only the size of a pixel counts then. Drawn are parts of it: partOf().
  bool isAllAround = false;

  Sides sides() const;
  /// Radians that one pixel spans: where not agreed, at the centre of the picture, and of its two sides the smaller.
  /// Of a symmetric picture: 2 tan(fov / 2) / height.
  double pixelAngle() const;
};
View viewOf(const Camera& camera, const geo::Ellipsoid& ellipsoid, geo::Angle verticalFov, Viewport viewport);
Camera cameraOf(const View& view, const geo::Ellipsoid& ellipsoid);

}  // namespace tellurion::scene
