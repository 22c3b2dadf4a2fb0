// A leader and its followers over loopback, and what others send them.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "io/fault_server_test.h"
#include "io/socket.h"
#include "io/step_follower.h"
#include "io/step_leader.h"
#include "io/step_wire.h"

namespace tellurion::io {
namespace {

using std::chrono::milliseconds;
using Status = StepFollower::Status;

constexpr const char* kSecret = "sixteen bytes or more";
constexpr milliseconds kLong{60000};

std::string stateOf(std::uint64_t frame) {
  return "state " + std::to_string(frame);
}

/// One that draws whatever comes, on a thread of its own.
class Drawing {
 public:
  explicit Drawing(StepFollowerOptions options) : link_(StepFollower::follow(std::move(options)).value()) {
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }
  std::uint64_t frame() const { return frame_; }  ///< that it has shown
  int count() const { return count_; }
  int wrong() const { return wrong_; }  ///< not a later one, or not what was published
  /// How long a picture takes.
  std::atomic<int> pace_ms = 0;

 private:
  void run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      const auto step = link_->newest();
      if (!step) {
        std::this_thread::sleep_for(milliseconds(1));
        continue;
      }
      if (step->frame <= frame_ || step->state != stateOf(step->frame)) ++wrong_;
      std::this_thread::sleep_for(milliseconds(pace_ms));
      link_->ready(*step, false);
      link_->awaitRelease(*step, milliseconds(500));
      frame_ = step->frame;
      ++count_;
    }
  }

  std::unique_ptr<StepFollower> link_;
  std::atomic<std::uint64_t> frame_ = 0;
  std::atomic<int> count_ = 0;
  std::atomic<int> wrong_ = 0;
  std::jthread thread_;
};

/// A leader that counts what it publishes.
class Showing {
 public:
  explicit Showing(StepLeaderOptions options) : leader_(StepLeader::listen(std::move(options)).value()) {}
  StepLeader& operator*() { return *leader_; }
  StepLeader* operator->() { return leader_.get(); }
  std::uint64_t show() {
    EXPECT_EQ(leader_->publish(stateOf(frame_ + 1)), frame_ + 1);
    leader_->release();
    return ++frame_;
  }
  StepFollowerOptions followed(const std::string& secret = "") const {
    return {.leader = {.port = leader_->port()}, .secret = secret};
  }
  /// Until so many are in step.
  bool inStep(int followers) {
    return eventually([&] {
      show();
      return leader_->counts().inStep == followers;
    });
  }

 private:
  std::unique_ptr<StepLeader> leader_;
  std::uint64_t frame_ = 0;
};

/// The last of the news, once it is refused.
std::string whyRefused(const StepFollowerOptions& options) {
  const auto link = StepFollower::follow(options).value();
  EXPECT_TRUE(eventually([&] { return link->status() == Status::refused; }));
  const auto news = link->news();
  return news.empty() ? "" : news.back();
}

class StepLink : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(, StepLink, testing::Values("", kSecret),
                         [](const auto& one) { return *one.param == '\0' ? "open" : "underASecret"; });

TEST_P(StepLink, threeShowEveryFrame) {
  Showing leader({.secret = GetParam(), .patience = kLong});
  std::vector<std::unique_ptr<Drawing>> all;
  for (int i = 0; i < 3; ++i)
    all.push_back(std::make_unique<Drawing>(leader.followed(GetParam())));
  ASSERT_TRUE(leader.inStep(3));
  std::vector<int> before;
  for (const auto& each : all)
    before.push_back(each->count());
  constexpr int kFrames = 60;
  for (int i = 0; i < kFrames; ++i) {
    const std::uint64_t frame = leader.show();
    for (const auto& each : all)
      EXPECT_GE(each->frame() + 1, frame) << "released before it was drawn";
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_TRUE(eventually([&] { return all[i]->count() - before[i] >= kFrames; }));
    EXPECT_EQ(all[i]->wrong(), 0);
  }
}

