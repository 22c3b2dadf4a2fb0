#include "io/resources.h"

#include <gmock/gmock.h>

#include <atomic>
#include <deque>
#include <list>

#include "io/fault_server_test.h"
#include "io/other_threads_test.h"
#include "io/url_secrets.h"

namespace tellurion::io {
namespace {

using testing::HasSubstr;

class ResourcesTest : public testing::Test {
 protected:
  ScratchFolder folder;
  FaultServer server{folder.path()};
};

TEST_F(ResourcesTest, BringsBytesAndTheirType) {
  folder.write("picture.png", noise(300'000, 1));
  Resources resources(quickOptions());
  const auto answer = resources.wait({.url = server.url("/picture.png")}, kPatience_s);
  ASSERT_TRUE(answer) << describe(answer.error());
  ASSERT_NE(*answer, nullptr);
  EXPECT_EQ(textOf(**answer), noise(300'000, 1));
  EXPECT_EQ((*answer)->contentType, "image/png");
  EXPECT_EQ(resources.statistics().requests, 1U);
  EXPECT_EQ(resources.statistics().failedRequests, 0U);
  EXPECT_GE(resources.statistics().receivedBytes, 300'000U);
  EXPECT_EQ(resources.statistics().waiting, 0U);
}

TEST_F(ResourcesTest, UnpacksAndFollowsRedirects) {
  folder.write("a.txt", std::string(100'000, 'x'));
  server.tell("set?prefix=/a.txt&fault=gzip");
  server.tell("set?prefix=/moved&fault=redirect&to=/a.txt");
  Resources resources(quickOptions());
  const auto answer = resources.wait({.url = server.url("/moved")}, kPatience_s);
  ASSERT_TRUE(answer && *answer);
  EXPECT_EQ(textOf(**answer), std::string(100'000, 'x'));
  EXPECT_LT(resources.statistics().receivedBytes, 200'000U);
}

TEST_F(ResourcesTest, ARedirectLeadsToNoFile) {
  folder.write("secret", "s");
  server.tell("set?prefix=/moved&fault=redirect&to=file://" + (folder / "secret").string());
  Resources resources(quickOptions());
  const auto answer = resources.wait({.url = server.url("/moved")}, kPatience_s);
  ASSERT_FALSE(answer);
  EXPECT_EQ(server.count("/moved"), 1);
}

TEST_F(ResourcesTest, WhatIsNotThereIsNullAndNotAskedForAgain) {
  server.tell("set?prefix=/204&fault=status&code=204");
  server.tell("set?prefix=/410&fault=status&code=410");
  folder.write("blank.png", "blank");
  Resources resources(quickOptions());
  for (int round = 0; round < 3; ++round)
    for (const std::string path : {"/404", "/204", "/410", "/blank.png"}) {
      const auto nothing = [](const Resource&) { return Result<bool>(false); };
      const auto answer = resources.wait({.url = server.url(path), .check = nothing}, kPatience_s);
      ASSERT_TRUE(answer) << path;
      EXPECT_EQ(*answer, nullptr);
      EXPECT_EQ(server.count(path), 1);
    }
  EXPECT_TRUE(resources.troubles().empty());
}

TEST_F(ResourcesTest, ARefusalIsFinal) {
  Resources resources(quickOptions());
  for (const int code : {400, 401, 403, 418}) {
    const std::string path = "/" + std::to_string(code);
    server.tell("set?prefix=" + path + "&fault=status&code=" + std::to_string(code));
    const auto answer = resources.wait({.url = server.url(path)}, kPatience_s);
    ASSERT_FALSE(answer);
    EXPECT_THAT(answer.error().message, HasSubstr(std::to_string(code)));
    EXPECT_EQ(answer.error().where, server.url(path));
    EXPECT_EQ(server.count(path), 1);
  }
  EXPECT_TRUE(resources.troubles().empty());
}

TEST_F(ResourcesTest, AddressesThatCannotBeAskedAreFailures) {
  Resources resources(quickOptions());
  for (const char* const url :
       {"", "nonsense", "ftp://127.0.0.1/x", "http://", "file://elsewhere/x", "http://[::1", "gopher://x"})
    EXPECT_FALSE(resources.wait({.url = url}, kPatience_s)) << url;
  EXPECT_EQ(resources.statistics().requests, 0U);
}

TEST_F(ResourcesTest, ReadsLocalFiles) {
  folder.write("with space/a.bin", noise(5000, 2));
  Resources resources(quickOptions());
  const std::string root = "file://" + folder.path().string();
  const auto there = resources.wait({.url = root + "/with%20space/a.bin"}, kPatience_s);
  ASSERT_TRUE(there && *there);
  EXPECT_EQ(textOf(**there), noise(5000, 2));
  const auto missing = resources.wait({.url = root + "/no"}, kPatience_s);
  ASSERT_TRUE(missing);
  EXPECT_EQ(*missing, nullptr);
  EXPECT_FALSE(resources.wait({.url = root + "/with%20space"}, kPatience_s)) << "a folder";
  EXPECT_FALSE(resources.wait({.url = root + "/with%20space/a.bin", .maxBytes = 4999}, kPatience_s));
  folder.write("with space/late.bin", "x");
  folder.write("no", "now it is there");
  EXPECT_TRUE(*resources.wait({.url = root + "/no"}, kPatience_s)) << "what is missing on this disk is not remembered";
}

TEST_F(ResourcesTest, AnswersOnTheirWayTakeNoMoreThanTheirBudgetAndOneOfThem) {
  constexpr std::size_t kAnswer = 400'000;
  constexpr int kAnswers = 24;
  for (int i = 0; i < kAnswers; ++i)
    folder.write(std::to_string(i), noise(kAnswer, static_cast<unsigned>(i)));
  for (int i = 0; i < kAnswers; i += 3)
    server.tell("set?prefix=/" + std::to_string(i) + "&fault=gzip");
  std::uint64_t unbounded = 0;
  for (const std::uint64_t budget : {std::uint64_t{1} << 30, std::uint64_t{500'000}}) {
    ResourceOptions options = quickOptions();
    options.inFlight_bytes = budget;
    server.tell("bandwidth?bits=100e6");  // so that all of them are on their way together
    Resources resources(options);
    std::deque<Arrival> arrivals(kAnswers);
    std::vector<Resources::Ticket> tickets;
    for (int i = 0; i < kAnswers; ++i)
      tickets.push_back(resources.get({.url = server.url("/" + std::to_string(i)),
                                       .maxBytes = 2 * kAnswer,
                                       .check = [i](const Resource& resource) -> Result<bool> {
                                         if (textOf(resource) == noise(kAnswer, static_cast<unsigned>(i))) return true;
                                         return fail(Failure::Code::corrupt, "not what was asked for");
                                       }},
                                      1.0, arrivals[static_cast<std::size_t>(i)].ready()));
    ASSERT_TRUE(eventually([&] { return resources.statistics().waiting == 0; }));
    for (int i = 0; i < kAnswers; ++i)
      EXPECT_EQ(arrivals[static_cast<std::size_t>(i)].count(), 1);
    const std::uint64_t most = resources.statistics().mostInFlight_bytes;
    EXPECT_GE(most, kAnswer);
    if (unbounded == 0) {
      unbounded = most;
      if (unbounded <= 1'000'000U) GTEST_SKIP() << "this machine has not had them under way together";
    } else {
      EXPECT_LE(most, budget + kAnswer);
    }
  }
}

TEST_F(ResourcesTest, AnAnswerThatDripsKeepsNoOtherWaitingForTheBudget) {
  constexpr std::size_t kDripping = 3000;
  constexpr std::size_t kAnswer = 200'000;
  folder.write("drips", noise(1'000'000, 1));
  server.tell("set?prefix=/drips&fault=slow&rate=500");
  ResourceOptions options = quickOptions();
  options.stallTimeout_s = 60.0;
  options.inFlight_bytes = kDripping / 2;
  Resources resources(options);
  Arrival drips;
  std::deque<Arrival> arrivals(8);
  std::vector<Resources::Ticket> tickets;
  tickets.push_back(resources.get({.url = server.url("/drips")}, 1.0, drips.ready()));
  ASSERT_TRUE(eventually([&] { return server.count("/drips") == 1; }));
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    folder.write(std::to_string(i), noise(kAnswer, static_cast<unsigned>(i)));
    tickets.push_back(resources.get({.url = server.url("/" + std::to_string(i))}, 1.0, arrivals[i].ready()));
  }
  ASSERT_TRUE(eventually([&] { return resources.statistics().waiting == 1; }));
  for (Arrival& arrival : arrivals)
    EXPECT_EQ(arrival.count(), 1);
  EXPECT_EQ(drips.count(), 0);
  // One after the other all the same.
  EXPECT_LE(resources.statistics().mostInFlight_bytes, options.inFlight_bytes + kDripping + 2 * kAnswer);
}

TEST_F(ResourcesTest, AUrlHasABound) {
  Resources resources(quickOptions());
  folder.write("a", "a");
  const std::string start = server.url("/a?");
  const auto longest = resources.wait({.url = start + std::string(kLongestUrl - start.size(), 'x')}, kPatience_s);
  EXPECT_TRUE(longest) << describe(longest.error());
  const auto longer = resources.wait({.url = start + std::string(kLongestUrl, 'x')}, kPatience_s);
  ASSERT_FALSE(longer);
  EXPECT_LT(describe(longer.error()).size(), 500U);
}

TEST_F(ResourcesTest, EqualRequestsAreOne) {
  folder.write("a", "a");
  server.tell("latency?ms=200");
  Resources resources(quickOptions());
  std::deque<Arrival> arrivals(50);
  std::vector<Resources::Ticket> tickets;
  for (Arrival& arrival : arrivals)
    tickets.push_back(resources.get({.url = server.url("/a")}, 1.0, arrival.ready()));
  tickets.erase(tickets.begin(), tickets.begin() + 10);
  ASSERT_TRUE(eventually([&] { return arrivals.back().count() > 0; }));
  ASSERT_TRUE(eventually([&] { return resources.statistics().waiting == 0; }));
  tickets.clear();
  for (std::size_t i = 0; i < arrivals.size(); ++i)
    EXPECT_EQ(arrivals[i].count(), i < 10 ? 0 : 1);
  EXPECT_EQ(server.count("/a"), 1);
}

TEST_F(ResourcesTest, TheMostUrgentGoesFirstAndMayChange) {
  ResourceOptions options = quickOptions();
  options.connectionsPerHost = 1;
  options.stallTimeout_s = 30.0;
  server.tell("set?prefix=/gate&fault=hang");
  Resources resources(options);
  Arrival arrival;
  std::vector<Resources::Ticket> tickets;
  tickets.push_back(resources.get({.url = server.url("/gate")}, 100.0, arrival.ready()));
  ASSERT_TRUE(eventually([&] { return server.count("/gate") == 1; }));
  for (const auto& [name, priority] : {std::pair{"/b", 2.0}, {"/a", 1.0}, {"/d", 4.0}, {"/c", 3.0}, {"/e", 5.0}})
    tickets.push_back(resources.get({.url = server.url(name)}, priority, arrival.ready()));
  tickets[5].setPriority(0.0);                                                         // e
  tickets[2].setPriority(10.0);                                                        // a
  tickets.push_back(resources.get({.url = server.url("/b")}, 20.0, arrival.ready()));  // the same, more urgent
  // What is looked for on disk first waits in another queue; give all of them the time to pass it.
  ASSERT_TRUE(eventually([&] { return resources.statistics().waiting == 6; }));
  ASSERT_TRUE(eventually(othersSleep));
  tickets.front() = {};
  ASSERT_TRUE(eventually([&] { return arrival.count() == 6; }));
  EXPECT_EQ(server.state()["order"], (std::vector<std::string>{"/gate", "/b", "/a", "/d", "/c", "/e"}));
}

TEST_F(ResourcesTest, FirstComeIsServedInOrderAndNothingIsCancelled) {
  ResourceOptions options = quickOptions();
  options.order = RequestOrder::firstCome;
  options.connectionsPerHost = 1;
  options.cacheFile = folder / "cache.db";
  server.tell("set?prefix=/gate&fault=slow&rate=10");
  folder.write("gate", "five!");
  for (const char* name : {"a", "b", "c"})
    folder.write(name, name);
  Resources resources(options);
  Arrival arrival;
  std::vector<Resources::Ticket> tickets;
  tickets.push_back(resources.get({.url = server.url("/gate")}, 1.0, arrival.ready()));
  for (const char* name : {"/a", "/b", "/c"})
    tickets.push_back(resources.get({.url = server.url(name)}, static_cast<double>(tickets.size()), arrival.ready()));
  tickets.back().setPriority(99.0);
  tickets[1] = {};
  tickets[0] = {};
  ASSERT_TRUE(eventually([&] { return resources.statistics().waiting == 0; }));
  EXPECT_EQ(server.state()["order"], (std::vector<std::string>{"/gate", "/a", "/b", "/c"}));
  EXPECT_EQ(arrival.count(), 2) << "of those that somebody still waits for";
  EXPECT_TRUE(resources.wait({.url = server.url("/a")}, kPatience_s));
  EXPECT_EQ(server.count("/a"), 1) << "it was kept";
}

TEST_F(ResourcesTest, CancellingFreesTheConnection) {
  ResourceOptions options = quickOptions();
  options.connectionsPerHost = 2;
  options.stallTimeout_s = 600.0;
  folder.write("a", "a");
  folder.write("slow", noise(1 << 20, 3));
  server.tell("set?prefix=/hang&fault=hang");
  server.tell("set?prefix=/slow&fault=slow&rate=2000");
  Resources resources(options);
  Arrival arrival;
  auto first = std::make_optional(resources.get({.url = server.url("/hang")}, 1.0, arrival.ready()));
  auto second = std::make_optional(resources.get({.url = server.url("/slow")}, 1.0, arrival.ready()));
  ASSERT_TRUE(eventually([&] { return server.state()["open"] == 2; }));
  first.reset();
  second.reset();
  EXPECT_TRUE(eventually([&] { return server.state()["broken"] == 2; })) << "the server sees both connections close";
  EXPECT_TRUE(resources.wait({.url = server.url("/a")}, kPatience_s));
  EXPECT_EQ(arrival.count(), 0);
}

TEST_F(ResourcesTest, ConnectionsAreBounded) {
  ResourceOptions options = quickOptions();
  options.connectionsPerHost = 3;
  for (int i = 0; i < 40; ++i)
    folder.write(std::to_string(i), noise(1000, 4));
  server.tell("latency?ms=20");
  Resources resources(options);
  Arrival arrival;
  std::vector<Resources::Ticket> tickets;
  for (int i = 0; i < 40; ++i)
    tickets.push_back(resources.get({.url = server.url("/" + std::to_string(i))}, i, arrival.ready()));
  ASSERT_TRUE(eventually([&] { return arrival.count() == 40; }));
  EXPECT_LE(server.state()["most_open"], 3);
  EXPECT_LE(server.state()["connections"], 3) << "connections are used again";
  EXPECT_EQ(server.countOfAll(), 40);
}

TEST_F(ResourcesTest, ACallbackMayAskAndLetGo) {
  folder.write("a", "a");
  folder.write("b", "b");
  Resources resources(quickOptions());
  Resources::Ticket own;
  Resources::Ticket next;
  std::atomic<bool> done = false;
  std::atomic<bool> given = false;
  own = resources.get({.url = server.url("/a")}, 1.0, [&](const auto&) {
    while (!given)
      std::this_thread::yield();
    own = {};
    next = resources.get({.url = server.url("/b")}, 1.0, [&](const auto&) { done = true; });
  });
  given = true;
  EXPECT_TRUE(eventually([&] { return done.load(); }));
}

TEST_F(ResourcesTest, NoCallbackBeginsAfterTheTicketHasGone) {
  for (int i = 0; i < 20; ++i)
    folder.write(std::to_string(i), noise(500, 5));
  Resources resources(quickOptions());
  std::mt19937 random(7);
  for (int round = 0; round < 300; ++round) {
    std::atomic<bool> gone = false;
    std::atomic<bool> late = false;
    std::optional<Resources::Ticket> ticket =
        resources.get({.url = server.url("/" + std::to_string(round % 20))}, 1.0, [&](const auto&) {
          std::this_thread::sleep_for(std::chrono::microseconds(200));
          late = gone.load();
        });
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 3000));
    ticket.reset();
    gone = true;
    ASSERT_FALSE(late);
  }
}

TEST_F(ResourcesTest, ManyThreadsAtOnce) {
  constexpr int kUrls = 60;
  for (int i = 0; i < kUrls; ++i)
    folder.write(std::to_string(i), noise(2000, static_cast<unsigned>(i)));
  ResourceOptions options = quickOptions();
  options.cacheFile = folder / "cache";
  Resources resources(options);
  std::atomic<int> wrong = 0;
  std::atomic<int> right = 0;
  const auto work = [&](unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> priority(0.0, 100.0);
    std::list<Resources::Ticket> tickets;
    for (int i = 0; i < 400; ++i) {
      const auto which = static_cast<unsigned>(random() % kUrls);
      tickets.push_back(resources.get({.url = server.url("/" + std::to_string(which))}, priority(random),
                                      [&, which](const auto& answer) {
                                        ++(answer && *answer && textOf(**answer) == noise(2000, which) ? right : wrong);
                                      }));
      if (random() % 3 == 0) tickets.pop_front();
      if (!tickets.empty()) tickets.front().setPriority(priority(random));
      if (random() % 50 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_TRUE(eventually([&] { return resources.statistics().waiting == 0; }));
  };
  std::vector<std::jthread> threads;
  for (unsigned seed = 0; seed < 3; ++seed)
    threads.emplace_back(work, seed);
  threads.clear();
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(right, 0);
}

TEST_F(ResourcesTest, DestructionDropsWhatHasNotCome) {
  server.tell("set?prefix=/&fault=hang");
  Arrival arrival;
  Resources::Ticket outlives;
  {
    Resources resources(quickOptions());
    outlives = resources.get({.url = server.url("/a")}, 1.0, arrival.ready());
    ASSERT_TRUE(eventually([&] { return server.state()["open"] == 1; }));
  }
  EXPECT_TRUE(eventually([&] { return server.state()["broken"] == 1; }));
  outlives.setPriority(2.0);
  outlives = {};
  EXPECT_EQ(arrival.count(), 0);
}

TEST_F(ResourcesTest, WaitingHasAnEndThatSaysWhy) {
  server.tell("set?prefix=/&fault=status&code=503");
  Resources resources(quickOptions());
  Arrival arrival;
  const Resources::Ticket ticket = resources.get({.url = server.url("/a")}, 1.0, arrival.ready());
  ASSERT_TRUE(eventually([&] { return !resources.troubles().empty(); }));
  const auto answer = resources.wait({.url = server.url("/a")}, 0.1);
  ASSERT_FALSE(answer);
  EXPECT_THAT(answer.error().message, HasSubstr("503"));
}

}  // namespace
}  // namespace tellurion::io
