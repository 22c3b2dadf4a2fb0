#include "pyramid/build_run.h"

#include <utility>

#include "pyramid/geometric_error.h"

namespace tellurion::pyramid {
namespace {

using Code = io::Failure::Code;

constexpr std::uint64_t kGroupSize = 128;
constexpr std::size_t kMostFilesOfTheWalk = 256;  ///< it reads no samples
constexpr std::chrono::milliseconds kReportInterval{100};

}  // namespace

BuildRun::BuildRun(const BuildPlan& plan, TileDatabase& database, const Resources& resources,
                   const ProgressSink& progress, std::stop_token stop, const BuildCut& cut)
    : plan_(plan),
      database_(database),
      progress_(progress),
      stop_(std::move(stop)),
      cut_(cut),
      inputs_(plan, kMostFilesOfTheWalk, 0),
      budget_(memoryBudget(resources.memoryBytes, resources.jobs, plan.inputs.size())),
      blockCache_(budget_.blockCacheBytes),
      work_(resources.jobs, budget_.window) {}

io::Result<void> BuildRun::prepareBase() {
  if (!plan_.base) return {};
  auto rows = TileDatabase::open(*plan_.base, io::SqliteConnection::Mode::read);
  if (!rows) return tl::unexpected(rows.error());
  baseRows_.emplace(std::move(*rows));
  auto reader = PyramidReader::open(*plan_.base);
  if (!reader) return tl::unexpected(reader.error());
  base_.emplace(std::move(*reader));
  return {};
}

io::Result<void> BuildRun::estimate() {
  total_ = position_.done;
  if (cut_.part) return {};
  TileDatabase* base = baseRows_ ? &*baseRows_ : nullptr;
  // Blocks hold levels below their own: of those that are done nothing is taken off, for that takes a walk.
  const bool isAtBlocks = position_.level == plan_.blockLevel;
  if (isAtBlocks) total_ = 0;
  for (int level = 0; level <= (isAtBlocks ? plan_.deepestLevel : position_.level); ++level) {
    const auto count = estimatedCandidates(plan_, inputs_, base, level);
    if (!count) return tl::unexpected(count.error());
    total_ += *count;
  }
  return {};
}

io::Result<void> BuildRun::run(BuildPosition start) {
  position_ = start;
  committed_ = start;
  doneBefore_ = start.done;
  if (auto ok = prepareBase(); !ok) return ok;
  if (auto ok = estimate(); !ok) return ok;
  while (true) {
    if (auto ok = runLevel(); !ok) {
      if (groupIsOpen_) database_.rollback();
      return ok;
    }
    if (position_.level == 0 || cut_.part) return {};
    position_.level -= 1;
    position_.row = 0;
  }
}

/// What was read of a file that is written meanwhile is of no one content. So only what was read of files that are
/// still what they were is committed, and what is committed may be gone on with.
io::Result<void> BuildRun::checkInputs() const {
  for (const int input : groupInputs_) {
    if (auto ok = checkUnchanged(plan_.inputs[static_cast<std::size_t>(input)].files); !ok) return ok;
  }
  return {};
}

std::set<std::string> BuildRun::warnings() const {
  std::set<std::string> warnings = inputs_.warnings();
  for (const auto& [thread, maker] : makers_)
    warnings.merge(maker->inputs().warnings());
  return warnings;
}

/// Keeps the window of work full, writes what comes out, and commits the level's last group.
io::Result<void> BuildRun::runLevel() {
  TileWalk walk(plan_, inputs_, baseRows_ ? &*baseRows_ : nullptr, position_.level, position_.row,
                {.within = cut_.part, .stopAt = {}});
  bool isExhausted = false;
  while (!isExhausted || !work_.isEmpty()) {
    if (stop_.stop_requested()) {
      return io::fail(Code::cancelled, "stopped; the same command goes on where it was", database_.connection().path());
    }
    if (isExhausted || work_.isFull()) {
      if (auto ok = finishOldest(); !ok) return ok;
      continue;
    }
    const auto candidate = walk.next();
    if (!candidate) return tl::unexpected(candidate.error());
    isExhausted = !candidate->has_value();
    if (isExhausted) continue;
    if (auto ok = submit(**candidate); !ok) return ok;
  }
  return commitGroup();
}

io::Result<void> BuildRun::submit(const Candidate& candidate) {
  if (cut_.shards != nullptr && position_.level == plan_.startLevel()) {
    const auto made = cut_.shards->piece(candidate.id);
    if (!made) return tl::unexpected(made.error());
    return take(Candidate{.id = candidate.id, .inputs = {}, .makes = {}}, *made);
  }
  if (position_.level == plan_.blockLevel) {
    pending_.push_back(candidate);
    work_.push([this, candidate] { return makerOfThisThread().makeBlock(candidate); });
    return {};
  }
  auto task = taskFor(candidate);
  if (!task) return tl::unexpected(task.error());
  pending_.push_back(candidate);
  work_.push([this, shared = std::make_shared<const TileTask>(std::move(*task))] {
    return makerOfThisThread().make(*shared);
  });
  return {};
}

TileMaker& BuildRun::makerOfThisThread() {
  const std::scoped_lock lock(makersMutex_);
  std::unique_ptr<TileMaker>& maker = makers_[std::this_thread::get_id()];
  if (!maker) maker = std::make_unique<TileMaker>(plan_, base_ ? &*base_ : nullptr, budget_);
  return *maker;
}

io::Result<TileTask> BuildRun::taskFor(const Candidate& candidate) {
  TileTask task{
      .id = candidate.id, .inputs = candidate.inputs, .children = {}, .childDepths = {}, .beyond = {}, .deeper = {}};
  if (candidate.id.level >= plan_.deepestLevel) return task;
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    auto child = database_.read(candidate.id.child(quadrant));
    if (!child) return tl::unexpected(child.error());
    if (!*child) continue;
    auto depths = database_.depths((*child)->id);
    if (!depths) return tl::unexpected(depths.error());
    task.childDepths[static_cast<std::size_t>(quadrant)] = std::move(*depths);
    task.children[static_cast<std::size_t>(quadrant)] =
        KnownTile{.record = std::move(**child), .heights = nullptr, .pixels = nullptr};
  }
  if (plan_.meta.kind != raster::Kind::elevation) return task;
  // Where voids are filled, a neighbour's samples may be of a deeper level than this tile has, beside its edge too.
  if (!task.hasChildren() && plan_.meta.fillVoids_m == 0.0) return task;
  if (auto ok = readBeyond(task); !ok) return tl::unexpected(ok.error());
  if (auto ok = readDeeper(task); !ok) return tl::unexpected(ok.error());
  return task;
}

