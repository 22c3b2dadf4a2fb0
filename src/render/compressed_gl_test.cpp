// Compressed pictures: as the driver reads them, and in a frame beside the same uncompressed.

#include <epoxy/gl.h>

#include <fstream>
#include <iterator>
#include <span>

#include "geo/seed_test.h"
#include "raster/codec.h"
#include "render/geometry_arena.h"
#include "render/synthetic_tiles_test.h"
#include "render/texture_pool.h"
#include "scene/texture_image.h"

namespace tellurion::render {
namespace {

using raster::BlockFormat;
using raster::Rgba8;
using Picture = raster::Raster<Rgba8>;

constexpr scene::Viewport kSize{640, 480};
constexpr int kSide = 258;
constexpr int kWidth = 5400;
constexpr int kHeight = 2700;

class Compressed : public synthetic::GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (!IsSkipped() && !readsCompressedPictures()) GTEST_SKIP() << "no compressed textures here";
  }

  /// Pieces of the Blue Marble, as large as tiles, from places all over it.
  static std::vector<Picture> pieces(std::size_t count) {
    std::ifstream file(TELLURION_SOURCE_DIR "/data/earth/bluemarble_dec2004_5400x2700.jpg", std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    const auto whole = raster::decodeImage(std::as_bytes(std::span(bytes)), kWidth, kHeight);
    std::vector<Picture> out;
    for (std::size_t i = 0; i < count && whole; ++i) {
      Picture& piece = out.emplace_back(kSide, kSide);
      const int left = static_cast<int>(i) * 797 % (kWidth - kSide);
      const int top = static_cast<int>(i) * 331 % (kHeight - kSide);
      for (int row = 0; row < kSide; ++row) {
        for (int col = 0; col < kSide; ++col)
          piece.at(col, row) = whole->at(left + col, top + row);
      }
    }
    EXPECT_EQ(out.size(), count);
    return out;
  }

  /// The Earth in 24 tiles, with a picture each of one or two layers.
  static scene::Frame earth(const std::vector<std::vector<Picture>>& layers, bool compress) {
    scene::Frame frame;
    frame.view = synthetic::viewAt(geo::earth().ellipsoid, 20, 30, 1e7, 0, -90, kSize);
    frame.light.enabled = false;
    frame.tiles = synthetic::wholeBody(tiling::Tiling(tiling::Scheme::cube), geo::earth().ellipsoid, 1, 16);
    frame.looks.resize(layers.size());
    for (std::size_t i = 0; i < frame.tiles.size(); ++i) {
      frame.tiles[i].firstPicture = static_cast<std::uint32_t>(frame.pictures.size());
      frame.tiles[i].pictureCount = static_cast<std::uint32_t>(layers.size());
      for (std::size_t layer = 0; layer < layers.size(); ++layer) {
        frame.pictures.push_back({.image = scene::textureFrom(layers[layer][i % layers[layer].size()], compress),
                                  .window = {},
                                  .layer = static_cast<std::uint32_t>(layer)});
      }
    }
    return frame;
  }

  static double meanDifference(const Picture& a, const Picture& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.samples.size(); ++i) {
      const Rgba8 p = a.samples[i];
      const Rgba8 q = b.samples[i];
      sum += std::abs(p.r - q.r) + std::abs(p.g - q.g) + std::abs(p.b - q.b);
    }
    return sum / (3.0 * static_cast<double>(a.samples.size()));
  }

  /// Of a frame of these layers with compressed pictures from the same without.
  static double lossOf(const std::vector<std::vector<Picture>>& layers, const RendererOptions& options,
                       scene::Light light = {.enabled = false}, bool lastIsLamps = false) {
    const RenderTarget target = makeTarget(kSize);
    std::vector<Picture> drawn;
    for (const bool compress : {false, true}) {
      Renderer renderer = makeRenderer(compress ? options : RendererOptions{});
      scene::Frame frame = earth(layers, compress);
      frame.light = light;
      if (lastIsLamps) frame.looks.back().role = scene::LayerRole::nightLights;
      const RenderStatistics statistics = renderer.draw(frame, target);
      EXPECT_EQ(statistics.tilesWithoutRoom, 0);
      EXPECT_LE(statistics.drawCalls, 2);
      drawn.push_back(readColour(target));
    }
    return meanDifference(drawn[0], drawn[1]);
  }
};

