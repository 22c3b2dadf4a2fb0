"""A page in a headless browser that measures itself: serves it on 127.0.0.1, hears what it says, looks at the browser's processes."""
import base64
import http.server
import json
import os
import pathlib
import shutil
import subprocess
import sys
import threading
import urllib.parse

TICKS_A_SECOND = os.sysconf("SC_CLK_TCK")
LONGEST_S = 200
TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".json": "application/json", ".png": "image/png",
         ".wasm": "application/wasm"}


def fields_of(pid):
    """/proc/PID/stat from the third field on; None when it is gone."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except (FileNotFoundError, ProcessLookupError):
        return None


def processor_s(pid):
    fields = fields_of(pid)
    return (int(fields[11]) + int(fields[12])) / TICKS_A_SECOND if fields else 0.0


def memory_mib(pid):
    """VmRSS, shared libraries included."""
    try:
        lines = pathlib.Path(f"/proc/{pid}/status").read_text().splitlines()
    except (FileNotFoundError, ProcessLookupError):
        return 0.0
    return next((int(line.split()[1]) / 1024 for line in lines if line.startswith("VmRSS:")), 0.0)


def tree(root):
    """A process and all below it."""
    parents = {int(entry.name): fields_of(entry.name) for entry in pathlib.Path("/proc").iterdir() if entry.name.isdigit()}
    found = [root]
    for pid in found:
        found += [child for child, fields in parents.items() if fields and int(fields[1]) == pid]
    return found


def draws(pid):
    """Whether it is one of the two processes that make the picture."""
    try:
        words = pathlib.Path(f"/proc/{pid}/cmdline").read_bytes()
    except (FileNotFoundError, ProcessLookupError):
        return False
    return b"--type=renderer" in words or b"--type=gpu-process" in words


class Session:
    def __init__(self, page, folders):
        self.page, self.folders = page, folders
        self.browser = self.result = self.failure = None
        self.steady = {}
        self.done = threading.Event()

    def heard(self, path, body):
        if path == "/steady":
            pids = tree(self.browser.pid)
            self.steady[body.decode()] = {"processor_s": sum(map(processor_s, pids)), "drawing_mib": sum(memory_mib(p) for p in pids if draws(p))}
        elif path == "/result":
            self.result = json.loads(body)
            self.done.set()
        elif path == "/failed":
            self.failure = body.decode(errors="replace")
            self.done.set()

    def file(self, path):
        if path == "/page":
            return self.page
        head, _, rest = path.lstrip("/").partition("/")
        return self.folders[head] / rest if head in self.folders and ".." not in rest.split("/") else None


def serve(session):
    class Handler(http.server.BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def answer(self, status, body=b"", content="application/octet-stream"):
            self.send_response(status)
            self.send_header("Content-Type", content)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def do_GET(self):
            path = session.file(urllib.parse.unquote(urllib.parse.urlsplit(self.path).path))
            if path is None or not path.is_file():
                return self.answer(404)
            self.answer(200, path.read_bytes(), TYPES.get(path.suffix, "application/octet-stream"))

        def do_POST(self):
            session.heard(self.path, self.rfile.read(int(self.headers["Content-Length"])))
            self.answer(200)

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return server


def measured(page, folders, asked, work, gl, picture):
    """Opens the page with `asked` (JSON, in its query), with the folders by name beside it; waits for its /result, and writes
    the picture in it. Returns the result, and by the name of each /steady that came before it processor seconds of all of the
    browser so far and MiB resident in the processes that draw. Ends the program when the page fails."""
    session = Session(page, folders)
    server = serve(session)
    profile, log = work / "profile", work / (picture.stem + ".log")
    shutil.rmtree(profile, ignore_errors=True)
    url = f"http://127.0.0.1:{server.server_port}/page?" + urllib.parse.urlencode({"q": json.dumps(asked)})
    with open(log, "w") as to:
        session.browser = subprocess.Popen(
            ["chromium", "--headless=new", "--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-component-update",
             "--disable-sync", f"--user-data-dir={profile}", "--window-size=1100,1000", "--force-device-scale-factor=1",
             "--ignore-gpu-blocklist", "--enable-unsafe-swiftshader", "--use-gl=angle", f"--use-angle={gl}", "--enable-logging=stderr", url],
            stdout=to, stderr=to)
        try:
            if not session.done.wait(LONGEST_S):
                session.failure = f"nothing heard for {LONGEST_S} s"
        finally:
            session.browser.terminate()
            session.browser.wait()
            server.shutdown()
            server.server_close()
    if session.failure:
        sys.exit(f"{page.name}: {session.failure}; the browser's own words are in {log}")
    picture.write_bytes(base64.b64decode(session.result["picture"].partition(",")[2]))
    return session.result, session.steady
