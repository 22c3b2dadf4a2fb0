#!/usr/bin/env python3
"""Kills a build with SIGKILL at random moments, starts it again until it is done, and compares the file, byte for byte,
with an undisturbed build's.

    tests/kill_build.py PROGRAM WORK_FOLDER [--kills N] [--seed S] [--append BASE_INPUT | --share | --parts N] -- INPUT... --kind KIND ...

Everything after '--' is handed to 'PROGRAM build OUT.tdb'. With --append, each round first builds OUT.tdb from BASE_INPUT
(same --kind and --tiling), and the rest is appended to it. --share builds as one of many processes would, --parts N in N
fixed shares that 'PROGRAM merge' joins; whichever of these runs is killed, it is started again.
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
    way = parser.add_mutually_exclusive_group()
    way.add_argument("--append", metavar="BASE_INPUT")
    way.add_argument("--share", action="store_true")
    way.add_argument("--parts", type=int, default=0, metavar="N")
    words = sys.argv[1:]
    split = words.index("--") if "--" in words else len(words)
    arguments = parser.parse_args(words[:split])
    arguments.build = words[split + 1:]
    if not arguments.build:
        parser.error("nothing to build: say what after '--'")
    return arguments


def clean(output):
    for path in output.parent.glob(output.name + "*"):
        shutil.rmtree(path) if path.is_dir() else path.unlink()


def options_only(build):
    """--kind and --tiling with their values: what the base of an append shares with it."""
    shared = []
    for name in ("--kind", "--tiling"):
        if name in build:
            shared += [name, build[build.index(name) + 1]]
    return shared


def start_over(output, base):
    clean(output)
    if base is not None:
        shutil.copy(base, output)


def commands(arguments, output):
    """What is run, one after the other, to make the output."""
    build = [arguments.program, "build", str(output), *arguments.build]
    if arguments.append:
        return [[*build, "--append"]]
    if arguments.share:
        return [[*build, "--share"]]
    if arguments.parts:
        shares = [[*build, "--part", f"{share + 1}/{arguments.parts}"] for share in range(arguments.parts)]
        return [*shares, [arguments.program, "merge", str(output), f"{output}.parts"]]
    return [build]


def run_to_the_end(words):
    began = time.monotonic()
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"failed: {' '.join(words)}\n{done.stderr}")
    return time.monotonic() - began


def run_and_kill(words, after):
    """Whether it was still running."""
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        process.wait(after)
        return False
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return True


def left_behind(arguments, output):
    """What is beside the output and should not; 'merge' leaves the parts to the user, but nothing unfinished among them."""
    kept = f"{output.name}.parts" if arguments.parts else None
    left = [p.name for p in output.parent.glob(output.name + "?*") if p.name != kept]
    return left + [p.name for p in output.parent.glob(f"{kept}/*.part*")] if kept else left


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
    # In one process, whichever way the killed ones go.
    whole = arguments.folder / "whole.tdb"
    start_over(whole, base)
    run_to_the_end([arguments.program, "build", str(whole), *arguments.build, *(["--append"] if arguments.append else [])])
    killed = arguments.folder / "killed.tdb"
    start_over(killed, base)
    durations = [run_to_the_end(words) for words in commands(arguments, killed)]
    kills = rounds = finished_first = 0
    while kills < arguments.kills:
        start_over(killed, base)
        rounds += 1
        for words, duration in zip(commands(arguments, killed), durations):
            # One to four kills a round, so that runs that went on are killed too.
            for _ in range(min(dice.randint(1, 4), arguments.kills - kills)):
                if run_and_kill(words, dice.uniform(0.0, duration)):
                    kills += 1
                else:
                    finished_first += 1
            run_to_the_end(words)
        if not filecmp.cmp(whole, killed, shallow=False):
            sys.exit(f"round {rounds}, seed {arguments.seed}: {killed} differs from {whole}")
        if left := left_behind(arguments, killed):
            sys.exit(f"round {rounds}, seed {arguments.seed}: left behind: {left}")
        if finished_first > 20 * (kills + arguments.kills):
            sys.exit(f"seed {arguments.seed}: {finished_first} runs ended before they could be killed: give more to build")
    print(f"{kills} kills in {rounds} rounds ({finished_first} came too late): the same {whole.stat().st_size} bytes each time")


if __name__ == "__main__":
    main()
