#pragma once

#include "geo/body.h"
#include "scene/atmosphere.h"
#include "scene/entry.h"

namespace tellurion::scene {

/// What the table [atmosphere] of a scene on this body means (docs/scene-file.md). Throws EntryFault on unknown keys,
/// wrong types and values out of range, and where the body's air is not known and not all of it is told.
Air readAir(const Entry& table, const geo::Body& body);

}  // namespace tellurion::scene
