#!/usr/bin/env python3
"""What `tellurion sources` reads in real capabilities documents, against a parser that is not ours.

    ogc_documents_test.py PROGRAM SHARED_DATA_DIR

Python's ElementTree reads the same documents, and the inheritance rules of the standards are written here a second time.
"""
import json
import pathlib
import re
import subprocess
import sys
import unittest
import xml.etree.ElementTree

SKIPPED = 77


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


def wms_layers(root):
    """(name, title, references, styles, box, time) of every layer in order."""
    found = []

    def walk(element, references, styles, box, time):
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
        found.append((text(element, "Name"), text(element, "Title"), references, set(styles), box, time))
        for child in children(element, "Layer"):
            walk(child, references, styles, box, time)

    for layer in children(children(root, "Capability")[0], "Layer"):
        walk(layer, set(), [], None, None)
    return found


def wmts_layers(root):
    contents = children(root, "Contents")[0]
    sets = {text(s, "Identifier"): reference(text(s, "SupportedCRS")) for s in children(contents, "TileMatrixSet")}
    found = []
    for layer in children(contents, "Layer"):
        boxes = children(layer, "WGS84BoundingBox")
        box = [float(word) for corner in ("LowerCorner", "UpperCorner") for word in text(boxes[0], corner).split()] if boxes else None
        links = [text(link, "TileMatrixSet") for link in children(layer, "TileMatrixSetLink")]
        times = [(text(d, "Default"), ",".join((v.text or "").strip() for v in children(d, "Value")))
                 for d in children(layer, "Dimension") if text(d, "Identifier").lower() == "time"]
        found.append((text(layer, "Identifier"), text(layer, "Title"), {sets[link] for link in links if link in sets},
                      {text(style, "Identifier") for style in children(layer, "Style")}, box, times[0] if times else None))
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
        for layer, (name, title, references, styles, box, time) in zip(told, expected):
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
