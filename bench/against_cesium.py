#!/usr/bin/env python3
"""CesiumJS in a browser and this program: the same data, views and measures, in turn. Prints Markdown tables.

  bench/against_cesium.py FOLDER WORK [--programs BIN] [--rounds 3] [--views NAME,...] [--sides NAME,...] [--gl gl-egl]

FOLDER is the developers' collection of data (earth/etopo5_dem_5min.tif, earth/bluemarble_dec2004_5400x2700.jpg); WORK a folder
for what is fetched (CesiumJS, with npm, once), made (tiles, 0.5 GB) and measured (results.json, pictures); BIN, build/release/bin,
holds tellurion and depth_errors. Needs npm, chromium, GDAL's programs and its Python module (so run it with /usr/bin/python3).
--gl is what the browser's ANGLE draws with: gl-egl is Mesa's llvmpipe, as here; swiftshader is its own.

Both draw 1024 x 768 pixels, 45 degrees high, without sky, sun, fog and smoothing of edges. Grids and meshes: bench/against_cesium.html.
A frame is over when it can be read back. Processor time is that of all processes of a side, and other work spoils it
less than the clock. --rounds 0 tells the last results again. Errors are what depth_errors says of depth at every 16th pixel: against the raster, bilinear between its
samples, and, of ours, against what its finest tiles hold, bilinear likewise (theirs hold triangles, and draw the very ones).
"""
import argparse
import csv
import json
import pathlib
import statistics
import subprocess
import sys
import time

import browser_session
from browser_session import memory_mib, processor_s

VERSION = "1.140.0"
SIZE = "1024x768"
FOV = 45
STRIDE = 16
FRAMES = 30  # of theirs, once complete
PLAYED_S = 16  # ours, as in a window; longer where it is not complete by then
IMAGE_LEVEL = 4  # the first that is as fine as the image
POSTS_LEVEL = 6  # likewise as the raster, in tiles of 65 x 65 posts
VIEWS = {
    "globe": ("whole globe, 15,000 km", "20,10,15000000,0,-90,0"),
    "oblique": ("oblique, 50 km", "46.0,8.0,50000,20,-35,0"),
    "horizon": ("horizon, 2 km above the ground", "46.6,8.0,4000,20,-3,0"),
}
# Places that the views need more of than the raster's samples, bilinear between them: west, south, east, north, samples
# for one of the raster.
WINDOWS = {"wide": (3, 44, 15, 51, 32), "near": (7.75, 46.5, 8.45, 46.9, 512)}


def theirs(**asked):
    return {"deepest": POSTS_LEVEL, "finest_m": 1, "fog": False, "screenError": 2, **asked}


def ours(scene, tolerance):
    return {"scene": scene, "tolerance": tolerance}


# name: what the table says, what is asked of it, the surface that its finest tiles hold, where it is one to measure against.
SIDES = {
    "ours": ("ours, tiles to the raster's level", ours("tiles.toml", 1), "tiles.tdb"),
    "meshes": ("CesiumJS, meshes to the raster's level", theirs(), None),
    "fog": ("the same with fog", theirs(fog=True), None),
    "deep": ("ours, tiles as deep as needed", ours("deep.toml", 1), "raster"),
    "deep5": ("the same, `--tolerance` 0.5 in place of 1", ours("deep.toml", 0.5), "raster"),
    "grids": ("CesiumJS, grids as deep as needed", theirs(deepest=None), "raster"),
    "grids8": ("the same, `maximumScreenSpaceError` 8 in place of 2", theirs(deepest=None, screenError=8), "raster"),
    "grids32": ("the same, 32", theirs(deepest=None, screenError=32), "raster"),
}


def run(*command, **options):
    return subprocess.run([str(c) for c in command], check=True, **options)


