#include "truth/finest_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace tellurion::truth {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr int kBlockCells = 4;
/// How much steeper than along the sides and diagonals of its cells a bilinear ground may be: cells are skewed.
constexpr double kSkew = 2.0;
constexpr double kPrecision = 3e-6;  ///< of the distance: a thousandth of a pixel

/// The ellipsoid's normal through a point at most 20 km from the surface. Each step lessens what it is off by a factor
/// of a thousand or more; after one it may be a decimetre on the ground, after two it is less than a tenth of a
/// millimetre.
geo::Direction normalNear(const geo::Ellipsoid& e, const geo::BodyPosition& p) {
  const double a2 = e.semiMajorAxis_m() * e.semiMajorAxis_m();
  const double b2 = e.semiMinorAxis_m() * e.semiMinorAxis_m();
  const auto normalAt = [&](const geo::Vec3& q) {
    return geo::Direction{geo::normalize(geo::Vec3(q.x / a2, q.y / a2, q.z / b2))};
  };
  geo::Direction near = normalAt(p.m);
  for (int i = 0; i < 2; ++i) {
    const double height_m = geo::dot(p - e.bodyFromDirection(near), near.n);
    near = normalAt(p.m - near.n * height_m);
  }
  return near;
}

}  // namespace

FinestSurface::FinestSurface(const raster::TileSource& source)
    : tiling_(source.info().scheme), ellipsoid_(source.info().body.ellipsoid), cells_(source.info().tileCells) {
  for (int root = 0; root < tiling_.rootCount(); ++root)
    read(source, {.level = 0, .root = static_cast<std::uint8_t>(root)});
  // Coarse levels first: the finer ones look up there.
  std::stable_sort(tiles_.begin(), tiles_.end(), [](const Tile& a, const Tile& b) { return a.id.level < b.id.level; });
  for (std::size_t i = 0; i < tiles_.size(); ++i)
    tileOf_[tiles_[i].id] = static_cast<int>(i);
  for (Tile& tile : tiles_)
    agreeWithNeighbours(tile);
  nodes_.resize(static_cast<std::size_t>(tiling_.rootCount()));
  for (int root = 0; root < tiling_.rootCount(); ++root)
    fill(root, {.tile = tileOf_.at({.level = 0, .root = static_cast<std::uint8_t>(root)}), .cells = cells_});
}

void FinestSurface::read(const raster::TileSource& source, const tiling::TileId& id) {
  const auto loaded = source.load(id);
  if (!loaded || !*loaded) throw std::runtime_error("a tile cannot be read");
  const raster::SourceTile& found = **loaded;
  const auto& samples = std::get<raster::ElevationTile>(found.payload).samples;
  Tile tile{.id = id, .childMask = found.childMask, .heights_m = {cells_ + 1, cells_ + 1}};
  for (int row = 0; row <= cells_; ++row) {
    for (int col = 0; col <= cells_; ++col) {
      const float height = samples.at(col + raster::kGutter, row + raster::kGutter);
      if (raster::isNoData(height)) throw std::runtime_error("the database has gaps");
      tile.heights_m.at(col, row) = height;
    }
  }
  tiles_.push_back(std::move(tile));
  for (int q = 0; q < 4; ++q) {
    if (((found.childMask >> q) & 1) != 0) read(source, id.child(q));
  }
}

int FinestSurface::storedLevel(tiling::TileId id) const {
  while (!tileOf_.contains(id))
    id = id.parent();
  return id.level;
}

/// On edges and corners where not all tiles that touch are stored, a sample lies between those of the level above.
void FinestSurface::agreeWithNeighbours(Tile& tile) const {
  if (tile.id.level == 0) return;
  std::array<bool, 4> edge{};  // some tile there is not stored
  std::array<bool, 4> corner{};
  for (std::size_t k = 0; k < 4; ++k) {
    edge[k] = storedLevel(tiling_.edgeNeighbour(tile.id, tiling::kEdges[k]).tile) < tile.id.level;
    const auto across = tiling_.cornerNeighbour(tile.id, tiling::kCorners[k]);
    corner[k] = across && storedLevel(*across) < tile.id.level;
  }
  const Tile& parent = tiles_[static_cast<std::size_t>(tileOf_.at(tile.id.parent()))];
  const int firstCol = static_cast<int>(tile.id.x & 1u) * cells_;  // in half cells of the parent
  const int firstRow = static_cast<int>(tile.id.y & 1u) * cells_;
  const auto between = [&](int col, int row) {
    const auto at = [&](int c, int r) { return static_cast<double>(parent.heights_m.at(c / 2, r / 2)); };
    const int c = firstCol + col;
    const int r = firstRow + row;
    return static_cast<float>((at(c, r) + at(c + 1, r) + at(c, r + 1) + at(c + 1, r + 1)) / 4.0);
  };
  for (int row = 0; row <= cells_; ++row) {
    for (int col = 0; col <= cells_; ++col) {
      const bool top = row == 0;
      const bool right = col == cells_;
      const bool bottom = row == cells_;
      const bool left = col == 0;
      const bool missing = (top && edge[0]) || (right && edge[1]) || (bottom && edge[2]) || (left && edge[3]) ||
                           (top && left && corner[0]) || (top && right && corner[1]) ||
                           (bottom && right && corner[2]) || (bottom && left && corner[3]);
      if (missing) tile.heights_m.at(col, row) = between(col, row);
    }
  }
}

