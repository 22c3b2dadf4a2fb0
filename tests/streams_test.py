#!/usr/bin/env python3
"""What goes in and out of the program through streams is bounded and checked.

usage: streams_test.py PROGRAM RASTER SCRATCH

Answers that cannot be written (a full disk, a reader that is gone) are told and make the exit status 1; a line without
end is an error and takes no memory; a file for --body that has no end is refused.
"""

import os
import subprocess
import sys
import unittest


class Streams(unittest.TestCase):
    program = raster = folder = ""

    @classmethod
    def setUpClass(cls):
        os.makedirs(cls.folder, exist_ok=True)
        cls.database = os.path.join(cls.folder, "heights.tdb")
        if os.path.exists(cls.database):
            os.remove(cls.database)
        subprocess.run([cls.program, "build", cls.database, cls.raster, "--kind", "elevation", "--max-level", "1"],
                       check=True, capture_output=True)

    def query(self, places, **options):
        return subprocess.run([self.program, "query", self.database], input=places, timeout=300,
                              stderr=subprocess.PIPE, **options)

    def test_a_full_disk_is_told(self):
        if not os.path.exists("/dev/full"):
            self.skipTest("no /dev/full")
        with open("/dev/full", "wb") as full:
            done = self.query(b"0 0\n", stdout=full)
        self.assertEqual(done.returncode, 1)
        self.assertIn(b"cannot be written", done.stderr)

    def test_descriptions_and_reports_on_a_full_disk_are_told(self):
        if not os.path.exists("/dev/full"):
            self.skipTest("no /dev/full")
        for words in (("info",), ("info", "--json"), ("verify",), ("verify", "--json")):
            with open("/dev/full", "wb") as full:
                done = subprocess.run([self.program, *words, self.database], stdout=full, stderr=subprocess.PIPE, timeout=300)
            self.assertEqual(done.returncode, 1, words)
            self.assertIn(b"cannot be written", done.stderr)

    def test_a_closed_pipe_is_told(self):
        reading, writing = os.pipe()
        os.close(reading)
        done = self.query(b"0 0\n" * 100000, stdout=writing)
        os.close(writing)
        self.assertEqual(done.returncode, 1)
        self.assertIn(b"cannot be written", done.stderr)

    def test_a_line_without_end_is_one_error(self):
        done = self.query(b"1" * 10_000_000 + b"\n0 0\n", stdout=subprocess.PIPE)
        lines = done.stdout.split()
        self.assertEqual(done.returncode, 1)
        self.assertEqual(len(lines), 2)
        self.assertEqual(lines[0], b"error")
        self.assertNotEqual(lines[1], b"error")
        self.assertIn(b"line 1: is longer than", done.stderr)

    def test_a_body_without_end_is_refused(self):
        done = subprocess.run([self.program, "build", os.path.join(self.folder, "x.tdb"), self.raster, "--kind",
                               "elevation", "--body", "/dev/zero"], capture_output=True, timeout=300)
        self.assertEqual(done.returncode, 1)
        self.assertIn(b"at most 1 MiB", done.stderr)


if __name__ == "__main__":
    Streams.program, Streams.raster, Streams.folder = sys.argv[1:4]
    unittest.main(argv=sys.argv[:1])
