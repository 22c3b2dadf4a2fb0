#!/usr/bin/env python3
"""`tellurion sources` on real servers: MapServer, MapProxy and nginx, started here on 127.0.0.1 over the project's data.

    services_test.py PROGRAM SOURCE_DIR WORK_DIR
"""
import json
import pathlib
import shutil
import subprocess
import sys
import tomllib
import unittest
import urllib.request

import map_servers
from pictures_test import png_pixels

SKIPPED = 77
LAYERS = ("bluemarble", "heights")
TILE_MAP = """<?xml version="1.0"?><TileMap version="1.0.0"><Title>A tree</Title><SRS>EPSG:4326</SRS>
<BoundingBox minx="-180" miny="-90" maxx="180" maxy="90"/><Origin x="-180" y="-90"/>
<TileFormat width="256" height="256" mime-type="image/png" extension="png"/><TileSets profile="global-geodetic">
<TileSet href="0" units-per-pixel="0.703125" order="0"/></TileSets></TileMap>"""

LAYER_SET = """<?xml version="1.0"?><LayerSet Name="t"><QuadTileSet><Name>A set</Name><ImageAccessor>
<LevelZeroTileSizeDegrees>36</LevelZeroTileSizeDegrees><NumberLevels>6</NumberLevels><TextureSizePixels>512</TextureSizePixels>
<ImageFileExtension>png</ImageFileExtension><ImageTileService><ServerUrl>{url}/worldwind</ServerUrl>
<DataSetName>set</DataSetName></ImageTileService></ImageAccessor></QuadTileSet></LayerSet>"""


