#!/usr/bin/env python3
"""Pictures of the embedded data against pictures that somebody looked at (tests/pictures).

    reference_test.py PROGRAM SOURCE_DIR WORK_DIR [--accept]

Two thresholds: the mean difference of all channels, which a wrong light or a shifted coast passes, and the share of pixels
that are far off, which a hole, a seam or a missing tile passes. A picture that fails is left in WORK_DIR beside a
difference. --accept writes what is drawn now as the reference: look at it first. Exit status 77: no OpenGL here.
"""
import pathlib
import shutil
import subprocess
import sys

from pictures_test import SKIPPED, png_pixels

MEAN_LEVELS = 1.5       # of 255; another driver's rounding stays under 0.5
FAR_LEVELS = 40
FAR_SHARE = 0.004
SIZE = "320x240"

EARTH = {"elevation": ["earth/etopo5_dem_10min.tif", "earth/srtm3_everest_N27E086_filled.tif"],
         "imagery": ["earth/bluemarble_dec2004_5400x2700.jpg", "earth/everest_landsat7_rgb_30m.tif"],
         "night": ["earth/night_lights_5400x2700.jpg"]}
MARS = {"elevation": ["mars/mola_dem_4ppd.tif"], "imagery": ["mars/viking_mdim21_color_2880x1440.jpg"]}

# Name, body, tiling, camera, light.
PICTURES = [
    ("earth_orbit", "earth", "cube", "20,80,15000000,0,-90,0", ""),
    ("everest", "earth", "cube", "27.75,86.82,9500,20,-12,0", ""),
    ("everest_near", "earth", "cube", "27.955,86.87,7200,60,-5,0", ""),
    ("north_pole_cube", "earth", "cube", "88,0,4000000,0,-90,0", ""),
    ("north_pole_geographic", "earth", "geographic", "88,0,4000000,0,-90,0", ""),
    ("south_pole_geographic", "earth", "geographic", "-88,0,4000000,0,-90,0", ""),
    ("south_pole_healpix", "earth", "healpix", "-88,0,4000000,0,-90,0", ""),
    ("date_line_geographic", "earth", "geographic", "-18,179,3000000,0,-90,0", ""),
    ("night", "earth", "cube", "35,20,12000000,0,-90,0", "[light]\nsun = [10.0, -165.0]\n"),
    ("mars_healpix", "mars", "healpix", "5,-100,9000000,0,-90,0", ""),
    ("valles_marineris", "mars", "healpix", "-16,-68,300000,20,-30,0", ""),
]


def databases(program, source, work, body, tiling):
    """The scene's layers as tile databases in `work`, made once."""
    layers = EARTH if body == "earth" else MARS
    paths = {}
    for role, rasters in layers.items():
        paths[role] = work / f"{body}_{tiling}_{role}.tdb"
        if not paths[role].exists():
            kind = "elevation" if role == "elevation" else "imagery"
            # The Earth is seen from nearby on the cube only; on the others nothing finer than 4 km can show.
            depth = [] if body == "mars" or tiling == "cube" else ["--max-level", 4]
            subprocess.run([program, "build", paths[role], *(source / "data" / r for r in rasters), "--kind", kind, "--tiling", tiling,
                            "--body", body, *map(str, depth)], check=True, stderr=subprocess.DEVNULL)
    return paths


def scene_text(body, tiling, paths, light):
    text = f'body = "{body}"\ntiling = "{tiling}"\n[[elevation]]\nsource = "{paths["elevation"]}"\n'
    text += f'[[imagery]]\nsource = "{paths["imagery"]}"\n'
    if "night" in paths:
        text += f'[[imagery]]\nsource = "{paths["night"]}"\nrole = "night_lights"\n'
    return text + light


def difference(drawn, expected):
    """(mean difference of a channel, share of pixels that are far off)."""
    width, height, rows = png_pixels(drawn)
    other_width, other_height, other_rows = png_pixels(expected)
    assert (width, height) == (other_width, other_height), "another size"
    total, far = 0, 0
    for row, other in zip(rows, other_rows):
        for pixel, reference in zip(row, other):
            off = [abs(a - b) for a, b in zip(pixel, reference)]
            total += sum(off)
            far += max(off) > FAR_LEVELS
    return total / (3 * width * height), far / (width * height)


def main():
    accept = "--accept" in sys.argv
    program, source, work = sys.argv[1], pathlib.Path(sys.argv[2]).resolve(), pathlib.Path(sys.argv[3]).resolve()
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    failed = 0
    for name, body, tiling, camera, light in PICTURES:
        scene, drawn, expected = work / f"{name}.toml", work / f"{name}.png", source / "tests" / "pictures" / f"{name}.png"
        scene.write_text(scene_text(body, tiling, databases(program, source, work, body, tiling), light))
        done = subprocess.run([program, "render", scene, "--camera", camera, "--size", SIZE, "-o", drawn], capture_output=True, text=True)
        if "OpenGL" in done.stderr or "EGL" in done.stderr:
            print(done.stderr)
            return SKIPPED
        assert done.returncode == 0, done.stderr
        if accept:
            shutil.copy(drawn, expected)
            continue
        mean, far = difference(drawn, expected)
        fine = mean <= MEAN_LEVELS and far <= FAR_SHARE
        failed += not fine
        print(f"{'ok   ' if fine else 'FAULT'} {name}: mean {mean:.3f} of {MEAN_LEVELS} levels, {100 * far:.3f}% of {100 * FAR_SHARE}% far off")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
