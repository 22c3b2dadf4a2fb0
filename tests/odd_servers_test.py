#!/usr/bin/env python3
"""Map servers that are odd but allowed: GIF alone, raw heights of either byte order, maps that are only given whole or at one size. The server is
this file's own and refuses everything else, as such servers do; what it draws is GDAL's.

    odd_servers_test.py PROGRAM SOURCE_DIR WORK_DIR

Exit status 77 (skipped) where a package or the shared data are missing.
"""
import http.server
import json
import threading
import urllib.parse

import online_world
from online_world import numpy

SIZE = "320x240"
CAMERA = "20,180,9000000,0,-90,0"
EVEREST = "27.75,86.5,60000,0,-90,0"
PICTURE_BOX = (-180.0, -90.0, 180.0, 90.0)
CAPABILITIES = """<?xml version="1.0"?>
<WMS_Capabilities version="1.3.0" xmlns="http://www.opengis.net/wms"><Service><Name>WMS</Name><Title>Odd</Title></Service>
<Capability><Request><GetMap><Format>{format}</Format></GetMap></Request><Layer><Title>All</Title>
<Layer {attributes}><Name>odd</Name><Title>Odd</Title><CRS>CRS:84</CRS>
<EX_GeographicBoundingBox><westBoundLongitude>{box[0]}</westBoundLongitude><eastBoundLongitude>{box[2]}</eastBoundLongitude>
<southBoundLatitude>{box[1]}</southBoundLatitude><northBoundLatitude>{box[3]}</northBoundLatitude></EX_GeographicBoundingBox>
</Layer></Layer></Capability></WMS_Capabilities>"""


class Odd:
    """`whole`, `size`: refuses other boxes and sizes. `raw`: a NumPy type that heights are given as."""

    def __init__(self, raster, form, box=PICTURE_BOX, whole=False, size=None, raw=None):
        from osgeo import gdal
        self.gdal, self.raster, self.format, self.box, self.whole, self.size, self.raw = gdal, raster, form, box, whole, size, raw
        self.maps, self.refused = 0, 0
        outer = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                query = {key.upper(): value for key, value in urllib.parse.parse_qsl(urllib.parse.urlparse(self.path).query)}
                kind, body = outer.answer(query)
                self.send_response(200)
                self.send_header("Content-Type", kind)
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, *_):
                pass

        self.lock = threading.Lock()
        self.service = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self.service.server_port}/wms"
        threading.Thread(target=self.service.serve_forever, daemon=True).start()

    def answer(self, query):
        if query.get("REQUEST") != "GetMap":
            attributes = "noSubsets='1' " if self.whole else ""
            attributes += f"fixedWidth='{self.size[0]}' fixedHeight='{self.size[1]}'" if self.size else ""
            return "text/xml", CAPABILITIES.format(format=self.format, attributes=attributes, box=self.box).encode()
        box = tuple(map(float, query["BBOX"].split(",")))
        size = int(query["WIDTH"]), int(query["HEIGHT"])
        fits = query["FORMAT"] == self.format and (not self.whole or box == self.box) and self.size in (None, size)
        with self.lock:
            self.maps += fits
            self.refused += not fits
            if not fits:
                return "text/xml", b"<ServiceExceptionReport><ServiceException>no such map here</ServiceException></ServiceExceptionReport>"
            return self.format, self.drawn(box, size)

    def drawn(self, box, size):
        gdal = self.gdal
        mode = "bilinear" if self.raw else "average"
        made = gdal.Warp("", str(self.raster), format="MEM", srcSRS="EPSG:4326", outputBounds=box, width=size[0], height=size[1], resampleAlg=mode,
                         outputType=gdal.GDT_Float32 if self.raw else gdal.GDT_Byte, dstNodata=-32768 if self.raw else None)
        if self.raw:
            return numpy.rint(made.ReadAsArray()).astype(self.raw).tobytes()
        name = f"/vsimem/{id(made)}"
        driver = {"image/gif": "GIF", "image/png": "PNG"}[self.format]
        if driver == "GIF":
            paletted = gdal.GetDriverByName("MEM").Create("", *size, 1)
            table = gdal.ColorTable()
            gdal.ComputeMedianCutPCT(made.GetRasterBand(1), made.GetRasterBand(2), made.GetRasterBand(3), 255, table)
            gdal.DitherRGB2PCT(made.GetRasterBand(1), made.GetRasterBand(2), made.GetRasterBand(3), paletted.GetRasterBand(1), table)
            paletted.GetRasterBand(1).SetColorTable(table)
            made = paletted
        gdal.GetDriverByName(driver).CreateCopy(name, made)
        file = gdal.VSIFOpenL(name, "rb")
        body = gdal.VSIFReadL(1, gdal.VSIStatL(name).size, file)
        gdal.VSIFCloseL(file)
        gdal.GetDriverByName(driver).Delete(name)
        return bytes(body)

    def stop(self):
        self.service.shutdown()
        self.service.server_close()


