#include "scene/derived_layer.h"

#include <algorithm>
#include <utility>

namespace tellurion::scene {
namespace {

using Code = io::Failure::Code;

raster::DerivedHeights heightsOf(const SharedSource& source, LayerSource::Pointer open) {
  return {.source = std::move(open), .seam_m = source.seam_m()};
}

/// Of all that can be opened; while one may come yet, it is waited for.
io::Result<LayerSource::Pointer> derivedOf(const SharedSources& heights, const raster::HeightColours& colours) {
  std::vector<raster::DerivedHeights> open;
  std::optional<io::Failure> failure;
  for (const auto& source : heights) {
    auto opened = source->get();
    if (opened) {
      open.push_back(heightsOf(*source, std::move(*opened)));
      continue;
    }
    if (opened.error().code == Code::ioError) return opened;
    failure = std::move(opened.error());
  }
  if (open.empty() && failure) return tl::unexpected(std::move(*failure));
  return raster::derivedTileSource(open, colours);
}

/// Of those that are open, whichever they are; of all when none is.
io::Result<LayerSource::Pointer> derivedOfOpen(const SharedSources& heights, const raster::HeightColours& colours) {
  std::vector<raster::DerivedHeights> open;
  for (const auto& source : heights) {
    if (source->isOpen()) open.push_back(heightsOf(*source, *source->get()));
  }
  if (open.empty()) return derivedOf(heights, colours);
  return raster::derivedTileSource(open, colours);
}

std::vector<std::string> unsettled(const SharedSources& heights) {
  std::vector<std::string> names;
  for (const auto& source : heights) {
    if (!source->isSettled()) names.push_back(source->name());
  }
  return names;
}

}  // namespace

SharedSource::SharedSource(LayerSource source, std::optional<double> seam_m)
    : source_(std::move(source)), seam_m_(seam_m), state_(source_.open ? State::open : State::closed) {}

io::Result<LayerSource::Pointer> SharedSource::get() {
  const std::lock_guard lock(mutex_);
  if (source_.open) return source_.open;
  if (refusal_) return tl::unexpected(*refusal_);
  auto opened = source_.opening();
  if (opened) {
    source_.open = std::move(*opened);
    state_ = State::open;
    return source_.open;
  }
  if (opened.error().code != Code::ioError) {
    refusal_ = opened.error();
    state_ = State::refused;
  }
  return opened;
}

LayerSource layerOf(const std::shared_ptr<SharedSource>& source) {
  if (source->isOpen()) return {*source->get()};
  return {[source] { return source->get(); }, source->name()};
}

io::Result<std::vector<LayerSource>> derivedLayer(const SharedSources& heights, const raster::HeightColours& colours,
                                                  SharedSource::OpenedBy openedBy) {
  const bool isHere = std::ranges::all_of(heights, [](const auto& source) { return source->isOpen(); });
  if (isHere) {
    auto derived = derivedOf(heights, colours);
    if (!derived) return tl::unexpected(std::move(derived.error()));
    return std::vector{LayerSource(std::move(*derived))};
  }
  const auto absent = std::ranges::find_if(heights, [](const auto& source) { return !source->isOpen(); });
  const std::string name = (*absent)->name();
  LayerSource whole([heights, colours] { return derivedOf(heights, colours); }, name);
  if (openedBy == SharedSource::OpenedBy::layersOfItsOwn) whole.waitsFor = [heights] { return unsettled(heights); };
  if (heights.size() == 1) return std::vector{std::move(whole)};
  LayerSource first([heights, colours] { return derivedOfOpen(heights, colours); }, name);
  if (openedBy == SharedSource::OpenedBy::layersOfItsOwn) {
    first.waitsFor = [heights] {
      const bool isAnyOpen = std::ranges::any_of(heights, [](const auto& source) { return source->isOpen(); });
      return isAnyOpen ? std::vector<std::string>{} : unsettled(heights);
    };
  }
  whole.replacesOthers = true;
  return std::vector{std::move(first), std::move(whole)};
}

}  // namespace tellurion::scene
