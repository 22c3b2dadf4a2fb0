"""Map servers on 127.0.0.1 for tests, out of the project's own data: MapServer (WMS), MapProxy (WMTS, TMS) before it, and
nginx (XYZ and World Wind trees). Each runs on a free port and ends with the object that started it.

    with MapServer(work, {"bluemarble": Layer(picture)}) as wms:
        wms.url                                # http://127.0.0.1:PORT/wms
        with MapProxy(work, wms.url, ["bluemarble"]) as proxy:
            proxy.wmts_url, proxy.wmts_rest_url, proxy.tms_url
    with FileServer(folder) as files:          # nginx
        files.url

`missing()` names the Debian packages that are not there: skip the test then.
"""
import dataclasses
import http.server
import os
import pathlib
import shutil
import socket
import subprocess
import threading
import time
import urllib.error
import urllib.request

MAPSERV = "/usr/bin/mapserv"
NGINX = "/usr/sbin/nginx"
# MapProxy's modules are those of the system's Python, whichever runs this.
SYSTEM_PYTHON = "/usr/bin/python3"
START_SECONDS = 60


def missing():
    """Packages that these servers need and the machine has not."""
    found = {"cgi-mapserver": os.access(MAPSERV, os.X_OK), "nginx": os.access(NGINX, os.X_OK),
             "mapproxy": shutil.which("mapproxy-util") is not None}
    return [package for package, there in found.items() if not there]


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wait_for(url, alive):
    """Until the URL is answered, whatever the answer."""
    end = time.monotonic() + START_SECONDS
    while time.monotonic() < end:
        if not alive():
            raise RuntimeError(f"the server of {url} ended by itself")
        try:
            urllib.request.urlopen(url, timeout=5).close()
            return
        except urllib.error.HTTPError:
            return
        except OSError:
            time.sleep(0.1)
    raise RuntimeError(f"{url} does not answer")


@dataclasses.dataclass
class Layer:
    """A raster that GDAL reads, as a layer of MapServer."""
    path: pathlib.Path
    extent: tuple = (-180, -90, 180, 90)
    elevation: bool = False
    resample: str = ""  # NEAREST, BILINEAR, AVERAGE; empty: as pictures or heights need it
    epsg: int = 4326
    times: str = ""  # WMS_TIMEEXTENT: then `path` is an index of rasters with the fields location and time (online_world.make_time_index)
    default_time: str = ""


def map_file(layers, url):
    """MapServer's configuration: WMS of the layers; elevation also as 32-bit GeoTIFF and BIL."""
    text = f"""MAP
  NAME "tellurion_test"
  SIZE 512 512
  MAXSIZE 4096
  EXTENT -180 -90 180 90
  UNITS DD
  PROJECTION "init=epsg:4326" END
  CONFIG "ON_MISSING_DATA" "IGNORE"
  OUTPUTFORMAT NAME "png" DRIVER "AGG/PNG" MIMETYPE "image/png" IMAGEMODE RGBA TRANSPARENT ON END
  OUTPUTFORMAT NAME "jpeg" DRIVER "AGG/JPEG" MIMETYPE "image/jpeg" IMAGEMODE RGB FORMATOPTION "QUALITY=95" END
  OUTPUTFORMAT NAME "tiff" DRIVER "GDAL/GTiff" MIMETYPE "image/tiff" IMAGEMODE FLOAT32 FORMATOPTION "NULLVALUE=-32768" END
  OUTPUTFORMAT NAME "bil16" DRIVER "GDAL/EHdr" MIMETYPE "application/bil16" IMAGEMODE INT16 EXTENSION "bil" END
  OUTPUTFORMAT NAME "tiff16" DRIVER "GDAL/GTiff" MIMETYPE "image/tiff16" IMAGEMODE INT16 END
  WEB METADATA
    "wms_title" "Tellurion test server"
    "wms_onlineresource" "{url}?"
    "wms_srs" "EPSG:4326 EPSG:3857 CRS:84"
    "wms_enable_request" "*"
    "wms_getmap_formatlist" "image/png,image/jpeg,image/tiff,application/bil16,image/tiff16"
    "wms_feature_info_mime_type" "text/plain"
  END END
"""
    for name, layer in layers.items():
        west, south, east, north = layer.extent
        # Pictures mostly shrink, and what shrinks has to be averaged; heights are wanted between samples too.
        processing = f'    PROCESSING "RESAMPLE={layer.resample or ("BILINEAR" if layer.elevation else "AVERAGE")}"\n'
        data = f'    DATA "{layer.path.resolve()}"'
        times = ""
        if layer.times:
            data = f'    TILEINDEX "{layer.path.resolve()}"\n    TILEITEM "location"'
            times = f"""      "wms_timeextent" "{layer.times}"
      "wms_timeitem" "time"
      "wms_timedefault" "{layer.default_time}"
"""
        text += f"""  LAYER
    NAME "{name}"
    TYPE RASTER
    STATUS ON
{data}
{processing}    PROJECTION "init=epsg:{layer.epsg}" END
    METADATA
      "wms_title" "{name} of the tests"
      "wms_extent" "{west} {south} {east} {north}"
      "wms_attribution_title" "Tellurion's tests"
{times}    END
  END
"""
    return text + "END\n"


