#!/usr/bin/env python3
"""Fails on the first include that points down, and on a library outside the room that owns it.

    tests/layering_test.py PROJECT_FOLDER

Rooms, their order and what each owns are read from the table in docs/architecture.md; here is only how a library is
included. Every include must be a room's, the standard library's, or a known library's. Before the project itself, small
made-up projects with one fault each are read, and the faults must be found.
"""
import pathlib
import re
import sys
import tempfile

# How the libraries of the table are included. OpenGL and EGL come through libepoxy: <GL/gl.h> is nobody's.
LIBRARIES = {
    "GLM": ("glm/",),
    "ERFA": ("erfa",),
    "tl::expected": ("tl/",),
    "GDAL": ("gdal", "cpl_", "ogr"),
    "PROJ": ("proj.h",),
    "JPEG": ("jpeglib.h", "jerror.h"),
    "PNG": ("png.h",),
    "WebP": ("webp/",),
    "zstd": ("zstd",),
    "SQLite": ("sqlite3",),
    "libcurl": ("curl/",),
    "OpenSSL": ("openssl/",),
    "pugixml": ("pugixml",),
    "stb": ("stb/",),
    "toml++": ("toml++/",),
    "OpenGL": ("epoxy/gl.h",),
    "EGL": ("epoxy/egl.h",),
    "libepoxy": ("epoxy/",),
    "CLI11": ("CLI/",),
    "GLFW": ("GLFW/",),
    "Dear ImGui": ("imgui", "backends/imgui"),
    "nlohmann-json": ("nlohmann/",),
}
THREADS = "threads"  # in the table, but no library
# Of these the public headers speak, of all other libraries none. The program's headers are nobody else's.
HEADER_EXCEPTIONS = {"GLM": "geo/vector.h", "tl::expected": "io/failure.h"}
# What tests compare with, and look into, beyond what their room owns.
OF_TESTS = {
    "geo": ("GeographicLib/",),
    "tiling": ("chealpix.h", "proj.h"),
    "io": ("nlohmann/",),
    "pyramid": ("gdal", "cpl_", "ogr", "sqlite3"),
}
TEST_FRAMEWORK = ("gtest/", "gmock/")

# fmt is every room's that has failures to tell, in .cpp files.
FMT_FROM = "io"
# geo and tiling are pure: from io down there may be locks; only io and the program start threads.
CONCURRENCY = {"atomic", "barrier", "condition_variable", "future", "latch", "mutex", "semaphore", "shared_mutex", "stop_token", "thread"}
STARTS_THREAD = re.compile(r"\bstd::(?:(?:jthread|thread)\b(?!::)|async\b)")
# POSIX and not C++: only in files that docs/architecture.md names (tests aside).
POSIX = re.compile(r"^(?:sched\.h|unistd\.h|fcntl\.h|stdio\.h|poll\.h|netdb\.h|sys/\w+\.h|netinet/\w+\.h)$")
STANDARD = re.compile(r"^[a-z_0-9]+$")
NEVER_IN_HEADERS = {"iostream", "regex", "future", "ranges"}

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]')
TABLE_ROW = re.compile(r"^\| `(\w+)` \|[^|]*\|([^|]*)\|")


class Design:
    """Rooms in their order and what each owns, as docs/architecture.md says."""

    def __init__(self, text):
        rows = [TABLE_ROW.match(line) for line in text.splitlines()]
        self.owns = {row[1]: {word.strip() for word in row[2].split(",")} - {""} for row in rows if row}
        self.rooms = list(self.owns)
        self.text = text

    def complaints(self):
        if len(self.rooms) < 2:
            yield "docs/architecture.md: no table of rooms found"
        named = [library for owned in self.owns.values() for library in owned]
        for library in sorted(set(named) - set(LIBRARIES) - {THREADS}):
            yield f"docs/architecture.md: how '{library}' is included is not known here: add it to LIBRARIES"
        for library in sorted((set(LIBRARIES) | {THREADS}) - set(named)):
            yield f"docs/architecture.md: no room owns '{library}'"
        for library in sorted({x for x in named if named.count(x) > 1}):
            yield f"docs/architecture.md: more than one room owns '{library}'"

    def owner(self, library):
        return next((room for room, owned in self.owns.items() if library in owned), None)


