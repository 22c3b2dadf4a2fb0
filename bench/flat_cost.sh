#!/usr/bin/env bash
# The same views out of a database of 6 levels and one of 14: what a frame costs must not grow with the data. A Markdown
# table; the two are measured in turn, ROUNDS times each, and compared by their medians.
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
import csv, statistics, subprocess, sys
program, rounds = sys.argv[1], int(sys.argv[2])
views = {"whole globe, 15,000 km": "20,10,15000000,0,-90,0",
         "India and the Himalaya, 2,000 km": "22,84,2000000,10,-70,0",
         "Alps, oblique from 50 km": "46.0,8.0,50000,20,-35,0",
         "Alps, horizon from 4 km": "46.6,8.0,4000,20,-3,0"}
def frames(scene, camera):
    with open("path.csv", "w") as path:
        path.write(f"seconds,lat,lon,height_m,heading,pitch,roll\n0,{camera}\n8,{camera}\n")
    subprocess.run([program, "bench", scene, "--path", "path.csv", "--size", "1024x768", "--stats", "frames.csv"],
                   check=True, capture_output=True)
    rows = list(csv.DictReader(open("frames.csv")))
    done = next(i for i, row in enumerate(rows) if row["complete"] == "true")
    return [float(row["frame_ms"]) for row in rows[done + 1:]], rows[-1]
print("| view | frame ms, 6 levels | 14 levels | ratio | triangles, 6 levels | 14 levels | tiles, 6 levels | 14 levels |")
print("| --- | --- | --- | --- | --- | --- | --- | --- |")
for name, camera in views.items():
    times, last = {6: [], 14: []}, {}
    for _ in range(rounds):
        for depth in (6, 14):
            found, last[depth] = frames(f"{depth}.toml", camera)
            times[depth].append(statistics.median(found))
    few, many = (statistics.median(times[depth]) for depth in (6, 14))
    print(f"| {name} | {few:.1f} | {many:.1f} | {many / few:.2f} | {last[6]['triangles']} | {last[14]['triangles']} | "
          f"{last[6]['tiles_drawn']} | {last[14]['tiles_drawn']} |", flush=True)
PY
