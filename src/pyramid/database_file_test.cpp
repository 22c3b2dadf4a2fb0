#include "pyramid/database_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "pyramid/synthetic_rasters_test.h"
#include "pyramid/verify.h"

namespace tellurion::pyramid::testing {
namespace {

namespace fs = std::filesystem;

class DatabaseFile : public ::testing::Test {
 protected:
  BuildOptions options(const std::string& input) const {
    BuildOptions options;
    options.output = folder_ / "out.tdb";
    options.inputs = {(folder_ / input).string()};
    return options;
  }
  void raster(const std::string& name, int side) const {
    writeElevation(folder_ / name, degreesGrid(-180, -90, 180, 90, 2 * side, side), [](int c, int r) { return c + r; });
  }
  /// Leaves out.tdb.part.
  static void interrupt(const BuildOptions& build) {
    std::stop_source stopped;
    stopped.request_stop();
    ASSERT_EQ(buildPyramid(build, {}, stopped.get_token()).error().code, io::Failure::Code::cancelled);
  }
  static std::string complaint(const io::Result<std::shared_ptr<const PyramidReader>>& opened) {
    return opened ? "none" : io::describe(opened.error());
  }
  TemporaryFolder folder_;
};

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(DatabaseFile, AnUnfinishedBuildSaysHowToGoOn) {
  raster("it's.tif", 90);
  interrupt(options("it's.tif"));
  const std::string part = complaint(PyramidReader::open(folder_ / "out.tdb.part"));
  const std::string quoted = "'" + (folder_ / "it'\\''s.tif").string() + "'";
  EXPECT_TRUE(has(part, "unfinished build")) << part;
  EXPECT_TRUE(has(part, "tellurion build " + (folder_ / "out.tdb").string() + " " + quoted +
                            " --kind elevation --tiling cube --body earth"))
      << part;
  EXPECT_FALSE(has(part, "--append")) << part;
  const std::string whole = complaint(PyramidReader::open(folder_ / "out.tdb"));
  EXPECT_TRUE(has(whole, "out.tdb.part")) << whole;
}

TEST_F(DatabaseFile, AnUnfinishedAppendNamesOnlyWhatIsAppended) {
  raster("below.tif", 90);
  raster("above.tif", 180);
  ASSERT_TRUE(buildPyramid(options("below.tif")).has_value());
  BuildOptions append = options("above.tif");
  append.append = true;
  interrupt(append);
  const std::string part = complaint(PyramidReader::open(folder_ / "out.tdb.part"));
  EXPECT_TRUE(has(part, "above.tif") && has(part, "--append")) << part;
  EXPECT_FALSE(has(part, "below.tif")) << part;
}

TEST_F(DatabaseFile, AnUnfinishedBuildUnderTheFinalNameIsNotTakenForFinished) {
  raster("a.tif", 90);
  const BuildOptions build = options("a.tif");
  interrupt(build);
  fs::rename(folder_ / "out.tdb.part", folder_ / "out.tdb");
  const std::string opened = complaint(PyramidReader::open(folder_ / "out.tdb"));
  EXPECT_TRUE(has(opened, "rename it back to")) << opened;
  const auto again = buildPyramid(build);
  ASSERT_FALSE(again.has_value());
  EXPECT_TRUE(has(again.error().message, "rename it back to")) << again.error().message;
  fs::rename(folder_ / "out.tdb", folder_ / "out.tdb.part");
  EXPECT_TRUE(buildPyramid(build)->resumed);
}

TEST_F(DatabaseFile, FoldersAreCalledSo) {
  fs::create_directory(folder_ / "out.tdb");
  EXPECT_TRUE(has(complaint(PyramidReader::open(folder_ / "out.tdb")), "is a folder"));
  EXPECT_TRUE(has(verifyPyramid(folder_ / "out.tdb").error().message, "is a folder"));
  raster("a.tif", 90);
  EXPECT_TRUE(has(buildPyramid(options("a.tif")).error().message, "is a folder"));
  BuildOptions elsewhere = options("a.tif");
  elsewhere.output = folder_ / "absent" / "out.tdb";
  EXPECT_TRUE(has(buildPyramid(elsewhere).error().message, "does not exist"));
  elsewhere.output = folder_ / "a.tif" / "out.tdb";
  EXPECT_TRUE(has(buildPyramid(elsewhere).error().message, "is a file, not a folder"));
}

TEST_F(DatabaseFile, ATileDatabaseIsNoInput) {
  raster("a.tif", 90);
  ASSERT_TRUE(buildPyramid(options("a.tif")).has_value());
  EXPECT_TRUE(isTileDatabaseFile(folder_ / "out.tdb"));
  EXPECT_FALSE(isTileDatabaseFile(folder_ / "a.tif"));
  EXPECT_FALSE(isTileDatabaseFile(folder_ / "absent"));
  fs::rename(folder_ / "out.tdb", folder_ / "named.otherwise");
  const auto built = buildPyramid(options("named.otherwise"));
  ASSERT_FALSE(built.has_value());
  EXPECT_TRUE(has(built.error().message, "is a tile database")) << built.error().message;
}

}  // namespace
}  // namespace tellurion::pyramid::testing