class MapServer:
    """MapServer as CGI behind an HTTP server of this process. `nice`: by which it leaves the cores to the program under test, as
    a server on another machine does."""

    def __init__(self, work, layers, nice=0):
        self.nice = nice
        self.port = free_port()
        self.url = f"http://127.0.0.1:{self.port}/wms"
        self.requests = []  # query strings, in the order they came
        work = pathlib.Path(work)
        work.mkdir(parents=True, exist_ok=True)
        self.map_file = work / "mapserver.map"
        self.map_file.write_text(map_file(layers, self.url))
        self.configuration = work / "mapserver.conf"  # MapServer 8 runs with none of the machine's
        self.configuration.write_text('CONFIG\n  ENV\n    MS_MAP_PATTERN "."\n  END\nEND\n')
        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", self.port), self._handler())
        self.thread = threading.Thread(target=self._serve, daemon=True)

    def _serve(self):
        # On Linux a thread's own; those that it starts, and their processes, inherit it.
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), min(19, os.getpriority(os.PRIO_PROCESS, 0) + self.nice))
        self.server.serve_forever()

    def _handler(self):
        outer = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                path, _, query = self.path.partition("?")
                if path != "/wms":
                    self.send_error(404)
                    return
                outer.requests.append(query)
                environment = {"REQUEST_METHOD": "GET", "QUERY_STRING": query, "MS_MAPFILE": str(outer.map_file),
                               "MAPSERVER_CONFIG_FILE": str(outer.configuration),
                               "SERVER_NAME": "127.0.0.1", "SERVER_PORT": str(outer.port), "SCRIPT_NAME": "/wms",
                               "PATH": os.environ["PATH"]}
                done = subprocess.run([MAPSERV], env=environment, capture_output=True)
                head, _, body = done.stdout.partition(b"\r\n\r\n")
                self.send_response(200)
                for line in head.decode("latin-1").splitlines():
                    key, _, value = line.partition(": ")
                    self.send_header(key, value)
                self.send_header("Content-Length", str(len(body)))
                try:
                    self.end_headers()
                    self.wfile.write(body)
                except OSError:
                    self.close_connection = True  # who asked has let go of it

            def log_message(self, *_):
                pass

        return Handler

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()
        self.thread.join()


class Process:
    """A server in a process of its own, ended with the object."""

    def __init__(self, command, url, log):
        self.command, self.url, self.log = command, url, log
        self.process = None

    def start(self):
        with open(self.log, "wb") as log:
            self.process = subprocess.Popen(self.command, stdout=log, stderr=log)
        try:
            wait_for(self.url, lambda: self.process.poll() is None)
        except RuntimeError as error:
            self.stop()
            raise RuntimeError(f"{error}\n{pathlib.Path(self.log).read_text(errors='replace')[-2000:]}") from None

    def stop(self):
        self.process.terminate()
        try:
            self.process.wait(60)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


MAPPROXY = """services:
  wmts: {{restful: true, kvp: true}}
  tms: {{use_grid_names: true}}
globals:
  cache: {{base_dir: '{cache}', lock_dir: '{cache}/locks', tile_lock_dir: '{cache}/tile_locks'}}
  image: {{resampling_method: bilinear, paletted: false}}
grids:
  geodetic: {{base: GLOBAL_GEODETIC, origin: ul, num_levels: 12}}
  geodetic_south: {{base: GLOBAL_GEODETIC, origin: ll, num_levels: 12}}
  mercator: {{base: GLOBAL_WEBMERCATOR, num_levels: 12}}
"""


