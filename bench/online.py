#!/usr/bin/env python3
"""Figures of online data for docs/measurements.md, with servers of its own (the packages of tests/online_world.py).

    bench/online.py PROGRAM WORK_DIR faults|line|flight|layers [SECONDS] [FPS] [--no-times]

faults: frame times of a flight over a healthy server and over one that fails in every way that tests/fault_server.py knows, in turns. line: at 2 Mbit/s,
seconds until 90% of the pixels are final, with requests in the program's order and in that of asking, and that nothing comes twice. flight: SECONDS (600) over a WMS with small
budgets: memory, disk, frame times; FPS (30; 0: one frame after the other) is the beat of the screen. layers: frame times while an opacity changes sixty times a
second, every other second of a flight. What is asked of each (docs/measurements.md) is said with the figure, and not reached it makes the exit status 1;
--no-times: but for times, which a busy machine cannot promise. The servers leave the cores to the program, as those on other machines do.
"""
import csv
import json
import math
import pathlib
import shutil
import signal
import statistics
import sys
import time

SOURCE = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(SOURCE / "tests"))
import map_servers  # noqa: E402
import online_world  # noqa: E402
from online_world import numpy  # noqa: E402

PICTURE = SOURCE / "data/earth/bluemarble_dec2004_5400x2700.jpg"
VIEW = "45,10,6000000,0,-90,0"
SIZE = "640x480"
FINEST = 4
MEBI = 2 ** 20
# A cache's log grows a little over its share while somebody reads.
LOG_MIB = 0.5
# What the program may hold in all (docs/online.md, "What is held"): of the tiles made, of decoded images, of answers that wait for the disk. What is on its way
# may be 256 MiB and one answer; 6 images of this flight at a time are far below that, so it is held to less.
DECODED_MIB, IMAGES_MIB, WRITES_MIB, UNDERWAY_MIB = 256, 128, 64, 32
# Every fault of the proxy that an image may have, a column of level 4 each.
FAULTS = ({"fault": "status"}, {"fault": "hang"}, {"fault": "slow", "rate": 100}, {"fault": "truncate"}, {"fault": "cut"}, {"fault": "spoil"},
          {"fault": "spoil", "mended": 1}, {"fault": "mislabel", "type": "text/html"}, {"fault": "other", "path": "/small.png"}, {"fault": "html"},
          {"fault": "xml"}, {"fault": "redirect", "to": "http://127.0.0.1:1/"}, {"fault": "loop"}, {"fault": "endless"}, {"fault": "length", "n": 10}, {"fault": "reset"})
# Two more, a column of level 3 each.
COARSER_FAULTS = ({"fault": "bomb"}, {"fault": "empty"})


class Asked:
    """What is asked for, and whether all of it was reached."""

    def __init__(self, times):
        self.times = times
        self.missed = 0

    def at_most(self, what, value, limit, is_time=False):
        counts = self.times or not is_time
        self.missed += counts and value > limit
        print(f"{what}: {value:.2f}, asked: at most {limit:.2f}: {'reached' if value <= limit else 'MISSED' if counts else 'missed (not asserted)'}", flush=True)


