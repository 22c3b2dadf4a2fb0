#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/failure.h"

namespace tellurion::raster {

/// A URL with names in braces, {x}, to be filled in. A value.
class UrlTemplate {
 public:
  /// Capitals of names do not matter. A brace that is not closed belongs to the text.
  explicit UrlTemplate(std::string_view text);

  bool has(std::string_view name) const;
  /// Names that are in it, in lower case, each as often as it stands there.
  const std::vector<std::string>& names() const { return names_; }
  /// `valueOf(name)`, with the name in lower case, gives what goes there; a value goes in as it is.
  template <class ValueOf>
  std::string filled(ValueOf valueOf) const {
    std::string url = texts_[0];
    for (std::size_t i = 0; i < names_.size(); ++i)
      url.append(valueOf(std::string_view(names_[i]))).append(texts_[i + 1]);
    return url;
  }

 private:
  std::vector<std::string> texts_;  ///< around the names: one more than those
  std::vector<std::string> names_;
};

}  // namespace tellurion::raster
