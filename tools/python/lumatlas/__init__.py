# SPDX-License-Identifier: GPL-3.0-or-later
"""View-dependent textured scenes from a mesh and posed photographs."""

from ._lumatlas import (
    Camera,
    Error,
    GlError,
    InputError,
    Model,
    Scene,
    Stopped,
    __version__,
    build,
    capture,
    export,
    inspect,
    load_scene,
    make_mesh,
    open_model,
    render,
    validate,
)

__all__ = [
    "Camera",
    "Error",
    "GlError",
    "InputError",
    "Model",
    "Scene",
    "Stopped",
    "__version__",
    "build",
    "capture",
    "export",
    "inspect",
    "load_scene",
    "make_mesh",
    "open_model",
    "render",
    "validate",
]

for _name in __all__:
    if _name != "__version__":
        globals()[_name].__module__ = "lumatlas"
del _name