TEST_P(StepLink, nobodyWaitsForOneThatIsSlowAndItCatchesUpWithTheNewest) {
  Showing leader({.secret = GetParam(), .patience = milliseconds(300)});
  Drawing quick(leader.followed(GetParam()));
  Drawing slow(leader.followed(GetParam()));
  ASSERT_TRUE(leader.inStep(2));
  slow.pace_ms = 1000;
  ASSERT_TRUE(eventually([&] {
    leader.show();
    return leader->counts().inStep == 1;
  }));
  const int before = slow.count();
  std::uint64_t last = 0;
  for (int i = 0; i < 60; ++i)
    last = leader.show();
  slow.pace_ms = 0;
  EXPECT_TRUE(eventually([&] { return slow.frame() >= last; }));
  EXPECT_LT(slow.count() - before, 60) << "old frames were played";
  EXPECT_TRUE(leader.inStep(2));
  EXPECT_EQ(slow.wrong() + quick.wrong(), 0);
}

TEST_P(StepLink, whoComesLateGetsTheNewestAndWhoGoesIsNotWaitedFor) {
  Showing leader({.secret = GetParam(), .patience = kLong});
  const std::uint64_t last = leader.show();
  {
    Drawing late(leader.followed(GetParam()));
    EXPECT_TRUE(eventually([&] { return late.frame() == last; })) << "without another frame";
    EXPECT_TRUE(eventually([&] { return leader->wantsFrame(); }));
    ASSERT_TRUE(leader.inStep(1));
  }
  leader.show();  // or it would take a minute
  EXPECT_TRUE(eventually([&] { return leader->counts().followers == 0; }));
}

TEST_P(StepLink, aLeaderThatComesBackIsFound) {
  auto leader = std::make_unique<Showing>(StepLeaderOptions{.secret = GetParam()});
  const StepFollowerOptions options = leader->followed(GetParam());
  const auto link = StepFollower::follow(options).value();
  ASSERT_TRUE(eventually([&] { return link->status() == Status::following; }));
  leader.reset();
  ASSERT_TRUE(eventually([&] { return link->status() == Status::lost; }));
  EXPECT_NE(link->news().back().find("is lost"), std::string::npos);
  leader = std::make_unique<Showing>(StepLeaderOptions{.address = {.port = options.leader.port}, .secret = GetParam()});
  leader->show();
  ASSERT_TRUE(eventually([&] { return link->status() == Status::following; }));
  EXPECT_TRUE(eventually([&] { return link->newest().has_value(); }));
}

TEST(StepDoor, theSecretHasToBeTheSame) {
  Showing guarded({.secret = kSecret});
  EXPECT_NE(whyRefused(guarded.followed("another of their bytes")).find("another secret"), std::string::npos);
  EXPECT_NE(whyRefused(guarded.followed()).find("asks for a secret"), std::string::npos);
  Showing open({});
  EXPECT_NE(whyRefused(open.followed(kSecret)).find("has no secret"), std::string::npos);
  EXPECT_EQ(guarded->counts().followers, 0);
}

TEST(StepDoor, withoutASecretOnlyThisMachineIsListenedTo) {
  for (const char* host : {"0.0.0.0", "::"}) {
    const auto leader = StepLeader::listen({.address = {.host = host}});
    ASSERT_FALSE(leader);
    if (leader.error().code == Failure::Code::invalidArgument) {  // else no IPv6 here
      EXPECT_NE(leader.error().message.find("secret"), std::string::npos);
    }
    const auto guarded = StepLeader::listen({.address = {.host = host}, .secret = kSecret});
    EXPECT_TRUE(guarded || guarded.error().code == Failure::Code::ioError);
  }
}

TEST(StepDoor, overIpv6Too) {
  auto leader = StepLeader::listen({.address = {.host = "::1"}});
  if (!leader) GTEST_SKIP() << describe(leader.error());
  const auto link = StepFollower::follow({.leader = {.host = "::1", .port = (*leader)->port()}}).value();
  EXPECT_TRUE(eventually([&] { return link->status() == Status::following; }));
}

TEST(StepDoor, aPortThatIsTakenIsTold) {
  Showing leader({});
  const auto second = StepLeader::listen({.address = {.port = leader->port()}});
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message.find("another program has this port"), std::string::npos);
}

