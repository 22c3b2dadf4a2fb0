#include "scene/source_openers.h"

#include <algorithm>
#include <utility>

namespace tellurion::scene {
namespace {

constexpr std::size_t kMostThreads = 32;
constexpr std::ptrdiff_t kMostOfAServer = 2;

/// A URL up to its path; of what is no URL all of it.
std::string_view serverOf(std::string_view name) {
  const std::size_t authority = name.find("://");
  return authority == name.npos ? name : name.substr(0, name.find_first_of("/?#", authority + 3));
}

}  // namespace

std::optional<io::Result<LayerSource::Pointer>> SourceOpeners::Opening::take() {
  if (!done_.load(std::memory_order_acquire)) return std::nullopt;
  return std::move(source_);
}

SourceOpeners::SourceOpeners(std::size_t most, Doorbell& bell)
    : bell_(bell), executor_(static_cast<int>(std::clamp<std::size_t>(kMostOfAServer * most, 1, kMostThreads))) {}

bool SourceOpeners::mayOpen(const LayerSource& source) const {
  if (source.open) return false;
  if (source.waitsFor) return source.waitsFor().empty();
  const std::string_view server = serverOf(source.name);
  return std::ranges::count_if(underway_, [&](const auto& other) {
           return other->server_ == server && !other->done_.load(std::memory_order_acquire);
         }) < kMostOfAServer;
}

std::shared_ptr<SourceOpeners::Opening> SourceOpeners::open(const LayerSource& source) {
  std::erase_if(underway_, [](const auto& other) { return other->done_.load(std::memory_order_acquire); });
  auto opening = std::make_shared<Opening>();
  if (!source.waitsFor) opening->server_ = serverOf(source.name);
  underway_.push_back(opening);
  executor_.submit(0.0, [slot = opening, how = source.opening, &bell = bell_] {
    slot->source_ = how();
    slot->done_.store(true, std::memory_order_release);
    bell.ring();
  });
  return opening;
}

}  // namespace tellurion::scene
