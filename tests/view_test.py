#!/usr/bin/env python3
"""The viewer as a person uses it: a window on a display of its own, real mouse and keyboard events.

    view_test.py PROGRAM SOURCE_DIR WORK_DIR

Exit status 77 (skipped) where Xvfb, xdotool or ImageMagick are missing.
"""
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time

SKIPPED = 77
RADIUS_M = 6378137.0
SIZE = (640, 480)
FOV_DEGREES = 45.0


LONG_S = 240.0  # how long a busy machine may take for what an idle one does at once


def wait_for(what, condition, seconds=LONG_S):
    """The first true answer of `condition`; fails when none comes in time."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        answer = condition()
        if answer:
            return answer
        time.sleep(0.05)
    raise AssertionError(f"waited {seconds:.0f} s in vain for {what}")


class Display:
    """An X server without a screen, on a free number."""

    def __init__(self):
        # An X server starts over when its last client leaves, and turns away whoever comes meanwhile: the next viewer.
        # -noreset keeps it as it is.
        reading, writing = os.pipe()
        self.process = subprocess.Popen(
            ["Xvfb", "-displayfd", str(writing), "-screen", "0", "1280x1024x24", "+extension", "GLX", "-nolisten", "tcp", "-noreset"],
            pass_fds=[writing], stderr=subprocess.DEVNULL)
        os.close(writing)
        with os.fdopen(reading) as numbers:
            number = numbers.readline().strip()
        assert number, "Xvfb did not start"
        self.environment = {**os.environ, "DISPLAY": f":{number}"}
        self.environment.pop("WAYLAND_DISPLAY", None)

    def stop(self):
        self.process.terminate()
        self.process.wait(60)


class Viewer:
    """The program with its window, and a hand on mouse and keyboard."""

    def __init__(self, program, display, folder, scene, camera, *more):
        # What a viewer remembers stays in this folder.
        self.environment = {**display.environment, "XDG_CONFIG_HOME": os.path.join(folder, "config")}
        self.folder = folder
        self.output = open(os.path.join(folder, "stdout.txt"), "w+")
        self.errors = open(os.path.join(folder, "stderr.txt"), "w+")
        self.process = subprocess.Popen(
            [program, "view", scene, "--camera", camera, "--size", f"{SIZE[0]}x{SIZE[1]}", "--fov", str(FOV_DEGREES), *more],
            cwd=folder, env=self.environment, stdout=self.output, stderr=self.errors)
        found = wait_for("the window", lambda: self.alive() and self.xdotool("search", "--onlyvisible", "--name", "Tellurion", check=False))
        self.window = found.split()[0]

    def alive(self):
        assert self.process.poll() is None, "the viewer ended: " + self.text(self.errors)
        return True

    @staticmethod
    def text(file):
        file.flush()
        with open(file.name) as again:
            return again.read()

    def xdotool(self, *arguments, check=True):
        done = subprocess.run(["xdotool", *map(str, arguments)], env=self.environment, capture_output=True, text=True)
        assert done.returncode == 0 or not check, done.stderr
        return done.stdout.strip()

    def move(self, x, y):
        self.xdotool("mousemove", "--window", self.window, x, y)

    def key(self, name):
        self.xdotool("key", name)

    def drag(self, button, start, end):
        self.move(*start)
        self.xdotool("mousedown", button)
        for share in (0.3, 0.7, 1.0):
            self.move(*(round(a + (b - a) * share) for a, b in zip(start, end)))
        self.xdotool("mouseup", button)

    def wheel(self, steps, at):
        self.move(*at)
        self.xdotool("click", "--repeat", abs(steps), "--delay", 10, 4 if steps > 0 else 5)

    def camera(self):
        """The camera once it stands still, as the program prints it."""
        seen = [self.camera_now()]

        def stands():
            seen.append(self.camera_now())
            return seen[-1] == seen[-2]

        wait_for("an eye that stands still", stands)
        return seen[-1]

    def camera_now(self):
        """What the program prints when asked for its camera: lat, lon, height, heading, pitch, roll."""
        before = len(self.text(self.output).splitlines())
        asked = [0.0]

        def line():
            if time.monotonic() - asked[0] > 4.0:  # once more, should a panel that was closing have got the key
                self.key("c")
                asked[0] = time.monotonic()
            return self.alive() and self.text(self.output).splitlines()[before:]

        lines = wait_for("the camera line", line)
        return [float(value) for value in lines[-1].split(",")]

    def screenshot(self):
        before = len(re.findall("^screenshot: ", self.text(self.errors), re.M))
        self.key("F12")
        paths = wait_for("the screenshot", lambda: self.alive() and re.findall("^screenshot: (.*)", self.text(self.errors), re.M)[before:])
        return paths[-1]

    def cpu_seconds(self):
        with open(f"/proc/{self.process.pid}/stat") as stat:
            fields = stat.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def complete(self):
        """Whether all that the view needs is there. The answer may be a frame old."""
        self.alive()
        return "(loading)" not in self.xdotool("getwindowname", self.window)

    def wait_until_complete(self):
        self.camera()
        time.sleep(0.3)
        wait_for("all data", self.complete)

    def idle(self):
        before = self.cpu_seconds()
        time.sleep(1.0)
        return self.cpu_seconds() - before < 0.1

    def end(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait(60)


def picture(path):
    """Width, height and the list of pixels (r, g, b) of a picture file."""
    size = subprocess.run(["identify", "-format", "%w %h", path], capture_output=True, text=True, check=True).stdout
    width, height = map(int, size.split())
    raw = subprocess.run(["convert", path, "-depth", "8", "rgb:-"], capture_output=True, check=True).stdout
    return width, height, [tuple(raw[i:i + 3]) for i in range(0, len(raw), 3)]


def on_sphere(camera, pixel, size=SIZE):
    """Latitude and longitude in degrees where the ray through a pixel meets a sphere: an independent check of the controls."""
    lat, lon, height, heading, pitch, _ = camera
    lat, lon, heading, pitch = (math.radians(v) for v in (lat, lon, heading, pitch))
    east = (-math.sin(lon), math.cos(lon), 0.0)
    north = (-math.sin(lat) * math.cos(lon), -math.sin(lat) * math.sin(lon), math.cos(lat))
    up = (math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat))
    scale = 2.0 * math.tan(math.radians(FOV_DEGREES) / 2.0) / size[1]
    x, y = (pixel[0] + 0.5 - size[0] / 2) * scale, (size[1] / 2 - pixel[1] - 0.5) * scale
    ahead = math.cos(pitch) - y * math.sin(pitch)
    rise = math.sin(pitch) + y * math.cos(pitch)
    e = ahead * math.sin(heading) + x * math.cos(heading)
    n = ahead * math.cos(heading) - x * math.sin(heading)
    ray = [e * east[i] + n * north[i] + rise * up[i] for i in range(3)]
    norm = math.sqrt(sum(v * v for v in ray))
    ray = [v / norm for v in ray]
    eye = [(RADIUS_M + height) * v for v in up]
    b = sum(p * v for p, v in zip(eye, ray))
    inside = b * b - sum(p * p for p in eye) + RADIUS_M ** 2
    assert inside > 0, "the pixel shows the sky"
    t = -b - math.sqrt(inside)
    p = [eye[i] + t * ray[i] for i in range(3)]
    return math.degrees(math.asin(p[2] / RADIUS_M)), math.degrees(math.atan2(p[1], p[0]))


def run_steps(steps):
    """One after the other, and how long each took."""
    for step in steps:
        began = time.monotonic()
        step()
        print(f"{step.__code__.co_names[0]}: {time.monotonic() - began:.1f} s", flush=True)


def run_in_window(program, folder, scene, start, steps_of):
    """The steps that `steps_of(viewer)` returns, with a viewer on a display of its own once its first picture stands."""
    display = Display()
    viewer = None
    try:
        viewer = Viewer(program, display, folder, scene, ",".join(map(str, start)))
        viewer.wait_until_complete()
        run_steps(steps_of(viewer))
    finally:
        if viewer:
            viewer.end()
        display.stop()


def main_of(run):
    """Calls `run(program, source, folder)` of the command line, the folder empty, where the machine can show a window."""
    program, source, folder = (os.path.abspath(p) for p in sys.argv[1:4])
    missing = [tool for tool in ("Xvfb", "xdotool", "import", "convert", "identify") if not shutil.which(tool)]
    if missing:
        print("skipped, not installed: " + " ".join(missing))
        return SKIPPED
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    run(program, source, folder)
    return 0


def check_near(what, value, wished, tolerance):
    assert abs(value - wished) <= tolerance, f"{what}: {value}, not {wished} within {tolerance}"


def make_scene(program, source, folder):
    """A coarse Earth out of the project's own rasters, made once a folder."""
    earth = os.path.join(source, "data", "earth")
    for name, kind, raster, level in (("e.tdb", "elevation", "etopo5_dem_10min.tif", 3),
                                      ("i.tdb", "imagery", "bluemarble_dec2004_5400x2700.jpg", 2)):
        subprocess.run([program, "build", os.path.join(folder, name), os.path.join(earth, raster), "--kind", kind,
                        "--tiling", "cube", "--max-level", str(level)], check=True, stderr=subprocess.DEVNULL)
    scene = os.path.join(folder, "earth.toml")
    with open(scene, "w") as file:
        file.write('body = "earth"\ntiling = "cube"\n[[elevation]]\nsource = "e.tdb"\n[[imagery]]\nsource = "i.tdb"\n')
    return scene


