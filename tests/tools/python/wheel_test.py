# SPDX-License-Identifier: GPL-3.0-or-later
"""Usage: wheel_test.py PROGRAM SOURCE BUILD, the program `lumatlas`, the sources, and a build of the module.

`pip install ./tools/python` makes a wheel that another Python environment imports.
"""

import base64
import csv
import hashlib
import os
import subprocess
import sys
import tarfile
import tempfile
import unittest
import zipfile
from pathlib import Path

from support import make_office, skip

PROGRAM, SOURCE, BUILD = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
PACKAGE = SOURCE / "tools" / "python"


def run(*command, **options):
    return subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          **options)


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name)
        os.chdir(cls.folder)
        # Neither PATH nor the sources are to give the module; pip is the system's, for its own copy takes 3 s to install.
        cls.environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
        cls.environment.update(PYTHONDONTWRITEBYTECODE="1", PIP_CACHE_DIR=str(cls.folder / "cache"))
        made = run(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", "venv")
        if made.returncode != 0:
            skip("venv makes no environment: " + made.stdout.strip().split("\n")[-1])
        cls.python = cls.folder / "venv" / "bin" / "python"

    @classmethod
    def tearDownClass(cls):
        os.chdir("/")
        cls.temporary.cleanup()

    def pip(self, *arguments, **options):
        return run(self.python, "-m", "pip", *arguments, env=self.environment, **options)

    def test_pip_installs_a_wheel_that_opens_a_model(self):
        make_office(PROGRAM)
        run(PROGRAM, "build", "office", "-o", "model", "--refine", "none", "--quiet", check=True)
        before = sorted([*SOURCE.iterdir(), *PACKAGE.iterdir()])
        installed = self.pip("install", "--no-deps", "--no-index", "--config-settings", f"build-dir={BUILD}", PACKAGE)
        self.assertEqual(installed.returncode, 0, installed.stdout)
        self.assertEqual(before, sorted([*SOURCE.iterdir(), *PACKAGE.iterdir()]))
        script = ("import lumatlas; print(lumatlas.__version__, len(lumatlas.open_model('model').cameras) > 0, "
                  "lumatlas.__file__)")
        said = run(self.python, "-c", script, env=self.environment).stdout
        self.assertRegex(said, rf"^\d+\.\d+\.\d+ True {self.folder}/venv/lib/.*/lumatlas/__init__.py")
        checked = self.pip("check")
        self.assertNotIn("lumatlas", checked.stdout)
        self.assertEqual(self.pip("uninstall", "--yes", "lumatlas").returncode, 0)

    def test_the_wheel_records_its_files(self):
        made = self.pip("wheel", "--no-deps", "--no-index", "--config-settings", f"build-dir={BUILD}", "-w", "wheels",
                        PACKAGE)
        self.assertEqual(made.returncode, 0, made.stdout)
        (wheel,) = Path("wheels").iterdir()
        version = f"{sys.version_info.major}{sys.version_info.minor}"
        self.assertRegex(wheel.name, rf"^lumatlas-[0-9.]+-cp{version}-cp{version}-linux_\w+\.whl$")
        with zipfile.ZipFile(wheel) as archive:
            self.assertIsNone(archive.testzip())
            names = archive.namelist()
            (record,) = (name for name in names if name.endswith("/RECORD"))
            rows = list(csv.reader(archive.read(record).decode().splitlines()))
            self.assertEqual([row[0] for row in rows], names)
            for name, digest, size in rows:
                if name == record:
                    self.assertEqual((digest, size), ("", ""))
                    continue
                data = archive.read(name)
                expected = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
                self.assertEqual((digest, size), (f"sha256={expected}", str(len(data))), name)
            (about,) = (name for name in names if name.endswith("/METADATA"))
            self.assertIn("Requires-Dist: numpy", archive.read(about).decode())
            self.assertTrue({"lumatlas/__init__.py", "lumatlas/__init__.pyi", "lumatlas/py.typed"} <= set(names))

    def test_a_folder_without_a_build_is_refused(self):
        for folder, sentence in ((self.folder, "which holds no build"), (self.folder / "nowhere", "which holds no build")):
            refused = self.pip("wheel", "--no-deps", "--no-index", "--config-settings", f"build-dir={folder}", "-w",
                               "none", PACKAGE)
            self.assertNotEqual(refused.returncode, 0)
            self.assertIn(sentence, refused.stdout)

    def test_an_archive_holds_the_sources(self):
        if not (SOURCE / ".git").exists():
            self.skipTest("the sources are in no git repository")
        script = (f"import sys; sys.path.insert(0, {str(SOURCE / 'tools' / 'python')!r}); import wheel_backend; "
                  "print(wheel_backend.build_sdist('.'))")
        name = run(self.python, "-c", script, env=self.environment, check=True).stdout.strip()
        with tarfile.open(name) as archive:
            folder = name.removesuffix(".tar.gz")
            held = set(archive.getnames())
            project = archive.extractfile(f"{folder}/pyproject.toml").read().decode()
        self.assertIn('backend-path = ["tools/python"]', project)
        for file in ("PKG-INFO", "pyproject.toml", "CMakeLists.txt", "tools/python/wheel_backend.py"):
            self.assertTrue(f"{folder}/{file}" in held, file)


if __name__ == "__main__":
    if run(sys.executable, "-m", "pip", "--version").returncode != 0:
        skip("pip is not installed")
    if run(sys.executable, "-c", "import venv").returncode != 0:
        skip("venv is not installed")
    unittest.main(argv=sys.argv[:1])
