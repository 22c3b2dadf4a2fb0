#include "raster/projection.h"

#include <proj.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "raster/proj_objects.h"

namespace tellurion::raster {
namespace {

/// Of all operations between two references the first, which PROJ ranks best, made ready for (longitude, latitude)
/// order.
ProjOwned<PJ> bestOperation(PJ_CONTEXT* context, const PJ* source, const PJ* target,
                            const std::optional<geo::GeoRect>& area) {
  const auto operations = projOperations(context, source, target, area, MissingGrids::discarded);
  const int count = operations ? proj_list_get_count(operations.get()) : 0;
  for (int i = 0; i < count; ++i) {
    const ProjOwned<PJ> operation(proj_list_get(context, operations.get(), i));
    if (!operation || proj_coordoperation_is_instantiable(context, operation.get()) == 0) continue;
    ProjOwned<PJ> ready(proj_normalize_for_visualization(context, operation.get()));
    if (ready) return ready;
  }
  return nullptr;
}

ProjOwned<PJ> referenceOf(PJ_CONTEXT* context, const std::string& wkt) {
  ProjOwned<PJ> reference(proj_create(context, wkt.c_str()));
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
  ProjOwned<PJ_CONTEXT> context = quietProjContext();
  ProjOwned<PJ> operation;  // Goes before the context.
};

Projection::Projection(std::unique_ptr<Handles> handles) : handles_(std::move(handles)) {}

Projection::Projection(Projection&&) noexcept = default;
Projection& Projection::operator=(Projection&&) noexcept = default;
Projection::~Projection() = default;

io::Result<Projection> Projection::fromOwnGeographic(const std::string& wkt) {
  auto handles = std::make_unique<Handles>();
  PJ_CONTEXT* context = handles->context.get();
  const ProjOwned<PJ> reference = referenceOf(context, wkt);
  if (!reference) return notUnderstood();
  const ProjOwned<PJ> geographic(proj_crs_get_geodetic_crs(context, reference.get()));
  if (!geographic) return notUnderstood();
  handles->operation = bestOperation(context, geographic.get(), reference.get(), std::nullopt);
  if (!handles->operation) return notUnderstood();
  return Projection(std::move(handles));
}

io::Result<Projection> Projection::fromWgs84(const std::string& wkt, const std::optional<geo::GeoRect>& area) {
  auto handles = std::make_unique<Handles>();
  PJ_CONTEXT* context = handles->context.get();
  const ProjOwned<PJ> reference = referenceOf(context, wkt);
  const ProjOwned<PJ> wgs84 = referenceOf(context, "EPSG:4326");
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
