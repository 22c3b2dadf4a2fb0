"""What the tests of online data stand on: the same rasters as files and behind every protocol, and the program's pictures as arrays.

GDAL's Python module and NumPy are the system's: run with /usr/bin/python3 (`missing()` says what is not there).
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import unittest
import urllib.parse
import urllib.request

import map_servers

try:
    import numpy
    from osgeo import gdal, ogr
    gdal.UseExceptions()
    ogr.UseExceptions()
    os.environ.setdefault("CPL_LOG", os.devnull)  # the poles are nowhere on web Mercator, as PROJ says a hundred times
except ImportError:
    gdal = None

MERCATOR_M = 20037508.342789244
# Of Everest's raster, a tile of 256 pixels at level 10 of a grid of longitude and latitude being 180 / 1024 degrees.
EVEREST_LEVEL = 10
EVEREST_COLUMNS, EVEREST_ROWS = range(1514, 1518), range(352, 356)
ENCODINGS = {"terrarium": 1 / 256, "mapbox": 0.1, "centimetre": 0.01}  # and their steps, metres


def missing():
    return map_servers.missing() + ([] if gdal else ["python3-gdal"])


def tile_side(level):
    return 180.0 / 2 ** level


def everest_bounds():
    side = tile_side(EVEREST_LEVEL)
    return (EVEREST_COLUMNS[0] * side - 180, 90 - (EVEREST_ROWS[-1] + 1) * side, (EVEREST_COLUMNS[-1] + 1) * side - 180, 90 - EVEREST_ROWS[0] * side)


def write_png(path, bands):
    """`bands`: uint8, three of them, by row and column."""
    path.parent.mkdir(parents=True, exist_ok=True)
    memory = gdal.GetDriverByName("MEM").Create("", bands.shape[2], bands.shape[1], 3)
    memory.WriteArray(bands)
    gdal.GetDriverByName("PNG").CreateCopy(str(path), memory, options=["ZLEVEL=1"])
    pathlib.Path(str(path) + ".aux.xml").unlink(missing_ok=True)


def encoded(heights, encoding):
    """A PNG's bands that mean these heights, as the encodings' own documents write them."""
    heights = heights.astype(numpy.float64)  # 32768 m more as a float would round to a whole step
    if encoding == "terrarium":
        code = numpy.rint((heights + 32768) * 256)
    elif encoding == "mapbox":
        code = numpy.rint((heights + 10000) * 10)
    else:
        code = numpy.rint((heights + 1000) * 100) * 16
    code = code.astype(numpy.uint32)
    return numpy.stack([code >> 16 & 255, code >> 8 & 255, code & 255]).astype(numpy.uint8)


def make_everest(source, tree, raster):
    """Heights on the pixels of level 10, as a file and as tiles of each encoding."""
    west, south, east, north = everest_bounds()
    width, height = 256 * len(EVEREST_COLUMNS), 256 * len(EVEREST_ROWS)
    gdal.Warp(str(raster), str(source / "data/earth/srtm3_everest_N27E086_filled.tif"), outputBounds=(west, south, east, north), width=width,
              height=height, resampleAlg="cubic", outputType=gdal.GDT_Float32).FlushCache()
    heights = gdal.Open(str(raster)).ReadAsArray()
    for encoding in ENCODINGS:
        for r, row in enumerate(EVEREST_ROWS):
            for c, column in enumerate(EVEREST_COLUMNS):
                tile = heights[256 * r:256 * (r + 1), 256 * c:256 * (c + 1)]
                write_png(tree / encoding / str(EVEREST_LEVEL) / str(column) / f"{row}.png", encoded(tile, encoding))


def make_xyz(picture, tree, finest):
    """A square of web Mercator, levels 0 to `finest`."""
    for level in range(finest + 1):
        side = 256 * 2 ** level
        whole = gdal.Warp("", str(picture), format="MEM", srcSRS="EPSG:4326", dstSRS="EPSG:3857", outputBounds=(-MERCATOR_M, -MERCATOR_M, MERCATOR_M, MERCATOR_M),
                          width=side, height=side, resampleAlg="average" if side < 5400 else "bilinear", multithread=True).ReadAsArray()
        for y in range(2 ** level):
            for x in range(2 ** level):
                write_png(tree / "xyz" / str(level) / str(x) / f"{y}.png", whole[:, 256 * y:256 * y + 256, 256 * x:256 * x + 256])


def make_worldwind(picture, tree, finest, degrees=36, side=512, name="worldwind"):
    """Tiles of so many degrees and pixels at level 0, rows from the south."""
    for level in range(finest + 1):
        width, height = 360 // degrees * side * 2 ** level, 180 // degrees * side * 2 ** level
        whole = gdal.Warp("", str(picture), format="MEM", width=width, height=height, outputBounds=(-180, -90, 180, 90),
                          resampleAlg="average" if level == 0 else "bilinear").ReadAsArray()
        for y in range(height // side):
            for x in range(width // side):
                top = height - side * (y + 1)
                write_png(tree / name / str(level) / str(y) / f"{x}.png", whole[:, top:top + side, side * x:side * x + side])


def make_time_index(path, rasters):
    """`rasters`: files by ISO 8601 date, each of the whole globe. An index as MapServer reads it."""
    index = ogr.GetDriverByName("ESRI Shapefile").CreateDataSource(str(path))
    layer = index.CreateLayer("index", geom_type=ogr.wkbPolygon)
    for field in ("location", "time"):
        layer.CreateField(ogr.FieldDefn(field, ogr.OFTString))
    for time, raster in rasters.items():
        feature = ogr.Feature(layer.GetLayerDefn())
        feature.SetField("location", str(raster))
        feature.SetField("time", time)
        feature.SetGeometry(ogr.CreateGeometryFromWkt("POLYGON((-180 -90,180 -90,180 90,-180 90,-180 -90))"))
        layer.CreateFeature(feature)


class Program:
    """The program, with a cache of its own."""

    def __init__(self, path, cache):
        self.path = str(path)
        self.environment = {**os.environ, "XDG_CACHE_HOME": str(cache)}

    def run(self, *words, status=0, timeout=300):
        done = subprocess.run([self.path, *map(str, words)], capture_output=True, text=True, timeout=timeout, env=self.environment)
        assert status is None or done.returncode == status, f"{words}: status {done.returncode}: {done.stderr[-2000:]}"
        return done

    def start(self, *words):
        return subprocess.Popen([self.path, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=self.environment)


def scene_file(path, imagery=(), elevation=(), tiling="cube", light=False):
    """Entries are dictionaries of a scene file's keys."""
    text = f'body = "earth"\ntiling = "{tiling}"\n'
    for kind, entries in (("elevation", elevation), ("imagery", imagery)):
        for entry in entries:
            text += f"[[{kind}]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in entry.items())
    path.write_text(text + f"[light]\nenabled = {json.dumps(light)}\n")
    return path


