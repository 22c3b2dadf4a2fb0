#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geo/body.h"
#include "geo/geodetic.h"
#include "io/failure.h"
#include "io/resources.h"
#include "raster/height_colours.h"
#include "raster/service.h"
#include "scene/atmosphere.h"
#include "scene/layer_look.h"
#include "scene/scene_clock.h"
#include "scene/sky.h"
#include "tiling/tiling.h"

namespace tellurion::pyramid {
class RemoteContents;
}

namespace tellurion::scene {

/// How a layer's source is read.
enum class SourceKind {
  file,       ///< a tile database, or a raster that is built into one first
  live,       ///< a raster, drawn without a build
  catalogue,  ///< a folder or a list of rasters, likewise
  service,    ///< images by row and column: a server, or a folder that is laid out like one
};

/// Heights: metres above the body's ellipsoid. Later layers lie over earlier ones where they have data.
struct ElevationLayer {
  std::string source;  ///< a path as it can be opened from the working directory, or a service's URL or template
  SourceKind from = SourceKind::file;
  raster::ServiceLayer service;  ///< of SourceKind::service: all that the scene says of it
  /// Metres over which the layer passes into those below it where it ends; 0: a step. Nothing: a twentieth of its size.
  std::optional<double> seam_m;
};

/// A picture of heights: hillshade, slope or a palette.
struct DerivedImagery {
  raster::HeightColours colours;
  std::optional<ElevationLayer> of;  ///< nothing: all elevation layers of the scene
};

/// A picture of a layer at a time and until the next.
struct TimedFile {
  double time_s = 0.0;  ///< seconds since 1970-01-01T00:00:00Z
  std::string source;   ///< as ImageryLayer has it
  SourceKind from = SourceKind::file;
};

/// ServiceLayer::time of an imagery layer that follows the clock.
inline constexpr std::string_view kClockTime = "clock";

/// Colours, or the lights of the night. Later layers lie over earlier ones.
struct ImageryLayer {
  std::string name;  ///< for people; empty: the source's
  std::string source;
  SourceKind from = SourceKind::file;
  raster::ServiceLayer service;
  /// Further data sets of the layer, of this machine: at each place the finest that has data counts, of equally fine
  /// ones the later.
  std::vector<std::string> alsoFrom;
  std::optional<DerivedImagery> derived;  ///< in place of all sources
  std::vector<TimedFile> times;           ///< likewise: in the order of time, the layer follows the clock
  LayerLook look;                         ///< at first (Globe::imageryLooks)
};

/// Where the light comes from. The default lights relief from one side whatever the view.
struct Lighting {
  enum class Sun {
    withCamera,  ///< behind the eye, to the left and above: fixed to the camera's axes
    fixed,       ///< stands in the zenith of `subsolar`, infinitely far away
    byClock,     ///< where it stands at the time of the scene's clock (geo/sun.h)
  };
  bool enabled = true;  ///< false: colours as they are, no shading
  Sun sun = Sun::withCamera;
  geo::Direction subsolar{{1.0, 0.0, 0.0}};
  double ambient = 0.03;  ///< 0..1, share of full light, linear, where the sun does not reach
};

/// What a scene file says (docs/scene-file.md). Plain data; nothing has been opened yet but the files' names are known
/// to exist; servers have not been asked.
struct Scene {
  std::string name;  ///< for titles and messages: what the scene was opened with
  geo::Body body = geo::earth();
  tiling::Scheme tiling = tiling::Scheme::cube;
  std::vector<ElevationLayer> elevation;  ///< bottom first
  std::vector<ImageryLayer> imagery;      ///< bottom first
  Lighting lighting;
  SceneClock clock;
  Air air;
  SkySettings sky;
  std::array<float, 3> background{0.0f, 0.0f, 0.0f};  ///< sRGB, 0..1
  /// Of tile databases on servers, what openScene() had to ask for: who opens the layers does not ask again.
  std::vector<std::shared_ptr<const pyramid::RemoteContents>> remoteContents;
};

/// Reads a scene from what people hand in: a scene file (.toml), a tile database (.tdb), a raster that GDAL reads, or
/// several of the last two joined by commas, bottom first; or of the URL of a service, "URL" or "URL#LAYER", which is
/// imagery on Earth. The URL of a tile database (pyramid/remote_database.h), or several, are asked what they are, as
/// `online` says, and waited for. Fails on unknown keys, wrong types and values (where:
/// file:line:column, the message says what is allowed), on files that are not there, and on databases that do not agree
/// on body and tiling. settings: values in place of what the scene file says, KEY=VALUE each (docs/scene-file.md); for
/// all else the layers count as the lists of a scene file.
io::Result<Scene> openScene(std::string_view argument, std::span<const std::string> settings = {},
                            const io::ResourceOptions& online = {});

/// The text of a scene file; `path` names it in failures and is what relative sources are relative to. base: what keys
/// that are left out mean.
io::Result<Scene> parseScene(std::string_view text, const std::string& path, std::span<const std::string> settings = {},
                             Scene base = {});

}  // namespace tellurion::scene
