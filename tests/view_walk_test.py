#!/usr/bin/env python3
"""Walking and flying in the viewer's window by keys that are held down.

    view_walk_test.py PROGRAM SOURCE_DIR WORK_DIR

Exit status 77 (skipped) where Xvfb, xdotool or ImageMagick are missing.
"""
import math
import sys
import time

from view_test import check_near, height_of_ground, main_of, make_scene, run_in_window, wait_for

START = [46.6, 8.0, 6000.0, 40.0, -30.0, 0.0]  # over the Alps


def metres_between(one, other):
    """Over the ground; for places near each other."""
    north = math.radians(other[0] - one[0]) * 6.37e6
    east = math.radians(other[1] - one[1]) * 6.37e6 * math.cos(math.radians(one[0]))
    return math.hypot(north, east), math.degrees(math.atan2(east, north))


def check_over_ground(viewer, program, camera, least_m=1.9):
    over_m = camera[2] - height_of_ground(program, viewer.folder, camera[0], camera[1])
    assert over_m > least_m, f"{over_m} m above the ground at {camera}"
    return over_m


def held(viewer, seconds, *keys):
    """Where the eye was before and after, and how long the keys were down: at least, at most."""
    before = viewer.camera()
    asked = time.monotonic()
    for key in keys:
        viewer.xdotool("keydown", key)
    down = time.monotonic()
    time.sleep(seconds)
    least = time.monotonic() - down
    for key in keys:
        viewer.xdotool("keyup", key)
    after = viewer.camera()
    return before, after, least, time.monotonic() - asked


def test_landing(viewer, program):
    """T from high above flies to the ground in the middle of the picture, and stands there."""
    viewer.key("t")
    wait_for("the eye of a walker", lambda: viewer.camera()[2] < 5000)
    viewer.wait_until_complete()
    # Ground that turned out to be lower is sunk to.
    camera = wait_for("an eye that stands", lambda: check_over_ground(viewer, program, viewer.camera()) < 300 and viewer.camera())
    check_near("pitch", camera[4], 0.0, 1e-3)
    check_near("heading", camera[3], START[3], 0.1)
    far, bearing = metres_between(START, camera)
    check_near("way to the middle of the picture, as the direction of the eye", bearing, START[3], 3.0)
    assert 2000 < far < 15000, far
    wait_for("a program that sleeps when nothing happens", viewer.idle)


def test_walk(viewer, program):
    """W goes on while it is down, by time, and no longer; arrows and S D too; heading and height above ground are kept."""
    for key, turned in (("w", 0.0), ("d", 90.0), ("Down", 180.0), ("Left", -90.0)):
        before, after, least, most = held(viewer, 1.0, key)
        way, bearing = metres_between(before, after)
        # The program counts from frame to frame: a slow one may see the press late, but none is longer than asked.
        assert 0.2 < way <= 5.0 * most + 0.1, (key, way, least, most)
        check_near(f"bearing of {key}", math.remainder(bearing - before[3] - turned, 360.0), 0.0, 1.0)
        check_near("heading", after[3], before[3], 0.01)
        check_over_ground(viewer, program, after)
    slow = held(viewer, 1.0, "w")
    fast = held(viewer, 1.0, "shift", "w")
    assert metres_between(*fast[:2])[0] > 2.0 * metres_between(*slow[:2])[0], "Shift is not faster"
    wait_for("a program that sleeps when no key is down", viewer.idle)


def test_look(viewer):
    before = viewer.camera()
    viewer.drag(1, (300, 200), (360, 240))
    after = viewer.camera()
    check_near("pitch", after[4] - before[4], 40 * 45.0 / 480, 0.5)
    assert after[3] < before[3] - 3.0, "the drag did not turn the eye"
    check_near("way of an eye that only looks", metres_between(before, after)[0], 0.0, 0.01)
    viewer.drag(1, (360, 240), (300, 200))
    viewer.camera()


def test_wheel_is_pace(viewer):
    viewer.wheel(10, (320, 240))
    before, after, _, most = held(viewer, 1.0, "w")
    way = metres_between(before, after)[0]
    assert 5.0 < way <= 5.0 * 1.25 ** 10 * most + 0.1, way
    viewer.wheel(-10, (320, 240))


def test_fly(viewer, program):
    """U flies along the view; down it never enters the ground; U again gives the keys back."""
    viewer.key("t")
    viewer.key("u")
    before, after, _, _ = held(viewer, 1.5, "Prior")
    assert after[2] > before[2] + 0.5, "Page Up does not rise"
    held(viewer, 1.0, "shift", "Prior")
    viewer.drag(1, (300, 150), (300, 50))  # look down
    before, after, _, _ = held(viewer, 1.5, "shift", "w")
    check_over_ground(viewer, program, after)
    way, bearing = metres_between(before, after)
    check_near("bearing", math.remainder(bearing - before[3], 360.0), 0.0, 2.0)
    assert way > 1.0, way
    viewer.key("u")
    viewer.key("s")  # the statistics again
    check_near("way of an S that leads nothing", metres_between(after, viewer.camera())[0], 0.0, 0.01)
    viewer.key("s")
    viewer.key("Home")
    for value, wished in zip(viewer.camera(), START):
        check_near("camera after the flight home", value, wished, 1e-3)


def run_all(program, source, folder):
    scene = make_scene(program, source, folder)
    run_in_window(program, folder, scene, START, lambda viewer: [
        lambda: test_landing(viewer, program), lambda: test_walk(viewer, program), lambda: test_look(viewer),
        lambda: test_wheel_is_pace(viewer), lambda: test_fly(viewer, program)])


if __name__ == "__main__":
    sys.exit(main_of(run_all))
