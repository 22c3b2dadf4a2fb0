#!/usr/bin/env python3
"""What 'bench' writes, and the modes that pictures are compared in: --stats, --plot, --mesh and --vertices-per-pixel.

    bench_test.py PROGRAM SOURCE_DIR WORK_DIR

Exit status 77 (skipped) where there is no OpenGL.
"""
import csv
import json
import pathlib
import shutil
import subprocess
import sys
import unittest
import xml.etree.ElementTree

SKIPPED = 77
SIZE = "512x384"
SVG = "{http://www.w3.org/2000/svg}"
CONTRACT = ["frame_ms", "update_ms", "upload_ms", "upload_bytes", "tiles_drawn", "triangles", "draw_calls", "max_screen_error_px", "capped_by_budget", "quality", "complete",
            "tiles_wanted", "tiles_held_back", "gpu_bytes", "cpu_cache_bytes", "requests", "failed_requests"]


class Bench(unittest.TestCase):
    program = source = work = None

    @classmethod
    def setUpClass(cls):
        shutil.rmtree(cls.work, ignore_errors=True)
        cls.work.mkdir(parents=True)
        cls.database = cls.work / "heights & <more>.tdb"  # a name that an XML file must not take as it is
        subprocess.run([cls.program, "build", cls.database, cls.source / "data/mars/mola_dem_4ppd.tif", "--kind", "elevation",
                        "--tiling", "healpix"], check=True, capture_output=True)
        cls.path = cls.work / "path.csv"
        cls.path.write_text("seconds,lat,lon,height_m,heading,pitch,roll\n0,0,-70,6000000,0,-90,0\n2,-10,-72,100000,20,-30,0\n")
        done = cls.run_program("render", cls.database, "--camera", "0,0,6e6,0,-90,0", "--size", "64x64", "-o", "/dev/null")
        if done.returncode == 1 and "OpenGL" in done.stderr:
            sys.exit(SKIPPED)

    @classmethod
    def run_program(cls, *words):
        return subprocess.run([cls.program, *map(str, words)], capture_output=True, text=True, timeout=300)

    def bench(self, *more):
        done = self.run_program("bench", self.database, "--path", self.path, "--size", "320x240", *(() if "--fps" in more else ("--fps", 20)), *more)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def stats(self, *more, camera="-10,-72,300000,20,-30,0"):
        out = self.work / "stats.json"
        done = self.run_program("render", self.database, "--camera", camera, "--size", SIZE, "-o", self.work / "x.png",
                                "--stats", out, *more)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(out.read_text())

    def test_frames_and_plot(self):
        frames, plot = self.work / "frames.csv", self.work / "frames.svg"
        summary = json.loads(self.bench("--stats", frames, "--plot", plot, "--json"))
        rows = list(csv.DictReader(frames.read_text().splitlines()))
        self.assertEqual(len(rows), summary["frames"])
        self.assertGreater(len(rows), 3)
        for name in ["time_s", *CONTRACT, *(f"level_{level}" for level in range(32))]:
            self.assertIn(name, rows[0])
        times = [float(row["time_s"]) for row in rows]
        self.assertEqual(times, sorted(times))
        for row in rows:
            self.assertEqual(sum(int(row[f"level_{level}"]) for level in range(32)), int(row["tiles_drawn"]))
            self.assertIn(row["complete"], ("true", "false"))
        self.assertGreater(int(rows[-1]["triangles"]), 0)

        root = xml.etree.ElementTree.parse(plot).getroot()
        self.assertEqual(root.tag, SVG + "svg")
        words = [text.text for text in root.iter(SVG + "text")]
        for wanted in ("Frame time", "Quality", "Tiles wanted but missing", "Tiles drawn, by level", "Triangles", "GPU memory", "ms", "tiles",
                       "thousands", "MiB", "1: full", "seconds of the path", "whole frame", "level 0"):
            self.assertIn(wanted, words)
        self.assertIn("heights & <more>.tdb", words[0])
        drawn_levels = sum(any(int(row[f"level_{level}"]) for row in rows) for level in range(32))
        self.assertEqual(len(list(root.iter(SVG + "polygon"))), drawn_levels)
        self.assertEqual(len(list(root.iter(SVG + "polyline"))), 7)  # three times, quality, missing tiles, triangles, memory
        width, height = float(root.get("width")), float(root.get("height"))
        for shape in [*root.iter(SVG + "polygon"), *root.iter(SVG + "polyline")]:
            points = [tuple(map(float, point.split(","))) for point in shape.get("points").split()]
            self.assertGreater(len(points), 1)
            for x, y in points:
                self.assertTrue(0 <= x <= width and 0 <= y <= height, (x, y))

    def test_the_last_time_of_the_plot_is_the_last_of_the_path(self):
        plot = self.work / "ticks.svg"
        self.bench("--plot", plot, "--fps", 0)
        root = xml.etree.ElementTree.parse(plot).getroot()
        ticks = [text.text for text in root.iter(SVG + "text") if text.get("text-anchor") == "middle"]
        self.assertIn("2", ticks)

    def test_the_regular_mesh_has_more_triangles_and_no_more_error(self):
        bisected, regular = self.stats(), self.stats("--mesh", "regular")
        self.assertEqual(regular["triangles"] % 32, 0)
        self.assertGreater(regular["triangles"], 4 * bisected["triangles"])
        self.assertLessEqual(max(bisected["max_screen_error_px"], regular["max_screen_error_px"]), 1.0)

    def test_vertices_a_pixel(self):
        before = 0
        for density in (0.005, 0.05, 0.2, 1):
            stats = self.stats("--vertices-per-pixel", density, "--mesh", "regular")
            self.assertTrue(stats["complete"])
            self.assertGreaterEqual(stats["triangles"], before)
            before = stats["triangles"]
        self.assertGreater(before / 2, 512 * 384)  # the picture is all ground, so half as many vertices as triangles

    def test_quality_divides_the_tolerance(self):
        plain, coarse, fine = self.stats(), self.stats("--quality", 0.1), self.stats("--quality", 4)
        self.assertEqual([s["quality"] for s in (plain, coarse, fine)], [1, 0.1, 4])
        self.assertLess(coarse["tiles_drawn"], plain["tiles_drawn"])
        self.assertLess(plain["tiles_drawn"], fine["tiles_drawn"])
        for stats, tolerance in ((coarse, 10), (plain, 1), (fine, 0.25)):
            self.assertLessEqual(stats["max_screen_error_px"], tolerance)
        counts = ("tiles_drawn", "triangles", "max_screen_error_px")
        both = self.stats("--quality", 2, "--tolerance", 2)
        self.assertEqual([both[c] for c in counts], [plain[c] for c in counts])
        dense, denser = (self.stats("--vertices-per-pixel", v, *more) for v, more in ((0.2, ("--quality", 0.5)), (0.05, ())))
        self.assertEqual([dense[c] for c in counts], [denser[c] for c in counts])

    def test_automatic_quality(self):
        frames = self.work / "automatic.csv"
        slow = json.loads(self.bench("--quality", "auto", "--frame-ms", 1, "--stats", frames, "--json"))
        self.assertLess(slow["quality_min"], 0.5)
        self.assertLess(slow["quality_min"], slow["quality_p50"])
        qualities = [float(row["quality"]) for row in csv.DictReader(frames.read_text().splitlines())]
        self.assertEqual(qualities[0], 1)
        self.assertEqual(min(qualities), slow["quality_min"])
        self.assertEqual(qualities, sorted(qualities, reverse=True))  # even the floor is too slow
        # Coarser ground first, then fewer pixels too, to a half of each side.
        self.assertEqual([row["resolution"] for row in csv.DictReader(frames.read_text().splitlines()) if float(row["quality"]) >= 0.5][-1], "1.0")
        self.assertEqual([row["resolution"] for row in csv.DictReader(frames.read_text().splitlines()) if float(row["quality"]) <= 0.25][-1], "0.5")
        fast = json.loads(self.bench("--quality", "auto", "--frame-ms", 10000, "--json"))
        self.assertEqual(fast["quality_min"], 1)

    def test_resolution(self):
        """More pixels or fewer for a pixel of the window: the ground is the same."""
        tiles = []
        still = self.work / "still.csv"
        for resolution in ("0.5", "1", "2"):
            for seconds in (2, 20):  # the second for a machine that has not got all in the first
                still.write_text("".join(f"{second},-10,-72,100000,20,-30,0\n" for second in (0, seconds)))
                frames = self.work / "resolution.csv"
                done = self.run_program("bench", self.database, "--path", still, "--size", "320x240", "--fps", 20, "--resolution", resolution,
                                        "--stats", frames)
                self.assertEqual(done.returncode, 0, done.stderr)
                rows = list(csv.DictReader(frames.read_text().splitlines()))
                if rows[-1]["complete"] == "true":
                    break
            self.assertEqual({float(row["resolution"]) for row in rows}, {float(resolution)})
            self.assertLessEqual(float(rows[-1]["max_screen_error_px"]), 1.0)
            tiles.append((rows[-1]["tiles_drawn"], rows[-1]["triangles"], rows[-1]["max_screen_error_px"]))
        self.assertEqual(len(set(tiles)), 1, tiles)

    def test_frames_keep_the_beat(self):
        frames = self.work / "beat.csv"
        self.bench("--stats", frames, "--fps", 10)
        beats = [int(10 * float(row["time_s"])) for row in csv.DictReader(frames.read_text().splitlines())]
        self.assertEqual(len(beats), len(set(beats)), "two frames in one beat")
        self.assertEqual(self.run_program("bench", self.database, "--path", self.path, "--fps", -1).returncode, 2)

    def test_uploads(self):
        def most(*more):
            frames = self.work / "uploads.csv"
            self.bench("--stats", frames, *more)
            rows = list(csv.DictReader(frames.read_text().splitlines()))
            # In the first frames the roots come, all at once: 12 of a mesh and a relief.
            return max(int(row["upload_bytes"]) for row in rows if int(row["tiles_drawn"]) > 12)

        self.assertLessEqual(most("--uploads", 0.5), 2**19)
        self.assertGreater(most("--uploads", 0), 0)
        self.assertEqual(self.run_program("render", self.database, "--camera", "0,0,6e6,0,-90,0", "--uploads", 1, "-o", self.work / "x.png").returncode, 2)

    def test_says_what_was_too_small(self):
        play = ("bench", self.database, "--path", self.path, "--size", "320x240")
        budget = self.run_program(*play, "--max-tiles", 16)
        self.assertEqual(budget.returncode, 0, budget.stderr)
        self.assertRegex(budget.stderr, r"warning: in \d+ of \d+ frames, the 16 tiles \(--max-tiles\) .* pixels off")
        memory = self.run_program(*play, "--gpu-memory", 1, "--uploads", 0)
        self.assertRegex(memory.stderr, r"warning: in \d+ of \d+ frames, \d+ pictures .* --gpu-memory")
        self.assertNotIn("warning", self.run_program(*play).stderr)

    def test_wrong_use(self):
        view = ("render", self.database, "--camera", "0,0,6e6,0,-90,0", "-o", self.work / "x.png")
        play = ("bench", self.database, "--path", self.path)
        for words, part in (((*view, "--tolerance", 1, "--vertices-per-pixel", 1), "--vertices-per-pixel"),
                            ((*view, "--vertices-per-pixel", "nan"), "--vertices-per-pixel"),
                            ((*view, "--vertices-per-pixel", 0), "--vertices-per-pixel"),
                            ((*view, "--mesh", "skirts"), "--mesh"),
                            ((*view, "--quality", 0), "1 is full quality"),
                            ((*view, "--quality", "nan"), "1 is full quality"),
                            ((*view, "--quality", "auto"), "bench and view"),
                            ((*view, "--frame-ms", 20), "--frame-ms is for bench and view, whose quality it holds; here each picture is waited for"),
                            ((*view, "--uploads", 1), "--uploads is for bench and view"),
                            ((*view, "--resolution", 1), "--resolution is for bench and view"),
                            ((*play, "--resolution", 0.4), "--resolution"),
                            ((*play, "--quality", "best"), "'auto' or a number"),
                            ((*play, "--frame-ms", 20), "--quality auto"),
                            ((*play, "--plot", self.work / "x.png"), ".svg"),
                            ((*play, "--plot", self.work / "x.svg", "--stats", self.work / "x.svg"), "the same file")):
            done = self.run_program(*words)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(part, done.stderr)
        self.assertFalse((self.work / "x.svg").exists())
        for subcommand in ("render", "fly", "bench", "view"):
            help_text = self.run_program(subcommand, "--help").stdout
            self.assertIn("--vertices-per-pixel", help_text)
            self.assertIn("--mesh", help_text)
            self.assertIn("--quality", help_text)


if __name__ == "__main__":
    Bench.program, Bench.source, Bench.work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    unittest.main(argv=sys.argv[:1])
