# SPDX-License-Identifier: GPL-3.0-or-later
from os import PathLike
from pathlib import Path
from typing import Any, Callable, Collection, Literal, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

_PathLike = Union[str, "PathLike[str]"]
_Progress = Optional[Callable[[str, int, int], Optional[bool]]]
_Mode = Literal[
    "picture", "coverage", "references", "valid-views", "winner", "weights", "trust", "cells", "depth", "error"
]

__version__: str

class Error(RuntimeError): ...
class InputError(Error): ...
class GlError(Error): ...
class Stopped(Error): ...

class Camera:
    def __init__(
        self,
        width: int,
        height: int,
        fx: float,
        fy: Optional[float] = None,
        cx: Optional[float] = None,
        cy: Optional[float] = None,
        cam_from_world: Optional[ArrayLike] = None,
    ) -> None: ...
    @staticmethod
    def looking_at(
        position: Sequence[float],
        target: Sequence[float],
        up: Sequence[float],
        width: int,
        height: int,
        fov_deg: float = 70.0,
    ) -> Camera: ...
    def scaled_to(self, width: int, height: int) -> Camera: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def fx(self) -> float: ...
    @property
    def fy(self) -> float: ...
    @property
    def cx(self) -> float: ...
    @property
    def cy(self) -> float: ...
    @property
    def center(self) -> list[float]: ...
    @property
    def cam_from_world(self) -> NDArray[np.float64]: ...

class Scene:
    @staticmethod
    def from_arrays(
        photographs: Mapping[str, NDArray[np.uint8]],
        cameras: Mapping[str, Camera],
        vertices: Optional[ArrayLike] = None,
        faces: Optional[ArrayLike] = None,
        *,
        masks: Optional[Mapping[str, Union[NDArray[np.uint8], NDArray[np.bool_]]]] = None,
        points: Optional[ArrayLike] = None,
    ) -> Scene: ...
    @property
    def path(self) -> Path: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def cameras(self) -> dict[str, Camera]: ...
    @property
    def bad(self) -> dict[str, str]: ...
    def held_out(self, hold: int = 8, block: int = 1) -> list[str]: ...
    def photograph(self, name: str) -> NDArray[np.uint8]: ...
    def __len__(self) -> int: ...

class Model:
    @property
    def path(self) -> Path: ...
    @property
    def cameras(self) -> dict[str, Camera]: ...
    @property
    def summary(self) -> Optional[dict[str, Any]]: ...
    def render(
        self,
        camera: Camera,
        *,
        mode: _Mode = "picture",
        background: Optional[str] = None,
        value_range: Optional[tuple[float, float]] = None,
        color_bar: bool = False,
        draft: bool = False,
        photograph: Optional[NDArray[np.uint8]] = None,
    ) -> NDArray[np.uint8]: ...
    def render_values(
        self,
        camera: Camera,
        *,
        mode: _Mode = "picture",
        draft: bool = False,
        photograph: Optional[NDArray[np.uint8]] = None,
    ) -> NDArray[np.float32]: ...
    def render_with_state(self, camera: Camera) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]: ...
    def depth(self, camera: Camera) -> NDArray[np.float32]: ...
    def tour(
        self,
        kind: Literal["orbit", "walk", "hilbert"] = "orbit",
        *,
        path: Optional[_PathLike] = None,
        frames: int = 120,
        width: int = 1280,
        height: int = 720,
        fov_deg: float = 70.0,
        anywhere: bool = False,
    ) -> list[Camera]: ...

