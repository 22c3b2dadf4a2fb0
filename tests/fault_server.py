#!/usr/bin/env python3
"""A web server that fails as it is told: serves a folder, or stands before another server.

    tests/fault_server.py (--folder DIR | --proxy URL) [--port N] [--control-port N]

Prints "PORT CONTROL_PORT" and serves on 127.0.0.1 until its standard input ends (so it dies with the test that started
it) or it is killed. Good answers carry an ETag and Last-Modified, and conditional requests are honoured. GET requests to the
control port say what to do; all answer 200.

    /set?prefix=/a/&fault=NAME[&times=N][&latency_ms=MS][&header=NAME:VALUE]...[&...]
                    the newest rule whose prefix begins the path (with its query) counts, N times, then it is gone
    /clear          no rules, no latency, no limit; whoever hangs is let go
    /latency?ms=MS  before every answer
    /bandwidth?bits=N   a second, for all connections together; 0: no limit
    /dead, /alive   nobody listens, and open connections end; and again
    /reset          forgets what was counted
    /state          JSON: counts (path: requests), statuses (status: answers), not_modified, open (requests being answered),
                    most_open, broken (answers that the client broke off), connections, bytes (of bodies), order (paths as they came), answers
                    (path, seconds on a steady clock when it was asked for and when answered, bytes of the body, whether it was good and came
                    whole: what the client closed its connection after may not have)

Faults: ok (for its header and latency), status (code=500, retry_after=TEXT), hang, slow (rate=BYTES a second), truncate,
mislabel (type=MIME), other (path=/of/another/file), html, xml, redirect (to=URL), loop, endless, length (n=STATED), reset,
gzip, bomb (n=UNPACKED BYTES, gzip), empty, cut (to half, without a length), spoil (a PNG's pixels; mended=1: with right checksums).
"""
import argparse
import collections
import gzip
import hashlib
import http.server
import json
import mimetypes
import pathlib
import select
import socket
import struct
import sys
import threading
import time
import urllib.error
import urllib.parse
import urllib.request
import zlib

EXCEPTION = b"""<?xml version="1.0" encoding="UTF-8"?>
<ServiceExceptionReport version="1.3.0" xmlns="http://www.opengis.net/ogc">
  <ServiceException code="LayerNotDefined">The layer is not there, says the test.</ServiceException>
</ServiceExceptionReport>
"""
PAGE = b"<!DOCTYPE html><html><head><title>Welcome</title></head><body><p>Please log in.</p></body></html>\n"
CHUNK = 4096


class Line:
    """What all connections share: a limit on their bytes a second together."""

    def __init__(self):
        self.lock = threading.Lock()
        self.bytes_per_second = 0.0
        self.free_at = 0.0

    def limit(self, bits):
        with self.lock:
            self.bytes_per_second = bits / 8.0

    def wait_for(self, count):
        with self.lock:
            if self.bytes_per_second <= 0.0:
                return
            now = time.monotonic()
            self.free_at = max(self.free_at, now) + count / self.bytes_per_second
            delay = self.free_at - now
        time.sleep(delay)


