#!/usr/bin/env bash
# How long builds take beside gdal2tiles.py and COGs of the same rasters, both sides in turn in each round.
#
#   bench/builds.sh [WORK_FOLDER] [PROGRAM] [ROUNDS] [PART...]
#
# Parts: imagery png healpix elevation jobs scale (all). WORK_FOLDER keeps the inputs for the next run: the embedded Earth as 10,800 x 5,400 RGB
# and 16-bit elevation, and a quarter and four times of the first. Prints medians over rounds: seconds of the processor (user and system) and of
# the clock, bytes, and the ratio to the first line of a part. On a busy machine only processor times and their ratios mean anything.
# gdal2tiles.py takes minutes, and of its workers the processor time is not all seen: GDAL2TILES=no leaves it out. Needs GDAL's programs.
set -euo pipefail
work=${1:-$(mktemp -d)}
program=${2:-build/release/bin/tellurion}
rounds=${3:-3}
[ $# -ge 1 ] || trap 'rm -rf "$work"' EXIT
parts=(imagery png healpix elevation jobs scale)
[ $# -lt 4 ] || parts=("${@:4}")
data="$(cd "$(dirname "$0")/.." && pwd)/data/earth"
program=$(realpath "$program")
mkdir -p "$work"
cd "$work"

input() { # NAME WIDTH HEIGHT SOURCE OPTIONS...
  [ -e "$1" ] || gdal_translate -q -a_srs EPSG:4326 -a_ullr -180 90 180 -90 -outsize "$2" "$3" -r cubic -co TILED=YES -co COMPRESS=DEFLATE "${@:5}" "$4" "$1"
}
image=$(ls "$data"/bluemarble*.jpg | head -1)
heights=$(ls "$data"/etopo5*.tif | head -1)
input rgb.tif 10800 5400 "$image"
input dem.tif 10800 5400 "$heights" -ot Int16 -co PREDICTOR=2

declare -A lines=()
run() { # NAME OUTPUT COMMAND...: user+sys, elapsed and bytes, added to the name's
  local name=$1 output=$2
  rm -rf "$output" "$output.part"
  local took
  took=$( { TIMEFORMAT='%U %S %R'; time "${@:3}" >/dev/null 2>&1; } 2>&1 ) || { echo "$name failed: ${*:3}" >&2; exit 1; }
  lines[$name]+="$took $(du -sb "$output" | cut -f1)"$'\n'
  rm -rf "$output"
}
table() { # NAMES...: medians, and ratios to the first
  printf '%-44s %8s %7s %8s %7s %10s %7s\n' '' 'cpu s' '' 'clock s' '' 'bytes' ''
  local first=
  for name in "$@"; do
    [ -n "${lines[$name]:-}" ] || continue
    local median
    median=$(printf '%s' "${lines[$name]}" | awk '
      function middle(v, n,   i, j, t) { for (i = 2; i <= n; ++i) for (j = i; j > 1 && v[j] < v[j-1]; --j) { t = v[j]; v[j] = v[j-1]; v[j-1] = t }
        return n % 2 ? v[(n+1)/2] : (v[n/2] + v[n/2+1]) / 2 }
      { cpu[NR] = $1 + $2; wall[NR] = $3; bytes[NR] = $4 } END { print middle(cpu, NR), middle(wall, NR), middle(bytes, NR) }')
    first=${first:-$median}
    awk -v n="$name" -v m="$median" -v f="$first" 'BEGIN { split(m, a); split(f, b)
      printf "%-44s %8.2f %6.2fx %8.2f %6.2fx %10d %6.2fx\n", n, a[1], a[1]/b[1], a[2], a[2]/b[2], a[3], a[3]/b[3] }'
  done
  echo
}
build() { "$program" build "$@"; }

for part in "${parts[@]}"; do
  echo "$part"
  case $part in
    imagery)
      for ((i = 0; i < rounds; ++i)); do
        run 'tellurion, geographic, JPEG' o.tdb build o.tdb rgb.tif --kind imagery --tiling geographic --jobs 2
        run 'gdal_translate -of COG -co COMPRESS=JPEG' o.tif gdal_translate -of COG -co COMPRESS=JPEG rgb.tif o.tif
        [ "$i" -gt 0 ] || [ "${GDAL2TILES:-}" = no ] || run 'gdal2tiles.py --processes=2 -p geodetic -z 0-5' tiles gdal2tiles.py --processes=2 -p geodetic -z 0-5 rgb.tif tiles
      done
      table 'tellurion, geographic, JPEG' 'gdal_translate -of COG -co COMPRESS=JPEG' 'gdal2tiles.py --processes=2 -p geodetic -z 0-5' ;;
    png)
      for ((i = 0; i < rounds; ++i)); do
        run 'tellurion, geographic, PNG' o.tdb build o.tdb rgb.tif --kind imagery --tiling geographic --format png --jobs 2
      done
      table 'tellurion, geographic, PNG' 'gdal2tiles.py --processes=2 -p geodetic -z 0-5' ;;
    healpix)
      for ((i = 0; i < rounds; ++i)); do
        for tiling in geographic cube healpix; do
          run "tellurion, $tiling" o.tdb build o.tdb rgb.tif --kind imagery --tiling $tiling --jobs 2
        done
      done
      table 'tellurion, geographic' 'tellurion, cube' 'tellurion, healpix' ;;
    elevation)
      for ((i = 0; i < rounds; ++i)); do
        run 'tellurion, geographic, elevation' o.tdb build o.tdb dem.tif --kind elevation --tiling geographic --jobs 2
        run 'gdal_translate -of COG, ZSTD, PREDICTOR' o.tif gdal_translate -of COG -co COMPRESS=ZSTD -co PREDICTOR=YES dem.tif o.tif
      done
      table 'tellurion, geographic, elevation' 'gdal_translate -of COG, ZSTD, PREDICTOR' ;;
    jobs)
      for ((i = 0; i < rounds; ++i)); do
        for jobs in 1 2; do
          run "imagery, --jobs $jobs" o.tdb build o.tdb rgb.tif --kind imagery --tiling geographic --jobs $jobs
          run "elevation, --jobs $jobs" o.tdb build o.tdb dem.tif --kind elevation --tiling geographic --jobs $jobs
        done
      done
      table 'imagery, --jobs 1' 'imagery, --jobs 2'
      table 'elevation, --jobs 1' 'elevation, --jobs 2' ;;
    scale) # each level four times the tiles of the one before
      input rgb1.tif 2700 1350 "$image"
      input rgb4.tif 5400 2700 "$image"
      for ((i = 0; i < rounds; ++i)); do
        run '1 times the input' o.tdb build o.tdb rgb1.tif --kind imagery --tiling geographic --jobs 2
        run '4 times' o.tdb build o.tdb rgb4.tif --kind imagery --tiling geographic --jobs 2
        run '16 times' o.tdb build o.tdb rgb.tif --kind imagery --tiling geographic --jobs 2
      done
      table '1 times the input' '4 times' '16 times' ;;
    *) echo "no such part: $part" >&2; exit 2 ;;
  esac
done
