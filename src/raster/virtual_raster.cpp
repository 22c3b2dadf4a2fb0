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

/// Where a source lies, as it is written.
io::Result<void> checkSource(const XmlElement& element, const fs::path& folder, const std::string& path) {
  const std::string& name = element.text;
  const bool isPlain = !name.empty() && name.find("://") == std::string::npos && !name.starts_with("/vsi") &&
                       !name.starts_with('<') && !name.ends_with(".vrt");
  if (!isPlain) return refused(path, fmt::format("names '{}', which is not a raster file", name));
  std::error_code error;
  const fs::path file = element.attribute("relativeToVRT") == "1" ? (folder / name).lexically_normal()
                                                                  : fs::absolute(name, error).lexically_normal();
  if (std::ranges::mismatch(folder, file).in1 != folder.end()) {
    return io::fail(Code::unsupported,
                    fmt::format("is a virtual raster (VRT) that names '{}', outside its own folder; put the file, or a "
                                "link to it, beside it",
                                name),
                    path);
  }
  if (fs::is_regular_file(file, error)) return {};
  return io::fail(Code::notFound, fmt::format("is a virtual raster (VRT) of files of which '{}' is not there", name),
                  path);
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

io::Result<void> checkElement(const XmlElement& element, const fs::path& folder, const std::string& path) {
  if (std::ranges::find(kElements, element.name) == kElements.end()) {
    return refused(path, fmt::format("has a <{}>", element.name));
  }
  for (const auto& [name, value] : element.attributes) {
    if (isMisspelt(name)) return refused(path, fmt::format("has an attribute '{}'", name));
  }
  const std::string_view subclass = element.attribute("subClass");
  if (!subclass.empty() && subclass != kOfSources) return refused(path, fmt::format("is a {}", subclass));
  if (element.name == "SourceFilename") return checkSource(element, folder, path);
  if (element.name == "Metadata" || element.name == "Histograms") return {};  // nothing in there is followed
  for (const XmlElement& child : element.children) {
    if (auto ok = checkElement(child, folder, path); !ok) return ok;
  }
  return {};
}

}  // namespace

bool isVirtualRaster(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(kHead, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  return head.find("<VRTDataset") != std::string::npos;
}

io::Result<void> checkVirtualRaster(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> text(kMaxXmlBytes + 1);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) return io::fail(Code::ioError, "cannot be read", path);
  text.resize(static_cast<std::size_t>(file.gcount()));
  const auto root = parseXml(std::as_bytes(std::span(text)), path);
  if (!root) return tl::unexpected(root.error());
  std::error_code error;
  const fs::path folder = fs::absolute(path, error).lexically_normal().parent_path();
  return checkElement(*root, folder, path);
}

}  // namespace tellurion::raster
