#!/usr/bin/env python3
"""Every raster in a folder either builds into a tile database that verifies, or fails with a clear error.

    tests/build_all.py PROGRAM DATA_FOLDER [--jobs N] [--timeout S] [--only TEXT] [--verbose]

Tried are all files that look like rasters, the hostile ones included, as elevation or imagery (both where the name does
not tell). A clear error is exit status 1 with a message that names the file. Anything else is a fault: a crash, a signal,
a time-out, status 1 without a message, a database that does not verify, a file left behind at the output. A folder of which
nothing builds is a failure too: a program that refuses everything proves nothing.
"""
import argparse
import concurrent.futures
import pathlib
import subprocess
import sys
import tempfile

SUFFIXES = {".tif", ".tiff", ".jpg", ".jpeg", ".png", ".img", ".lbl", ".hgt", ".gpkg", ".webp", ".vrt", ".asc", ".bil", ".jp2"}
ELEVATION_WORDS = ("dem", "srtm", "height", "geoid", ".hgt", "megt", "ldem", "elev")
IMAGERY_WORDS = ("rgb", "jpg", "jpeg", "color", "ortho", "landsat", "rgba")


def kinds_of(path):
    name = path.name.lower()
    if path.parent.name.startswith("srtm"):  # its files are named after their corner
        name = "srtm_" + name
    if any(word in name for word in ELEVATION_WORDS) and not any(word in name for word in ("jpg", "ortho", "rgb")):
        return ["elevation"]
    if any(word in name for word in IMAGERY_WORDS):
        return ["imagery"]
    return ["elevation", "imagery"]


def rasters_in(folder):
    return sorted(p for p in folder.rglob("*") if p.is_file() and p.suffix.lower() in SUFFIXES)


def run(words, timeout):
    try:
        done = subprocess.run(words, capture_output=True, timeout=timeout, check=False)
    except subprocess.TimeoutExpired:
        return None, "", f"no end after {timeout} s"
    return done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")


def attempt(program, raster, kind, timeout):
    """(verdict, detail): verdict is built, refused or FAULT."""
    with tempfile.TemporaryDirectory() as folder:
        output = pathlib.Path(folder) / "out.tdb"
        status, _, errors = run([program, "build", str(output), str(raster), "--kind", kind], timeout)
        detail = errors.strip().splitlines()[-1] if errors.strip() else ""
        if status == 1:
            if not detail:
                return "FAULT", "status 1 without a message"
            if raster.name not in errors:
                return "FAULT", f"the message does not name the file: {detail}"
            if output.exists():
                return "FAULT", "failed, but left a database"
            return "refused", detail
        if status != 0:
            return "FAULT", f"status {status}: {errors.strip()[-2000:]}"
        status, report, errors = run([program, "verify", str(output)], timeout)
        if status != 0:
            return "FAULT", f"verify ended with {status}: {(report + errors).strip()[-2000:]}"
        return "built", report.strip().splitlines()[-1]


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--timeout", type=float, default=300.0)
    parser.add_argument("--only", default="", help="only paths that contain this")
    parser.add_argument("--verbose", action="store_true")
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    if not arguments.data.is_dir():
        print(f"skipped: {arguments.data} is not there")
        return 77
    tasks = [(raster, kind) for raster in rasters_in(arguments.data) for kind in kinds_of(raster)
             if arguments.only in str(raster)]
    counts = {"built": 0, "refused": 0, "FAULT": 0}
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        verdicts = pool.map(lambda task: attempt(arguments.program, *task, arguments.timeout), tasks)
        for (raster, kind), (verdict, detail) in zip(tasks, verdicts):
            counts[verdict] += 1
            if verdict == "FAULT" or arguments.verbose:
                print(f"{verdict:8} {kind:9} {raster.relative_to(arguments.data)}: {detail}", flush=True)
    print(f"{len(tasks)} builds: {counts['built']} built and sound, {counts['refused']} refused with a clear error, "
          f"{counts['FAULT']} faults")
    if not counts["built"]:
        print("failed: not one database was built")
    return 1 if counts["FAULT"] or not counts["built"] else 0


if __name__ == "__main__":
    sys.exit(main())
