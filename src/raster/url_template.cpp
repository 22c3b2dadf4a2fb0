#include "raster/url_template.h"

#include <algorithm>

#include "raster/service_url.h"

namespace tellurion::raster {

UrlTemplate::UrlTemplate(std::string_view text) {
  texts_.emplace_back();
  while (!text.empty()) {
    const std::size_t open = text.find('{');
    const std::size_t close = open == text.npos ? text.npos : text.find('}', open);
    texts_.back() += text.substr(0, close == text.npos ? text.npos : open);
    if (close == text.npos) return;
    names_.push_back(lowered(text.substr(open + 1, close - open - 1)));
    texts_.emplace_back();
    text.remove_prefix(close + 1);
  }
}

bool UrlTemplate::has(std::string_view name) const {
  return std::ranges::find(names_, name) != names_.end();
}

}  // namespace tellurion::raster
