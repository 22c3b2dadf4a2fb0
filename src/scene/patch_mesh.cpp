#include "scene/patch_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "scene/terrain_mesh.h"

namespace tellurion::scene {
namespace {

constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kMostVertices = std::numeric_limits<std::uint16_t>::max();
constexpr int kHalf = kPlaceUnits / 2;

/// Of a vertex in the square of what is drawn, 0..1. Exact, however much finer the tile was that has it.
struct Place {
  double s = 0.0;
  double t = 0.0;
};

Place placeIn(const MeshPart& part, const TerrainVertex& v) {
  if (part.quadrant == MeshPart::kWhole) return {double(v.s) / kPlaceUnits, double(v.t) / kPlaceUnits};
  return {double(v.s) / kHalf - (part.quadrant & 1), double(v.t) / kHalf - (part.quadrant >> 1)};
}

bool isWithin(const Place& p) {
  return p.s >= 0.0 && p.s <= 1.0 && p.t >= 0.0 && p.t <= 1.0;
}

bool isOnEdge(const Place& p, int edge) {
  const double across = edge == 0 || edge == 2 ? p.t : p.s;
  return across == (edge == 1 || edge == 2 ? 1.0 : 0.0);
}

double alongEdge(const Place& p, int edge) {
  return edge == 0 || edge == 2 ? p.s : p.t;
}

Place placeOnEdge(int edge, double along) {
  const double across = edge == 1 || edge == 2 ? 1.0 : 0.0;
  return edge == 0 || edge == 2 ? Place{along, across} : Place{across, along};
}

/// What is drawn on a finer tile's edge: called with each vertex, some twice, and where it lies along that.
template <class Visit>
void visitEdge(const MeshPart& finer, int edge, const Visit& visit) {
  const auto look = [&](const TerrainVertex& v) {
    const Place p = placeIn(finer, v);
    if (isWithin(p) && isOnEdge(p, edge)) visit(v, alongEdge(p, edge));
  };
  const TerrainMesh& mesh = *finer.mesh;
  if (finer.quadrant != MeshPart::kWhole) {
    std::ranges::for_each(mesh.vertices, look);
    return;
  }
  const IndexRange& range = mesh.coarseEdge[static_cast<std::size_t>(edge)];
  for (std::uint32_t i = range.first; i < range.first + range.count; ++i)
    look(mesh.vertices[mesh.indices[i]]);
}

class Patch {
 public:
  Patch(const MeshPart& base, std::uint8_t coarseEdges, std::span<const FinerEdge> finer, double vertexGrid_m)
      : base_(base), vertexGrid_m_(vertexGrid_m), indexOf_(base.mesh->vertices.size(), kNoVertex) {
    const TerrainMesh& from = *base.mesh;
    out_->serial = nextSerial();
    out_->origin = from.origin;
    out_->parentStep_m = from.parentStep_m;
    out_->middleUp_body = from.middleUp_body;
    out_->upReach = from.upReach;
    const bool isWhole = base.quadrant == MeshPart::kWhole;
    for (const TerrainVertex& v : from.vertices)
      places_.push_back(placeIn(base, v));
    collectFiner(finer);
    addAll(from.interior);
    for (std::size_t e = 0; e < 4; ++e)
      addAll(isWhole && ((coarseEdges >> e) & 1) != 0 ? from.coarseEdge[e] : from.fineEdge[e]);
    out_->interior.count = static_cast<std::uint32_t>(out_->indices.size());
  }

  std::shared_ptr<const TerrainMesh> take() { return std::move(out_); }

 private:
  struct Inserted {
    double along = 0.0;
    TerrainVertex vertex;
    std::uint32_t index = kNoVertex;  ///< of out_
  };
  struct Corner {
    Place place;
    std::uint32_t index = 0;  ///< of out_
  };
  using Triangle = std::array<Corner, 3>;

  void collectFiner(std::span<const FinerEdge> finer) {
    for (const FinerEdge& each : finer) {
      visitEdge(each.finer, each.finerEdge, [&](const TerrainVertex& v, double along) {
        const double here = each.from + along * (each.to - each.from);
        inserted_[each.edge].push_back({.along = here, .vertex = moved(v, *each.finer.mesh, each.edge, here)});
      });
    }
    for (auto& ofEdge : inserted_) {
      std::ranges::stable_sort(ofEdge, {}, &Inserted::along);
      const auto again = std::ranges::unique(ofEdge, {}, &Inserted::along);
      ofEdge.erase(again.begin(), again.end());
    }
  }