def colours(path):
    """Of a PNG: rows, columns, three bands, as numbers that may be subtracted."""
    return numpy.moveaxis(gdal.Open(str(path)).ReadAsArray()[:3].astype(numpy.int32), 0, -1)


def depths(path):
    return gdal.Open(str(path)).ReadAsArray().astype(numpy.float64)


class ServerTest(unittest.TestCase):
    """A test of the program over servers: an empty folder and cache of its own."""
    program = source = work = None

    def setUp(self):
        self.work = type(self).work / self._testMethodName
        shutil.rmtree(self.work, ignore_errors=True)
        self.work.mkdir(parents=True)
        self.run_it = Program(self.program, self.work / "cache")


SKIPPED = 77


def run_tests(test, absent, shared=False):
    """The main program of a file with one class of tests: PROGRAM SOURCE_DIR WORK_DIR [--whole]. absent: what is not installed; `shared`: the tests'
    source folder is that of the shared data."""
    words = [word for word in sys.argv[1:] if word != "--whole"]
    test.whole = "--whole" in sys.argv
    test.program, test.source, test.work = [pathlib.Path(word).resolve() for word in words]
    if shared:
        test.source = test.source.parent / "shared"
    if absent or not (test.source / "data/earth").exists():
        print(f"not installed: {', '.join(absent)}" if absent else "no shared data")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])


def asked_for_again(state):
    """Of what a fault server has counted: the paths that were asked for though they had come whole and good before."""
    came = {}
    for path, _, answered, _, is_whole in state["answers"]:
        if is_whole:
            came[path] = min(answered, came.get(path, answered))
    return sorted({path for path, asked, *_ in state["answers"] if asked > came.get(path, asked)})


class FaultServer:
    """tests/fault_server.py before another server, or over a folder."""

    def __init__(self, *, proxy=None, port=0):
        self.process = subprocess.Popen([sys.executable, str(pathlib.Path(__file__).with_name("fault_server.py")), "--proxy", proxy, "--port", str(port)],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        port, self.control_port = map(int, self.process.stdout.readline().split())
        self.url = f"http://127.0.0.1:{port}"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        self.process.wait(60)
        self.process.stdout.close()

    def tell(self, command, **values):
        query = urllib.parse.urlencode(values)
        with urllib.request.urlopen(f"http://127.0.0.1:{self.control_port}/{command}?{query}", timeout=300) as answer:
            return json.loads(answer.read())

    def state(self):
        return self.tell("state")