class MapProxy:
    """MapProxy's tiles of layers of a WMS, in EPSG:4326 and EPSG:3857."""

    def __init__(self, work, wms_url, layers):
        work = pathlib.Path(work)
        work.mkdir(parents=True, exist_ok=True)
        self.port = free_port()
        base = f"http://127.0.0.1:{self.port}"
        self.wmts_url = f"{base}/service"
        self.wmts_rest_url = f"{base}/wmts/1.0.0/WMTSCapabilities.xml"
        self.tms_url = f"{base}/tms/1.0.0/"
        text = MAPPROXY.format(cache=(work / "mapproxy_cache").resolve())
        text += "layers:\n" + "".join(
            f"  - {{name: {name}, title: {name} of the proxy, sources: [{name}_cache]}}\n" for name in layers)
        text += "caches:\n" + "".join(
            f"  {name}_cache: {{grids: [geodetic, geodetic_south, mercator], sources: [{name}_wms], format: image/png, image: {{transparent: true}}, "
            # Else two grids of one reference share a folder, and each is given the other's tiles.
            f"cache: {{type: file, use_grid_names: true}}}}\n"
            for name in layers)
        text += "sources:\n" + "".join(
            f"  {name}_wms: {{type: wms, supported_srs: ['EPSG:4326', 'EPSG:3857'], "
            f"req: {{url: '{wms_url}', layers: {name}, transparent: true}}}}\n" for name in layers)
        configuration = work / "mapproxy.yaml"
        configuration.write_text(text)
        serve = ("import sys; from wsgiref.simple_server import make_server, WSGIServer, WSGIRequestHandler; "
                 "from socketserver import ThreadingMixIn; from mapproxy.wsgiapp import make_wsgi_app; "
                 "Server = type('Server', (ThreadingMixIn, WSGIServer), {'daemon_threads': True}); "
                 "Quiet = type('Quiet', (WSGIRequestHandler,), {'log_message': lambda *_: None}); "
                 "make_server('127.0.0.1', int(sys.argv[2]), make_wsgi_app(sys.argv[1]), Server, Quiet).serve_forever()")
        self.process = Process([SYSTEM_PYTHON, "-c", serve, str(configuration), str(self.port)], self.wmts_rest_url,
                               work / "mapproxy.log")

    def __enter__(self):
        self.process.start()
        return self

    def __exit__(self, *_):
        self.process.stop()


NGINX_CONF = """worker_processes 1;
daemon off;
master_process off;
pid {work}/nginx.pid;
error_log {work}/nginx.error.log;
events {{ worker_connections 256; }}
http {{
  access_log off;
  types {{ image/png png; image/jpeg jpg; image/tiff tif; text/xml xml; application/octet-stream bil; }}
  client_body_temp_path {work}/nginx_body; proxy_temp_path {work}/nginx_proxy; fastcgi_temp_path {work}/nginx_fastcgi;
  uwsgi_temp_path {work}/nginx_uwsgi; scgi_temp_path {work}/nginx_scgi;
  server {{
    listen 127.0.0.1:{port};
    root {root};
    # World Wind: ?T=data set&L=level&X=column&Y=row, out of folders L/Y/X.png.
    location = /worldwind {{ rewrite ^ /$arg_t/$arg_l/$arg_y/$arg_x.png last; }}
  }}
}}
"""


class FileServer:
    """nginx over a folder; /worldwind?T=T&L=L&X=X&Y=Y gives T/L/Y/X.png of it."""

    def __init__(self, folder, work):
        work = pathlib.Path(work).resolve()
        work.mkdir(parents=True, exist_ok=True)
        port = free_port()
        self.url = f"http://127.0.0.1:{port}"
        configuration = work / "nginx.conf"
        configuration.write_text(NGINX_CONF.format(work=work, port=port, root=pathlib.Path(folder).resolve()))
        self.process = Process([NGINX, "-p", str(work), "-e", str(work / "nginx.error.log"), "-c", str(configuration)],
                               self.url, work / "nginx.log")

    def __enter__(self):
        self.process.start()
        return self

    def __exit__(self, *_):
        self.process.stop()
