#include "scene/scene_identity.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace tellurion::scene {
namespace {

namespace fs = std::filesystem;

class SceneIdentity : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("tellurion_scene_identity_" + std::to_string(::getpid()));
    fs::create_directories(folder / "there");
    for (const char* place : {"a.tdb", "there/a.tdb"})
      std::ofstream(folder / place) << "four";
  }
  void TearDown() override { fs::remove_all(folder); }

  Scene scene(const std::string& imagery = "a.tdb") const {
    Scene all;
    all.elevation.push_back({.source = (folder / "a.tdb").string()});
    all.imagery.push_back({.name = "day", .source = (folder / imagery).string()});
    return all;
  }
  static std::string difference(const Scene& leader, const Scene& own) {
    return differenceOf(identityOf(leader), identityOf(own));
  }
  fs::path folder;
};

TEST_F(SceneIdentity, filesMayLieElsewhere) {
  EXPECT_EQ(difference(scene(), scene("there/a.tdb")), "");
}

TEST_F(SceneIdentity, whatDiffersIsTold) {
  std::ofstream(folder / "there" / "a.tdb") << "fifteen letters";
  EXPECT_EQ(difference(scene(), scene("there/a.tdb")),
            "the leader shows another scene: it has 'imagery: day, a.tdb of 4 bytes', this machine 'imagery: day, "
            "a.tdb of 15 "
            "bytes'; give all machines the same");
  Scene other = scene();
  other.tiling = tiling::Scheme::healpix;
  EXPECT_NE(difference(other, scene()).find("'tiling: healpix', this machine 'tiling: cube'"), std::string::npos);
  other = scene();
  other.body = geo::mars();
  EXPECT_NE(difference(other, scene()).find("body: mars"), std::string::npos);
  other = scene();
  other.imagery.push_back(other.imagery.front());
  EXPECT_NE(difference(scene(), other).find("it has nothing more"), std::string::npos);
  other = scene();
  other.imagery.front().look.role = LayerRole::water;
  EXPECT_NE(difference(scene(), other).find("water"), std::string::npos);
  other = scene();
  other.air.atmosphere = *atmosphereByName("mars");
  EXPECT_NE(difference(scene(), other).find("'air: "), std::string::npos);
  other = scene();
  other.imagery.front().look.opacity = 0.5;  // the leader says that anew in each frame
  EXPECT_EQ(difference(scene(), other), "");
}

TEST_F(SceneIdentity, secretsOfUrlsStayHere) {
  Scene all;
  all.imagery.push_back({.source = "https://me:password@host/wms?token=abcdef"});
  const std::string text = identityOf(all);
  EXPECT_EQ(text.find("password"), std::string::npos);
  EXPECT_EQ(text.find("abcdef"), std::string::npos);
  EXPECT_NE(text.find("host/wms"), std::string::npos);
}

TEST_F(SceneIdentity, whatALeaderSaysDoesNotMoveTheTerminal) {
  const std::string told = differenceOf("\x1b[2J" + std::string(100000, 'x'), identityOf(scene()));
  EXPECT_EQ(told.find('\x1b'), std::string::npos);
  EXPECT_LT(told.size(), 1000u);
}

}  // namespace
}  // namespace tellurion::scene