void FinestSurface::fill(int node, const Block& block) {
  const Tile& tile = tiles_[static_cast<std::size_t>(block.tile)];
  nodes_[static_cast<std::size_t>(node)].tile = block.tile;
  const bool isWhole = block.cells == cells_;
  if (block.cells <= kBlockCells && !(isWhole && tile.childMask != 0)) {
    bound(nodes_[static_cast<std::size_t>(node)], block);
    return;
  }
  const auto first = static_cast<int>(nodes_.size());
  nodes_.resize(nodes_.size() + 4);
  const int half = block.cells / 2;
  for (int q = 0; q < 4; ++q) {
    if (isWhole && ((tile.childMask >> q) & 1) != 0) {
      fill(first + q, {.tile = tileOf_.at(tile.id.child(q)), .cells = cells_});
    } else {
      fill(first + q,
           {.tile = block.tile, .col = block.col + (q & 1) * half, .row = block.row + (q >> 1) * half, .cells = half});
    }
  }
  Node& made = nodes_[static_cast<std::size_t>(node)];
  made.firstQuarter = first;
  made.low = nodes_[static_cast<std::size_t>(first)].low;
  made.high = nodes_[static_cast<std::size_t>(first)].high;
  for (int q = 1; q < 4; ++q) {
    made.low = glm::min(made.low, nodes_[static_cast<std::size_t>(first + q)].low);
    made.high = glm::max(made.high, nodes_[static_cast<std::size_t>(first + q)].high);
  }
}

void FinestSurface::bound(Node& node, const Block& block) const {
  const Tile& tile = tiles_[static_cast<std::size_t>(block.tile)];
  const double cell = tiling::tileSize(tile.id.level) / cells_;
  node.u = (tile.id.x * static_cast<double>(cells_) + block.col) * cell;
  node.v = (tile.id.y * static_cast<double>(cells_) + block.row) * cell;
  node.size = block.cells * cell;
  struct Sample {
    geo::Vec3 foot;
    geo::Vec3 ground;
    double height_m;
  };
  const auto sample = [&](double col, double row, double height_m) {
    const geo::Direction d = tiling_.direction(tiling::rootPointIn(tile.id, col / cells_, row / cells_));
    const geo::Vec3 foot = ellipsoid_.bodyFromDirection(d).m;
    return Sample{foot, foot + d.n * height_m, height_m};
  };
  const int side = block.cells + 1;
  std::vector<Sample> samples;
  for (int row = block.row; row <= block.row + block.cells; ++row) {
    for (int col = block.col; col <= block.col + block.cells; ++col)
      samples.push_back(sample(col, row, static_cast<double>(tile.heights_m.at(col, row))));
  }
  node.low = node.high = samples.front().ground;
  for (const Sample& s : samples) {
    node.low = glm::min(node.low, s.ground);
    node.high = glm::max(node.high, s.ground);
  }
  double bulge = 0.0;
  for (int row = 0; row < block.cells; ++row) {
    for (int col = 0; col < block.cells; ++col) {
      const auto corner = [&](int q) {
        return samples[static_cast<std::size_t>((row + (q >> 1)) * side + col + (q & 1))];
      };
      geo::Vec3 mean(0.0);
      double height_m = 0.0;
      for (int i = 0; i < 4; ++i) {
        mean += corner(i).ground * 0.25;
        height_m += corner(i).height_m * 0.25;
        for (int j = 0; j < i; ++j) {
          const double run = geo::length(corner(i).foot - corner(j).foot);
          // A side that is one place, at a pole, has no slope.
          if (run < 1e-6) continue;
          node.steepest = std::max(node.steepest, kSkew * std::abs(corner(i).height_m - corner(j).height_m) / run);
        }
      }
      const Sample middle = sample(block.col + col + 0.5, block.row + row + 0.5, height_m);
      bulge = std::max(bulge, geo::length(middle.ground - mean));
    }
  }
  const geo::Vec3 margin(2.0 * bulge + 1e-3);
  node.low -= margin;
  node.high += margin;
}

double FinestSurface::height_m(const geo::Direction& place) const {
  const tiling::RootPoint p = tiling_.rootPoint(place);
  return heightIn(blockAt(p), p);
}

