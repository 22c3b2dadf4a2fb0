// Inputs that go away or change while a database is made from them: what was made is kept or removed, never a mixture.
#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <memory>

#include "pyramid/build_output.h"
#include "pyramid/database.h"
#include "pyramid/pyramid_builder.h"
#include "pyramid/synthetic_rasters_test.h"

namespace tellurion::pyramid::testing {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

/// Compressed, so that damage is noticed; and so large that building takes several of a second's tenths, at which
/// progress is told.
std::string writeLargeGlobe(const fs::path& path) {
  const std::string plain = path.string() + ".plain.tif";
  writeElevation(plain, degreesGrid(-180, -90, 180, 90, 2160, 1080),
                 [](int c, int r) { return std::round(hills(90 - (r + 0.5) / 6, -180 + (c + 0.5) / 6)); });
  const std::unique_ptr<GDALDataset> source(GDALDataset::Open(plain.c_str()));
  GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  CPLStringList options;
  options.SetNameValue("COMPRESS", "DEFLATE");
  const std::unique_ptr<GDALDataset> copy(
      driver->CreateCopy(path.c_str(), source.get(), FALSE, options.List(), nullptr, nullptr));
  return path.string();
}

class ChangedInputs : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = std::make_unique<TemporaryFolder>();
    input_ = writeLargeGlobe(*shared_ / "globe.tif");
    content_ = bytesOf(input_);
    time_ = fs::last_write_time(input_);
    BuildOptions whole;
    whole.output = *shared_ / "whole.tdb";
    whole.inputs = {input_};
    ASSERT_TRUE(buildPyramid(whole).has_value());
    whole_ = bytesOf(whole.output);
  }
  static void TearDownTestSuite() { shared_.reset(); }
  ChangedInputs() { build_ = options("out.tdb"); }
  ~ChangedInputs() override { write(content_); }

  /// To the input, with its former time.
  static void write(const std::string& bytes) {
    std::ofstream(input_, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    fs::last_write_time(input_, time_);
  }
  BuildOptions options(const std::string& output) const {
    BuildOptions options;
    options.output = folder_ / output;
    options.inputs = {input_};
    return options;
  }
  void touch() const { fs::last_write_time(input_, fs::last_write_time(input_) + std::chrono::seconds(5)); }
  bool isPartThere() const { return fs::exists(folder_ / "out.tdb.part"); }

  /// Tiles are told as done before their group is committed: what counts is what the part holds for another reader.
  bool isAGroupCommitted() const {
    const auto part = TileDatabase::open(folder_ / "out.tdb.part", io::SqliteConnection::Mode::read);
    if (!part) return false;
    const auto position = part->position();
    return position && *position && (*position)->done > 0;
  }

  /// How a build ends under which something happens as soon as a group of tiles is committed.
  io::Failure interruptedBy(const std::function<void()>& happening) {
    build_.jobs = 1;
    bool hasHappened = false;
    const auto built = buildPyramid(build_, [&](const BuildProgress&) {
      if (hasHappened || !isAGroupCommitted()) return;
      hasHappened = true;
      happening();
    });
    EXPECT_TRUE(hasHappened);
    EXPECT_FALSE(built.has_value());
    EXPECT_TRUE(isPartThere());
    EXPECT_FALSE(fs::exists(build_.output));
    return built ? io::Failure{} : built.error();
  }

  inline static std::unique_ptr<TemporaryFolder> shared_;
  inline static std::string input_;
  inline static std::string content_;
  inline static fs::file_time_type time_;
  inline static std::string whole_;  ///< the bytes of an undisturbed build
  TemporaryFolder folder_;
  BuildOptions build_;
};

TEST_F(ChangedInputs, OneThatIsGoneWhenItIsOpenedIsNamed) {
  const auto prepared = prepareBuild(build_, {});
  ASSERT_TRUE(prepared.has_value());
  fs::rename(input_, folder_ / "away");
  const auto built = makeOutput(build_, *prepared, nullptr, {}, {});
  ASSERT_FALSE(built.has_value());
  EXPECT_EQ(built.error().code, Code::notFound);
  EXPECT_EQ(built.error().where, input_);
  fs::rename(folder_ / "away", input_);
  ASSERT_TRUE(buildPyramid(build_).has_value());
  EXPECT_EQ(bytesOf(build_.output), whole_);
}

