#include "io/output_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

namespace tellurion::io {
namespace {

namespace fs = std::filesystem;

class OutputFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / fmt::format("tellurion_{}_{}", test->name(), std::random_device{}());
    ASSERT_TRUE(fs::create_directory(folder_));
  }
  ~OutputFile() override { fs::remove_all(folder_); }
  static std::string contentOf(const fs::path& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }
  fs::path folder_;
};

TEST_F(OutputFile, WhatCannotBeWrittenIsKnownBefore) {
  EXPECT_TRUE(checkOutput(folder_ / "new.txt"));
  EXPECT_TRUE(checkOutput("in_this_folder.txt"));
  EXPECT_TRUE(checkOutput("/dev/null"));
  fs::create_directory(folder_ / "a.png");
  const auto isFolder = checkOutput(folder_ / "a.png");
  ASSERT_FALSE(isFolder);
  EXPECT_EQ(isFolder.error().where, (folder_ / "a.png").string());
  const auto absent = checkOutput(folder_ / "absent/a.txt");
  ASSERT_FALSE(absent);
  EXPECT_NE(absent.error().message.find("mkdir -p '" + (folder_ / "absent").string() + "'"), std::string::npos);
  EXPECT_FALSE(checkOutput("/proc/new.txt")) << "whoever asks";
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "nothing is left of the asking";
}

TEST_F(OutputFile, ThereIsAWholeFileOrTheFormerOne) {
  const fs::path path = folder_ / "text";
  ASSERT_TRUE(writeWhole(path, "former"));
  EXPECT_EQ(contentOf(path), "former");
  const auto failed = writeWhole(path, [&](const fs::path& part) -> Result<void> {
    std::ofstream(part) << "hal";
    EXPECT_EQ(contentOf(path), "former");
    return fail(Failure::Code::ioError, "no room for " + part.string(), part.string());
  });
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().where, path.string());
  EXPECT_EQ(failed.error().message, "no room for " + path.string());
  EXPECT_EQ(contentOf(path), "former");
  ASSERT_TRUE(writeWhole(path, "latter"));
  EXPECT_EQ(contentOf(path), "latter");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
  EXPECT_FALSE(writeWhole(folder_ / "absent/text", "x"));
}

TEST_F(OutputFile, ADeviceIsWrittenToAndNeverReplaced) {
  const fs::path device = folder_ / "null";  // a link, so that a failing test cannot harm the machine
  fs::create_symlink("/dev/null", device);
  EXPECT_TRUE(isDevice(device));
  EXPECT_TRUE(writeWhole(device, "x"));
  EXPECT_TRUE(fs::is_symlink(device));
  EXPECT_FALSE(writeWhole("/dev/full", std::string(10'000, 'x')));
}

}  // namespace
}  // namespace tellurion::io
