#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Usage: arrays.py SEED NUMBER SCENE

Gives the Python module arrays and numbers that it does not expect. Each call ends well or raises an exception that says
what is wrong; nothing ends the interpreter. Exit status 1 and what happened on stderr otherwise.
"""

import gc
import random
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np

import lumatlas

warnings.simplefilter("ignore")
chance = random.Random(f"{sys.argv[1]} {sys.argv[2]}")
EXPECTED = (lumatlas.Error, ValueError, TypeError, OverflowError, MemoryError, IndexError)
NUMBERS = [0, -1, 1, 2, 0.5, float("nan"), float("inf"), -1e308, 1e300, 1e-320, 2**31, 2**32, 2**63, 2**64, 10**30, True,
           None, "1", b"1", [], {}, (1, 2, 3), np.float32(3), np.int64(-5), np.array(7), np.array([7]), 1j, object()]
NAMES = ["a.png", "a/b.png", "../a", "/a", "", ".", "a\0b", "a\nb", "\ud800", "\u00fc" * 130, "x" * 300, "con", "-x", "%s%n",
         "a/../../b", "a//b", "scene.gltf", " ", 3, None, b"a", ("a",)]


class Lies:
    """Something that NumPy asks for an array, and that gives another one each time, or none."""

    def __init__(self, array):
        self.array = array

    def __array__(self, *_, **__):
        kind = chance.randrange(4)
        if kind == 0:
            raise RuntimeError("no array today")
        if kind == 1:
            return np.zeros((3, 3))
        return self.array


class Mapping:
    """A mapping whose items are none, or never end well."""

    def __init__(self, items):
        self.kept = items

    def items(self):
        kind = chance.randrange(4)
        if kind == 0:
            return [(1, 2, 3)]
        if kind == 1:
            return [()]
        if kind == 2:
            return 7
        return self.raising()

    def raising(self):
        yield from self.kept.items()
        raise KeyError("gone")


def spoilt(array):
    """Return an array of another kind, shape or layout, or with another value in it."""
    array = np.asarray(array)
    # Names and not numbers, so that a case stays the same when one is added at the end.
    changes = {
        "none": lambda: array,
        "wrong value": lambda: with_value(array),
        "empty": lambda: array[:0],
        "cut": lambda: array[: chance.randrange(len(array) + 1)],
        "flat": lambda: array.reshape(-1),
        "deeper": lambda: array[None],
        "reversed": lambda: array[::-1],
        "columns first": lambda: np.asfortranarray(array),
        "turned": lambda: array.T,
        "big endian": lambda: array.astype(array.dtype.newbyteorder(">")),
        "other kind": lambda: array.astype(chance.choice(["f2", "f4", "f8", "g", "i1", "u8", "i8", "c16", "S3", "U2", "O", "?"])),
        "times": lambda: array.astype("i8").view("M8[s]"),
        "records": lambda: np.zeros(array.shape, [("a", "f8"), ("b", "i4")]),
        "repeated": lambda: np.broadcast_to(array.flat[0], array.shape),
        "endless": lambda: np.broadcast_to(array.flat[0], (chance.choice([10**6, 10**9, 10**12]), *array.shape[1:])),
        "overlapping": lambda: np.lib.stride_tricks.as_strided(array, array.shape, (1, *array.strides[1:])),
        "masked": lambda: np.ma.masked_array(array, array == array.flat[0]),
        "matrix": lambda: np.matrix(array.reshape(len(array), -1)),
        "list": lambda: array[:4].tolist(),
        "ragged": lambda: [[1, 2], [3]],
        "lies": lambda: Lies(array),
        "number": lambda: chance.choice(NUMBERS),
    }
    return changes[chance.choice(list(changes))]()


def with_value(array):
    copy = array.copy()
    value = chance.choice([0, 1, 255, np.nan, np.inf, -np.inf, 1e308, -1, 2**31, 2**32 - 1, 2**63])
    with np.errstate(all="ignore"):
        try:
            copy.flat[chance.randrange(copy.size)] = value
        except (OverflowError, ValueError):
            pass
    return copy


def spoilt_camera(camera):
    """Return a camera with another size or another matrix, or something else."""
    kind = chance.randrange(5)
    if kind == 0:
        return chance.choice(NUMBERS)
    if kind == 1:
        return lumatlas.Camera.__new__(lumatlas.Camera)
    if kind == 2:
        size = chance.choice([0, 1, 2, 65536, 60000, 40000])  # what is drawn and not refused would take minutes
        return lumatlas.Camera(size, chance.choice([size, 1]), 10)
    if kind == 3:
        return lumatlas.Camera(camera.width, camera.height, camera.fx, cam_from_world=spoilt(camera.cam_from_world))
    return lumatlas.Camera(camera.width, camera.height, *(chance.choice(NUMBERS) for _ in range(4)))


def changed(mapping, change):
    """Return a copy with one item or name changed, or another mapping."""
    copy = dict(mapping)
    name = chance.choice(list(copy))
    kind = chance.randrange(6)
    if kind == 0:
        copy[chance.choice(NAMES)] = copy.pop(name)
    elif kind == 1:
        return chance.choice([Mapping(copy), [], None, 3, "ab", {}])
    else:
        copy[name] = change(copy[name])
    return copy


def huge_pair(pictures, cameras):
    """Add a photograph of one pixel's memory that is as large as its camera says."""
    side = 65536
    name = next(iter(pictures))
    pictures[name] = np.broadcast_to(np.uint8(3), (side, side, 3))
    cameras[name] = lumatlas.Camera(side, side, side)


