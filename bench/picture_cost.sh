#!/usr/bin/env bash
# What a frame costs with everything on (air, stars, the sea's glint, lamps) and with everything off (the plain lit
# relief). A Markdown table: medians over ROUNDS rounds, in each of which the two are measured right after each other, of
# the ratios of frame times; and instructions of a frame, the difference of 12 and 2 frames of `fly`, one thread, PNG
# included, where `perf` can count them.
#   bench/picture_cost.sh [PROGRAM] [ROUNDS]
# Needs the demo's tile databases (./bootstrap demo).
set -euo pipefail
program=$(realpath "${1:-build/release/bin/tellurion}")
rounds=${2:-5}
data=$(realpath "$(dirname "$0")/../data")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

ground=$(printf 'body = "earth"\ntiling = "cube"\n[[elevation]]\nsource = "%s/earth_elevation.tdb"\n[[imagery]]\nsource = "%s/earth_imagery.tdb"\n' "$data" "$data")
printf '%s\n' "$ground" >off.toml
printf '%s\n[[imagery]]\nsource = "%s/earth_night.tdb"\nrole = "night_lights"\n[[imagery]]\nsource = "%s/earth_sea.tdb"\nrole = "water"\n[atmosphere]\n[sky]\n' \
  "$ground" "$data" "$data" >on.toml

python3 - "$program" "$rounds" <<'PY'
import csv, os, shutil, statistics, subprocess, sys
program, rounds = sys.argv[1], int(sys.argv[2])
seconds = 8
views = {"Earth by day, 15,000 km": ("10,20,15000000,0,-90,0", "[10, 30]"),
         "Earth by night, 12,000 km": ("35,20,12000000,0,-90,0", "[10, -165]"),
         "the terminator, 9,000 km": ("40,20,9000000,0,-90,0", "[10, -60]"),
         "Alps, oblique from 50 km": ("45.0,8.0,50000,20,-35,0", "[20, -40]"),
         "Everest, horizon from 9.5 km": ("27.75,86.82,9500,20,-12,0", "[10, 60]"),
         "the sea, sunset, from 2 m": ("40,-30,2,250,4,0", "[0, -118]")}

# A machine may have perf and no counters to read.
counts_instructions = bool(shutil.which("perf")) and b"not supported" not in subprocess.run(
    ["perf", "stat", "-x,", "-e", "instructions:u", "true"], capture_output=True).stderr

def path(camera, end_s):
    """The eye moves a little: of one that stands the air's tables are kept."""
    lat, rest = camera.split(",", 1)
    with open("path.csv", "w") as file:
        file.write(f"seconds,lat,lon,height_m,heading,pitch,roll\n0,{camera}\n{end_s},{float(lat) + 1e-5},{rest}\n")

def frame_ms(scene, camera, sun):
    path(camera, seconds)
    subprocess.run([program, "bench", scene, "--path", "path.csv", "--size", "1024x768", "--set", f"light.sun={sun}",
                    "--stats", "frames.csv"], check=True, capture_output=True)
    done = [float(row["frame_ms"]) for row in csv.DictReader(open("frames.csv")) if row["complete"] == "true"]
    if len(done) < 3: sys.exit(f"{scene} was not complete within {seconds} s: too busy a machine to measure on")
    return statistics.median(done)

def instructions(scene, camera, sun):
    counted = []
    for frames in 2, 12:
        path(camera, (frames - 0.9) / 10)
        subprocess.run(["perf", "stat", "-x,", "-e", "instructions:u", "-o", "perf.csv", program, "fly", scene, "--path", "path.csv",
                        "--fps", "10", "--size", "1024x768", "--set", f"light.sun={sun}", "-o", f"frames{frames}"],
                       check=True, capture_output=True, env=os.environ | {"LP_NUM_THREADS": "1"})
        shutil.rmtree(f"frames{frames}")
        counted.append(int(next(line for line in open("perf.csv") if "instructions" in line).split(",")[0]))
    return (counted[1] - counted[0]) / 1e7

print("| view | frame time, on to off | frame ms, off | on | million instructions, off | on | on to off |")
print("| --- | --- | --- | --- | --- | --- | --- |")
for name, (camera, sun) in views.items():
    ms = [[frame_ms(scene, camera, sun) for scene in ("off.toml", "on.toml")] for _ in range(rounds)]
    ratio = statistics.median(on / off for off, on in ms)
    off_ms, on_ms = (statistics.median(column) for column in zip(*ms))
    told = " | | "
    if counts_instructions:
        off, on = (instructions(scene, camera, sun) for scene in ("off.toml", "on.toml"))
        told = f"{off:.0f} | {on:.0f} | {on / off:.2f}"
    print(f"| {name} | {ratio:.2f} | {off_ms:.1f} | {on_ms:.1f} | {told} |", flush=True)
PY
