#!/usr/bin/env python3
"""Tile databases on servers: behind nginx, in a bucket of an S3 server (s3rver), and behind a server that checks every signature.

    remote_database_test.py PROGRAM SOURCE_DIR WORK_DIR

Exit status 77 (skipped) where nginx, GDAL's Python module or the data are missing; what needs s3rver is skipped where npm cannot bring it.
"""
import hashlib
import hmac
import http.server
import pathlib
import re
import shutil
import subprocess
import threading
import unittest
import urllib.request

import map_servers
import online_world

SIZE = "480x360"
CAMERA = "20,-130,3000000,0,-60,0"
ELSEWHERE = "-40,60,200000,0,-90,0"
KEY, SECRET = "S3RVER", "S3RVER"
NOTHING = hashlib.sha256(b"").hexdigest()


def signature_of(secret, method, path, headers, signed, scope):
    """AWS Signature Version 4 of a request without a query (Authenticating Requests, Amazon S3 API Reference)."""
    canonical = "\n".join([method, path, "", *[f"{name}:{headers[name].strip()}" for name in signed], "", ";".join(signed), headers["x-amz-content-sha256"]])
    text = "\n".join(["AWS4-HMAC-SHA256", headers["x-amz-date"], scope, hashlib.sha256(canonical.encode()).hexdigest()])
    key = ("AWS4" + secret).encode()
    for part in scope.split("/"):
        key = hmac.new(key, part.encode(), hashlib.sha256).digest()
    return hmac.new(key, text.encode(), hashlib.sha256).hexdigest()


class CheckingServer:
    """A folder as a bucket; 403 without the right signature, and for keys that are not there."""

    def __init__(self, folder):
        self.asked, self.tokens, self.moved_to = 0, set(), None
        outer = self

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self):
                outer.asked += 1
                headers = {name.lower(): value for name, value in self.headers.items()}
                outer.tokens.add(headers.get("x-amz-security-token"))
                match = re.fullmatch(r"AWS4-HMAC-SHA256 Credential=([^/]+)/([^,]+), ?SignedHeaders=([^,]+), ?Signature=([0-9a-f]+)",
                                     headers.get("authorization", ""))
                good = match is not None and match[1] == KEY and headers.get("x-amz-content-sha256") == NOTHING
                if good:
                    signed = match[3].split(";")
                    good = {"host", "x-amz-date", "x-amz-content-sha256"} <= set(signed) and match[4] == signature_of(
                        SECRET, "GET", self.path, headers, signed, match[2])
                if outer.moved_to:
                    self.send_response(302)
                    self.send_header("Location", outer.moved_to + self.path)
                    self.send_header("Content-Length", "0")
                    self.end_headers()
                    return
                file = folder / self.path.lstrip("/")
                body = file.read_bytes() if good and file.is_file() else b"<Error/>"
                self.send_response(200 if good and file.is_file() else 403)
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, *_):
                pass

        self.service = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.service.handle_error = lambda *_: None  # a connection that is let go of
        self.url = f"http://127.0.0.1:{self.service.server_port}"
        threading.Thread(target=self.service.serve_forever, daemon=True).start()


