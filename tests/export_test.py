#!/usr/bin/env python3
"""The subcommands export and import: what a person types, what is left behind by a kill, and that files come back.

    export_test.py PROGRAM SOURCE_DIR WORK_DIR
"""
import json
import pathlib
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
import unittest


class Export(unittest.TestCase):
    program = source = work = None

    @classmethod
    def setUpClass(cls):
        shutil.rmtree(cls.work, ignore_errors=True)
        cls.work.mkdir(parents=True)
        cls.pictures = cls.work / "pictures.tdb"
        cls.heights = cls.work / "heights.tdb"
        cls.build(cls.pictures, "data/mars/viking_mdim21_color_2880x1440.jpg", "imagery", "--body", "earth")
        cls.build(cls.heights, "data/mars/mola_dem_4ppd.tif", "elevation")

    @classmethod
    def build(cls, output, raster, kind, *more):
        subprocess.run([cls.program, "build", output, cls.source / raster, "--kind", kind, "--max-level", "1", *more],
                       check=True, capture_output=True)

    def call(self, status, *words, text=None):
        done = subprocess.run([self.program, *map(str, words)], input=text, capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def refused(self, status, words, *parts):
        told = self.call(status, *words).stderr
        for part in parts:
            self.assertIn(str(part), told)

    def answers(self, database, *places):
        done = self.call(0, "query", database, "--json", text="".join(f"{lat} {lon}\n" for lat, lon in places))
        return [json.loads(line) for line in done.stdout.splitlines()]

    def test_names_tell_the_format(self):
        self.call(0, "export", self.heights, self.work / "a.tif", "--levels", "0")
        self.assertIn(self.work.joinpath("a.tif").read_bytes()[:4], (b"II*\0", b"MM\0*"))
        self.call(0, "export", self.heights, self.work / "a.gpkg", "--levels", "0")
        with sqlite3.connect(self.work / "a.gpkg") as package:
            self.assertEqual(package.execute("SELECT data_type FROM gpkg_contents").fetchall(), [("2d-gridded-coverage",)])
        self.refused(2, ("export", self.heights, self.work / "a.xyz"), "--format")

    def test_mistakes(self):
        self.refused(1, ("export", self.work / "none.tdb", self.work / "b.tif"), "no such file")
        self.refused(1, ("export", self.heights, self.work / "b.mbtiles"), "elevation", "geotiff")
        self.refused(2, ("export", self.heights, self.work / "b.tif", "--region", "10,20,30,5"), "--region")
        self.refused(1, ("export", self.heights, self.heights, "--format", "cog", "--force"), "the database itself")
        self.refused(1, ("import", self.source / "data/mars/mola_dem_4ppd.tif", self.work / "b.tdb"), "tellurion build")
        self.refused(1, ("import", self.heights, self.work / "b.tdb"), "is a tile database already")
        self.refused(1, ("import", self.work / "none.mbtiles", self.work / "b.tdb"), "none.mbtiles")

    def test_mbtiles_there_and_back(self):
        tiles = self.work / "c.mbtiles"
        self.call(0, "export", self.pictures, tiles, "--tile-format", "jpeg", "--quality", "95")
        with sqlite3.connect(tiles) as file:
            facts = dict(file.execute("SELECT name, value FROM metadata"))
            self.assertEqual((facts["format"], facts["minzoom"], facts["maxzoom"]), ("jpg", "0", "3"))
            self.assertEqual(file.execute("SELECT count(*) FROM tiles").fetchone()[0], 1 + 4 + 16 + 64)
            self.assertEqual(file.execute("PRAGMA integrity_check").fetchone()[0], "ok")
        self.call(0, "import", tiles, self.work / "c.tdb", "--tiling", "healpix")
        self.call(0, "verify", self.work / "c.tdb")
        places = [(lat, lon) for lat in (-60, -20, 3, 45, 70) for lon in (-170, -60, 10, 120)]
        for before, after in zip(self.answers(self.pictures, *places), self.answers(self.work / "c.tdb", *places)):
            for channel in range(4):
                self.assertAlmostEqual(before["rgba"][channel], after["rgba"][channel], delta=24, msg=f"{before} {after}")

    def test_a_killed_export_leaves_nothing_under_its_name(self):
        tiles = self.work / "d"
        for moment in (0.02, 0.1, 0.4):
            words = [self.program, "export", self.pictures, tiles, "--format", "xyz", "--levels", "6"]
            running = subprocess.Popen(words, stderr=subprocess.PIPE)
            time.sleep(moment)
            running.kill()
            self.assertEqual(running.wait(), -signal.SIGKILL)
            running.stderr.close()
            self.assertFalse(tiles.exists())
        # The next one of that name needs no help.
        self.call(0, "export", self.pictures, tiles, "--format", "xyz", "--levels", "1")
        self.assertTrue((tiles / "tiles.json").exists())
        self.assertEqual(json.loads((tiles / "tiles.json").read_text())["maxzoom"], 1)
        self.assertFalse((self.work / "d.part").exists())

    def test_an_interrupted_export_says_so(self):
        words = [self.program, "export", self.pictures, self.work / "e", "--format", "xyz", "--levels", "7"]
        running = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
        while not (self.work / "e.part").exists() and running.poll() is None:
            time.sleep(0.01)
        running.send_signal(signal.SIGINT)
        told = running.communicate()[1]
        self.assertEqual(running.returncode, 1)
        self.assertIn("stopped", told)
        self.assertFalse((self.work / "e").exists())
        self.assertFalse((self.work / "e.part").exists())


if __name__ == "__main__":
    Export.program = pathlib.Path(sys.argv[1])
    Export.source = pathlib.Path(sys.argv[2])
    Export.work = pathlib.Path(sys.argv[3])
    unittest.main(argv=sys.argv[:1])
