#include <gtest/gtest.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>

#include "truth/proof_options.h"

namespace tellurion::truth {
namespace {

std::map<std::string, std::string>& given() {
  static std::map<std::string, std::string> options;
  return options;
}

const std::string* find(const std::string& name) {
  const auto found = given().find(name);
  return found != given().end() ? &found->second : nullptr;
}

double numberIn(const std::string& name, const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && std::isfinite(value)) return value;
  std::fprintf(stderr, "--%s=%s: '%s' is no number\n", name.c_str(), text.c_str(), text.c_str());
  std::exit(2);
}

/// False, with a word why, where an argument is none of this program's.
bool take(std::string_view argument) {
  const std::size_t equals = argument.find('=');
  if (argument.starts_with("--") && equals != std::string_view::npos) {
    const std::string name(argument.substr(2, equals - 2));
    if (std::find(kOptionNames.begin(), kOptionNames.end(), name) != kOptionNames.end()) {
      given()[name] = argument.substr(equals + 1);
      return true;
    }
  }
  std::fprintf(stderr, "'%s' is not taken here; there are", std::string(argument).c_str());
  for (const std::string& name : kOptionNames)
    std::fprintf(stderr, " --%s=", name.c_str());
  std::fprintf(stderr, "\n");
  return false;
}

}  // namespace

std::string option(const std::string& name, const std::string& otherwise) {
  const std::string* text = find(name);
  return text != nullptr ? *text : otherwise;
}

double option(const std::string& name, double otherwise) {
  const std::string* text = find(name);
  return text != nullptr ? numberIn(name, *text) : otherwise;
}

int option(const std::string& name, int otherwise) {
  return static_cast<int>(option(name, static_cast<double>(otherwise)));
}

std::vector<double> option(const std::string& name, const std::vector<double>& otherwise) {
  const std::string* text = find(name);
  if (text == nullptr) return otherwise;
  std::istringstream list(*text);
  std::vector<double> numbers;
  for (std::string one; std::getline(list, one, ',');)
    numbers.push_back(numberIn(name, one));
  return numbers;
}

}  // namespace tellurion::truth

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  for (int i = 1; i < argc; ++i) {
    if (!tellurion::truth::take(argv[i])) return 2;
  }
  return RUN_ALL_TESTS();
}
