#!/usr/bin/env bash
# Prints the figures that README and docs/measurements.md claim, measured now on this machine.
#   bench/figures.sh [PROGRAM]
# Whole processes, wall-clock seconds, median of five runs after one that is not counted.
set -euo pipefail
cd "$(dirname "$0")/.."
program=$(realpath "${1:-build/release/bin/tellurion}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# median_seconds COMMAND...: its output is thrown away.
median_seconds() {
  "$@" >/dev/null 2>&1
  for _ in 1 2 3 4 5; do
    local start=$EPOCHREALTIME
    "$@" >/dev/null 2>&1
    echo "$EPOCHREALTIME $start" | awk '{ printf "%.3f\n", $1 - $2 }'
  done | sort -n | sed -n 3p
}

build_earth() {
  rm -f "$work"/earth_*.tdb
  "$program" build "$work/earth_elevation.tdb" data/earth/etopo5_dem_10min.tif data/earth/srtm3_everest_N27E086_filled.tif --kind elevation --tiling "$1"
  "$program" build "$work/earth_imagery.tdb" data/earth/bluemarble_dec2004_5400x2700.jpg data/earth/everest_landsat7_rgb_30m.tif --kind imagery --tiling "$1"
}

echo "machine: $(nproc) cores, $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1)"
for tiling in geographic cube healpix; do
  echo "build the embedded Earth, elevation and imagery, $tiling: $(median_seconds build_earth "$tiling") s," \
    "$(du -cb "$work"/earth_*.tdb | tail -n 1 | awk '{ printf "%.1f MiB", $1 / 1048576 }')"
  cat >"$work/earth.toml" <<TOML
body = "earth"
tiling = "$tiling"
[[elevation]]
source = "earth_elevation.tdb"
[[imagery]]
source = "earth_imagery.tdb"
TOML
  for view in "orbit 20,80,15000000,0,-90,0" "oblique 27.4,86.7,50000,0,-25,0" "horizon 27.7,86.7,9000,20,-5,0"; do
    seconds=$(median_seconds "$program" render "$work/earth.toml" --camera "${view#* }" --size 1024x768 -o "$work/out.png" --stats "$work/stats.json")
    figures=$(python3 -c "
import json
s = json.load(open('$work/stats.json'))
print(f\"frame {s['frame_ms']:.0f} ms, {s['triangles']} triangles, {s['tiles_drawn']} tiles, {s['draw_calls']} draw calls\")")
    echo "render ${view%% *}, $tiling, whole process: $seconds s; $figures"
  done
done
