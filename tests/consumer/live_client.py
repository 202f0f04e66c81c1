#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sends a TUM RGB-D folder to `lumatlas live --listen PORT`: live_client.py FOLDER PORT [FRAMES_PER_SECOND]

The protocol is described in tools/live/README.md. Needs numpy and Pillow, for the depth images."""
import socket
import struct
import sys
import time
from pathlib import Path

import numpy
from PIL import Image


def rows(path):
    lines = (line.split() for line in path.read_text().splitlines())
    return [line for line in lines if line and not line[0].startswith("#")]


def message(kind, payload):
    return kind + bytes(3) + struct.pack("<I", len(payload)) + payload


def named(name):
    data = name.encode()
    return struct.pack("<I", len(data)) + data


def pose(values):
    """Cam from world, by rows, of TUM's tx ty tz qx qy qz qw: world from camera."""
    t = numpy.array(values[:3])
    x, y, z, w = numpy.array(values[3:]) / numpy.linalg.norm(values[3:])
    world_from_cam = numpy.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    cam_from_world = world_from_cam.T
    return numpy.column_stack([cam_from_world, -cam_from_world @ t]).astype("<f8").tobytes()


def lens(folder):
    """The beginning of the stream."""
    fx, fy, cx, cy = [float(v) for v in rows(folder / "camera.txt")[0][:4]]
    width, height = Image.open(folder / rows(folder / "rgb.txt")[0][1]).size
    # TUM counts from pixel middles.
    return b"LUMLIVE1" + message(b"L", struct.pack("<II4d", width, height, fx, fy, cx + 0.5, cy + 0.5))


def frames(folder):
    """Each frame: its name and its message."""
    depths = {float(stamp): file for stamp, file in rows(folder / "depth.txt")}
    poses = {float(row[0]): [float(v) for v in row[1:]] for row in rows(folder / "groundtruth.txt")}
    nearest = lambda table, stamp: table[min(table, key=lambda other: abs(other - stamp))]
    for stamp, file in rows(folder / "rgb.txt"):
        name, photograph = Path(file).name, (folder / file).read_bytes()
        depth = numpy.asarray(Image.open(folder / nearest(depths, float(stamp)))).astype("<u2").tobytes()
        payload = named(name) + pose(nearest(poses, float(stamp))) + struct.pack("<I", len(photograph)) + photograph
        yield name, message(b"F", payload + struct.pack("<d", 1 / 5000) + depth)


def main(folder, port, rate=0.0):
    with socket.create_connection(("127.0.0.1", port)) as out:
        out.sendall(lens(folder))
        for _, frame in frames(folder):
            out.sendall(frame)
            time.sleep(1 / rate if rate else 0)
        out.sendall(message(b"E", b""))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), *map(float, sys.argv[3:]))
