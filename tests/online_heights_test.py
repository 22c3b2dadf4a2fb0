#!/usr/bin/env python3
"""Samples of heights through every protocol and encoding against the local raster that the servers stand on: drawn live, and its pixels as files.

    online_heights_test.py TEST_PROGRAM SOURCE_DIR WORK_DIR [--random=N]

The Earth's heights, on a lattice that images of every server here share with the raster: whatever differs is the encoding's. TEST_PROGRAM is
truth/online_heights_test.cpp. --random: tiles a level beside those at chosen places. Exit status 77 (skipped) where a package is missing.
"""
import os
import pathlib
import shutil
import subprocess
import sys

import map_servers
import online_world
from online_world import gdal, numpy

LEVEL = 3  # of the grids of 256 pixels and 180 degrees: 4096 x 2048 pixels
WIDTH, HEIGHT = 256 * 2 ** (LEVEL + 1), 256 * 2 ** LEVEL
# Numbers of 16 bits, and positive for PNG: metres = code * STEP - LOWEST.
STEP, LOWEST = 0.625, 1000
EXACT = 0.0


def write(path, array, kind):
    """A raster of the whole Earth, a band for each of the array's first axis."""
    out = gdal.GetDriverByName("GTiff").Create(str(path), WIDTH, HEIGHT, len(array), kind, ["TILED=YES"])
    out.SetGeoTransform((-180, 360 / WIDTH, 0, 90, 0, -180 / HEIGHT))
    out.SetProjection("EPSG:4326")
    out.WriteArray(array)
    out.FlushCache()


def write_band(path, driver, band, kind):
    path.parent.mkdir(parents=True, exist_ok=True)
    memory = gdal.GetDriverByName("MEM").Create("", band.shape[1], band.shape[0], 1, kind)
    memory.WriteArray(band)
    gdal.GetDriverByName(driver).CreateCopy(str(path), memory)
    pathlib.Path(str(path) + ".aux.xml").unlink(missing_ok=True)


