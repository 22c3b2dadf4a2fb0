#!/usr/bin/env bash
# Three views of a planet with a global 5' elevation model and a 5400 x 2700 image, at 1024 x 768: frame time, triangles,
# how long a cold start takes until the picture is complete, the worst frame while loading, memory. A Markdown table.
#   bench/global_views.sh FOLDER_WITH_DATA [PROGRAM]      (earth/etopo5_dem_5min.tif, earth/bluemarble_dec2004_5400x2700.jpg)
set -euo pipefail
data=${1:?usage: bench/global_views.sh FOLDER_WITH_DATA [PROGRAM]}
program=$(realpath "${2:-build/release/bin/tellurion}")
data=$(realpath "$data")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"$program" build e.tdb "$data/earth/etopo5_dem_5min.tif" --kind elevation 2>/dev/null
"$program" build i.tdb "$data/earth/bluemarble_dec2004_5400x2700.jpg" --kind imagery 2>/dev/null
printf 'body = "earth"\ntiling = "cube"\n[[elevation]]\nsource = "e.tdb"\n[[imagery]]\nsource = "i.tdb"\n' > s.toml

echo '| view | frame ms, median | triangles | complete after s | worst frame ms while loading | max error px | resident MB |'
echo '| --- | --- | --- | --- | --- | --- | --- |'
measure() {
  printf 'seconds,lat,lon,height_m,heading,pitch,roll\n0,%s\n5,%s\n' "$2" "$2" > path.csv
  python3 - "$program" "$1" "$2" <<'PY'
import csv, json, resource, statistics, subprocess, sys
program, name, camera = sys.argv[1:]
subprocess.run([program, "bench", "s.toml", "--path", "path.csv", "--size", "1024x768", "--stats", "frames.csv"],
               check=True, capture_output=True)
frames = [{k: float(v) if v not in ("true", "false") else v == "true" for k, v in row.items()}
          for row in csv.DictReader(open("frames.csv"))]
done = next(i for i, f in enumerate(frames) if f["complete"])
steady = [f["frame_ms"] for f in frames[done + 30:]]
resident = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
print(f"| {name} | {statistics.median(steady):.1f} | {frames[-1]['triangles']:.0f} | {frames[done]['time_s']:.2f} | "
      f"{max(f['frame_ms'] for f in frames[:done + 1]):.0f} | {frames[-1]['max_screen_error_px']:.2f} | {resident:.0f} |")
PY
}
measure 'whole globe, 15,000 km' 20,10,15000000,0,-90,0
measure 'oblique, 50 km' 46.0,8.0,50000,20,-35,0
measure 'horizon, 2 km above the ground' 46.6,8.0,4000,20,-3,0