class Services(unittest.TestCase):
    program = source = work = None

    @classmethod
    def setUpClass(cls):
        shutil.rmtree(cls.work, ignore_errors=True)
        earth = cls.source / "data/earth"
        rasters = {"bluemarble": map_servers.Layer(earth / "bluemarble_dec2004_5400x2700.jpg"),
                   "heights": map_servers.Layer(earth / "etopo5_dem_10min.tif", elevation=True)}
        cls.wms = cls.enterClassContext(map_servers.MapServer(cls.work / "wms", rasters))
        cls.proxy = cls.enterClassContext(map_servers.MapProxy(cls.work / "proxy", cls.wms.url, ["bluemarble"]))
        tree = cls.work / "tree"
        tree.mkdir()
        (tree / "tilemapresource.xml").write_text(TILE_MAP)
        cls.files = cls.enterClassContext(map_servers.FileServer(tree, cls.work / "nginx"))

    def run_sources(self, *words):
        return subprocess.run([self.program, "sources", *map(str, words)], capture_output=True, text=True, timeout=300)

    def answer(self, *words):
        done = self.run_sources(*words)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout

    def offers(self, *words):
        return json.loads(self.answer(*words, "--json"))

    def entry(self, kind, *words):
        """The one entry of a scene file that is printed."""
        scene = tomllib.loads(self.answer(*words))
        self.assertEqual(list(scene), [kind])
        self.assertEqual(len(scene[kind]), 1)
        return scene[kind][0]

    def refused(self, status, words, *parts):
        done = self.run_sources(*words)
        self.assertEqual((done.returncode, done.stdout), (status, ""), done.stderr)
        for part in parts:
            self.assertIn(part, done.stderr)

    def test_wms_in_both_versions(self):
        for version in ("1.1.1", "1.3.0"):
            offers = self.offers(self.wms.url, "--wms-version", version)
            self.assertEqual((offers["type"], offers["version"]), ("wms", version))
            named = {layer["name"]: layer for layer in offers["layers"]}
            for name in LAYERS:
                self.assertEqual(named[name]["title"], f"{name} of the tests")
                self.assertEqual(named[name]["bounds"], [-180, -90, 180, 90])
                self.assertLessEqual({"EPSG:4326", "EPSG:3857"}, set(named[name]["crs"]))
            self.assertIn("image/png", named["bluemarble"]["formats"])
        table = self.answer(self.wms.url)
        self.assertIn("bluemarble of the tests", table)
        self.assertIn("-180 -90 180 90", table)

    def test_entries_of_a_wms(self):
        entry = self.entry("imagery", self.wms.url, "--layer", "bluemarble")
        self.assertEqual(entry, {"source": self.wms.url, "type": "wms", "layer": "bluemarble", "attribution": "Tellurion's tests"})
        entry = self.entry("elevation", self.wms.url, "--layer", "heights", "--elevation")
        self.assertEqual(entry["layer"], "heights")

    def first_image(self, *words):
        """What the server gives for the first image of a layer: (content type, bytes)."""
        told = json.loads(self.answer(*words, "--json"))
        self.assertGreater(told["levels"], 5)
        with urllib.request.urlopen(told["first_image"], timeout=300) as answer:
            return answer.headers["Content-Type"], answer.read()

    def mean_colour(self, image, columns=1.0, lines=1.0):
        """Of the upper left part of an image, as shares of its sides."""
        path = self.work / "image.png"
        path.write_bytes(image)
        rows = png_pixels(path)[2]
        pixels = [pixel for row in rows[:int(len(rows) * lines)] for pixel in row[:int(len(row) * columns)]]
        return [sum(pixel[band] for pixel in pixels) / len(pixels) for band in range(3)]

    def test_every_protocol_gives_the_western_hemisphere(self):
        asked = {"wms 1.1.1": (self.wms.url, "--wms-version", "1.1.1"), "wms 1.3.0": (self.wms.url, "--wms-version", "1.3.0"),
                 "wmts keys": (self.proxy.wmts_url, "--type", "wmts"), "wmts templates": (self.proxy.wmts_rest_url,)}
        means = {}
        for name, words in asked.items():
            kind, image = self.first_image(*words, "--layer", "bluemarble")
            self.assertEqual(kind, "image/png", name)
            # The first tile of MapProxy's set spans 360 degrees both ways, the first image of a WMS the whole map.
            means[name] = self.mean_colour(image, 0.5, 0.5 if name.startswith("wmts") else 1.0)
        for name, mean in means.items():
            for band in range(3):
                self.assertAlmostEqual(mean[band], means["wms 1.1.1"][band], delta=1.5, msg=name)
        # Were latitude and longitude exchanged, the server would answer with an exception or another picture.
        self.assertGreater(means["wms 1.3.0"][2], means["wms 1.3.0"][0] + 10, "mostly ocean")

    def test_heights_come_as_numbers(self):
        kind, image = self.first_image(self.wms.url, "--layer", "heights", "--elevation")
        self.assertEqual(kind, "image/tiff")
        self.assertIn(image[:4], (b"II*\0", b"MM\0*"))

    def test_wmts_by_keys_and_by_templates(self):
        for url in (self.proxy.wmts_url, self.proxy.wmts_rest_url):
            offers = self.offers(url, "--type", "wmts")
            self.assertEqual([layer["name"] for layer in offers["layers"]], ["bluemarble"])
            self.assertEqual(set(offers["layers"][0]["crs"]), {"EPSG:4326", "EPSG:3857"})
            self.assertEqual(self.entry("imagery", url, "--type", "wmts", "--layer", "bluemarble")["type"], "wmts")
        # Told by the documents: MapProxy has no WMS here, so the second question is the WMTS's.
        self.assertEqual(self.offers(self.proxy.wmts_url)["type"], "wmts")

    def test_tms(self):
        offers = self.offers(self.proxy.tms_url, "--type", "tms")
        self.assertEqual(offers["type"], "tms")
        names = [layer["name"] for layer in offers["layers"]]
        self.assertEqual(names, ["bluemarble/geodetic", "bluemarble/geodetic_south", "bluemarble/mercator"])
        for name in names:
            self.assertEqual(self.first_image(self.proxy.tms_url, "--type", "tms", "--layer", name)[0], "image/png")
        self.assertEqual(self.offers(self.files.url)["layers"][0]["title"], "A tree")
        self.assertEqual(self.entry("imagery", self.files.url, "--layer", "tree")["type"], "tms")
        # A folder here is the same.
        self.assertEqual(self.offers(self.work / "tree")["type"], "tms")

    def test_templates(self):
        template = self.files.url + "/{z}/{x}/{y}.png"
        self.assertEqual(self.entry("imagery", template, "--layer", "any"), {"source": template, "type": "xyz"})

    def test_world_wind(self):
        (self.work / "tree/set/0/4").mkdir(parents=True)
        (self.work / "tree/set/0/4/0.png").write_bytes(b"the north-west tile: row 4 of 5 from the south")
        (self.work / "tree/layers.xml").write_text(LAYER_SET.format(url=self.files.url))
        for source in (self.work / "tree/layers.xml", self.files.url + "/layers.xml"):
            entry = self.entry("imagery", source, "--layer", "A set")
            self.assertEqual((entry["type"], entry["level_zero_degrees"], entry["max_level"]), ("worldwind", 36, 5))
            self.assertIn(b"north-west", self.first_image(source, "--layer", "A set")[1])

    def test_mistakes(self):
        self.refused(1, (self.wms.url, "--layer", "blumarble"), "there is no layer 'blumarble'", "did you mean 'bluemarble'")
        self.refused(1, (self.files.url + "/nothing/here",), "no map service is found there")
        self.refused(1, (self.wms.url, "--type", "wnts"), "there is no type 'wnts'", "wmts")
        self.refused(2, (), "URL")
        secret = self.files.url.replace("127", "me:hidden@127") + "/none?token=hidden"
        done = self.run_sources(secret)
        self.assertEqual(done.returncode, 1)
        self.assertNotIn("hidden", done.stdout + done.stderr)
        self.assertIn("sources http", self.answer("--help"))


if __name__ == "__main__":
    Services.program = pathlib.Path(sys.argv[1])
    Services.source = pathlib.Path(sys.argv[2])
    Services.work = pathlib.Path(sys.argv[3])
    if absent := map_servers.missing():
        print(f"not installed: {', '.join(absent)}")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])
