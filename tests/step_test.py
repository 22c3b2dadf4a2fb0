#!/usr/bin/env python3
"""Several windows in step: a leader and three channels that follow it, on a display of their own.

    step_test.py PROGRAM SOURCE_DIR WORK_DIR [--whole]

Every frame that a follower shows is compared with the leader's by what both wrote into their logs, over 100 frames in motion or, --whole, 1,000. The
channels' pictures are joined, at rest and in the midst of a flight, and compared with one wide picture. Followers and leaders are killed and
started again. How long that took is printed and decides nothing.

Exit status 77 (skipped) where Xvfb, xdotool or ImageMagick are missing.
"""
import csv
import os
import re
import signal
import subprocess
import sys
import time

import view_test
from view_test import Display, main_of, picture, wait_for

SIZE = (240, 180)
CAMERA = "24,84,200000,20,-25,0"
TARGET = "30, 30, 4000 km"
CHANNELS = ("left", "middle", "right")
SECRET = "a secret of this test, as long as it needs to be"
# One plane in three parts of the same width: the tangents of their sides are -1.2, -0.4, 0.4 and 1.2.
TANGENT_DEGREES = {-1.2: -50.194428907734805, -0.4: -21.80140948635181, 0.4: 21.80140948635181, 1.2: 50.194428907734805}
UP_DEGREES = 16.69924423399362  # 0.3: pixels are square


def channel(name, left, right):
    return (f'[[channel]]\nname = "{name}"\nleft_degrees = {TANGENT_DEGREES[left]}\nright_degrees = {TANGENT_DEGREES[right]}\n'
            f"bottom_degrees = {-UP_DEGREES}\ntop_degrees = {UP_DEGREES}\n")


def write(path, text):
    with open(path, "w") as file:
        file.write(text)
    return path


class Window:
    """A viewer that leads or follows, in a corner of the display that is its own."""

    def __init__(self, stage, name, *arguments):
        self.stage, self.name = stage, name
        self.log = os.path.join(stage.folder, name + ".csv")
        self.errors = os.path.join(stage.folder, name + ".err")
        if os.path.exists(self.log):
            os.remove(self.log)
        self.began = time.monotonic()
        with open(self.errors, "w") as errors:
            self.process = subprocess.Popen([stage.program, "view", stage.scene, "--size", "{}x{}".format(*SIZE), "--frames-log", self.log, *arguments],
                                            cwd=stage.folder, env=stage.environment, stdout=errors, stderr=errors)
        self.window = None

    def place(self, x, y):
        self.window = wait_for("the window of " + self.name, self.find)
        self.stage.xdotool("windowmove", "--sync", self.window, x, y)

    def find(self):
        self.alive()
        found = self.stage.xdotool("search", "--onlyvisible", "--pid", self.process.pid, check=False).split()
        return found[0] if found else None

    def said(self):
        with open(self.errors) as file:
            return file.read()

    def alive(self):
        assert self.process.poll() is None, f"{self.name} ended: {self.said()}"
        return True

    def frames(self):
        """What it has shown so far: a row each, a line that is being written left out."""
        if not os.path.exists(self.log):
            return []
        with open(self.log) as file:
            text = file.read()
        return list(csv.DictReader(text[:text.rfind("\n") + 1].splitlines()))

    def last(self):
        """The number of the last frame that it has shown."""
        rows = self.frames()
        return int(rows[-1]["frame"]) if rows else 0

    def title(self):
        return self.stage.xdotool("getwindowname", self.window)

    def pixels(self):
        path = os.path.join(self.stage.folder, f"{self.name}.png")
        subprocess.run(["import", "-window", self.window, path], env=self.stage.environment, check=True)
        width, height, pixels = picture(path)
        assert (width, height) == SIZE, f"{self.name} is {width}x{height}"
        return [pixels[row * width:(row + 1) * width] for row in range(height)]

    def kill(self, how=signal.SIGKILL):
        if self.process.poll() is None:
            self.process.send_signal(how)
        self.process.wait(60)