TEST(StepDoor, aLeaderThatDoesNotSuitIsNotFollowed) {
  Showing leader({.greeting = "mars"});
  StepFollowerOptions options = leader.followed();
  options.check = [](std::string_view greeting) -> Result<void> {
    return fail(Failure::Code::invalidArgument, std::string(greeting) + " is not this scene");
  };
  EXPECT_NE(whyRefused(options).find("mars is not this scene"), std::string::npos);
}

TEST(StepDoor, noMoreFollowThanMay) {
  Showing leader({.mostFollowers = 1});
  const auto first = StepFollower::follow(leader.followed()).value();
  ASSERT_TRUE(eventually([&] { return first->status() == Status::following; }));
  EXPECT_NE(whyRefused(leader.followed()).find("as many followers"), std::string::npos);
}

/// Says what it is told, and hears nothing.
class Stranger {
 public:
  explicit Stranger(std::uint16_t port) : socket_(std::move(*Socket::connectTo({.port = port}, 0).value())) {
    EXPECT_TRUE(eventually([&] { return socket_.connectionProblem().empty(); }));
  }
  void say(std::string_view bytes) const {
    EXPECT_TRUE(eventually([&] {
      const auto sent = socket_.send(bytes);
      if (sent) bytes.remove_prefix(*sent);
      return !sent || bytes.empty();
    }));
  }
  /// The other side has closed.
  bool isDismissed() const {
    return eventually([&] { return !socket_.receive(); });
  }

 private:
  Socket socket_;
};

TEST(StepDoor, strangersDisturbNobody) {
  Showing leader({.patience = kLong});
  Drawing good(leader.followed());
  ASSERT_TRUE(leader.inStep(1));
  StepSealer seal;
  const StepHello hello{};
  const std::string joined = seal.seal(StepKind::hello, encode(hello)) + seal.seal(StepKind::join);
  const std::vector<std::string> all{
      "GET / HTTP/1.1\r\nHost: x\r\n\r\n",
      noise(5000, 1),
      std::string(64 * 1024, '\0'),
      std::string(200, '\xff'),
      seal.seal(StepKind::join),
      seal.seal(StepKind::hello, encode(StepHello{.version = 77})),
      seal.seal(StepKind::hello, encode(hello)) + seal.seal(StepKind::ready, encodeNumber(1, "x")),
      joined + seal.seal(StepKind::ready, encodeNumber(1u << 30, "x")),
      joined + seal.seal(StepKind::ready, "short"),
      joined + seal.seal(StepKind::frame, encodeNumber(9)),
      joined + joined,
      joined + seal.seal(StepKind::ready, encodeNumber(1, std::string(50, 'x'))),
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Stranger stranger(leader->port());
    stranger.say(all[i]);
    EXPECT_TRUE(stranger.isDismissed()) << i;
  }
  const Stranger silent(leader->port());  // and one that takes its time
  silent.say(joined.substr(0, 5));
  EXPECT_TRUE(silent.isDismissed());
  for (int i = 0; i < 20; ++i)
    leader.show();
  EXPECT_TRUE(leader.inStep(1));
  EXPECT_EQ(good.wrong(), 0);
}

/// Followers bear a leader that is none: they look on, or say what is wrong.
TEST(StepDoor, whatIsNoLeaderIsNotFollowed) {
  const auto listener = Socket::listenOn({}).value();
  StepSealer seal;
  const std::string hello = seal.seal(StepKind::hello, encode(StepHello{}));
  for (const std::string& said :
       {noise(100, 2), std::string("SSH-2.0-OpenSSH_9.2\r\n"), seal.seal(StepKind::welcome), hello + noise(100, 3),
        hello + seal.seal(StepKind::ready, "x"), hello + seal.seal(StepKind::refused, "\xee"), std::string()}) {
    const auto link = StepFollower::follow({.leader = {.port = listener.port()}}).value();
    std::optional<Socket> other;
    ASSERT_TRUE(eventually([&] { return (other = listener.accept()).has_value(); }));
    ASSERT_TRUE(other->send(said));
    if (said.empty()) other.reset();
    EXPECT_TRUE(eventually([&] { return !link->news().empty(); }));
    EXPECT_NE(link->status(), Status::following);
  }
}

}  // namespace
}  // namespace tellurion::io
