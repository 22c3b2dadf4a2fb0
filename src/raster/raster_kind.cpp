#include "raster/raster_kind.h"

#include <gdal_priv.h>

#include <string_view>

#include "raster/gdal_session.h"

namespace tellurion::raster {
namespace {

bool isColour(GDALRasterBand& band) {
  switch (band.GetColorInterpretation()) {
    case GCI_PaletteIndex:
    case GCI_RedBand:
    case GCI_GreenBand:
    case GCI_BlueBand:
    case GCI_AlphaBand:
      return true;
    default:
      break;  // GDAL's enumeration is open: later versions add to it
  }
  return band.GetRasterDataType() == GDT_Byte && std::string_view(band.GetUnitType()).empty();
}

}  // namespace

io::Result<Kind> kindOfRaster(const std::string& path) {
  const GdalMessages messages;
  std::vector<std::string> warnings;
  const auto dataset = gdalOpen(path, warnings);
  if (!dataset) return tl::unexpected(dataset.error());
  const int bands = (*dataset)->GetRasterCount();
  if (bands < 1) return io::fail(io::Failure::Code::unsupported, "the raster has no bands", path);
  if (bands >= 3) return Kind::imagery;
  for (int i = 1; i <= bands; ++i) {
    if (isColour(*(*dataset)->GetRasterBand(i))) return Kind::imagery;
  }
  return Kind::elevation;
}

}  // namespace tellurion::raster