def test_picture(viewer):
    """Once everything is there the picture shows a lit, textured globe on dark sky."""
    viewer.wait_until_complete()
    wait_for("a program that sleeps when nothing happens", viewer.idle)
    width, height, pixels = picture(viewer.screenshot())
    assert (width, height) == SIZE
    lit = sum(1 for p in pixels if max(p) > 24) / len(pixels)
    assert 0.2 < lit < 0.98, f"share of the picture that is not dark: {lit}"
    assert len(set(pixels)) > 1000, "a plain picture"


def test_window_shows_the_picture(viewer):
    """What the window shows is the screenshot with the status line over it, colours included."""
    width, height = SIZE
    drawn = picture(os.path.join(viewer.folder, "tellurion-0001.png"))[2]
    top = width * (height - 40)

    def shown_alike():
        """The window's pixels, once the notice of the last screenshot has gone from it."""
        shown = window_picture(viewer, "window.png")
        assert len(shown) == width * height
        return shown if all(abs(a - b) <= 2 for p, q in zip(shown[:top], drawn[:top]) for a, b in zip(p, q)) else None

    line = wait_for("a window that shows the picture", shown_alike)[width * (height - 25):]
    assert sum(1 for p in line if min(p) > 200) > 200, "no text in the status line"


def test_pan(viewer):
    before = viewer.camera()
    start, end = (300, 260), (420, 190)
    viewer.drag(1, start, end)
    after = viewer.camera()
    held, now = on_sphere(before, start), on_sphere(after, end)
    check_near("latitude of the held point", now[0], held[0], 0.3)
    check_near("longitude of the held point", now[1], held[1], 0.3)
    check_near("height", after[2], before[2], 1.0)
    check_near("heading", after[3], before[3], 1e-3)
    assert after[1] < before[1] - 5, "the drag moved nothing"


