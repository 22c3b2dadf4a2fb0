#!/usr/bin/env python3
"""The window on its screen: full, and with larger letters.

    view_screen_test.py PROGRAM SOURCE_DIR WORK_DIR

Exit status 77 (skipped) where Xvfb, xdotool or ImageMagick are missing.
"""
import os
import subprocess
import sys

import view_test

CAMERA = "20,-40,9000000,0,-90,0"
SCREEN = (1280, 1024)


def letters_of(viewer, size):
    """How many pixels the letters of the status line have, which begins at the left lower corner."""
    path = os.path.join(viewer.folder, "line.png")
    subprocess.run(["import", "-window", viewer.window, path], env=viewer.environment, check=True)
    width, height, pixels = view_test.picture(path)
    assert (width, height) == size, (width, height)
    return sum(min(pixels[y * width + x]) > 200 for y in range(height - 60, height) for x in range(60))


def test_full_screen(program, display, folder, scene):
    viewer = view_test.Viewer(program, display, folder, scene, CAMERA, "--fullscreen")
    try:
        viewer.wait_until_complete()
        assert view_test.picture(viewer.screenshot())[:2] == SCREEN
        return letters_of(viewer, SCREEN)
    finally:
        viewer.end()


def test_larger_letters(program, display, folder, scene, plain):
    """Twice as high and as wide."""
    viewer = view_test.Viewer(program, display, folder, scene, CAMERA, "--fullscreen=1", "--ui-scale", "2")
    try:
        viewer.wait_until_complete()
        # Half as many letters are within those 60 pixels, four times as large each.
        assert 1.3 * plain < letters_of(viewer, SCREEN) < 3.0 * plain
    finally:
        viewer.end()


def test_wrong_use(program, display, scene):
    absent = subprocess.run([program, "view", scene, "--fullscreen=7"], env=display.environment, capture_output=True, text=True, timeout=300)
    assert absent.returncode == 1 and "no screen 7" in absent.stderr and "1 is " in absent.stderr, absent.stderr
    for wrong in ("0.1", "nan"):
        done = subprocess.run([program, "view", scene, "--ui-scale", wrong], env=display.environment, capture_output=True, text=True, timeout=300)
        assert done.returncode == 2 and "0.5 to 8" in done.stderr, done.stderr


def run_all(program, source, folder):
    scene = view_test.make_scene(program, source, folder)
    display = view_test.Display()
    try:
        plain = test_full_screen(program, display, folder, scene)
        test_larger_letters(program, display, folder, scene, plain)
        test_wrong_use(program, display, scene)
    finally:
        display.stop()


if __name__ == "__main__":
    sys.exit(view_test.main_of(run_all))
