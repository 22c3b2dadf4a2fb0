#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/failure.h"

/// XML of servers and users: their capabilities, exceptions and layer configurations.
namespace tellurion::raster {

inline constexpr std::size_t kMaxXmlBytes = std::size_t{32} << 20;
inline constexpr int kMaxXmlDepth = 128;  ///< elements inside each other, the root included

/// An element, all text in UTF-8. Names are local: without the prefix of a namespace. A value.
struct XmlElement {
  std::string name;
  std::string text;  ///< its own character data, without the white space around
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<XmlElement> children;

  /// The first child of a name; null: there is none.
  const XmlElement* child(std::string_view childName) const;
  /// Down through first children, names parted by '/'; null: one of them is not there.
  const XmlElement* find(std::string_view path) const;
  /// The text of what find() finds; empty: not there. An empty path is the element itself.
  std::string_view textOf(std::string_view path) const;
  /// Empty: not there.
  std::string_view attribute(std::string_view attributeName) const;
  /// All children of a name.
  std::vector<const XmlElement*> all(std::string_view childName) const;
};

/// The root element. Safe on untrusted bytes: size, depth and the number of elements and attributes are bounded before
/// anything is built, entities but the five of XML itself and character references stay as they stand, a document type
/// is skipped, and nothing outside the document is read. Encodings: UTF-8, UTF-16 with and without a byte-order mark,
/// ISO-8859-1, ISO-8859-15, windows-1252; a mark that contradicts the bytes behind it is passed over. `where` is for
/// the failure, which names the line.
io::Result<XmlElement> parseXml(std::span<const std::byte> bytes, const std::string& where);

/// The same bytes as UTF-8, without a byte-order mark.
io::Result<std::string> xmlTextInUtf8(std::span<const std::byte> bytes, const std::string& where);

}  // namespace tellurion::raster
