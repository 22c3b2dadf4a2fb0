#include "raster/image_tree.h"

#include <algorithm>
#include <array>

namespace tellurion::raster {
namespace {

using geo::Angle;

/// A tile's gutter and the half of an outer sample, as a share of the tile's radius; small tiles have few cells.
constexpr double kGutterShare = 0.05;

bool areApart(const tiling::Cap& a, const tiling::Cap& b) {
  return geo::angleBetween(a.centre, b.centre) > a.radius + b.radius;
}

tiling::Cap withGutter(tiling::Cap cap) {
  cap.radius = cap.radius * (1.0 + kGutterShare);
  return cap;
}

}  // namespace

tiling::Cap capAround(const geo::GeoRect& rect) {
  constexpr int kSteps = 16;
  const geo::Direction centre = geo::directionFromLatLon((rect.south + rect.north) * 0.5, rect.west + rect.width * 0.5);
  Angle radius;
  // The farthest place of a rectangle is on its rim, and between two points of that no farther than half a step.
  for (int i = 0; i <= kSteps; ++i) {
    const Angle lon = rect.west + rect.width * (static_cast<double>(i) / kSteps);
    const Angle lat = rect.south + (rect.north - rect.south) * (static_cast<double>(i) / kSteps);
    for (const geo::Direction& rim :
         {geo::directionFromLatLon(rect.south, lon), geo::directionFromLatLon(rect.north, lon),
          geo::directionFromLatLon(lat, rect.west), geo::directionFromLatLon(lat, rect.east())}) {
      radius = std::max(radius, geo::angleBetween(centre, rim));
    }
  }
  const Angle halfStep = std::max(rect.width, rect.north - rect.south) * (0.5 / kSteps);
  return {centre, std::min(radius + halfStep, Angle::radians(geo::kPi))};
}

void ImageTree::insert(const PlacedImage& image) {
  const int number = static_cast<int>(images_.size());
  images_.push_back(image);
  int level = 0;
  while (level < tiling::kMaxLevel && tiling_.metrics(level + 1).meanEdge > image.cap.radius * 2.0)
    ++level;
  const tiling::TileId own = tiling_.tileAt(image.cap.centre, level);
  nodes_[own].images.push_back(number);
  for (int l = level; l >= 0; --l) {
    const tiling::TileId id = own.ancestor(l);
    Node& node = nodes_[id];
    node.reach = std::max(node.reach, geo::angleBetween(tiling_.cap(id).centre, image.cap.centre) + image.cap.radius);
    node.deepestLevel = std::max(node.deepestLevel, image.deepestLevel);
  }
}

/// Visits the images at nodes that may reach a tile; enter(node) says whether a node is worth it, visit(number) whether
/// to go on.
template <class Enter, class Visit>
void ImageTree::walk(const tiling::TileId& id, const Enter& enter, const Visit& visit) const {
  const tiling::Cap cap = withGutter(tiling_.cap(id));
  std::vector<tiling::TileId> open;
  for (int root = 0; root < tiling_.rootCount(); ++root)
    open.push_back({.root = static_cast<std::uint8_t>(root)});
  while (!open.empty()) {
    const tiling::TileId at = open.back();
    open.pop_back();
    const auto found = nodes_.find(at);
    if (found == nodes_.end() || !enter(found->second)) continue;
    if (areApart(cap, {tiling_.cap(at).centre, found->second.reach})) continue;
    for (const int number : found->second.images) {
      if (!areApart(cap, image(number).cap) && !visit(number)) return;
    }
    if (at.level >= tiling::kMaxLevel) continue;
    for (int quadrant = 0; quadrant < 4; ++quadrant)
      open.push_back(at.child(quadrant));
  }
}

std::vector<int> ImageTree::touching(const tiling::TileId& id, Angle leastSize) const {
  std::vector<int> numbers;
  walk(
      id, [](const Node&) { return true; },
      [&](int number) {
        if (image(number).cap.radius * 2.0 >= leastSize) numbers.push_back(number);
        return true;
      });
  return numbers;
}

bool ImageTree::isTouched(const tiling::TileId& id, int level) const {
  bool is = false;
  const geo::GeoRect bounds = tiling_.bounds(id);
  walk(
      id, [&](const Node& node) { return node.deepestLevel >= level; },
      [&](int number) {
        is = image(number).deepestLevel >= level && image(number).bounds.intersects(bounds);
        return !is;
      });
  return is;
}

}  // namespace tellurion::raster
