#!/usr/bin/env python3
"""The same view from local rasters and through every protocol of real servers, and again from what is kept of them once all servers are gone.

    online_test.py PROGRAM SOURCE_DIR WORK_DIR [--whole]

--whole: every protocol in every view on all three tilings; else a sample. Exit status 77 (skipped) where a package is missing.
"""
import shutil
import sys
import unittest

import map_servers
import online_world
from online_world import numpy

SIZE = "320x240"
# Their pixels are nearly those of the raster: a server that makes a picture smaller averages its numbers, and we the light that they mean, which
# on coasts with snow differs by more than is looked for here.
VIEWS = {"europe": "45,10,3000000,0,-90,0", "date line": "20,180,3000000,0,-90,0", "north pole": "89,0,3000000,0,-90,0",
         "south pole": "-88,30,3000000,0,-90,0"}
TILINGS = ("cube", "geographic", "healpix")
FINEST_XYZ = 4
COLOUR_LIMIT = 1.5
# A tile database keeps its pictures as JPEG, which makes up to 1.6 of this; the raster itself is the measure for what came from servers.
DATABASE_LIMIT = 2.5
EVEREST = "27.75,86.5,20000,0,-90,0"
# Tiles by their spacing alone, and the whole grid of each: both sides are then drawn from the same places, whatever their estimates of errors.
SAME_PLACES = ("--vertices-per-pixel", "0.2", "--mesh", "regular", "--no-morph")
FLOAT_STEP_M = 20000 * 2.0 ** -23  # of a depth at the camera's height
EDGE_STEP_M = 1.0 / 64.0  # vertices on edges stand whole steps off their parents' (docs/selection.md); either side half of one, for this spacing


def imagery_of(wms, proxy, files):
    """By protocol: an entry of a scene file for the same picture, and whether it is web Mercator, which ends before the poles."""
    layer = {"layer": "bluemarble"}
    return {
        "WMS 1.1.1": ({"source": wms.url, "type": "wms", "version": "1.1.1", **layer}, False),
        "WMS 1.3.0": ({"source": wms.url, "type": "wms", "version": "1.3.0", **layer}, False),
        "WMS 1.3.0, Mercator": ({"source": wms.url, "type": "wms", "crs": "EPSG:3857", **layer}, True),
        "WMTS by keys": ({"source": proxy.wmts_url, "type": "wmts", **layer}, False),
        "WMTS by templates": ({"source": proxy.wmts_rest_url, **layer}, False),
        "TMS": ({"source": proxy.tms_url, "type": "tms", "layer": "bluemarble/geodetic_south"}, False),
        "XYZ": ({"source": files.url + "/xyz/{z}/{x}/{y}.png", "max_level": FINEST_XYZ}, True),
        "World Wind": ({"source": files.url + "/worldwind", "type": "worldwind", "layer": "worldwind", "level_zero_degrees": 36, "max_level": 0}, False),
    }


def elevation_of(wms, files):
    """By name: an entry for Everest's heights, and how far one may be off, metres."""
    west, south, east, north = online_world.everest_bounds()
    level = {"min_level": online_world.EVEREST_LEVEL, "max_level": online_world.EVEREST_LEVEL, "bounds": [west, south, east, north]}
    entries = {name: ({"source": f"{files.url}/{name}/{{z}}/{{x}}/{{y}}.png", "crs": "EPSG:4326", "encoding": name, **level}, step)
               for name, step in online_world.ENCODINGS.items()}
    # The grid of a WMS has images of 512 pixels, so that its level before has the same pixels.
    at = {"min_level": online_world.EVEREST_LEVEL - 1, "max_level": online_world.EVEREST_LEVEL - 1}
    entries["WMS, TIFF"] = ({"source": wms.url, "type": "wms", "layer": "everest", "format": "image/tiff", **at}, 1e-3)
    return entries


