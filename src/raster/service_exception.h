#pragma once

#include <optional>
#include <string>

#include "raster/xml_document.h"

namespace tellurion::raster {

/// What a server complains of in XML (WMS <ServiceExceptionReport>, OWS <ExceptionReport>): code and text on one line,
/// not longer than a message may be. Nothing: the document is something else.
std::optional<std::string> serviceExceptionText(const XmlElement& root);

/// The code of the first exception of a report ("TileOutOfRange"); empty: none.
std::string serviceExceptionCode(const XmlElement& root);

/// Text of the outside for a message: one line of at most 300 bytes, without control characters.
std::string onOneLine(std::string_view text);

}  // namespace tellurion::raster
