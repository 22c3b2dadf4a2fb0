#!/usr/bin/env python3
"""Fails on the first include that points down: a room may use only the rooms above it (docs/architecture.md)."""
import pathlib
import re
import sys

ROOMS = ["geo", "tiling", "io", "raster", "pyramid", "scene", "render", "app"]

# The only rooms that may touch a library, by the start of its include path. Not named here: the standard library.
WALLS = {
    "glm/": {"geo"},
    "tl/": {"io"},
    "gdal": {"raster"},
    "cpl_": {"raster"},
    "ogr": {"raster"},
    "proj": {"raster"},
    "jpeglib.h": {"raster"},
    "png.h": {"raster"},
    "webp/": {"raster"},
    "zstd.h": {"raster", "pyramid"},
    "sqlite3.h": {"pyramid"},
    "toml++/": {"scene"},
    "epoxy/": {"render"},
    "GL/": set(),
    "EGL/": set(),
    "CLI/": {"app"},
    "GLFW/": {"app"},
    "imgui": {"app"},
    "backends/imgui": {"app"},
    "nlohmann/": {"scene", "app"},
}
# Third-party types stay out of every header, but for the vector types, the result type and the program's own skin.
HEADER_EXCEPTIONS = {"glm/": {"geo/vector.h"}, "tl/": {"io/failure.h"}}

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^">]+)[">]')


def complaints_about(path: pathlib.Path, source: pathlib.Path):
    relative = path.relative_to(source).as_posix()
    room = relative.split("/")[0]
    is_test = path.stem.endswith("_test")
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        target = match.group(1)
        first = target.split("/")[0]
        if first in ROOMS and "/" in target and ROOMS.index(first) > ROOMS.index(room):
            yield f"{relative}:{number}: room '{room}' includes '{target}' of the room '{first}' below it"
        for library, rooms in WALLS.items():
            if not target.startswith(library) or first in ROOMS:
                continue
            if room not in rooms and not is_test:
                yield f"{relative}:{number}: only {sorted(rooms) or 'no room'} may touch '{target}'"
            elif path.suffix == ".h" and not is_test and room != "app" and relative not in HEADER_EXCEPTIONS.get(library, set()):
                yield f"{relative}:{number}: '{target}' in a header that others include"


def main():
    source = pathlib.Path(sys.argv[1]) / "src"
    folders = {p.name for p in source.iterdir() if p.is_dir()}
    complaints = [f"src/{name}: not a room of the design" for name in sorted(folders - set(ROOMS))]
    files = sorted([*source.rglob("*.h"), *source.rglob("*.cpp")])
    if not files:
        complaints.append(f"{source}: no sources found")
    for path in files:
        complaints.extend(complaints_about(path, source))
    print("\n".join(complaints) if complaints else f"{len(files)} files: every include points up")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
