#pragma once

#include <optional>
#include <string>

#include "app/query_places.h"
#include "pyramid/colour_query.h"

namespace tellurion::app {

enum class AnswerFormat { text, json, csv };

/// How answers are printed, each a line that is added to `out`.
struct HeightPrinter {
  AnswerFormat format = AnswerFormat::text;
  bool withNormals = false;

  void header(std::string& out) const;  ///< CSV only
  void answer(std::string& out, const LatLon& place, const std::optional<pyramid::HeightAnswer>& answer) const;
  void error(std::string& out) const;
};

struct ColourPrinter {
  AnswerFormat format = AnswerFormat::text;

  void header(std::string& out) const;
  void answer(std::string& out, const LatLon& place, const std::optional<pyramid::ColourAnswer>& answer) const;
  void error(std::string& out) const;
};

}  // namespace tellurion::app
