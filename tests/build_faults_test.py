#!/usr/bin/env python3
"""Builds that are killed, run out of disk or lose their source: a clear message, no damage, the finished file identical.

    tests/build_faults_test.py PROGRAM DATA_FOLDER WORK_FOLDER [--whole] [--seed S]

Prints what was done. --whole: fifty SIGKILLs at random moments over five ways to build (elevation, imagery, --append, --share,
--part), full disks and sources at a dozen moments each; without, a sample of seconds. A disk is made full twice: as a small
tmpfs in a name space of the test's own, where the system lets users have one, and by a limit of a file's size, anywhere.
"""
import argparse
import filecmp
import os
import pathlib
import random
import resource
import shutil
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent


def fail(message):
    sys.exit(f"FAILED: {message}")


def clean(output):
    for path in output.parent.glob(output.name + "*"):
        shutil.rmtree(path) if path.is_dir() else path.unlink()


def run(words, **more):
    return subprocess.run(words, capture_output=True, text=True, check=False, **more)


def run_sound(words, **more):
    done = run(words, **more)
    if done.returncode != 0:
        fail(f"{' '.join(map(str, words))}: {done.stderr}")


def expect_same(whole, output, what):
    if not filecmp.cmp(whole, output, shallow=False):
        fail(f"{what}: {output} differs from {whole}")
    if left := [p.name for p in output.parent.glob(output.name + "?*")]:
        fail(f"{what}: left behind: {left}")


def kills(arguments, seed):
    """Over the ways to build; each in its own folder."""
    earth = arguments.data / "earth"
    relief, mountains, picture = earth / "etopo5_dem_10min.tif", earth / "srtm3_everest_N27E086_filled.tif", earth / "bluemarble_dec2004_5400x2700.jpg"
    small = [] if arguments.whole else ["--region", "60,0,100,40"]
    elevation = [relief, "--kind", "elevation", "--tiling", "geographic", *small]
    imagery = [picture, "--kind", "imagery", "--tiling", "cube", *small]
    ways = {"elevation": ([], elevation), "imagery": ([], imagery),
            "append": (["--append", relief], [mountains, "--kind", "elevation", "--tiling", "cube"]),
            "share": (["--share"], elevation), "parts": (["--parts", "2"], imagery)}
    if not arguments.whole:
        del ways["append"], ways["elevation"]  # they are tests of their own
    for name, (way, build) in ways.items():
        done = run([sys.executable, HERE / "kill_build.py", arguments.program, arguments.folder / name, "--kills", "10" if arguments.whole else "2",
                    "--seed", str(seed), *way, "--", *build])
        if done.returncode != 0:
            fail(f"kills, {name}: {done.stdout}{done.stderr}")
        print(f"{name}: {done.stdout.splitlines()[-1]}")


class Source:
    """A raster of the test's own, an undisturbed build of it, and how long that takes."""

    def __init__(self, arguments):
        self.path = arguments.folder / "source.tif"
        self.program = arguments.program
        self.bytes = (arguments.data / "earth" / "etopo5_dem_10min.tif").read_bytes()
        self.restore()
        self.whole = arguments.folder / "whole.tdb"
        self.output = arguments.folder / "out.tdb"
        clean(self.whole)
        began = time.monotonic()
        run_sound(self.build(self.whole))
        self.duration = time.monotonic() - began

    def build(self, output):
        return [self.program, "build", str(output), str(self.path), "--kind", "elevation", "--tiling", "cube"]

    def restore(self):
        self.path.write_bytes(self.bytes)
        os.utime(self.path, (1, 1))  # what is done to it gives it another time, however coarse the file system's clock


def expect_words(done, words, what):
    if done.returncode != 1 or not all(word in done.stderr for word in words):
        fail(f"{what}: ended with {done.returncode} and says: {done.stderr}")


def gives_name_spaces(folder):
    """Whether this system lets a user mount a disk of his own; asked by itself, so that nothing else is taken for a no."""
    return shutil.which("unshare") and run(["unshare", "-rm", "sh", "-c", 'mount -t tmpfs -o size=1m tmpfs "$0"', folder]).returncode == 0


