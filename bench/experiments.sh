#!/usr/bin/env bash
# Repeats the known experiments, and compares meshes and tolerances: prints the tables of docs/measurements.md.
#   bench/experiments.sh [PROGRAM] [PLOTS_DIR] [PART...]
# PART: vertices, path, meshes, tolerances, automatic, cut (flight_tests beside PROGRAM); all of them unless some are named. The plots of the 30 s path go into PLOTS_DIR
# (build/experiments). All takes nine to fourteen minutes.
set -euo pipefail
cd "$(dirname "$0")/.."
program=$(realpath "${1:-build/release/bin/tellurion}")
plots=${2:-build/experiments}
mkdir -p "$plots"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
size=1024x768

# figures FRAMES.csv: of the settled frames (the last ones, complete and of as many triangles as the very last; a frame that
# still morphs may be complete too) median milliseconds, triangles, tiles, largest screen error in pixels. Where there are
# fewer than five, of the last ten frames, with a star.
figures() {
  python3 - "$1" <<'PY'
import csv, statistics, sys
rows = list(csv.DictReader(open(sys.argv[1])))
settled = len(rows)
while settled and rows[settled - 1]["complete"] == "true" and rows[settled - 1]["triangles"] == rows[-1]["triangles"]:
    settled -= 1
kept = rows[settled + 1:]
star = "" if len(kept) >= 5 else "*"
kept = rows[-10:] if star else kept
median = lambda name: statistics.median(float(row[name]) for row in kept)
print(f"{median('frame_ms'):.{0 if median('frame_ms') >= 100 else 1}f}{star}", f"{median('triangles'):.0f}", f"{median('tiles_drawn'):.0f}", f"{median('max_screen_error_px'):.3g}")
PY
}

# held SCENE CAMERA OPTION...: figures of a camera that stands still, longer where the data take longer to come.
held() {
  local scene=$1 camera=$2 told seconds
  shift 2
  for seconds in 6 20 60; do
    printf '0,%s\n%s,%s\n' "$camera" "$seconds" "$camera" >"$work/held.csv"
    "$program" bench "$scene" --path "$work/held.csv" --size "$size" --stats "$work/held_frames.csv" "$@" >"$work/held.txt"
    told=$(figures "$work/held_frames.csv")
    [[ $told == *"*"* ]] || break
  done
  echo "$told"
}

row() {
  printf '|'
  printf ' %s |' "$@"
  printf '\n'
}

per_second() { awk "BEGIN { printf \"%.0f\", 1000 / ${1%\*} }"; }

vertices() {
  printf '\nMars, elevation alone, vertices a pixel:\n\n'
  row view V mesh 'frame, ms' 'frames a second' triangles tiles 'largest error, px' 'published, frames a second'
  row --- --- --- --- --- --- --- --- ---
  declare -A published=([0.005]=105 [0.01]=75 [0.2]=24 [1]=9)
  for view in "globe 0,-70,6000000,0,-90,0" "oblique,300km -14,-75,300000,20,-25,0"; do
    for v in 0.005 0.01 0.2 1; do
      for mesh in regular bisected; do
        read -r ms triangles tiles error < <(held data/mars_elevation.tdb "${view#* }" --vertices-per-pixel "$v" --mesh "$mesh")
        row "${view%% *}" "$v" "$mesh" "$ms" "$(per_second "$ms")" "$triangles" "$tiles" "$error" "${published[$v]}"
      done
    done
  done
}

# By --tolerance, as published: --quality would make texels as coarse.
path() {
  printf '\nMars, elevation and picture, the 30 s path at three qualities (tolerance 1 px / quality), plots in %s:\n\n' "$plots"
  row quality 'tolerance, px' 'frame ms: 50%' '95%' '99%' most frames 'over the tolerance, nothing missing' 'the worst, px' 'triangles, most' 'tiles wanted, most' 'GPU, MiB'
  row --- --- --- --- --- --- --- --- --- --- --- ---
  for quality in 0.025 1 5; do
    tolerance=$(awk "BEGIN { print 1 / $quality }")
    "$program" bench data/mars.toml --path data/mars_zoom_pan_look.csv --size "$size" --tolerance "$tolerance" \
      --plot "$plots/mars_quality_$quality.svg" --stats "$plots/mars_quality_$quality.csv" --json >"$work/path.json"
    mapfile -t values < <(python3 - "$work/path.json" "$plots/mars_quality_$quality.csv" "$tolerance" <<'PY'
import csv, json, sys
s = json.load(open(sys.argv[1]))
calm = [float(row["max_screen_error_px"]) for row in csv.DictReader(open(sys.argv[2])) if row["tiles_wanted"] == "0"]
over = [error for error in calm if error > 1.001 * float(sys.argv[3])]
for name in ("p50", "p95", "p99", "max"):
    print(f"{s['frame_ms_' + name]:.3g}")
print(s["frames"], len(over), f"{max(over, default=0):.2g}", sep="\n")
print(s["triangles_max"], s["tiles_wanted_max"], round(s["gpu_bytes_max"] / 2**20), sep="\n")
PY
    )
    row "$quality" "$tolerance" "${values[@]}"
  done
}

