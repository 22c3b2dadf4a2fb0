#!/usr/bin/env python3
"""What the program says to a mistake: what is wrong, where, and what to do; and that a stopped build goes on.

    messages_test.py PROGRAM SOURCE_DIR WORK_DIR
"""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import unittest
import unittest.mock

from pictures_test import stopped


class Messages(unittest.TestCase):
    program = source = work = None

    @classmethod
    def setUpClass(cls):
        shutil.rmtree(cls.work, ignore_errors=True)
        cls.work.mkdir(parents=True)
        cls.raster = cls.source / "data/mars/mola_dem_4ppd.tif"
        cls.picture = cls.source / "data/mars/viking_mdim21_color_2880x1440.jpg"
        cls.earth = cls.source / "data/earth/etopo5_dem_10min.tif"
        cls.database = cls.work / "heights.tdb"
        subprocess.run([cls.program, "build", cls.database, cls.raster, "--kind", "elevation", "--max-level", "1"],
                       check=True, capture_output=True)

    def run_program(self, *words, text=None):
        return subprocess.run([self.program, *map(str, words)], input=text, capture_output=True, text=True, timeout=300)

    def refused(self, status, words, *parts):
        """The run ends with the status, and its message has all the parts."""
        done = self.run_program(*words)
        self.assertEqual(done.returncode, status, done.stderr)
        for part in parts:
            self.assertIn(str(part), done.stderr)
        self.assertEqual(done.stdout, "")
        return done.stderr

    def build(self, output, *inputs, kind="elevation", more=()):
        return ("build", output, *inputs, "--kind", kind, *more)

    def test_subcommands(self):
        told = self.refused(2, ("biuld", "x"), "'biuld'", "did you mean 'build'?", "verify", "render", "view")
        self.assertNotIn("did you mean", self.refused(2, ("paint",), "'paint'", "build"))
        self.assertIn("query", told)
        self.refused(2, (), "subcommand")
        for words in (("--help",), ("--version",), ("build", "--help")):
            self.assertEqual(self.run_program(*words).returncode, 0)

    def test_folders_in_place_of_files(self):
        folder = self.work / "a_folder"
        folder.mkdir()
        self.refused(1, self.build(folder, self.raster), folder, "is a folder", "name.tdb")
        self.refused(1, self.build(self.work / "x.tdb", folder), folder, "is a folder")
        self.refused(1, self.build(self.work / "absent/x.tdb", self.raster), "does not exist", "mkdir -p")
        for subcommand in ("info", "verify", "query"):
            self.refused(1, (subcommand, folder), folder, "is a folder")
            self.refused(1, (subcommand, self.work / "none.tdb"), "no such file")
        self.assertFalse((self.work / "x.tdb.part").exists())

    def test_a_tile_database_as_input(self):
        told = self.refused(1, self.build(self.work / "x.tdb", self.database), "is a tile database", "rasters")
        self.assertNotIn(".LBL", told)

    def test_scenes_whose_databases_are_not_there(self):
        folder = self.work / "demo"
        folder.mkdir()
        scene = folder / "s.toml"
        scene.write_text('body = "mars"\n[[elevation]]\nsource = "absent.tdb"\n')
        view = ("render", scene, "--camera", "0,0,1e6", "-o", self.work / "x.png")
        told = self.refused(1, view, "absent.tdb", f"tellurion build {folder / 'absent.tdb'} INPUT... --kind elevation")
        self.assertNotIn("bootstrap", told)
        (folder / "demo.sh").touch()
        self.refused(1, view, "./bootstrap demo")
        scene.write_text('[[imagery]]\nsource = "absent.tif"\n')
        self.assertNotIn("tellurion build", self.refused(1, view, "absent.tif"))

    def test_lists_of_layers_with_a_gap(self):
        for name in (f"{self.database},", f",{self.database}", f"{self.database},,{self.database}", ","):
            self.refused(1, ("render", name, "--camera", "0,0,1e6", "-o", self.work / "x.png"), name, "comma")
        self.refused(1, ("render", "", "--camera", "0,0,1e6", "-o", self.work / "x.png"), "no name")

    def test_a_signal_while_a_scenes_raster_is_built(self):
        """The program says so, ends with status 1, and no half database passes for a whole one."""
        path = self.work / "path.csv"
        path.write_text("seconds,lat,lon,height_m,heading,pitch,roll\n0,0,0,4e6,0,-90,0\n1,0,9,4e6,0,-90,0\n")
        calls = {"render": ("--camera", "0,0,1e6", "-o", self.work / "signal.png"), "bench": ("--path", path, "--json"),
                 "fly": ("--path", path, "-o", self.work / "signal")}
        for number, (command, words) in zip((signal.SIGINT, signal.SIGTERM, signal.SIGHUP), calls.items()):
            cache = self.work / f"cache_{command}"
            with unittest.mock.patch.dict(os.environ, XDG_CACHE_HOME=str(cache)):
                done = stopped(number, self.program, command, self.earth, *words)
            self.assertEqual(done.returncode, 1, done)
            self.assertIn(f"{self.earth}: stopped", done.stderr)
            self.assertIn("goes on where it was", done.stderr)
            self.assertEqual(done.stdout, "")
            self.assertEqual(list((cache / "tellurion").glob("*.tdb")), [])
        self.assertFalse((self.work / "signal.png").exists())

    def test_a_signal_ends_verify(self):
        for _ in range(10):  # a check that is over first is no fault
            done = stopped(signal.SIGTERM, self.program, "verify", self.database)
            if done.returncode != 0:
                break
        self.assertEqual(done.returncode, 1, done)
        self.assertIn("stopped before the end", done.stderr)
        self.assertEqual(done.stdout, "")

    def test_servers_that_do_not_answer(self):
        """Nothing listens there: what there is is written, and the message names the server."""
        source = "http://127.0.0.1:9/wms"
        scene = self.work / "online.toml"
        scene.write_text(f'[[imagery]]\nsource = "{source}"\n')
        for name in (scene, source + "#layer"):
            picture = self.work / "online.png"
            done = self.refused(1, ("render", name, "--camera", "0,0,1e7", "--size", "64x48", "--timeout", "2", "--cache-mib", "0",
                                    "-o", picture), "imagery.0 of the scene", "had not told what it offers", "raise --timeout", f"{source}: ")
            self.assertTrue(picture.exists(), done)
            picture.unlink()

    def test_nodata_that_the_file_cannot_hold(self):
        for value in ("nan", "0.5", "-99999"):
            self.refused(1, self.build(self.work / "x.tdb", self.raster, more=("--nodata", value)), "--nodata", "Int16")
        self.refused(1, self.build(self.work / "x.tdb", self.picture, kind="imagery", more=("--nodata", "256")), "Byte")
        self.assertFalse((self.work / "x.tdb.part").exists())

    def test_a_body_that_contradicts_the_file(self):
        self.refused(1, self.build(self.work / "x.tdb", self.raster, more=("--body", "moon")), "mars", "--body")
        done = self.run_program(*self.build(self.work / "mislabelled.tdb", self.earth, more=("--body", "mars", "--max-level", 0)))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("leave --body out", done.stderr)

    def test_query_takes_a_comma(self):
        done = self.run_program("query", self.database, text="10 20\n10,20\n10, 20\n10\t,\t20\n10,20,\n,10,20\n10,,20\n10\n")
        lines = done.stdout.split("\n")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(lines[1:4], [lines[0]] * 3)
        self.assertNotEqual(lines[0], "error")
        self.assertEqual(lines[4:8], ["error"] * 4)

    def test_query_takes_tables_and_places(self):
        """Columns by their names, a row for each row, what is wrong with which line; places of the command line."""
        done = self.run_program("query", self.database, "--csv", text='name,Longitude,lat\n"a, b",20,10\nhalf,20\nx,abc,3\n,20,10\n')
        header, first, *wrong, last = done.stdout.splitlines()
        self.assertEqual(done.returncode, 1)
        self.assertEqual(header, "lat,lon,height_m,level,spacing_m,error_m,finer")
        self.assertEqual(first, last)
        self.assertEqual(first.split(",")[:2] + first.split(",")[3:4], ["10", "20", "1"])
        self.assertEqual(wrong, [",,error,,,,"] * 2)
        self.assertIn("line 3: 'half,20' ends before the columns", done.stderr)
        self.assertIn("line 4: '3' and 'abc' are no latitude and longitude", done.stderr)
        done = self.run_program("query", "--at", "-10,-20", "--at", "10,20", self.database, "--level", 0, "--json")
        answers = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([(a["lat"], a["lon"], a["level"], a["finer"]) for a in answers], [(-10, -20, 0, True), (10, 20, 0, True)])
        coarse, fine = answers[1], json.loads(self.run_program("query", "--at", "10,20", self.database, "--json").stdout)
        self.assertLessEqual(abs(coarse["height_m"] - fine["height_m"]), coarse["error_m"])
        self.assertEqual((fine["level"], fine["error_m"], fine["finer"]), (1, 0, False))
        self.assertIn("no level 9", self.run_program("query", "--at", "1,2", self.database, "--level", 9).stderr)
        self.refused(1, ("query", self.database, "--input", self.work / "none.csv"), "none.csv", "cannot be opened")

    def test_a_stopped_build_says_how_to_go_on(self):
        """SIGTERM is as Ctrl-C; what 'info' says of the rest, done as it stands, finishes it with the same bytes."""
        whole, half = self.work / "whole.tdb", self.work / "half.tdb"
        self.assertEqual(self.run_program(*self.build(whole, self.earth)).returncode, 0)
        for number in (signal.SIGTERM, signal.SIGINT):
            done = stopped(number, self.program, *self.build(half, self.earth))
            self.assertEqual(done.returncode, 1, done)
            self.assertIn("stopped; the same command goes on", done.stderr)
        self.assertFalse(half.exists())
        told = self.refused(1, ("info", f"{half}.part"), "unfinished build", "--max-level")
        command = told.split("'")[1]
        self.refused(1, ("info", half), f"{half}.part")
        view = ("--camera", "0,0,1e6", "-o", self.work / "x.png")
        self.refused(1, ("render", f"{half}.part", *view), f"{half}.part", "unfinished build", command)
        self.refused(1, ("render", half, *view), f"{half}.part")
        environment = {**os.environ, "PATH": f"{pathlib.Path(self.program).resolve().parent}:{os.environ['PATH']}"}
        subprocess.run(command, shell=True, check=True, env=environment, capture_output=True)
        self.assertEqual(whole.read_bytes(), half.read_bytes())

    def test_a_damaged_input_is_not_in_the_way(self):
        damaged = self.work / "damaged.tif"
        damaged.write_bytes(self.raster.read_bytes()[:300000])
        out = self.work / "after.tdb"
        self.refused(1, self.build(out, damaged), damaged, "nothing was built")
        self.assertEqual(self.run_program(*self.build(out, self.raster, more=("--max-level", 1))).returncode, 0)
        before = out.read_bytes()
        self.refused(1, self.build(out, damaged, more=("--append",)), damaged, "is as it was")
        self.assertEqual(out.read_bytes(), before)
        self.assertEqual([p.name for p in self.work.glob("after.tdb?*")], [])


if __name__ == "__main__":
    Messages.program, Messages.source, Messages.work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    unittest.main(argv=sys.argv[:1])
