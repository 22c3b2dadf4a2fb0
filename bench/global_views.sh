#!/usr/bin/env bash
# Three views of a planet with a global 5' elevation model and a 5400 x 2700 image, at 1024 x 768: frame time, triangles,
# how long a cold start takes until the picture is complete, the worst frame while loading, memory: VmRSS once the picture
# stands and its peak VmHWM, both with shared libraries, and the part of it that stands for GPU memory. A Markdown table.
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

echo '| view | frame ms, median | triangles | complete after s | worst frame ms while loading | max error px | resident MiB | peak MiB | of it for the GPU |'
echo '| --- | --- | --- | --- | --- | --- | --- | --- | --- |'
measure() {
  printf 'seconds,lat,lon,height_m,heading,pitch,roll\n0,%s\n5,%s\n' "$2" "$2" > path.csv
  python3 - "$program" "$1" "$2" <<'PY'
import csv, pathlib, statistics, subprocess, sys, time
program, name, camera = sys.argv[1:]
bench = subprocess.Popen([program, "bench", "s.toml", "--path", "path.csv", "--size", "1024x768", "--stats", "frames.csv"],
                         stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
resident, peak = [], 0
while bench.poll() is None:
    status = dict(line.split(":", 1) for line in pathlib.Path(f"/proc/{bench.pid}/status").read_text().splitlines())
    if "VmRSS" in status:
        resident.append(int(status["VmRSS"].split()[0]) / 1024)
        peak = max(peak, int(status["VmHWM"].split()[0]) / 1024)
    time.sleep(0.02)
if bench.returncode != 0:
    sys.exit(f"bench failed with {bench.returncode}")
frames = [{k: float(v) if v not in ("true", "false") else v == "true" for k, v in row.items()}
          for row in csv.DictReader(open("frames.csv"))]
done = next(i for i, f in enumerate(frames) if f["complete"])
steady = [f["frame_ms"] for f in frames[done + 30:]]
print(f"| {name} | {statistics.median(steady):.1f} | {frames[-1]['triangles']:.0f} | {frames[done]['time_s']:.2f} | "
      f"{max(f['frame_ms'] for f in frames[:done + 1]):.0f} | {frames[-1]['max_screen_error_px']:.2f} | "
      f"{statistics.median(resident[len(resident) // 2:]):.0f} | {peak:.0f} | {frames[-1]['gpu_bytes'] / 2**20:.0f} |")
PY
}
measure 'whole globe, 15,000 km' 20,10,15000000,0,-90,0
measure 'oblique, 50 km' 46.0,8.0,50000,20,-35,0
measure 'horizon, 2 km above the ground' 46.6,8.0,4000,20,-3,0
