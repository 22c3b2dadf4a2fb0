#include "raster/grid_sampling.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "raster/sampling.h"
#include "raster/tile_places.h"

namespace tellurion::raster {
namespace {

/// Enough for the blocks that a tile meets.
constexpr std::size_t kStoreBytes = std::size_t{256} << 20u;
/// Samples read at a time: their places stay in the processor's cache.
constexpr std::size_t kBatch = 2048;
/// How much finer than the parent's samples pixels must be to count.
constexpr double kFiner = 1.1;

constexpr Kind kindOf(float /*sample*/) {
  return Kind::elevation;
}
constexpr Kind kindOf(Rgba8 /*sample*/) {
  return Kind::imagery;
}
constexpr float emptyOf(float /*sample*/) {
  return kNoData;
}
constexpr Rgba8 emptyOf(Rgba8 /*sample*/) {
  return {};
}

bool sampleStore(PixelStore<float>& store, bool isMean, const PixelPlaces& places, std::span<float> out) {
  return isMean ? meanHeights(store, places, out) : bilinearHeights(store, places, out);
}
bool sampleStore(PixelStore<Rgba8>& store, bool isMean, const PixelPlaces& places, std::span<Rgba8> out) {
  return isMean ? meanColours(store, places, out) : bilinearColours(store, places, out);
}

/// The images of one level that a tile meets.
template <class T>
class LevelImages {
 public:
  LevelImages(const GridGeometry& geometry, int level, const GridImages<T>& images)
      : geometry_(geometry),
        level_(level),
        grid_(geometry.window(level).topology),
        width_(geometry.level(level).imageWidth),
        height_(geometry.level(level).imageHeight),
        images_(images) {}

  /// Whether all pixels that a sample at (col, row) reads are of images that exist. False outside the window.
  io::Result<bool> hold(double col, double row, const GridFit& fit) {
    if (!(col >= 0.0 && col <= grid_.width && row >= 0.0 && row <= grid_.height)) return false;
    const double x = fit.isMean ? 0.5 * std::max(fit.width, 1.0) : 0.5;
    const double y = fit.isMean ? 0.5 * std::max(fit.height, 1.0) : 0.5;
    const int left = static_cast<int>(std::floor(col - x));
    const int right = static_cast<int>(std::floor(col + x));
    const int top = static_cast<int>(std::floor(row - y));
    const int bottom = static_cast<int>(std::floor(row + y));
    if (left < 0 || top < 0 || right >= grid_.width || bottom >= grid_.height) {
      return holdAcrossEnds(left, right, top, bottom);
    }
    for (int r = top / height_; r <= bottom / height_; ++r) {
      for (int c = left / width_; c <= right / width_; ++c) {
        auto found = image(c, r);
        if (!found) return tl::unexpected(std::move(found.error()));
        if (*found == nullptr) return false;
      }
    }
    return true;
  }

  /// Fills a block of a PixelStore; parts whose images nobody asked for are left empty, for nobody reads them.
  void read(const Window& window, T* block) const {
    constexpr int kSide = PixelStore<T>::kSide;
    std::fill_n(block, kSide * kSide, emptyOf(T{}));
    const int right = window.col + window.width;
    const int bottom = window.row + window.height;
    for (int r = window.row / height_; r * height_ < bottom; ++r) {
      for (int c = window.col / width_; c * width_ < right; ++c) {
        const auto found = kept_.find(keyOf(c, r));
        if (found == kept_.end() || !found->second) continue;
        const Raster<T>& image = *found->second;
        const int first = std::max(window.col, c * width_);
        const int end = std::min(right, (c + 1) * width_);
        for (int row = std::max(window.row, r * height_); row < std::min(bottom, (r + 1) * height_); ++row) {
          const auto from = image.row(row - r * height_).subspan(static_cast<std::size_t>(first - c * width_));
          std::copy_n(from.begin(), end - first, block + (row - window.row) * kSide + (first - window.col));
        }
      }
    }
  }

 private:
  static std::uint64_t keyOf(int column, int row) {
    return (static_cast<std::uint64_t>(row) << 32u) | static_cast<std::uint64_t>(column);
  }

  io::Result<const Raster<T>*> image(int column, int row) {
    const std::uint64_t key = keyOf(column, row);
    if (key == lastKey_) return last_;
    auto found = kept_.find(key);
    if (found == kept_.end()) {
      auto got = images_(geometry_.imageAt(level_, column, row));
      if (!got) return tl::unexpected(std::move(got.error()));
      found = kept_.emplace(key, std::move(*got)).first;
    }
    lastKey_ = key;
    last_ = found->second.get();
    return last_;
  }

  io::Result<bool> holdAcrossEnds(int left, int right, int top, int bottom) {
    for (int row = top; row <= bottom; ++row) {
      for (int col = left; col <= right; ++col) {
        int c = col;
        int r = row;
        if (!grid_.resolve(c, r)) {
          c = std::clamp(c, 0, grid_.width - 1);
          r = std::clamp(r, 0, grid_.height - 1);
        }
        auto found = image(c / width_, r / height_);
        if (!found) return tl::unexpected(std::move(found.error()));
        if (*found == nullptr) return false;
      }
    }
    return true;
  }