def test_wheel(viewer):
    before = viewer.camera()
    at = (250, 200)
    viewer.wheel(5, at)
    after = viewer.camera()
    held, now = on_sphere(before, at), on_sphere(after, at)
    check_near("latitude of the held point", now[0], held[0], 0.3)
    check_near("longitude of the held point", now[1], held[1], 0.3)
    check_near("share of the height left", after[2] / before[2], 0.9 ** 5, 0.06)
    check_near("roll", after[5], 0.0, 1e-4)


def test_look(viewer):
    before = viewer.camera()
    viewer.drag(3, (300, 200), (300, 300))
    after = viewer.camera()
    check_near("pitch", after[4] - before[4], 100 * math.degrees(2 * math.tan(math.radians(FOV_DEGREES / 2)) / SIZE[1]), 0.02)
    for i, what in ((0, "latitude"), (1, "longitude"), (2, "height")):
        check_near(what, after[i], before[i], 1e-3)


def test_orbit(viewer):
    before = viewer.camera()
    at = (320, 300)
    viewer.drag(2, at, (400, 240))
    after = viewer.camera()
    held, now = on_sphere(before, at), on_sphere(after, at)
    check_near("latitude of the held point", now[0], held[0], 0.3)
    check_near("longitude of the held point", now[1], held[1], 0.3)
    assert after[4] > before[4] + 5, "a drag upwards lowers the eye"
    assert abs(after[3] - before[3]) > 5


def test_reset_and_north(viewer, start):
    viewer.key("n")
    check_near("heading", (viewer.camera()[3] + 180) % 360 - 180, 0.0, 1e-3)
    viewer.key("Home")
    for value, wished in zip(viewer.camera(), start):
        check_near("camera after reset", value, wished, 1e-3)


def test_terrain_is_never_entered(viewer, program):
    viewer.wheel(60, (320, 250))
    viewer.wait_until_complete()
    viewer.wheel(60, (320, 250))
    viewer.wait_until_complete()
    lat, lon, height, *_ = viewer.camera()
    ground = height_of_ground(program, viewer.folder, lat, lon)
    assert 1.9 < height - ground < 500, f"{height - ground} m above ground"
    viewer.key("Home")


