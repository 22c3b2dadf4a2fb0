#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geo/body.h"
#include "io/failure.h"

class OGRSpatialReference;

namespace tellurion::raster {

/// The body that a spatial reference is of.
struct ReferencedBody {
  geo::Body body;
  bool onEarth = false;  ///< both it and the reference are Earth's: changes of datum mean something
};

/// `body`, if given, is taken in place of the one that the reference names, where that is possible; warnings are added.
/// Fails on references that are no map of a body, or of another body than the one that is given.
io::Result<ReferencedBody> bodyOfReference(const OGRSpatialReference& reference, const std::string& path,
                                           const std::optional<geo::Body>& body, std::vector<std::string>& warnings);

bool hasDegrees(const OGRSpatialReference& reference);
std::string wktOf(const OGRSpatialReference& reference);

}  // namespace tellurion::raster
