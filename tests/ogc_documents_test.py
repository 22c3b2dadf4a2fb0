#!/usr/bin/env python3
"""What `tellurion sources` reads in real capabilities documents, against a parser that is not ours.

    ogc_documents_test.py PROGRAM SHARED_DATA_DIR

Python's ElementTree reads the same documents, and the inheritance rules of the standards are written here a second time. Where OWSLib (Debian's
python3-owslib) is installed, what it finds is compared too; what GDAL finds is compared in src/raster/service_documents_test.cpp.
"""
import json
import math
import pathlib
import re
import subprocess
import sys
import unittest
import xml.etree.ElementTree

try:
    from owslib.wms import WebMapService
    from owslib.wmts import WebMapTileService
except ImportError:
    WebMapService = WebMapTileService = None

SKIPPED = 77
# Of each list of a layer so many are named.
MOST_LISTED = 64


def local(element):
    return element.tag.rpartition("}")[2]


def children(element, *names):
    return [child for child in element if local(child) in names]


def text(element, *path):
    for name in path:
        found = children(element, name)
        if not found:
            return ""
        element = found[0]
    return (element.text or "").strip()


def attribute(element, name):
    return next((value for key, value in element.attrib.items() if key.rpartition("}")[2] == name), "")


def read(path):
    data = path.read_bytes()
    if data[:4] == b"\xff\xfe<?":  # a mark that is not true
        data = data[2:]
    return xml.etree.ElementTree.fromstring(data)


def reference(name):
    """The commonest aliases only."""
    name = name.upper()
    urn = re.fullmatch(r"URN:OGC:DEF:CRS:(\w+):[^:]*(?::[^:]*)?:(\w+)", name) or re.fullmatch(r"URN:OGC:DEF:CRS:(\w+)::(\w+)", name)
    if urn:
        name = f"{urn[1]}:{urn[2]}"
    name = {"OGC:CRS84": "CRS:84"}.get(name, name)
    authority, _, code = name.partition(":")
    return "EPSG:3857" if code in ("900913", "3857", "3785", "102100", "102113", "3587", "41001") else name


def one_line(words):
    return " ".join(words.split())


def number(words):
    try:
        return float(words) if math.isfinite(float(words)) else None
    except ValueError:
        return None


def scales_of(element, outer):
    """(smallest, largest) denominator. A limit of 0, of infinity, or one that is no number, is none."""
    told = [text(element, "MinScaleDenominator"), text(element, "MaxScaleDenominator")]
    factor = 1.0
    for hint in children(element, "ScaleHint"):
        told, factor = [hint.get("min", ""), hint.get("max", "")], 1 / (math.sqrt(2) * 0.00028)
    read = [(number(words) or 0) * factor for words in told]
    return tuple((read[i] if read[i] > 0 else None) if told[i] else outer[i] for i in (0, 1))


def map_formats(root):
    request = children(children(root, "Capability")[0], "Request")[0]
    return [word for format in children(children(request, "GetMap", "Map")[0], "Format")
            for word in ([(format.text or "").strip()] if (format.text or "").strip() else []) + [local(child) for child in format]]


def wms_layers(root):
    """What is compared of every layer in order."""
    found = []
    formats = map_formats(root)

    def walk(element, references, styles, box, time, scales=(None, None), attribution=""):
        references = references | {reference(word) for child in children(element, "CRS", "SRS") for word in (child.text or "").split()}
        styles = styles + [name for name in (text(style, "Name") for style in children(element, "Style")) if name and name not in styles]
        geographic = children(element, "EX_GeographicBoundingBox")
        older = children(element, "LatLonBoundingBox")
        if geographic:
            box = [float(text(geographic[0], side + "Bound" + kind)) for side, kind in
                   (("west", "Longitude"), ("south", "Latitude"), ("east", "Longitude"), ("north", "Latitude"))]
        elif older:
            box = [float(older[0].get(key)) for key in ("minx", "miny", "maxx", "maxy")]
        for child in children(element, "Dimension", "Extent"):
            if (child.get("name") or "").lower() == "time" and ((child.text or "").strip() or child.get("default")):
                time = (child.get("default") or "", (child.text or "").strip())
        scales = scales_of(element, scales)
        attribution = one_line(text(element, "Attribution", "Title")) or attribution
        found.append((text(element, "Name"), text(element, "Title"), references, set(styles), box, time, formats, scales, attribution))
        for child in children(element, "Layer"):
            walk(child, references, styles, box, time, scales, attribution)

    for layer in children(children(root, "Capability")[0], "Layer"):
        walk(layer, set(), [], None, None)
    return found


