#!/usr/bin/env python3
"""When there is something to see over a slow line, for docs/measurements.md, with servers of its own (the packages of tests/online_world.py).

    bench/first_picture.py PROGRAM WORK_DIR

A WMS with imagery, and one with heights as raw TIFF, behind 2 Mbit/s: after each time how far the picture is from the final one, and the bytes that came over the line,
which say more than the seconds where other work keeps the cores busy.
"""
import pathlib
import shutil
import sys

SOURCE = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(SOURCE / "tests"))
import map_servers  # noqa: E402
import online_world  # noqa: E402

VIEW = ["--camera", "20,60,3000000,0,-60,0", "--size", "320x240", "--exaggeration", "20"]


def measure(program, work, proxy, name, scene):
    proxy.tell("clear")
    online_world.Program(program, work / f"cache {name}").run("render", scene, *VIEW, "-o", work / f"{name}.png")
    final = online_world.colours(work / f"{name}.png")
    proxy.tell("bandwidth", bits=2e6)
    for seconds in (1, 1.5, 2, 3, 4, 6, 8, 10, 12):
        proxy.tell("reset")
        out = work / f"{name}_{seconds}.png"
        online_world.Program(program, work / f"cache {name} {seconds}").run("render", scene, *VIEW, "--timeout", seconds, "-o", out, status=None)
        off = abs(online_world.colours(out) - final)
        state = proxy.state()
        print(f"{name}, {seconds} s: {100 * float((off.max(axis=2) <= 2).mean()):.1f}% of the pixels are final, {float(off.mean()):.1f} off in the mean; "
              f"{state['bytes'] / 1024:.0f} KiB, {sum(state['counts'].values())} requests", flush=True)


def main():
    if absent := online_world.missing():
        print(f"not installed: {', '.join(absent)}")
        return 77
    program, work = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    layers = {"picture": map_servers.Layer(SOURCE / "data/earth/bluemarble_dec2004_5400x2700.jpg"), "heights": map_servers.Layer(SOURCE / "data/earth/etopo5_dem_10min.tif")}
    with map_servers.MapServer(work / "wms", layers) as wms, online_world.FaultServer(proxy=wms.url.removesuffix("/wms")) as proxy:
        # The capabilities name the line's end, not the server behind it.
        wms.map_file.write_text(wms.map_file.read_text().replace(wms.url, proxy.url + "/wms"))
        entry = {"source": proxy.url + "/wms", "type": "wms", "max_level": 2}
        for tiling in ("cube", "geographic", "healpix"):
            scene = online_world.scene_file(work / f"imagery {tiling}.toml", [{**entry, "layer": "picture"}], tiling=tiling)
            measure(program, work, proxy, f"imagery on {tiling}", scene)
        heights = {**entry, "layer": "heights", "format": "image/tiff"}
        measure(program, work, proxy, "elevation", online_world.scene_file(work / "elevation.toml", [], [heights], light=True))
    return 0


if __name__ == "__main__":
    sys.exit(main())
