#!/usr/bin/env python3
"""A WMS with a time dimension, MapServer over months of the Blue Marble: what it lists, each step's picture against the month's own raster, a
flight through the year, and that the step to come is there before the clock is.

    time_server_test.py PROGRAM SOURCE_DIR WORK_DIR

Exit status 77 (skipped) where a package or the shared data are missing.
"""
import json
import urllib.parse

import map_servers
import online_world

MONTHS = ("2004-01-01", "2004-04-01", "2004-07-01", "2004-10-01")
# Its pixels are nearly those of the rasters (online_test.py says why that matters).
CAMERA = "45,10,9000000,0,-90,0"
SIZE = "320x240"
COLOUR_LIMIT = 1.5


def raster_of(folder, month):
    return folder / f"bluemarble_{month[:7].replace('-', '')}_2048x1024.jpg"


class TimeServer(online_world.ServerTest):
    def setUp(self):
        super().setUp()
        self.folder = self.source / "data/earth/bluemarble_monthly"
        index = self.work / "index.shp"
        online_world.make_time_index(index, {month: raster_of(self.folder, month) for month in MONTHS})
        layers = {"months": map_servers.Layer(index, times="2004-01-01/2004-10-01/P3M", default_time=MONTHS[2])}
        self.server = map_servers.MapServer(self.work / "wms", layers).__enter__()
        self.addCleanup(self.server.__exit__)

    def scene(self, name, extra="", **entry):
        path = online_world.scene_file(self.work / f"{name}.toml", [entry])
        path.write_text(path.read_text() + extra)
        return path

    def served(self, name, time="clock", extra=""):
        return self.scene(name, extra, source=self.server.url, type="wms", layer="months", time=time)

    def render(self, scene, *more):
        out = scene.with_suffix(".png")
        self.run_it.run("render", scene, "--camera", CAMERA, "--size", SIZE, "-o", out, *more)
        return out

    def asked(self):
        """The days of all maps that were asked for, in that order."""
        queries = [{key.upper(): value for key, value in urllib.parse.parse_qsl(query)} for query in self.server.requests]
        return [query.get("TIME", "default")[:10] for query in queries if query.get("REQUEST") == "GetMap"]

    def month(self, month):
        return online_world.colours(self.render(self.scene(f"local {month}", source=str(raster_of(self.folder, month)), type="live")))

    def test_what_it_lists(self):
        offers = json.loads(self.run_it.run("sources", self.server.url, "--json").stdout)
        text = json.dumps(offers)
        self.assertIn("2004-01-01", text)
        self.assertIn("P3M", text)
        entry = self.run_it.run("sources", self.server.url, "--layer", "months").stdout
        self.assertIn('layer = "months"', entry)

    def test_each_step_is_its_raster(self):
        local = {month: self.month(month) for month in MONTHS}
        days = dict(zip(MONTHS, MONTHS)) | {"2004-06-30": MONTHS[1], "2030-01-01": MONTHS[3], "1990-01-01": MONTHS[0]}
        for day, month in days.items():
            picture = online_world.colours(self.render(self.served(f"served {month}"), "--time", day))
            misses = {other: float(abs(picture - local[other]).mean()) for other in MONTHS}
            print(f"{day}: {misses[month]:.2f} of 255 off {month} in the mean, {min(m for o, m in misses.items() if o != month):.2f} off the next best")
            self.assertLess(misses[month], COLOUR_LIMIT)
            self.assertEqual(min(misses, key=misses.get), month)
        self.assertLessEqual(set(self.asked()), set(MONTHS))

    def test_without_a_clock(self):
        """A fixed time, and none: the server's own."""
        self.render(self.served("fixed", MONTHS[1]))
        self.assertEqual(set(self.asked()), {MONTHS[1]})
        self.server.requests.clear()
        plain = self.render(self.scene("plain", source=self.server.url, type="wms", layer="months"))
        self.assertEqual(set(self.asked()), {"default"})
        self.assertEqual(plain.read_bytes(), self.render(self.served("summer", MONTHS[2])).read_bytes())
        refused = self.run_it.run("render", self.served("never", "1999-01-01"), "--camera", CAMERA, "--size", SIZE, "-o", self.work / "never.png", status=1)
        self.assertIn("1999-01-01", refused.stderr)

    def test_play(self):
        """A flight at a quarter of a year a second shows what each day shows; forwards and backwards."""
        path = self.work / "path.csv"
        path.write_text("seconds,lat,lon,height_m,heading,pitch,roll\n" + "".join(f"{t},{CAMERA}\n" for t in (0, 3)))
        single = {month: self.render(self.served(f"alone {month}"), "--time", month).read_bytes() for month in MONTHS}
        self.assertEqual(len(set(single.values())), len(MONTHS))
        for start, rate, months in (("2004-01-01", 7948800, MONTHS), ("2004-10-02", -7948800, MONTHS[::-1])):
            scene = self.served(f"flight {start}", extra=f'[clock]\nstart = "{start}"\nrate = {rate}\n')
            frames = self.work / f"frames {start}"
            self.run_it.run("fly", scene, "--path", path, "--fps", 1, "--size", SIZE, "-o", frames)
            drawn = [frame.read_bytes() for frame in sorted(frames.glob("*.png"))]
            self.assertEqual([next((m for m, p in single.items() if p == frame), None) for frame in drawn], list(months))

    def test_what_comes_next_is_loaded_ahead(self):
        """The clock goes a little way into a step and never reaches the next one: that is asked for all the same, in either direction, after what shows, and
        the one after it is not."""
        path = self.work / "path.csv"
        for start, rate, months in (("2004-01-02", 86400, MONTHS[:2]), ("2004-12-01", -86400, (MONTHS[3], MONTHS[2]))):
            scene = self.served(f"bench {start}", extra=f'[clock]\nstart = "{start}"\nrate = {rate}\n')
            for seconds in (8, 60):  # a slow machine has not come to the next step in the first of them
                path.write_text("seconds,lat,lon,height_m,heading,pitch,roll\n" + "".join(f"{t},{CAMERA}\n" for t in (0, seconds)))
                self.server.requests.clear()
                self.run_it = online_world.Program(self.program, self.work / f"cache {start} {seconds}")
                self.run_it.run("bench", scene, "--path", path, "--fps", 10, "--size", SIZE)
                asked = self.asked()
                if set(asked) == set(months):
                    break
            self.assertEqual(set(asked), set(months))
            last = max(i for i, day in enumerate(asked) if day == months[0])
            print(f"{start}: {asked.count(months[0])} maps of the step shown, then {asked.count(months[1])} of the one to come")
            self.assertLess(last, asked.index(months[1]), "the step to come waits for the one that shows")

    def test_a_server_that_is_slow_with_the_step_to_come_spoils_no_frame(self):
        """What is loaded ahead hardly comes, for seconds, while each frame has all that it shows."""
        with online_world.FaultServer(proxy=self.server.url.removesuffix("/wms")) as proxy:
            # Maps are asked for where the capabilities say.
            self.server.map_file.write_text(self.server.map_file.read_text().replace(self.server.url, proxy.url + "/wms"))
            scene = self.scene("slow", '[clock]\nstart = "2004-01-02"\nrate = 3600\n', source=proxy.url + "/wms", type="wms", layer="months", time="clock")
            self.run_it.run("render", scene, "--time", MONTHS[0], "--camera", CAMERA, "--size", SIZE, "-o", self.work / "warm.png")
            proxy.tell("reset")
            proxy.tell("set", prefix="/", fault="hang")
            path = self.work / "path.csv"
            path.write_text("seconds,lat,lon,height_m,heading,pitch,roll\n" + "".join(f"{t},{CAMERA}\n" for t in (0, 5)))
            done = self.run_it.run("fly", scene, "--path", path, "--fps", 30, "--size", SIZE, "-o", self.work / "frames")
            self.assertEqual(done.stderr, "")
            self.assertGreater(sum(proxy.state()["counts"].values()), 0, "it was asked for the step to come")


if __name__ == "__main__":
    online_world.run_tests(TimeServer, online_world.missing(), shared=True)
