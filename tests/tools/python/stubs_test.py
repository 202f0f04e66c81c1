# SPDX-License-Identifier: GPL-3.0-or-later
"""Usage: stubs_test.py FOLDER, the folder of the module's page and stubs.

The stubs say what the module holds, and mypy takes them and the page's example.
"""

import ast
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from support import lumatlas, skip

FOLDER = Path(sys.argv[1])
CACHE = tempfile.TemporaryDirectory()  # what mypy has read of NumPy, once for all tests


def run_mypy(module, *arguments):
    """Run mypy and return its exit status and what it says."""
    environment = dict(os.environ, MYPY_CACHE_DIR=CACHE.name)
    ended = subprocess.run([sys.executable, "-m", module, *arguments], stdout=subprocess.PIPE,
                           stderr=subprocess.STDOUT, text=True, env=environment, cwd=CACHE.name)
    return ended.returncode, ended.stdout


class Stubs(unittest.TestCase):
    def test_mypy_takes_the_stubs_and_the_example_of_the_page(self):
        block = re.search(r"```python\n(.*?)```", (FOLDER / "README.md").read_text(), re.DOTALL)[1]
        # The example leaves types out, as people do who try it.
        untyped = ["--allow-untyped-defs", "--allow-untyped-calls"]
        with tempfile.TemporaryDirectory() as folder:
            example = Path(folder) / "example.py"
            example.write_text(block)
            for arguments in ([str(FOLDER / "lumatlas" / "__init__.pyi")], [*untyped, str(example)]):
                self.assertEqual(run_mypy("mypy", "--strict", *arguments)[1][:7], "Success")

    def test_mypy_finds_a_wrong_call(self):
        with tempfile.TemporaryDirectory() as folder:
            wrong = Path(folder) / "wrong.py"
            wrong.write_text("import lumatlas\nlumatlas.open_model(3)\nlumatlas.export(2, 'a')\n")
            status, said = run_mypy("mypy", "--strict", str(wrong))
            self.assertEqual((status, said.count("error:")), (1, 2), said)

    def test_the_stubs_agree_with_the_module(self):
        # The compiled part, _lumatlas, needs no stubs: its names are those of the package.
        # pybind11 gives its classes a metaclass, and an __init__ that refuses all arguments to those without one.
        with tempfile.NamedTemporaryFile("w") as allowed:
            allowed.write("lumatlas\\.(Camera|Model|Scene)\nlumatlas\\.(Model|Scene)\\.__init__\n")
            allowed.flush()
            status, said = run_mypy("mypy.stubtest", "lumatlas", "--ignore-missing-stub", "--allowlist", allowed.name,
                                    "--ignore-unused-allowlist")
        self.assertEqual(status, 0, said)

    def test_the_stubs_name_what_is_there(self):
        stubs = ast.parse((FOLDER / "lumatlas" / "__init__.pyi").read_text())
        named = set()
        for node in stubs.body:
            if isinstance(node, ast.ClassDef):
                named.add(node.name)
                members = {part.name for part in node.body if isinstance(part, ast.FunctionDef)}
                there = {name for name in vars(getattr(lumatlas, node.name)) if not name.startswith("_")}
                self.assertEqual({name for name in members if not name.startswith("_")}, there, node.name)
            elif isinstance(node, ast.FunctionDef):
                named.add(node.name)
                stated = [arg.arg for arg in node.args.args + node.args.kwonlyargs]
                signature = getattr(lumatlas, node.name).__doc__.split("\n")[0]
                self.assertEqual(stated, re.findall(r"(\w+): ", signature), node.name)
            elif isinstance(node, ast.AnnAssign):
                named.add(node.target.id)
        self.assertEqual(named, set(lumatlas.__all__))
        for name in named:
            self.assertTrue(hasattr(lumatlas, name), name)


if __name__ == "__main__":
    if subprocess.run([sys.executable, "-m", "mypy", "--version"], capture_output=True).returncode != 0:
        skip("mypy is not installed")
    unittest.main(argv=sys.argv[:1])