// The driver's own reading of any bytes, those that our compressor never writes too. Drivers round differently between
// a block's ends.
TEST_F(Compressed, AreReadAsTheDriverReadsThem) {
  constexpr int kRounding = 3;
  auto random = geo::seededGenerator();
  for (int round = 0; round < 50; ++round) {
    for (const BlockFormat format : {BlockFormat::bc1, BlockFormat::bc3}) {
      raster::BlockPicture blocks{.format = format, .width = 18, .height = 7, .bytes = {}};
      blocks.bytes.resize(raster::blockBytes(format, blocks.width, blocks.height));
      for (std::byte& b : blocks.bytes)
        b = static_cast<std::byte>(random());
      const GLenum glFormat =
          format == BlockFormat::bc1 ? GL_COMPRESSED_RGB_S3TC_DXT1_EXT : GL_COMPRESSED_RGBA_S3TC_DXT5_EXT;
      GLuint name = 0;
      glCreateTextures(GL_TEXTURE_2D, 1, &name);
      const Texture texture(name);
      glTextureStorage2D(name, 1, glFormat, blocks.width, blocks.height);
      glCompressedTextureSubImage2D(name, 0, 0, 0, blocks.width, blocks.height, glFormat,
                                    static_cast<GLsizei>(blocks.bytes.size()), blocks.bytes.data());
      Picture theirs(blocks.width, blocks.height);
      glGetTextureImage(name, 0, GL_RGBA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(theirs.samples.size() * sizeof(Rgba8)),
                        theirs.samples.data());
      const Picture ours = raster::decompressed(blocks);
      for (std::size_t i = 0; i < ours.samples.size(); ++i) {
        const Rgba8 p = ours.samples[i];
        const Rgba8 q = theirs.samples[i];
        ASSERT_LE(std::max({std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b), std::abs(p.a - q.a)}),
                  kRounding);
      }
    }
  }
}

TEST_F(Compressed, OpaquePicturesTakeAnEighthAndOthersAQuarter) {
  Picture piece = pieces(1).front();
  const auto ratio = [](const Picture& p) {
    return static_cast<double>(scene::pixelBytes(*scene::textureFrom(p, false))) /
           static_cast<double>(scene::pixelBytes(*scene::textureFrom(p, true)));
  };
  EXPECT_NEAR(ratio(piece), 8.0, 0.2);  // 258 is no multiple of 4
  piece.at(7, 7).a = 254;
  EXPECT_NEAR(ratio(piece), 4.0, 0.1);
  const RenderTarget target = makeTarget(kSize);
  Renderer plain = makeRenderer();
  Renderer compressed = makeRenderer({.compressedPictures = true});
  const std::vector<std::vector<Picture>> layers{pieces(24)};
  const RenderStatistics before = plain.draw(earth(layers, false), target);
  const RenderStatistics after = compressed.draw(earth(layers, true), target);
  const std::uint64_t meshes = 24 * bytesOf(*earth(layers, false).tiles[0].mesh);
  EXPECT_NEAR(static_cast<double>(before.uploadBytes - meshes) / static_cast<double>(after.uploadBytes - meshes), 8.0,
              0.2);
  EXPECT_LT(after.gpuBytes, before.gpuBytes);
}

TEST_F(Compressed, AFrameLooksTheSame) {
  const std::vector<std::vector<Picture>> layers{pieces(24)};
  for (const bool isTold : {true, false}) {
    const double loss = lossOf(layers, {.compressedPictures = isTold});
    std::printf("mean difference %.2f of 255\n", loss);
    EXPECT_GT(loss, 0.0);
    EXPECT_LT(loss, 3.0);
  }
}

TEST_F(Compressed, LayersWithGapsAndNightLightsToo) {
  std::vector<Picture> gaps = pieces(3);
  for (Picture& piece : gaps) {
    for (int row = 0; row < kSide; ++row) {
      for (int col = 0; col < kSide; ++col)
        piece.at(col, row).a = static_cast<std::uint8_t>(std::clamp(3 * (col + row - kSide), 0, 255));
    }
  }
  EXPECT_LT(lossOf({pieces(24), gaps}, {.compressedPictures = true}), 3.0);
  std::vector<Picture> lamps = pieces(3);
  for (Picture& piece : lamps) {
    for (Rgba8& p : piece.samples)
      p = {0, 0, 0, p.g};
  }
  const scene::Light night{.toSun_body = {-1.0, 0.0, 0.0}};
  for (const bool anyGpu : {false, true})
    EXPECT_LT(lossOf({pieces(24), lamps}, {.compressedPictures = true, .asOnAnyGpu = anyGpu}, night, true), 3.0);
}

TEST_F(Compressed, WithoutRoomAreTheirMeanColour) {
  constexpr Rgba8 kColour{180, 121, 64, 255};
  const RenderTarget target = makeTarget(kSize);
  Renderer renderer = makeRenderer({.gpuBudgetBytes = 1, .compressedPictures = true});
  scene::Frame frame = earth({std::vector<Picture>(24, Picture(kSide, kSide, kColour))}, true);
  EXPECT_GT(renderer.draw(frame, target).tilesWithoutRoom, 0);
  const Rgba8 middle = readColour(target).at(kSize.width / 2, kSize.height / 2);
  EXPECT_NEAR(middle.r, kColour.r, 4);
  EXPECT_NEAR(middle.g, kColour.g, 2);
  EXPECT_NEAR(middle.b, kColour.b, 4);
}

}  // namespace
}  // namespace tellurion::render