# The bisected mesh twice: with the regular grid's tolerance, and with its largest error for a tolerance.
meshes() {
  printf '\nEarth, the whole grid of a tile against its bisected mesh:\n\n'
  row view mesh 'tolerance, px' 'largest error, px' triangles tiles 'frame, ms' 'times fewer triangles'
  row --- --- --- --- --- --- --- ---
  for view in "Everest,horizon 27.75,86.82,9500,20,-12,0" "Everest,50km 27.4,86.7,50000,0,-25,0" "plains,50km 60,72,50000,0,-30,0" \
    "sea,50km 10,-150,50000,0,-30,0" "globe,15000km 20,80,15000000,0,-90,0"; do
    camera=${view#* }
    read -r ms most tiles bound < <(held data/earth.toml "$camera" --mesh regular)
    row "${view%% *}" regular 1 "$bound" "$most" "$tiles" "$ms" 1
    for tolerance in 1 "$bound"; do
      read -r ms triangles tiles error < <(held data/earth.toml "$camera" --tolerance "$tolerance")
      row "${view%% *}" bisected "$tolerance" "$error" "$triangles" "$tiles" "$ms" "$(awk "BEGIN { printf \"%.1f\", $most / $triangles }")"
    done
  done
}

tolerances() {
  printf '\nEarth, frame time against tolerance:\n\n'
  row view 'tolerance, px' 'frame, ms' triangles tiles 'largest error, px'
  row --- --- --- --- --- ---
  for view in "Everest,horizon 27.75,86.82,9500,20,-12,0" "Everest,50km 27.4,86.7,50000,0,-25,0" "globe,15000km 20,80,15000000,0,-90,0"; do
    for tolerance in 0.5 1 2 4; do
      read -r ms triangles tiles error < <(held data/earth.toml "${view#* }" --tolerance "$tolerance")
      row "${view%% *}" "$tolerance" "$ms" "$triangles" "$tiles" "$error"
    done
  done
}

# Frames that may take 33 ms, along both paths.
automatic() {
  printf '\nFull quality against automatic for 33 ms:\n\n'
  row path quality 'frame ms: 50%' '95%' '99%' most 'quality, median' least frames 'triangles, most'
  row --- --- --- --- --- --- --- --- --- ---
  for flight in "earth everest_flight" "mars mars_zoom_pan_look"; do
    for quality in 1 auto; do
      "$program" bench "data/${flight% *}.toml" --path "data/${flight#* }.csv" --size "$size" --quality "$quality" \
        --plot "$plots/${flight#* }_quality_$quality.svg" --json >"$work/automatic.json"
      mapfile -t values < <(python3 - "$work/automatic.json" <<'PY'
import json, sys
s = json.load(open(sys.argv[1]))
for name in ("frame_ms_p50", "frame_ms_p95", "frame_ms_p99", "frame_ms_max", "quality_p50", "quality_min"):
    print(f"{s[name]:.3g}")
print(s["frames"], s["triangles_max"], sep="\n")
PY
      )
      row "${flight#* }" "$quality" "${values[@]}"
    done
  done
}

# The update of the cut with 500 tiles in the picture.
cut() {
  printf '\nUpdate of the cut, a flight over Everest at tolerance 1:\n\n'
  row tiling flight tiles 'median, ms' '99%, ms'
  row --- --- --- --- ---
  "$(dirname "$program")/flight_tests" --tolerance=1 |
    sed -nE 's/^([a-z]+) +(.*[a-z]) +largest jump.*; +([0-9]+) tiles, cut ([0-9.]+) ms, 99% ([0-9.]+) ms.*/| \1 | \2 | \3 | \4 | \5 |/p'
}

echo "machine: $(nproc) cores, $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1); load $(cut -d' ' -f1 /proc/loadavg)"
parts=("${@:3}")
((${#parts[@]})) || parts=(vertices path meshes tolerances automatic cut)
for part in "${parts[@]}"; do
  case $part in
    vertices | path | meshes | tolerances | automatic | cut) "$part" ;;
    *)
      echo "experiments.sh: there is no part '$part'" >&2
      exit 2
      ;;
  esac
done
