#pragma once

#include <chrono>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/camera.h"

namespace tellurion::scene {

/// A camera that moves through keys. Immutable. Between keys:
///  - the place follows a spline of great circles (cubic, by de Casteljau on the sphere), smooth at the keys; two keys
///  alone
///    give the great circle at constant speed. No date line, no pole is special;
///  - the height is monotone cubic in asinh(h / 100 m), so that a descent from orbit takes its time near the ground;
///  - heading is carried along the way (parallel transport), so that crossing a pole does not spin it; it, pitch and
///  roll
///    turn the shorter way, monotone cubic.
class CameraPath {
 public:
  using Seconds = std::chrono::duration<double>;
  struct Key {
    double seconds = 0.0;
    Camera camera;
  };

  /// At least one key, times strictly increasing, values finite; else invalidArgument naming the key.
  static io::Result<CameraPath> create(std::vector<Key> keys);

  Seconds begin() const { return Seconds(keys_.front().seconds); }
  Seconds end() const { return Seconds(keys_.back().seconds); }
  Seconds duration() const { return end() - begin(); }
  /// Before the first key the first, after the last the last.
  Camera at(Seconds time) const;
  const std::vector<Key>& keys() const { return keys_; }

 private:
  explicit CameraPath(std::vector<Key> keys);

  struct Segment {
    geo::Direction control1;  ///< the spline's inner control points
    geo::Direction control2;
  };
  /// Values at a key that are interpolated as numbers, and their slopes a second.
  struct Channel {
    std::vector<double> values;
    std::vector<double> slopes;
  };
  void makePlaces();
  void makeChannels();
  double sample(const Channel& channel, std::size_t segment, double time) const;

  std::vector<Key> keys_;
  std::vector<geo::Direction> places_;
  std::vector<Segment> segments_;
  Channel height_;
  Channel heading_;  ///< relative to the heading of the first key, carried along
  Channel pitch_;
  Channel roll_;
};

/// CSV: `seconds,lat,lon,height_m,heading,pitch,roll`, degrees and metres, a key a line; that header line may stand
/// first; empty lines and lines that begin with # are skipped. Fails naming the line.
io::Result<CameraPath> parseCameraPath(std::string_view text, const std::string& name);
io::Result<CameraPath> readCameraPath(const std::string& path);
/// What parseCameraPath reads. Seconds to a tenth of a millisecond.
std::string formatCameraPath(std::span<const CameraPath::Key> keys);

}  // namespace tellurion::scene
