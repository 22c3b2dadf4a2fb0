#include "app/leading.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "scene/scene_identity.h"

namespace tellurion::app {

io::Result<Leading> Leading::begin(const StepArguments& arguments, const scene::Scene& scene,
                                   std::function<void()> wake) {
  const auto address = io::parseNetAddress(arguments.lead);
  if (!address) return tl::unexpected(address.error());
  auto secret = readStepSecret(arguments);
  if (!secret) return tl::unexpected(secret.error());
  Leading leading;
  auto leader = io::StepLeader::listen({.address = *address,
                                        .secret = std::move(*secret),
                                        .greeting = scene::identityOf(scene),
                                        .patience = std::chrono::milliseconds(arguments.patience_ms),
                                        .wake = std::move(wake)});
  if (!leader) return tl::unexpected(leader.error());
  leading.leader_ = std::move(*leader);
  auto log = FramesLog::open(arguments.framesLog);
  if (!log) return tl::unexpected(log.error());
  leading.log_ = std::move(*log);
  fmt::print(stderr, "leads on {}\n", io::formatNetAddress({.host = address->host, .port = leading.leader_->port()}));
  return leading;
}

void Leading::publish(scene::LedPicture picture) {
  const std::uint64_t frame = leader_->publish(encode(picture));
  published_ = Published{.frame = frame, .picture = std::move(picture)};
}

std::optional<double> Leading::release(bool isComplete) {
  if (!published_) return std::nullopt;
  const auto before = std::chrono::steady_clock::now();
  leader_->release();
  const std::chrono::duration<double, std::milli> waited = std::chrono::steady_clock::now() - before;
  if (log_) log_->add(published_->frame, published_->picture, true, isComplete);
  published_.reset();
  return waited.count();
}

std::optional<std::string> Leading::tellNews() {
  const auto news = leader_->news();
  for (const std::string& each : news)
    fmt::print(stderr, "{}\n", each);
  return news.empty() ? std::nullopt : std::optional(news.back());
}

std::string Leading::status() const {
  const auto counts = leader_->counts();
  const std::string text = fmt::format("{} follower{}", counts.followers, counts.followers == 1 ? "" : "s");
  const int late = counts.followers - counts.inStep;
  return late > 0 ? text + fmt::format(", {} late", late) : text;
}

}  // namespace tellurion::app
