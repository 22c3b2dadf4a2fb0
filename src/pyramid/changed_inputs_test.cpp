// Inputs that go away or change while a database is made from them: what was made is kept or removed, never a mixture.
#include <gtest/gtest.h>

#include <chrono>

#include "pyramid/build_output.h"
#include "pyramid/pyramid_builder.h"
#include "pyramid/synthetic_rasters_test.h"

namespace tellurion::pyramid::testing {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

class ChangedInputs : public ::testing::Test {
 protected:
  ChangedInputs() : input_(writeHillyGlobe(folder_ / "globe.tif")) {
    whole_ = options("whole.tdb");
    EXPECT_TRUE(buildPyramid(whole_).has_value());
    build_ = options("out.tdb");
  }
  BuildOptions options(const std::string& output) const {
    BuildOptions options;
    options.output = folder_ / output;
    options.inputs = {input_};
    return options;
  }
  void touch() const { fs::last_write_time(input_, fs::last_write_time(input_) + std::chrono::seconds(5)); }
  bool isPartThere() const { return fs::exists(folder_ / "out.tdb.part"); }

  TemporaryFolder folder_;
  std::string input_;
  BuildOptions whole_;
  BuildOptions build_;
};

TEST_F(ChangedInputs, OneThatIsGoneWhenItIsOpenedKeepsWhatIsDoneAndTheSameCommandGoesOn) {
  const auto prepared = prepareBuild(build_, {});
  ASSERT_TRUE(prepared.has_value());
  fs::rename(input_, folder_ / "away");
  const auto built = makeOutput(build_, *prepared, nullptr, {}, {});
  ASSERT_FALSE(built.has_value());
  EXPECT_EQ(built.error().code, Code::notFound);
  EXPECT_EQ(built.error().where, input_);
  EXPECT_NE(built.error().message.find("put the file back and run the same command again"), std::string::npos)
      << built.error().message;
  EXPECT_TRUE(isPartThere());
  fs::rename(folder_ / "away", input_);
  ASSERT_TRUE(buildPyramid(build_).has_value());
  EXPECT_EQ(bytesOf(build_.output), bytesOf(whole_.output));
}

TEST_F(ChangedInputs, OneThatIsAnotherWhenItIsOpenedLeavesNothing) {
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

TEST_F(ChangedInputs, OneThatChangesWhileItIsReadIsNoticedAtTheEnd) {
  bool isTouched = false;
  const auto built = buildPyramid(build_, [&](const BuildProgress&) {
    if (!isTouched) touch();
    isTouched = true;
  });
  ASSERT_TRUE(isTouched);
  ASSERT_FALSE(built.has_value());
  EXPECT_NE(built.error().message.find("changed while it was built from"), std::string::npos) << built.error().message;
  EXPECT_FALSE(isPartThere());
  EXPECT_FALSE(fs::exists(build_.output));
  EXPECT_TRUE(buildPyramid(build_).has_value()) << "the same command";
}

TEST_F(ChangedInputs, OneThatIsRemovedAfterItWasOpenedWasReadWhole) {
  build_.jobs = 1;
  bool isGone = false;
  const auto built = buildPyramid(build_, [&](const BuildProgress&) {
    if (!isGone) fs::rename(input_, folder_ / "away");
    isGone = true;
  });
  ASSERT_TRUE(built.has_value()) << io::describe(built.error());
  EXPECT_EQ(bytesOf(build_.output), bytesOf(whole_.output));
}

}  // namespace
}  // namespace tellurion::pyramid::testing