  /// The same point, from this mesh's origin.
  TerrainVertex moved(const TerrainVertex& v, const TerrainMesh& from, int edge, double along) const {
    const geo::Vec3 fine(v.fine_tile[0], v.fine_tile[1], v.fine_tile[2]);
    const geo::Vec3 exact = from.origin.m + geo::Vec3(v.position_tile) + fine * vertexGrid_m_ - out_->origin.m;
    TerrainVertex out = v;
    out.position_tile = geo::Vec3f(exact);
    const geo::Vec3 rest = (exact - geo::Vec3(out.position_tile)) / vertexGrid_m_;
    for (int axis = 0; axis < 3; ++axis)
      out.fine_tile[static_cast<std::size_t>(axis)] = static_cast<std::int16_t>(std::lround(rest[axis]));
    out.toParent = {};
    setPlace(out, placeOnEdge(edge, along));
    return out;
  }

  static void setPlace(TerrainVertex& v, const Place& p) {
    v.s = static_cast<std::uint16_t>(std::lround(p.s * kPlaceUnits));
    v.t = static_cast<std::uint16_t>(std::lround(p.t * kPlaceUnits));
  }

  std::uint32_t add(const TerrainVertex& v) {
    out_->vertices.push_back(v);
    return static_cast<std::uint32_t>(out_->vertices.size() - 1);
  }

  std::uint32_t ofBase(std::uint16_t i) {
    std::uint32_t& known = indexOf_[i];
    if (known != kNoVertex) return known;
    --baseLeft_;
    TerrainVertex v = base_.mesh->vertices[i];
    if (base_.quadrant != MeshPart::kWhole) {
      v.toParent = {};
      setPlace(v, places_[i]);
    }
    return known = add(v);
  }

  /// Triangles lie wholly in one quarter: the lines through the middle are lines of every mesh.
  void addAll(const IndexRange& range) {
    const auto& indices = base_.mesh->indices;
    for (std::uint32_t i = range.first; i < range.first + range.count; i += 3) {
      const std::array<std::uint16_t, 3> t{indices[i], indices[i + 1], indices[i + 2]};
      if (!std::ranges::all_of(t, [&](std::uint16_t v) { return isWithin(places_[v]); })) continue;
      Triangle triangle;
      for (std::size_t k = 0; k < 3; ++k)
        triangle[k] = {.place = places_[t[k]], .index = ofBase(t[k])};
      addTriangle(triangle);
    }
  }

  /// As a fan around the corner across from a side that has vertices of finer tiles.
  void addTriangle(const Triangle& t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner& a = t[k];
      const Corner& b = t[(k + 1) % 3];
      const std::vector<Corner> between = verticesBetween(a, b);
      if (between.empty()) continue;
      const Corner& apex = t[(k + 2) % 3];
      const Corner* last = &a;
      for (const Corner& next : between) {
        addTriangle({*last, next, apex});
        last = &next;
      }
      addTriangle({*last, b, apex});
      return;
    }
    for (const Corner& corner : t)
      out_->indices.push_back(static_cast<std::uint16_t>(corner.index));
  }

  /// Of finer tiles, on the way from one corner to the other.
  std::vector<Corner> verticesBetween(const Corner& a, const Corner& b) {
    std::vector<Corner> out;
    for (int edge = 0; edge < 4; ++edge) {
      auto& ofEdge = inserted_[static_cast<std::size_t>(edge)];
      if (ofEdge.empty() || !isOnEdge(a.place, edge) || !isOnEdge(b.place, edge)) continue;
      const auto [low, high] = std::minmax({alongEdge(a.place, edge), alongEdge(b.place, edge)});
      for (auto i = std::ranges::upper_bound(ofEdge, low, {}, &Inserted::along); i != ofEdge.end() && i->along < high;
           ++i) {
        if (i->index == kNoVertex) {
          if (out_->vertices.size() + baseLeft_ >= kMostVertices) break;
          i->index = add(i->vertex);
        }
        out.push_back({.place = placeOnEdge(edge, i->along), .index = i->index});
      }
      if (alongEdge(a.place, edge) > alongEdge(b.place, edge)) std::ranges::reverse(out);
      if (!out.empty()) break;
    }
    return out;
  }

  MeshPart base_;
  double vertexGrid_m_;
  std::vector<Place> places_;               ///< of the base's vertices
  std::vector<std::uint32_t> indexOf_;      ///< likewise, in out_
  std::size_t baseLeft_ = indexOf_.size();  ///< of the base's vertices, those that are not in out_ yet
  std::array<std::vector<Inserted>, 4> inserted_;
  std::shared_ptr<TerrainMesh> out_ = std::make_shared<TerrainMesh>();
};

}  // namespace

std::shared_ptr<const TerrainMesh> patchMesh(const MeshPart& base, std::uint8_t coarseEdges,
                                             std::span<const FinerEdge> finer, double vertexGrid_m) {
  return Patch(base, coarseEdges, finer, vertexGrid_m).take();
}

}  // namespace tellurion::scene
