# SPDX-License-Identifier: GPL-3.0-or-later
"""View-dependent textured scenes from a mesh and posed photographs."""

from ._lumatlas import (
    Camera,
    Model,
    Scene,
    __version__,
    build,
    load_scene,
    make_mesh,
    open_model,
    validate,
)

__all__ = [
    "Camera",
    "Model",
    "Scene",
    "__version__",
    "build",
    "load_scene",
    "make_mesh",
    "open_model",
    "validate",
]

for _name in (Camera, Model, Scene, build, load_scene, make_mesh, open_model, validate):
    _name.__module__ = "lumatlas"
del _name
