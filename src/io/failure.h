#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace tellurion::io {

/// What the outside got wrong. Travels by return value; asserts are for our own mistakes.
struct Failure {
  enum class Code { invalidArgument, notFound, corrupt, unsupported, ioError, cancelled };
  Code code = Code::ioError;
  std::string message;  ///< a sentence without a full stop: what is wrong and, where we know, what to do next
  std::string where;    ///< path, URL, tile, line or byte; may be empty
};

/// "WHERE: MESSAGE".
std::string describe(const Failure& f);

template <class T>
using Result = tl::expected<T, Failure>;

inline tl::unexpected<Failure> fail(Failure::Code code, std::string message, std::string where = {}) {
  return tl::unexpected<Failure>(Failure{code, std::move(message), std::move(where)});
}

}  // namespace tellurion::io
