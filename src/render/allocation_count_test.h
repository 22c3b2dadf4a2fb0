#pragma once

namespace tellurion::render {

/// Counts what this thread allocates with operator new between two calls: start, and how many since.
void startCountingAllocations();
int allocationsCounted();

}  // namespace tellurion::render
