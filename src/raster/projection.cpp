#include "raster/projection.h"

#include <proj.h>

#include <algorithm>
#include <string_view>
#include <utility>

namespace tellurion::raster {
namespace {

struct FreeProj {
  void operator()(PJ_CONTEXT* c) const { proj_context_destroy(c); }
  void operator()(PJ* p) const { proj_destroy(p); }
  void operator()(PJ_OBJ_LIST* l) const { proj_list_destroy(l); }
  void operator()(PJ_OPERATION_FACTORY_CONTEXT* f) const { proj_operation_factory_context_destroy(f); }
};
template <class T>
using Owned = std::unique_ptr<T, FreeProj>;

Owned<PJ_CONTEXT> quietContext() {
  Owned<PJ_CONTEXT> context(proj_context_create());
  proj_log_level(context.get(), PJ_LOG_NONE);
  proj_context_set_enable_network(context.get(), 0);
  return context;
}

/// Of all operations between two references the first, which PROJ ranks best, made ready for (longitude, latitude)
/// order.
Owned<PJ> bestOperation(PJ_CONTEXT* context, const PJ* source, const PJ* target,
                        const std::optional<geo::GeoRect>& area) {
  const Owned<PJ_OPERATION_FACTORY_CONTEXT> factory(proj_create_operation_factory_context(context, nullptr));
  PJ_OPERATION_FACTORY_CONTEXT* f = factory.get();
  proj_operation_factory_context_set_grid_availability_use(context, f,
                                                           PROJ_GRID_AVAILABILITY_DISCARD_OPERATION_IF_MISSING_GRID);
  proj_operation_factory_context_set_spatial_criterion(context, f, PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION);
  if (area) {
    proj_operation_factory_context_set_area_of_interest(context, f, area->west.degrees(), area->south.degrees(),
                                                        geo::wrappedLongitude(area->east()).degrees(),
                                                        area->north.degrees());
  }
  const Owned<PJ_OBJ_LIST> operations(proj_create_operations(context, source, target, f));
  const int count = operations ? proj_list_get_count(operations.get()) : 0;
  for (int i = 0; i < count; ++i) {
    const Owned<PJ> operation(proj_list_get(context, operations.get(), i));
    if (!operation || proj_coordoperation_is_instantiable(context, operation.get()) == 0) continue;
    Owned<PJ> ready(proj_normalize_for_visualization(context, operation.get()));
    if (ready) return ready;
  }
  return nullptr;
}

Owned<PJ> referenceOf(PJ_CONTEXT* context, const std::string& wkt) {
  Owned<PJ> reference(proj_create(context, wkt.c_str()));
  if (reference && proj_is_crs(reference.get()) == 0) reference.reset();
  return reference;
}

io::Result<Projection> notUnderstood() {
  return io::fail(io::Failure::Code::unsupported,
                  "its spatial reference cannot be related to longitude and latitude; warp it to another one first "
                  "(gdalwarp -t_srs)");
}

}  // namespace

struct Projection::Handles {
  Owned<PJ_CONTEXT> context = quietContext();
  Owned<PJ> operation;  // Goes before the context.
};

Projection::Projection(std::unique_ptr<Handles> handles) : handles_(std::move(handles)) {}

Projection::Projection(Projection&&) noexcept = default;
Projection& Projection::operator=(Projection&&) noexcept = default;
Projection::~Projection() = default;

io::Result<Projection> Projection::fromOwnGeographic(const std::string& wkt) {
  auto handles = std::make_unique<Handles>();
  PJ_CONTEXT* context = handles->context.get();
  const Owned<PJ> reference = referenceOf(context, wkt);
  if (!reference) return notUnderstood();
  const Owned<PJ> geographic(proj_crs_get_geodetic_crs(context, reference.get()));
  if (!geographic) return notUnderstood();
  handles->operation = bestOperation(context, geographic.get(), reference.get(), std::nullopt);
  if (!handles->operation) return notUnderstood();
  return Projection(std::move(handles));
}

io::Result<Projection> Projection::fromWgs84(const std::string& wkt, const std::optional<geo::GeoRect>& area) {
  auto handles = std::make_unique<Handles>();
  PJ_CONTEXT* context = handles->context.get();
  const Owned<PJ> reference = referenceOf(context, wkt);
  const Owned<PJ> wgs84 = referenceOf(context, "EPSG:4326");
  if (!reference || !wgs84) return notUnderstood();
  handles->operation = bestOperation(context, wgs84.get(), reference.get(), area);
  if (!handles->operation) return notUnderstood();
  return Projection(std::move(handles));
}

void Projection::forward(std::span<double> x, std::span<double> y) const {
  const std::size_t count = std::min(x.size(), y.size());
  proj_trans_generic(handles_->operation.get(), PJ_FWD, x.data(), sizeof(double), count, y.data(), sizeof(double),
                     count, nullptr, 0, 0, nullptr, 0, 0);
}

void Projection::inverse(std::span<double> x, std::span<double> y) const {
  const std::size_t count = std::min(x.size(), y.size());
  proj_trans_generic(handles_->operation.get(), PJ_INV, x.data(), sizeof(double), count, y.data(), sizeof(double),
                     count, nullptr, 0, 0, nullptr, 0, 0);
}

bool Projection::isIdentity() const {
  const PJ_PROJ_INFO info = proj_pj_info(handles_->operation.get());
  return info.definition != nullptr && std::string_view(info.definition).find("proj=noop") != std::string_view::npos &&
         std::string_view(info.definition).find("step") == std::string_view::npos;
}

}  // namespace tellurion::raster
