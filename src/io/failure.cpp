#include "io/failure.h"

namespace tellurion::io {

std::string describe(const Failure& f) { return f.where.empty() ? f.message : f.where + ": " + f.message; }

}  // namespace tellurion::io
