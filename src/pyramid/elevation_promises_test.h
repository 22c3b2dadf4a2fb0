#pragma once

#include "pyramid/pyramid_reader.h"

namespace tellurion::pyramid::testing {

/// Neighbours, across roots too, hold the same bits on their shared edge, and in the gutter each other's samples.
void expectEdgesShared(const PyramidReader& reader);

/// A tile's samples are every second one of its children's.
void expectDecimated(const PyramidReader& reader);

/// By brute force: no sample of any descendant is further from a tile's bilinear surface than its error says; errors
/// and ranges never grow downwards. Prints the worst ratio of stated to measured error.
void expectErrorsBound(const PyramidReader& reader);

}  // namespace tellurion::pyramid::testing