def make_world(source, work):
    """(the raster, the same in codes of 16 bits, in colours of terrarium, the tree for nginx and for files)"""
    whole, codes, colours, tree = work / "earth.tif", work / "codes.tif", work / "colours.tif", work / "tree"
    heights = gdal.Warp("", str(source / "data/earth/etopo5_dem_10min.tif"), format="MEM", width=WIDTH, height=HEIGHT, outputBounds=(-180, -90, 180, 90),
                        resampleAlg="cubicspline", outputType=gdal.GDT_Float32).ReadAsArray()
    heights = numpy.where(heights < 0, 0.09 * heights, heights).astype("float32")  # of the centimetre code nothing lies deeper than 1000 m
    assert -990 < heights.min() < -800 and heights.max() > 5000
    write(whole, heights[None], gdal.GDT_Float32)
    code = numpy.rint((heights + LOWEST) / STEP).astype(numpy.int16)
    assert code.min() > 0
    write(codes, code[None], gdal.GDT_Int16)
    write(colours, online_world.encoded(heights, "terrarium"), gdal.GDT_Byte)
    coded = {encoding: online_world.encoded(heights, encoding) for encoding in online_world.ENCODINGS}
    for y in range(HEIGHT // 256):
        for x in range(WIDTH // 256):
            window = (slice(256 * y, 256 * y + 256), slice(256 * x, 256 * x + 256))
            place = f"{LEVEL}/{x}/{y}"
            for encoding, pixels in coded.items():
                online_world.write_png(tree / encoding / f"{place}.png", pixels[(slice(None), *window)])
            write_band(tree / "float" / f"{place}.tif", "GTiff", heights[window], gdal.GDT_Float32)
            write_band(tree / "png16" / f"{place}.png", "PNG", code[window].astype(numpy.uint16), gdal.GDT_UInt16)
    # World Wind: tiles of 45 degrees, rows from the south.
    for y in range(HEIGHT // 512):
        for x in range(WIDTH // 512):
            top = HEIGHT - 512 * (y + 1)
            path = tree / "worldwind" / "0" / f"{y:04}" / f"{y:04}_{x:04}.bil"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(code[top:top + 512, 512 * x:512 * x + 512].astype("<i2").tobytes())
    return whole, codes, colours, tree


def entries_of(wms, proxy, files):
    """By name: an entry of a scene file, and the step of its encoding, metres."""
    at = {"min_level": LEVEL, "max_level": LEVEL}
    served = {"type": "wms", "source": wms.url, "min_level": LEVEL - 1, "max_level": LEVEL - 1}  # images of 512 pixels
    codes = {"layer": "codes", "scale": STEP, "offset": -LOWEST}
    entries = {
        "WMS 1.3.0, float TIFF": ({**served, "layer": "earth", "format": "image/tiff"}, EXACT),
        "WMS 1.1.1, float TIFF": ({**served, "layer": "earth", "format": "image/tiff", "version": "1.1.1"}, EXACT),
        "XYZ, 16-bit PNG": ({"source": files.url + "/png16/{z}/{x}/{y}.png", "crs": "EPSG:4326", "encoding": "band", "scale": STEP, "offset": -LOWEST, **at}, STEP),
        "WMS, 16-bit TIFF": ({**served, **codes, "format": "image/tiff16"}, STEP),
        "WMS, BIL": ({**served, **codes, "format": "application/bil16"}, STEP),
        "World Wind, BIL": ({"source": files.url + "/worldwind/", "type": "worldwind", "level_zero_degrees": 45, "max_level": 0, "format": "application/bil16",
                             "scale": STEP, "offset": -LOWEST}, STEP),
    }
    for encoding, step in online_world.ENCODINGS.items():
        entries[f"XYZ, {encoding}"] = ({"source": f"{files.url}/{encoding}/{{z}}/{{x}}/{{y}}.png", "crs": "EPSG:4326", "encoding": encoding, **at}, step)
    terrarium = {"encoding": "terrarium"}
    one_more = {"min_level": LEVEL + 1, "max_level": LEVEL + 1}  # its level 0 is the whole Earth in one image
    entries["WMTS, terrarium"] = ({"source": proxy.wmts_url, "type": "wmts", "layer": "colours", "matrix_set": "geodetic", **terrarium, **one_more}, 1 / 256)
    entries["TMS, terrarium"] = ({"source": proxy.tms_url, "type": "tms", "layer": "colours/geodetic_south", **terrarium, **at}, 1 / 256)
    return entries


def main():
    if absent := online_world.missing():
        print(f"not installed: {', '.join(absent)}")
        return online_world.SKIPPED
    words = [word for word in sys.argv[1:] if word.startswith("--")]
    program, source, work = [pathlib.Path(word).resolve() for word in sys.argv[1:] if word not in words]
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    whole, codes, colours, tree = make_world(source, work)
    # Nearest: a pixel of an image is a pixel of the raster, and no server makes a number of its own.
    layers = {name: map_servers.Layer(path, resample="NEAREST") for name, path in (("earth", whole), ("codes", codes), ("colours", colours))}
    with map_servers.MapServer(work / "wms", layers) as wms, map_servers.MapProxy(work / "proxy", wms.url, ["colours"]) as proxy, \
            map_servers.FileServer(tree, work / "nginx") as files:
        entries = entries_of(wms, proxy, files)
        pixels = {"source": f"{tree}/float/{{z}}/{{x}}/{{y}}.tif", "type": "xyz", "crs": "EPSG:4326", "format": "image/tiff", "min_level": LEVEL, "max_level": LEVEL}
        scene = online_world.scene_file(work / "scene.toml", elevation=[{"source": str(whole), "type": "live"}, pixels, *(entry for entry, _ in entries.values())])
        for number, name in enumerate(entries, 3):
            print(f"layer {number}: {name}")
        sys.stdout.flush()
        environment = {**os.environ, "XDG_CACHE_HOME": str(work / "cache")}  # what came for one tiling serves the next
        steps = ",".join(str(step) for _, step in entries.values())
        return subprocess.run([program, f"--scene={scene}", f"--steps={steps}", *words], timeout=900, env=environment).returncode


if __name__ == "__main__":
    sys.exit(main())
