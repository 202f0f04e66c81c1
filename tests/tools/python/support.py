# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of the Python module have in common."""

import os
import subprocess
import sys
import tempfile
import unittest


def skip(reason):
    """End the test as one that cannot run here."""
    print(f"skipped: {reason}")
    sys.exit(77)


try:
    import numpy as np
except ImportError:
    skip("NumPy is not installed")

import lumatlas  # noqa: E402


def make_office(program, *options):
    """Make a small scene in the folder `office`."""
    size = "--photographs 12 --width 96 --height 72 --samples 1 --triangles 3000"
    subprocess.run([program, "synth", "apartment", "-o", "office", *size.split(), *options, "--quiet"], check=True,
                   stdout=subprocess.DEVNULL)


class InOffice(unittest.TestCase):
    """Tests in a folder of their own, with a small scene in its folder `office`."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        os.chdir(cls.temporary.name)
        make_office(sys.argv[1])

    @classmethod
    def tearDownClass(cls):
        os.chdir("/")
        cls.temporary.cleanup()


def read_ply(path):
    """Return vertices and faces of a mesh that `synth` has written, or `make_mesh`."""
    data = path.read_bytes()
    head, body = data.split(b"end_header\n", 1)
    lines = head.decode().split("\n")
    counts = [int(line.split()[2]) for line in lines if line.startswith("element")]
    kinds = {"float": "<f4", "double": "<f8", "uchar": "u1"}
    named = [line.split() for line in lines if line.startswith("property") and "list" not in line]
    row = np.dtype([(name, kinds[kind]) for _, kind, name in named])
    vertices = np.frombuffer(body, row, counts[0])
    faces = np.frombuffer(body, np.dtype([("count", "u1"), ("corners", "<u4", 3)]), counts[1], row.itemsize * counts[0])
    return np.stack([vertices[axis].astype(float) for axis in "xyz"], axis=1), faces["corners"].copy()


def stopping(at):
    """Return a progress function that ends the job at its call of this number."""
    calls = []

    def progress(stage, done, total):
        calls.append(stage)
        return len(calls) < at

    return progress
