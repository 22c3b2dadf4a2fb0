#!/usr/bin/env python3
"""Kills a build with SIGKILL at random moments, starts it again until it is done, and compares the file, byte for byte,
with an undisturbed build's.

    tests/kill_build.py PROGRAM WORK_FOLDER [--kills N] [--seed S] [--append BASE_INPUT] -- INPUT... --kind KIND ...

Everything after '--' is handed to 'PROGRAM build OUT.tdb'. With --append, each round first builds OUT.tdb from BASE_INPUT
(same --kind and --tiling), and the rest is appended to it.
"""
import argparse
import filecmp
import pathlib
import random
import shutil
import subprocess
import sys
import time


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--kills", type=int, default=6, help="how many times a build is killed, over all rounds")
    parser.add_argument("--seed", type=int, default=int(time.time()))
    parser.add_argument("--append", metavar="BASE_INPUT")
    words = sys.argv[1:]
    split = words.index("--") if "--" in words else len(words)
    arguments = parser.parse_args(words[:split])
    arguments.build = words[split + 1:]
    if not arguments.build:
        parser.error("nothing to build: say what after '--'")
    return arguments


def clean(output):
    for path in output.parent.glob(output.name + "*"):
        path.unlink()


def options_only(build):
    """--kind and --tiling with their values: what the base of an append shares with it."""
    shared = []
    for name in ("--kind", "--tiling"):
        if name in build:
            shared += [name, build[build.index(name) + 1]]
    return shared


def start_over(arguments, output, base):
    clean(output)
    if base is not None:
        shutil.copy(base, output)


def command(arguments, output):
    append = ["--append"] if arguments.append else []
    return [arguments.program, "build", str(output), *arguments.build, *append]


def run_to_the_end(words):
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"failed: {' '.join(words)}\n{done.stderr}")


def main():
    arguments = parse_arguments()
    print(f"seed {arguments.seed}")
    dice = random.Random(arguments.seed)
    arguments.folder.mkdir(parents=True, exist_ok=True)
    base = None
    if arguments.append:
        base = arguments.folder / "base.tdb"
        clean(base)
        run_to_the_end([arguments.program, "build", str(base), arguments.append, *options_only(arguments.build)])
    whole = arguments.folder / "whole.tdb"
    start_over(arguments, whole, base)
    began = time.monotonic()
    run_to_the_end(command(arguments, whole))
    duration = time.monotonic() - began
    killed = arguments.folder / "killed.tdb"
    kills = rounds = finished_first = 0
    while kills < arguments.kills:
        start_over(arguments, killed, base)
        rounds += 1
        # One to four kills a round, so that runs that went on are killed too.
        for _ in range(dice.randint(1, 4)):
            process = subprocess.Popen(command(arguments, killed), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(dice.uniform(0.0, duration))
            if process.poll() is None:
                process.kill()
                kills += 1
            else:
                finished_first += 1
            process.wait()
        run_to_the_end(command(arguments, killed))
        if not filecmp.cmp(whole, killed, shallow=False):
            sys.exit(f"round {rounds}, seed {arguments.seed}: {killed} differs from {whole}")
        left = [p.name for p in killed.parent.glob(killed.name + "?*")]
        if left:
            sys.exit(f"round {rounds}, seed {arguments.seed}: left behind: {left}")
    print(f"{kills} kills in {rounds} rounds ({finished_first} came too late): the same {whole.stat().st_size} bytes each time")


if __name__ == "__main__":
    main()
