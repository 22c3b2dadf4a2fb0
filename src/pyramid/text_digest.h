#pragma once

#include <string>
#include <string_view>

namespace tellurion::pyramid {

/// FNV-1a, 64 bits, as hexadecimal digits: a name for a text, not a protection.
std::string digestOf(std::string_view text);

}  // namespace tellurion::pyramid
