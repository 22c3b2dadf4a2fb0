#pragma once

#include <optional>

#include "geo/body.h"

namespace tellurion::pyramid {

/// The largest bound of the error that a build takes, metres.
inline constexpr double kMostMaxError_m = 1e6;

/// The step that heights are rounded to where each may be off by maxError_m (above 0, at most kMostMaxError_m): as wide
/// as the bound allows, less what the 32-bit numbers before and after take of it for the highest height that the body
/// can have (0.0015 m on Earth, 0.003 m on Mars and the Moon). 0: the bound is so narrow that only 32-bit floating
/// point keeps it. Nothing where maxError_m is 0: no bound was asked for.
///
/// A height's multiple depends on the height alone, so what tiles share they still share, bit for bit.
std::optional<double> stepForError(double maxError_m, const geo::Body& body);

}  // namespace tellurion::pyramid
