#pragma once

#include <string>
#include <string_view>

namespace tellurion::scene {

/// UTF-8 text as a person looks for it: without case, and without the diacritics of the Latin alphabets ("Sao Paulo"
/// finds its tilde, "Zurich" its two dots); sharp s, thorn and the like as the letters that stand for them; signs
/// between letters as one blank, apostrophes as nothing. Other alphabets stay as they are. Bytes that are no UTF-8 are
/// left out.
std::string foldedText(std::string_view text);

}  // namespace tellurion::scene
