#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/resources.h"
#include "raster/tile_source.h"
#include "scene/layer_look.h"

namespace tellurion::scene {

/// A layer's source, open or still to be opened.
struct LayerSource {
  using Pointer = std::shared_ptr<const raster::TileSource>;
  using Opening = std::function<io::Result<Pointer>()>;

  LayerSource() = default;
  template <class Source>
  LayerSource(std::shared_ptr<Source> source) : open(std::move(source)) {}  // NOLINT: as the pointer is one
  /// opening: may wait for a network; called on a thread of the globe's own, again and again while it fails with
  /// Failure::Code::ioError. name: for messages until it is open.
  LayerSource(Opening how, std::string called) : opening(std::move(how)), name(std::move(called)) {}

  Pointer open;                  ///< null: has to be opened first
  std::optional<double> seam_m;  ///< of elevation: GroundLayers::Layer
  Opening opening;               ///< of those
  /// Of one that is made of other layers' sources: the names of those that opening() would wait for now; it is not
  /// called while there are any. Must be quick; any thread. Null: it waits for no other layer.
  std::function<std::vector<std::string>()> waitsFor;
  /// Of a data set of imagery: where it takes part, the layer's others are not drawn.
  bool replacesOthers = false;
  std::string name;
};

/// A layer's source at a time and until the next.
struct TimedSource {
  double time_s = 0.0;  ///< seconds since 1970-01-01T00:00:00Z
  LayerSource source;
};

/// The sources of a scene: what Globe draws from. Elevation and imagery, bottom first, all of the scene's tiling and
/// body.
struct GlobeLayers {
  struct Imagery {
    LayerSource source;
    std::vector<LayerSource> alsoFrom;  ///< as ImageryLayer has it
    std::vector<TimedSource> steps;     ///< of a layer that follows the clock, in the order of time, in place of source
    /// Of one whose steps are known once its server has answered, in place of steps: as LayerSource::opening.
    std::function<io::Result<std::vector<TimedSource>>()> openSteps;
    LayerLook look;
    std::string name;  ///< empty: the last part of the source's
  };
  std::vector<LayerSource> elevation;
  std::vector<Imagery> imagery;
  std::shared_ptr<io::Resources> resources;  ///< what network sources fetch with; may be null
};

}  // namespace tellurion::scene
