#include "raster/colour_match.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace tellurion::raster {
namespace {

constexpr int kMostPlaces = 512;
constexpr int kMostCells = 24;
constexpr int kPlacesPerCell = 8;  ///< along a side, at least
constexpr int kRounds = 3;
constexpr double kLeastPlaces = 16.0;
/// Of a channel's values, 0..255: contrast below this says little about the gain.
constexpr double kFaint = 2.5;
constexpr double kLeastGain = 0.4;
constexpr double kMostGain = 2.5;
/// What a wider neighbourhood counts against the next narrower one.
constexpr double kWiderShare = 0.05;
constexpr std::array kWidths_cells{1.0, 3.0, 9.0};

using Channels = std::array<double, 3>;

Channels channelsOf(Rgba8 c) {
  return {static_cast<double>(c.r), static_cast<double>(c.g), static_cast<double>(c.b)};
}

bool isUnclipped(Rgba8 c) {
  const auto [low, high] = std::minmax({c.r, c.g, c.b});
  return c.a == 255 && low > 0 && high < 255;
}

/// A place where both pictures can be believed.
struct Pair {
  Channels from{};
  Channels to{};
  geo::Direction place;
  std::size_t cell = 0;
  double weight = 1.0;
};

/// The sums that a line's least squares need.
struct Moments {
  double count = 0.0;
  Channels from{};
  Channels to{};
  Channels fromFrom{};
  Channels fromTo{};

