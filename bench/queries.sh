#!/usr/bin/env bash
# How fast places are asked for: conversions beside chealpix and GeographicLib, heights beside GDAL and a flat array in memory.
#
#   bench/queries.sh [BUILD_FOLDER] [WORK_FOLDER]
#
# The elevation is the embedded Earth, resampled to 10,800 x 5,400 with hills of its own below that, as a COG (ZSTD, predictor) and as a
# tile database of each tiling. WORK_FOLDER keeps them for the next run. Needs GDAL's Python.
set -euo pipefail
cd "$(dirname "$0")/.."
build=${1:-build/release}
work=${2:-$(mktemp -d)}
mkdir -p "$work"
[ $# -ge 2 ] || trap 'rm -rf "$work"' EXIT

"$build/bin/conversion_speed"
echo
if [ ! -e "$work/earth.tif" ]; then
  /usr/bin/python3 - data/earth/etopo5_dem_10min.tif "$work" <<'PYTHON'
import sys

import numpy as np
from osgeo import gdal

gdal.UseExceptions()
source, work = sys.argv[1:]
fine = gdal.Translate("", source, format="MEM", width=10800, height=5400, resampleAlg="cubicspline")
heights = fine.ReadAsArray().astype(np.float32)
grain = np.random.default_rng(1).normal(size=heights.shape).astype(np.float32)
for axis in (0, 1):  # hills of a few pixels
    grain = grain + np.roll(grain, 1, axis) + np.roll(grain, -1, axis) + np.roll(grain, 2, axis)
fine.GetRasterBand(1).WriteArray(np.rint(heights + 3.0 * grain).astype(np.int16))
gdal.Translate(f"{work}/earth.tif", fine, format="COG", creationOptions=["COMPRESS=ZSTD", "PREDICTOR=YES", "OVERVIEWS=NONE", "BLOCKSIZE=256"])
PYTHON
fi
for tiling in geographic cube healpix; do
  [ -e "$work/$tiling.tdb" ] || "$build/bin/tellurion" build "$work/$tiling.tdb" "$work/earth.tif" --kind elevation --tiling $tiling >/dev/null
  echo "$tiling"
  "$build/bin/query_speed" "$work/$tiling.tdb" "$work/earth.tif" 64
done