def height_of_ground(program, folder, lat, lon):
    query = subprocess.run([program, "query", os.path.join(folder, "e.tdb")], input=f"{lat} {lon}\n",
                           capture_output=True, text=True, check=True)
    return float(query.stdout.split()[0])


def test_low_start(program, display, folder, scene):
    """Coarse ground that lies over the eye lifts it while data load; in the end it is where it was asked to be."""
    lat, lon = 26.9, 87.1  # at the foot of the Himalaya
    wished = [lat, lon, height_of_ground(program, folder, lat, lon) + 20.0, 10.0, -5.0, 0.0]
    viewer = Viewer(program, display, folder, scene, ",".join(map(str, wished)))
    try:
        viewer.wait_until_complete()
        # What has come grows into its place, level after level, and the eye sinks with it.
        wait_for("the eye at its place", lambda: abs(viewer.camera()[2] - wished[2]) < 1e-3)
        for value, expected in zip(viewer.camera(), wished):
            check_near("camera", value, expected, 1e-3)
    finally:
        viewer.end()


def test_resize(viewer):
    viewer.xdotool("windowsize", "--sync", viewer.window, 500, 400)
    wait_for("a picture of the window's size", lambda: picture(viewer.screenshot())[:2] == (500, 400))
    viewer.xdotool("windowsize", "--sync", viewer.window, *SIZE)