def library_of(target):
    """The most exact match: <epoxy/egl.h> is EGL before it is libepoxy."""
    found = [(len(start), name) for name, starts in LIBRARIES.items() for start in starts if target.startswith(start)]
    return max(found)[1] if found else None


def complaint_about_include(design, relative, quoted, target):
    room = relative.split("/")[0]
    is_header = relative.endswith(".h")
    is_test = pathlib.PurePath(relative).stem.endswith("_test")
    first = target.split("/")[0]
    if quoted:
        if first not in design.rooms or "/" not in target:
            return f"'{target}' names no room"
        if design.rooms.index(first) > design.rooms.index(room):
            return f"room '{room}' includes '{target}' of the room '{first}' below it"
        return None
    if STANDARD.match(target):
        if target in CONCURRENCY and not is_test and design.rooms.index(room) < design.rooms.index(design.owner(THREADS)):
            return f"room '{room}' knows no threads, but includes <{target}>"
        if target in NEVER_IN_HEADERS and is_header:
            return f"<{target}> in a header"
        return None
    if is_test and target.startswith((*TEST_FRAMEWORK, *OF_TESTS.get(room, ()))):
        return None
    if POSIX.match(target):
        return None if is_test or f"`{relative}`" in design.text else f"<{target}> is POSIX; docs/architecture.md does not name this file"
    if target.startswith("fmt/"):
        if is_header or design.rooms.index(room) < design.rooms.index(FMT_FROM):
            return f"<{target}> belongs into .cpp files from '{FMT_FROM}' down"
        return None
    library = library_of(target)
    if library is None:
        return f"<{target}> is of no library that a room owns"
    if room != design.owner(library):
        return f"<{target}> is of {library}, which '{design.owner(library)}' owns"
    if is_header and not is_test and room != design.rooms[-1] and relative != HEADER_EXCEPTIONS.get(library):
        return f"<{target}> in a header that others include"
    return None


def complaints_about(design, source, path):
    relative = path.relative_to(source).as_posix()
    room = relative.split("/")[0]
    if room not in design.rooms:
        yield f"src/{relative}: '{room}' is not a room"
        return
    may_start_threads = room in (design.owner(THREADS), design.rooms[-1]) or path.stem.endswith("_test")
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        match = INCLUDE.match(line)
        complaint = complaint_about_include(design, relative, match[1] == '"', match[2]) if match else None
        if complaint is None and not may_start_threads and STARTS_THREAD.search(line.split("//")[0]):
            complaint = f"room '{room}' starts a thread; '{design.owner(THREADS)}' does that"
        if complaint:
            yield f"src/{relative}:{number}: {complaint}"


def read_project(root):
    """(number of files, complaints)"""
    design = Design((root / "docs" / "architecture.md").read_text(encoding="utf-8"))
    complaints = list(design.complaints())
    source = root / "src"
    folders = {p.name for p in source.iterdir() if p.is_dir()}
    complaints += [f"src/{name}: the design has it, the project not" for name in sorted(set(design.rooms) - folders)]
    files = sorted([*source.rglob("*.h"), *source.rglob("*.cpp")])
    if not files:
        complaints.append(f"{source}: no sources found")
    for path in files:
        complaints.extend(complaints_about(design, source, path))
    return len(files), complaints


