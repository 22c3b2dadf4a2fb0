#include "raster/virtual_raster.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <vector>

#include "raster/xml_document.h"

namespace tellurion::raster {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr std::size_t kHead = 1024;

/// All that a plain mosaic is written with.
constexpr auto kElements = std::to_array<std::string_view>({"VRTDataset",
                                                            "SRS",
                                                            "GeoTransform",
                                                            "Metadata",
                                                            "MDI",
                                                            "GCPList",
                                                            "GCP",
                                                            "VRTRasterBand",
                                                            "MaskBand",
                                                            "ColorInterp",
                                                            "NoDataValue",
                                                            "UnitType",
                                                            "HideNoDataValue",
                                                            "Offset",
                                                            "Scale",
                                                            "Description",
                                                            "ColorTable",
                                                            "Entry",
                                                            "CategoryNames",
                                                            "Category",
                                                            "SimpleSource",
                                                            "ComplexSource",
                                                            "AveragedSource",
                                                            "SourceFilename",
                                                            "SourceBand",
                                                            "SrcRect",
                                                            "DstRect",
                                                            "SourceProperties",
                                                            "NODATA",
                                                            "ScaleOffset",
                                                            "ScaleRatio",
                                                            "LUT",
                                                            "UseMaskBand",
                                                            "Exponent",
                                                            "SrcMin",
                                                            "SrcMax",
                                                            "DstMin",
                                                            "DstMax",
                                                            "ColorTableComponent",
                                                            "Histograms",
                                                            "BlockXSize"});
/// Attributes that matter here; GDAL knows them in any case.
constexpr auto kWatched = std::to_array<std::string_view>({"subClass", "relativeToVRT"});
constexpr std::string_view kOfSources = "VRTSourcedRasterBand";

io::Result<void> refused(const std::string& path, const std::string& why) {
  return io::fail(
      Code::unsupported,
      fmt::format("is a virtual raster (VRT) that {}; only mosaics of raster files are read, so make a file "
                  "of it first (gdal_translate)",
                  why),
      path);
}

std::string headOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(kHead, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  return head;
}

/// Databases, and documents that may name files of their own.
bool isMoreThanARaster(const std::string& head) {
  constexpr auto kMarks = std::to_array<std::string_view>(
      {"PDS_VERSION_ID", "CCSD", "^IMAGE", "^QUBE", "<?xml", "<VRTDataset", "<Product_"});
  return head.starts_with("SQLite format 3") ||
         std::ranges::any_of(kMarks, [&](std::string_view mark) { return head.find(mark) != std::string::npos; });
}

/// Where a mosaic's sources may lie.
struct Place {
  fs::path folder;  ///< its own
  bool sourcesAnywhere;
};

io::Result<void> checkSource(const XmlElement& element, const Place& place, const std::string& path) {
  const std::string& name = element.text;
  const bool isPlain = !name.empty() && name.find("://") == std::string::npos && !name.starts_with("/vsi") &&
                       !name.starts_with('<') && !name.ends_with(".vrt");
  if (!isPlain) return refused(path, fmt::format("names '{}', which is not a raster file", name));
  std::error_code error;
  const fs::path file = element.attribute("relativeToVRT") == "1" ? (place.folder / name).lexically_normal()
                                                                  : fs::absolute(name, error).lexically_normal();
  if (!place.sourcesAnywhere && std::ranges::mismatch(place.folder, file).in1 != place.folder.end()) {
    return io::fail(Code::unsupported,
                    fmt::format("is a virtual raster (VRT) that names '{}', outside its own folder; put the file, or a "
                                "link to it, beside it",
                                name),
                    path);
  }
  if (!fs::is_regular_file(file, error)) {
    return io::fail(Code::notFound, fmt::format("is a virtual raster (VRT) of files of which '{}' is not there", name),
                    path);
  }
  if (isMoreThanARaster(headOf(file.string()))) {
    return refused(path, fmt::format("names '{}', a database or a label, which may name more", name));
  }
  return {};
}

bool isMisspelt(std::string_view attribute) {
  const auto lower = [](std::string_view text) {
    std::string out(text);
    std::ranges::transform(out, out.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return out;
  };
  return std::ranges::any_of(
      kWatched, [&](std::string_view name) { return attribute != name && lower(attribute) == lower(name); });
}

io::Result<void> checkElement(const XmlElement& element, const Place& place, const std::string& path) {
  if (std::ranges::find(kElements, element.name) == kElements.end()) {
    return refused(path, fmt::format("has a <{}>", element.name));
  }
  for (const auto& [name, value] : element.attributes) {
    if (isMisspelt(name)) return refused(path, fmt::format("has an attribute '{}'", name));
  }
  const std::string_view subclass = element.attribute("subClass");
  if (!subclass.empty() && subclass != kOfSources) return refused(path, fmt::format("is a {}", subclass));
  if (element.name == "SourceFilename") return checkSource(element, place, path);
  if (element.name == "Metadata" || element.name == "Histograms") return {};  // nothing in there is followed
  for (const XmlElement& child : element.children) {
    if (auto ok = checkElement(child, place, path); !ok) return ok;
  }
  return {};
}

}  // namespace

bool isVirtualRaster(const std::string& path) {
  return headOf(path).find("<VRTDataset") != std::string::npos;
}

io::Result<void> checkVirtualRaster(const std::string& path, bool sourcesAnywhere) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> text(kMaxXmlBytes + 1);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) return io::fail(Code::ioError, "cannot be read", path);
  text.resize(static_cast<std::size_t>(file.gcount()));
  const auto root = parseXml(std::as_bytes(std::span(text)), path);
  if (!root) return tl::unexpected(root.error());
  std::error_code error;
  const fs::path folder = fs::absolute(path, error).lexically_normal().parent_path();
  return checkElement(*root, {.folder = folder, .sourcesAnywhere = sourcesAnywhere}, path);
}

}  // namespace tellurion::raster
