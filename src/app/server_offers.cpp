#include "app/server_offers.h"

#include <atomic>
#include <thread>
#include <utility>

#include "io/resources.h"

namespace tellurion::app {

struct ServerOffers::Question {
  Question(std::string source, bool offline, std::function<void()> wake)
      : resources({.offline = offline}), thread([this, source = std::move(source), wake = std::move(wake)] {
          raster::ServiceLayer entry;
          entry.source = source;
          answer = raster::listService(entry, resources);
          isAnswered = true;
          wake();
        }) {}
  ~Question() { resources.cancelWaits(); }
  Question(const Question&) = delete;
  Question& operator=(const Question&) = delete;

  io::Resources resources;
  Answer answer;
  std::atomic<bool> isAnswered{false};
  std::jthread thread;  ///< last: it uses what stands above
};

ServerOffers::ServerOffers(bool offline, std::function<void()> wake) : offline_(offline), wake_(std::move(wake)) {}

ServerOffers::~ServerOffers() = default;

void ServerOffers::dismiss() {
  std::erase_if(dismissed_, [](const auto& question) { return question->isAnswered.load(); });
  if (!current_) return;
  current_->resources.cancelWaits();
  dismissed_.push_back(std::move(current_));
}

void ServerOffers::ask(const std::string& source) {
  dismiss();
  current_ = std::make_unique<Question>(source, offline_, wake_);
}

bool ServerOffers::hasAnswer() const {
  return current_ && current_->isAnswered;
}

std::optional<ServerOffers::Answer> ServerOffers::take() {
  if (!hasAnswer()) return std::nullopt;
  Answer answer = std::move(current_->answer);
  current_.reset();
  return answer;
}

}  // namespace tellurion::app