class World:
    """What the server has been told, and what it has counted."""

    def __init__(self, folder, upstream):
        self.folder = folder
        self.upstream = upstream
        self.lock = threading.Lock()
        self.line = Line()
        self.rules = []
        self.latency_s = 0.0
        self.letting_go = threading.Event()
        self.sockets = set()
        self.dead = False
        self.forget()

    def forget(self):
        with self.lock:
            self.counts = collections.Counter()
            self.statuses = collections.Counter()
            self.order = []
            self.answers = []
            self.not_modified = self.most_open = self.broken = self.connections = self.bytes = 0
            self.open = 0

    def clear(self):
        with self.lock:
            self.rules = []
            self.latency_s = 0.0
        self.line.limit(0)
        self.letting_go.set()
        self.letting_go = threading.Event()

    def rule_for(self, path):
        with self.lock:
            for rule in reversed(self.rules):
                if path.startswith(rule["prefix"]):
                    if "times" in rule:
                        rule["times"] -= 1
                        if rule["times"] <= 0:
                            self.rules.remove(rule)
                    return rule
        return {}

    def begin(self, path):
        with self.lock:
            self.counts[path] += 1
            self.order.append(path)
            self.open += 1
            self.most_open = max(self.most_open, self.open)

    def end(self, broken, answer):
        with self.lock:
            self.open -= 1
            self.broken += broken
            self.answers.append(answer)

    def state(self):
        with self.lock:
            return {"counts": self.counts, "statuses": self.statuses, "not_modified": self.not_modified, "open": self.open,
                    "most_open": self.most_open, "broken": self.broken, "connections": self.connections, "bytes": self.bytes,
                    "order": self.order, "answers": self.answers}

    def content(self, path):
        """(status, type, body) of what is behind this server."""
        if self.upstream:
            try:
                with urllib.request.urlopen(self.upstream + path, timeout=60) as answer:
                    return answer.status, answer.headers.get("Content-Type", ""), answer.read()
            except urllib.error.HTTPError as error:
                return error.code, error.headers.get("Content-Type", ""), error.read()
        name = urllib.parse.unquote(urllib.parse.urlsplit(path).path).lstrip("/")
        file = (self.folder / name).resolve()
        if not file.is_relative_to(self.folder) or not file.is_file():
            return 404, "text/plain", b"no such file\n"
        return 200, mimetypes.guess_type(file.name)[0] or "application/octet-stream", file.read_bytes()