def wmts_layers(root):
    contents = children(root, "Contents")[0]
    sets = {text(s, "Identifier"): reference(text(s, "SupportedCRS")) for s in children(contents, "TileMatrixSet")}
    found = []
    attribution = one_line(text(root, "ServiceProvider", "ProviderName"))
    for layer in children(contents, "Layer"):
        boxes = children(layer, "WGS84BoundingBox")
        box = [float(word) for corner in ("LowerCorner", "UpperCorner") for word in text(boxes[0], corner).split()] if boxes else None
        links = [(s.text or "").strip() for link in children(layer, "TileMatrixSetLink") for s in children(link, "TileMatrixSet")]
        times = [(text(d, "Default"), ",".join((v.text or "").strip() for v in children(d, "Value")))
                 for d in children(layer, "Dimension") if text(d, "Identifier").lower() == "time"]
        found.append((text(layer, "Identifier"), text(layer, "Title"), {sets[link] for link in links if link in sets},
                      {text(style, "Identifier") for style in children(layer, "Style")}, box, times[0] if times else None,
                      [(format.text or "").strip() for format in children(layer, "Format")], (None, None), attribution))
    return found


class Documents(unittest.TestCase):
    program = data = None

    def offers(self, path):
        done = subprocess.run([self.program, "sources", path, "--json"], capture_output=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def compare(self, path, expected):
        told = self.offers(path)["layers"]
        self.assertEqual(len(told), len(expected))
        for layer, (name, title, references, styles, box, time, formats, scales, attribution) in zip(told, expected):
            with self.subTest(document=path.name, layer=name or title):
                self.assertEqual(layer["name"], name)
                self.assertEqual(layer["title"], title)
                self.assertEqual(layer["crs_count"], len(references))
                self.assertLessEqual(set(layer["crs"]), references)
                self.assertEqual(set(layer["styles"]), styles)
                self.assertEqual(layer.get("bounds"), box)
                self.assertEqual(layer["default_time"], time[0] if time else "")
                self.assertEqual(bool(layer["times"]), bool(time))
                for end in filter(None, re.split(r"[,/]\s*", time[1])[:1] if time and time[1] else []):
                    self.assertIn(end.strip(), layer["times"])

                self.assertEqual(layer["formats"], formats[:MOST_LISTED])
                self.assertEqual(layer["attribution"], attribution)
                self.compare_scales(layer, scales)

    def compare_scales(self, layer, scales):
        for key, expected in zip(("min_scale_denominator", "max_scale_denominator"), scales):
            self.assertEqual(key in layer, expected is not None, key)
            if expected is not None:
                self.assertAlmostEqual(layer[key] / expected, 1, places=9)

    @unittest.skipUnless(WebMapService, "OWSLib is not installed")
    def test_maps_as_owslib_reads_them(self):
        compared, unread = 0, []
        for path in sorted((self.data / "ogc/wms").glob("*.xml")):
            offers = self.offers(path)
            try:
                theirs = WebMapService("http://localhost/", version="1.3.0" if offers["version"] == "1.3.0" else "1.1.1", xml=path.read_bytes())
                formats = [operation for operation in theirs.operations if operation.name == "GetMap"][0].formatOptions
            except Exception as failure:  # noqa: BLE001: whatever it does not read
                unread.append(f"{path.name}: {failure}")
                continue
            by_name = {}
            for layer in offers["layers"]:
                by_name.setdefault(layer["name"], []).append(layer)
            for name, layer in theirs.contents.items():
                if len(by_name.get(name, [])) != 1:
                    continue  # it numbers headings, and of equal names keeps the last
                ours = by_name[name][0]
                with self.subTest(document=path.name, layer=name):
                    self.assertEqual(one_line(ours["title"]), one_line(layer.title or ""))
                    references = {reference(crs) for crs in layer.crsOptions or []}
                    self.assertLessEqual(references, set(ours["crs"]) if ours["crs_count"] <= MOST_LISTED else references | set(ours["crs"]))
                    self.assertEqual(ours["crs_count"], len(references))
                    self.assertLessEqual(set(layer.styles), set(ours["styles"]) | {None, ""})
                    self.assertEqual(ours["formats"], formats[:MOST_LISTED])
                    if layer.boundingBoxWGS84:
                        self.assertEqual(ours.get("bounds"), list(layer.boundingBoxWGS84))
                    if layer.timepositions:
                        self.assertEqual(ours["default_time"], layer.defaulttimeposition or "")
                    title = one_line((getattr(layer, "attribution", None) or {}).get("title") or "")
                    if title:
                        self.assertEqual(ours["attribution"], title)
                compared += 1
        print(f"{compared} layers compared; not read by OWSLib: {unread}", file=sys.stderr)
        self.assertGreater(compared, 500)

    @unittest.skipUnless(WebMapTileService, "OWSLib is not installed")
    def test_tiles_as_owslib_reads_them(self):
        compared, unread = 0, []
        for path in sorted((self.data / "ogc/wmts").glob("*.xml")):
            offers = self.offers(path)
            try:
                theirs = WebMapTileService("http://localhost/", xml=path.read_bytes())
            except Exception as failure:  # noqa: BLE001: whatever it does not read
                unread.append(f"{path.name}: {failure}")
                continue
            for ours in offers["layers"]:
                layer = theirs.contents.get(ours["name"])
                with self.subTest(document=path.name, layer=ours["name"]):
                    self.assertIsNotNone(layer)
                    self.assertEqual(one_line(ours["title"]), one_line(layer.title or ""))
                    self.assertEqual(ours["formats"], layer.formats[:MOST_LISTED])
                    self.assertEqual(set(ours["styles"]), set(layer.styles))
                    self.assertEqual(ours["matrix_sets"], list(layer.tilematrixsetlinks)[:MOST_LISTED])
                    self.assertEqual(set(ours["crs"]), {reference(theirs.tilematrixsets[link].crs) for link in layer.tilematrixsetlinks if link in theirs.tilematrixsets})
                    if layer.boundingBoxWGS84:
                        self.assertEqual(ours.get("bounds"), list(layer.boundingBoxWGS84))
                    if hasattr(theirs, "provider"):
                        self.assertEqual(ours["attribution"], one_line(theirs.provider.name or ""))
                compared += 1
        print(f"{compared} layers compared; not read by OWSLib: {unread}", file=sys.stderr)
        self.assertGreater(compared, 50)

    def counted(self):
        """Layers of each document, headings included, as the data's README states them."""
        readme = (self.data / "README.md").read_text(encoding="utf-8")
        return {row[1]: int(row[2]) for row in re.finditer(r"^\| `(ogc/wmt?s/\S+)` .*; (\d+) layers", readme, re.M)}

    def test_wms(self):
        documents = sorted((self.data / "ogc/wms").glob("*.xml"))
        self.assertGreater(len(documents), 20)
        for path in documents:
            self.compare(path, wms_layers(read(path)))

    def test_wmts(self):
        documents = sorted((self.data / "ogc/wmts").glob("*.xml"))
        self.assertGreater(len(documents), 8)
        for path in documents:
            self.compare(path, wmts_layers(read(path)))

    def test_counts(self):
        counts = self.counted()
        self.assertGreater(len(counts), 30)
        for name, count in counts.items():
            self.assertEqual(len(self.offers(self.data / name)["layers"]), count, name)


if __name__ == "__main__":
    Documents.program = pathlib.Path(sys.argv[1])
    Documents.data = pathlib.Path(sys.argv[2])
    if not (Documents.data / "ogc").exists():
        print("no shared data")
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])
