#!/usr/bin/env python3
"""Ground made of scattered points, beside the model that they were taken from and beside gdal_grid.

    bench/points.py PROGRAM WORK [RASTER] [--share 0.03] [--body earth] [--million]

Takes a share of the samples of RASTER (longitude and latitude; the embedded Everest if none is named) at random, builds a database of them on each
tiling, and asks it and `gdal_grid -a linear` (of the same points, on the raster's own grid) for the samples that were not taken: root mean square of
the difference to the raster, largest difference, where there was no answer, processor time. --million: builds of a million points, evenly spread and
mixed, with processor time and peak memory. Run it with /usr/bin/python3, which has GDAL.
"""
import argparse
import os
import pathlib
import subprocess
import sys

import numpy as np
from osgeo import gdal

gdal.UseExceptions()


def run(command, **more):
    """What it said, seconds of the processor, peak MiB."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               stdin=subprocess.PIPE if "say" in more else None)
    if "say" in more:
        text, errors = process.communicate(more["say"])
        usage = None
    else:
        text, errors = process.stdout.read(), process.stderr.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, None) and "say" not in more:
        sys.exit(f"failed: {' '.join(map(str, command))}\n{errors}")
    if usage is None:
        return text, 0.0, 0.0
    return text, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def write_table(path, lon, lat, height):
    with open(path, "w", encoding="ascii") as table:
        table.write("lon,lat,height\n")
        for x, y, z in zip(lon, lat, height):
            table.write(f"{x:.8f},{y:.8f},{z:.2f}\n")


def told(name, found, truth, seconds):
    off = found - truth
    have = np.isfinite(off)
    off = off[have]
    print(f"{name:24} rms {np.sqrt(np.mean(off**2)):7.2f} m   99% {np.percentile(np.abs(off), 99):7.2f} m   largest "
          f"{np.abs(off).max():8.2f} m   without answer {100 * (1 - have.mean()):6.3f}%   {seconds:6.1f} s")


def query(program, database, lat, lon):
    places = "".join(f"{y:.9f} {x:.9f}\n" for y, x in zip(lat, lon))
    text, _, _ = run([program, "query", database], say=places)
    return np.array([float(w) if w not in ("nodata", "error") else np.nan for w in (line.split()[0] for line in text.splitlines())])


def compare(program, work, raster, share, body):
    dataset = gdal.Open(str(raster))
    band = dataset.GetRasterBand(1)
    heights = band.ReadAsArray().astype(float)
    transform = dataset.GetGeoTransform()
    rows, columns = heights.shape
    good = (heights > -12000) & (heights < 30000)
    if band.GetNoDataValue() is not None:
        good &= heights != band.GetNoDataValue()
    random = np.random.default_rng(20261)
    cells = np.flatnonzero(good)
    taken = random.choice(cells, int(share * len(cells)), replace=False)
    row, column = np.divmod(taken, columns)
    lon, lat = transform[0] + (column + 0.5) * transform[1], transform[3] + (row + 0.5) * transform[5]
    table = work / "points.csv"
    write_table(table, lon, lat, heights.ravel()[taken])
    (work / "points.vrt").write_text(
        f'<OGRVRTDataSource><OGRVRTLayer name="points"><SrcDataSource>{table}</SrcDataSource><GeometryType>wkbPoint</GeometryType>'
        '<GeometryField encoding="PointFromColumns" x="lon" y="lat" z="height"/></OGRVRTLayer></OGRVRTDataSource>')
    # What was not taken, and lies inside.
    inside = np.zeros_like(good)
    margin = max(4, int(3 / np.sqrt(share)))
    inside[margin:-margin, margin:-margin] = True
    left = good & inside
    left.ravel()[taken] = False
    asked = random.choice(np.flatnonzero(left), min(100000, int(left.sum())), replace=False)
    row, column = np.divmod(asked, columns)
    lon, lat = transform[0] + (column + 0.5) * transform[1], transform[3] + (row + 0.5) * transform[5]
    truth = heights.ravel()[asked]
    print(f"{raster.name}: {len(taken)} points of {len(cells)}, {len(asked)} places asked")
    grid = work / "grid.tif"
    bounds = [transform[0], transform[0] + columns * transform[1], transform[3] + rows * transform[5], transform[3]]
    _, seconds, _ = run(["gdal_grid", "-q", "-a", "linear:radius=0:nodata=nan", "-txe", str(bounds[0]), str(bounds[1]), "-tye", str(bounds[3]),
                         str(bounds[2]), "-outsize", str(columns), str(rows), "-ot", "Float32", str(work / "points.vrt"), str(grid)])
    gridded = gdal.Open(str(grid)).ReadAsArray().astype(float).ravel()[asked]
    told("gdal_grid -a linear", gridded, truth, seconds)
    for tiling in ("geographic", "cube", "healpix"):
        database = work / f"{tiling}.tdb"
        database.unlink(missing_ok=True)
        _, seconds, _ = run([program, "build", str(database), str(table), "--kind", "elevation", "--tiling", tiling, "--body", body])
        found = query(program, str(database), lat, lon)
        told(tiling, found, truth, seconds)
        told("  beside gdal_grid", found, gridded, 0.0)


def million(program, work):
    random = np.random.default_rng(20261)
    even = random.uniform((44, 5), (46, 8), (1_000_000, 2))
    sparse = random.uniform((40, 0), (50, 14), (100_000, 2))
    dense = random.uniform((44.9, 6.9), (45.1, 7.1), (900_000, 2))
    for name, places in (("even", even), ("mixed", np.concatenate((sparse, dense)))):
        lat, lon = places[:, 0], places[:, 1]
        table = work / f"{name}.csv"
        write_table(table, lon, lat, 1500 + 900 * np.sin(7 * lat) * np.cos(5 * lon))
        for memory, jobs in ((1024, 2), (1024, 1), (256, 2)):
            database = work / "million.tdb"
            database.unlink(missing_ok=True)
            text, seconds, peak = run([program, "build", str(database), str(table), "--kind", "elevation", "--memory", str(memory), "--jobs", str(jobs)])
            print(f"a million points, {name}, --memory {memory} --jobs {jobs}: {seconds:.1f} s of processor, peak {peak:.0f} MiB, "
                  f"{database.stat().st_size / 2**20:.1f} MiB")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("work", type=pathlib.Path)
    parser.add_argument("raster", type=pathlib.Path, nargs="?")
    parser.add_argument("--share", type=float, default=0.03)
    parser.add_argument("--body", default="earth")
    parser.add_argument("--million", action="store_true")
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    embedded = pathlib.Path(__file__).resolve().parent.parent / "data/earth/srtm3_everest_N27E086_filled.tif"
    if arguments.million:
        million(arguments.program, arguments.work.resolve())
    else:
        compare(arguments.program, arguments.work.resolve(), (arguments.raster or embedded).resolve(), arguments.share, arguments.body)


if __name__ == "__main__":
    main()