class Broken(Exception):
    """The client has gone."""


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    world = None
    disable_nagle_algorithm = True

    def setup(self):
        super().setup()
        self.last_answer = None
        with self.world.lock:
            self.world.connections += 1
            self.world.sockets.add(self.connection)
            dead = self.world.dead
        if dead:
            end(self.connection)

    def finish(self):
        with self.world.lock:
            if self.last_answer:
                self.last_answer[-1] = False
            self.world.sockets.discard(self.connection)
        try:
            super().finish()
        except OSError:
            pass

    def log_message(self, *_):
        pass

    def do_GET(self):
        rule = self.world.rule_for(self.path)
        self.world.begin(self.path)
        begun, self.sent, self.status, broken = time.monotonic(), 0, 0, False
        try:
            self.sleep(self.world.latency_s + float(rule.get("latency_ms", 0)) / 1000.0)
            self.answer(rule)
        except (Broken, OSError):
            broken = True
            self.close_connection = True
        finally:
            is_good = not broken and self.status == 200 and rule.get("fault", "ok") == "ok"
            self.last_answer = [self.path, begun, time.monotonic(), self.sent, is_good]
            self.world.end(broken, self.last_answer)

    def answer(self, rule):
        fault = rule.get("fault", "ok")
        getattr(self, "fault_" + fault)(rule)

    # Sending

    def sleep(self, seconds):
        """Waits, but no longer than the client does or /clear says."""
        end = time.monotonic() + seconds
        letting_go = self.world.letting_go
        while time.monotonic() < end and not letting_go.is_set():
            self.look_at_client(min(0.05, max(0.0, end - time.monotonic())))

    def look_at_client(self, seconds=0.0):
        readable, _, _ = select.select([self.connection], [], [], seconds)
        if readable and not self.connection.recv(1, socket.MSG_PEEK):
            raise Broken()

    def head(self, status, content_type, length, rule, extra=()):
        self.status = status
        with self.world.lock:
            self.world.statuses[str(status)] += 1
        self.send_response(status)
        if content_type:
            self.send_header("Content-Type", content_type)
        if length is not None:
            self.send_header("Content-Length", str(length))
        for name, value in [*extra, *rule.get("headers", [])]:
            self.send_header(name, value)
        self.end_headers()

    def body(self, data, rate=0.0):
        step = CHUNK if rate <= 0 else max(1, min(CHUNK, int(rate / 10)))
        for start in range(0, len(data), step):
            part = data[start:start + step]
            self.world.line.wait_for(len(part))
            self.look_at_client()  # who has gone takes no more of the line
            if rate > 0:
                self.sleep(len(part) / rate)
            self.wfile.write(part)
            self.wfile.flush()
            self.sent += len(part)
            with self.world.lock:
                self.world.bytes += len(part)

    def send(self, status, content_type, data, rule, extra=(), rate=0.0):
        self.head(status, content_type, len(data), rule, extra)
        self.body(data, rate)

    def content(self):
        return self.world.content(self.path)

    # Faults

    def fault_ok(self, rule, rate=0.0):
        status, content_type, data = self.content()
        if status != 200:
            return self.send(status, content_type, data, rule)
        etag = '"' + hashlib.sha1(data).hexdigest() + '"'
        told = {name.lower() for name, _ in rule.get("headers", [])}
        stamps = [(n, v) for n, v in [("ETag", etag), ("Last-Modified", "Sat, 01 Jan 2022 00:00:00 GMT")] if n.lower() not in told]
        asked = self.headers.get("If-None-Match")
        same = asked == etag if asked else "etag" in told and self.headers.get("If-Modified-Since") == "Sat, 01 Jan 2022 00:00:00 GMT"
        if same:
            with self.world.lock:
                self.world.not_modified += 1
            return self.head(304, "", None, rule, stamps)
        return self.send(status, content_type, data, rule, stamps, rate)

    def fault_status(self, rule):
        code = int(rule.get("code", 500))
        extra = [("Retry-After", rule["retry_after"])] if "retry_after" in rule else []
        if code in (204, 304):
            return self.head(code, "", None, rule, extra)
        return self.send(code, "text/plain", b"so the test wants it\n", rule, extra)

    def fault_hang(self, _):
        self.sleep(3600.0)
        self.close_connection = True

    def fault_slow(self, rule):
        self.fault_ok(rule, float(rule.get("rate", 100)))

    def fault_truncate(self, rule):
        _, content_type, data = self.content()
        self.head(200, content_type, len(data), rule)
        self.body(data[:len(data) // 2])
        self.close_connection = True

    def fault_cut(self, rule):
        _, content_type, data = self.content()
        self.close_connection = True
        self.head(200, content_type, None, rule, [("Connection", "close")])
        self.body(data[:len(data) // 2])

    def fault_spoil(self, rule):
        _, content_type, data = self.content()
        at, out = 8, data[:8]
        while at < len(data):
            length, = struct.unpack(">I", data[at:at + 4])
            name, body, checksum = data[at + 4:at + 8], data[at + 8:at + 8 + length], data[at + 8 + length:at + 12 + length]
            if name == b"IDAT":
                body = bytes(length)
                checksum = struct.pack(">I", zlib.crc32(name + body)) if rule.get("mended") else checksum
            out += data[at:at + 4] + name + body + checksum
            at += 12 + length
        self.send(200, content_type, out, rule)

    def fault_mislabel(self, rule):
        status, _, data = self.content()
        self.send(status, rule.get("type", "image/png"), data, rule)

    def fault_other(self, rule):
        self.send(*self.world.content(rule["path"]), rule)

    def fault_html(self, rule):
        self.send(200, "text/html; charset=utf-8", PAGE, rule)

    def fault_xml(self, rule):
        self.send(200, "application/vnd.ogc.se_xml", EXCEPTION, rule)

    def fault_redirect(self, rule):
        self.send(302, "text/plain", b"elsewhere\n", rule, [("Location", rule["to"])])

    def fault_loop(self, rule):
        self.send(302, "text/plain", b"here\n", rule, [("Location", self.path)])

    def fault_endless(self, rule):
        self.head(200, "application/octet-stream", None, rule, [("Connection", "close")])
        self.close_connection = True
        letting_go = self.world.letting_go
        while not letting_go.is_set():
            self.body(b"\0" * CHUNK)

    def fault_length(self, rule):
        status, content_type, data = self.content()
        self.head(status, content_type, int(rule["n"]), rule)
        self.body(data)
        self.close_connection = True

    def fault_reset(self, _):
        self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.connection.shutdown(socket.SHUT_RD)
        self.close_connection = True

    def fault_gzip(self, rule):
        status, content_type, data = self.content()
        self.send(status, content_type, gzip.compress(data), rule, [("Content-Encoding", "gzip")])

    def fault_bomb(self, rule):
        data = gzip.compress(b"\0" * int(rule.get("n", 1 << 26)))
        self.send(200, "application/octet-stream", data, rule, [("Content-Encoding", "gzip")])

    def fault_empty(self, rule):
        self.send(200, "application/octet-stream", b"", rule)


def end(connection):
    """In the middle, whoever reads or writes there."""
    try:
        connection.shutdown(socket.SHUT_RDWR)
        connection.close()
    except OSError:
        pass


class Server(http.server.ThreadingHTTPServer):
    daemon_threads = True
    request_queue_size = 128

    def handle_error(self, *_):
        pass  # clients that break off are the tests' daily bread


class Stage:
    """The server that can die and come back on its port, which nobody else gets meanwhile."""

    def __init__(self, world, port):
        self.handler = type("BoundHandler", (Handler,), {"world": world})
        self.world = world
        self.server = None
        self.hold(port)
        self.rise()

    def hold(self, port):
        self.place = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        self.place.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.place.bind(("127.0.0.1", port))  # not listening: connections are refused
        self.port = self.place.getsockname()[1]

    def rise(self):
        if self.server:
            return
        self.server = Server(("127.0.0.1", self.port), self.handler, bind_and_activate=False)
        self.server.socket.close()
        self.server.socket = self.place
        self.server.server_activate()
        self.world.dead = False
        threading.Thread(target=self.server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True).start()

    def die(self):
        if not self.server:
            return
        self.server.shutdown()
        self.server.server_close()
        self.server = None
        self.hold(self.port)
        with self.world.lock:
            self.world.dead = True
            sockets, self.world.sockets = self.world.sockets, set()
        for connection in sockets:
            end(connection)


class Control(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    stage = None

    def log_message(self, *_):
        pass

    def do_GET(self):
        url = urllib.parse.urlsplit(self.path)
        pairs = urllib.parse.parse_qsl(url.query)
        told = dict(pairs)
        world = self.stage.world
        answer = {}
        if url.path == "/set":
            rule = {"prefix": "/", "fault": "ok", **told, "headers": [tuple(p.strip() for p in v.split(":", 1)) for k, v in pairs if k == "header"]}
            if not hasattr(Handler, "fault_" + rule["fault"]):
                return self.say(400, {"error": "no such fault"})
            if "times" in rule:
                rule["times"] = int(rule["times"])
            with world.lock:
                world.rules.append(rule)
        elif url.path == "/clear":
            world.clear()
        elif url.path == "/latency":
            world.latency_s = float(told["ms"]) / 1000.0
        elif url.path == "/bandwidth":
            world.line.limit(float(told["bits"]))
        elif url.path == "/dead":
            self.stage.die()
        elif url.path == "/alive":
            self.stage.rise()
        elif url.path == "/reset":
            world.forget()
        elif url.path == "/state":
            answer = world.state()
        else:
            return self.say(404, {"error": "no such command"})
        return self.say(200, answer)

    def say(self, status, answer):
        data = json.dumps(answer).encode()
        self.send_response(status)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)


def main():
    parser = argparse.ArgumentParser(description="A web server that fails as it is told.")
    behind = parser.add_mutually_exclusive_group(required=True)
    behind.add_argument("--folder", type=pathlib.Path)
    behind.add_argument("--proxy", metavar="URL")
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--control-port", type=int, default=0)
    options = parser.parse_args()
    world = World(options.folder.resolve() if options.folder else None, (options.proxy or "").rstrip("/"))
    stage = Stage(world, options.port)
    control = Server(("127.0.0.1", options.control_port), type("BoundControl", (Control,), {"stage": stage}))
    threading.Thread(target=control.serve_forever, daemon=True).start()
    print(stage.port, control.server_address[1], flush=True)
    sys.stdin.read()
    return 0


if __name__ == "__main__":
    sys.exit(main())