class Setup:
    """The folders and what is in them. Makes what is not there yet; a file that is there is whole."""

    def __init__(self, arguments):
        self.work, self.programs, self.gl = arguments.work.resolve(), arguments.programs.resolve(), arguments.gl
        self.elevation = arguments.data.resolve() / "earth/etopo5_dem_5min.tif"
        self.image = arguments.data.resolve() / "earth/bluemarble_dec2004_5400x2700.jpg"
        self.raster = {"cols": 4320, "rows": 2161, "west": -180, "north": 90, "step": 1 / 12}
        self.cesium = self.work / "npm/node_modules/cesium/Build/Cesium"
        self.work.mkdir(parents=True, exist_ok=True)
        if not self.cesium.is_dir():
            (self.work / "npm").mkdir(exist_ok=True)
            run("npm", "install", "--silent", "--no-save", "--prefix", self.work / "npm", f"cesium@{VERSION}")
        self.make("raster.bin", lambda part: run("gdal_translate", "-q", "-of", "ENVI", "-ot", "Int16", self.elevation, part))
        self.make("image", lambda part: run("gdal2tiles.py", "-q", "-p", "geodetic", "--tmscompatible", "--s_srs", "EPSG:4326", "-r",
                                            "average", "-w", "none", "-z", f"0-{IMAGE_LEVEL}", self.image, part))
        for name, (west, south, east, north, finer) in WINDOWS.items():
            self.make(f"{name}.tif", lambda part: self.resample(part, west, south, east, north, self.raster["step"] / finer))
        self.make("image.tdb", lambda part: self.build(part, "imagery", self.image))
        self.make("tiles.tdb", lambda part: self.build(part, "elevation", self.elevation))
        self.make("deep.tdb", lambda part: self.build(part, "elevation", self.elevation, *(self.work / f"{name}.tif" for name in WINDOWS)))
        for name in "tiles", "deep":
            (self.work / f"{name}.toml").write_text(
                f'body = "earth"\ntiling = "cube"\n[[elevation]]\nsource = "{name}.tdb"\n[[imagery]]\nsource = "image.tdb"\n')

    def make(self, name, maker):
        if (self.work / name).exists():
            return
        print(f"making {name}", file=sys.stderr)
        part = self.work / ("part_" + name)
        maker(part)
        part.rename(self.work / name)

    def resample(self, part, west, south, east, north, step):
        """Samples on the edges too, bilinear between those of the raster."""
        half = step / 2
        run("gdalwarp", "-q", "-overwrite", "-r", "bilinear", "-ot", "Float32", "-te", west - half, south - half, east + half, north + half,
            "-tr", step, step, "-co", "COMPRESS=DEFLATE", self.elevation, part)

    def build(self, part, kind, *inputs):
        run(self.programs / "tellurion", "build", part, *inputs, "--kind", kind, "--tiling", "cube", stderr=subprocess.DEVNULL)

    def surface(self, name):
        return self.elevation if name == "raster" else self.work / name


def measure_theirs(setup, side, view, camera, depth):
    asked = {**SIDES[side][1], "camera": [float(x) for x in camera.split(",")], "verticalFov": FOV, "frames": FRAMES, "stride": STRIDE,
             "imageLevel": IMAGE_LEVEL, "raster": setup.raster, "depth": depth}
    folders = {"cesium": setup.cesium, "image": setup.work / "image", "raster.bin": setup.work / "raster.bin"}
    result, steady = browser_session.measured(pathlib.Path(__file__).with_suffix(".html"), folders, asked, setup.work, setup.gl,
                                              setup.work / f"{side}_{view}.png")
    begin, end = steady["begins"], steady["ends"]
    return {
        "frame_ms": statistics.median(result["times"]),
        "processor_ms": 1000 * (end["processor_s"] - begin["processor_s"]) / FRAMES,
        "triangles": result["triangles"],
        "complete_s": result["complete_ms"] / 1000,
        "worst_ms": result["worst_ms"],
        "resident_mib": end["drawing_mib"],
        "depth": result["depth"].lower() if depth else None,
        "meshes": result["meshes"].lower() if depth else None,
        "draws_with": f"CesiumJS {result['version']}, {result['gl']}",
    }


def is_ours(side):
    return "scene" in SIDES[side][1]


def words(side):
    return [SIDES[side][1]["scene"], "--tolerance", str(SIDES[side][1]["tolerance"])]


