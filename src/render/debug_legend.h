#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "raster/raster.h"
#include "scene/frame.h"

namespace tellurion::render {

/// A line of a legend. Letters that the font lacks are left out (debug_legend.cpp has those that legends use).
struct LegendRow {
  raster::Rgba8 colour;
  std::string label;
};

/// What the legend of a frame shows: equal contents need no new picture.
struct LegendContent {
  scene::DebugViews views;
  std::uint32_t levels = 0;  ///< bit n: a tile of level n is drawn
  double tolerance_px = 0.0;
  friend bool operator==(const LegendContent&, const LegendContent&) = default;
};
LegendContent legendContentOf(const scene::Frame& frame);

/// The colours of the levels that are drawn, and some of the heat of errors; empty in other views.
std::vector<LegendRow> legendRows(const LegendContent& content);

/// Colour patches with their labels on a dark ground. `pixel`: the side of one of the font's dots, >= 1. Empty without
/// rows.
raster::Raster<raster::Rgba8> legendPicture(std::span<const LegendRow> rows, int pixel);

}  // namespace tellurion::render