  const GridGeometry& geometry_;
  int level_;
  GridTopology grid_;
  int width_;
  int height_;
  const GridImages<T>& images_;
  std::unordered_map<std::uint64_t, std::shared_ptr<const Raster<T>>> kept_;
  std::uint64_t lastKey_ = ~std::uint64_t{0};
  const Raster<T>* last_ = nullptr;
};

/// Samples that are read on one level in one way.
struct Group {
  std::vector<std::size_t> indices;
  PixelPlaces places;
  void add(std::size_t index, GridGeometry::Pixel pixel, const GridFit& fit) {
    indices.push_back(index);
    places.col.push_back(pixel.col);
    places.row.push_back(pixel.row);
    places.width.push_back(fit.width);
    places.height.push_back(fit.height);
  }
  void clear() {
    indices.clear();
    places.col.clear();
    places.row.clear();
    places.width.clear();
    places.height.clear();
  }
};

template <class T>
class TileSampler {
 public:
  TileSampler(const GridGeometry& geometry, const tiling::Tiling& tiling, const tiling::TileId& id, int cells,
              const GridImages<T>& images)
      : geometry_(geometry),
        scheme_(tiling.scheme()),
        spacing_(sampleSpacing(tiling, id.level, cells)),
        images_(images),
        side_(sideOf(kindOf(T{}), cells)),
        places_(tilePlaces(geometry, tiling, id, kindOf(T{}), cells)) {
    made_.samples = Raster<T>(side_, side_, emptyOf(T{}));
  }

  io::Result<GridSamples<T>> run() {
    chooseLevels();
    for (int level = geometry_.levels() - 1; level >= 0; --level) {
      if (auto done = readLevel(level); !done) return tl::unexpected(std::move(done.error()));
    }
    return std::move(made_);
  }

 private:
  void chooseLevels() {
    levels_.assign(places_.x.size(), -1);
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      if (!std::isfinite(places_.x[i]) || !std::isfinite(places_.y[i])) continue;
      if (!geometry_.isInBounds(places_.x[i], places_.y[i])) continue;
      levels_[i] = geometry_.fit(spacing_, scheme_, places_.narrowing[i]).level;
      made_.isReached = made_.isReached || (levels_[i] >= 0 && isInside(i));
    }
  }

  /// Reads what is to be read on a level, and leaves what that has not to the next coarser one.
  io::Result<void> readLevel(int level) {
    LevelImages<T> images(geometry_, level, images_);
    // All images are here before the first block of pixels is put together of them.
    if (auto held = hold(level, images); !held) return held;
    PixelStore<T> store({geometry_.window(level).topology}, kStoreBytes, [&](const Window& window, T* block) {
      images.read(window, block);
      return io::Result<void>{};
    });
    Group means;
    Group points;
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      if (levels_[i] != level) continue;
      const double narrowing = places_.narrowing[i];
      const GridFit fit = geometry_.fitOn(level, spacing_, scheme_, narrowing);
      Group& group = fit.isMean ? means : points;
      group.add(i, geometry_.pixel(level, places_.x[i], places_.y[i]), fit);
      if (group.indices.size() >= kBatch) readGroup(store, group, fit.isMean);
      const bool isFiner = geometry_.pixelSide(level, narrowing).radians() * kFiner < 2.0 * spacing_.radians();
      made_.addsDetail = made_.addsDetail || (isFiner && isInside(i));
    }
    readGroup(store, means, true);
    readGroup(store, points, false);
    return {};
  }

  /// Of the samples for a level, those whose images are not all there become samples for the next coarser one.
  io::Result<void> hold(int level, LevelImages<T>& images) {
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      if (levels_[i] != level) continue;
      const GridFit fit = geometry_.fitOn(level, spacing_, scheme_, places_.narrowing[i]);
      const GridGeometry::Pixel pixel = geometry_.pixel(level, places_.x[i], places_.y[i]);
      const auto held = images.hold(pixel.col, pixel.row, fit);
      if (!held) return tl::unexpected(held.error());
      if (!*held) --levels_[i];
    }
    return {};
  }

  void readGroup(PixelStore<T>& store, Group& group, bool isMean) {
    out_.assign(group.indices.size(), emptyOf(T{}));
    sampleStore(store, isMean, group.places, out_);
    for (std::size_t i = 0; i < out_.size(); ++i)
      made_.samples.samples[group.indices[i]] = out_[i];
    group.clear();
  }

  bool isInside(std::size_t index) const {
    const auto side = static_cast<std::size_t>(side_);
    const std::size_t col = index % side;
    const std::size_t row = index / side;
    return col >= kGutter && row >= kGutter && col + kGutter < side && row + kGutter < side;
  }

  const GridGeometry& geometry_;
  tiling::Scheme scheme_;
  geo::Angle spacing_;
  const GridImages<T>& images_;
  int side_;
  PlanePlaces places_;
  std::vector<int> levels_;  ///< of each sample the level that it is to be read on; -1: it has no data
  std::vector<T> out_;
  GridSamples<T> made_;
};

}  // namespace

io::Result<GridSamples<float>> sampleGrid(const GridGeometry& geometry, const tiling::Tiling& tiling,
                                          const tiling::TileId& id, int cells, const GridImages<float>& images) {
  return TileSampler<float>(geometry, tiling, id, cells, images).run();
}

io::Result<GridSamples<Rgba8>> sampleGrid(const GridGeometry& geometry, const tiling::Tiling& tiling,
                                          const tiling::TileId& id, int cells, const GridImages<Rgba8>& images) {
  return TileSampler<Rgba8>(geometry, tiling, id, cells, images).run();
}

}  // namespace tellurion::raster