class RemoteDatabases(online_world.ServerTest):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(cls.work, ignore_errors=True)
        cls.files, cls.bucket = cls.work / "files", cls.work / "www/planets"
        cls.files.mkdir(parents=True)
        program = online_world.Program(cls.program, cls.work / "cache")
        for name, raster in (("elevation", "mola_dem_4ppd.tif"), ("imagery", "viking_mdim21_color_2880x1440.jpg")):
            program.run("build", cls.files / f"{name}.tdb", cls.source / "data/mars" / raster, "--kind", name, "--tiling", "healpix", "--body", "mars")
            done = program.run("export", cls.files / f"{name}.tdb", cls.bucket / f"{name}.tdb", "--format", "objects")
            assert "tiles" in done.stderr, done.stderr
        cls.local = cls.work / "local.png"
        program.run("render", cls.scene_of(f"{cls.files}/"), "--size", SIZE, "--camera", CAMERA, "-o", cls.local)

    @staticmethod
    def scene_of(base):
        return f"{base}elevation.tdb,{base}imagery.tdb"

    def picture(self, scene, *words, status=0, camera=CAMERA, **environment):
        out = self.work / "out.png"
        out.unlink(missing_ok=True)
        self.run_it.environment.update(environment)
        done = self.run_it.run("render", scene, "--size", SIZE, "--camera", camera, "-o", out, *words, status=status)
        return done, out.read_bytes() if out.exists() else None

    def test_behind_nginx_it_is_the_file_and_there_again_without_it(self):
        with map_servers.FileServer(self.bucket.parent, self.work) as server:
            base = f"{server.url}/planets/"
            done, picture = self.picture(self.scene_of(base))
            self.assertEqual(done.stderr, "")
            self.assertEqual(picture, self.local.read_bytes())
            # In a scene file, which says body and tiling.
            scene = self.work / "mars.toml"
            scene.write_text(f'body = "mars"\ntiling = "healpix"\n[[elevation]]\nsource = "{base}elevation.tdb"\n'
                             f'[[imagery]]\nsource = "{base}imagery.tdb"\n')
            self.assertEqual(self.picture(scene)[1], self.local.read_bytes())
            # What lets somebody in is in no cache.
            self.picture(f"{base}imagery.tdb?token=opensesame")
            for kept in (self.work / "cache").rglob("*"):
                self.assertNotIn(b"opensesame", kept.read_bytes() if kept.is_file() else b"")
            self.assertEqual(self.picture(f"{base}imagery.tdb,{self.files / 'elevation.tdb'}")[1], self.local.read_bytes())
            missing, _ = self.picture(f"{base}nothing.tdb", status=1)
            self.assertIn("--format objects", missing.stderr)
        self.assertEqual(self.picture(self.scene_of(base), "--offline")[1], self.local.read_bytes())

    def test_what_a_server_spoils_is_told(self):
        with map_servers.FileServer(self.bucket.parent, self.work) as server, online_world.FaultServer(proxy=server.url) as front:
            base = f"{front.url}/planets/"
            # What is damaged on its way is asked for again.
            revision = next(each.name for each in (self.bucket / "imagery.tdb").iterdir() if each.is_dir())
            front.tell("set", prefix=f"/planets/imagery.tdb/{revision}", fault="cut", times=12)
            self.assertEqual(self.picture(self.scene_of(base))[1], self.local.read_bytes())
            self.assertGreater(max(front.state()["counts"].values()), 1)
            front.tell("clear")
            front.tell("set", prefix="/planets/elevation.tdb", fault="status", code=403)
            self.run_it = online_world.Program(self.program, self.work / "other cache")
            refused, _ = self.picture(f"{base}elevation.tdb", status=1)
            self.assertIn("does not allow", refused.stderr)

    def test_a_replaced_database_is_never_mixed_with_the_old(self):
        copy = self.bucket.parent / "replaced.tdb"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(self.bucket / "imagery.tdb", copy)
        with map_servers.FileServer(self.bucket.parent, self.work) as server:
            url = f"{server.url}/replaced.tdb"
            self.assertIsNotNone(self.picture(url)[1])
            self.run_it.run("export", self.files / "elevation.tdb", copy, "--format", "objects")
            folders = [each.name for each in copy.iterdir() if each.is_dir()]
            self.assertEqual(len(folders), 1)
            # Contents are asked about at each opening.
            again, picture = self.picture(url, camera=ELSEWHERE)
            self.run_it.run("render", self.files / "elevation.tdb", "--size", SIZE, "--camera", ELSEWHERE, "-o", self.work / "elsewhere.png")
            self.assertEqual(picture, (self.work / "elsewhere.png").read_bytes(), again.stderr)

    def test_signatures(self):
        # The published example.
        headers = {"host": "examplebucket.s3.amazonaws.com", "range": "bytes=0-9", "x-amz-content-sha256": NOTHING, "x-amz-date": "20130524T000000Z"}
        self.assertEqual(signature_of("wJalrXUtnFEMI/K7MDENG/bPxRfiCYEXAMPLEKEY", "GET", "/test.txt", headers, sorted(headers),
                                      "20130524/us-east-1/s3/aws4_request"),
                         "f0e8bdb87c964420e857bd35b5d6ed310bd44f0170aba48dd91039c6036bdb41")
        server = CheckingServer(self.bucket.parent)
        here = {"AWS_ENDPOINT_URL": server.url, "AWS_REGION": "eu-central-1", "AWS_ACCESS_KEY_ID": KEY, "AWS_SECRET_ACCESS_KEY": SECRET}
        done, picture = self.picture(self.scene_of("s3://planets/"), AWS_SESSION_TOKEN="of+a/while==", **here)
        self.assertEqual(picture, self.local.read_bytes(), done.stderr)
        self.assertEqual(server.tokens, {"of+a/while=="})
        self.assertGreater(server.asked, 20)
        self.run_it = online_world.Program(self.program, self.work / "other cache")
        wrong, _ = self.picture("s3://planets/imagery.tdb", status=1, **{**here, "AWS_SECRET_ACCESS_KEY": "not it"})
        self.assertIn("403", wrong.stderr)
        self.assertNotIn("not it", wrong.stderr)
        # To another host nothing is told: a signature is for one.
        elsewhere = CheckingServer(self.bucket.parent)
        elsewhere.moved_to = server.url.replace("127.0.0.1", "localhost")
        before = server.asked
        moved, _ = self.picture("s3://planets/imagery.tdb", status=1, AWS_SESSION_TOKEN="of+a/while==", **{**here, "AWS_ENDPOINT_URL": elsewhere.url})
        self.assertIn("AWS_REGION", moved.stderr)
        self.assertEqual(server.asked, before)
        # Two servers with a bucket of one name are two.
        self.run_it = online_world.Program(self.program, self.work / "third cache")
        self.picture("s3://planets/imagery.tdb", **here)
        other = CheckingServer(self.files)
        absent, _ = self.picture("s3://planets/imagery.tdb", status=1, **{**here, "AWS_ENDPOINT_URL": other.url})
        self.assertIn("403", absent.stderr)
        half, _ = self.picture("s3://planets/imagery.tdb", status=1, **{**here, "AWS_SECRET_ACCESS_KEY": ""})
        self.assertIn("AWS_SECRET_ACCESS_KEY", half.stderr)

    def test_in_a_bucket_of_an_s3_server(self):
        tool = self.work / "npm"
        tool.mkdir()
        try:
            done = subprocess.run(["npm", "install", "--silent", "--no-audit", "--no-fund", "s3rver@3"], cwd=tool, capture_output=True, timeout=120)
        except (OSError, subprocess.TimeoutExpired):
            done = None
        script = tool / "node_modules/s3rver/bin/s3rver.js"
        if done is None or done.returncode != 0 or not script.exists():
            self.skipTest("npm cannot bring s3rver")
        port = map_servers.free_port()
        url = f"http://127.0.0.1:{port}"
        process = map_servers.Process(["node", str(script), "-d", str(self.work / "buckets"), "-a", "127.0.0.1", "-p", str(port), "--configure-bucket", "planets"],
                                      url, self.work / "s3rver.log")
        process.start()
        self.addCleanup(process.stop)
        for file in sorted(self.bucket.rglob("*")):
            if file.is_file():
                put = urllib.request.Request(f"{url}/planets/{file.relative_to(self.bucket)}", data=file.read_bytes(), method="PUT")
                urllib.request.urlopen(put).close()
        done, picture = self.picture(self.scene_of("s3://planets/"), AWS_ENDPOINT_URL=url, AWS_ACCESS_KEY_ID=KEY, AWS_SECRET_ACCESS_KEY=SECRET)
        self.assertEqual(picture, self.local.read_bytes(), done.stderr)


if __name__ == "__main__":
    absent = [] if shutil.which("nginx") or pathlib.Path("/usr/sbin/nginx").exists() else ["nginx"]
    online_world.run_tests(RemoteDatabases, absent + online_world.missing())