class Online(unittest.TestCase):
    program = source = work = None
    whole = False

    @classmethod
    def setUpClass(cls):
        shutil.rmtree(cls.work, ignore_errors=True)
        cls.work.mkdir(parents=True)
        cls.run_it = online_world.Program(cls.program, cls.work / "cache")
        cls.drawn = []  # (words of the call but its output, the picture)
        picture, everest = cls.source / "data/earth/bluemarble_dec2004_5400x2700.jpg", cls.work / "everest.tif"
        tree = cls.work / "tree"
        online_world.make_everest(cls.source, tree, everest)
        online_world.make_xyz(picture, tree, FINEST_XYZ)
        online_world.make_worldwind(picture, tree, 0)
        rasters = {"bluemarble": map_servers.Layer(picture),
                   "everest": map_servers.Layer(everest, extent=online_world.everest_bounds(), elevation=True)}
        servers = [map_servers.MapServer(cls.work / "wms", rasters)]
        servers.append(map_servers.MapProxy(cls.work / "proxy", servers[0].url, ["bluemarble"]))
        servers.append(map_servers.FileServer(tree, cls.work / "nginx"))
        for server in servers:
            server.__enter__()
        try:
            cls.colour_misses = cls.compare_colours(picture, imagery_of(*servers))
            cls.height_misses = cls.compare_heights(everest, elevation_of(servers[0], servers[2]))
        finally:
            for server in reversed(servers):
                server.__exit__()

    @classmethod
    def render(cls, name, camera, *more, imagery=(), elevation=(), tiling="cube", online=True):
        """The picture's path, once it is complete."""
        stem = name.replace(" ", "_").replace(",", "").replace("/", "_")
        scene = online_world.scene_file(cls.work / f"{stem}.toml", imagery, elevation, tiling)
        out = cls.work / f"{stem}.png"
        words = ["render", scene, "--camera", camera, "--size", SIZE, *more]
        cls.run_it.run(*words, "-o", out)
        if online:
            cls.drawn.append((words, out))
        return out

    @classmethod
    def cases(cls, protocols):
        """(tiling, view, protocol) to look at."""
        every = [(tiling, view, protocol) for tiling in TILINGS for view in VIEWS for protocol, (_, mercator) in protocols.items()
                 if not (mercator and "pole" in view)]
        sample = {("geographic", "date line", "WMS 1.3.0"), ("healpix", "north pole", "WMS 1.3.0"), ("geographic", "south pole", "WMS 1.3.0")}
        sample |= {("cube", "europe", protocol) for protocol in protocols}
        return [case for case in every if cls.whole or case in sample]

    @classmethod
    def compare_colours(cls, picture, protocols):
        misses, local = {}, {}
        for tiling, view, protocol in cls.cases(protocols):
            if (tiling, view) not in local:
                local[tiling, view] = online_world.colours(cls.render(f"{tiling} {view} local", VIEWS[view], tiling=tiling, online=False,
                                                                      imagery=[{"source": str(picture), "type": "live"}]))
            out = cls.render(f"{tiling} {view} {protocol}", VIEWS[view], imagery=[protocols[protocol][0]], tiling=tiling)
            misses[tiling, view, protocol] = float(abs(online_world.colours(out) - local[tiling, view]).mean())
        return misses

    @classmethod
    def depth(cls, name, entry, online):
        path = cls.work / f"{name.replace(' ', '_')}.tif"
        cls.render(f"depth {name}", EVEREST, "--depth", path, *SAME_PLACES, elevation=[entry], online=online)
        return online_world.depths(path)

    @classmethod
    def compare_heights(cls, everest, entries):
        local = cls.depth("local", {"source": str(everest), "type": "live"}, False)
        assert numpy.isfinite(local).all() and numpy.ptp(local) > 1500, "Everest fills the picture"
        return {name: (float(abs(cls.depth(name, entry, True) - local).max()), step) for name, (entry, step) in entries.items()}

    def test_colours_are_those_of_the_local_raster(self):
        for case, miss in self.colour_misses.items():
            print(f"{', '.join(case)}: {miss:.2f} of 255 off in the mean")
        for case, miss in self.colour_misses.items():
            self.assertLess(miss, COLOUR_LIMIT, case)

    @unittest.skipUnless("--whole" in sys.argv, "takes long")
    def test_colours_of_a_database(self):
        picture = self.source / "data/earth/bluemarble_dec2004_5400x2700.jpg"
        for tiling in TILINGS:
            database = self.work / f"{tiling}.tdb"
            self.run_it.run("build", database, picture, "--kind", "imagery", "--tiling", tiling)
            for view, camera in VIEWS.items():
                built = online_world.colours(self.render(f"{tiling} {view} database", camera, tiling=tiling, online=False, imagery=[{"source": str(database)}]))
                served = online_world.colours(self.work / f"{tiling}_{view.replace(' ', '_')}_WMS_1.3.0.png")
                miss = float(abs(built - served).mean())
                print(f"{tiling}, {view}, WMS 1.3.0 against a tile database: {miss:.2f} of 255 off in the mean")
                self.assertLess(miss, DATABASE_LIMIT, (tiling, view))

    def test_heights_are_those_of_the_local_raster(self):
        for name, (miss, step) in self.height_misses.items():
            print(f"{name}: at most {miss:.4f} m off, a step is {step:.4f} m")
        for name, (miss, step) in self.height_misses.items():
            self.assertLess(miss, step + 4 * FLOAT_STEP_M + EDGE_STEP_M, name)

    def test_the_same_bytes_without_servers(self):
        for words, out in self.drawn if self.whole else self.drawn[::3]:
            again = out.with_suffix(".offline.png")
            self.run_it.run(*words, "--offline", "-o", again)
            self.assertEqual(again.read_bytes(), out.read_bytes(), f"{out} and {again} differ")

    def test_nothing_kept_is_said(self):
        words, out = self.drawn[0]
        empty = online_world.Program(self.program, self.work / "empty_cache")
        done = empty.run(*words, "--offline", "-o", out.with_suffix(".nothing.png"), status=1)
        self.assertIn("offline", done.stderr)


if __name__ == "__main__":
    online_world.run_tests(Online, online_world.missing())
