#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "raster/image_check.h"
#include "raster/image_grid.h"
#include "raster/service.h"

/// What a scene's entry means to every protocol.
namespace tellurion::raster {

/// By the entry's encoding, scale, offset, nodata and byte order. Fails on an encoding or order that there is not,
/// naming those there are.
io::Result<HeightEncoding> heightEncoding(const ServiceLayer& layer);

/// The entry's bounds, else the server's, else the whole body. West beyond east crosses the date line.
geo::GeoRect boundsOf(const ServiceLayer& layer, const std::optional<std::array<double, 4>>& server_degrees);

/// Of the formats that a server offers the one to ask for: the entry's, else the best for the kind. Fails where there
/// is no such; the failure says which there are. Names are compared without parameters and capitals where no exact one
/// is.
io::Result<std::string> chooseFormat(const ServiceLayer& layer, Kind kind, std::span<const std::string> offered);

/// Bytes of a raw sample that a format holds; 0: it is a picture.
int rawSampleBytes(std::string_view format);

/// The file extension of a format, without a point: "png", "jpg", "bil", ...
std::string extensionOf(std::string_view format);

/// A request for an image at `url`, with its check and a bound for its bytes.
io::ResourceRequest imageRequest(std::string url, const std::string& dataset, const ExpectedImage& expected);

}  // namespace tellurion::raster
