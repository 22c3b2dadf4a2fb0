#!/usr/bin/env python3
"""What is held stays held: real mouse and keyboard events in the viewer's window, checked by exact geometry.

    view_grip_test.py PROGRAM SOURCE_DIR WORK_DIR [--whole] [--seed S]

In random attitudes over the whole Earth, from 30 m above ground to 30,000 km, every control is used that holds a point of
the ground. Where that point is, is found here: the ray through the pixel of the camera that the program printed, and where
it meets the ground of `tellurion query` on WGS 84. It must then be within a pixel of where it is held, in every camera that
is printed on the way, and no camera may be below the ground. --whole: 200 attitudes; else a sample. Exit status 77 (skipped)
where Xvfb or xdotool are missing.
"""
import argparse
import math
import os
import random
import shutil
import subprocess
import sys
import time

from view_test import FOV_DEGREES, SIZE, SKIPPED, Display, Viewer, make_scene

A = 6378137.0
E2 = (2.0 - 1.0 / 298.257223563) / 298.257223563
HIGHEST_M = 9000.0
PIXEL = 2.0 * math.tan(math.radians(FOV_DEGREES) / 2.0) / SIZE[1]
CLEARANCE_M = 2.0


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def body(lat, lon, height_m):
    """WGS 84, degrees and metres, to earth-centred metres (EPSG 9602)."""
    phi, lam = math.radians(lat), math.radians(lon)
    n = A / math.sqrt(1.0 - E2 * math.sin(phi) ** 2)
    return ((n + height_m) * math.cos(phi) * math.cos(lam), (n + height_m) * math.cos(phi) * math.sin(lam),
            (n * (1.0 - E2) + height_m) * math.sin(phi))


def geodetic(p):
    """Back again: the latitude is the fixed point of the formula above, found by iteration."""
    across = math.hypot(p[0], p[1])
    phi = math.atan2(p[2], across * (1.0 - E2))
    for _ in range(6):
        n = A / math.sqrt(1.0 - E2 * math.sin(phi) ** 2)
        phi = math.atan2(p[2] + E2 * n * math.sin(phi), across)
    n = A / math.sqrt(1.0 - E2 * math.sin(phi) ** 2)
    height_m = across * math.cos(phi) + p[2] * math.sin(phi) - A * A / n
    return math.degrees(phi), math.degrees(math.atan2(p[1], p[0])), height_m


def axes(camera):
    """The eye, and right, up and forward of the picture; roll 0."""
    lat, lon, height_m, heading, pitch, roll = camera
    assert abs(roll) < 1e-4, f"a roll of {roll}"
    phi, lam, h, p = (math.radians(v) for v in (lat, lon, heading, pitch))
    east = (-math.sin(lam), math.cos(lam), 0.0)
    north = (-math.sin(phi) * math.cos(lam), -math.sin(phi) * math.sin(lam), math.cos(phi))
    zenith = (math.cos(phi) * math.cos(lam), math.cos(phi) * math.sin(lam), math.sin(phi))
    level = [n * math.cos(h) + e * math.sin(h) for n, e in zip(north, east)]
    right = [e * math.cos(h) - n * math.sin(h) for n, e in zip(north, east)]
    forward = [v * math.cos(p) + z * math.sin(p) for v, z in zip(level, zenith)]
    up = [z * math.cos(p) - v * math.sin(p) for v, z in zip(level, zenith)]
    return body(lat, lon, height_m), right, up, forward


def ray(camera, pixel):
    """Unit direction through the middle of a pixel."""
    eye, right, up, forward = axes(camera)
    x, y = (pixel[0] + 0.5 - SIZE[0] / 2) * PIXEL, (SIZE[1] / 2 - pixel[1] - 0.5) * PIXEL
    v = [f + x * r + y * u for f, r, u in zip(forward, right, up)]
    length = math.sqrt(dot(v, v))
    return eye, [c / length for c in v]


def pixels_off(camera, point, pixel):
    eye, right, up, forward = axes(camera)
    to = [a - b for a, b in zip(point, eye)]
    depth = dot(to, forward)
    if depth <= 0.0:
        return math.inf
    x = dot(to, right) / depth / PIXEL + SIZE[0] / 2 - 0.5
    y = SIZE[1] / 2 - 0.5 - dot(to, up) / depth / PIXEL
    return math.hypot(x - pixel[0], y - pixel[1])