def attempt_scene(disk, vertices, faces):
    pictures, cameras = {name: disk.photograph(name) for name in disk.names}, dict(disk.cameras)
    masks = {name: np.ones(picture.shape[:2], bool) for name, picture in list(pictures.items())[:2]}
    points = vertices
    for _ in range(chance.randrange(1, 3)):
        kind = chance.randrange(7)
        if kind == 0:
            pictures = changed(pictures, spoilt)
        elif kind == 1:
            cameras = changed(cameras, spoilt_camera)
        elif kind == 2:
            masks = changed(masks, spoilt)
        elif kind == 3:
            vertices = spoilt(vertices)
        elif kind == 4:
            faces = spoilt(faces)
        elif kind == 5:
            points = spoilt(points)
        elif isinstance(pictures, dict) and pictures and isinstance(cameras, dict):
            huge_pair(pictures, cameras)
    scene = lumatlas.Scene.from_arrays(pictures, cameras, vertices, faces, masks=masks, points=points)
    lumatlas.inspect(scene)
    with tempfile.TemporaryDirectory() as folder:
        model = lumatlas.build(scene, Path(folder) / "model", refine="none", texture=None)
        attempt_pictures(model)


def attempt_pictures(model):
    camera = next(iter(model.cameras.values()))
    if chance.randrange(2):
        camera = spoilt_camera(camera)
    chance.choice([
        lambda: model.render(camera, mode=chance.choice(["picture", "trust", "error", "x", None, "depth"])),
        lambda: model.render(camera, value_range=(chance.choice(NUMBERS), chance.choice(NUMBERS)), mode="depth"),
        lambda: model.render(camera, mode="error", photograph=spoilt(np.zeros((48, 64, 3), np.uint8))),
        lambda: model.depth(camera),
        lambda: model.render_with_state(camera),
        lambda: model.tour(frames=chance.choice(NUMBERS), width=chance.choice(NUMBERS), height=chance.choice(NUMBERS)),
    ])()


def attempt_options(scene):
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "model"
        option = chance.choice(["mesh_scale", "mesh_axes", "mesh_shift", "hold", "block", "max_views", "gpu_bytes", "texels",
                                "loss", "faces", "cell_size", "texture", "quality", "image", "refine", "progress"])
        value = chance.choice([*NUMBERS, (1e308, 0, 0), [1, 2], "x,y,z", "x,x,x", ("x", "y", "z"), np.zeros((3, 3)),
                               lambda *_: 1 / 0, lambda: True, lambda *_: "no"])
        lumatlas.build(scene, target, **{"refine": "none", "texture": None, option: value})


def problem_with(error):
    """Return what is wrong with an exception, or None."""
    text = str(error)
    if isinstance(error, (ZeroDivisionError, KeyError)):
        return None  # raised here
    if isinstance(error, RuntimeError) and text == "no array today":
        return None
    if isinstance(error, UnicodeError):
        return None
    if not isinstance(error, EXPECTED):
        return f"{type(error).__name__} is none of those that are told of: {text}"
    if not text.strip():
        return f"{type(error).__name__} says nothing"
    if "Unable to cast" in text or "unknown exception" in text.lower():
        return f"{type(error).__name__} names nothing: {text}"
    return None


def main():
    disk = lumatlas.load_scene(sys.argv[3])
    grid = np.stack(np.meshgrid(np.linspace(-3, 3, 12), np.linspace(-3, 3, 12), indexing="ij"), -1).reshape(-1, 2)
    vertices = np.column_stack([grid, np.ones(len(grid))])
    corner = (np.arange(11)[:, None] * 12 + np.arange(11)).reshape(-1)
    faces = np.concatenate([np.column_stack([corner, corner + 1, corner + 13]),
                            np.column_stack([corner, corner + 13, corner + 12])])
    for turn in range(8):
        try:
            if chance.randrange(4) == 0:
                attempt_options(disk)
            else:
                attempt_scene(disk, vertices, faces)
        except Exception as error:  # noqa: BLE001
            problem = problem_with(error)
            if problem:
                sys.exit(f"arrays.py: at its turn {turn}, {problem}")
        gc.collect()


main()
