# SPDX-License-Identifier: GPL-3.0-or-later
from os import PathLike
from pathlib import Path
from typing import Any, Callable, Collection, Literal, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

_PathLike = Union[str, "PathLike[str]"]

__version__: str

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
    def render(self, camera: Camera) -> NDArray[np.uint8]: ...
    def render_with_state(self, camera: Camera) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]: ...
    def depth(self, camera: Camera) -> NDArray[np.float32]: ...

def load_scene(
    path: _PathLike,
    *,
    images: Optional[_PathLike] = None,
    masks: Optional[_PathLike] = None,
    skip_bad: bool = False,
) -> Scene: ...
def make_mesh(scene: Scene, output: _PathLike, *, points: Optional[_PathLike] = None) -> dict[str, Any]: ...
def build(
    scene: Scene,
    output: _PathLike,
    *,
    mesh: Optional[_PathLike] = None,
    hold: Optional[int] = None,
    block: int = 1,
    max_views: Optional[int] = 100,
    refine: Literal["none", "exposure", "pose", "all", "joint"] = "joint",
    image: Literal["png", "jpeg"] = "png",
    progress: Optional[Callable[[str, int, int], Optional[bool]]] = None,
) -> Model: ...
def open_model(path: _PathLike) -> Model: ...
def validate(
    model: Model,
    scene: Scene,
    *,
    hold: Optional[int] = None,
    block: int = 1,
    baselines: Collection[Literal["texture", "unbounded", "vertex"]] = (),
    aligned: bool = False,
) -> dict[str, Any]: ...
