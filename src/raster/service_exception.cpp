#include "raster/service_exception.h"

#include <algorithm>

namespace tellurion::raster {
namespace {

constexpr std::size_t kLongestText = 300;

bool isReport(const XmlElement& root) {
  return root.name == "ServiceExceptionReport" || root.name == "ExceptionReport" || root.name == "WMTException";
}

const XmlElement* firstException(const XmlElement& root) {
  const XmlElement* exception = root.child("ServiceException");
  return exception != nullptr ? exception : root.child("Exception");
}

std::string_view codeOf(const XmlElement& exception) {
  const std::string_view code = exception.attribute("code");
  return code.empty() ? exception.attribute("exceptionCode") : code;
}

}  // namespace

std::string onOneLine(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const bool space = static_cast<unsigned char>(c) <= ' ' || c == '\x7f';
    if (!space) line += c;
    if (space && !line.empty() && line.back() != ' ') line += ' ';
    if (line.size() > kLongestText) break;
  }
  if (line.size() > kLongestText) {
    std::size_t end = kLongestText;
    while (end > 0 && (static_cast<unsigned char>(line[end]) & 0xC0) == 0x80)
      --end;  // no half letter of UTF-8
    line.resize(end);
    line += "...";
  }
  while (line.ends_with(' ') || line.ends_with('.')) {
    if (line.ends_with("...")) break;
    line.pop_back();
  }
  return line;
}

std::string serviceExceptionCode(const XmlElement& root) {
  const XmlElement* exception = isReport(root) ? firstException(root) : nullptr;
  return exception == nullptr ? std::string{} : std::string(codeOf(*exception));
}

std::optional<std::string> serviceExceptionText(const XmlElement& root) {
  if (!isReport(root)) return std::nullopt;
  const XmlElement* exception = firstException(root);
  if (exception == nullptr) return root.text.empty() ? "an exception without a text" : onOneLine(root.text);
  const std::string_view inner = exception->textOf("ExceptionText");
  const std::string text = onOneLine(inner.empty() ? std::string_view(exception->text) : inner);
  const std::string code = onOneLine(codeOf(*exception));
  if (text.empty()) return code.empty() ? "an exception without a text" : code;
  return code.empty() ? text : code + ": " + text;
}

}  // namespace tellurion::raster