const FinestSurface::Node& FinestSurface::blockAt(const tiling::RootPoint& p) const {
  const Node* node = &nodes_[static_cast<std::size_t>(p.root)];
  double u = p.u;
  double v = p.v;
  while (node->firstQuarter >= 0) {
    const int right = u < 0.5 ? 0 : 1;
    const int below = v < 0.5 ? 0 : 1;
    u = 2.0 * u - right;
    v = 2.0 * v - below;
    node = &nodes_[static_cast<std::size_t>(node->firstQuarter + right + 2 * below)];
  }
  return *node;
}

double FinestSurface::heightIn(const Node& block, const tiling::RootPoint& p) const {
  const Tile& tile = tiles_[static_cast<std::size_t>(block.tile)];
  const double size = tiling::tileSize(tile.id.level);
  const double x = std::clamp((p.u / size - tile.id.x) * cells_, 0.0, static_cast<double>(cells_));
  const double y = std::clamp((p.v / size - tile.id.y) * cells_, 0.0, static_cast<double>(cells_));
  const int col = std::min(static_cast<int>(x), cells_ - 1);
  const int row = std::min(static_cast<int>(y), cells_ - 1);
  const auto at = [&](int dc, int dr) { return static_cast<double>(tile.heights_m.at(col + dc, row + dr)); };
  return std::lerp(std::lerp(at(0, 0), at(1, 0), x - col), std::lerp(at(0, 1), at(1, 1), x - col), y - row);
}

/// `near`: the block that most likely holds the place below; what it is changes nothing but the time.
double FinestSurface::above(const geo::BodyPosition& p, const Node& near, geo::Direction& up) const {
  up = normalNear(ellipsoid_, p);
  const tiling::RootPoint place = tiling_.rootPoint(up);
  const double u = place.u - near.u;
  const double v = place.v - near.v;
  const bool isThere = place.root == tiles_[static_cast<std::size_t>(near.tile)].id.root && u >= 0.0 && u < near.size &&
                       v >= 0.0 && v < near.size;
  return geo::dot(p - ellipsoid_.bodyFromDirection(up), up.n) - heightIn(isThere ? near : blockAt(place), place);
}

/// One ray's way through the boxes, front to back.
struct FinestSurface::Search {
  const FinestSurface& surface;
  geo::Ray ray;
  double best = kNever;

  /// The part of the ray in a box; nothing gives an empty one.
  std::pair<double, double> within(const Node& node) const {
    double from = 0.0;
    double to = best;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (node.low[axis] - ray.origin.m[axis]) / ray.direction[axis];
      const double b = (node.high[axis] - ray.origin.m[axis]) / ray.direction[axis];
      from = std::max(from, std::min(a, b));  // of NaN, in a box's side, the other
      to = std::min(to, std::max(a, b));
    }
    return {from, to};
  }

  double above(double distance, const Node& near, geo::Direction& up) const {
    return surface.above({ray.origin.m + ray.direction * distance}, near, up);
  }
  double above(double distance, const Node& near) const {
    geo::Direction up;
    return above(distance, near, up);
  }

  /// The first crossing from above to below; `fall` bounds how fast the height above the ground changes.
  double crossing(const Node& block, double from, double aboveFrom, double to, double aboveTo, double fall) const {
    if (aboveFrom <= 0.0 || (aboveTo > 0.0 && aboveFrom + aboveTo >= fall * (to - from))) return kNever;
    const double middle = 0.5 * (from + to);
    if (to - from <= kPrecision * (1.0 + to)) return aboveTo <= 0.0 ? middle : kNever;
    const double aboveMiddle = above(middle, block);
    const double first = crossing(block, from, aboveFrom, middle, aboveMiddle, fall);
    return first < kNever ? first : crossing(block, middle, aboveMiddle, to, aboveTo, fall);
  }

  void visit(int index) {
    const Node& node = surface.nodes_[static_cast<std::size_t>(index)];
    const auto [from, to] = within(node);
    if (!(from <= to)) return;
    if (node.firstQuarter < 0) {
      geo::Direction up;
      const double aboveFrom = above(from, node, up);
      const double turn = 1.02 * (to - from) / surface.ellipsoid_.semiMinorAxis_m();
      const double fall = std::abs(geo::dot(ray.direction, up.n)) + turn + node.steepest;
      best = std::min(best, crossing(node, from, aboveFrom, to, above(to, node), fall));
      return;
    }
    std::array<std::pair<double, int>, 4> quarters;
    for (int q = 0; q < 4; ++q) {
      const int quarter = node.firstQuarter + q;
      quarters[static_cast<std::size_t>(q)] = {within(surface.nodes_[static_cast<std::size_t>(quarter)]).first,
                                               quarter};
    }
    std::sort(quarters.begin(), quarters.end());
    for (const auto& [enters, quarter] : quarters)
      visit(quarter);
  }
};

double FinestSurface::distanceAlong(const geo::Ray& ray) const {
  Search search{.surface = *this, .ray = ray};
  for (int root = 0; root < tiling_.rootCount(); ++root)
    search.visit(root);
  return search.best < kNever ? search.best : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace tellurion::truth
