# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds a wheel of the Python module, and an archive of the sources, for pip (PEP 517).

The wheel is for the Python that runs this, and for machines with the same system libraries. CMake builds in
build/wheel-TAG of the sources. `--config-settings build-dir=DIR` takes the module of a build that is in DIR instead, and
leaves that build's settings as they are.
"""

import base64
import csv
import hashlib
import io
import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
PACKAGE = Path(__file__).resolve().parent / "lumatlas"
TARGET = "lumatlas_python"
OPTIONS = {
    "CMAKE_BUILD_TYPE": "Release",
    "LUMATLAS_PYTHON": "ON",
    "LUMATLAS_TOGETHER": "ON",
    "LUMATLAS_TESTS": "OFF",
    "LUMATLAS_BENCHMARKS": "OFF",
    "LUMATLAS_INSTALL": "OFF",
}


def version():
    """Return the version that CMakeLists.txt gives the project."""
    return re.search(r"^project\(lumatlas VERSION ([0-9.]+)", (SOURCE / "CMakeLists.txt").read_text(), re.M)[1]


def tag():
    """Return the wheel's tag, such as "cp311-cp311-linux_x86_64"."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    abi = "cp" + sysconfig.get_config_var("SOABI").split("-")[1]
    return f"{python}-{abi}-" + re.sub(r"[^A-Za-z0-9_]", "_", sysconfig.get_platform())


def metadata():
    """Return the text of METADATA."""
    head = [
        "Metadata-Version: 2.1",
        "Name: lumatlas",
        f"Version: {version()}",
        "Summary: View-dependent textured scenes from a mesh and posed photographs",
        "License: GPL-3.0-or-later",
        f"Requires-Python: =={sys.version_info.major}.{sys.version_info.minor}.*",
        "Requires-Dist: numpy",
        "Description-Content-Type: text/markdown",
    ]
    return "\n".join(head) + "\n\n" + (PACKAGE.parent / "README.md").read_text(encoding="utf-8")


def run_cmake(*arguments):
    """Run CMake; its output is shown by `pip -v`, and where it fails."""
    try:
        subprocess.run(["cmake", *arguments], check=True)
    except FileNotFoundError:
        raise SystemExit("lumatlas: cmake is not in PATH: tools/install-packages --program installs what is needed")
    except subprocess.CalledProcessError as error:
        raise SystemExit(f"lumatlas: cmake {' '.join(arguments)} failed with exit status {error.returncode}")


def configure(folder):
    """Set up a build of the module for this Python."""
    settings = [f"-D{name}={value}" for name, value in OPTIONS.items()]
    run_cmake("-S", str(SOURCE), "-B", str(folder), f"-DPython3_EXECUTABLE={sys.executable}", *settings)


def built_files(config_settings):
    """Build the compiled part; return the paths of the module and of the library that it opens for images, if any."""
    given = (config_settings or {}).get("build-dir")
    folder = Path(given).resolve() if given else SOURCE / "build" / f"wheel-{tag()}"
    if not given:
        configure(folder)
    elif not (folder / "CMakeCache.txt").is_file():
        raise SystemExit(f"lumatlas: build-dir is {given}, which holds no build: leave it out to make one")
    run_cmake("--build", str(folder), "--target", TARGET, "--parallel", str(os.cpu_count()))
    module = folder / "tools" / "python" / "lumatlas" / ("_lumatlas" + sysconfig.get_config_var("EXT_SUFFIX"))
    if not module.is_file():
        raise SystemExit(f"lumatlas: {module} was not built: {folder} is a build for another Python than {sys.executable}")
    return [module, *(folder / "atlas").glob("liblumatlas-images.so")]


def record_line(name, data):
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return [name, f"sha256={digest}", str(len(data))]


def write_wheel(path, files):
    """Write the files, names and bytes, with their RECORD."""
    info = f"lumatlas-{version()}.dist-info"
    record = io.StringIO()
    lines = csv.writer(record, lineterminator="\n")
    lines.writerows([record_line(name, data) for name, data in files.items()] + [[f"{info}/RECORD", "", ""]])
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in {**files, f"{info}/RECORD": record.getvalue().encode()}.items():
            entry = zipfile.ZipInfo(name, (2020, 1, 1, 0, 0, 0))
            entry.external_attr = (0o100755 if name.endswith(".so") else 0o100644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)


def info_files():
    info = f"lumatlas-{version()}.dist-info"
    wheel = f"Wheel-Version: 1.0\nGenerator: lumatlas ({version()})\nRoot-Is-Purelib: false\nTag: {tag()}\n"
    return {
        f"{info}/METADATA": metadata().encode(),
        f"{info}/WHEEL": wheel.encode(),
        f"{info}/LICENSE": (SOURCE / "LICENSE").read_bytes(),
    }


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """Write what pip asks for before a build, and return the folder's name (PEP 517)."""
    for name, data in info_files().items():
        path = Path(metadata_directory) / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return f"lumatlas-{version()}.dist-info"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Build the module, write the wheel, and return the wheel's name (PEP 517)."""
    built = built_files(config_settings)
    files = {f"lumatlas/{name}": (PACKAGE / name).read_bytes() for name in ("__init__.py", "__init__.pyi", "py.typed")}
    files.update({f"lumatlas/{file.name}": file.read_bytes() for file in built})
    name = f"lumatlas-{version()}-{tag()}.whl"
    write_wheel(Path(wheel_directory) / name, {**files, **info_files()})
    return name


def build_sdist(sdist_directory, config_settings=None):
    """Write an archive of the files that git tracks, and return the archive's name (PEP 517)."""
    try:
        listed = subprocess.run(["git", "-C", str(SOURCE), "ls-files", "-z"], check=True, capture_output=True).stdout
    except (OSError, subprocess.CalledProcessError):
        raise SystemExit(f"lumatlas: {SOURCE} is no git repository, whose files an archive would hold")
    folder = f"lumatlas-{version()}"
    name = f"{folder}.tar.gz"
    with tarfile.open(Path(sdist_directory) / name, "w:gz", format=tarfile.PAX_FORMAT) as archive:
        for file in sorted(os.fsdecode(part) for part in listed.split(b"\0") if part):
            if (SOURCE / file).exists():
                archive.add(SOURCE / file, f"{folder}/{file}", recursive=False)
        # pip looks for both in the root of an archive.
        project = (PACKAGE.parent / "pyproject.toml").read_text(encoding="utf-8")
        project = project.replace('backend-path = ["."]', 'backend-path = ["tools/python"]')
        for text, called in ((project, "pyproject.toml"), (metadata(), "PKG-INFO")):
            entry = tarfile.TarInfo(f"{folder}/{called}")
            entry.size = len(text.encode())
            archive.addfile(entry, io.BytesIO(text.encode()))
    return name
