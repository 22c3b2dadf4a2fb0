#include <gmock/gmock.h>

#include <atomic>

#include "io/fault_server_test.h"
#include "io/resources.h"

namespace tellurion::io {
namespace {

using testing::HasSubstr;

// Each question is put to a Resources of its own, as the next run of a program would.
class ResourcesCacheTest : public testing::Test {
 protected:
  ResourcesCacheTest() {
    options.cacheFile = scratch / "cache";
    options.warn = [](const Failure& failure) { ADD_FAILURE() << describe(failure); };
  }

  Result<std::shared_ptr<const Resource>> ask(const std::string& path, const std::string& dataset = "set") {
    Resources resources(options);
    auto answer = resources.wait({.url = server.url(path), .dataset = dataset}, kPatience_s);
    last = resources.statistics();
    return answer;
  }
  // "" stands for nothing, "!" for a failure.
  std::string text(const std::string& path, const std::string& dataset = "set") {
    const auto answer = ask(path, dataset);
    return !answer ? "!" : *answer ? textOf(**answer) : "";
  }
  void header(const std::string& path, const std::string& line) {
    server.tell("set?prefix=" + path + "&header=" + line);
  }

  ScratchFolder folder;   // served
  ScratchFolder scratch;  // of the cache
  FaultServer server{folder.path()};
  ResourceOptions options = quickOptions();
  ResourceStatistics last;
};

TEST_F(ResourcesCacheTest, WhatIsFreshIsNotAskedForAgain) {
  folder.write("a.png", "first");
  EXPECT_EQ(text("/a.png"), "first");
  folder.write("a.png", "second");
  for (int i = 0; i < 3; ++i) {
    const auto answer = ask("/a.png");
    ASSERT_TRUE(answer && *answer);
    EXPECT_EQ(textOf(**answer), "first");
    EXPECT_EQ((*answer)->contentType, "image/png");
    EXPECT_EQ(last.requests, 0U);
    EXPECT_EQ(last.fromCache, 1U);
    EXPECT_GT(last.cacheBytes, 0U);
  }
  EXPECT_EQ(server.count("/a.png"), 1);
  EXPECT_EQ(text("/a.png", "another data set"), "second");
}

TEST_F(ResourcesCacheTest, WhatHasExpiredIsAskedForWithACondition) {
  for (const std::string& line :
       {std::string("Cache-Control:max-age=0"), std::string("Cache-Control:no-cache"), std::string("Expires:0")}) {
    const std::string path = "/" + std::to_string(line.size());
    folder.write(path.substr(1), "first");
    header(path, line);
    server.tell("reset");
    for (int i = 0; i < 4; ++i)
      EXPECT_EQ(text(path), "first");
    EXPECT_EQ(server.count(path), 4);
    EXPECT_EQ(server.state()["not_modified"], 3);
    EXPECT_EQ(server.state()["bytes"], 5) << "the body came once";
    folder.write(path.substr(1), "changed");
    EXPECT_EQ(text(path), "changed");
    EXPECT_EQ(last.failedRequests, 0U);
  }
}

TEST_F(ResourcesCacheTest, WhatIsForgottenIsAskedForAgainAndNotFoundOffline) {
  for (const bool isWritten : {false, true}) {  // in the file already, or still waiting to be
    folder.write("a", "spoilt");
    ASSERT_EQ(text("/a"), "spoilt");
    {
      Resources resources(options);
      const ResourceRequest request{.url = server.url("/a"), .dataset = "set"};
      ASSERT_TRUE(resources.wait(request, kPatience_s));
      folder.write("a", "well");
      resources.forget(request);
      resources.forget({.url = server.url("/never"), .dataset = "set"});
      if (!isWritten) {
        const auto answer = resources.wait(request, kPatience_s);
        ASSERT_TRUE(answer && *answer);
        EXPECT_EQ(textOf(**answer), "well");
        resources.forget(request);
      }
    }
    options.offline = true;
    EXPECT_EQ(text("/a"), "!");
    options.offline = false;
    EXPECT_EQ(text("/a"), "well");
    options.cacheFile += "2";
  }
}

TEST_F(ResourcesCacheTest, TheFileIsPrivateAndTellsNoCredentials) {
  namespace fs = std::filesystem;
  const auto isPrivate = [](const fs::path& path) {
    return (fs::status(path).permissions() & (fs::perms::group_all | fs::perms::others_all)) == fs::perms::none;
  };
  folder.write("a", "of me");
  std::string url = server.url("/a?access_token=opensesame");
  url.insert(url.find("://") + 3, "someone:hunter2@");
  for (const bool isOld : {false, true}) {
    if (isOld) fs::permissions(options.cacheFile, fs::perms::others_read, fs::perm_options::add);
    Resources resources(options);
    ASSERT_TRUE(resources.wait({.url = url, .dataset = "set"}, kPatience_s));
    ASSERT_TRUE(eventually([&] { return resources.statistics().cacheBytes > 0; }));
    for (const auto& entry : fs::directory_iterator(scratch.path())) {
      EXPECT_TRUE(isPrivate(entry.path())) << entry.path();
      std::ifstream file(entry.path(), std::ios::binary);
      const std::string bytes((std::istreambuf_iterator<char>(file)), {});
      for (const char* secret : {"someone", "hunter2", "opensesame"})
        EXPECT_EQ(bytes.find(secret), std::string::npos) << secret << " in " << entry.path();
    }
  }
  // What was kept is found by who has the same, and by nobody else.
  options.offline = true;
  const auto isKept = [&](const std::string& other) {
    return Resources(options).wait({.url = other, .dataset = "set"}, kPatience_s).has_value();
  };
  EXPECT_TRUE(isKept(url));
  std::string another = url;
  another.replace(another.find("hunter2"), 7, "hunter3");
  EXPECT_FALSE(isKept(another));
  EXPECT_FALSE(isKept(server.url("/a?access_token=opensesame")));
}

TEST_F(ResourcesCacheTest, LastModifiedIsAConditionToo) {
  folder.write("a", "first");
  server.tell("set?prefix=/a&header=Cache-Control:max-age=0&header=ETag:");
  EXPECT_EQ(text("/a"), "first");
  EXPECT_EQ(text("/a"), "first");
  EXPECT_EQ(server.state()["not_modified"], 1);
}

// A 304 that says for how long makes the entry fresh for so long.
TEST_F(ResourcesCacheTest, WhatIsStillGoodIsFreshAgain) {
  folder.write("a", "first");
  header("/a", "Cache-Control:max-age=0");
  EXPECT_EQ(text("/a"), "first");
  header("/a", "Cache-Control:max-age=1000");
  EXPECT_EQ(text("/a"), "first");
  EXPECT_EQ(text("/a"), "first");
  EXPECT_EQ(server.count("/a"), 2);
}

TEST_F(ResourcesCacheTest, NoStoreIsHonoured) {
  folder.write("a", "first");
  header("/a", "Cache-Control:no-store");
  EXPECT_EQ(text("/a"), "first");
  EXPECT_EQ(text("/a"), "first");
  EXPECT_EQ(server.count("/a"), 2);
  EXPECT_EQ(server.state()["not_modified"], 0);
}

TEST_F(ResourcesCacheTest, WhatIsNotThereIsRememberedAcrossRuns) {
  EXPECT_EQ(text("/a"), "");
  EXPECT_EQ(text("/a"), "");
  EXPECT_EQ(server.count("/a"), 1);
  header("/b", "Cache-Control:max-age=0");
  EXPECT_EQ(text("/b"), "");
  EXPECT_EQ(text("/b"), "") << "for some minutes at the least";
  EXPECT_EQ(server.count("/b"), 1);
}

TEST_F(ResourcesCacheTest, OfflineGivesWhateverIsThereHoweverOld) {
  folder.write("old", noise(5000, 1));
  header("/old", "Cache-Control:max-age=0");
  const std::string before = text("/old");
  EXPECT_EQ(text("/missing"), "");
  server.tell("dead");
  options.offline = true;
  EXPECT_EQ(text("/old"), before);
  EXPECT_EQ(text("/missing"), "");
  EXPECT_EQ(last.requests, 0U);
  const auto unknown = ask("/unknown");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, Failure::Code::notFound);
}

TEST_F(ResourcesCacheTest, OldIsBetterThanNothingWhileTheServerFails) {
  folder.write("old", "old");
  header("/old", "Cache-Control:max-age=0");
  EXPECT_EQ(text("/old"), "old");
  server.tell("set?prefix=/old&fault=status&code=500");
  EXPECT_EQ(text("/old"), "old");
  server.tell("dead");
  EXPECT_EQ(text("/old"), "old");
  EXPECT_EQ(last.requests, 1U);
}

TEST_F(ResourcesCacheTest, BadBytesAreNotKept) {
  folder.write("a", "good");
  server.tell("set?prefix=/a&fault=html&times=3");
  const ResourceRequest request{
      .url = server.url("/a"), .dataset = "set", .check = [](const Resource& resource) -> Result<bool> {
        if (textOf(resource) == "good") return true;
        return fail(Failure::Code::corrupt, "a page and not a tile");
      }};
  {
    Resources resources(options);
    const auto answer = resources.wait(request, 0.02);
    EXPECT_TRUE(answer || answer.error().message.find("a page and not a tile") != std::string::npos ||
                answer.error().message.find("did not come") != std::string::npos);
  }
  Resources resources(options);
  const auto answer = resources.wait(request, kPatience_s);
  ASSERT_TRUE(answer && *answer);
  EXPECT_EQ(textOf(**answer), "good");
}

TEST_F(ResourcesCacheTest, LocalFilesAreNotKept) {
  folder.write("a", "first");
  Resources resources(options);
  const ResourceRequest request{.url = "file://" + (folder / "a").string()};
  EXPECT_EQ(textOf(**resources.wait(request, kPatience_s)), "first");
  folder.write("a", "second");
  EXPECT_EQ(textOf(**resources.wait(request, kPatience_s)), "second");
  EXPECT_EQ(resources.statistics().fromCache, 0U);
}

TEST_F(ResourcesCacheTest, WithoutAUsableCacheEverythingElseWorks) {
  folder.write("a", "first");
  scratch.write("file", "");
  options.cacheFile = scratch / "file" / "cache";
  std::atomic<int> warnings = 0;
  options.warn = [&](const Failure& failure) {
    ++warnings;
    EXPECT_THAT(describe(failure), HasSubstr("not kept"));
  };
  EXPECT_EQ(text("/a"), "first");
  EXPECT_EQ(warnings, 1);
}

// Two programs at once on one cache file, each with the other's bytes.
TEST_F(ResourcesCacheTest, TwoAtOnceShareWhatTheyHave) {
  for (int i = 0; i < 40; ++i)
    folder.write(std::to_string(i), noise(3000, static_cast<unsigned>(i)));
  Resources first(options);
  Resources second(options);
  for (int i = 0; i < 40; ++i) {
    const std::string path = "/" + std::to_string(i);
    Resources& one = i % 2 == 0 ? first : second;
    ASSERT_TRUE(one.wait({.url = server.url(path)}, kPatience_s));
  }
  for (Resources* const one : {&first, &second})
    for (int i = 0; i < 40; ++i) {
      const ResourceRequest request{.url = server.url("/" + std::to_string(i))};
      EXPECT_EQ(textOf(**one->wait(request, kPatience_s)), noise(3000, static_cast<unsigned>(i)));
    }
  std::uint64_t came = 0;
  for (const Resources* one : {&first, &second}) {
    const ResourceStatistics s = one->statistics();
    came += s.fromCache + s.requests - s.failedRequests;  // on a busy machine an answer stalls, and is asked for again
  }
  EXPECT_EQ(came, 120U);
}

}  // namespace
}  // namespace tellurion::io
