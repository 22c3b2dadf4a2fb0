#include "io/byte_cache.h"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>

#include "io/fault_server_test.h"

namespace tellurion::io {
namespace {

constexpr std::uint64_t kAmple = std::uint64_t{1} << 30;
constexpr UnixSeconds kFarAhead = 4'000'000'000;

CacheKey keyOf(int i) {
  return {.dataset = "set", .url = "http://host/" + std::to_string(i)};
}

// What belongs to an entry follows from its number, so any entry can be told right from wrong.
std::string contentOf(int i) {
  return noise(static_cast<std::size_t>(200 + i * 7919 % 30'000), static_cast<unsigned>(i));
}

CacheEntry entryOf(int i) {
  const std::string text = contentOf(i);
  const auto bytes = std::as_bytes(std::span(text));
  return {.resource = std::make_shared<Resource>(
              Resource{.bytes = {bytes.begin(), bytes.end()}, .contentType = "image/" + std::to_string(i)}),
          .etag = "\"" + std::to_string(i) + "\"",
          .lastModified = "then",
          .fetched = i,
          .expires = kFarAhead + i};
}

// 1: there and right, 0: not there, -1: there and wrong.
int look(ByteCache& cache, int i) {
  const auto found = cache.find(keyOf(i));
  if (!found) return 0;
  const CacheEntry right = entryOf(i);
  const bool same = found->resource && textOf(*found->resource) == contentOf(i) &&
                    found->resource->contentType == right.resource->contentType && found->etag == right.etag &&
                    found->expires == right.expires;
  return same ? 1 : -1;
}

int countRight(const std::filesystem::path& path, int entries) {
  ByteCache cache(path, kAmple, nullptr);
  int right = 0;
  for (int i = 0; i < entries; ++i) {
    const int found = look(cache, i);
    EXPECT_GE(found, 0) << "entry " << i << " is wrong";
    right += found;
  }
  return right;
}

std::uint64_t sizeOnDisk(const std::filesystem::path& path) {
  std::uint64_t size = 0;
  for (const char* const ending : {"", "-wal"}) {
    std::error_code error;
    const std::uintmax_t part = std::filesystem::file_size(path.string() + ending, error);
    if (!error) size += part;
  }
  return size;
}

class ByteCacheTest : public testing::Test {
 protected:
  ByteCache::Warn warn() {
    return [this](const Failure& failure) {
      ++warnings;
      lastWarning = describe(failure);
    };
  }

  ScratchFolder folder;
  std::filesystem::path path = folder / "cache";
  std::atomic<int> warnings = 0;
  std::string lastWarning;
};

TEST_F(ByteCacheTest, GivesBackWhatItWasGivenAtOnceAndLater) {
  {
    ByteCache cache(path, kAmple, warn());
    for (int i = 0; i < 300; ++i) {
      cache.keep(keyOf(i), entryOf(i));
      EXPECT_EQ(look(cache, i), 1) << "not written yet";
    }
    cache.keep(keyOf(1000), {.etag = "x", .fetched = 1, .expires = 5});
    CacheKey other = keyOf(1);
    other.dataset = "other";
    EXPECT_FALSE(cache.find(other)) << "data sets are kept apart";
  }
  EXPECT_EQ(countRight(path, 300), 300);
  ByteCache cache(path, kAmple, warn());
  const auto nothing = cache.find(keyOf(1000));
  ASSERT_TRUE(nothing);
  EXPECT_EQ(nothing->resource, nullptr);
  EXPECT_EQ(nothing->expires, 5);
  EXPECT_FALSE(cache.find(keyOf(2000)));
  EXPECT_EQ(warnings, 0) << lastWarning;
}

TEST_F(ByteCacheTest, ANewerEntryReplacesTheOlder) {
  ByteCache(path, kAmple, warn()).keep(keyOf(1), entryOf(5));
  ByteCache(path, kAmple, warn()).keep(keyOf(1), {.expires = 7});
  EXPECT_EQ(ByteCache(path, kAmple, warn()).find(keyOf(1))->resource, nullptr);
  {
    ByteCache cache(path, kAmple, warn());
    cache.keep(keyOf(1), entryOf(3));
    cache.keep(keyOf(1), entryOf(1));
  }
  EXPECT_EQ(countRight(path, 2), 1);
}

TEST_F(ByteCacheTest, RenewingChangesTheTimesAlone) {
  ByteCache(path, kAmple, warn()).keep(keyOf(1), entryOf(1));
  const auto check = [](ByteCache& cache) {
    const auto found = cache.find(keyOf(1));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->fetched, 77);
    EXPECT_EQ(found->expires, 99);
    EXPECT_EQ(textOf(*found->resource), contentOf(1));
  };
  {
    ByteCache cache(path, kAmple, warn());
    cache.renew(keyOf(1), 77, 99);
    check(cache);
  }
  ByteCache cache(path, kAmple, warn());
  check(cache);
}

TEST_F(ByteCacheTest, StaysInItsBudgetAndKeepsWhatIsUsed) {
  constexpr std::uint64_t kBudget = 4 << 20;
  constexpr int kEntries = 1200;  // some 18 MB
  std::uint64_t peak = 0;
  for (int from = 0; from < kEntries; from += 60) {
    ByteCache cache(path, kBudget, warn());
    EXPECT_TRUE(from == 0 || look(cache, 7) == 1) << "the one that is looked at in every round stays";
    for (int i = from; i < from + 60; ++i) {
      cache.keep(keyOf(i), entryOf(i));
      peak = std::max(peak, sizeOnDisk(path));
    }
  }
  EXPECT_LE(std::max(peak, sizeOnDisk(path)), kBudget) << "the log beside it included";
  EXPECT_GT(sizeOnDisk(path), kBudget / 2) << "and makes use of it";
  ByteCache cache(path, kBudget, warn());
  EXPECT_LE(cache.bytes(), kBudget);
  EXPECT_GT(cache.bytes(), 0U);
  for (int i = kEntries - 60; i < kEntries; ++i)
    EXPECT_EQ(look(cache, i), 1) << i;
  int old = 0;
  for (int i = 8; i < 600; ++i)
    old += look(cache, i);
  EXPECT_EQ(old, 0) << "the oldest went first";
}

TEST_F(ByteCacheTest, ABudgetThatBecameSmallerShrinksTheFile) {
  {
    ByteCache cache(path, kAmple, warn());
    for (int i = 0; i < 500; ++i)
      cache.keep(keyOf(i), entryOf(i));
  }
  ASSERT_GT(sizeOnDisk(path), 6U << 20);
  { const ByteCache cache(path, 2 << 20, warn()); }
  EXPECT_LE(sizeOnDisk(path), 2U << 20);
  EXPECT_EQ(warnings, 0) << lastWarning;
}

TEST_F(ByteCacheTest, WhatIsTooLargeIsNotKept) {
  ByteCache cache(path, 1 << 20, warn());
  const auto large = std::make_shared<Resource>();
  large->bytes.resize(1 << 19);
  cache.keep(keyOf(1), {.resource = large, .expires = 1});
  EXPECT_FALSE(cache.find(keyOf(1)));
}

TEST_F(ByteCacheTest, AFileThatIsNoCacheIsMovedAsideOrLeftAlone) {
  folder.write("cache",
               "this is a letter to my aunt, and of no use as a cache; it was saved under that name by mistake");
  {
    ByteCache cache(path, kAmple, warn());
    cache.keep(keyOf(1), entryOf(1));
  }
  EXPECT_EQ(warnings, 1);
  EXPECT_NE(lastWarning.find("cache.damaged"), std::string::npos) << lastWarning;
  EXPECT_TRUE(std::filesystem::exists(folder / "cache.damaged"));
  EXPECT_EQ(countRight(path, 2), 1);

  // A database of somebody else is not ours to move.
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "other").c_str(), &database), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(database, "CREATE TABLE addresses (name TEXT)", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
  ByteCache cache(folder / "other", kAmple, warn());
  cache.keep(keyOf(1), entryOf(1));
  EXPECT_EQ(warnings, 2);
  EXPECT_TRUE(std::filesystem::exists(folder / "other"));
}

// Bytes overwritten anywhere: what is given is right or nothing, and the cache is of use again.
TEST_F(ByteCacheTest, DamageCostsEntriesAndNothingElse) {
  std::mt19937 random(99);
  int survivors = 0;
  for (int round = 0; round < 12; ++round) {
    constexpr int kEntries = 60;
    {
      ByteCache cache(path, kAmple, nullptr);
      for (int i = 0; i < kEntries; ++i)
        cache.keep(keyOf(i), entryOf(i));
    }
    {
      std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
      const auto size = static_cast<unsigned>(std::filesystem::file_size(path));
      for (int hit = 0; hit < 1 + round; ++hit) {
        file.seekp(static_cast<std::streamoff>(random() % size));
        file.put(static_cast<char>(random() & 0xff));
      }
    }
    {
      ByteCache cache(path, kAmple, nullptr);
      for (int i = 0; i < kEntries; ++i) {
        const auto found = cache.find(keyOf(i));
        if (found) ++survivors;
        if (!found) continue;
        EXPECT_TRUE(found->resource && textOf(*found->resource) == contentOf(i)) << "round " << round;
        EXPECT_EQ(found->etag, entryOf(i).etag) << "round " << round;
      }
    }
    ByteCache(path, kAmple, nullptr).keep(keyOf(777), entryOf(777));
    ByteCache cache(path, kAmple, nullptr);
    EXPECT_EQ(look(cache, 777), 1) << "round " << round;
  }
  EXPECT_GT(survivors, 0);
}

TEST_F(ByteCacheTest, WorksOnWhereNothingCanBeWritten) {
  folder.write("file", "");
  ByteCache cache(folder / "file" / "cache", kAmple, warn());
  for (int i = 0; i < 10; ++i) {
    cache.keep(keyOf(i), entryOf(i));
    EXPECT_GE(look(cache, i), 0);
  }
  EXPECT_EQ(warnings, 1) << "said once";
}

// What follows runs this program again, as a process of its own that may be killed.
class Child {
 public:
  Child(const char* job, const std::filesystem::path& path) {
    process_ = fork();
    if (process_ != 0) return;
    setenv("TELLURION_CACHE", path.c_str(), 1);
    const std::string filter = std::string("--gtest_filter=CacheChild.DISABLED_") + job;
    const int quiet = ::open("/dev/null", O_WRONLY);
    dup2(quiet, STDOUT_FILENO);
    execl("/proc/self/exe", "io_tests", filter.c_str(), "--gtest_also_run_disabled_tests", nullptr);
    _exit(127);
  }
  ~Child() { end(); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void kill() const { ::kill(process_, SIGKILL); }
  int end() {
    if (process_ <= 0) return status_;
    waitpid(std::exchange(process_, -1), &status_, 0);
    return status_;
  }

 private:
  pid_t process_ = -1;
  int status_ = 0;
};

std::filesystem::path childsPath() {
  const char* const path = std::getenv("TELLURION_CACHE");
  return path == nullptr ? std::filesystem::path() : path;
}

TEST(CacheChild, DISABLED_writesForEver) {
  if (childsPath().empty()) GTEST_SKIP();
  ByteCache cache(childsPath(), kAmple, nullptr);
  for (int i = 0;; i = (i + 1) % 2000) {
    cache.keep(keyOf(i), entryOf(i));
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
}

constexpr int kByEach = 400;

TEST(CacheChild, DISABLED_writesEven) {
  if (childsPath().empty()) GTEST_SKIP();
  ByteCache cache(childsPath(), kAmple, nullptr);
  for (int i = 0; i < kByEach; ++i) {
    cache.keep(keyOf(2 * i), entryOf(2 * i));
    if (i % 20 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

TEST(CacheChild, DISABLED_fillsTheDisk) {
  if (childsPath().empty()) GTEST_SKIP();
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{.rlim_cur = 300'000, .rlim_max = 300'000};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  std::atomic<int> warnings = 0;
  {
    ByteCache cache(childsPath(), kAmple, [&](const Failure&) { ++warnings; });
    for (int i = 0; i < 100; ++i) {
      cache.keep(keyOf(i), entryOf(i));
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  EXPECT_EQ(warnings, 1);
}

TEST_F(ByteCacheTest, SurvivesBeingKilledAtAnyInstant) {
  std::mt19937 random(5);
  int before = 0;
  for (int round = 0; round < 8; ++round) {
    Child child("writesForEver", path);
    std::this_thread::sleep_for(std::chrono::milliseconds(150 + random() % 300));
    child.kill();
    child.end();
    auto file = CacheFile::open(path, SqliteConnection::Mode::create);
    ASSERT_TRUE(file) << describe(file.error());
    EXPECT_TRUE(file->isSound().value_or(false));
    const int now = countRight(path, 2000);
    EXPECT_GE(now, before) << "what was written stays";
    before = now;
  }
  EXPECT_GT(before, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "cache.damaged"));
}

TEST_F(ByteCacheTest, TwoProcessesAtOnce) {
  {
    Child other("writesEven", path);
    ByteCache cache(path, kAmple, warn());
    for (int i = 0; i < kByEach; ++i) {
      cache.keep(keyOf(2 * i + 1), entryOf(2 * i + 1));
      EXPECT_GE(look(cache, 2 * i), 0);
      if (i % 20 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_EQ(other.end(), 0);
  }
  EXPECT_EQ(countRight(path, 2 * kByEach), 2 * kByEach);
  EXPECT_EQ(warnings, 0) << lastWarning;
}

TEST_F(ByteCacheTest, AFullDiskIsToldOnceAndHurtsNothing) {
  Child child("fillsTheDisk", path);
  EXPECT_EQ(child.end(), 0);
  EXPECT_GE(countRight(path, 100), 0);
}

}  // namespace
}  // namespace tellurion::io
