#!/usr/bin/env python3
"""Pictures while a server fails in every way that tests/fault_server.py knows, standing before nginx, and after it is well again.

    online_faults_test.py PROGRAM SOURCE_DIR WORK_DIR [--whole]

--whole: every fault; else a sample. Exit status 77 (skipped) where a package is missing.
"""
import csv
import shutil
import time
import unittest

import map_servers
import online_world
from online_world import gdal, numpy

SIZE = "320x240"
CAMERA = "45,10,6000000,0,-90,0"
AWAY = "-30,-150,6000000,0,-90,0"
FINEST = 4
ODD, ODD_COLOUR = "FF00FF", (255, 0, 255)
TIMEOUT_S = 2
# What hardly comes is told once it has been under way for a second.
SLOW_TIMEOUT_S = 5
# By name: what the proxy is told, and what the program says of it.
FAULTS = {
    "status": ({}, "status 500"),
    "hang": ({}, "hardly answers"),
    "slow": ({"rate": 100}, "hardly answers"),
    "truncate": ({}, "broke off"),
    "spoil": ({}, "checksum"),
    "spoil, with right checksums": ({"fault": "spoil", "mended": 1}, "PNG"),
    "cut": ({}, "ends before it is complete"),
    "wrong size": ({"fault": "other", "path": "/small.png"}, "128 x 128 pixels"),
    "text": ({"fault": "other", "path": "/text.txt"}, "no image that is known here"),
    "html": ({}, "a page came instead of an image"),
    "xml": ({}, "LayerNotDefined"),
    "loop": ({}, "redirected more than"),
    "endless": ({}, "larger than"),
    "reset": ({}, "the connection broke"),
}
SAMPLE = ("status", "hang", "wrong size", "endless")


def inner(mask):
    """Without its rim of two pixels: how coarse the ground is moves the limb by a pixel."""
    out = mask.copy()
    for axis in (0, 1):
        for shift in (-2, -1, 1, 2):
            out &= numpy.roll(mask, shift, axis)
    return out


