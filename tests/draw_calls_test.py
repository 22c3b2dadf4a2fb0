#!/usr/bin/env python3
"""The ground in at most four draw calls: the scenes of the demo, seen from where its paths and pictures look.

    draw_calls_test.py PROGRAM SOURCE_DIR WORK_DIR

The demo's tile databases are used where they have been made, else they are made in WORK_DIR. Exit status 77: no OpenGL here.
"""
import csv
import json
import pathlib
import shutil
import subprocess
import sys

from pictures_test import SKIPPED
from reference_test import EARTH, MARS

MOST_CALLS = 4
SIZE = "1024x768"
# Scene, body, tiling, paths whose points are looked from, more cameras (those of data/demo.sh).
SCENES = [("earth", "earth", "cube", ["everest_flight", "everest_turn"], ["88,0,5000000,0,-90,0", "27.4,86.7,50000,0,-25,0"]),
          ("earth_night", "earth", "cube", [], ["35,20,12000000,0,-90,0"]),
          ("mars", "mars", "healpix", ["mars_zoom_pan_look"], ["5,-100,9000000,0,-90,0"])]


def bring_databases(program, data, work, body, tiling):
    for role, rasters in (EARTH if body == "earth" else MARS).items():
        name = f"{body}_{role}.tdb"
        if (work / name).exists():
            continue
        if (data / name).exists():
            (work / name).symlink_to((data / name).resolve())
            continue
        subprocess.run([program, "build", work / name, *(data / r for r in rasters), "--kind",
                        "elevation" if role == "elevation" else "imagery", "--tiling", tiling, "--body", body], check=True,
                       stderr=subprocess.DEVNULL)


def cameras(data, paths, more):
    found = list(more)
    for path in paths:
        for row in csv.reader((data / f"{path}.csv").read_text().splitlines()[1:]):
            found.append(",".join(row[1:]))
    return sorted(set(found))


def main():
    program, data, work = sys.argv[1], pathlib.Path(sys.argv[2]) / "data", pathlib.Path(sys.argv[3])
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    failures, most, tiles = [], 0, 0
    for name, body, tiling, paths, more in SCENES:
        bring_databases(program, data, work, body, tiling)
        shutil.copy(data / f"{name}.toml", work)
        for camera in cameras(data, paths, more):
            done = subprocess.run([program, "render", work / f"{name}.toml", "--camera", camera, "--size", SIZE, "-o", work / "picture.png",
                                   "--stats", work / "stats.json"], capture_output=True, text=True)
            if done.returncode == 1 and "OpenGL" in done.stderr:
                sys.exit(SKIPPED)
            if done.returncode != 0:
                sys.exit(f"{name} from {camera}: {done.stderr}")
            stats = json.loads((work / "stats.json").read_text())
            most, tiles = max(most, stats["draw_calls"]), max(tiles, stats["tiles_drawn"])
            if not 1 <= stats["draw_calls"] <= MOST_CALLS:
                failures.append(f"{name} from {camera}: {stats['draw_calls']} draw calls for {stats['tiles_drawn']} tiles")
    print(f"at most {most} draw calls, for up to {tiles} tiles")
    sys.exit("\n".join(failures) if failures else 0)


if __name__ == "__main__":
    main()
