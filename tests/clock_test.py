#!/usr/bin/env python3
"""Layers that follow the clock, as pictures: the months of the Blue Marble, a WMS with a time dimension, and a flight.

    clock_test.py PROGRAM SOURCE_DIR WORK_DIR

Exit status 77: no OpenGL or no shared data here.
"""
import http.server
import pathlib
import shutil
import struct
import subprocess
import sys
import threading
import urllib.parse
import zlib

SKIPPED = 77
CAMERA = "40,15,9000000,0,-90,0"
TIMES = {"2004-01-01T00:00:00Z": (255, 0, 0), "2004-07-01T00:00:00Z": (0, 0, 255)}
CAPABILITIES = """<?xml version="1.0"?>
<WMS_Capabilities version="1.3.0" xmlns="http://www.opengis.net/wms" xmlns:xlink="http://www.w3.org/1999/xlink">
<Service><Name>WMS</Name><Title>Two colours</Title></Service>
<Capability><Request><GetMap><Format>image/png</Format></GetMap></Request>
<Layer><Title>All</Title><Layer><Name>colour</Name><Title>A colour</Title><CRS>CRS:84</CRS>
<EX_GeographicBoundingBox><westBoundLongitude>-180</westBoundLongitude><eastBoundLongitude>180</eastBoundLongitude>
<southBoundLatitude>-90</southBoundLatitude><northBoundLatitude>90</northBoundLatitude></EX_GeographicBoundingBox>
<Dimension name="time" units="ISO8601" default="2004-07-01T00:00:00Z">{times}</Dimension>
<MinScaleDenominator>20000000</MinScaleDenominator></Layer></Layer></Capability></WMS_Capabilities>"""


def png(width, height, colour):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    rows = (b"\0" + bytes(colour) * width) * height
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


class TwoColours(http.server.BaseHTTPRequestHandler):
    asked = set()

    def do_GET(self):
        query = {k.upper(): v for k, v in urllib.parse.parse_qsl(urllib.parse.urlparse(self.path).query)}
        if query.get("REQUEST") == "GetMap":
            time = query.get("TIME", "2004-07-01T00:00:00Z")
            self.asked.add(time)
            body = png(int(query["WIDTH"]), int(query["HEIGHT"]), TIMES[time])
            kind = "image/png"
        else:
            body = CAPABILITIES.format(times=",".join(TIMES)).encode()
            kind = "text/xml"
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *arguments):
        pass


class Pictures:
    def __init__(self, program, work):
        self.program, self.work = program, work

    def run(self, *arguments):
        done = subprocess.run([self.program, *map(str, arguments)], capture_output=True, text=True)
        if done.returncode == 1 and "OpenGL" in done.stderr:
            print(done.stderr)
            sys.exit(SKIPPED)
        assert done.returncode == 0, done.stderr

    def render(self, name, scene, *more):
        (self.work / f"{name}.toml").write_text("[light]\nenabled = false\n" + scene)
        self.run("render", self.work / f"{name}.toml", "--camera", CAMERA, "--size", "200x150", "--cache-mib", 0, "-o",
                 self.work / f"{name}.png", *more)
        return (self.work / f"{name}.png").read_bytes()


def months(pictures, folder):
    def file(month):
        return folder / f"bluemarble_2004{month}_2048x1024.jpg"

    times = ", ".join(f'["2004-{m}-01T00:00:00Z", "{file(m)}"]' for m in ("01", "04", "07", "10"))
    series = f'[[imagery]]\ntype = "live"\ntimes = [{times}]\n'
    alone = {m: pictures.render(f"alone{m}", f'[[imagery]]\ntype = "live"\nsource = "{file(m)}"\n') for m in ("01", "07", "10")}
    assert alone["01"] != alone["07"]
    assert pictures.render("january", series, "--time", "2004-03-31") == alone["01"]
    assert pictures.render("july", series, "--time", "2004-07-01T00:00:00Z") == alone["07"]
    assert pictures.render("last", series) == alone["10"], "without a time it is the last"
    assert pictures.render("start", '[clock]\nstart = "2004-08"\n' + series) == alone["07"]
    # A flight at a quarter of a year a second: January, April, July.
    (pictures.work / "path.csv").write_text("seconds,lat,lon,height_m,heading,pitch,roll\n" + "".join(f"{t},{CAMERA}\n" for t in (0, 2)))
    (pictures.work / "flight.toml").write_text('[light]\nenabled = false\n[clock]\nstart = "2004-01-01"\nrate = 7862400\n' + series)
    pictures.run("fly", pictures.work / "flight.toml", "--path", pictures.work / "path.csv", "--fps", 1, "--size", "200x150", "-o",
                 pictures.work / "frames")
    frames = [f.read_bytes() for f in sorted((pictures.work / "frames").glob("*.png"))]
    assert len(frames) == 3 and frames[0] == alone["01"]
    assert frames[2] == alone["07"] and frames[1] not in (alone["01"], alone["07"]), "a step each second"


def server(pictures):
    service = http.server.ThreadingHTTPServer(("127.0.0.1", 0), TwoColours)
    threading.Thread(target=service.serve_forever, daemon=True).start()
    layer = f'[[imagery]]\nsource = "http://127.0.0.1:{service.server_port}/wms"\ntype = "wms"\nlayer = "colour"\nmax_level = 2\n'
    winter = pictures.render("winter", layer + 'time = "clock"\n', "--time", "2004-05-01")
    assert TwoColours.asked <= {"2004-01-01T00:00:00Z", "2004-07-01T00:00:00Z"}
    TwoColours.asked.clear()
    assert pictures.render("fixed", layer + 'time = "2004-01-01T00:00:00Z"\n') == winter
    assert TwoColours.asked == {"2004-01-01T00:00:00Z"}
    summer = pictures.render("summer", layer + 'time = "clock"\n', "--time", "2005-05-01")
    assert pictures.render("usual", layer) == pictures.render("usual2", layer + 'time = "2004-07-01T00:00:00Z"\n') == summer != winter
    service.shutdown()


def main():
    program, source, work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    pictures = Pictures(program, work)
    server(pictures)
    folder = (source / "../shared/data/earth/bluemarble_monthly").resolve()
    if not folder.exists():
        print("no shared data: the months are not looked at")
        return SKIPPED
    months(pictures, folder)
    print("the months, a server with times and a flight show what the clock says")
    return 0


if __name__ == "__main__":
    sys.exit(main())
