#!/usr/bin/env bash
# The demo: tile databases from the rasters in this folder, then the viewer, or pictures where there is no display.
#   demo.sh PROGRAM OUTPUT_DIR
set -euo pipefail
program=$1 out=$2
data=$(dirname "$0")

say() { printf '\033[1m%s\033[0m\n' "$*"; }

# A database is made once; one that an interruption left unfinished goes on where it was. `build` sees in a moment that
# one is complete; what it would not build like this today, an older version's, is made anew.
database() {
  local file=$data/$1 told
  shift
  if [ -f "$file" ]; then
    told=$("$program" build "$file" "$@" 2>&1) && return
    case $told in *"built from other inputs or with other options"*) rm "$file" ;; esac
  fi
  say "$program build $file $*"
  "$program" build "$file" "$@"
}
database earth_elevation.tdb "$data/earth/etopo5_dem_10min.tif" "$data/earth/srtm3_everest_N27E086_filled.tif" --kind elevation --tiling cube
database earth_imagery.tdb "$data/earth/bluemarble_dec2004_5400x2700.jpg" "$data/earth/everest_landsat7_rgb_30m.tif" --kind imagery --tiling cube
database earth_night.tdb "$data/earth/night_lights_5400x2700.jpg" --kind imagery --tiling cube
database earth_sea.tdb "$data/earth/sea_5400x2700.tif" --kind imagery --tiling cube
database mars_elevation.tdb "$data/mars/mola_dem_4ppd.tif" --kind elevation --tiling healpix --body mars
database mars_imagery.tdb "$data/mars/viking_mdim21_color_2880x1440.jpg" --kind imagery --tiling healpix --body mars

if [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]; then
  say "$program view $data/earth.toml"
  exec "$program" view "$data/earth.toml"
fi

say "No display here: rendering pictures into $out"
mkdir -p "$out/flight"
"$program" fly "$data/earth.toml" --path "$data/everest_flight.csv" --fps 1 --size 640x480 -o "$out/flight"
"$program" render "$data/mars.toml" --camera 5,-100,9000000,0,-90,0 --size 640x480 -o "$out/mars.png"
"$program" render "$data/earth.toml" --camera 88,0,5000000,0,-90,0 --size 640x480 -o "$out/north_pole.png"
"$program" render "$data/earth_night.toml" --camera 35,20,12000000,0,-90,0 --size 640x480 -o "$out/night.png"
"$program" render "$data/earth_sun.toml" --time 2026-06-21T16:30:00Z --camera 36,20,300000,285,-35,0 --size 640x480 -o "$out/sunset.png"
montage -font DejaVu-Sans -pointsize 16 -background '#101014' -fill white -label '%t' "$out"/flight/*.png "$out"/mars.png \
  "$out"/north_pole.png "$out"/night.png "$out"/sunset.png -tile 4x -geometry 480x360+6+6 "$out/contact_sheet.png"
say "Pictures:"
ls -1 "$out"/*.png "$out"/flight/*.png
say "All of them on one sheet: $out/contact_sheet.png"
