// Asks a tile database for the height of a place:  height_at alps.tdb 46.53 8.13
#include <cstdio>
#include <cstdlib>

#include "pyramid/height_query.h"
#include "pyramid/pyramid_reader.h"

using namespace tellurion;

namespace {

int complain(const io::Failure& failure) {
  std::fprintf(stderr, "height_at: %s\n", io::describe(failure).c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: height_at DATABASE.tdb LATITUDE LONGITUDE\n");
    return 2;
  }
  const auto database = pyramid::PyramidReader::open(argv[1]);
  if (!database) return complain(database.error());
  auto query = pyramid::HeightQuery::create(*database);
  if (!query) return complain(query.error());

  const geo::Direction place = geo::directionFromDegrees(std::atof(argv[2]), std::atof(argv[3]));
  const auto answer = query->at(place);
  if (!answer) return complain(answer.error());
  if (!*answer) {
    std::printf("no data there\n");
    return 1;
  }
  std::printf("%.2f m above the ellipsoid, from level %d\n", (*answer)->height_m, (*answer)->level);
  return 0;
}
