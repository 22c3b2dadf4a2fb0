#pragma once

#include <functional>
#include <string>
#include <vector>

#include "geo/body.h"
#include "geo/geodetic.h"
#include "io/failure.h"
#include "raster/raster_file.h"

namespace tellurion::raster {

/// What a person may know better than a layer of points.
struct PointOptions {
  /// Names of the columns, in capitals or not: {height}, or {x, y, height}. Empty: those that readPoints() knows.
  std::vector<std::string> columns;
  /// What the coordinates are in, in place of what the layer says: AUTHORITY:CODE, WKT or a PROJ string.
  std::string reference;

  bool asksForAnything() const { return !columns.empty() || !reference.empty(); }
};

/// What a layer of points says of itself.
struct PointLayerInfo {
  std::vector<std::string> files;  ///< all that it is read from, sorted
  geo::Body body = geo::earth();
  std::vector<std::string> warnings;  ///< sentences without a full stop
};

/// Whether a file is a table of text (.csv, .tsv), or of shapes (GeoPackage, Shapefile, GeoJSON, FlatGeobuf, KML), and
/// no raster: a table whose lines are all cells of a regular grid, row by row, is a raster (GDAL's XYZ), unless options
/// say how its points are read.
bool isPointFile(const std::string& path, const PointOptions& options);

/// Gets every point, in the layer's order; a failure ends the reading.
using PointSink = std::function<io::Result<void>(const geo::Direction& place, float height_m)>;

/// Reads the one layer of points of a local file.
///
/// Places are the points' geometry, or else columns: lon, longitude, long or lng and lat or latitude; or x, easting or
/// east and y, northing or north, which come first where the reference is of a map. Heights, in metres, are the
/// geometry's z, or else the column height, elevation, elev, ele, altitude, alt, z or h; that one too, with a warning,
/// where z is 0 everywhere. PointOptions::columns are taken before all of these. Names in capitals or not.
///
/// Without a spatial reference (a table's may lie beside it as .prj) coordinates are longitude and latitude in degrees,
/// on RasterOptions::body or else Earth; with one, as RasterFile's places.
///
/// Left out, with a warning that counts them: points without a number where one has to be, RasterOptions::nodata,
/// places beyond 90 or 360 degrees, heights that the body cannot have. Safe on untrusted files as far as GDAL's drivers
/// are. Failures name the file: notFound, unsupported, invalidArgument, corrupt. Thread-safe.
io::Result<PointLayerInfo> readPoints(const std::string& path, const RasterOptions& options, const PointOptions& points,
                                      const PointSink& sink);

}  // namespace tellurion::raster
