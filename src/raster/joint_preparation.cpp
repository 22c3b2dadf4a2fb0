#include "raster/joint_preparation.h"

#include <mutex>
#include <utility>

namespace tellurion::raster {
namespace {

struct Count {
  std::mutex mutex;  ///< held while parts begin, so that none is counted before all are known
  std::size_t pending = 0;
  std::function<void()> ready;
};

}  // namespace

std::unique_ptr<Preparation> JointPreparation::begin(std::span<const Part> parts, double priority,
                                                     std::function<void()> ready) {
  const auto count = std::make_shared<Count>();
  count->ready = std::move(ready);
  const auto oneIsReady = [count] {
    bool done = false;
    {
      const std::scoped_lock lock(count->mutex);
      done = --count->pending == 0;
    }
    if (done) count->ready();
  };
  std::vector<std::unique_ptr<Preparation>> begun;
  const std::scoped_lock lock(count->mutex);
  for (const Part& part : parts) {
    if (auto preparation = part(priority, oneIsReady)) begun.push_back(std::move(preparation));
  }
  count->pending = begun.size();
  if (begun.empty()) return nullptr;
  return std::unique_ptr<Preparation>(new JointPreparation(std::move(begun)));
}

void JointPreparation::setPriority(double priority) {
  for (const auto& part : parts_)
    part->setPriority(priority);
}

}  // namespace tellurion::raster