TEST_F(ChangedInputs, OneThatIsAnotherBeforeTheFirstTileLeavesNothing) {
  const auto prepared = prepareBuild(build_, {});
  ASSERT_TRUE(prepared.has_value());
  touch();
  const auto built = makeOutput(build_, *prepared, nullptr, {}, {});
  ASSERT_FALSE(built.has_value());
  EXPECT_EQ(built.error().where, input_);
  EXPECT_NE(built.error().message.find("changed while it was built from"), std::string::npos) << built.error().message;
  EXPECT_NE(built.error().message.find("nothing was built"), std::string::npos) << built.error().message;
  EXPECT_FALSE(isPartThere());
  EXPECT_TRUE(buildPyramid(build_).has_value()) << "the same command";
}

TEST_F(ChangedInputs, WhatWasReadOfOneThatChangesIsNotCommittedAndTheRestIsKept) {
  const auto disturbed = interruptedBy([&] {
    write(content_.substr(0, content_.size() / 2));
    touch();
  });
  EXPECT_NE(disturbed.message.find("while it was built from"), std::string::npos) << disturbed.message;
  EXPECT_NE(disturbed.message.find("remove " + (folder_ / "out.tdb.part").string()), std::string::npos)
      << disturbed.message;
  EXPECT_FALSE(buildPyramid(build_).has_value()) << "another content, another build";
  write(content_);
  const auto resumed = buildPyramid(build_);
  ASSERT_TRUE(resumed.has_value()) << io::describe(resumed.error());
  EXPECT_TRUE(resumed->resumed);
  EXPECT_EQ(bytesOf(build_.output), whole_);
}

TEST_F(ChangedInputs, OneThatIsMerelyTouchedCostsNothingOnceItsTimeIsSetBack) {
  interruptedBy([&] { touch(); });
  fs::last_write_time(input_, time_);
  ASSERT_TRUE(buildPyramid(build_)->resumed);
  EXPECT_EQ(bytesOf(build_.output), whole_);
}

/// As of a disk that fails for a while, or too many open files: reading fails, and the file is the same.
TEST_F(ChangedInputs, ReadingThatFailsForAWhileKeepsWhatIsDone) {
  const auto failed = interruptedBy([&] {
    std::string damaged = content_;
    std::fill(damaged.begin() + static_cast<std::ptrdiff_t>(damaged.size() / 16), damaged.end(), '\x5a');
    write(damaged);
  });
  EXPECT_EQ(failed.code, Code::corrupt) << failed.message;
  write(content_);
  ASSERT_TRUE(buildPyramid(build_)->resumed);
  EXPECT_EQ(bytesOf(build_.output), whole_);
}

TEST(FileStamps, ThatOneIsGoneHidesNoneThatChanged) {
  const TemporaryFolder folder;
  const std::string gone = writeHillyGlobe(folder / "gone.tif");
  const std::string other = writeHillyGlobe(folder / "other.tif");
  const std::vector<FileStamp> stamps = {stampOf(gone), stampOf(other), stampOf("/vsicurl/http://far.away/x.tif")};
  EXPECT_TRUE(checkUnchanged(stamps).has_value());
  fs::remove(gone);
  EXPECT_EQ(checkUnchanged(stamps).error().code, Code::notFound);
  fs::last_write_time(other, fs::last_write_time(other) + std::chrono::seconds(5));
  EXPECT_EQ(checkUnchanged(stamps).error().code, Code::invalidArgument);
  EXPECT_EQ(checkUnchanged(stamps).error().where, other);
}

TEST_F(ChangedInputs, AFileOfAFormerBuilderIsCalledThat) {
  auto prepared = prepareBuild(build_, {});
  ASSERT_TRUE(prepared.has_value());
  ASSERT_FALSE(prepared->plan.olderKeys.empty());
  auto former = *prepared;
  former.plan.meta.buildKey = former.plan.olderKeys.front();
  const fs::path part = folder_ / "out.tdb.part";
  ASSERT_TRUE(openPart(part, former.plan, {}).has_value());
  const auto refused = buildPyramid(build_);
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().message.find("older version"), std::string::npos) << refused.error().message;
  EXPECT_TRUE(fs::exists(part));
}

}  // namespace
}  // namespace tellurion::pyramid::testing