  void add(const Moments& o, double share) {
    count += share * o.count;
    for (std::size_t k = 0; k < 3; ++k) {
      from[k] += share * o.from[k];
      to[k] += share * o.to[k];
      fromFrom[k] += share * o.fromFrom[k];
      fromTo[k] += share * o.fromTo[k];
    }
  }
  void add(const Pair& p) {
    count += p.weight;
    for (std::size_t k = 0; k < 3; ++k) {
      from[k] += p.weight * p.from[k];
      to[k] += p.weight * p.to[k];
      fromFrom[k] += p.weight * p.from[k] * p.from[k];
      fromTo[k] += p.weight * p.from[k] * p.to[k];
    }
  }
  ColourLine line() const {
    ColourLine line;
    if (!(count > 0.0)) return line;
    for (std::size_t k = 0; k < 3; ++k) {
      const double meanFrom = from[k] / count;
      const double meanTo = to[k] / count;
      const double variance = fromFrom[k] / count - meanFrom * meanFrom;
      const double covariance = fromTo[k] / count - meanFrom * meanTo;
      line[k].gain = std::clamp((covariance + kFaint * kFaint) / (variance + kFaint * kFaint), kLeastGain, kMostGain);
      line[k].offset = meanTo - line[k].gain * meanFrom;
    }
    return line;
  }
};

/// Weights of a bell of some cells, from its middle outwards to three times its width.
std::vector<double> bell(double width) {
  std::vector<double> weights(static_cast<std::size_t>(std::ceil(3.0 * width)) + 1);
  for (std::size_t i = 0; i < weights.size(); ++i)
    weights[i] = std::exp(-0.5 * static_cast<double>(i * i) / (width * width));
  return weights;
}

/// Each cell with those before and after it in its row or its column.
std::vector<Moments> blurred(const std::vector<Moments>& cells, const LonLatGrid& grid, bool alongRows,
                             const std::vector<double>& weights) {
  std::vector<Moments> out(cells.size());
  const int reach = static_cast<int>(weights.size()) - 1;
  for (int row = 0; row < grid.height; ++row) {
    for (int col = 0; col < grid.width; ++col) {
      Moments& sum = out[static_cast<std::size_t>(row * grid.width + col)];
      for (int d = -reach; d <= reach; ++d) {
        int c = alongRows ? col + d : col;
        const int r = alongRows ? row : row + d;
        if (grid.wraps() && 2 * reach < grid.width) c = (c + grid.width) % grid.width;
        if (c < 0 || c >= grid.width || r < 0 || r >= grid.height) continue;
        sum.add(cells[static_cast<std::size_t>(r * grid.width + c)], weights[static_cast<std::size_t>(std::abs(d))]);
      }
    }
  }
  return out;
}

std::vector<ColourLine> linesOf(const std::vector<Pair>& pairs, const LonLatGrid& grid) {
  std::vector<Moments> cells(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
  Moments all;
  for (const Pair& pair : pairs) {
    cells[pair.cell].add(pair);
    all.add(pair);
  }
  std::vector<Moments> sums(cells.size());
  double share = 1.0;
  for (const double width : kWidths_cells) {
    const std::vector<double> weights = bell(width);
    const auto wide = blurred(blurred(cells, grid, true, weights), grid, false, weights);
    for (std::size_t i = 0; i < sums.size(); ++i)
      sums[i].add(wide[i], share / (width * width));
    share *= kWiderShare;
  }
  std::vector<ColourLine> lines(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    sums[i].add(all, share / static_cast<double>(cells.size()));
    lines[i] = sums[i].line();
  }
  return lines;
}

io::Result<std::vector<Pair>> pairsOf(const ColourSampler& from, const ColourSampler& to, const LonLatGrid& places,
                                      geo::Angle footprint, const LonLatGrid& cells) {
  std::vector<Pair> pairs;
  std::vector<Rgba8> a;
  std::vector<Rgba8> b;
  for (int row = 0; row < places.height; ++row) {
    const auto line = places.places(row);
    a.assign(line.size(), {});
    b.assign(line.size(), {});
    if (auto ok = to(line, footprint, b); !ok) return tl::unexpected(ok.error());
    if (std::ranges::none_of(b, isUnclipped)) continue;
    if (auto ok = from(line, footprint, a); !ok) return tl::unexpected(ok.error());
    for (std::size_t i = 0; i < line.size(); ++i) {
      if (!isUnclipped(a[i]) || !isUnclipped(b[i])) continue;
      const int cellColumn = static_cast<int>(i) * cells.width / places.width;
      const int cellRow = row * cells.height / places.height;
      pairs.push_back({.from = channelsOf(a[i]),
                       .to = channelsOf(b[i]),
                       .place = line[i],
                       .cell = static_cast<std::size_t>(cellRow * cells.width + cellColumn)});
    }
  }
  return pairs;
}

double diagonalOf(const geo::GeoRect& area) {
  return std::hypot((area.north - area.south).radians(),
                    area.width.radians() * std::cos(((area.north + area.south) / 2.0).radians()));
}

/// How far a place is from the nearest of some areas, radians; `most` where it is no nearer.
double distanceTo(const std::vector<geo::GeoRect>& areas, const geo::Direction& place, const geo::Geodetic& where,
                  double most) {
  double least = most;
  for (const geo::GeoRect& area : areas) {
    if (area.contains(where.lat, where.lon)) return 0.0;
    const geo::Angle lat = std::clamp(where.lat, area.south, area.north);
    if (std::abs((where.lat - lat).radians()) >= least) continue;
    const geo::Angle middle = area.west + area.width / 2.0;
    const double half = area.width.radians() / 2.0;
    const double east = std::clamp(geo::wrappedLongitude(where.lon - middle).radians(), -half, half);
    const auto nearest = geo::directionFromLatLon(lat, geo::wrappedLongitude(middle + geo::Angle::radians(east)));
    least = std::min(least, geo::angleBetween(place, nearest).radians());
  }
  return least;
}

ColourLine lineAt(const ColourMatch::Part& part, const geo::Direction& place) {
  const LonLatGrid::Spot s = part.grid.spotOf(place);
  const auto cell = [&](int col, int row) -> const ColourLine& {
    return part.lines[static_cast<std::size_t>(row * part.grid.width + col)];
  };
  const std::array<const ColourLine*, 4> near{&cell(s.col0, s.row0), &cell(s.col1, s.row0), &cell(s.col0, s.row1),
                                              &cell(s.col1, s.row1)};
  const std::array<double, 4> shares{(1 - s.right) * (1 - s.down), s.right * (1 - s.down), (1 - s.right) * s.down,
                                     s.right * s.down};
  ColourLine line;
  for (std::size_t k = 0; k < 3; ++k) {
    line[k] = {.gain = 0.0, .offset = 0.0};
    for (std::size_t i = 0; i < 4; ++i) {
      line[k].gain += shares[i] * (*near[i])[k].gain;
      line[k].offset += shares[i] * (*near[i])[k].offset;
    }
  }
  return line;
}

/// How far a pair is off its line in its worst channel.
double residualOf(const Pair& pair, const ColourMatch::Part& part) {
  const ColourLine line = lineAt(part, pair.place);
  double worst = 0.0;
  for (std::size_t k = 0; k < 3; ++k)
    worst = std::max(worst, std::abs(pair.to[k] - line[k].gain * pair.from[k] - line[k].offset));
  return worst;
}

/// Those that are far off count less.
void weigh(std::vector<Pair>& pairs, const ColourMatch::Part& part) {
  std::vector<double> residuals(pairs.size());
  std::ranges::transform(pairs, residuals.begin(), [&](const Pair& p) { return residualOf(p, part); });
  std::vector<double> sorted = residuals;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::ranges::nth_element(sorted, middle);
  const double usual = std::max(3.0 * *middle, 3.0);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double off = residuals[i] / usual;
    pairs[i].weight = 1.0 / (1.0 + off * off * off * off);
  }
}

struct Group {
  geo::GeoRect around;
  std::vector<geo::GeoRect> areas;
};

/// So that no two groups' rectangles touch.
std::vector<Group> groupsOf(const std::vector<geo::GeoRect>& areas) {
  std::vector<Group> groups;
  for (const geo::GeoRect& area : areas) {
    Group joined{.around = area, .areas = {area}};
    while (true) {
      const auto met =
          std::ranges::find_if(groups, [&](const Group& group) { return group.around.intersects(joined.around); });
      if (met == groups.end()) break;
      joined.around = met->around.united(joined.around);
      joined.areas.insert(joined.areas.begin(), met->areas.begin(), met->areas.end());
      groups.erase(met);
    }
    groups.push_back(std::move(joined));
  }
  return groups;
}

/// Nothing: they have hardly a place in common there.
io::Result<std::optional<ColourMatch::Part>> partOf(const ColourSampler& from, const ColourSampler& to,
                                                    const Group& group, geo::Angle finestSpacing) {
  const LonLatGrid places = gridOfSpacing(group.around, finestSpacing, kMostPlaces);
  ColourMatch::Part part{.grid = {.bounds = group.around,
                                  .width = std::clamp(places.width / kPlacesPerCell, 1, kMostCells),
                                  .height = std::clamp(places.height / kPlacesPerCell, 1, kMostCells)},
                         .areas = group.areas,
                         .lines = {}};
  const geo::Angle footprint = (group.around.north - group.around.south) / places.height;
  auto pairs = pairsOf(from, to, places, footprint, part.grid);
  if (!pairs) return tl::unexpected(pairs.error());
  if (static_cast<double>(pairs->size()) < kLeastPlaces) return std::optional<ColourMatch::Part>{};
  for (int round = 0; round <= kRounds; ++round) {
    if (round > 0) weigh(*pairs, part);
    part.lines = linesOf(*pairs, part.grid);
  }
  return part;
}

}  // namespace

