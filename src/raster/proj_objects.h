#pragma once

#include <memory>
#include <optional>

#include "geo/geo_rect.h"

// Of PROJ, whose own header stays in source files: PJ, PJ_CONTEXT, and its lists of operations.
struct PJconsts;
struct pj_ctx;
struct PJ_OBJ_LIST;

namespace tellurion::raster {

struct FreeProj {
  void operator()(pj_ctx* context) const;
  void operator()(PJconsts* object) const;
  void operator()(PJ_OBJ_LIST* list) const;
};
/// Objects go before their context.
template <class T>
using ProjOwned = std::unique_ptr<T, FreeProj>;

/// A context that prints nothing and asks no network. One thread only.
ProjOwned<pj_ctx> quietProjContext();

enum class MissingGrids { discarded, kept };

/// All operations between two references, over an area if one is given, as PROJ ranks them, best first; of those whose
/// grids are not installed none, or these too. Null where there are none at all.
ProjOwned<PJ_OBJ_LIST> projOperations(pj_ctx* context, const PJconsts* source, const PJconsts* target,
                                      const std::optional<geo::GeoRect>& area, MissingGrids missing);

}  // namespace tellurion::raster