class Stage:
    """A scene, a display, and the windows on it."""

    def __init__(self, program, source, folder):
        self.program, self.folder = program, folder
        plain = view_test.make_scene(program, source, folder)
        with open(plain) as file:
            self.text = file.read() + '[light]\nsun = "clock"\n[clock]\nstart = "2026-06-21T06:00:00Z"\nrate = 60\n'
        self.scene = write(os.path.join(folder, "stage.toml"), self.text)
        self.channels = write(os.path.join(folder, "channels.toml"), channel("left", -1.2, -0.4) + channel("middle", -0.4, 0.4) + channel("right", 0.4, 1.2))
        self.wide = write(os.path.join(folder, "wide.toml"), channel("wide", -1.2, 1.2))
        self.secret = write(os.path.join(folder, "secret"), SECRET + "\n")
        os.chmod(self.secret, 0o600)
        self.display = Display()
        self.environment = {**self.display.environment, "XDG_CONFIG_HOME": os.path.join(folder, "config")}
        self.environment.pop("TELLURION_STEP_SECRET", None)
        self.port = 0
        self.windows = []

    def xdotool(self, *arguments, check=True):
        done = subprocess.run(["xdotool", *map(str, arguments)], env=self.environment, capture_output=True, text=True)
        assert done.returncode == 0 or not check, done.stderr
        return done.stdout.strip()

    def lead(self, *more):
        leader = Window(self, "leader", "--lead", str(self.port), "--camera", CAMERA, "--secret-file", self.secret, *more)
        self.windows.append(leader)
        told = wait_for("the leader's port", lambda: leader.alive() and re.search(r"leads on 127\.0\.0\.1:(\d+)", leader.said()))
        self.port = int(told[1])
        leader.place(0, 0)
        return leader

    def keys(self, leader, *names, text=None):
        """Keys, and a line of text after them, for the leader: a window that opens takes them to itself else."""
        self.xdotool("windowfocus", "--sync", leader.window)
        self.xdotool("key", *names)
        if text:
            self.xdotool("type", "--delay", 3, text)
            self.xdotool("key", "Return")

    def follow(self, name):
        follower = Window(self, name, "--follow", f"127.0.0.1:{self.port}", "--frustum", self.channels, "--channel", name, "--secret-file", self.secret)
        self.windows.append(follower)
        follower.place(20 + CHANNELS.index(name) * 260, 240)
        return follower

    def wrong(self, *arguments, status):
        done = subprocess.run([self.program, "view", *arguments], cwd=self.folder, env=self.environment, capture_output=True, text=True, timeout=view_test.LONG_S)
        assert done.returncode == status, f"{arguments}: {done.returncode}, {done.stderr}"
        return done.stderr

    def end(self):
        for window in self.windows:
            window.kill()
        self.display.stop()


def in_step(leader):
    """How many followers have become in step and are not late, as the leader tells."""
    text = leader.said()
    return len(re.findall(" is in step$", text, re.M)) - len(re.findall(" is late: ", text, re.M))


def compare_frames(leader, followers, first, last):
    """Every frame from the first to the last, in every window, with the same picture to the last bit."""
    led = {int(row["frame"]): row for row in leader.frames()}
    skew = []
    for follower in followers:
        shown = {int(row["frame"]): row for row in follower.frames()}
        missing = [frame for frame in range(first, last + 1) if frame not in shown]
        assert not missing, f"{follower.name} has not shown {len(missing)} of {last - first + 1} frames: {missing[:5]}"
        for frame in range(first, last + 1):
            for key in ("eye_x_m", "eye_y_m", "eye_z_m", "clock_s", "picture"):
                assert shown[frame][key] == led[frame][key], f"{follower.name}, frame {frame}: {key} {shown[frame][key]}, not {led[frame][key]}"
            assert shown[frame]["released"] == "1", f"{follower.name} has shown frame {frame} by itself"
            skew.append(abs(float(shown[frame]["shown_s"]) - float(led[frame]["shown_s"])))
    eyes = {(row["eye_x_m"], row["eye_y_m"]) for frame, row in led.items() if first <= frame <= last}
    pictures = {row["picture"] for frame, row in led.items() if first <= frame <= last}
    skew.sort()
    print(f"frames {first} to {last}: {len(followers)} followers showed the leader's {len(pictures)} pictures from {len(eyes)} eyes; apart in time by "
          f"{1e3 * skew[len(skew) // 2]:.1f} ms in the median, {1e3 * skew[-1]:.1f} ms at most")
    return len(eyes)


def join(parts):
    return [left + middle + right for left, middle, right in zip(*parts)]