def small_disk(source, folder, share):
    disk = folder / "disk"
    disk.mkdir(exist_ok=True)
    size = source.whole.stat().st_size
    output = disk / "out.tdb"
    script = ('mount -t tmpfs -o size=$1 tmpfs "$2" || exit 77; out=$3; shift 3; "$@"; status=$?; [ $status = 1 ] || exit 78; '
              'ls "$(dirname $out)" >&2; mount -o remount,size=1g tmpfs "$(dirname $out)"; "$@" 2>/dev/null || exit 79; cp "$out" "$0"')
    copied = folder / "from_small_disk.tdb"
    clean(copied)
    words = ["unshare", "-rm", "sh", "-c", script, copied, str(int(size * share)), disk, output, *source.build(output)]
    done = run(words)
    if done.returncode != 0 or "the disk is full; nothing is lost: free some space and run the same command again" not in done.stderr:
        fail(f"disk of {share:.2f} times the result: {done.returncode}: {done.stderr}")
    if "out.tdb.part" not in done.stderr:
        fail(f"disk of {share:.2f} times the result: nothing is kept: {done.stderr}")
    expect_same(source.whole, copied, f"disk of {share:.2f} times the result")


def limited_file(source, share):
    clean(source.output)
    most = int(source.whole.stat().st_size * share)
    done = run(source.build(source.output), preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, resource.RLIM_INFINITY)))
    expect_words(done, ["File too large", "the same command goes on from there"], f"files of at most {most} bytes")
    run_sound(source.build(source.output))
    expect_same(source.whole, source.output, f"files of at most {most} bytes")


def rewritten(path):
    """As a program does that writes its result again: other bytes in the same file."""
    with open(path, "r+b") as file:
        data = bytearray(file.read())
        for i in range(len(data) // 3, len(data), 97):
            data[i] ^= 0x55
        file.seek(0)
        file.write(data)


def replaced(path):
    path.unlink()
    path.write_bytes(b"no raster any more")


DISTURBANCES = {"removed": lambda path: path.unlink(), "truncated": lambda path: os.truncate(path, path.stat().st_size // 3),
                "rewritten": rewritten, "replaced": replaced}


def lost_source(source, name, moment):
    """Either it was read wholly before, or the build says what is the matter; the next one is as if nothing had been."""
    clean(source.output)
    source.restore()
    process = subprocess.Popen(source.build(source.output), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    time.sleep(moment)
    DISTURBANCES[name](source.path)
    errors = process.communicate()[1]
    source.restore()
    if process.returncode != 0:
        if process.returncode != 1 or source.path.name not in errors:
            fail(f"source {name} after {moment:.2f} s: ends with {process.returncode} and says: {errors}")
        run_sound(source.build(source.output))
    expect_same(source.whole, source.output, f"source {name} after {moment:.2f} s")
    return process.returncode


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--whole", action="store_true")
    parser.add_argument("--seed", type=int, default=int(time.time()))
    arguments = parser.parse_args()
    print(f"seed {arguments.seed}")
    dice = random.Random(arguments.seed)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    kills(arguments, arguments.seed)
    source = Source(arguments)
    moments = 12 if arguments.whole else 1
    if gives_name_spaces(arguments.folder):
        for _ in range(moments):
            small_disk(source, arguments.folder, dice.uniform(0.1, 0.9))
        print(f"{moments} full disks: the same bytes")
    else:
        print("NOT TRIED: full disks. This system gives no name spaces (unshare -rm); limits of a file's size come next.")
    for _ in range(moments):
        limited_file(source, dice.uniform(0.1, 0.9))
    print(f"{moments} limits of a file's size: the same bytes")
    for name in DISTURBANCES:
        ends = [lost_source(source, name, dice.uniform(0.0, source.duration)) for _ in range(moments)]
        print(f"source {name} {moments} times: {ends.count(1)} builds say so, {ends.count(0)} had read all of it; then the same bytes")


if __name__ == "__main__":
    main()
