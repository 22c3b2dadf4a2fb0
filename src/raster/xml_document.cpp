#include "raster/xml_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <pugixml.hpp>

#include "raster/parse_number.h"

namespace tellurion::raster {
namespace {

// Elements and attributes together; the largest real document known to us has 78,000. It bounds the parser's memory.
constexpr std::ptrdiff_t kMostParts = 1'000'000;

std::string_view localName(std::string_view name) {
  const std::size_t colon = name.rfind(':');
  return colon == name.npos ? name : name.substr(colon + 1);
}

/// False: deeper than allowed.
bool copyElement(const pugi::xml_node& node, int depth, XmlElement& element) {
  if (depth > kMaxXmlDepth) return false;
  element.name = localName(node.name());
  for (const pugi::xml_attribute& attribute : node.attributes())
    element.attributes.emplace_back(localName(attribute.name()), attribute.value());
  element.children.reserve(static_cast<std::size_t>(
      std::ranges::count_if(node.children(), [](const auto& child) { return child.type() == pugi::node_element; })));
  for (const pugi::xml_node& child : node.children()) {
    if (child.type() == pugi::node_element) {
      if (!copyElement(child, depth + 1, element.children.emplace_back())) return false;
    } else {
      element.text += child.value();
    }
  }
  element.text = std::string(trimmed(element.text));
  return true;
}

io::Result<XmlElement> failAt(std::string_view text, std::size_t offset, std::string_view problem,
                              const std::string& where) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(offset, text.size()));
  return io::fail(io::Failure::Code::corrupt,
                  fmt::format("line {}: {}", 1 + std::count(text.begin(), end, '\n'), problem), where);
}

}  // namespace

const XmlElement* XmlElement::child(std::string_view childName) const {
  const auto found = std::ranges::find(children, childName, &XmlElement::name);
  return found == children.end() ? nullptr : &*found;
}

const XmlElement* XmlElement::find(std::string_view path) const {
  const XmlElement* element = this;
  while (element != nullptr && !path.empty()) {
    const std::size_t slash = path.find('/');
    element = element->child(path.substr(0, slash));
    path = slash == path.npos ? std::string_view{} : path.substr(slash + 1);
  }
  return element;
}

std::string_view XmlElement::textOf(std::string_view path) const {
  const XmlElement* element = find(path);
  return element == nullptr ? std::string_view{} : std::string_view(element->text);
}

std::string_view XmlElement::attribute(std::string_view attributeName) const {
  for (const auto& [key, value] : attributes)
    if (key == attributeName) return value;
  return {};
}

std::vector<const XmlElement*> XmlElement::all(std::string_view childName) const {
  std::vector<const XmlElement*> found;
  for (const XmlElement& child : children)
    if (child.name == childName) found.push_back(&child);
  return found;
}

io::Result<XmlElement> parseXml(std::span<const std::byte> bytes, const std::string& where) {
  if (bytes.size() > kMaxXmlBytes) {
    return io::fail(io::Failure::Code::unsupported,
                    fmt::format("the document has {} bytes; at most {} are read", bytes.size(), kMaxXmlBytes), where);
  }
  const auto text = xmlTextInUtf8(bytes, where);
  if (!text) return tl::unexpected(text.error());
  const std::string_view all = *text;
  if (all.find_first_not_of(" \t\r\n") == all.npos)
    return io::fail(io::Failure::Code::corrupt, "the document is empty", where);
  if (std::ranges::count(all, '<') + std::ranges::count(all, '=') > kMostParts) {
    return io::fail(io::Failure::Code::unsupported,
                    fmt::format("the document has more than {} elements and attributes", kMostParts), where);
  }
  pugi::xml_document document;  // parses without recursion, and knows no entities but XML's own
  const pugi::xml_parse_result result =
      document.load_buffer(all.data(), all.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!result) {
    const auto offset = static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0));
    const bool atEnd = trimmed(all.substr(std::min(offset, all.size()))).size() <= 1;
    return failAt(all, offset,
                  atEnd ? "the document ends before it is complete; was it cut short?"
                        : fmt::format("not well-formed XML ({})", result.description()),
                  where);
  }
  XmlElement root;
  if (!copyElement(document.document_element(), 1, root)) {
    return io::fail(io::Failure::Code::unsupported,
                    fmt::format("the document nests deeper than {} elements", kMaxXmlDepth), where);
  }
  return root;
}

}  // namespace tellurion::raster