/// The stored tiles from the grandchildren down to the last level that the error is measured against.
io::Result<void> BuildRun::readDeeper(TileTask& task) {
  struct Parent {
    tiling::TileId id;
    std::uint8_t childMask;
  };
  std::vector<Parent> parents;
  for (const auto& child : task.children) {
    if (child) parents.push_back({child->record.id, child->record.childMask});
  }
  for (std::size_t i = 0; i < parents.size(); ++i) {
    const Parent parent = parents[i];
    if (parent.id.level - task.id.level >= kComparedLevels) continue;
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      if ((parent.childMask & (1 << quadrant)) == 0) continue;
      auto record = database_.read(parent.id.child(quadrant));
      if (!record) return tl::unexpected(record.error());
      if (!*record) continue;
      parents.push_back({(*record)->id, (*record)->childMask});
      task.deeper.push_back({.record = std::move(**record), .heights = nullptr, .pixels = nullptr});
    }
  }
  return {};
}

/// The stored tiles of the children's level across each half of each edge.
io::Result<void> BuildRun::readBeyond(TileTask& task) {
  struct Half {
    tiling::Edge edge;
    std::size_t half;
    int quadrant;
  };
  using enum tiling::Edge;
  constexpr std::array<Half, 8> kHalves = {{{top, 0, 0},
                                            {top, 1, 1},
                                            {right, 0, 1},
                                            {right, 1, 3},
                                            {bottom, 0, 2},
                                            {bottom, 1, 3},
                                            {left, 0, 0},
                                            {left, 1, 2}}};
  for (const Half& half : kHalves) {
    const tiling::EdgeNeighbour neighbour = plan_.tiling().edgeNeighbour(task.id.child(half.quadrant), half.edge);
    auto record = database_.read(neighbour.tile);
    if (!record) return tl::unexpected(record.error());
    if (!*record) continue;
    task.beyond[static_cast<std::size_t>(half.edge)][half.half] =
        AdjacentTile{.tile = {.record = std::move(**record), .heights = nullptr, .pixels = nullptr},
                     .edge = neighbour.edge,
                     .reversed = neighbour.reversed};
  }
  return {};
}

io::Result<void> BuildRun::finishOldest() {
  Made made = work_.pop();
  const Candidate candidate = std::move(pending_.front());
  pending_.pop_front();
  if (!made) return tl::unexpected(made.error());
  return take(candidate, *made);
}

io::Result<void> BuildRun::take(const Candidate& candidate, const MadeTiles& made) {
  if (!groupIsOpen_) {
    if (auto ok = beginGroup(); !ok) return ok;
  }
  for (const TileRecord& record : made.records) {
    if (auto ok = database_.write(record); !ok) return ok;
  }
  if (cut_.part) {
    if (auto ok = listPiece(database_, candidate.id, made.candidates); !ok) return ok;
  }
  groupInputs_.insert(candidate.inputs.begin(), candidate.inputs.end());
  position_.row = rowNumberOf(candidate.id);
  position_.done += made.candidates;
  groupSize_ += made.candidates;
  report();
  return groupSize_ >= kGroupSize ? commitGroup() : io::Result<void>{};
}

/// Nobody else may have written since the last commit: two builds of the same file would ruin each other's order.
io::Result<void> BuildRun::beginGroup() {
  if (auto ok = database_.begin(); !ok) return ok;
  groupIsOpen_ = true;
  const auto found = database_.position();
  if (!found) return tl::unexpected(found.error());
  if (*found && **found == committed_) return {};
  return io::fail(Code::ioError, "another program builds the same file; wait for it to end",
                  database_.connection().path());
}

io::Result<void> BuildRun::commitGroup() {
  if (!groupIsOpen_) return {};
  if (auto ok = checkInputs(); !ok) return ok;
  if (auto ok = database_.writePosition(position_); !ok) return ok;
  if (auto ok = database_.commit(); !ok) return ok;
  committed_ = position_;
  groupIsOpen_ = false;
  groupSize_ = 0;
  groupInputs_.clear();
  return {};
}

void BuildRun::report() {
  if (!progress_) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - lastReport_ < kReportInterval) return;
  lastReport_ = now;
  progress_({.level = position_.level,
             .done = position_.done,
             .total = std::max(total_, position_.done),
             .doneBefore = doneBefore_});
}

}  // namespace tellurion::pyramid
