#!/usr/bin/env python3
"""Builds with many processes, kills some with SIGKILL at random moments, and compares the file, byte for byte, with one
process's build's.

    tests/many_processes_test.py PROGRAM DATA_FOLDER WORK_FOLDER [--seed S] [--kills N]

Without mpirun (Debian's openmpi-bin) the processes are started by hand, and the test is skipped at its end.
"""
import argparse
import filecmp
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import time

SKIPPED = 77


def fail(message):
    sys.exit(f"FAILED: {message}")


def clean(output):
    for path in output.parent.glob(output.name + "*"):
        shutil.rmtree(path) if path.is_dir() else path.unlink()


def holders(output):
    """The processes that make parts: their locks name them, and the parts are not there yet."""
    found = set()
    for lock in output.parent.glob(output.name + ".parts/*.lock"):
        try:
            match = re.match(r"process (\d+) on ", lock.read_text())
        except OSError:
            continue
        if match and lock.name != "join.lock" and not lock.with_suffix(".tdb").exists():
            found.add(int(match[1]))
    return sorted(found)


def kill_one(output, dice, running, patience=60):
    """Waits for processes that make parts, and kills one. False: the build ended before."""
    end = time.monotonic() + patience
    time.sleep(dice.uniform(0.0, 0.3))
    while time.monotonic() < end and running():
        found = holders(output)
        if found:
            try:
                os.kill(dice.choice(found), signal.SIGKILL)
                return True
            except ProcessLookupError:
                pass  # it was killed before, and nobody has taken its part yet
        time.sleep(0.002)
    return False


def check(output, whole, what):
    if not filecmp.cmp(whole, output, shallow=False):
        fail(f"{what}: {output} differs from {whole}")
    left = [p.name for p in output.parent.glob(output.name + "?*")]
    if left:
        fail(f"{what}: left behind: {left}")


def mpirun(count):
    return ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", str(count)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--seed", type=int, default=int(time.time()))
    parser.add_argument("--kills", type=int, default=2)
    arguments = parser.parse_args()
    print(f"seed {arguments.seed}")
    dice = random.Random(arguments.seed)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    whole, output = arguments.folder / "whole.tdb", arguments.folder / "many.tdb"
    clean(whole)
    clean(output)

    def build(path, *more):
        return [arguments.program, "build", str(path), str(arguments.data / "earth" / "etopo5_dem_10min.tif"), "--kind", "elevation",
                "--tiling", "healpix", "--jobs", "1", *more]

    subprocess.run(build(whole), check=True, capture_output=True)

    # By hand: of three processes one is killed, and the others make what it has left.
    for attempt in range(5):
        clean(output)
        processes = [subprocess.Popen(build(output, "--share"), stderr=subprocess.PIPE, text=True) for _ in range(3)]
        killed = kill_one(output, dice, lambda: all(p.poll() is None for p in processes))
        errors = [p.communicate(timeout=120)[1] for p in processes]
        # One that is killed just when its part was there has nothing redone.
        if killed and any(p.returncode == -signal.SIGKILL for p in processes) and any("is gone; it is redone" in text for text in errors):
            break
    else:
        fail(f"no process could be killed while it made a part, or nobody told of it: {errors}")
    if sorted(p.returncode for p in processes) != [-signal.SIGKILL, 0, 0]:
        fail(f"exit statuses {[p.returncode for p in processes]}: {errors}")
    check(output, whole, "by hand")
    print("three processes by hand, one killed: the same bytes")

    # Fixed shares of a job array, joined out of their folder.
    clean(output)
    for share in ("1/2", "2/2"):
        subprocess.run(build(output, "--part", share), check=True, capture_output=True)
    subprocess.run([arguments.program, "merge", str(output), f"{output}.parts"], check=True, capture_output=True)
    shutil.rmtree(f"{output}.parts")
    check(output, whole, "merge")
    print("two shares joined: the same bytes")

    if shutil.which("mpirun") is None:
        print("no mpirun: the rest is left out")
        return SKIPPED
    clean(output)
    done = subprocess.run(mpirun(4) + build(output), capture_output=True, text=True, timeout=120, check=False)
    if done.returncode != 0:
        fail(f"mpirun ends with {done.returncode}: {done.stderr}")
    check(output, whole, "mpirun")
    print("mpirun -n 4: the same bytes")

    for attempt in range(5):
        clean(output)
        process = subprocess.Popen(mpirun(4) + build(output), stderr=subprocess.PIPE, text=True)
        kills = sum(kill_one(output, dice, lambda: process.poll() is None) for _ in range(arguments.kills))
        errors = process.communicate(timeout=120)[1]
        if process.returncode != 0:
            fail(f"mpirun with killed processes ends with {process.returncode}: {errors}")
        check(output, whole, "mpirun with killed processes")
        if kills and "was killed by signal 9" in errors and "is gone; it is redone" in errors:
            break
    else:
        fail(f"nothing tells of {kills} kills: {errors}")
    print(f"mpirun -n 4, {kills} processes killed and reported: the same bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
