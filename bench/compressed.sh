#!/usr/bin/env bash
# What --compress-textures costs and saves, over the demo's Earth: memory on the GPU, the difference in the picture, instructions a frame.
#
#   bench/compressed.sh [PROGRAM]
#
# Needs the demo's tile databases (./bootstrap demo), ImageMagick's compare and, for the instructions, perf.
set -euo pipefail
cd "$(dirname "$0")/.."
program=${1:-build/release/bin/tellurion}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Million user instructions of a frame, one thread drawing: 12 frames less 2.
instructions() {
  local scene=$1 camera=$2 frames
  shift 2
  for frames in 2 12; do
    printf 'seconds,lat,lon,height_m,heading,pitch,roll\n0,%s\n%d.1,%s\n' "$camera" "$((frames / 12))" "$camera" >"$work/path.csv"
    LP_NUM_THREADS=1 perf stat -x, -e instructions:u -o "$work/perf$frames" "$program" fly "$scene" --path "$work/path.csv" --fps 10 \
      --size 1024x768 -o "$work/frames$frames" "$@" >/dev/null 2>&1
    rm -rf "$work/frames$frames"
  done
  awk -F, '/instructions/ { n[FILENAME] = $1 } END { for (f in n) if (f ~ /12$/) more = n[f]; else less = n[f]; printf "%.0f", (more - less) / 1e7 }' \
    "$work/perf2" "$work/perf12"
}

figure() { sed -n "s/.*\"$2\": *\([0-9.]*\).*/\1/p" "$1" | head -1; }

echo "scene, camera: MiB on the GPU without, with; mean difference of 255; million instructions a frame without, with"
while read -r scene camera; do
  for how in without with; do
    flag=()
    [ $how = without ] || flag=(--compress-textures)
    "$program" render "$scene" --camera "$camera" --size 1024x768 -o "$work/$how.png" --stats "$work/$how.json" "${flag[@]}"
  done
  difference=$(compare -metric MAE "$work/without.png" "$work/with.png" null: 2>&1 || true)
  difference=$(sed 's/.*(\(.*\))/\1/' <<<"$difference" | awk '{ printf "%.2f", $1 * 255 }')
  echo "$scene, $camera: $(($(figure "$work/without.json" gpu_bytes) >> 20)), $(($(figure "$work/with.json" gpu_bytes) >> 20)); $difference;" \
    "$(instructions "$scene" "$camera"), $(instructions "$scene" "$camera" --compress-textures)"
done <<'VIEWS'
data/earth.toml 35,20,9000000,0,-90,0
data/earth.toml 25.5,86.2,500000,5,-62,0
data/earth.toml 27.75,86.82,9500,20,-12,0
data/earth_night.toml 35,20,12000000,0,-90,0
VIEWS
