#!/usr/bin/env python3
"""--no-morph makes the difference that it says: without, ground grows into finer levels; with it, it pops.

    no_morph_test.py PROGRAM SOURCE_DIR WORK_DIR

A descent over Mars straight down, by an octave, in small steps: the height of the ground under each pixel changes from
step to step by what the pixels move aside, and with --no-morph by what a level is off as well. Heights drawn ten times
as high with few tiles are drawn coarser, with a warning. Exit status 77 (skipped) where there is no OpenGL.
"""
import json
import math
import pathlib
import shutil
import subprocess
import sys

from pictures_test import tiff_floats

SKIPPED = 77
SIZE = 24
FOV_DEGREES = 3.0
TOLERANCE_PX = 8.0
STEPS = 24
CLEARLY = 3.0  # times as far, at least, goes ground that pops


def run(program, *words):
    return subprocess.run([program, *map(str, words)], capture_output=True, text=True, timeout=300, check=False)


class Descent:
    def __init__(self, program, work):
        self.program, self.work, self.database = program, work, work / "mars.tdb"

    def ground(self, height_m, *options):
        """Heights of the ground under all pixels, metres, and the figures of the picture."""
        depth, stats = self.work / "depth.tif", self.work / "stats.json"
        done = run(self.program, "render", self.database, "--camera", f"-7,-90,{height_m},0,-90,0", "--size", f"{SIZE}x{SIZE}", "--fov",
                   FOV_DEGREES, "--tolerance", TOLERANCE_PX, "-o", self.work / "picture.png", "--depth", depth, "--stats", stats, *options)
        assert done.returncode == 0, done.stderr
        width, height, rows = tiff_floats(depth)
        assert (width, height) == (SIZE, SIZE)
        pixel = 2.0 * math.tan(math.radians(FOV_DEGREES / 2.0)) / SIZE
        heights = []
        for row in range(SIZE):
            for col in range(SIZE):
                aside = pixel * math.hypot(col + 0.5 - SIZE / 2, row + 0.5 - SIZE / 2)
                heights.append(height_m - rows[row][col] / math.hypot(1.0, aside))
        return heights, json.loads(stats.read_text())

    def largest_step(self, *options):
        """The furthest that the ground under a pixel goes in one step, in widths of a pixel."""
        heights = [600e3 * 0.5 ** (i / STEPS) for i in range(STEPS + 1)]
        pixel = math.radians(FOV_DEGREES) / SIZE
        before, largest = None, 0.0
        for height_m in heights:
            now, figures = self.ground(height_m, *options)
            assert figures["max_screen_error_px"] <= TOLERANCE_PX * (1 + 1e-6), figures
            if before is not None:
                largest = max(largest, max(abs(a - b) for a, b in zip(now, before)) / (height_m * pixel))
            before = now
        return largest


def main():
    program, source, work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    descent = Descent(program, work)
    built = run(program, "build", descent.database, source / "data/mars/mola_dem_4ppd.tif", "--kind", "elevation", "--body", "mars")
    assert built.returncode == 0, built.stderr
    probe = run(program, "render", descent.database, "--camera", "0,0,9e6", "--size", "8x8", "-o", work / "probe.png")
    if probe.returncode != 0 and ("OpenGL" in probe.stderr or "EGL" in probe.stderr):
        print("skipped: no OpenGL here:", probe.stderr.strip())
        return SKIPPED
    grows, pops = descent.largest_step(), descent.largest_step("--no-morph")
    print(f"largest step of the ground: {grows:.3f} pixels; with --no-morph {pops:.3f} pixels")
    assert pops > CLEARLY * grows, "--no-morph makes no clear difference"

    view = ["--camera", "-7,-90,300000,0,-60,0", "--size", "320x240", "-o", work / "high.png", "--stats", work / "high.json"]
    errors = {}
    for exaggeration in (1, 10):
        done = run(program, "render", descent.database, *view, "--exaggeration", exaggeration, "--max-tiles", 100)
        assert done.returncode == 0, done.stderr
        figures = json.loads((work / "high.json").read_text())
        errors[exaggeration] = figures["max_screen_error_px"]
        assert ("warning" in done.stderr) == (exaggeration == 10), done.stderr
        assert figures["complete"] == (exaggeration == 1), figures
    print(f"100 tiles: off by {errors[1]:.2f} pixels, ten times as high by {errors[10]:.2f}")
    assert errors[1] <= 1.0 + 1e-6 < errors[10]
    return 0


if __name__ == "__main__":
    sys.exit(main())
