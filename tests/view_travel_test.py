#!/usr/bin/env python3
"""How the eye travels in the viewer's window: flights, a drag that goes on, recordings.

    view_travel_test.py PROGRAM SOURCE_DIR WORK_DIR

Exit status 77 (skipped) where Xvfb, xdotool or ImageMagick are missing.
"""
import csv
import math
import random
import re
import sys

from view_test import FOV_DEGREES, SIZE, check_near, height_of_ground, main_of, make_scene, on_sphere, run_in_window, wait_for

START = [20.0, -40.0, 9000000.0, 0.0, -90.0, 0.0]


def check_camera(what, camera, wished, tolerance=1e-3):
    for value, expected in zip(camera[:3], wished[:3]):
        check_near(what, value, expected, tolerance)


def test_flight_home(viewer):
    """It comes from somewhere and ends where asked; Esc stops it where it is."""
    viewer.wheel(20, (250, 200))
    away = viewer.camera()
    assert away[2] < 0.3 * START[2]
    viewer.key("Home")
    check_camera("after the flight home", viewer.camera(), START)
    viewer.wheel(60, (250, 200))
    viewer.camera()
    viewer.xdotool("key", "Home", "Escape")
    stopped = viewer.camera()
    assert stopped[2] < START[2] - 1.0, "Esc did not stop the flight"
    viewer.key("Home")
    check_camera("after the flight home", viewer.camera(), START)


def test_go_to(viewer):
    """By name and by coordinates; typed as fast as keys come, at rest and while the eye flies."""
    viewer.key("g")
    viewer.xdotool("type", "--delay", 0, "zimb")
    viewer.xdotool("key", "Return")
    zimbabwe = viewer.camera()
    check_near("latitude of Zimbabwe", zimbabwe[0], -19.0, 1.0)
    check_near("longitude of Zimbabwe", zimbabwe[1], 29.0, 2.0)
    viewer.xdotool("key", "Home")  # and on the way there:
    viewer.xdotool("key", "ctrl+f")
    viewer.xdotool("type", "--delay", 3, "27 59 17 N, 86 55 30 E")
    viewer.xdotool("key", "Return")
    everest = viewer.camera()
    check_near("latitude", everest[0], 27.98806, 1e-4)
    check_near("longitude", everest[1], 86.925, 1e-4)
    viewer.key("g")
    viewer.xdotool("type", "--delay", 3, "nowhere at all")
    viewer.xdotool("key", "Return", "ctrl+a")
    viewer.xdotool("type", "--delay", 3, "10.5, -20")
    viewer.xdotool("key", "Return")
    there = viewer.camera()
    check_near("latitude", there[0], 10.5, 1e-4)
    check_near("longitude", there[1], -20.0, 1e-4)
    viewer.key("g")
    viewer.xdotool("type", "--delay", 3, "mali")
    viewer.key("Escape")
    check_camera("after a Go to that was given up", viewer.camera(), there)
    viewer.key("Home")
    check_camera("after the flight home", viewer.camera(), START)


def test_double_click(viewer):
    at = (380, 200)
    before = viewer.camera()
    viewer.move(*at)
    viewer.xdotool("click", "--repeat", 2, "--delay", 30, 1)
    after = viewer.camera()
    check_near("share of the height left", after[2] / before[2], 0.9 ** 5, 0.06)
    held, now = on_sphere(before, at), on_sphere(after, at)
    check_near("latitude of the point", now[0], held[0], 0.3)
    check_near("longitude of the point", now[1], held[1], 0.3)
    viewer.key("Home")
    check_camera("after the flight home", viewer.camera(), START)


