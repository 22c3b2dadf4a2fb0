#!/usr/bin/env bash
# The same views out of a database of 6 levels and one of 14: what a frame costs must not grow with the data. A Markdown
# table. In each of ROUNDS rounds the two are measured right after each other, and it is the ratios of the rounds whose
# median is told, for what else the machine does changes from round to round. Instructions a frame are the difference of a
# long and a short run, so that loading does not count; without `perf` they are left out.
#   bench/flat_cost.sh FOLDER_WITH_DATA [PROGRAM] [ROUNDS]
# (earth/etopo5_dem_5min.tif, earth/bluemarble_dec2004_5400x2700.jpg, earth/srtm3_everest_N27E086.tif,
# earth/portland_ned_dem_third_as.tif)
set -euo pipefail
data=${1:?usage: bench/flat_cost.sh FOLDER_WITH_DATA [PROGRAM] [ROUNDS]}
program=$(realpath "${2:-build/release/bin/tellurion}")
rounds=${3:-5}
data=$(realpath "$data")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"$program" build 6.tdb "$data/earth/etopo5_dem_5min.tif" --kind elevation --max-level 5 2>/dev/null
"$program" build 14.tdb "$data"/earth/{etopo5_dem_5min.tif,srtm3_everest_N27E086.tif,portland_ned_dem_third_as.tif} \
  --kind elevation --max-level 13 2>/dev/null
"$program" build i.tdb "$data/earth/bluemarble_dec2004_5400x2700.jpg" --kind imagery 2>/dev/null
for levels in 6 14; do
  printf 'body = "earth"\ntiling = "cube"\n[[elevation]]\nsource = "%s.tdb"\n[[imagery]]\nsource = "i.tdb"\n' $levels > $levels.toml
done

python3 - "$program" "$rounds" <<'PY'
import csv, shutil, statistics, subprocess, sys
program, rounds = sys.argv[1], int(sys.argv[2])
short_s, long_s = 5, 12
views = {"whole globe, 15,000 km": "20,10,15000000,0,-90,0",
         "India and the Himalaya, 2,000 km": "22,84,2000000,10,-70,0",
         "Alps, oblique from 50 km": "46.0,8.0,50000,20,-35,0",
         "Alps, horizon from 4 km": "46.6,8.0,4000,20,-3,0"}
counts_instructions = bool(shutil.which("perf"))

def run(scene, camera, seconds):
    """Frames, and instructions of the whole run."""
    with open("path.csv", "w") as path:
        path.write(f"seconds,lat,lon,height_m,heading,pitch,roll\n0,{camera}\n{seconds},{camera}\n")
    command = [program, "bench", scene, "--path", "path.csv", "--size", "1024x768", "--stats", "frames.csv"]
    if counts_instructions:
        command = ["perf", "stat", "-x,", "-e", "instructions:u", "-o", "perf.csv"] + command
    subprocess.run(command, check=True, capture_output=True)
    rows = list(csv.DictReader(open("frames.csv")))
    counted = 0
    if counts_instructions:
        counted = int(next(line for line in open("perf.csv") if "instructions" in line).split(",")[0])
    return rows, counted

def measured(scene, camera):
    """Milliseconds a frame once the view is complete, instructions a frame, and the last frame's figures."""
    few, few_instructions = run(scene, camera, short_s)
    rows, instructions = run(scene, camera, long_s)
    done = next((i for i, row in enumerate(rows) if row["complete"] == "true"), None)
    if done is None or done + 1 >= len(rows): sys.exit(f"{scene} was not complete within {long_s} s: too busy a machine to measure on")
    a_frame = (instructions - few_instructions) / max(len(rows) - len(few), 1)
    return statistics.median(float(row["frame_ms"]) for row in rows[done + 1:]), a_frame, rows[-1]

print("| view | frame time, 14 levels to 6 | instructions a frame | frame ms, 6 levels | triangles, 6 levels | 14 levels | "
      "tiles, 6 levels | 14 levels |")
print("| --- | --- | --- | --- | --- | --- | --- | --- |")
for name, camera in views.items():
    times, instructions, ms = [], [], []
    for _ in range(rounds):
        few, many = measured("6.toml", camera), measured("14.toml", camera)
        ms.append(few[0])
        times.append(many[0] / few[0])
        if counts_instructions: instructions.append(many[1] / few[1])
    told = f"{statistics.median(instructions):.2f}" if instructions else ""
    last = few[2], many[2]
    print(f"| {name} | {statistics.median(times):.2f} | {told} | {statistics.median(ms):.1f} | {last[0]['triangles']} | "
          f"{last[1]['triangles']} | {last[0]['tiles_drawn']} | {last[1]['tiles_drawn']} |", flush=True)
PY
