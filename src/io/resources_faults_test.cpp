#include <gmock/gmock.h>

#include <deque>

#include "io/fault_server_test.h"
#include "io/resources.h"

namespace tellurion::io {
namespace {

using testing::HasSubstr;

// A fault that passes: how often the rule is applied, and how many requests fail by that.
struct Fault {
  const char* name;
  const char* rule;
  int times;
  int failures;
  int more = 0;  ///< may fail by what is left on the connection
};

std::ostream& operator<<(std::ostream& out, const Fault& fault) {
  return out << fault.name;
}

class FaultTest : public testing::TestWithParam<Fault> {};

// Whatever a server did, the right bytes come by themselves once it is well, and nothing else ever comes.
TEST_P(FaultTest, TheRightBytesComeInTheEnd) {
  const std::string content = noise(20'000, 11);
  const ScratchFolder folder;
  folder.write("tile.png", content);
  folder.write("small.png", noise(900, 12));
  const FaultServer server(folder.path());
  server.tell("set?prefix=/tile.png&times=" + std::to_string(GetParam().times) + "&fault=" + GetParam().rule);
  ResourceOptions options = quickOptions();
  options.cacheFile = folder / "cache";
  const ResourceRequest request{
      .url = server.url("/tile.png"), .maxBytes = 100'000, .check = [&](const Resource& resource) -> Result<bool> {
        if (textOf(resource) == content && resource.contentType == "image/png") return true;
        return fail(Failure::Code::corrupt, "not the tile");
      }};
  for (const bool again : {false, true}) {
    Resources resources(options);
    const auto answer = resources.wait(request, kPatience_s);
    ASSERT_TRUE(answer) << describe(answer.error());
    ASSERT_NE(*answer, nullptr);
    EXPECT_EQ(textOf(**answer), content);
    const int failures = static_cast<int>(resources.statistics().failedRequests);
    EXPECT_GE(failures, again ? 0 : GetParam().failures);
    EXPECT_LE(failures, again ? 0 : GetParam().failures + GetParam().more);
    EXPECT_EQ(server.countOfAll(), GetParam().times + 1) << "what is bad is not kept, what is good is kept";
    EXPECT_TRUE(resources.troubles().empty());
  }
}

INSTANTIATE_TEST_SUITE_P(All, FaultTest,
                         testing::Values(Fault{"status500", "status&code=500", 3, 3},                 //
                                         Fault{"status502", "status&code=502", 2, 2},                 //
                                         Fault{"status503", "status&code=503&retry_after=0", 2, 2},   //
                                         Fault{"status429", "status&code=429", 2, 2},                 //
                                         Fault{"notModifiedUnasked", "status&code=304", 2, 2},        //
                                         Fault{"hang", "hang", 1, 1},                                 //
                                         Fault{"hundredBytesASecond", "slow&rate=100", 1, 1},         //
                                         Fault{"truncated", "truncate", 2, 2},                        //
                                         Fault{"mislabelled", "mislabel&type=text/plain", 2, 2},      //
                                         Fault{"anotherPicture", "other&path=/small.png", 2, 2},      //
                                         Fault{"html", "html", 2, 2},                                 //
                                         Fault{"exception", "xml", 2, 2},                             //
                                         Fault{"redirectLoop", "loop", 12, 2},                        //
                                         Fault{"endless", "endless", 2, 2},                           //
                                         Fault{"lengthTooLong", "length&n=30000", 2, 2},              //
                                         Fault{"lengthTooShort", "length&n=300", 2, 2, 2},            //
                                         Fault{"lengthBeyondTheLimit", "length&n=1000000000", 2, 2},  //
                                         Fault{"bomb", "bomb&n=50000000", 2, 2},                      //
                                         Fault{"reset", "reset", 2, 2},                               //
                                         Fault{"empty", "empty", 2, 2}),
                         [](const auto& fault) { return std::string(fault.param.name); });

class HostTest : public testing::Test {
 protected:
  void ask(Resources& resources, const FaultServer& of, int count, double priority) {
    for (int i = 0; i < count; ++i)
      tickets.push_back(resources.get({.url = of.url("/" + std::to_string(i))}, priority, arrival.ready()));
  }