def test_help(viewer):
    """The table of controls darkens the middle of the window and writes on it."""
    viewer.key("h")
    path = os.path.join(viewer.folder, "help.png")
    viewer.wait_until_complete()
    subprocess.run(["import", "-window", viewer.window, path], env=viewer.environment, check=True)
    width, height, pixels = picture(path)
    middle = [pixels[row * width + col] for row in range(height // 3, 2 * height // 3) for col in range(width // 4, 3 * width // 4)]
    assert sum(1 for p in middle if min(p) > 200) > 1000, "no text in the middle"
    viewer.key("Escape")


def window_picture(viewer, name):
    path = os.path.join(viewer.folder, name)
    subprocess.run(["import", "-window", viewer.window, path], env=viewer.environment, check=True)
    return picture(path)[2]


def settled_picture(viewer):
    """The picture once the ground has come and has grown into its place."""
    viewer.wait_until_complete()
    shown = [picture(viewer.screenshot())[2]]

    def is_still():
        time.sleep(0.3)
        shown.append(picture(viewer.screenshot())[2])
        return shown[-1] == shown[-2]

    wait_for("a picture that stands still", is_still)
    return shown[-1]


def test_debug_views(viewer):
    """Each of the keys 1 to 4 changes the picture, and changes it back."""
    viewer.key("Home")
    plain = settled_picture(viewer)
    seen = [plain]
    for key in "1234":
        viewer.key(key)
        shown = settled_picture(viewer)
        assert shown not in seen, f"key {key} shows nothing new"
        seen.append(shown)
        viewer.key(key)
        assert settled_picture(viewer) == plain, f"key {key} leaves something behind"
    blue = sum(1 for r, g, b in seen[3] if b > r + 60 or g > r + 60)  # of errors up to the tolerance
    assert blue > 0.2 * len(plain), "no heat of the screen error"


def test_frozen_cut(viewer):
    """The eye moves on and away, the tiles stay, so ground is missing that was out of the first picture."""
    viewer.key("Home")
    viewer.wheel(20, (320, 240))
    viewer.wait_until_complete()
    viewer.key("f")
    viewer.wheel(-20, (320, 240))
    viewer.wait_until_complete()
    frozen = picture(viewer.screenshot())[2]
    assert (255, 255, 255) in frozen, "no pyramid of the frozen eye"
    viewer.key("f")
    viewer.wait_until_complete()
    following = picture(viewer.screenshot())[2]
    dark = [sum(1 for p in pixels if max(p) < 8) for pixels in (frozen, following)]
    assert dark[0] > 1.2 * dark[1] + 5000, f"dark pixels: {dark}"


def test_statistics(viewer):
    """A table in the upper right corner."""
    def bright(name):
        pixels = window_picture(viewer, name)
        return sum(1 for row in range(200) for col in range(SIZE[0] - 220, SIZE[0]) if min(pixels[row * SIZE[0] + col]) > 200)
    viewer.wait_until_complete()
    before = bright("without.png")
    viewer.key("s")
    viewer.wait_until_complete()
    assert bright("with.png") > before + 1000, "no text in the corner"
    viewer.key("s")


def test_quality_keys(viewer):
    """Each of the keys [ and ] changes the picture, and the other one changes it back."""
    viewer.key("Home")
    plain = settled_picture(viewer)
    for there, back in (("bracketleft", "bracketright"), ("bracketright", "bracketleft")):
        viewer.xdotool("key", *[there] * 4)
        assert settled_picture(viewer) != plain, f"{there} changes nothing"
        viewer.xdotool("key", *[back] * 4)
        assert settled_picture(viewer) == plain, f"{back} does not lead back"


def test_automatic_quality(program, display, folder, scene, start):
    """Where no frame is fast enough, pictures are coarse while the eye moves and as ever when it stands; not so with A."""
    viewer = Viewer(program, display, folder, scene, ",".join(map(str, start)), "--frame-ms", "1")

    def while_moving():
        """To move the eye to where it is counts as moving, and leaves the view the same."""
        before = len(re.findall("^screenshot: ", viewer.text(viewer.errors), re.M))
        viewer.xdotool("key", "--delay", 50, *["Home"] * 60, "F12")
        paths = wait_for("the screenshot", lambda: viewer.alive() and re.findall("^screenshot: (.*)", viewer.text(viewer.errors), re.M)[before:])
        return picture(paths[-1])[2]

    try:
        plain = settled_picture(viewer)
        assert while_moving() != plain, "full quality while moving"
        assert settled_picture(viewer) == plain, "not full quality at rest"
        wait_for("a program that sleeps when nothing happens", viewer.idle)
        viewer.key("a")
        assert while_moving() == plain, "less than full quality though it is not automatic"
        viewer.key("a")
        assert while_moving() != plain, "automatic again, and full quality while moving"
    finally:
        viewer.end()


def test_quit(viewer):
    viewer.key("q")
    assert viewer.process.wait(LONG_S) == 0, viewer.text(viewer.errors)


def test_sigterm_closes_the_window(program, display, folder, scene, start):
    """As a click on its cross does, also while the program sleeps."""
    for number in (signal.SIGTERM, signal.SIGINT):
        viewer = Viewer(program, display, folder, scene, ",".join(map(str, start)))
        try:
            viewer.wait_until_complete()
            viewer.process.send_signal(number)
            assert viewer.process.wait(LONG_S) == 0, viewer.text(viewer.errors)
        finally:
            viewer.end()


def test_without_display(program, scene):
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    done = subprocess.run([program, "view", scene], env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 1, done.returncode
    assert "tellurion render" in done.stderr, done.stderr


def test_wrong_use(program, scene):
    for wrong in (["--size", "large"], ["--camera", "1,2"], ["--fov", "0"], ["--quality", "0"], ["--quality", "best"], ["--frame-ms", "0"]):
        done = subprocess.run([program, "view", scene, *wrong], capture_output=True, text=True, timeout=300)
        assert done.returncode == 2, (wrong, done.returncode, done.stderr)


def run_all(program, source, folder):
    scene = make_scene(program, source, folder)
    test_without_display(program, scene)
    test_wrong_use(program, scene)
    start = [20.0, -40.0, 9000000.0, 0.0, -90.0, 0.0]
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # what runs behind a shell may ignore it, and so would the viewer
    display = Display()
    viewer = None
    try:
        viewer = Viewer(program, display, folder, scene, ",".join(map(str, start)))
        viewer.key("m")  # what is dragged ends where it is let go
        steps = [lambda: test_picture(viewer), lambda: test_window_shows_the_picture(viewer), lambda: test_pan(viewer),
                 lambda: test_wheel(viewer), lambda: test_look(viewer), lambda: test_orbit(viewer),
                 lambda: test_reset_and_north(viewer, start), lambda: test_terrain_is_never_entered(viewer, program),
                 lambda: test_resize(viewer), lambda: test_help(viewer), lambda: test_debug_views(viewer), lambda: test_frozen_cut(viewer),
                 lambda: test_statistics(viewer), lambda: test_quality_keys(viewer), lambda: test_quit(viewer)]
        steps.append(lambda: test_low_start(program, display, folder, scene))
        steps.append(lambda: test_automatic_quality(program, display, folder, scene, start))
        steps.append(lambda: test_sigterm_closes_the_window(program, display, folder, scene, start))
        run_steps(steps)
    finally:
        if viewer:
            viewer.end()
        display.stop()


if __name__ == "__main__":
    sys.exit(main_of(run_all))
