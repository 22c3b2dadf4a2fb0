#!/usr/bin/env python3
"""The subcommands that make pictures, driven as a script would: render, fly and bench.

    pictures_test.py PROGRAM SOURCE_DIR WORK_DIR

Exit status 77 (skipped) where there is no OpenGL. Pictures and depths are read by this file itself.
"""
import csv
import json
import math
import pathlib
import re
import shutil
import signal
import sqlite3
import struct
import subprocess
import sys
import time
import zlib

SKIPPED = 77
MARS_RADIUS_M = 3396190.0
SIZE = (96, 64)
STATS = ["frame_ms", "update_ms", "tiles_drawn", "triangles", "draw_calls", "max_screen_error_px", "capped_by_budget", "complete",
         "tiles_wanted", "gpu_bytes", "cpu_cache_bytes", "requests", "failed_requests"]
PATH = "seconds,lat,lon,height_m,heading,pitch,roll\n0,0,170,9000000,0,-90,0\n0.5,20,-170,3000000,30,-60,0\n"


def png_pixels(path):
    """(width, height, rows of (r, g, b)) of an 8-bit RGB or RGBA PNG that is not interlaced."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is no PNG"
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        assert zlib.crc32(kind + body) == struct.unpack(">I", data[at + 8 + length:at + 12 + length])[0], "a chunk's checksum"
        if kind == b"IHDR":
            width, height, depth, colour, _, _, interlace = struct.unpack(">IIBBBBB", body)
        if kind == b"IDAT":
            packed += body
        at += 12 + length
    assert (depth, interlace) == (8, 0) and colour in (2, 6), f"{path}: depth {depth}, colour type {colour}"
    channels = 3 if colour == 2 else 4
    flat, previous, rows = zlib.decompress(packed), bytes(width * channels), []
    for row in range(height):
        start = row * (width * channels + 1)
        line = unfiltered(flat[start], bytearray(flat[start + 1:start + 1 + width * channels]), previous, channels)
        rows.append([tuple(line[i:i + 3]) for i in range(0, len(line), channels)])
        previous = line
    return width, height, rows


def unfiltered(kind, line, above, channels):
    """One PNG row without its filter (PNG specification, 9.2)."""
    for i, value in enumerate(line):
        left = line[i - channels] if i >= channels else 0
        corner = above[i - channels] if i >= channels else 0
        if kind == 4:
            estimate = left + above[i] - corner
            guess = min((left, above[i], corner), key=lambda v: abs(estimate - v))
        else:
            guess = (0, left, above[i], (left + above[i]) // 2)[kind]
        line[i] = (value + guess) & 255
    return line


def tiff_floats(path):
    """(width, height, values by row) of a one-band little-endian float32 TIFF in strips, plain or deflated."""
    data = path.read_bytes()
    assert data[:4] == b"II*\0", f"{path} is no little-endian TIFF"
    at = struct.unpack("<I", data[4:8])[0]
    tags = {}
    for i in range(struct.unpack("<H", data[at:at + 2])[0]):
        tag, kind, count, value = struct.unpack("<HHI4s", data[at + 2 + 12 * i:at + 14 + 12 * i])
        size, letter = {3: (2, "H"), 4: (4, "I")}.get(kind, (0, ""))
        if not size:
            continue
        where = value if size * count <= 4 else data[struct.unpack("<I", value)[0]:]
        tags[tag] = struct.unpack(f"<{count}{letter}", where[:size * count])
    width, height, rows_a_strip = tags[256][0], tags[257][0], tags.get(278, tags[257])[0]
    assert (tags[258], tags.get(277, (1,)), tags[339]) == ((32,), (1,), (3,)), f"{path} holds no single float32 band"
    compression, predictor = tags.get(259, (1,))[0], tags.get(317, (1,))[0]
    assert compression in (1, 8) and predictor in (1, 3), f"{path}: compression {compression}, predictor {predictor}"
    rows = []
    for offset, count in zip(tags[273], tags[279]):
        strip = data[offset:offset + count]
        strip = zlib.decompress(strip) if compression == 8 else strip
        for row in range(min(rows_a_strip, height - len(rows))):
            line = strip[4 * width * row:4 * width * (row + 1)]
            rows.append(struct.unpack(f"<{width}f", unpredicted(line, width) if predictor == 3 else line))
    return width, height, rows


def unpredicted(line, width):
    """One row without TIFF's floating-point predictor: bytes summed, then planes from the highest byte interleaved."""
    total, sums = 0, bytearray()
    for byte in line:
        total = (total + byte) & 255
        sums.append(total)
    return bytes(sums[(3 - i % 4) * width + i // 4] for i in range(4 * width))


def catches(pid, number):
    """Whether the process has a handler of its own for the signal."""
    try:
        status = pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False
    caught = re.search(r"^SigCgt:\s*([0-9a-f]+)$", status, re.MULTILINE)
    return bool(caught) and bool(int(caught[1], 16) >> (number - 1) & 1)


def stopped(number, *words):
    """What a program does that gets the signal as soon as it is ready for it."""
    for inherited in (signal.SIGINT, signal.SIGHUP):  # what runs behind a shell may ignore them, and so would the program
        signal.signal(inherited, signal.SIG_DFL)
    process = subprocess.Popen(list(map(str, words)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while process.poll() is None and not catches(process.pid, number):
        time.sleep(0.001)
    process.send_signal(number)
    out, err = process.communicate(timeout=300)
    return subprocess.CompletedProcess(words, process.returncode, out, err)


class Pictures:
    def __init__(self, program, source, work):
        self.program = program
        self.work = work
        self.database = work / "mars.tdb"
        self.source = source
        self.path = work / "path.csv"
        self.path.write_text(PATH)

    def run(self, *words, status=0):
        done = subprocess.run([self.program, *map(str, words)], capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == status, f"{words}: status {done.returncode}, not {status}: {done.stderr[-1000:]}"
        return done

    def render(self, *words, camera="0,0,9000000,0,-90,0", status=0, scene=None):
        return self.run("render", scene or self.database, "--camera", camera, *words, status=status)

    def build(self):
        self.run("build", self.database, self.source / "data/mars/mola_dem_4ppd.tif", "--kind", "elevation", "--max-level", 1)

    def has_opengl(self):
        done = subprocess.run([self.program, "render", self.database, "--camera", "0,0,9e6", "--size", "8x8", "-o",
                               self.work / "first.png"], capture_output=True, text=True, timeout=300, check=False)
        if done.returncode == 1 and "OpenGL" in done.stderr:
            print(done.stderr.strip())
            return False
        return True

    def test_picture_and_background(self):
        out = self.work / "mars.png"
        self.render("--size", "96x64", "-o", out, "--background", "12A0F0")
        width, height, rows = png_pixels(out)
        assert (width, height) == SIZE
        for corner in (rows[0][0], rows[0][-1], rows[-1][0], rows[-1][-1]):
            assert corner == (0x12, 0xA0, 0xF0), corner
        assert rows[32][48] != (0x12, 0xA0, 0xF0), "no planet in the middle"
        assert not list(self.work.glob("*.part")), "a temporary file is left"

    def test_same_bytes_each_time(self):
        for name in ("one.png", "two.png"):
            self.render("--size", "96x64", "-o", self.work / name)
        assert (self.work / "one.png").read_bytes() == (self.work / "two.png").read_bytes()

    def test_depth(self):
        depth, stats = self.work / "depth.tif", self.work / "depth.json"
        self.render("--size", "97x65", "-o", self.work / "depth.png", "--depth", depth, "--stats", stats, "--fov", 60)
        width, height, rows = tiff_floats(depth)
        assert (width, height) == (97, 65)
        assert math.isnan(rows[0][0]) and math.isnan(rows[-1][-1])
        ground = float(self.run_query("0 0\n"))
        miss = abs(rows[32][48] - (9e6 - ground))
        # The tolerance of one pixel, seen from here.
        pixel_m = 9e6 * 2 * math.tan(math.radians(30)) / 65
        assert miss < pixel_m * json.loads(stats.read_text())["max_screen_error_px"] + 1.0, miss
        # Beyond the horizon's distance nothing can be seen.
        horizon = math.sqrt((MARS_RADIUS_M + 9e6) ** 2 - (MARS_RADIUS_M - 9e3) ** 2) + 4e5
        assert all(math.isnan(d) or 8.9e6 < d < horizon for row in rows for d in row)

    def run_query(self, places):
        done = subprocess.run([self.program, "query", self.database], input=places, capture_output=True, text=True,
                              timeout=300, check=True)
        return done.stdout.split()[0]

    def test_stats(self):
        stats = self.work / "stats.json"
        self.render("--size", "96x64", "-o", self.work / "stats.png", "--stats", stats)
        figures = json.loads(stats.read_text())
        missing = [name for name in STATS if name not in figures]
        assert not missing, f"{missing} not in {figures}"
        assert figures["complete"] is True and figures["tiles_wanted"] == 0 and figures["failed_requests"] == 0
        assert figures["tiles_drawn"] > 0 and figures["triangles"] > 0 and 1 <= figures["draw_calls"] <= 4
        assert 0 <= figures["max_screen_error_px"] <= 1.0 and figures["frame_ms"] > 0
        assert sum(figures["tiles_a_level"]) == figures["tiles_drawn"]
        assert figures["capped_by_budget"] is False

    def test_debug_views(self):
        """Each changes the picture and neither its depth nor its tiles; the same picture comes back without them."""
        depth, stats, drawn = self.work / "debug.tif", self.work / "debug.json", []
        for views in ((), ("wireframe",), ("levels",), ("error",), ("boxes",), ("levels", "wireframe", "error", "boxes")):
            out = self.work / f"debug{len(drawn)}.png"
            asked = ("--debug", ",".join(views)) if views else ()
            self.render("--size", "96x64", "-o", out, "--depth", depth, "--stats", stats, *asked)
            figures = json.loads(stats.read_text())
            drawn.append((png_pixels(out)[2], depth.read_bytes(), figures["tiles_a_level"], figures["triangles"]))
            passes = len(views) - (1 if {"levels", "error"} <= set(views) else 0)
            assert figures["draw_calls"] == 1 + passes, (views, figures["draw_calls"])
        for i, one in enumerate(drawn):
            assert one[1:] == drawn[0][1:], f"depth, tiles or triangles of view {i}"
            assert all(one[0] != other[0] for other in drawn[:i]), f"view {i} is as one before"

    def test_frozen_cut(self):
        """The tiles of one camera, seen from another."""
        def tiles(*words, **more):
            stats = self.work / "frozen.json"
            self.render("--size", "96x64", "-o", self.work / "frozen.png", "--stats", stats, *words, **more)
            figures = json.loads(stats.read_text())
            return figures["tiles_a_level"], figures["triangles"], png_pixels(self.work / "frozen.png")[2]
        near, far = "10,20,900000,30,-60,0", "0,10,9000000,0,-90,0"
        of_near, of_far, frozen = tiles(camera=near), tiles(camera=far), tiles("--freeze-at", near, camera=far)
        assert of_near[:2] != of_far[:2], "the cameras do not differ enough for this test"
        assert frozen[:2] == of_near[:2], f"not the tiles of the other camera: {frozen[:2]}, {of_near[:2]}"
        assert frozen[2] not in (of_near[2], of_far[2])
        assert any((255, 255, 255) in row for row in frozen[2]), "no line of the pyramid"

    def test_debug_views_of_a_flight(self):
        for name, words in (("plain", ()), ("tinted", ("--debug", "levels"))):
            self.run("fly", self.database, "--path", self.path, "--fps", 2, "--size", "32x24", "-o", self.work / name, *words)
        assert (self.work / "plain/frame_00001.png").read_bytes() != (self.work / "tinted/frame_00001.png").read_bytes()

    def test_wrong_debug_views_are_told_with_the_right_ones(self):
        out = self.work / "never.png"
        for views in ("tiles", "levels,", "", "levels;error", "Levels"):
            done = self.render("-o", out, "--debug", views, status=2)
            assert all(view in done.stderr for view in ("wireframe", "levels", "error", "boxes")), done.stderr
        self.render("-o", out, "--freeze-at", "1,2", status=2)
        assert not out.exists()

    def test_wrong_use(self):
        out = self.work / "never.png"
        wrong = [("render", self.database, "-o", out), ("render", "--camera", "0,0,1e6", "-o", out),
                 ("render", self.database, "--camera", "0,0,1e6"), ("fly", self.database, "-o", out), ("bench", self.database),
                 ("bench", self.database, "--path", self.work / "absent.csv"), ("view",), ("view", self.database, "--fov", "nan"),
                 ("view", self.database, "--size", "9"), ("view", self.database, "--camera", "x")]
        for option, value in (("--camera", "1,2"), ("--camera", "91,0,1e6"), ("--camera", "0,0,1e6,x"), ("--camera", "nan,0,1e6"),
                              ("--size", "0x9"), ("--size", "9"), ("--size", "9x9x9"), ("--size", "99999x9"), ("--fov", "0"),
                              ("--fov", "nan"), ("--fov", "180"), ("--tolerance", "-1"), ("--tolerance", "nan"),
                              ("--background", "12345"), ("--background", "red"), ("--timeout", "-1"), ("--nonsense", "1")):
            camera = () if option == "--camera" else ("--camera", "0,0,1e6")
            wrong.append(("render", self.database, *camera, option, value, "-o", out))
        for words in wrong:
            done = self.run(*words, status=2)
            assert done.stderr.strip() and not done.stdout.strip(), f"{words}: no message on stderr"
        assert not out.exists()

    def test_names_of_pictures(self):
        """A wrong name is refused before anything is drawn; two outputs are never one file, however they are written."""
        here = ("render", self.database, "--camera", "0,0,9e6", "--size", "8x8")
        for name in ("never.jpg", "never", "never.png.tif", "."):
            done = self.run(*here, "-o", self.work / name, status=2)
            assert ".png" in done.stderr, done.stderr
        self.run(*here, "-o", self.work / "LOUD.PNG")
        self.run(*here, "-o", "/dev/null")
        (self.work / "link").symlink_to(self.work)
        out, same = self.work / "same.png", [self.work / "same.png", f"{self.work}/./absent/../same.png", self.work / "link/same.png"]
        for other in same:
            for words in (("-o", out, "--depth", other), ("-o", out, "--stats", other),
                          ("-o", self.work / "other.png", "--depth", out, "--stats", other)):
                done = self.run(*here, *words, status=2)
                assert "same file" in done.stderr, done.stderr
        self.run("render", self.database, "--camera", "0,0,9e6", "-o", self.work / "o.png", "--stats", self.database, status=2)
        assert not out.exists() and not (self.work / "other.png").exists()

    def test_names_of_flights(self):
        fly = ("fly", self.database, "--path", self.path, "--fps", 4, "--size", "8x8", "-o")
        for name in ("f.avi", "f.MOV", "f.png"):
            done = self.run(*fly, self.work / name, status=2)
            assert ".mp4" in done.stderr and not (self.work / name).exists(), done.stderr
        folder = self.work / "films.mov"  # a folder that is there may have any name
        folder.mkdir()
        self.run(*fly, folder)
        assert len(list(folder.iterdir())) == 3
        (self.work / "folder.mp4").mkdir()
        assert "is a folder" in self.run(*fly, self.work / "folder.mp4", status=1).stderr

    def test_frames_of_a_longer_flight_do_not_mix_with_new_ones(self):
        folder = self.work / "refilled"
        fly = ("fly", self.database, "--path", self.path, "--size", "8x8", "-o", folder, "--fps")
        self.run(*fly, 8)
        before = {p.name: p.read_bytes() for p in folder.iterdir()}
        done = self.run(*fly, 4, status=1)
        assert "frame_00004.png" in done.stderr and "frame_00002.png" in done.stderr, done.stderr
        assert {p.name: p.read_bytes() for p in folder.iterdir()} == before, "something was written or removed"
        (folder / "frame_00003.png").unlink()
        (folder / "frame_00004.png").rename(folder / "frame_4.png")  # no name that fly gives
        self.run(*fly, 4)

    def test_an_eye_below_the_ground_is_told(self):
        out = self.work / "below.png"
        ground = float(self.run_query("0 0\n"))
        above = self.render("--size", "32x24", "-o", out, camera=f"0,0,{ground + 50},0,-90,0")
        assert "below the ground" not in above.stderr, above.stderr
        for depth in (300.0, 50000.0):
            done = self.render("--size", "32x24", "-o", out, camera=f"0,0,{ground - depth},0,-90,0")
            told = re.search(r"the eye is ([0-9.]+) m below the ground", done.stderr)
            assert told, done.stderr
            # The loaded ground may be coarser than the finest.
            assert abs(float(told[1]) - depth) < 250.0, done.stderr
        path = self.work / "dive.csv"
        path.write_text("seconds,lat,lon,height_m,heading,pitch,roll\n"
                        f"0,0,0,{ground + 5000},0,-45,0\n1,0,0,{ground - 5000},0,-45,0\n")
        done = self.run("fly", self.database, "--path", path, "--fps", 4, "--size", "16x16", "-o", self.work / "dive")
        assert re.search(r"in [1-4] of 5 frames, from number [1-4] on, the eye is below the ground", done.stderr), done.stderr

    def test_a_spent_budget_is_told(self):
        """Of a picture, and once of a flight."""
        low = "0,0,30000,0,-30,0"
        stats = self.work / "capped.json"
        done = self.render("--max-tiles", "16", "-o", self.work / "capped.png", "--stats", stats, "--size", "96x64", camera=low)
        off = re.search(r"render: warning: the 16 tiles \(--max-tiles\).* up to ([0-9.]+) pixels off", done.stderr)
        assert off and float(off[1]) > 1.0, done.stderr
        figures = json.loads(stats.read_text())
        assert figures["capped_by_budget"] is True and not figures["complete"], figures
        assert abs(figures["max_screen_error_px"] - float(off[1])) < 0.1, figures
        path = self.work / "descent.csv"
        path.write_text(f"seconds,lat,lon,height_m,heading,pitch,roll\n0,0,0,15000000,0,-90,0\n1,{low}\n")
        flight = ("fly", self.database, "--path", path, "--fps", 2, "-o", self.work / "descent", "--size", "96x64")
        done = self.run(*flight, "--max-tiles", "16")
        assert len(re.findall("warning", done.stderr)) == 1, done.stderr
        told = re.search(r"fly: warning: in [12] of 3 frames, the 16 tiles .* up to ([0-9.]+) pixels off", done.stderr)
        assert told and float(told[1]) >= float(off[1]) - 0.1, done.stderr
        assert "warning" not in self.run(*flight).stderr

    def test_frames_of_a_flight_are_whole_however_fast_it_goes(self):
        """Each frame is what render makes of its camera."""
        path = self.work / "jump.csv"
        cameras = ("20,10,15000000,0,-90,0", "27,86,60000,20,-30,0", "-10,-70,300000,0,-60,0")
        path.write_text("seconds,lat,lon,height_m,heading,pitch,roll\n" +
                        "".join(f"{i},{camera}\n" for i, camera in enumerate(cameras)))
        self.run("fly", self.database, "--path", path, "--fps", 1, "--size", "160x120", "-o", self.work / "jump")
        for i, camera in enumerate(cameras):
            out = self.work / f"jump{i}.png"
            self.run("render", self.database, "--camera", camera, "--size", "160x120", "-o", out)
            assert out.read_bytes() == (self.work / f"jump/frame_0000{i}.png").read_bytes(), f"frame {i} is not whole"

    def test_sigterm_stops_as_ctrl_c_does(self):
        path = self.work / "long.csv"
        path.write_text("seconds,lat,lon,height_m,heading,pitch,roll\n0,0,0,4e6,0,-90,0\n1000,0,90,4e6,0,-90,0\n")
        fly = ("fly", self.database, "--path", path, "--fps", 30, "--size", "64x48", "-o")
        bench = ("bench", self.database, "--path", path, "--size", "64x48")
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            done = stopped(number, self.program, *fly, self.work / "stopped")
            assert done.returncode == 1 and "stopped after" in done.stderr, done
            done = stopped(number, self.program, *bench)
            assert done.returncode == 0 and "stopped after" in done.stderr and "frame_ms_p50" in done.stdout, done
            assert re.search(r"^stopped +true$", done.stdout, re.MULTILINE), done.stdout
        done = stopped(signal.SIGTERM, self.program, *fly, self.work / "stopped.mp4")
        assert done.returncode == 1, done
        assert not list(self.work.glob("stopped.mp4*")), "a temporary file is left"
        fine = self.work / "fine.tdb"
        self.run("build", fine, self.source / "data/mars/mola_dem_4ppd.tif", "--kind", "elevation")
        out = self.work / "stopped.png"
        for _ in range(10):  # a picture that is whole first is no fault
            done = stopped(signal.SIGTERM, self.program, "render", fine, "--camera", "0,0,4e5", "--tolerance", "0.05", "-o", out)
            if done.returncode == 1:
                break
            out.unlink(missing_ok=True)
        assert done.returncode == 1 and "stopped" in done.stderr and not out.exists(), done

    def test_failed_runs(self):
        out = self.work / "never.png"
        nowhere = self.work / "absent" / "x"
        nothing = self.work / "absent" / "x.png"
        folder = self.work / "a_folder.png"
        folder.mkdir()
        (self.work / "broken.toml").write_text('body = "mars"\n[[elevation]]\nsource = "absent.tdb"\n')
        (self.work / "broken.csv").write_text("seconds,lat\n0,0\n")
        (self.work / "empty.csv").write_text("")
        fly = ("fly", self.database, "--fps", 4, "--size", "32x24")
        failures = [
            (("render", self.work / "absent.toml", "--camera", "0,0,1e6", "-o", out), "absent.toml"),
            (("render", self.work / "absent.tdb", "--camera", "0,0,1e6", "-o", out), "absent.tdb"),
            (("render", self.work / "broken.toml", "--camera", "0,0,1e6", "-o", out), "absent.tdb"),
            (("render", self.path, "--camera", "0,0,1e6", "-o", out), "path.csv"),
            (("render", self.database, "--camera", "0,0,1e6", "-o", nothing), f" {nothing}: "),
            (("render", self.database, "--camera", "0,0,1e6", "-o", out, "--depth", nowhere), "absent"),
            # Known before the scene is opened, which is not there either.
            (("render", self.work / "none.toml", "--camera", "0,0,1e6", "-o", folder), "is a folder; give the name of a file in it"),
            (("bench", self.work / "none.toml", "--path", self.path, "--plot", nowhere.with_suffix(".svg")), "mkdir -p"),
            (("render", self.database, "--camera", "0,0,1e6", "-o", out, "--stats", nowhere), "absent"),
            ((*fly, "--path", self.work / "broken.csv", "-o", self.work / "never"), "broken.csv"),
            ((*fly, "--path", self.work / "empty.csv", "-o", self.work / "never"), "empty.csv"),
            ((*fly, "--path", self.path, "-o", self.path), "is a file"),
            ((*fly, "--path", self.path, "-o", nowhere / "f.mp4"), "its folder does not exist"),
            (("bench", self.database, "--path", self.path, "--size", "32x24", "--stats", nowhere), "absent"),
        ]
        for words, named in failures:
            done = self.run(*words, status=1)
            assert named in done.stderr, f"{words}: the message does not name {named}: {done.stderr}"
        assert not list(self.work.glob("*.part")), "a temporary file is left"

    def test_a_missing_root_is_a_failure(self):
        damaged = self.work / "rootless.tdb"
        shutil.copyfile(self.database, damaged)
        database = sqlite3.connect(damaged)
        gone = database.execute("DELETE FROM tiles WHERE level = 0").rowcount
        database.commit()
        database.close()
        assert gone == 6, gone
        out, stats = self.work / "rootless.png", self.work / "rootless.json"
        done = self.render("--size", "32x24", "-o", out, "--stats", stats, scene=damaged, status=1)
        assert "rootless.tdb: tile 0/" in done.stderr and "is missing" in done.stderr, done.stderr
        figures = json.loads(stats.read_text())
        assert figures["complete"] is False and figures["failed_requests"] == 6, figures
        done = subprocess.run([self.program, "query", damaged], input="0 0\n", capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == 1 and done.stdout == "error\n" and "is missing" in done.stderr, done

    def test_timeout(self):
        out = self.work / "hurried.png"
        done = self.render("--size", "96x64", "-o", out, "--timeout", 0, status=1)
        assert "hurried.png" in done.stderr and "timeout" in done.stderr, done.stderr
        assert png_pixels(out)[:2] == SIZE

    def test_flight_into_a_folder(self):
        folders = [self.work / "flight_a", self.work / "flight_b"]
        for folder in folders:
            self.run("fly", self.database, "--path", self.path, "--fps", 8, "--size", "48x32", "-o", folder)
        names = sorted(p.name for p in folders[0].iterdir())
        assert names == [f"frame_{i:05}.png" for i in range(5)], names  # 0, 1/8 ... 1/2 s
        frames = [(folders[0] / name).read_bytes() for name in names]
        assert frames == [(folders[1] / name).read_bytes() for name in names]
        assert len(set(frames)) == len(frames), "the camera does not move"
        assert png_pixels(folders[0] / names[0])[:2] == (48, 32)

    def test_flight_into_a_video(self):
        if not shutil.which("ffmpeg"):
            print("  no ffmpeg: not tested")
            return
        for name in ("flight.mp4", "it's : odd.mp4"):
            out = self.work / name
            odd = self.run("fly", self.database, "--path", self.path, "--fps", 8, "--size", "47x31", "-o", out)
            assert "47x31" in odd.stderr and "48x32" in odd.stderr, odd.stderr
            assert out.read_bytes()[4:8] == b"ftyp", f"{name} is no MP4"
        even = self.run("fly", self.database, "--path", self.path, "--fps", 8, "--size", "48x32", "-o", self.work / "LOUD.MP4")
        assert not even.stderr and (self.work / "LOUD.MP4").read_bytes()[4:8] == b"ftyp", even.stderr
        self.run("fly", self.database, "--path", self.path, "--fps", 8, "--size", "48x32", "-o", self.work / "absent/f.mp4", status=1)
        assert not list(self.work.glob("*.part")), "a temporary file is left"

    def test_bench(self):
        table = self.work / "frames.csv"
        words = ("bench", self.database, "--path", self.path, "--size", "48x32")
        plain = self.run(*words, "--stats", table).stdout
        for percentile in ("p50", "p90", "p99", "max"):
            assert re.search(rf"^frame_ms_{percentile} +\d+\.\d+$", plain, re.MULTILINE), plain
        rows = list(csv.DictReader(table.read_text().splitlines()))
        missing = [name for name in ["time_s", "level_0", "level_1", *STATS] if name not in rows[0]]
        assert not missing, f"{missing} not in frames.csv"
        assert len(rows) == int(re.search(r"^frames +(\d+)$", plain, re.MULTILINE)[1])
        times = [float(row["time_s"]) for row in rows]
        assert times[0] == 0.0 and times == sorted(times) and times[-1] <= 0.5, times
        assert all(sum(int(v) for k, v in row.items() if k.startswith("level_")) == int(row["tiles_drawn"]) for row in rows)
        summary = json.loads(self.run(*words, "--json").stdout)
        assert summary["frames"] > 0 and summary["failed_requests"] == 0
        assert summary["stopped"] is False and 0 <= summary["played_s"] <= summary["path_s"] == 0.5, summary
        assert summary["frame_ms_p50"] <= summary["frame_ms_p90"] <= summary["frame_ms_p99"] <= summary["frame_ms_max"]


def main():
    program, source, work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    pictures = Pictures(program, source, work)
    pictures.build()
    if not pictures.has_opengl():
        return SKIPPED
    failed = 0
    for name in (n for n in dir(pictures) if n.startswith("test_")):
        try:
            getattr(pictures, name)()
            print(f"ok    {name}")
        except AssertionError as error:
            failed += 1
            print(f"FAULT {name}: {error}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
