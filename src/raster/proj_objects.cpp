#include "raster/proj_objects.h"

#include <proj.h>

namespace tellurion::raster {

void FreeProj::operator()(pj_ctx* context) const {
  proj_context_destroy(context);
}
void FreeProj::operator()(PJconsts* object) const {
  proj_destroy(object);
}
void FreeProj::operator()(PJ_OBJ_LIST* list) const {
  proj_list_destroy(list);
}

ProjOwned<pj_ctx> quietProjContext() {
  ProjOwned<pj_ctx> context(proj_context_create());
  proj_log_level(context.get(), PJ_LOG_NONE);
  proj_context_set_enable_network(context.get(), 0);
  return context;
}

ProjOwned<PJ_OBJ_LIST> projOperations(pj_ctx* context, const PJconsts* source, const PJconsts* target,
                                      const std::optional<geo::GeoRect>& area, MissingGrids missing) {
  PJ_OPERATION_FACTORY_CONTEXT* factory = proj_create_operation_factory_context(context, nullptr);
  proj_operation_factory_context_set_grid_availability_use(
      context, factory,
      missing == MissingGrids::kept ? PROJ_GRID_AVAILABILITY_IGNORED
                                    : PROJ_GRID_AVAILABILITY_DISCARD_OPERATION_IF_MISSING_GRID);
  proj_operation_factory_context_set_spatial_criterion(context, factory, PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION);
  if (area) {
    proj_operation_factory_context_set_area_of_interest(context, factory, area->west.degrees(), area->south.degrees(),
                                                        geo::wrappedLongitude(area->east()).degrees(),
                                                        area->north.degrees());
  }
  ProjOwned<PJ_OBJ_LIST> found(proj_create_operations(context, source, target, factory));
  proj_operation_factory_context_destroy(factory);
  return found;
}

}  // namespace tellurion::raster