class Terrain:
    def __init__(self, program, database):
        self.command = [program, "query", database]

    def heights_m(self, places):
        text = "".join(f"{lat:.12f} {lon:.12f}\n" for lat, lon in places)
        done = subprocess.run(self.command, input=text, capture_output=True, text=True, check=True)
        return [float(line.split()[0]) for line in done.stdout.splitlines()]

    def clearances_m(self, points):
        found = [geodetic(p) for p in points]
        grounds = self.heights_m([g[:2] for g in found])
        return [g[2] - ground for g, ground in zip(found, grounds)]

    def under(self, camera, pixel):
        """Where the ray meets the ground first; nothing in the sky, and where it only grazes the ground: a pixel is a long way there."""
        eye, way = ray(camera, pixel)
        along = lambda t: tuple(e + t * w for e, w in zip(eye, way))
        middle = -dot(eye, way)
        nearest = dot(eye, eye) - middle * middle
        if middle <= 0.0 or nearest > (A - 30e3) ** 2:
            return None
        # Spheres around the body and within it: between them the ground is met.
        top, bottom = A + HIGHEST_M, A * math.sqrt(1.0 - E2) - 12e3
        first = max(0.0, middle - math.sqrt(max(top * top - nearest, 0.0)))
        last = middle - math.sqrt(max(bottom * bottom - nearest, 0.0))
        steps = [first + (last - first) * (i / 1500.0) ** 2 if first == 0.0 else first + (last - first) * i / 1500.0 for i in range(1501)]
        for _ in range(4):
            clearances = self.clearances_m([along(t) for t in steps])
            below = next((i for i, c in enumerate(clearances) if c <= 0.0), None)
            if not below:
                return None
            a, b = steps[below - 1], steps[below]
            if b - a < 1e-5:
                break
            steps = [a + (b - a) * i / 200.0 for i in range(201)]
        point = along(b)
        lat, lon, _ = geodetic(point)
        zenith = axes((lat, lon, 0.0, 0.0, 0.0, 0.0))[2]
        return point if -dot(way, zenith) > 0.15 else None


class Attitude:
    """A viewer that begins in an attitude, and what was found of it."""

    def __init__(self, viewer, terrain, chance):
        self.viewer, self.terrain, self.chance = viewer, terrain, chance
        self.cameras = []
        self.worst_px = {}

    def camera(self, *, rest=True):
        found = self.viewer.camera() if rest else self.viewer.camera_now()
        self.cameras.append(found)
        return found

    def hold(self, near=None):
        """A pixel that shows ground, and that ground; not near the rim of the picture."""
        camera = self.camera()
        for _ in range(25):
            pixel = near or (self.chance.randint(90, SIZE[0] - 90), self.chance.randint(60, SIZE[1] - 90))
            point = self.terrain.under(camera, pixel)
            if point:
                return camera, pixel, point
            if near:
                break
        return None

    def check(self, what, camera, point, pixel):
        off = pixels_off(camera, point, pixel)
        self.worst_px[what] = max(self.worst_px.get(what, 0.0), off)
        return off

    def pan(self):
        held = self.hold()
        if not held:
            return
        camera, start, point = held
        end = tuple(s + self.chance.randint(-110, 110) for s in start)
        end = (min(max(end[0], 5), SIZE[0] - 5), min(max(end[1], 5), SIZE[1] - 30))
        if not self.terrain.under(camera, end):
            return
        self.viewer.move(*start)
        self.viewer.xdotool("mousedown", 1)
        for share in (0.5, 1.0):
            at = tuple(round(a + (b - a) * share) for a, b in zip(start, end))
            self.viewer.move(*at)
            self.check("drag", self.camera(rest=False), point, at)
        self.viewer.xdotool("mouseup", 1)
        self.check("drag", self.camera(), point, end)

    def wheel(self):
        for steps in (self.chance.randint(1, 6), -self.chance.randint(1, 6)):
            held = self.hold()
            if not held:
                return
            _, at, point = held
            self.viewer.wheel(steps, at)
            for rest in (False, True):
                camera = self.camera(rest=rest)
                # From far out the body may be too small to reach the pixel; then the eye looks straight down (docs/viewer.md).
                if steps > 0 or camera[4] > -89.999:
                    self.check("wheel", camera, point, at)

    def orbit(self):
        held = self.hold()
        if not held:
            return
        _, start, point = held
        self.viewer.move(*start)
        self.viewer.xdotool("mousedown", 2)
        for _ in range(2):
            self.viewer.move(start[0] + self.chance.randint(-60, 60), start[1] + self.chance.randint(-30, 60))
            self.check("orbit", self.camera(rest=False), point, start)
        self.viewer.xdotool("mouseup", 2)
        self.check("orbit", self.camera(), point, start)

    def look(self):
        before = self.camera()
        start = (self.chance.randint(100, 500), self.chance.randint(100, 400))
        self.viewer.drag(3, start, (start[0] + self.chance.randint(-60, 60), start[1] + self.chance.randint(-60, 60)))
        after = self.camera()
        moved = math.dist(body(*before[:3]), body(*after[:3]))
        assert moved < 0.01, f"to look around moves the eye by {moved} m"

    def leap(self):
        held = self.hold()
        if not held:
            return
        _, at, point = held
        self.viewer.move(*at)
        self.viewer.xdotool("click", "--repeat", 2, "--delay", 30, 1)
        self.check("double click", self.camera(), point, at)

    def keys(self):
        """What the middle of the picture shows stays there; the arrows shift it by a tenth of the picture's height."""
        middle, step = (SIZE[0] / 2 - 0.5, SIZE[1] / 2 - 0.5), 0.1 * SIZE[1]
        shifts = {"plus": (0, 0), "minus": (0, 0), "n": (0, 0), "ctrl+Left": (0, 0), "ctrl+Up": (0, 0), "Left": (step, 0), "Right": (-step, 0),
                  "Up": (0, step), "Down": (0, -step)}
        key = self.chance.choice(sorted(shifts))
        held = self.hold(middle)
        goal = tuple(m + s for m, s in zip(middle, shifts[key]))
        if not held or not self.terrain.under(held[0], goal):
            return
        self.viewer.key(key)
        self.check(key, self.camera(), held[2], goal)

    def check_above_ground(self):
        return min(self.terrain.clearances_m([body(*camera[:3]) for camera in self.cameras]))


