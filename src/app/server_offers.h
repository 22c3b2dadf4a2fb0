#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "raster/service_offers.h"

namespace tellurion::app {

/// Asks servers what they offer, each on a thread of its own that nobody waits for. One thread only.
class ServerOffers {
 public:
  using Answer = io::Result<raster::ServiceOffers>;

  /// offline: nothing is asked, and that is the answer. wake: called from another thread once an answer is here.
  ServerOffers(bool offline, std::function<void()> wake);
  ~ServerOffers();  ///< ends what is being asked
  ServerOffers(const ServerOffers&) = delete;
  ServerOffers& operator=(const ServerOffers&) = delete;

  /// A URL, template, file or folder as raster::listService takes it. What was asked before is not waited for any more.
  void ask(const std::string& source);
  bool isAsking() const { return current_ != nullptr; }
  bool hasAnswer() const;  ///< take() gives it
  /// Once: the answer to the last question, nothing until it is here.
  std::optional<Answer> take();

 private:
  struct Question;
  void dismiss();

  bool offline_;
  std::function<void()> wake_;
  std::unique_ptr<Question> current_;
  std::vector<std::unique_ptr<Question>> dismissed_;  ///< until their threads have ended
};

}  // namespace tellurion::app