def measure_ours(setup, side, view, camera, depth, played_s=PLAYED_S):
    work = setup.work
    (work / "path.csv").write_text(f"seconds,lat,lon,height_m,heading,pitch,roll\n0,{camera}\n{played_s},{camera}\n")
    bench = subprocess.Popen([setup.programs / "tellurion", "bench", *words(side), "--path", "path.csv", "--size", SIZE, "--fov", str(FOV), "--stats",
                              "frames.csv"], cwd=work, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    samples = []  # clock, processor seconds, resident MiB
    while bench.poll() is None:
        samples.append((time.monotonic(), processor_s(bench.pid), memory_mib(bench.pid)))
        time.sleep(0.02)
    if bench.returncode != 0:
        sys.exit(f"against_cesium.py: tellurion bench ended with {bench.returncode}; run it by hand in {work}")
    samples = [s for s in samples if s[2] > 0]
    with open(work / "frames.csv") as file:
        frames = list(csv.DictReader(file))
    done = next((i for i, f in enumerate(frames) if f["complete"] == "true"), None)
    if done is None or float(frames[done]["time_s"]) > played_s - 4:  # the machine is busy
        return measure_ours(setup, side, view, camera, depth, 2 * played_s)
    steady = [float(f["frame_ms"]) for f in frames[done + 10:]]
    last = samples[-1]
    first = next(s for s in samples if s[0] > last[0] - 2.0)
    counted = sum(float(f["time_s"]) > float(frames[-1]["time_s"]) - (last[0] - first[0]) for f in frames)
    return {
        "frame_ms": statistics.median(steady),
        "processor_ms": 1000 * (last[1] - first[1]) / counted,
        "triangles": float(frames[-1]["triangles"]),
        "complete_s": float(frames[done]["time_s"]) + float(frames[done]["frame_ms"]) / 1000,
        "worst_ms": max(float(f["frame_ms"]) for f in frames[:done + 1]),
        "resident_mib": statistics.median(s[2] for s in samples[len(samples) // 2:]),
        "depth": depth_of_ours(setup, side, view, camera) if depth else None,
        "draws_with": run(setup.programs / "tellurion", "--version", stdout=subprocess.PIPE, text=True).stdout.strip(),
    }


def depth_of_ours(setup, side, view, camera):
    from osgeo import gdal
    gdal.UseExceptions()
    run(setup.programs / "tellurion", "render", *words(side), "--camera", camera, "--size", SIZE, "--fov", FOV, "-o", f"{side}_{view}.png",
        "--depth", "depth.tif", cwd=setup.work, stderr=subprocess.DEVNULL)
    depth = gdal.Open(str(setup.work / "depth.tif")).ReadAsArray()
    rows, cols = depth.shape
    return "".join(f"{col} {row} {depth[row, col]}\n" for row in range(STRIDE // 2, rows, STRIDE) for col in range(STRIDE // 2, cols, STRIDE))


def errors(setup, surface, camera, drawn):
    return json.loads(run(setup.programs / "depth_errors", setup.surface(surface), camera, SIZE, FOV, input=drawn, stdout=subprocess.PIPE,
                          text=True).stdout)


def tell(results, sides):
    print("| view | | frame ms | processor ms a frame | triangles | complete after s | worst frame ms while loading | resident MiB | "
          "error to the raster px: median, 99%, worst | to its finest tiles |")
    print("|" + " --- |" * 10)
    for view, (title, _) in VIEWS.items():
        for side in sides:
            rounds = results.get(f"{view} {side}")
            if not rounds:
                continue
            of = lambda name: statistics.median(r[name] for r in rounds)  # noqa: E731
            px = [f"{e['median_px']:.2f}, {e['p99_px']:.2f}, {e['worst_px']:.2f}" if surface else "-"
                  for e, surface in ((rounds[0]["to_raster"], True), (rounds[0]["to_finest"], SIDES[side][2]))]
            print(f"| {title} | {side}: {SIDES[side][0]} | {of('frame_ms'):.1f} | {of('processor_ms'):.1f} | {of('triangles'):.0f} | {of('complete_s'):.2f} | "
                  f"{of('worst_ms'):.0f} | {of('resident_mib'):.0f} | {px[0]} | {px[1]} |")
    print("\nTheirs over ours, medians over the rounds of the ratio in a round:\n")
    print("| view | theirs | ours | frame time | processor time |\n| --- | --- | --- | --- | --- |")
    for view, (title, _) in VIEWS.items():
        for other in (s for s in sides if not is_ours(s)):
            for own in (s for s in sides if is_ours(s) and (SIDES[s][2] == "raster") == (SIDES[other][2] == "raster")):
                pairs = list(zip(results.get(f"{view} {other}", []), results.get(f"{view} {own}", [])))
                if pairs:
                    ratio = [statistics.median(t[name] / o[name] for t, o in pairs) for name in ("frame_ms", "processor_ms")]
                    print(f"| {title} | {other} | {own} | {ratio[0]:.1f} | {ratio[1]:.1f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("work", type=pathlib.Path)
    parser.add_argument("--programs", type=pathlib.Path, default=pathlib.Path("build/release/bin"))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--views", default=",".join(VIEWS))
    parser.add_argument("--sides", default=",".join(SIDES))
    parser.add_argument("--gl", default="gl-egl", choices=("gl-egl", "swiftshader"))
    arguments = parser.parse_args()
    views, sides = arguments.views.split(","), arguments.sides.split(",")
    if unknown := [name for name in views if name not in VIEWS] + [name for name in sides if name not in SIDES]:
        parser.error(f"there is no {unknown[0]}: views are {', '.join(VIEWS)}, sides are {', '.join(SIDES)}")
    setup = Setup(arguments)
    kept = setup.work / "results.json"
    results = {} if arguments.rounds else json.loads(kept.read_text())
    for number in range(arguments.rounds):
        for view in views:
            for side in sides:
                camera = VIEWS[view][1]
                measure = measure_ours if is_ours(side) else measure_theirs
                r = measure(setup, side, view, camera, number == 0)
                if number == 0:
                    r["to_raster"] = errors(setup, "raster", camera, r["depth"])
                    finest = SIDES[side][2]
                    r["to_finest"] = r["to_raster"] if finest == "raster" else finest and errors(setup, finest, camera, r["depth"])
                    if r.get("meshes"):  # what is read back is what is drawn: rays to the meshes themselves say so
                        r["meshes_to_raster"] = errors(setup, "raster", camera, r["meshes"])
                results.setdefault(f"{view} {side}", []).append(r)
                print(f"round {number + 1}, {view}, {side}: {r['frame_ms']:.1f} ms with {r['draws_with']}", file=sys.stderr)
                kept.write_text(json.dumps(results, indent=1))
    tell(results, sides)


if __name__ == "__main__":
    main()