def random_cameras(chance, terrain, count):
    out = []
    while len(out) < count:
        lat, lon = math.degrees(math.asin(chance.uniform(-1, 1))), chance.uniform(-180, 180)
        above_m = 30.0 * 1e6 ** chance.random()
        pitch = chance.uniform(-90, 5) if above_m < 1e6 else chance.uniform(-90, -70)
        ground_m = terrain.heights_m([(lat, lon)])[0]
        out.append([lat, lon, ground_m + above_m, chance.uniform(-180, 180), pitch, 0.0])
    return out


def run_all(program, source, folder, count, seed):
    scene = make_scene(program, source, folder)
    terrain = Terrain(program, os.path.join(folder, "e.tdb"))
    chance = random.Random(seed)
    cameras = random_cameras(chance, terrain, count)
    display = Display()
    worst, wrong, checks = {}, [], 0
    try:
        for number, start in enumerate(cameras):
            viewer = Viewer(program, display, folder, scene, ",".join(f"{v:.9f}" for v in start))
            try:
                viewer.key("m")  # what is dragged ends where it is let go
                viewer.wait_until_complete()
                one = Attitude(viewer, terrain, random.Random(f"{seed} {number}"))
                steps = [one.pan, one.wheel, one.orbit, one.look, one.leap, one.keys]
                one.chance.shuffle(steps)
                for step in steps:
                    step()
                    viewer.wait_until_complete()
                clearance_m = one.check_above_ground()
            finally:
                viewer.end()
            checks += len(one.worst_px)
            for what, off in one.worst_px.items():
                worst[what] = max(worst.get(what, 0.0), off)
            told = " ".join(f"{what} {off:.2f}" for what, off in sorted(one.worst_px.items()))
            line = f"{number}: {','.join(f'{v:.6f}' for v in start)}: {told}; {clearance_m:.2f} m above ground at least"
            print(line, flush=True)
            if clearance_m < 0.0 or any(off > 1.0 for off in one.worst_px.values()):
                wrong.append(line)
    finally:
        display.stop()
    print("pixels off at most: " + ", ".join(f"{what} {off:.2f}" for what, off in sorted(worst.items())))
    assert checks > count, "hardly anything was held"
    assert not wrong, "a held point left its pixel, or an eye was below the ground:\n" + "\n".join(wrong)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("source")
    parser.add_argument("folder")
    parser.add_argument("--whole", action="store_true")
    parser.add_argument("--seed", type=int, default=6)
    parser.add_argument("--count", type=int)
    given = parser.parse_args()
    missing = [tool for tool in ("Xvfb", "xdotool") if not shutil.which(tool)]
    if missing:
        print("skipped, not installed: " + " ".join(missing))
        return SKIPPED
    folder = os.path.abspath(given.folder)
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    began = time.monotonic()
    run_all(os.path.abspath(given.program), os.path.abspath(given.source), folder, given.count or (200 if given.whole else 2), given.seed)
    print(f"{time.monotonic() - began:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