class Faults(unittest.TestCase):
    program = source = work = None
    whole = False

    @classmethod
    def setUpClass(cls):
        shutil.rmtree(cls.work, ignore_errors=True)
        tree = cls.work / "tree"
        online_world.make_xyz(cls.source / "data/earth/bluemarble_dec2004_5400x2700.jpg", tree, FINEST)
        for png in (tree / "xyz").rglob("*.png"):
            gdal.GetDriverByName("GTiff").CreateCopy(str(png.with_suffix(".tif")), gdal.Open(str(png)), options=["COMPRESS=LZW"])
        online_world.write_png(tree / "small.png", numpy.zeros((3, 128, 128), "uint8"))
        (tree / "text.txt").write_text("no picture at all\n")
        cls.files = cls.enterClassContext(map_servers.FileServer(tree, cls.work / "nginx"))
        cls.proxy = cls.enterClassContext(online_world.FaultServer(proxy=cls.files.url))
        entry = {"source": cls.proxy.url + "/xyz/{z}/{x}/{y}.png", "max_level": FINEST}
        cls.scene = online_world.scene_file(cls.work / "scene.toml", [entry])
        cls.healthy = cls.work / "healthy.png"
        cls.render("healthy", cls.healthy)
        cls.inside = inner(~cls.sky_of(cls.healthy))
        assert 0.5 < cls.inside.mean() < 0.98, "the picture shows ground and sky"

    def setUp(self):
        self.proxy.tell("alive")
        self.proxy.tell("clear")
        self.proxy.tell("reset")

    @classmethod
    def of_cache(cls, name):
        return online_world.Program(cls.program, cls.work / f"cache {name}")

    @classmethod
    def words(cls, out, timeout=300):
        return ["render", cls.scene, "--camera", CAMERA, "--size", SIZE, "--background", ODD, "--timeout", timeout, "-o", out]

    @classmethod
    def render(cls, name, out, status=0, timeout=300):
        return cls.of_cache(name).run(*cls.words(out, timeout), status=status)

    @staticmethod
    def sky_of(path):
        return (online_world.colours(path) == ODD_COLOUR).all(axis=2)

    def check_whole(self, path):
        self.assertEqual(int((self.sky_of(path) & self.inside).sum()), 0, f"pixels of background on the ground in {path}")

    def bench(self, name, poses):
        """Rows of figures of a flight: (seconds, camera)."""
        path, rows = self.work / f"{name}.path.csv", self.work / f"{name}.csv"
        path.write_text("".join(f"{seconds},{camera}\n" for seconds, camera in poses))
        process = self.of_cache(name).start("bench", self.scene, "--path", path, "--fps", 10, "--size", SIZE, "--stats", rows)

        def end():
            _, errors = process.communicate(timeout=300)
            self.assertEqual(process.returncode, 0, errors)
            return list(csv.DictReader(rows.read_text().splitlines()))
        return end

    def test_each_fault_leaves_a_whole_picture_and_is_told(self):
        for name, (values, words) in FAULTS.items():
            if name not in SAMPLE and not self.whole:
                continue
            with self.subTest(name):
                self.setUp()
                # Coarser levels come: what is missing is drawn from them.
                self.proxy.tell("set", **{"prefix": "/xyz/3", "fault": name, **values})
                out = self.work / f"{name}.png"
                # On a slow machine nothing of the faulty level may have come back yet: longer, until something has.
                for timeout in [SLOW_TIMEOUT_S if name in ("hang", "slow") else TIMEOUT_S] + [20, 60]:
                    done = self.render(name, out, status=1, timeout=timeout)
                    if words in done.stderr:
                        break
                self.assertIn(words, done.stderr)
                self.assertIn(self.proxy.url, done.stderr, "which server it is")
                self.assertIn("is written, but not all of it is there", done.stderr)
                self.check_whole(out)
                away = abs(online_world.colours(out) - online_world.colours(self.healthy)).mean()
                self.assertTrue(0.1 < away < 20, f"coarser, not another picture: {away}")
                self.assertEqual([path for path, count in self.proxy.state()["counts"].items() if count > 6 and name != "reset"], [])

    def test_a_dead_server_leaves_a_whole_picture(self):
        self.proxy.tell("dead")
        done = self.render("dead", self.work / "dead.png", status=1, timeout=TIMEOUT_S)
        self.assertIn("no server answers there", done.stderr)
        self.check_whole(self.work / "dead.png")

    def test_a_wrong_content_type_alone_does_no_harm(self):
        self.proxy.tell("set", prefix="/", fault="mislabel", type="text/html")
        self.render("mislabel", self.work / "mislabel.png")
        self.assertEqual((self.work / "mislabel.png").read_bytes(), self.healthy.read_bytes())

    def test_a_server_that_comes_back_completes_the_picture(self):
        out = self.work / "back.png"
        self.proxy.tell("dead")
        process = self.of_cache("back").start(*self.words(out))
        time.sleep(1.5)
        self.proxy.tell("alive")
        _, errors = process.communicate(timeout=300)
        self.assertEqual((process.returncode, errors), (0, ""))
        self.assertEqual(out.read_bytes(), self.healthy.read_bytes())

    def test_what_came_damaged_is_asked_for_again_and_not_kept(self):
        """Images whose ends look right: each once, from one level; and one that stays so."""
        tiffs = online_world.scene_file(self.work / "tiffs.toml", [{"source": self.proxy.url + "/xyz/{z}/{x}/{y}.tif", "max_level": FINEST}])
        for name, scene, rule in (("cut tiff", tiffs, {"fault": "cut"}), ("spoilt", self.scene, {"fault": "spoil"}),
                                  ("spoilt and mended", self.scene, {"fault": "spoil", "mended": 1})):
            with self.subTest(name):
                self.setUp()
                once, offline = self.work / f"{name}.png", self.work / f"{name} offline.png"
                words = [scene if word == self.scene else word for word in self.words(once)]
                self.proxy.tell("set", **{"prefix": "/xyz/3", "times": 3, **rule})
                done = self.of_cache(name).run(*words)
                self.assertEqual(done.stderr, "")
                self.assertEqual(once.read_bytes(), self.healthy.read_bytes())
                self.assertEqual(max(self.proxy.state()["counts"].values()) > 1, True, "asked again")
                self.of_cache(name).run(*words[:-1], offline, "--offline")
                self.assertEqual(offline.read_bytes(), self.healthy.read_bytes())
                # As long as it is damaged nothing of it is kept.
                stays = self.work / f"{name} stays.png"
                self.setUp()
                self.proxy.tell("set", **{"prefix": "/xyz/3", **rule})
                words = [scene if word == self.scene else word for word in self.words(stays, TIMEOUT_S)]
                self.of_cache(name + " stays").run(*words, status=1)
                offered = self.of_cache(name + " stays").run(*words, "--offline", status=1)
                self.assertIn("could not be had --offline", offered.stderr)
                self.assertNotIn("damaged", offered.stderr)
                self.check_whole(stays)

    def test_a_wrong_address_is_told_and_a_sparse_server_is_not(self):
        right = f"{self.proxy.url}/xyz/{{z}}/{{x}}/{{y}}.png"
        wrong = right.replace("/xyz/", "/wrong/") + "?token=opensesame"
        out, path = self.work / "wrong.png", self.work / "wrong.path.csv"
        path.write_text(f"0,{CAMERA}\n1,{CAMERA}\n")
        for name, layers in (("imagery", {"imagery": [{"source": wrong}]}),
                             ("elevation", {"imagery": [{"source": right, "max_level": FINEST}],
                                            "elevation": [{"source": wrong, "type": "xyz", "encoding": "terrarium"}]})):
            with self.subTest(name):
                scene = online_world.scene_file(self.work / f"wrong {name}.toml", **layers)
                program = self.of_cache(f"wrong {name}")
                for done in (program.run(*[scene if word == self.scene else word for word in self.words(out)], status=1),
                             program.run("fly", scene, "--path", path, "--fps", 1, "--size", SIZE, "-o", self.work / "wrong frames", status=1)):
                    self.assertIn("is the address right?", done.stderr)
                    self.assertIn(f"{self.proxy.url}/wrong/", done.stderr)
                    self.assertNotIn("opensesame", done.stderr)
                    self.assertEqual(done.stderr.count("address"), 1, "once for a layer")
        for prefix in ("/xyz/3", "/xyz/2/1", "/xyz/1/0"):
            self.setUp()
            self.proxy.tell("set", prefix=prefix, fault="status", code=404)
            done = self.render("sparse" + prefix.replace("/", "_"), out)
            self.assertEqual(done.stderr, "")
            self.assertGreater(self.proxy.state()["statuses"].get("404", 0), 0)

    def test_a_flight_completes_by_itself_and_backs_off_meanwhile(self):
        # All that is finer than what comes first: a success between failures says that the host is well, and then each URL backs off for itself.
        for level in (3, 4):
            self.proxy.tell("set", prefix=f"/xyz/{level}", fault="status")
        end = self.bench("well_again", [(0, CAMERA), (30, CAMERA)])
        # What comes first may take a busy machine long, and each success among it says again that the host is well: the four
        # seconds begin with the last of them.
        limit = time.monotonic() + 20
        well, failed_before, since = -1, 0, time.monotonic()
        while time.monotonic() < min(limit, since + 4):
            statuses = self.proxy.state()["statuses"]
            if statuses.get("200", 0) != well or not statuses.get("500"):
                well, failed_before, since = statuses.get("200", 0), statuses.get("500", 0), time.monotonic()
            time.sleep(0.05)
        self.assertLess(time.monotonic(), limit, "four seconds without a success")
        state = self.proxy.state()
        self.proxy.tell("clear")
        rows = end()
        failed = state["statuses"].get("500", 0)
        in_trouble = failed - failed_before
        print(f"{in_trouble} of {failed} requests to the failing host in its first 4 s, at most {max(state['counts'].values())} for one URL; "
              f"{sum(self.proxy.state()['counts'].values())} in all")
        # Six connections at first, then one at a time after 1, 2, 4 s.
        self.assertGreaterEqual(failed, 3)
        self.assertLessEqual(in_trouble, 12)
        self.assertNotEqual(rows[0]["complete"], "true")
        self.assertEqual((rows[-1]["complete"], rows[-1]["tiles_wanted"]), ("true", "0"))

    def test_a_few_coarse_images_come_before_the_many_that_roots_need(self):
        """World Wind's level zero: eight images in place of the 32 that the twelve roots of HEALPix are read from."""
        online_world.make_worldwind(self.source / "data/earth/bluemarble_dec2004_5400x2700.jpg", self.work / "tree", 1, degrees=90, side=256, name="wide")
        entry = {"source": f"{self.proxy.url}/worldwind", "type": "worldwind", "layer": "wide", "level_zero_degrees": 90, "max_level": 1, "tile_pixels": 256}
        scene = online_world.scene_file(self.work / "wide.toml", [entry], tiling="healpix")
        out = self.work / "wide.png"

        def render(cache, status, timeout):
            words = [scene if word == self.scene else word for word in self.words(out, timeout)]
            self.of_cache(cache).run(*words, status=status)
            self.check_whole(out)
            return [int(path.partition("L=")[2].partition("&")[0]) for path in self.proxy.state()["order"]], online_world.colours(out)

        levels, healthy = render("wide", 0, 120)
        print(f"{levels.count(0)} coarse images, then {levels.count(1)}")
        self.assertEqual(levels[:8], [0] * 8)
        self.assertEqual(set(levels[8:]), {1})
        self.assertGreater(levels.count(1), 8, "there is something to save")
        # Out of these eight alone there is a picture of the whole.
        self.setUp()
        self.proxy.tell("set", prefix="/worldwind?T=wide&L=1", fault="hang")
        _, coarse = render("wide coarse", 1, SLOW_TIMEOUT_S)
        self.assertLess(abs(coarse - healthy)[self.inside].mean(), 10)

    def test_nothing_comes_twice_and_turning_away_cancels(self):
        self.proxy.tell("set", prefix="/xyz/3", fault="slow", rate=3000)
        end = self.bench("turn", [(0, CAMERA), (3, CAMERA), (3.01, AWAY), (6, AWAY)])
        end()
        state = self.proxy.state()
        print(f"{state['broken']} of {sum(state['counts'].values())} transfers were let go of")
        self.assertGreater(state["broken"], 6, "more than were under way when the flight ended")
        self.assertEqual(max(state["counts"].values()), 1, "requests for one URL")

    def test_what_has_come_is_never_asked_for_again(self):
        """However often the eye turns away and back, what is let go of or not; and in the next run."""
        self.proxy.tell("set", prefix="/xyz/", latency_ms=100)
        self.bench("to and fro", [(0, CAMERA), (1, CAMERA), (1.01, AWAY), (2, AWAY), (2.01, CAMERA), (3, CAMERA), (3.01, AWAY), (4, AWAY), (4.01, CAMERA), (5, CAMERA)])()
        self.render("to and fro", self.work / "to and fro.png")
        state = self.proxy.state()
        whole = {path for path, *_, is_whole in state["answers"] if is_whole}
        print(f"{len(whole)} images came whole, {state['broken']} transfers were let go of")
        self.assertGreater(len(whole), 20)
        self.assertEqual(online_world.asked_for_again(state), [])


if __name__ == "__main__":
    online_world.run_tests(Faults, online_world.missing())
