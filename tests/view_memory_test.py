#!/usr/bin/env python3
"""What the viewer remembers from one window to the next.

    view_memory_test.py PROGRAM SOURCE_DIR WORK_DIR

Exit status 77 (skipped) where Xvfb, xdotool or ImageMagick are missing.
"""
import os
import subprocess
import sys

import view_test
from view_test import wait_for

CAMERA = "20,-40,9000000,0,-90,0"


class Remembering(view_test.Viewer):
    """Without a size of its own, unless it is given."""

    def __init__(self, program, display, folder, scene, *more):
        self.environment = {**display.environment, "XDG_CONFIG_HOME": os.path.join(folder, "config")}
        self.folder = folder
        self.output = open(os.path.join(folder, "stdout.txt"), "w+")
        self.errors = open(os.path.join(folder, "stderr.txt"), "w+")
        self.process = subprocess.Popen([program, "view", scene, "--camera", CAMERA, *more], cwd=folder, env=self.environment, stdout=self.output,
                                        stderr=self.errors)
        self.window = wait_for("the window", lambda: self.alive() and self.xdotool("search", "--onlyvisible", "--name", "Tellurion", check=False)).split()[0]
        self.wait_until_complete()

    def size(self):
        words = self.xdotool("getwindowgeometry", "--shell", self.window).split()
        named = dict(word.split("=") for word in words)
        return int(named["WIDTH"]), int(named["HEIGHT"])

    def quit(self):
        self.key("q")
        assert self.process.wait(view_test.LONG_S) == 0, self.text(self.errors)

    def has_statistics(self):
        """A table in the upper right corner."""
        width, _ = self.size()
        path = os.path.join(self.folder, "corner.png")
        subprocess.run(["import", "-window", self.window, path], env=self.environment, check=True)
        wide, _, pixels = view_test.picture(path)
        assert wide == width
        return sum(min(pixels[row * width + col]) > 200 for row in range(60, 200) for col in range(width - 220, width)) > 1000


def run_all(program, source, folder):
    scene = view_test.make_scene(program, source, folder)
    kept = os.path.join(folder, "config", "tellurion", "viewer.toml")
    display = view_test.Display()
    viewer = None

    def opened(*more):
        nonlocal viewer
        viewer = Remembering(program, display, folder, scene, *more)
        return viewer

    try:
        first = opened("--size", "640x480")
        assert not first.has_statistics()
        first.key("s")
        wait_for("the statistics", first.has_statistics)
        first.xdotool("windowsize", "--sync", first.window, 700, 520)
        wait_for("a picture of the window's size", lambda: view_test.picture(first.screenshot())[:2] == (700, 520))
        first.quit()
        assert os.listdir(os.path.dirname(kept)) == ["viewer.toml"], os.listdir(os.path.dirname(kept))
        again = opened()
        assert again.size() == (700, 520), again.size()
        wait_for("the statistics of before", again.has_statistics)
        again.quit()
        fresh = opened("--fresh", "--size", "640x480")
        assert fresh.size() == (640, 480) and not fresh.has_statistics()
        before = open(kept).read()
        fresh.key("i")
        fresh.quit()
        assert open(kept).read() == before, "a fresh window was remembered"
        with open(kept, "w") as file:
            file.write("window = [1, 2]\n")
        damaged = opened("--size", "640x480")
        assert "viewer.toml" in damaged.text(damaged.errors) and "kept as" in damaged.text(damaged.errors), damaged.text(damaged.errors)
        assert os.path.exists(kept + ".damaged")
        damaged.quit()
        assert "hint = true" in open(kept).read()
    finally:
        if viewer:
            viewer.end()
        display.stop()


if __name__ == "__main__":
    sys.exit(view_test.main_of(run_all))
