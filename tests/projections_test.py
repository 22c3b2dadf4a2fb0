#!/usr/bin/env python3
"""Projections, channels, pictures in pieces and films, through the program.

    projections_test.py PROGRAM SOURCE_DIR WORK_DIR

Exit status 77 (skipped) where there is no OpenGL.
"""
import os
import pathlib
import resource
import shutil
import subprocess
import sys

from pictures_test import png_pixels

SKIPPED = 77
CAMERA = "-7,-90,300000,40,-20,0"
PATH = "seconds,lat,lon,height_m,heading,pitch,roll\n0,-7,-90,300000,0,-20,0\n0.5,-6,-91,250000,30,-30,0\n"
# Two halves of one picture, and a third to the side that makes the sides of all differ.
CHANNELS = """
[[channel]]
name = "both"
left_degrees = -35
right_degrees = 35
bottom_degrees = -30
top_degrees = 10
[[channel]]
name = "left"
left_degrees = -35
right_degrees = 0
bottom_degrees = -30
top_degrees = 10
[[channel]]
name = "right"
left_degrees = 0
right_degrees = 35
bottom_degrees = -30
top_degrees = 10
"""


class Projections:
    def __init__(self, program, work):
        self.program, self.work, self.scene = program, work, work / "mars.tdb"

    def run(self, *words, status=0, **how):
        done = subprocess.run([self.program, *map(str, words)], capture_output=True, text=True, timeout=300, check=False, **how)
        assert done.returncode == status, f"{words}: {done.returncode}\n{done.stderr}"
        return done

    def picture(self, *options, camera=CAMERA):
        out = self.work / "out.png"
        self.run("render", self.scene, "--camera", camera, "-o", out, *options)
        return png_pixels(out)

    @staticmethod
    def differences(a, b):
        """The largest step of 255 for each pixel of two lists of rows."""
        assert len(a) == len(b) and len(a[0]) == len(b[0])
        return sorted(max(abs(x - y) for x, y in zip(p, q)) for left, right in zip(a, b) for p, q in zip(left, right))

    def same(self, a, b):
        steps = self.differences(a, b)
        assert steps[int(0.99 * len(steps))] <= 1, f"one in a hundred is off by {steps[int(0.99 * len(steps))]}"
        assert steps[int(0.999 * len(steps))] <= 8, f"one in a thousand is off by {steps[int(0.999 * len(steps))]}"

    def test_each_has_its_size(self):
        for name, size in (("fisheye", (96, 96)), ("equirectangular", (96, 48)), ("cube", (96, 72)), ("stereo", (96, 48))):
            tilt = ("--tilt", 60) if name == "fisheye" else ()
            width, height, rows = self.picture("--projection", name, "--size", f"{size[0]}x{size[1]}", *tilt)
            assert (width, height) == size
            assert len({pixel for row in rows for pixel in row}) > 20, f"{name} shows nothing"

    def test_pieces_make_the_picture(self):
        for options in (("--size", "150x100"), ("--projection", "equirectangular", "--size", "128x64"),
                        ("--projection", "cube", "--size", "128x96"), ("--projection", "stereo", "--size", "128x64"),
                        ("--projection", "fisheye", "--tilt", "70", "--aperture", "220", "--size", "100x100")):
            self.same(self.picture(*options)[2], self.picture(*options, "--piece", 37)[2])

    def test_a_large_picture_in_pieces_shrinks_to_the_small_one(self):
        """Means of 4 x 4 pixels, of ground at the same error in angle, are those of one where the ground is smooth."""
        large = self.picture("--size", "384x256", "--piece", 100, "--tolerance", 4)[2]
        small = self.picture("--size", "96x64", "--tolerance", 1)[2]
        shrunk = [[tuple(sum(large[4 * y + j][4 * x + i][c] for i in range(4) for j in range(4)) // 16 for c in range(3))
                   for x in range(96)] for y in range(64)]
        steps = self.differences(small, shrunk)
        assert steps[len(steps) // 2] <= 4 and sum(steps) / len(steps) < 8, (steps[len(steps) // 2], sum(steps) / len(steps))

    def test_channels_join(self):
        file = self.work / "channels.toml"
        file.write_text(CHANNELS)
        left, right = (self.picture("--frustum", file, "--channel", name, "--size", "100x80")[2] for name in ("left", "right"))
        both = self.picture("--frustum", file, "--channel", "both", "--size", "200x80")[2]
        # Chosen for another size of a pixel, so not to the last bit.
        steps = self.differences(both, [a + b for a, b in zip(left, right)])
        assert steps[int(0.97 * len(steps))] <= 12, steps[int(0.97 * len(steps))]
        told = self.run("render", self.scene, "--camera", CAMERA, "--frustum", file, "--channel", "middle", "-o", self.work / "x.png", status=1)
        assert "no channel 'middle'" in told.stderr and "both, left, right" in told.stderr
        told = self.run("render", self.scene, "--camera", CAMERA, "--frustum", file, "-o", self.work / "x.png", status=1)
        assert "--channel" in told.stderr

    def test_wrong_use(self):
        for options, words in ((("--aperture", 180), "--projection fisheye"), (("--tilt", 30, "--projection", "cube"), "--projection fisheye"),
                               (("--eye-separation", 3), "--projection stereo"),
                               (("--projection", "equirectangular", "--size", "100x60"), "120x60"),
                               (("--projection", "cube", "--size", "100x60"), "100x75"), (("--projection", "dome"), "dome"),
                               (("--projection", "fisheye", "--fov", 30), "--aperture"), (("--projection", "fisheye", "--aperture", 361), "360"),
                               (("--projection", "fisheye", "--debug", "levels"), "--debug"), (("--size", "70000x10"), "65536")):
            told = self.run("render", self.scene, "--camera", CAMERA, "-o", self.work / "x.png", *options, status=2)
            assert words in told.stderr, (options, told.stderr)
        assert not (self.work / "x.png").exists()

    def test_a_film_is_the_same_twice(self):
        path = self.work / "path.csv"
        path.write_text(PATH)
        fly = ["fly", self.scene, "--path", path, "--fps", 8]
        if not shutil.which("ffmpeg"):
            print("  no ffmpeg: not tested")
            return
        for options in (["--size", "64x48"], ["--projection", "fisheye", "--tilt", 80, "--size", "64x64"]):
            films = []
            for name in ("one.mp4", "two.mp4"):
                self.run(*fly, *options, "-o", self.work / name)
                films.append((self.work / name).read_bytes())
            assert films[0] == films[1] and films[0][4:8] == b"ftyp"
        tools = self.work / "tools"
        tools.mkdir(exist_ok=True)
        (tools / "sh").unlink(missing_ok=True)
        (tools / "sh").symlink_to("/bin/sh")
        lacking = self.run(*fly, "--size", "64x48", "-o", self.work / "none.mp4", status=1, env={**os.environ, "PATH": str(tools)})
        assert "ffmpeg" in lacking.stderr and "install" in lacking.stderr, lacking.stderr
        full = self.run(*fly, "--size", "64x48", "-o", self.work / "full.mp4", status=1,
                        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (700, 700)))
        assert "ffmpeg" in full.stderr, full.stderr
        left = [p.name for p in self.work.iterdir() if p.name.startswith(("none", "full")) or p.suffix == ".part"]
        assert not left, left


def main():
    program, source, work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    tests = Projections(program, work)
    tests.run("build", tests.scene, source / "data/mars/mola_dem_4ppd.tif", "--kind", "elevation", "--body", "mars", "--max-level", 3)
    probe = subprocess.run([program, "render", tests.scene, "--camera", CAMERA, "--size", "8x8", "-o", work / "probe.png"],
                           capture_output=True, text=True, check=False)
    if "EGL" in probe.stderr:
        print(probe.stderr)
        return SKIPPED
    for name in [n for n in dir(tests) if n.startswith("test_")]:
        print(name, flush=True)
        getattr(tests, name)()
    return 0


if __name__ == "__main__":
    sys.exit(main())