def load_scene(
    path: _PathLike,
    *,
    images: Optional[_PathLike] = None,
    masks: Optional[_PathLike] = None,
    skip_bad: bool = False,
) -> Scene: ...
def capture(
    photographs: _PathLike,
    output: _PathLike,
    *,
    work: Optional[_PathLike] = None,
    masks: Optional[_PathLike] = None,
    max_frames: int = 300,
    matching: Literal["automatic", "exhaustive", "sequential", "spatial"] = "automatic",
    vocabulary: Optional[_PathLike] = None,
    camera_model: str = "SIMPLE_RADIAL",
    mapper: Literal["incremental", "global"] = "incremental",
    poses: Optional[_PathLike] = None,
    use_gpu: bool = False,
    source: Optional[Literal["photographs", "points"]] = None,
    points: Optional[_PathLike] = None,
    hold: Optional[int] = None,
    block: int = 1,
    max_views: Optional[int] = None,
    progress: _Progress = None,
) -> dict[str, Any]: ...
def make_mesh(
    scene: Scene,
    output: _PathLike,
    *,
    source: Optional[Literal["photographs", "depth", "points"]] = None,
    points: Optional[_PathLike] = None,
    complete: Optional[_PathLike] = None,
    hold: Optional[int] = None,
    block: int = 1,
    match_size: Optional[int] = None,
    neighbors: Optional[int] = None,
    most_photographs: Optional[int] = None,
    voxel: Optional[float] = None,
    depth_unit: Optional[float] = None,
    most_faces: Optional[int] = None,
    spacing: Optional[float] = None,
    most_points: Optional[int] = None,
    longest_edge: Optional[float] = None,
    progress: _Progress = None,
) -> dict[str, Any]: ...
def build(
    scene: Scene,
    output: _PathLike,
    *,
    mesh: Optional[_PathLike] = None,
    mesh_scale: Optional[float] = None,
    mesh_axes: Optional[str] = None,
    mesh_shift: Optional[Sequence[float]] = None,
    mesh_as_given: bool = False,
    hold: Optional[int] = None,
    block: int = 1,
    max_views: Optional[int] = None,
    gpu_bytes: Optional[int] = None,
    texels: Optional[int] = None,
    loss: Optional[float] = None,
    memory_bytes: Optional[int] = None,
    faces: Optional[Union[int, Literal["keep", "auto"]]] = None,
    cell_size: float = 0.0,
    refine: Literal["none", "exposure", "pose", "all", "joint"] = "joint",
    texture: Optional[int] = 2048,
    image: Literal["png", "jpeg"] = "png",
    quality: Optional[int] = None,
    settings: Mapping[str, Union[bool, int, float, str]] = ...,
    progress: _Progress = None,
) -> Model: ...
def open_model(path: _PathLike) -> Model: ...
def validate(
    model: Model,
    scene: Scene,
    *,
    hold: Optional[int] = None,
    block: int = 1,
    baselines: Collection[Literal["texture", "unbounded", "vertex"]] = ...,
    aligned: bool = False,
    progress: _Progress = None,
) -> dict[str, Any]: ...
def render(
    model: Model,
    cameras: Union[dict[str, Camera], Sequence[Camera]],
    output: _PathLike,
    *,
    mode: _Mode = "picture",
    background: Optional[str] = None,
    value_range: Optional[tuple[float, float]] = None,
    color_bar: bool = True,
    draft: bool = False,
    format: Literal["png", "exr", "mp4"] = "png",
    fps: float = 30.0,
    progress: _Progress = None,
) -> list[Path]: ...
def export(
    model: Model,
    output: _PathLike,
    *,
    form: Literal["glb", "gltf", "obj", "web"] = "glb",
    image: Optional[Literal["png", "jpeg", "webp"]] = None,
    quality: Optional[int] = None,
    as_scene: bool = False,
    texture: Optional[int] = None,
    pages: Optional[int] = None,
    density: Optional[float] = None,
    exposure: Optional[Literal["nearby", "model"]] = None,
    scene: Optional[Scene] = None,
    progress: _Progress = None,
) -> dict[str, Any]: ...
def inspect(
    subject: Union[Scene, Model],
    *,
    mesh: Optional[_PathLike] = None,
    mesh_scale: Optional[float] = None,
    mesh_axes: Optional[str] = None,
    mesh_shift: Optional[Sequence[float]] = None,
    cell_size: float = 0.0,
) -> dict[str, Any]: ...