  ScratchFolder folder;
  FaultServer server{folder.path()};
  Arrival arrival;
  std::deque<Resources::Ticket> tickets;
};

TEST_F(HostTest, AFailingHostIsAskedOneAtATime) {
  constexpr int kUrls = 200;
  for (int i = 0; i < kUrls; ++i)
    folder.write(std::to_string(i), noise(500, 1));
  server.tell("set?prefix=/&fault=status&code=500");
  ResourceOptions options = quickOptions();
  options.firstRetry_s = 0.5;
  options.longestRetry_s = 1.0;
  Resources resources(options);
  ask(resources, server, kUrls, 1.0);
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  // Six at once, then a probe after about 0.5 s and another after 1 s more; slowness only makes them fewer.
  EXPECT_LE(server.countOfAll(), 6 + 3);
  ASSERT_EQ(resources.troubles().size(), 1U);
  EXPECT_THAT(resources.troubles().front().message, HasSubstr("500"));
  EXPECT_EQ(resources.troubles().front().where, server.url(""));
  EXPECT_EQ(arrival.count(), 0);
  server.tell("clear");
  EXPECT_TRUE(eventually([&] { return arrival.count() == kUrls; }));
  EXPECT_TRUE(resources.troubles().empty());
  const auto counts = server.state()["counts"];
  int failed = 0;
  for (const auto& count : counts)
    failed += count.get<int>() - 1;
  EXPECT_EQ(static_cast<std::uint64_t>(failed), resources.statistics().failedRequests) << "nothing came twice";
}

TEST_F(HostTest, AHostThatDiesComesBack) {
  folder.write("0", "0");
  folder.write("1", "1");
  folder.write("2", "2");
  Resources resources(quickOptions());
  ASSERT_TRUE(resources.wait({.url = server.url("/0")}, kPatience_s));
  server.tell("dead");
  ask(resources, server, 3, 1.0);
  ASSERT_TRUE(eventually([&] { return !resources.troubles().empty(); }));
  EXPECT_THAT(resources.troubles().front().message, HasSubstr("asked again in"));
  server.tell("alive");
  EXPECT_TRUE(eventually([&] { return arrival.count() == 3; }));
  EXPECT_TRUE(resources.troubles().empty());
}

TEST_F(HostTest, RetryAfterIsHonouredForTheWholeHost) {
  server.tell("set?prefix=/0&fault=status&code=429&retry_after=500");
  Resources resources(quickOptions());
  ask(resources, server, 1, 1.0);
  ASSERT_TRUE(eventually([&] { return !resources.troubles().empty(); }));
  ask(resources, server, 20, 1.0);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_EQ(server.countOfAll(), 1);
  EXPECT_THAT(resources.troubles().front().message, HasSubstr("429"));
}

TEST_F(HostTest, OneBadUrlIsNoTroubleForTheOthers) {
  for (int i = 0; i < 100; ++i)
    folder.write(std::to_string(i), noise(500, 1));
  server.tell("set?prefix=/bad&fault=status&code=500");
  ResourceOptions options = quickOptions();
  options.firstRetry_s = 30.0;
  options.longestRetry_s = 30.0;
  Resources resources(options);
  tickets.push_back(resources.get({.url = server.url("/bad")}, 9.0, arrival.ready()));
  ASSERT_TRUE(eventually([&] { return !resources.troubles().empty(); }));
  ask(resources, server, 100, 1.0);
  EXPECT_TRUE(eventually([&] { return arrival.count() == 100; }));
  EXPECT_EQ(server.count("/bad"), 1);
  ASSERT_EQ(resources.troubles().size(), 1U) << "the bad one is told of all the same";
}

// Two hosts that hang fill all connections; the third is served before either gives anything.
TEST_F(HostTest, HangingHostsDoNotHoldUpOthers) {
  constexpr int kGood = 40;
  const ScratchFolder goodFolder;
  for (int i = 0; i < kGood; ++i)
    goodFolder.write(std::to_string(i), noise(500, 1));
  const FaultServer otherHanging(folder.path());
  const FaultServer good(goodFolder.path());
  server.tell("set?prefix=/&fault=hang");
  otherHanging.tell("set?prefix=/&fault=hang");
  ResourceOptions options = quickOptions();
  options.connections = 12;
  options.stallTimeout_s = 600.0;
  Resources resources(options);
  ask(resources, server, 20, 10.0);
  ask(resources, otherHanging, 20, 10.0);
  ASSERT_TRUE(eventually([&] { return server.state()["open"] == 6 && otherHanging.state()["open"] == 6; }));
  ask(resources, good, kGood, 1.0);
  EXPECT_TRUE(eventually([&] { return arrival.count() == kGood; }));
  EXPECT_EQ(good.countOfAll(), kGood);
  EXPECT_EQ(server.state()["open"], 6);
}

TEST_F(HostTest, AStalledNameOrPortIsItsOwnTrouble) {
  folder.write("0", "0");
  Resources resources(quickOptions());
  tickets.push_back(resources.get({.url = "http://no-such-host.invalid/x"}, 10.0, arrival.ready()));
  tickets.push_back(resources.get({.url = "http://127.0.0.1:1/x"}, 10.0, arrival.ready()));
  EXPECT_TRUE(resources.wait({.url = server.url("/0")}, kPatience_s));
  ASSERT_TRUE(eventually([&] { return resources.troubles().size() == 2; }));
  EXPECT_EQ(arrival.count(), 0);
}

}  // namespace
}  // namespace tellurion::io
