#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "geo/geodetic.h"
#include "io/failure.h"

namespace tellurion::scene {

struct Place {
  std::string name;
  std::string kind;  ///< "crater", "country"; may be empty
  geo::Angle lat;
  geo::Angle lon;
  double size_m = 0.0;  ///< across; 0: not known
  double weight = 0.0;  ///< of two that fit alike, the larger one comes first: inhabitants, else size_m
};

/// Places of one body, by name. Immutable once filled.
class Gazetteer {
 public:
  /// CSV with a line of names first, in any case, of which each place needs a name (`name`, `feature_name`,
  /// `nameascii`), a latitude (`lat`, `latitude`, `center_latitude`, `y`) and a longitude (`lon`, `lng`, `long`,
  /// `longitude`, `center_longitude`, `x`), degrees; it may have `size_km` or `diameter` (km), `population` or
  /// `pop_max`, `kind`, `feature_type` or `featurecla`, and `body` or `target`: rows of another body are left out. So
  /// what the USGS Gazetteer of Planetary Nomenclature and Natural Earth give, and what `ogr2ogr -f CSV -lco
  /// GEOMETRY=AS_XY` writes, is read as it is. Fails naming the line; more than a million places are refused. file: for
  /// messages.
  io::Result<void> add(std::string_view csv, const std::string& body, const std::string& file);
  /// The same of a file, at most 256 MiB.
  io::Result<void> addFile(const std::string& path, const std::string& body);

  /// Those whose name is what was asked for, then those that begin with it, those of which a word begins with it, and
  /// those that have it anywhere, without regard to case and diacritics; the larger ones first. At most so many.
  std::vector<const Place*> search(std::string_view query, std::size_t most) const;
  bool empty() const { return places_.empty(); }
  std::size_t size() const { return places_.size(); }

 private:
  std::vector<Place> places_;
  std::vector<std::string> folded_;  ///< the names (folded_text.h)
};

}  // namespace tellurion::scene