ColourMatch::ColourMatch(std::vector<Part> parts) : parts_(std::move(parts)) {
  for (const Part& part : parts_) {
    double reach = 0.0;
    for (const geo::GeoRect& area : part.areas)
      reach = std::max(reach, diagonalOf(area));
    reaches_rad_.push_back(reach);
  }
}

ColourLine ColourMatch::at(const geo::Direction& place) const {
  const geo::Geodetic where = geo::geodeticFromDirection(place);
  ColourLine sum{};
  for (ChannelLine& channel : sum)
    channel = {.gain = 0.0, .offset = 0.0};
  double shares = 0.0;
  double kept = 0.0;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const double reach = reaches_rad_[p];
    const double distance = distanceTo(parts_[p].areas, place, where, 3.0 * reach);
    if (distance == 0.0) return lineAt(parts_[p], place);
    const double t = std::clamp((distance / reach - 1.0) / 2.0, 0.0, 1.0);
    const double keeps = 1.0 - t * t * (3.0 - 2.0 * t);
    if (!(keeps > 0.0)) continue;
    const double share = keeps / (distance * distance);
    const ColourLine line = lineAt(parts_[p], place);
    for (std::size_t k = 0; k < 3; ++k) {
      sum[k].gain += share * line[k].gain;
      sum[k].offset += share * line[k].offset;
    }
    shares += share;
    kept = std::max(kept, keeps);
  }
  ColourLine line;
  for (std::size_t k = 0; shares > 0.0 && k < 3; ++k)
    line[k] = {.gain = 1.0 + kept * (sum[k].gain / shares - 1.0), .offset = kept * sum[k].offset / shares};
  return line;
}

Rgba8 ColourMatch::apply(const geo::Direction& place, Rgba8 colour) const {
  if (colour.a == 0) return colour;
  const ColourLine line = at(place);
  const Channels value = channelsOf(colour);
  const auto moved = [&](std::size_t k) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(line[k].gain * value[k] + line[k].offset, 0.0, 255.0)));
  };
  return {moved(0), moved(1), moved(2), colour.a};
}

io::Result<std::optional<ColourMatch>> matchColours(const ColourSampler& from, const ColourSampler& to,
                                                    const std::vector<geo::GeoRect>& areas, geo::Angle finestSpacing) {
  std::vector<ColourMatch::Part> parts;
  for (const Group& group : groupsOf(areas)) {
    auto part = partOf(from, to, group, finestSpacing);
    if (!part) return tl::unexpected(part.error());
    if (*part) parts.push_back(std::move(**part));
  }
  if (parts.empty()) return std::optional<ColourMatch>{};
  return ColourMatch(std::move(parts));
}

}  // namespace tellurion::raster
