#pragma once

#include <span>
#include <string>
#include <variant>
#include <vector>

#include "geo/body.h"
#include "io/failure.h"
#include "scene/atmosphere.h"

namespace tellurion::scene {

/// A key of a table, as the scene file has it; monostate: a value of any other type.
struct EntryField {
  std::string key;
  std::variant<std::monostate, bool, double, std::string, std::vector<double>> value;
  std::string where;  ///< for messages
};

/// What the table [atmosphere] of a scene on this body means (docs/scene-file.md). where: of the table itself. Fails on
/// unknown keys, wrong types and values out of range, and where the body's air is not known and not all of it is told.
io::Result<Air> readAir(std::span<const EntryField> fields, const std::string& where, const geo::Body& body);

}  // namespace tellurion::scene
