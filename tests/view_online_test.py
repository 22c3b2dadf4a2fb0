#!/usr/bin/env python3
"""The window over servers: `view URL#LAYER` of a real WMS, the time keys over one with a time dimension, and a layer that is added by hand.

    view_online_test.py PROGRAM SOURCE_DIR WORK_DIR

Exit status 77 (skipped) where Xvfb, xdotool, ImageMagick or MapServer are missing.
"""
import collections
import http.server
import os
import pathlib
import shutil
import subprocess
import sys
import threading

import clock_test
import map_servers
import view_test

SKIPPED = 77
CAMERA = "20,-10,9000000,0,-90,0"


def of_the_globe(viewer):
    """The middle of what the window shows, away from its panels."""
    width, height, pixels = view_test.picture(viewer.screenshot())
    return [pixels[y * width + x] for y in range(height // 3, 2 * height // 3) for x in range(width // 3, 2 * width // 3)]


def test_a_wms_opens_by_its_url(program, display, work, source):
    picture = source / "data/earth/bluemarble_dec2004_5400x2700.jpg"
    with map_servers.MapServer(work / "wms", {"bluemarble": map_servers.Layer(picture)}) as wms:
        viewer = view_test.Viewer(program, display, work, f"{wms.url}#bluemarble", CAMERA)
        try:
            viewer.wait_until_complete()
            pixels = of_the_globe(viewer)
            assert len(set(pixels)) > 1000, "a plain picture"
            # The Sahara in the east, the Atlantic in the west of the middle.
            sand = sum(r > b + 20 for r, _, b in pixels) / len(pixels)
            sea = sum(b > r + 10 for r, _, b in pixels) / len(pixels)
            assert sand > 0.15 and sea > 0.15, f"sand {sand:.2f}, sea {sea:.2f} of the middle"
            before = len(wms.requests)
            viewer.wheel(4, (view_test.SIZE[0] // 2, view_test.SIZE[1] // 2))
            view_test.wait_for("something finer to be asked for, closer", lambda: len(wms.requests) > before)
            viewer.wait_until_complete()
            maps = collections.Counter(query for query in wms.requests if "GetMap" in query)
            assert max(maps.values()) == 1, f"asked for twice: {[query for query, count in maps.items() if count > 1]}"
        finally:
            viewer.end()


# Of the panel of E as it opens, pixels of the window: where a message begins, the second layer of the list, and the button under what is told of it.
MESSAGE, LAYER, ADD = (101, 96), (200, 161), (140, 228)


def test_a_layer_is_added(program, display, work, source):
    """What is drawn in the end is what `render` draws of a scene with that layer on top."""
    night = source / "data/earth/night_lights_5400x2700.jpg"
    subprocess.run([program, "build", work / "day.tdb", source / "data/earth/bluemarble_dec2004_5400x2700.jpg", "--kind", "imagery", "--tiling", "cube",
                    "--max-level", "1"], check=True, stderr=subprocess.DEVNULL)
    day = 'body = "earth"\ntiling = "cube"\n[light]\nenabled = false\n[[imagery]]\nsource = "day.tdb"\n'
    with map_servers.MapServer(work / "wms of the night", {"night": map_servers.Layer(night)}) as wms:
        (work / "day.toml").write_text(day)
        (work / "both.toml").write_text(day + f'[[imagery]]\nsource = "{wms.url}"\ntype = "wms"\nlayer = "night"\n')
        pictures = {}
        for name in ("day", "both"):
            subprocess.run([program, "render", work / f"{name}.toml", "--camera", CAMERA, "--size", "x".join(map(str, view_test.SIZE)), "--fov",
                            str(view_test.FOV_DEGREES), "-o", work / f"{name}.png"], check=True, stderr=subprocess.DEVNULL)
            pictures[name] = view_test.picture(work / f"{name}.png")[2]
        viewer = view_test.Viewer(program, display, work, str(work / "day.toml"), CAMERA)

        def shows(name):
            drawn = view_test.picture(viewer.screenshot())[2]
            return sum(abs(a - b) for p, q in zip(drawn, pictures[name]) for a, b in zip(p, q)) / (3 * len(drawn)) < 1.5

        def bright(at, wide, high):
            pixels = view_test.window_picture(viewer, "panel.png")
            return sum(min(pixels[y * view_test.SIZE[0] + x]) > 200 for y in range(at[1], at[1] + high) for x in range(at[0], at[0] + wide))

        def ask(address):
            """Typed at once: all of it is the panel's."""
            viewer.xdotool("key", "--clearmodifiers", "e", "type", "--delay", "2", address)
            viewer.key("Return")

        try:
            viewer.wait_until_complete()
            assert shows("day") and not shows("both")
            closed = f"http://127.0.0.1:{map_servers.free_port()}/wms"
            ask(closed)
            view_test.wait_for("what is wrong with a server that is not there", lambda: bright(MESSAGE, 400, 60) > 300)
            assert shows("day")
            viewer.key("Escape")
            viewer.key("e")
            ask(wms.url)
            view_test.wait_for("a list", lambda: bright((LAYER[0] - 60, LAYER[1] - 6), 150, 12) > 40)
            for at in (LAYER, ADD):
                viewer.move(*at)
                viewer.xdotool("click", 1)
                viewer.wait_until_complete()
            view_test.wait_for("the layer on top", lambda: shows("both"))
        finally:
            viewer.end()


def test_time_keys(program, display, work, _):
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), clock_test.TwoColours)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    scene = work / "colours.toml"
    scene.write_text(f'body = "earth"\n[[imagery]]\nsource = "http://127.0.0.1:{server.server_port}/wms"\ntype = "wms"\nlayer = "colour"\ntime = "clock"\nmax_level = 2\n'
                     '[light]\nenabled = false\n[clock]\nstart = "2004-01-01T00:00:00Z"\nstep = 15811200\n')
    viewer = view_test.Viewer(program, display, work, str(scene), CAMERA)
    try:
        def shows(channel):
            viewer.wait_until_complete()
            pixels = of_the_globe(viewer)
            return all(p[channel] > 60 and sum(p) - p[channel] < 30 for p in pixels)
        view_test.wait_for("January, which is red, at first", lambda: shows(0))
        viewer.key("apostrophe")
        view_test.wait_for("July, which is blue", lambda: shows(2))
        viewer.key("semicolon")
        view_test.wait_for("January, which is red", lambda: shows(0))
    finally:
        viewer.end()
        server.shutdown()


def main():
    program, source, work = (pathlib.Path(word).resolve() for word in sys.argv[1:4])
    absent = [tool for tool in ("Xvfb", "xdotool", "convert", "identify") if not shutil.which(tool)] + map_servers.missing()
    if absent:
        print(f"not installed: {', '.join(absent)}")
        return SKIPPED
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    os.environ["XDG_CACHE_HOME"] = str(work / "cache")
    display = view_test.Display()
    try:
        for test in (test_a_wms_opens_by_its_url, test_a_layer_is_added, test_time_keys):
            test(str(program), display, work, source)
            print(f"{test.__name__}: ok")
    finally:
        display.stop()
    return 0


if __name__ == "__main__":
    sys.exit(main())