# (file, a line of it, part of the complaint; empty: none)
CASES = [
    ("tiling/a.cpp", '#include "geo/angle.h"', ""),
    ("geo/a.cpp", '#include "tiling/tiling.h"', "below it"),
    ("geo/a.cpp", '  #  include "scene/frame.h"  // odd spaces', "below it"),
    ("geo/a_test.cpp", '#include "io/failure.h"', "below it"),
    ("geo/a.cpp", '#include "angle.h"', "names no room"),
    ("odd/a.cpp", "#include <cmath>", "not a room"),
    ("raster/a.cpp", "#include <zstd.h>", ""),
    ("pyramid/a.cpp", "#include <zstd.h>", "'raster' owns"),
    ("raster/a.cpp", "#include <zstd_errors.h>", ""),
    ("raster/a.h", "#include <zstd.h>", "in a header"),
    ("scene/a.cpp", "#include <nlohmann/json.hpp>", "'app' owns"),
    ("app/a.h", "#include <nlohmann/json.hpp>", ""),
    ("app/a.cpp", "#include <toml++/toml.h>", "'scene' owns"),
    ("scene/a.cpp", "#include <gdal_priv.h>", "'raster' owns"),
    ("scene/a_test.cpp", "#include <gdal_priv.h>", "'raster' owns"),
    ("pyramid/a_test.cpp", "#include <gdal_priv.h>", ""),
    ("pyramid/a.cpp", "#include <gdal_priv.h>", "'raster' owns"),
    ("pyramid/a.cpp", "#include <sqlite3.h>", "'io' owns"),
    ("pyramid/a_test.cpp", "#include <sqlite3.h>", ""),
    ("app/a.cpp", "#include <epoxy/gl.h>", "'render' owns"),
    ("render/a.cpp", "#include <epoxy/egl.h>", ""),
    ("render/a.cpp", "#include <GL/gl.h>", "no library"),
    ("render/a.cpp", "#include <boost/optional.hpp>", "no library"),
    ("geo/a.h", "#include <glm/glm.hpp>", "in a header"),
    ("geo/vector.h", "#include <glm/glm.hpp>", ""),
    ("scene/a.cpp", "#include <glm/gtc/quaternion.hpp>", "'geo' owns"),
    ("tiling/a.cpp", "#include <fmt/format.h>", "from 'io' down"),
    ("scene/a.h", "#include <fmt/format.h>", "from 'io' down"),
    ("tiling/a.cpp", "#include <mutex>", "no threads"),
    ("geo/a.h", "#include <atomic>", "no threads"),
    ("scene/a.h", "#include <mutex>", ""),
    ("scene/a.cpp", "std::jthread worker_;", "starts a thread"),
    ("pyramid/a.cpp", "auto f = std::async(work);", "starts a thread"),
    ("pyramid/a.cpp", "std::thread::id me;  // not a std::thread", ""),
    ("io/a.cpp", "std::thread t;", ""),
    ("scene/a.cpp", "#include <unistd.h>", "POSIX"),
    ("scene/a_test.cpp", "#include <unistd.h>", ""),
    ("geo/a.h", "#include <iostream>", "in a header"),
    ("geo/a.cpp", "#include <gtest/gtest.h>", "no library"),
    ("geo/a_test.cpp", "#include <GeographicLib/Geocentric.hpp>", ""),
    ("scene/a_test.cpp", "#include <GeographicLib/Geocentric.hpp>", "no library"),
]


def self_test(table):
    """What is wrong with this test itself: each made-up project must give its one complaint, or none."""
    for name, line, expected in CASES:
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for room in Design(table).rooms:
                (root / "src" / room).mkdir(parents=True)
            (root / "docs").mkdir()
            (root / "docs" / "architecture.md").write_text(table, encoding="utf-8")
            (root / "src" / name).parent.mkdir(exist_ok=True)
            (root / "src" / name).write_text(f"// A file.\n{line}\n", encoding="utf-8")
            _, complaints = read_project(root)
        if not expected and complaints or expected and not (len(complaints) == 1 and expected in complaints[0]):
            yield f"self-test: {name} with {line!r}: expected {expected or 'no complaint'!r}, found {complaints}"
    without = "\n".join(line for line in table.splitlines() if "SQLite" not in line)
    if not any("SQLite" in complaint for complaint in Design(without).complaints()):
        yield "self-test: a library that no room owns is not noticed"


def main():
    root = pathlib.Path(sys.argv[1])
    rows = [line for line in (root / "docs" / "architecture.md").read_text(encoding="utf-8").splitlines() if TABLE_ROW.match(line)]
    count, complaints = read_project(root)
    complaints += self_test("\n".join(rows))
    print("\n".join(complaints) if complaints else f"{count} files: every include points up; {len(CASES)} made-up faults and virtues told apart")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
