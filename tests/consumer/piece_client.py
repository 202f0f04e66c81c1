#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sends a mesh in pieces, and photographs: piece_client.py FOLDER MESH.ply PORT [FRAMES_PER_SECOND [SIDE]]

The photographs and poses are those of a TUM RGB-D folder, whose depth images are not sent. The mesh, a binary PLY file
in the same coordinates, is cut by cubes of SIDE (1) scene units. A piece is sent before the first frame whose picture
the middle of the piece is in, as a program sends what it has meshed so far; the pieces that are left are sent at the
end. The receiver is `lumatlas live --listen PORT`; tools/live/README.md describes the protocol. Needs numpy and
Pillow."""
import re
import socket
import struct
import sys
import time
from pathlib import Path

import numpy
from PIL import Image

from live_client import message, named, pose, rows


def ply(path):
    """Vertices and triangles of a binary little-endian PLY file."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode()
    counts = [int(n) for n in re.findall(r"element \w+ (\d+)", header)]
    types = {"float": "<f4", "double": "<f8", "uchar": "u1", "uint8": "u1", "float32": "<f4"}
    vertex = header[header.index("element vertex"):header.index("element face")]
    layout = numpy.dtype([(name, types[kind]) for kind, name in re.findall(r"property (\w+) (\w+)\n", vertex)])
    vertices = numpy.frombuffer(data, layout, counts[0], end)
    faces = numpy.frombuffer(data, numpy.dtype([("n", "u1"), ("v", "<i4", 3)]), counts[1],
                             end + counts[0] * layout.itemsize)["v"]
    return numpy.column_stack([vertices[axis] for axis in "xyz"]).astype(float), faces


def pieces_of(positions, faces, side):
    """Cuts a mesh by the cubes that its faces' middles are in: a middle and a message for each piece."""
    middles = positions[faces].mean(axis=1)
    _, cube = numpy.unique(numpy.floor(middles / side).astype(int), axis=0, return_inverse=True)
    for number in range(cube.max() + 1):
        mine = faces[cube.ravel() == number]
        used, corners = numpy.unique(mine, return_inverse=True)
        payload = struct.pack("<III", number, 4, len(used)) + positions[used].astype("<f4").tobytes()
        payload += struct.pack("<I", len(mine)) + corners.astype("<u4").tobytes()
        yield positions[used].mean(axis=0), message(b"S", payload)


def sees(pose_bytes, lens, middle):
    rotation = numpy.frombuffer(pose_bytes, "<f8").reshape(3, 4)
    x, y, z = rotation[:, :3] @ middle + rotation[:, 3]
    width, height, fx, fy, cx, cy = lens
    return z > 0 and 0 <= fx * x / z + cx < width and 0 <= fy * y / z + cy < height


def main(folder, mesh, port, rate=0.0, side=1.0):
    photographs = rows(folder / "rgb.txt")
    poses = {float(row[0]): [float(v) for v in row[1:]] for row in rows(folder / "groundtruth.txt")}
    fx, fy, cx, cy = [float(v) for v in rows(folder / "camera.txt")[0][:4]]
    lens = *Image.open(folder / photographs[0][1]).size, fx, fy, cx + 0.5, cy + 0.5  # TUM counts from pixel middles
    left = list(pieces_of(*ply(mesh), side))
    with socket.create_connection(("127.0.0.1", port)) as out:
        out.sendall(b"LUMLIVE1" + message(b"L", struct.pack("<II4d", *lens)))
        for stamp, file in photographs:
            here = pose(poses[min(poses, key=lambda other: abs(other - float(stamp)))])
            seen = [sees(here, lens, middle) for middle, _ in left]
            for piece in (piece for (_, piece), shown in zip(left, seen) if shown):
                out.sendall(piece)
            left = [piece for piece, shown in zip(left, seen) if not shown]
            photograph = (folder / file).read_bytes()
            payload = named(Path(file).name) + here + struct.pack("<I", len(photograph)) + photograph
            out.sendall(message(b"F", payload + struct.pack("<d", 0)))  # no depths
            time.sleep(1 / rate if rate else 0)
        for _, piece in left:
            out.sendall(piece)
        out.sendall(message(b"E", b""))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]), *map(float, sys.argv[4:]))
