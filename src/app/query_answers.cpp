#include "app/query_answers.h"

#include <fmt/format.h>

#include <iterator>
#include <string_view>

namespace tellurion::app {
namespace {

constexpr std::string_view kJsonError = "{\"error\":true}\n";

template <class... Values>
void add(std::string& out, fmt::format_string<Values...> format, Values&&... values) {
  fmt::format_to(std::back_inserter(out), format, std::forward<Values>(values)...);
}

}  // namespace

void HeightPrinter::header(std::string& out) const {
  if (format != AnswerFormat::csv) return;
  out += "lat,lon,height_m,level,spacing_m,error_m,finer";
  out += withNormals ? ",east,north,up\n" : "\n";
}

void HeightPrinter::answer(std::string& out, const LatLon& place,
                           const std::optional<pyramid::HeightAnswer>& answer) const {
  switch (format) {
    case AnswerFormat::text:
      if (!answer) {
        out += withNormals ? "nan nan nan nan" : "nan";
        break;
      }
      add(out, "{:.4f}", answer->height_m);
      if (withNormals) {
        const geo::Vec3& n = answer->normal_enu;
        add(out, " {:.7f} {:.7f} {:.7f}", n.x, n.y, n.z);
      }
      break;
    case AnswerFormat::json:
      add(out, R"({{"lat":{},"lon":{},"height_m":)", place.lat, place.lon);
      if (!answer) {
        out += "null}";
        break;
      }
      add(out, R"({:.4f},"level":{},"spacing_m":{:.6g},"error_m":{:.6g},"finer":{})", answer->height_m, answer->level,
          answer->spacing_m, answer->errorBound_m, answer->hasFiner);
      if (withNormals) {
        const geo::Vec3& n = answer->normal_enu;
        add(out, R"(,"normal":[{:.7f},{:.7f},{:.7f}])", n.x, n.y, n.z);
      }
      out += '}';
      break;
    case AnswerFormat::csv:
      add(out, "{},{},", place.lat, place.lon);
      if (!answer) {
        out += withNormals ? ",,,,,,," : ",,,,";
        break;
      }
      add(out, "{:.4f},{},{:.6g},{:.6g},{:d}", answer->height_m, answer->level, answer->spacing_m, answer->errorBound_m,
          answer->hasFiner);
      if (withNormals) {
        const geo::Vec3& n = answer->normal_enu;
        add(out, ",{:.7f},{:.7f},{:.7f}", n.x, n.y, n.z);
      }
      break;
  }
  out += '\n';
}

void HeightPrinter::error(std::string& out) const {
  switch (format) {
    case AnswerFormat::text:
      out += "error\n";
      break;
    case AnswerFormat::json:
      out += kJsonError;
      break;
    case AnswerFormat::csv:
      out += withNormals ? ",,error,,,,,,,\n" : ",,error,,,,\n";
      break;
  }
}

void ColourPrinter::header(std::string& out) const {
  if (format == AnswerFormat::csv) out += "lat,lon,red,green,blue,coverage,level,spacing_m,finer\n";
}

void ColourPrinter::answer(std::string& out, const LatLon& place,
                           const std::optional<pyramid::ColourAnswer>& answer) const {
  const raster::Rgba8 c = answer ? answer->colour : raster::Rgba8{};
  switch (format) {
    case AnswerFormat::text:
      if (answer) {
        add(out, "{} {} {} {}\n", c.r, c.g, c.b, c.a);
      } else {
        out += "nan nan nan nan\n";
      }
      break;
    case AnswerFormat::json:
      add(out, R"({{"lat":{},"lon":{},"rgba":)", place.lat, place.lon);
      if (answer) {
        add(out, R"([{},{},{},{}],"level":{},"spacing_m":{:.6g},"finer":{}}})", c.r, c.g, c.b, c.a, answer->level,
            answer->spacing_m, answer->hasFiner);
      } else {
        out += "null}";
      }
      out += '\n';
      break;
    case AnswerFormat::csv:
      add(out, "{},{},", place.lat, place.lon);
      if (answer) {
        add(out, "{},{},{},{},{},{:.6g},{:d}\n", c.r, c.g, c.b, c.a, answer->level, answer->spacing_m,
            answer->hasFiner);
      } else {
        out += ",,,,,,\n";
      }
      break;
  }
}

void ColourPrinter::error(std::string& out) const {
  switch (format) {
    case AnswerFormat::text:
      out += "error\n";
      break;
    case AnswerFormat::json:
      out += kJsonError;
      break;
    case AnswerFormat::csv:
      out += ",,error,,,,,,\n";
      break;
  }
}

}  // namespace tellurion::app