def flight_path(path, seconds):
    """Around the Earth once in two minutes, between 4,000 and 1,000 km."""
    poses = [(s, 30 * (1 if s // 40 % 2 else -1) * ((s % 40) / 20 - 1), (3 * s + 180) % 360 - 180, 4e6 if s // 15 % 2 else 1e6) for s in range(0, seconds + 1, 5)]
    path.write_text("".join(f"{s},{lat},{lon},{height},0,-75,0\n" for s, lat, lon, height in poses))
    return path


def xyz(work, finest=FINEST):
    online_world.make_xyz(PICTURE, work / "tree", finest)
    online_world.write_png(work / "tree/small.png", numpy.zeros((3, 128, 128), "uint8"))
    return map_servers.FileServer(work / "tree", work / "nginx")


def entry_of(proxy, finest=FINEST):
    return {"source": proxy.url + "/xyz/{z}/{x}/{y}.png", "max_level": finest}


def rows_of(path):
    return list(csv.DictReader(path.read_text().splitlines()))


def middle_and_99(times):
    times = sorted(times)
    return statistics.median(times), times[min(len(times) - 1, int(0.99 * len(times)))]


def percentiles(rows, column="frame_ms"):
    return middle_and_99(float(row[column]) for row in rows)


def intervals(rows):
    """From the beginning of a frame to that of the next: what a person sees."""
    starts = [float(row["time_s"]) for row in rows]
    return middle_and_99(1000 * (after - before) for before, after in zip(starts, starts[1:]))


def slowest(rows):
    """Of the slowest hundredth of the frames, and of all: the mean of each part."""
    order = sorted(rows, key=lambda row: float(row["frame_ms"]))
    some = order[-max(1, len(order) // 100):]
    parts = ("frame_ms", "update_ms", "upload_ms", "upload_bytes", "triangles", "tiles_drawn")
    return "; ".join(f"{part} {statistics.mean(float(r[part]) for r in some):.1f} of {statistics.mean(float(r[part]) for r in order):.1f}" for part in parts)


def break_everything(proxy):
    for level, faults in ((4, FAULTS), (3, COARSER_FAULTS)):
        for column, fault in enumerate(faults):
            proxy.tell("set", prefix=f"/xyz/{level}/{column if level == 4 else 2 + 3 * column}/", **fault)


def fly_through(program, work, proxy, name, seconds, fps, fails):
    """The rows of a flight; over a server that fails it also dies for a sixth of it."""
    proxy.tell("clear")
    proxy.tell("reset")
    if fails:
        break_everything(proxy)
    rows = work / f"{name}.csv"
    process = online_world.Program(program, work / f"cache {name}").start(
        "bench", work / "scene.toml", "--path", work / "path.csv", "--size", SIZE, "--stats", rows, "--fps", fps, "--json")
    if fails:
        time.sleep(seconds / 2)
        proxy.tell("dead")
        time.sleep(seconds / 6)
        proxy.tell("alive")
    _, errors = process.communicate()
    assert process.returncode == 0, errors
    frames, state = rows_of(rows), proxy.state()
    median, p99 = percentiles(frames)
    print(f"{name}: {len(frames)} frames, median {median:.1f} ms, 99% {p99:.1f} ms; {sum(state['counts'].values())} requests, "
          f"at most {max(state['counts'].values())} for one URL; answers {dict(state['statuses'])}", flush=True)
    return frames


def faults(program, work, asked, seconds=30, fps=30):
    with xyz(work) as files, online_world.FaultServer(proxy=files.url) as proxy:
        online_world.scene_file(work / "scene.toml", [entry_of(proxy)], light=True)
        flight_path(work / "path.csv", seconds)
        frames = {True: [], False: []}
        for turn in range(4):
            fails = turn % 2 == 1
            frames[fails] += fly_through(program, work, proxy, f"{'failing' if fails else 'healthy'} {turn // 2 + 1}", seconds, fps, fails)
        print(f"a healthy flight against another, 99% of frame times: {percentiles(rows_of(work / 'healthy 2.csv'))[1] / percentiles(rows_of(work / 'healthy 1.csv'))[1]:.2f}")
        asked.at_most("99% of frame times under faults, in those of the healthy server", percentiles(frames[True])[1] / percentiles(frames[False])[1], 1.2, is_time=True)


def seconds_until_final(program, work, name, words, path, since, final, limit):
    """From second `since` of the path: until at least 90% of the pixels are final and stay so."""
    pictures = work / f"pictures {name}"
    pictures.mkdir()
    process = online_world.Program(program, work / f"cache {name}").start("bench", work / "scene.toml", "--path", path, "--size", SIZE, "--fps", 5,
                                                                          "--pictures", pictures, *words)
    reached, seen, end = limit, set(), time.monotonic() + since + limit + 60
    while process.poll() is None and time.monotonic() < end:
        time.sleep(0.2)
        for picture in sorted(set(pictures.glob("*.png")) - seen):
            seen.add(picture)
            at = float(picture.stem) - since
            share = float((abs(online_world.colours(picture) - final).max(axis=2) <= 2).mean())
            if at >= 0 and len(seen) % 5 == 0:
                print(f"  {name}, {at:.0f} s: {100 * share:.0f}% final", flush=True)
            if at >= 0:
                reached = min(reached, at) if share >= 0.9 else limit
            if reached < limit and (at > reached + 3 or share > 0.98):
                process.send_signal(signal.SIGTERM)
    process.communicate(timeout=300)
    return reached


def line(program, work, asked, most=180, bits=2e6):
    """A view out of nothing, and the same after a minute's flight around the Earth, north and south, that the line cannot follow."""
    flown = 60
    near = "45,10,2000000,0,-90,0"
    still = [(s, near) for s in (0, most)]
    way = [(s, 60 * math.sin(2 * math.pi * s / 20), (10 - 6 * (flown - s) + 180) % 360 - 180) for s in range(flown)]
    passing = [(s, f"{lat:.3f},{lon},2000000,0,-90,0") for s, lat, lon in way] + [(s + flown, near) for s in (0, most)]
    with xyz(work, FINEST + 1) as files, online_world.FaultServer(proxy=files.url) as proxy:
        online_world.scene_file(work / "scene.toml", [entry_of(proxy, FINEST + 1)])
        out = work / "final.png"
        online_world.Program(program, work / "cache whole").run("render", work / "scene.toml", "--camera", near, "--size", SIZE, "-o", out)
        final = online_world.colours(out)
        for name, poses, since in (("after a flight", passing, flown), ("from nothing", still, 0)):
            path = work / f"{name}.csv"
            path.write_text("".join(f"{s},{camera}\n" for s, camera in poses))
            took = {}
            for order, words in (("most urgent first", ()), ("first come", ("--first-come",))):
                proxy.tell("clear")
                proxy.tell("bandwidth", bits=bits)
                proxy.tell("reset")
                took[order] = seconds_until_final(program, work, f"{name}, {order}", words, path, since, final, most)
                state = proxy.state()
                print(f"{name}, {order}: 90% final after {took[order]:.1f} s; {state['bytes'] / MEBI:.2f} MiB, {sum(state['counts'].values())} requests, "
                      f"{state['broken']} let go of, at most {max(state['counts'].values())} for one URL", flush=True)
                asked.at_most(f"{name}, {order}: images asked for again after they had come", len(online_world.asked_for_again(state)), 0)
            ratio = took["most urgent first"] / max(took["first come"], 0.1)
            if since > 0:
                asked.at_most(f"{name}: time in that of first come", ratio, 0.5, is_time=True)
            else:
                # All that is asked for is of the picture, and it is asked for in the order of urgency: there is little to save.
                print(f"{name}: time in that of first come: {ratio:.2f}", flush=True)


def resident(pid):
    for text in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if text.startswith("VmRSS:"):
            return int(text.split()[1]) * 1024
    return 0


def watched(process, cache):
    """What a run printed, and once a second: resident bytes and those of the disk cache."""
    memory, disk = [0], [0]
    while process.poll() is None:
        memory.append(resident(process.pid))
        disk.append(sum(file.stat().st_size for file in (cache / "tellurion").glob("online.db*") if file.exists()))
        time.sleep(0.5)
    out, errors = process.communicate()
    assert process.returncode == 0, errors
    return json.loads(out), memory, disk


def bare_bytes(program, work):
    """Of the program that draws a bare ellipsoid: itself, its libraries, OpenGL's, the picture."""
    path = work / "still.csv"
    path.write_text("".join(f"{s},{VIEW}\n" for s in (0, 2)))
    cache = work / "cache bare"
    process = online_world.Program(program, cache).start("bench", online_world.scene_file(work / "bare.toml", light=True), "--path", path, "--size", SIZE, "--json")
    return max(watched(process, cache)[1])


def flight(program, work, asked, seconds=600, fps=30):
    # A short flight needs small budgets to come up to them.
    gpu_mib, disk_mib = (96, 32) if seconds > 60 else (40, 4)
    bare = bare_bytes(program, work)
    with map_servers.MapServer(work / "wms", {"bluemarble": map_servers.Layer(PICTURE)}, nice=19 if asked.times else 0) as wms:
        scene = online_world.scene_file(work / "scene.toml", [{"source": wms.url, "type": "wms", "layer": "bluemarble"}], light=True)
        path, rows = flight_path(work / "path.csv", seconds), work / "flight.csv"
        cache = work / "cache"
        process = online_world.Program(program, cache).start("bench", scene, "--path", path, "--size", SIZE, "--stats", rows, "--gpu-memory", gpu_mib,
                                                            "--cache-mib", disk_mib, "--fps", fps, "--json")
        summary, memory, disk = watched(process, cache)
        frames = rows_of(rows)
        median, p99 = percentiles(frames)
        seen, late = intervals(frames)
        thirds = [max(memory[i * len(memory) // 3:(i + 1) * len(memory) // 3] or [0]) / MEBI for i in range(3)]
        print(f"{seconds} s, {len(frames)} frames, {len(wms.requests)} requests to the WMS; frame median {median:.1f} ms, 99% {p99:.1f} ms; "
              f"from frame to frame median {seen:.1f} ms, 99% {late:.1f} ms, ratio {late / seen:.2f}")
        print(f"the slowest hundredth, and all in the mean: {slowest(frames)}; update 99% / median {percentiles(frames, 'update_ms')[1] / percentiles(frames, 'update_ms')[0]:.1f}")
        print(f"resident, MiB, by thirds of the flight: {', '.join(f'{most:.0f}' for most in thirds)}; of a bare ellipsoid {bare / MEBI:.0f}")
        asked.at_most("GPU memory, MiB", summary["gpu_bytes_max"] / MEBI, gpu_mib)
        asked.at_most("tiles made, MiB", summary["cpu_cache_bytes_max"] / MEBI, DECODED_MIB)
        asked.at_most("disk cache, MiB", max(disk) / MEBI, disk_mib + LOG_MIB)
        budgets = gpu_mib + DECODED_MIB + IMAGES_MIB + WRITES_MIB + UNDERWAY_MIB
        asked.at_most(f"resident, MiB (bare {bare / MEBI:.0f} and budgets of {budgets})", max(memory) / MEBI, bare / MEBI + budgets)
        if fps > 0:
            asked.at_most("99% of times from frame to frame in their median", late / seen, 1.5, is_time=True)
        # What a frame costs goes with its picture and with what else the machine does: beside it, frames that lack nothing and got nothing.
        calm = [row for before, row in zip(frames, frames[1:]) if int(row["tiles_wanted"]) + int(before["tiles_wanted"]) + int(row["upload_bytes"]) == 0]
        ratios = [percentiles(some)[1] / percentiles(some)[0] for some in (frames, calm) if some]
        print(f"99% of what frames cost in their median: {', of those that load nothing: '.join(f'{ratio:.2f}' for ratio in ratios)} ({len(calm)} frames)")


def layers(program, work, asked, seconds=60, fps=30):
    with xyz(work) as files, online_world.FaultServer(proxy=files.url) as proxy:
        scene = online_world.scene_file(work / "scene.toml", [{**entry_of(proxy), "name": "ground"}, {**entry_of(proxy), "name": "above"}], light=True)
        path, rows = work / "path.csv", work / "layers.csv"
        run = online_world.Program(program, work / "cache")
        run.run("render", scene, "--camera", VIEW, "--size", SIZE, "-o", work / "warm.png")
        changing, still = [], []
        # However long a busy machine takes until all is here.
        while not (still and any(int(row["layer_changes"]) for row in changing)) and seconds < 1000:
            path.write_text("".join(f"{s},{VIEW}\n" for s in (0, seconds)))
            run.run("bench", scene, "--path", path, "--size", SIZE, "--fps", fps, "--layer-changes", 60, "--stats", rows, timeout=seconds + 120)
            frames = rows_of(rows)
            frames = frames[next((i for i, row in enumerate(frames) if row["complete"] == "true"), len(frames)):]
            seconds *= 2
            changing = [row for row in frames if int(float(row["time_s"])) % 2]
            still = [row for row in frames if not int(float(row["time_s"])) % 2]
        print(f"{sum(int(row['layer_changes']) for row in frames)} changes; at rest median {percentiles(still)[0]:.1f} ms, 99% {percentiles(still)[1]:.1f} ms; "
              f"while they change {percentiles(changing)[0]:.1f} and {percentiles(changing)[1]:.1f} ms")
        asked.at_most("requests once all is here", int(frames[-1]["requests"]) - int(frames[0]["requests"]), 0)
        asked.at_most("tiles that are wanted in any frame", max(int(row["tiles_wanted"]) for row in frames), 0)
        asked.at_most("99% of frame times while the opacity changes, in those at rest", percentiles(changing)[1] / percentiles(still)[1], 1.2, is_time=True)


def main():
    if absent := online_world.missing():
        print(f"not installed: {', '.join(absent)}")
        return 77
    words = [word for word in sys.argv[1:] if word != "--no-times"]
    program, work, part = pathlib.Path(words[0]).resolve(), pathlib.Path(words[1]).resolve(), words[2]
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    asked = Asked(times="--no-times" not in sys.argv)
    {"faults": faults, "line": line, "flight": flight, "layers": layers}[part](program, work, asked, *map(int, words[3:]))
    return 1 if asked.missed else 0


if __name__ == "__main__":
    sys.exit(main())
