#include "io/file_lock.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <string>

namespace tellurion::io {
namespace {

namespace fs = std::filesystem;

class FileLockTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_ = fs::temp_directory_path() / ("tellurion_lock_" + std::to_string(::getpid()));
  fs::path path_ = folder_ / "a.lock";
};

TEST_F(FileLockTest, OneHoldsItAtATime) {
  {
    const auto first = FileLock::tryTake(path_);
    ASSERT_TRUE(first && first->has_value());
    EXPECT_EQ((*first)->leftBy(), "");
    const auto second = FileLock::tryTake(path_);
    ASSERT_TRUE(second.has_value());
    EXPECT_FALSE(second->has_value());
  }
  const auto third = FileLock::tryTake(path_);
  ASSERT_TRUE(third && third->has_value());
  EXPECT_EQ((*third)->leftBy(), "") << "it was let go of in good order";
}

TEST_F(FileLockTest, AKilledHolderLosesItAndIsNamed) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const auto held = FileLock::tryTake(path_);
    if (held && *held) ::kill(::getpid(), SIGKILL);
    ::_exit(1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  const auto taken = FileLock::tryTake(path_);
  ASSERT_TRUE(taken && taken->has_value());
  EXPECT_TRUE((*taken)->leftBy().starts_with("process " + std::to_string(child) + " on ")) << (*taken)->leftBy();
}

TEST_F(FileLockTest, AFolderThatIsNotThereIsAFailure) {
  const auto taken = FileLock::tryTake(folder_ / "none" / "a.lock");
  ASSERT_FALSE(taken.has_value());
  EXPECT_EQ(taken.error().where, (folder_ / "none" / "a.lock").string());
}

}  // namespace
}  // namespace tellurion::io
