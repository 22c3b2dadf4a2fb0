#!/usr/bin/env python3
"""Figures of online data for docs/measurements.md, with servers of its own (the packages of tests/online_world.py).

    bench/online.py PROGRAM WORK_DIR faults|line|flight [SECONDS] [FPS]

faults: frame times of a flight over a healthy server and over one that fails in many ways. line: share of the pixels that are final, by time,
at 2 Mbit/s. flight: SECONDS (600) over a WMS with small budgets: memory, disk, frame times; FPS (30; 0: one frame after the other) is the beat of the screen. The
WMS leaves the cores to the program, as one on another machine does.
"""
import csv
import json
import pathlib
import shutil
import statistics
import sys
import time

SOURCE = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(SOURCE / "tests"))
import map_servers  # noqa: E402
import online_world  # noqa: E402

PICTURE = SOURCE / "data/earth/bluemarble_dec2004_5400x2700.jpg"
VIEW = "45,10,6000000,0,-90,0"
SIZE = "640x480"
FINEST = 4
MEBI = 2 ** 20


def flight_path(path, seconds):
    """Around the Earth once in two minutes, between 4,000 and 1,000 km."""
    poses = [(s, 30 * (1 if s // 40 % 2 else -1) * ((s % 40) / 20 - 1), (3 * s + 180) % 360 - 180, 4e6 if s // 15 % 2 else 1e6) for s in range(0, seconds + 1, 5)]
    path.write_text("".join(f"{s},{lat},{lon},{height},0,-75,0\n" for s, lat, lon, height in poses))
    return path


def xyz(work):
    online_world.make_xyz(PICTURE, work / "tree", FINEST)
    return map_servers.FileServer(work / "tree", work / "nginx")


def entry_of(proxy):
    return {"source": proxy.url + "/xyz/{z}/{x}/{y}.png", "max_level": FINEST}


def percentiles(rows, column="frame_ms"):
    times = sorted(float(row[column]) for row in rows)
    return statistics.median(times), times[min(len(times) - 1, int(0.99 * len(times)))]


def intervals(rows):
    """From the beginning of a frame to that of the next: what a person sees."""
    starts = [float(row["time_s"]) for row in rows]
    times = sorted(1000 * (after - before) for before, after in zip(starts, starts[1:]))
    return statistics.median(times), times[min(len(times) - 1, int(0.99 * len(times)))]


def slowest(rows):
    """Of the slowest hundredth of the frames, and of all: the mean of each part."""
    order = sorted(rows, key=lambda row: float(row["frame_ms"]))
    some = order[-max(1, len(order) // 100):]
    parts = ("frame_ms", "update_ms", "upload_ms", "upload_bytes", "triangles", "tiles_drawn")
    return "; ".join(f"{part} {statistics.mean(float(r[part]) for r in some):.1f} of {statistics.mean(float(r[part]) for r in order):.1f}" for part in parts)


def faults(program, work, seconds=30):
    with xyz(work) as files, online_world.FaultServer(proxy=files.url) as proxy:
        scene = online_world.scene_file(work / "scene.toml", [entry_of(proxy)], light=True)
        path = flight_path(work / "path.csv", seconds)
        p99 = {}
        for name in ("healthy", "faults", "healthy again"):
            proxy.tell("clear")
            proxy.tell("reset")
            if name == "faults":
                for place, fault in (("/xyz/3/0", "status"), ("/xyz/3/2", "hang"), ("/xyz/3/4", "truncate"), ("/xyz/3/6", "html"), ("/xyz/4/1", "loop"), ("/xyz/4/5", "endless")):
                    proxy.tell("set", prefix=place, fault=fault)
            rows = work / f"{name}.csv"
            online_world.Program(program, work / f"cache {name}").run("bench", scene, "--path", path, "--size", SIZE, "--stats", rows)
            frames = list(csv.DictReader(rows.read_text().splitlines()))
            median, p99[name] = percentiles(frames)
            state = proxy.state()
            print(f"{name}: {len(frames)} frames, median {median:.1f} ms, 99% {p99[name]:.1f} ms; {sum(state['counts'].values())} requests, at most {max(state['counts'].values())} for one URL")
        print(f"99% under faults / healthy: {p99['faults'] / p99['healthy']:.2f}; healthy again / healthy: {p99['healthy again'] / p99['healthy']:.2f}")


def line(program, work, _=None):
    with xyz(work) as files, online_world.FaultServer(proxy=files.url) as proxy:
        scene = online_world.scene_file(work / "scene.toml", [entry_of(proxy)])
        words = ["render", scene, "--camera", VIEW, "--size", SIZE]
        online_world.Program(program, work / "cache whole").run(*words, "-o", work / "final.png")
        final = online_world.colours(work / "final.png")
        proxy.tell("bandwidth", bits=2e6)
        for seconds in (3, 6, 8, 10, 12, 15, 20, 25, 30, 35, 40):
            proxy.tell("reset")
            out = work / f"after_{seconds}.png"
            done = online_world.Program(program, work / f"cache {seconds}").run(*words, "--timeout", seconds, "-o", out, status=None)
            share = float((abs(online_world.colours(out) - final).max(axis=2) <= 2).mean())
            state = proxy.state()
            print(f"{seconds} s: {100 * share:.1f}% of the pixels are final, {state['bytes'] / MEBI:.2f} MiB, {sum(state['counts'].values())} requests, "
                  f"at most {max(state['counts'].values())} for one URL", flush=True)
            if done.returncode == 0:
                break


def resident(pid):
    for text in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if text.startswith("VmRSS:"):
            return int(text.split()[1]) * 1024
    return 0


def flight(program, work, seconds=600, fps=30):
    gpu_mib, disk_mib = 96, 32
    with map_servers.MapServer(work / "wms", {"bluemarble": map_servers.Layer(PICTURE)}, nice=19) as wms:
        scene = online_world.scene_file(work / "scene.toml", [{"source": wms.url, "type": "wms", "layer": "bluemarble"}], light=True)
        path, rows = flight_path(work / "path.csv", seconds), work / "flight.csv"
        cache = work / "cache"
        process = online_world.Program(program, cache).start("bench", scene, "--path", path, "--size", SIZE, "--stats", rows, "--gpu-memory", gpu_mib,
                                                            "--cache-mib", disk_mib, "--fps", fps, "--json")
        memory, disk = [], []
        while process.poll() is None:
            memory.append(resident(process.pid))
            disk.append(sum(file.stat().st_size for file in (cache / "tellurion").glob("online.db*")))
            time.sleep(1)
        out, errors = process.communicate()
        assert process.returncode == 0, errors
        summary = json.loads(out)
        frames = list(csv.DictReader(rows.read_text().splitlines()))
        median, p99 = percentiles(frames)
        seen, late = intervals(frames)
        third = len(memory) // 3
        print(f"{seconds} s, {len(frames)} frames, {len(wms.requests)} requests to the WMS; frame median {median:.1f} ms, 99% {p99:.1f} ms, ratio {p99 / median:.2f}; "
              f"from frame to frame median {seen:.1f} ms, 99% {late:.1f} ms, ratio {late / seen:.2f}")
        print(f"the slowest hundredth, and all in the mean: {slowest(frames)}; update 99% / median {percentiles(frames, 'update_ms')[1] / percentiles(frames, 'update_ms')[0]:.1f}")
        print(f"resident at most {max(memory) / MEBI:.0f} MiB, in the first third {max(memory[:third + 1]) / MEBI:.0f}; GPU at most {summary['gpu_bytes_max'] / MEBI:.0f} of {gpu_mib} MiB; "
              f"decoded at most {summary['cpu_cache_bytes_max'] / MEBI:.0f} MiB; disk at most {max(disk) / MEBI:.1f} of {disk_mib} MiB")


def main():
    if absent := online_world.missing():
        print(f"not installed: {', '.join(absent)}")
        return 77
    program, work, part = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve(), sys.argv[3]
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    {"faults": faults, "line": line, "flight": flight}[part](program, work, *map(int, sys.argv[4:]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
