#pragma once

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

/// A camera placed on a body. View axes: x right, y up, z backwards (the eye looks along -z).
struct View {
  geo::BodyPosition eye;
  geo::Mat3 viewFromBody;  ///< rotation only; positions are made relative to the eye first, in double
  geo::Angle verticalFov;
  Viewport viewport;

  double pixelAngle() const;  ///< radians that one pixel spans at the centre of the picture: 2 tan(fov / 2) / height
};
View viewOf(const Camera& camera, const geo::Ellipsoid& ellipsoid, geo::Angle verticalFov, Viewport viewport);
Camera cameraOf(const View& view, const geo::Ellipsoid& ellipsoid);

}  // namespace tellurion::scene