def step_between(rows, column):
    """Mean difference of a column of pixels and the one to its right, 0..255."""
    return sum(abs(a - b) for row in rows for a, b in zip(row[column], row[column + 1])) / (3 * len(rows))


def check_joints(rows, what):
    """No larger step where channels meet than beside it, as far as that can be told of ground that nobody knows."""
    for joint in (SIZE[0] - 1, 2 * SIZE[0] - 1):
        around = [step_between(rows, joint + i) for i in range(-6, 7) if i != 0]
        here = step_between(rows, joint)
        print(f"{what}: step at column {joint}: {here:.2f}, beside it {min(around):.2f} to {max(around):.2f}")
        assert here <= 2.0 * max(around) + 1.0, f"{what}: the channels do not join"


def save(rows, path):
    data = b"".join(bytes(pixel) for row in rows for pixel in row)
    subprocess.run(["convert", "-size", f"{len(rows[0])}x{len(rows)}", "-depth", "8", "rgb:-", path], input=data, check=True)


def still(leader):
    """Once nothing is drawn any more."""
    def stands():
        before = leader.last()
        time.sleep(1.0)
        return leader.alive() and before == leader.last()

    wait_for("a picture that stands", stands)


def test_every_frame(stage, leader, followers, frames):
    wait_for("three followers in step", lambda: all(f.alive() for f in followers) and in_step(leader) == 3)
    first = leader.last() + 2
    stage.keys(leader, "space")  # the clock runs: a frame after the other
    targets = 0
    while leader.last() < first + frames:
        if targets % 2 == 0:  # there and back
            stage.keys(leader, "g", text=TARGET)
        else:
            stage.keys(leader, "Home")
        targets += 1
        stage.keys(leader, *(("period", "o", "bracketright") if targets % 2 else ("comma", "o", "bracketleft")))  # heights, air, quality
        here = leader.last()
        wait_for("more frames", lambda: leader.alive() and leader.last() > here + frames // 3)
    eyes = compare_frames(leader, followers, first, first + frames - 1)
    assert eyes >= 5, "hardly any motion"


def stopped_in_motion(stage, leader, followers):
    """The leader is stopped in the midst of a flight, and its followers keep their pictures: rows of all joined, and whether all of them are of one frame
    that moves."""
    stage.keys(leader, "Home")
    start = float(leader.frames()[0]["eye_x_m"])
    wait_for("the beginning", lambda: abs(float(leader.frames()[-1]["eye_x_m"]) - start) < 1.0)
    stage.keys(leader, "g", text=TARGET)
    wait_for("a flight", lambda: abs(float(leader.frames()[-1]["eye_x_m"]) - start) > 100e3)
    told = in_step(leader)
    leader.process.send_signal(signal.SIGSTOP)
    try:
        wait_for("followers that miss it", lambda: all(f.alive() and "(no leader)" in f.title() for f in followers))
        rows = join([f.pixels() for f in followers])
        last = {(f.frames()[-1]["frame"], f.frames()[-1]["picture"]) for f in followers}
    finally:
        leader.process.send_signal(signal.SIGCONT)
    wait_for("followers that are back", lambda: in_step(leader) >= told + 3)
    led = {row["frame"]: row["eye_x_m"] for row in leader.frames()}
    frame = int(min(last)[0])
    return rows, len(last) == 1 and led[str(frame)] != led[str(frame - 1)]


def test_join_in_motion(stage, leader, followers):
    for _ in range(5):  # on a slow machine a flight may be over
        rows, is_one = stopped_in_motion(stage, leader, followers)
        if is_one:
            break
    assert is_one, "the channels did not stand at one frame of a flight"
    save(rows, os.path.join(stage.folder, "joined_in_motion.png"))
    check_joints(rows, "in motion")


def test_join_at_rest(stage, leader, followers):
    wait_for("all data", lambda: all(f.alive() and f.frames() and f.frames()[-1]["complete"] == "1" for f in followers))
    still(leader)
    rows = join([f.pixels() for f in followers])
    save(rows, os.path.join(stage.folder, "joined_at_rest.png"))
    check_joints(rows, "at rest")
    out = os.path.join(stage.folder, "wide.png")
    subprocess.run([stage.program, "render", stage.scene, "--camera", CAMERA, "--size", f"{3 * SIZE[0]}x{SIZE[1]}", "--frustum", stage.wide, "-o", out],
                   check=True, stderr=subprocess.DEVNULL)
    width, height, pixels = picture(out)
    wide = [pixels[row * width:(row + 1) * width] for row in range(height)]
    off = [abs(a - b) for p, q in zip(rows, wide) for c, d in zip(p, q) for a, b in zip(c, d)]
    print(f"at rest: off from one wide picture by {sum(off) / len(off):.3f} of 255 in the mean")
    assert sum(off) / len(off) < 0.1, "the joined picture is not the wide one"


def test_killed_follower(stage, leader, followers):
    here = leader.last()
    followers[1].kill()
    wait_for("frames without it", lambda: leader.alive() and leader.last() > here + 10)
    told = in_step(leader)
    followers[1] = stage.follow("middle")
    wait_for("its return", lambda: followers[1].alive() and in_step(leader) > told)
    first = leader.last() + 2
    wait_for("frames with it", lambda: leader.alive() and min(f.last() for f in followers) > first + 10)
    compare_frames(leader, followers, first, first + 10)
    led = {int(row["frame"]): float(row["shown_s"]) for row in leader.frames()}
    rows = followers[1].frames()
    begun = float(rows[0]["shown_s"])
    caught = next(float(row["shown_s"]) for row in rows if row["released"] == "1" and abs(float(row["shown_s"]) - led[int(row["frame"])]) < 0.1)
    print(f"killed and started again: {begun - followers[1].began:.2f} s until its first picture, in step {caught - begun:.2f} s after that")


def test_killed_leader(stage, leader, followers):
    """They keep their pictures, say so, and find it again."""
    stage.keys(leader, "space")
    still(leader)
    before = [f.pixels() for f in followers]
    leader.kill()
    wait_for("titles that tell", lambda: all(f.alive() and "(no leader)" in f.title() for f in followers))
    assert all("the leader is lost" in f.said() for f in followers)
    assert [f.pixels() for f in followers] == before, "a picture has gone with the leader"
    leader = stage.lead("--patience", "60000")
    wait_for("followers of the new leader", lambda: all(f.alive() for f in followers) and in_step(leader) == 3)
    assert all("(no leader)" not in f.title() for f in followers)
    return leader


def test_who_is_refused(stage):
    address = f"127.0.0.1:{stage.port}"
    other = write(os.path.join(stage.folder, "other_secret"), "another secret, as long as it needs to be")
    os.chmod(other, 0o600)
    short = write(os.path.join(stage.folder, "short_secret"), "short")
    scene = write(os.path.join(stage.folder, "other.toml"), stage.text.replace('[[imagery]]\nsource = "i.tdb"\n', ""))
    assert "another secret" in stage.wrong(stage.scene, "--follow", address, "--secret-file", other, status=1)
    assert "asks for a secret" in stage.wrong(stage.scene, "--follow", address, status=1)
    told = stage.wrong(scene, "--follow", address, "--secret-file", stage.secret, status=1)
    assert "another scene" in told and "i.tdb" in told, told
    assert "16 to 4096 bytes" in stage.wrong(stage.scene, "--follow", address, "--secret-file", short, status=1)
    assert "has no channel 'up'" in stage.wrong(stage.scene, "--follow", address, "--frustum", stage.channels, "--channel", "up", status=1)
    assert "secret has to guard it" in stage.wrong(stage.scene, "--lead", "0.0.0.0:0", status=1)
    assert "another program has this port" in stage.wrong(stage.scene, "--lead", str(stage.port), status=1)
    assert "--camera is the leader's to say" in stage.wrong(stage.scene, "--follow", address, "--camera", CAMERA, status=2)
    assert "HOST:PORT" in stage.wrong(stage.scene, "--follow", "nonsense", status=2)


def run_all(program, source, folder):
    frames = 1000 if "--whole" in sys.argv else 100
    stage = Stage(program, source, folder)
    try:
        leader = stage.lead("--patience", "60000")
        followers = [stage.follow(name) for name in CHANNELS]
        test_join_at_rest(stage, leader, followers)
        test_every_frame(stage, leader, followers, frames)
        test_join_in_motion(stage, leader, followers)
        test_killed_follower(stage, leader, followers)
        leader = test_killed_leader(stage, leader, followers)
        test_who_is_refused(stage)
    finally:
        stage.end()


if __name__ == "__main__":
    sys.exit(main_of(run_all))
