#!/usr/bin/env bash
# What the update of the cut costs in the program, with some 500 tiles in the picture: a steady flight over Everest, 30 s at
# 500 m/s and going down from 12 km, played by `bench` as a window would, with imagery, copies to the GPU, loading and all that
# an update does. A Markdown table, a line a tiling: of ROUNDS runs the median of what each found for `update_ms`, of all
# frames once the flight is under way, and of those during which nothing was missing. For what else the machine does, the
# lowest of the runs stands beside it.
#   bench/cut_cost.sh [PROGRAM] [ROUNDS] [TILING...]
set -euo pipefail
cd "$(dirname "$0")/.."
program=$(realpath "${1:-build/release/bin/tellurion}")
rounds=${2:-3}
tilings=("${@:3}")
((${#tilings[@]})) || tilings=(geographic cube healpix)
data=$(realpath data/earth)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
for tiling in "${tilings[@]}"; do
  "$program" build "$tiling"_e.tdb "$data"/{etopo5_dem_10min.tif,srtm3_everest_N27E086_filled.tif} --kind elevation --tiling "$tiling" 2>/dev/null
  "$program" build "$tiling"_i.tdb "$data"/{bluemarble_dec2004_5400x2700.jpg,everest_landsat7_rgb_30m.tif} --kind imagery --tiling "$tiling" 2>/dev/null
  printf 'body = "earth"\ntiling = "%s"\n[[elevation]]\nsource = "%s_e.tdb"\n[[imagery]]\nsource = "%s_i.tdb"\n' \
    "$tiling" "$tiling" "$tiling" >"$tiling.toml"
done

python3 - "$program" "$rounds" "${tilings[@]}" <<'PY'
import csv, math, statistics, subprocess, sys
program, rounds, tilings = sys.argv[1], int(sys.argv[2]), sys.argv[3:]
tolerance_px = {"geographic": 1.3, "cube": 1.3, "healpix": 4.0}  # that draw some 500 tiles
settled_s = 8  # the cold start is over, also on a busy machine

with open("path.csv", "w") as path:
    path.write("seconds,lat,lon,height_m,heading,pitch,roll\n")
    for k in range(13):
        t = 2.5 * k
        path.write(f"{t},{27.25 + 500 * t / 111e3:.6f},86.6,{12000 - 60 * t},{20 + 2 * t},-20,0\n")

def percentile(values, percent):
    return sorted(values)[max(math.ceil(percent / 100 * len(values)), 1) - 1]

def flown(tiling):
    command = [program, "bench", f"{tiling}.toml", "--path", "path.csv", "--size", "1024x768", "--tolerance",
               str(tolerance_px[tiling]), "--stats", "frames.csv"]
    subprocess.run(command, check=True, capture_output=True)
    rows = [row for row in csv.DictReader(open("frames.csv")) if float(row["time_s"]) > settled_s]
    if len(rows) < 100: sys.exit(f"only {len(rows)} frames in {30 - settled_s} s: too busy a machine to measure on")
    update_ms = [float(row["update_ms"]) for row in rows]
    quiet_ms = [float(row["update_ms"]) for row in rows if row["tiles_wanted"] == "0"] or [math.nan]
    tiles = [int(row["tiles_drawn"]) for row in rows]
    return (statistics.median(tiles), statistics.median(int(row["tiles_visited"]) for row in rows), len(rows) - len(quiet_ms),
            len(rows), percentile(update_ms, 50), percentile(update_ms, 99), percentile(quiet_ms, 50), percentile(quiet_ms, 99))

print("| tiling | tiles drawn | looked at | frames that miss tiles | update ms, median (lowest run) | 99% (lowest run) | nothing missing: median | 99% |")
print("| --- | --- | --- | --- | --- | --- | --- | --- |")
for tiling in tilings:
    runs = list(zip(*[flown(tiling) for _ in range(rounds)]))
    mid = [statistics.median(column) for column in runs]
    print(f"| {tiling} | {mid[0]:.0f} | {mid[1]:.0f} | {mid[2]:.0f} of {mid[3]:.0f} | {mid[4]:.2f} ({min(runs[4]):.2f}) | "
          f"{mid[5]:.2f} ({min(runs[5]):.2f}) | {mid[6]:.2f} | {mid[7]:.2f} |", flush=True)
PY
