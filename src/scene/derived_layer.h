#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "raster/derived_tiles.h"
#include "scene/globe_layers.h"

namespace tellurion::scene {

/// A source that several layers are made of: opened once, by whichever needs it first. Thread-safe.
class SharedSource {
 public:
  /// Who opens those that pictures are made of.
  enum class OpenedBy : std::uint8_t {
    thisLayer,       ///< nobody else
    layersOfItsOwn,  ///< each is a layer, too: pictures need not keep a thread to wait for them
  };
  SharedSource(LayerSource source, std::optional<double> seam_m);

  /// May wait for a network. Fails as the source does; what failed for good is not tried again.
  io::Result<LayerSource::Pointer> get();
  /// Never waits.
  bool isOpen() const { return state_ == State::open; }
  bool isSettled() const { return state_ != State::closed; }  ///< open, or failed for good
  const std::optional<double>& seam_m() const { return seam_m_; }
  const std::string& name() const { return source_.name; }

 private:
  enum class State : std::uint8_t { closed, open, refused };

  std::mutex mutex_;
  LayerSource source_;
  std::optional<io::Failure> refusal_;
  std::optional<double> seam_m_;  ///< of elevation: LayerSource's
  std::atomic<State> state_;
};
using SharedSources = std::vector<std::shared_ptr<SharedSource>>;

LayerSource layerOf(const std::shared_ptr<SharedSource>& source);

/// Pictures of heights, one source or more. Those of several servers begin with the heights that are here, whichever
/// they are, as the heights themselves do; once all have answered, pictures of all take their place: the second data
/// set. Fails when all are open and cannot be shown together.
io::Result<std::vector<LayerSource>> derivedLayer(const SharedSources& heights, const raster::HeightColours& colours,
                                                  SharedSource::OpenedBy openedBy);

}  // namespace tellurion::scene