class OddServers(online_world.ServerTest):
    def setUp(self):
        super().setUp()
        self.picture = self.source / "data/earth/bluemarble_may2004_2048x1024.jpg"
        self.heights = self.source / "data/earth/srtm3_everest_N27E086.tif"

    def server(self, *arguments, **named):
        odd = Odd(*arguments, **named)
        self.addCleanup(odd.stop)
        return odd

    def render(self, name, *more, camera=CAMERA, **layers):
        out = self.work / f"{name}.png"
        scene = online_world.scene_file(self.work / f"{name}.toml", **layers)
        self.run_it.run("render", scene, "--camera", camera, "--size", SIZE, "-o", out, *more)
        return online_world.colours(out)

    def local(self):
        return self.render("local", imagery=[{"source": str(self.picture), "type": "live"}])

    def miss(self, odd):
        served = self.render("served", imagery=[{"source": odd.url, "type": "wms", "layer": "odd"}])
        miss = float(abs(served - self.local()).mean())
        print(f"{self._testMethodName}: {miss:.2f} of 255 off in the mean, {odd.maps} maps, {odd.refused} refused")
        self.assertEqual(odd.refused, 0)
        self.assertGreater(odd.maps, 0)
        return miss

    def test_gif_alone(self):
        """256 colours an image, dithered."""
        self.assertLess(self.miss(self.server(self.picture, "image/gif")), 1.5)

    def test_a_map_that_is_only_given_whole(self):
        odd = self.server(self.picture, "image/png", whole=True, size=(2048, 1024))
        self.assertLess(self.miss(odd), 0.2)
        self.assertEqual(odd.maps, 1)
        told = self.run_it.run("sources", odd.url).stdout
        self.assertIn("one map of all of it, no parts, 2048 x 1024 pixels", told)
        offers = json.loads(self.run_it.run("sources", odd.url, "--json").stdout)["layers"][-1]
        self.assertEqual((offers["only_whole"], offers["fixed_width"], offers["fixed_height"]), (True, 2048, 1024))

    def test_a_whole_map_of_any_size(self):
        self.assertLess(self.miss(self.server(self.picture, "image/png", whole=True)), 1.5)

    def test_maps_of_one_size(self):
        self.assertLess(self.miss(self.server(self.picture, "image/png", size=(600, 400))), 1.5)

    def test_raw_heights_of_either_byte_order(self):
        box = (86.0, 27.0, 87.0, 28.0)
        depth = {}
        for name, form, kind, order in (("little", "application/bil16", "<i2", None), ("big", "image/bil", ">i2", "big"), ("float", "application/bil32", ">f4", "big")):
            odd = self.server(self.heights, form, box=box, raw=kind)
            entry = {"source": odd.url, "type": "wms", "layer": "odd", "nodata": -32768} | ({"byte_order": order} if order else {})
            path = self.work / f"{name}.tif"
            self.render(name, "--depth", path, "--tolerance", 4, camera=EVEREST, elevation=[entry])
            self.assertEqual(odd.refused, 0)
            depth[name] = online_world.depths(path)
        self.assertGreater(numpy.ptp(depth["little"]), 3000)
        self.assertEqual(abs(depth["big"] - depth["little"]).max(), 0)
        self.assertLess(abs(depth["float"] - depth["little"]).max(), 1e-3)


if __name__ == "__main__":
    online_world.run_tests(OddServers, [] if online_world.gdal else ["python3-gdal"], shared=True)