def test_inertia(viewer):
    """What is thrown goes on and comes to rest, and then the program sleeps."""
    throw = ["mousedown", 1, "mousemove_relative", 20, 0, "sleep", 0.03, "mousemove_relative", 20, 0, "sleep", 0.03,
             "mousemove_relative", 20, 0, "mouseup", 1]
    viewer.camera()
    for attempt in range(20):  # on a busy machine the throw may be seen as a rest
        viewer.move(300, 240)
        viewer.xdotool(*throw)
        let_go = viewer.camera_now()
        rest = viewer.camera()
        if let_go[1] - rest[1] > 0.1:
            break
    else:
        raise AssertionError("the globe stops at once")
    check_near("height", rest[2], START[2], 1.0)
    viewer.move(300, 240)
    viewer.xdotool(*throw, "mousemove", "--window", viewer.window, 300, 240, *throw)
    check_near("height after two throws from one place, fast, which are no double click", viewer.camera()[2], START[2], 1.0)
    viewer.wait_until_complete()
    wait_for("a program that sleeps when nothing happens", viewer.idle)
    viewer.key("Home")
    viewer.camera()


def test_recording(viewer, scene):
    """What was flown, as a path that starts and ends where the eye did."""
    viewer.key("F9")
    viewer.wheel(10, (300, 200))
    viewer.camera()
    viewer.key("Home")
    viewer.camera()
    viewer.key("F9")
    path = wait_for("the recorded path", lambda: viewer.alive() and re.findall("^camera path: (.*)", viewer.text(viewer.errors), re.M))[-1]
    with open(path) as file:
        rows = list(csv.DictReader(file))
    seconds = [float(row["seconds"]) for row in rows]
    heights = [float(row["height_m"]) for row in rows]
    assert seconds[0] == 0.0 and seconds == sorted(set(seconds)), seconds
    assert len(rows) > 5 and min(heights) < 0.6 * START[2], (len(rows), min(heights))
    for row in (rows[0], rows[-1]):
        check_camera("an end of the recorded path", [float(row[name]) for name in ("lat", "lon", "height_m")], START)
    return path


def angle_apart_px(camera, one, other):
    """How many pixels, straight below, lie between two places on the sphere, seen from so high."""
    radius = 6378137.0
    (a, b), (c, d) = (tuple(map(math.radians, p)) for p in (one, other))
    cosine = math.sin(a) * math.sin(c) + math.cos(a) * math.cos(c) * math.cos(b - d)
    metres = radius * math.acos(max(-1.0, min(1.0, cosine)))
    return metres / (camera[2] * 2.0 * math.tan(math.radians(FOV_DEGREES / 2)) / SIZE[1])


def test_input_storm(viewer, program, folder):
    """Any keys and buttons: the eye stays above the ground and the program alive."""
    chance = random.Random(5)
    for _ in range(6):
        commands = []
        for _ in range(40):
            commands += chance.choice([
                ["key", chance.choice(["Up", "Down", "Left", "Right", "plus", "minus", "n", "Home", "Escape", "shift+Up", "ctrl+Down"])],
                ["mousemove", "--window", viewer.window, str(chance.randint(0, 639)), str(chance.randint(0, 440))],
                ["click", "--repeat", str(chance.randint(1, 9)), "--delay", "2", chance.choice(["4", "4", "5"])],
                ["mousedown", chance.choice(["1", "2", "3"])], ["mouseup", chance.choice(["1", "2", "3"])]])
        viewer.xdotool(*commands, "mouseup", "1", "mouseup", "2", "mouseup", "3")
        viewer.alive()
        lat, lon, height_m = viewer.camera()[:3]
        ground_m = height_of_ground(program, folder, lat, lon)
        assert height_m > ground_m + 1.0, f"{height_m} m over {lat}, {lon}, where the ground is {ground_m} m high"
    viewer.key("Home")
    check_camera("home after the storm", viewer.camera(), START)


def run_all(program, source, folder):
    scene = make_scene(program, source, folder)
    run_in_window(program, folder, scene, START, lambda viewer: [
        lambda: test_inertia(viewer), lambda: viewer.key("m"), lambda: test_flight_home(viewer), lambda: test_double_click(viewer),
        lambda: test_recording(viewer, scene), lambda: test_go_to(viewer), lambda: test_input_storm(viewer, program, folder)])


if __name__ == "__main__":
    sys.exit(main_of(run_all))
