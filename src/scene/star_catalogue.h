#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "geo/vector.h"
#include "io/failure.h"

namespace tellurion::scene {

struct Star {
  geo::Vec3f direction_celestial{0.0f};  ///< unit, ICRS
  float magnitude = 0.0f;                ///< visual
  geo::Vec3f colour{1.0f};               ///< linear sRGB of light, the strongest channel 1
};

/// Immutable once made.
struct StarCatalogue {
  std::uint64_t serial = 0;  ///< unique in the process; what GPU copies are keyed by
  std::vector<Star> stars;   ///< brightest first
};

/// Those that come with the program: 5,044 of the extended Hipparcos compilation, down to magnitude 6
/// (data/sky/bright_stars.csv). Read at the first call; any thread.
std::shared_ptr<const StarCatalogue> brightStars();

/// Comma-separated text with a header that has ra_degrees, dec_degrees and magnitude, and may have bv (the colour index
/// B - V; left empty: white) and others, which are not looked at. Places are those of J2000. Fails on columns that are
/// missing, on what is no number or out of range (where: name:line), and on more than a million stars.
io::Result<StarCatalogue> readStars(std::string_view text, const std::string& name);

/// The same from a file, of at most 256 MiB.
io::Result<StarCatalogue> readStarFile(const std::string& path);

/// The colour of a star, as Star has it: a black body's of the temperature that its colour index tells (Ballesteros
/// 2012, New insights into black bodies, formula 14), by Planck's law at the wavelengths of sRGB's primaries (612, 549
/// and 465 nm).
geo::Vec3f starColour(double colourIndex_bv);

}  // namespace tellurion::scene
