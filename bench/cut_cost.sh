#!/usr/bin/env bash
# What the update of the cut costs in the program, with some 500 tiles in the picture: a steady flight over Everest, 30 s,
# played by `bench` as a window would, with imagery, copies to the GPU, loading and all that an update does. Twice: at 125 m/s,
# where a processor that draws 15 frames a second moves from frame to frame as 500 m/s do at 60; and at 500 m/s, four times
# as far a frame, which is too far for a cut to be kept. A Markdown table, a line a flight and tiling: of ROUNDS runs the median
# of what each found for `update_ms`, of all frames once the flight is under way, and of those during which nothing was
# missing. For what else the machine does, the lowest of the runs stands beside it.
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
tolerance_px = {"geographic": 0.85, "cube": 0.8, "healpix": 1.4}  # that draw some 500 tiles
settled_s = 8  # the cold start is over, also on a busy machine

def write_path(speed_m_s):
    share = speed_m_s / 500
    with open("path.csv", "w") as path:
        path.write("seconds,lat,lon,height_m,heading,pitch,roll\n")
        for k in range(13):
            t = 2.5 * k
            s = 15 + share * (t - 15)  # the middle is that of all flights
            path.write(f"{t},{27.25 + 500 * s / 111e3:.6f},86.6,{12000 - 60 * s},{20 + 2 * s},-20,0\n")

def percentile(values, percent):
    return sorted(values)[max(math.ceil(percent / 100 * len(values)), 1) - 1]

def flown(tiling):
    command = [program, "bench", f"{tiling}.toml", "--path", "path.csv", "--size", "1024x768", "--tolerance",
               str(tolerance_px[tiling]), "--stats", "frames.csv"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0: sys.exit(f"{' '.join(command)}: {done.stderr}")
    rows = [row for row in csv.DictReader(open("frames.csv")) if float(row["time_s"]) > settled_s]
    if len(rows) < 100: sys.exit(f"only {len(rows)} frames in {30 - settled_s} s: too busy a machine to measure on")
    update_ms = [float(row["update_ms"]) for row in rows]
    quiet_ms = [float(row["update_ms"]) for row in rows if row["tiles_wanted"] == "0"] or [math.nan]
    tiles = [int(row["tiles_drawn"]) for row in rows]
    return (statistics.median(tiles), statistics.median(int(row["tiles_visited"]) for row in rows), len(rows) - len(quiet_ms),
            len(rows), percentile(update_ms, 50), percentile(update_ms, 99), percentile(quiet_ms, 50), percentile(quiet_ms, 99))

print("| m/s | tiling | tiles drawn | looked at | frames that miss tiles | update ms, median (lowest run) | 99% (lowest run) | nothing missing: median | 99% |")
print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
for speed_m_s, tiling in ((speed_m_s, tiling) for speed_m_s in (125, 500) for tiling in tilings):
    write_path(speed_m_s)
    runs = list(zip(*[flown(tiling) for _ in range(rounds)]))
    mid = [statistics.median(column) for column in runs]
    print(f"| {speed_m_s} | {tiling} | {mid[0]:.0f} | {mid[1]:.0f} | {mid[2]:.0f} of {mid[3]:.0f} | {mid[4]:.2f} ({min(runs[4]):.2f}) | "
          f"{mid[5]:.2f} ({min(runs[5]):.2f}) | {mid[6]:.2f} | {mid[7]:.2f} |", flush=True)
PY
