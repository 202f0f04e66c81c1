# SPDX-License-Identifier: GPL-3.0-or-later
"""Usage: jobs_test.py PROGRAM, the program `lumatlas`.

Each job of the program, from Python.
"""

import json
import os
import shutil
import signal
import stat
import subprocess
import sys
import unittest
import warnings
from pathlib import Path

from support import InOffice, lumatlas, np, read_ply, stopping

PROGRAM = sys.argv[1]

# Stands for COLMAP: leaves the model that lies beside it.
COLMAP = """#!/bin/sh
folder=$(dirname "$0")
command=$1
shift
[ "$1" != -h ] || exit 0
while [ $# -gt 0 ]; do
  case $1 in
    --database_path) database=$2 ;;
    --output_path) output=$2 ;;
  esac
  shift 2
done
case $command in
  feature_extractor) echo "Processed file [12/12]"; echo "  Features:        866"; : > "$database" ;;
  exhaustive_matcher)
    echo "Matching block [1/2, 1/1]"
    if [ -f "$folder/slow" ]; then sleep 60; fi ;;
  mapper) mkdir -p "$output/0" && cp "$folder"/model/* "$output/0" ;;
esac
"""


class Jobs(InOffice):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scene = lumatlas.load_scene("office")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            cls.model = lumatlas.build(cls.scene, "model", hold=4, refine="none", cell_size=0.3)
        cls.camera = cls.scene.cameras[cls.scene.names[0]]

    def setUp(self):
        warnings.simplefilter("ignore")

    def test_a_mesh_is_made_of_what_is_asked_for(self):
        facts = lumatlas.make_mesh(self.scene, "points.ply", source="points")
        vertices, faces = read_ply(Path("points.ply"))
        self.assertEqual((facts["from"], facts["mesh"]), ("points", {"vertices": len(vertices), "faces": len(faces)}))
        facts = lumatlas.make_mesh(self.scene, "matched.ply", match_size=96, neighbors=2, hold=4)
        self.assertEqual((facts["from"], facts["views"]["matched"]), ("photographs", 9))
        facts = lumatlas.make_mesh(self.scene, "completed.ply", source="points", complete="office/mesh.ply")
        self.assertEqual(facts["completion"]["mesh"], "office/mesh.ply")
        coarse = lumatlas.make_mesh(self.scene, "coarse.ply", source="points", spacing=20)
        self.assertLess(coarse["mesh"]["faces"], len(faces))

    def test_a_mesh_refuses_what_it_would_ignore(self):
        for arguments, sentence in (
            ({"source": "points", "voxel": 1}, "voxel is for depth images, and this mesh is made of points"),
            ({"source": "points", "hold": 4}, "hold is for photographs, and this mesh is made of points"),
            ({"source": "sand"}, "source is 'sand', must be photographs, depth or points"),
            ({"spacing": -1}, "spacing_px"),
        ):
            with self.assertRaisesRegex(ValueError, sentence):
                lumatlas.make_mesh(self.scene, "other.ply", **arguments)
        with self.assertRaisesRegex(ValueError, "'other.obj', must end in .ply"):
            lumatlas.make_mesh(self.scene, "other.obj")
        with self.assertRaisesRegex(lumatlas.InputError, "depth"):
            lumatlas.make_mesh(self.scene, "other.ply", source="depth")
        self.assertFalse(Path("other.ply").exists())

    def test_a_build_keeps_to_its_budgets(self):
        whole = lumatlas.inspect(self.model)
        self.assertEqual(len(lumatlas.build(self.scene, "few", max_views=3, refine="none", cell_size=0.5).cameras), 3)
        small = lumatlas.build(self.scene, "small", gpu_bytes=1 << 20, refine="none")
        self.assertLessEqual(small.summary["gpu"]["sum"], 1 << 20)
        self.assertGreater(whole["gpu"]["sum"], 1 << 20)
        texels = lumatlas.build(self.scene, "texels", texels=100_000, refine="none", cell_size=0.5).summary["texels"]
        self.assertLessEqual(texels["resident"], 100_000)
        lost = lumatlas.build(self.scene, "lost", loss=0.5, refine="none", cell_size=0.5).summary["parsimony"]
        self.assertEqual(lost["bound_db"], 0.5)
        faces = lumatlas.build(self.scene, "faces", faces=2000, mesh_as_given=True, refine="none", texture=None,
                               image="jpeg", quality=80, cell_size=0.5).summary["faces"]
        self.assertGreater(faces["taken_away"], 0)

    def test_a_build_is_the_programs(self):
        lumatlas.build(self.scene, "one", gpu_bytes=2 << 20, hold=4)
        subprocess.run([PROGRAM, "build", "office", "-o", "other", "--budget", "2MiB", "--hold", "4", "--quiet"],
                       check=True, stdout=subprocess.DEVNULL)
        one, other = (lumatlas.open_model(path).summary for path in ("one", "other"))
        for key in ("views", "texels", "gpu", "faces", "references"):
            self.assertEqual(one[key], other[key], key)

    def test_settings_are_those_of_the_program(self):
        given = {"coverage.direction-weight": 0.5, "coverage.references": 4, "surface.exact": True,
                 "stream.order": "shuffled", "stream.seed": 3}
        one = lumatlas.build(self.scene, "set", refine="none", settings=given)
        texts = {"surface.exact": "on"}
        options = [f"--set={name}={texts.get(name, value)}" for name, value in given.items()]
        subprocess.run([PROGRAM, "build", "office", "-o", "set-too", "--refine", "none", "--quiet", *options],
                       check=True, stdout=subprocess.DEVNULL)
        settings, others = (json.loads(Path(folder, "lumatlas.json").read_text())["options"]["settings"]
                            for folder in ("set", "set-too"))
        self.assertEqual(settings, others)
        self.assertEqual(settings["coverage.references"], 4)
        self.assertEqual(one.summary["references"], lumatlas.open_model("set-too").summary["references"])

    def test_wrong_settings_are_refused_as_by_the_program(self):
        for name, value, arguments in (
            ("coverage.reference", 4, {}),
            ("coverage.references", 0, {}),
            ("coverage.references", 2.5, {}),
            ("surface.exact", "perhaps", {}),
            ("stream.seed", 3, {}),
            ("departures.hemisphere", "on", {}),
            ("budget.least-scale", 0.5, {}),
            ("refinement.lenses", "off", {"refine": "none"}),
        ):
            options = [text for key, word in arguments.items() for text in ("--" + key, word)]
            program = subprocess.run(
                [PROGRAM, "build", "office", "-o", "other-model", f"--set={name}={value}", *options],
                capture_output=True, text=True)
            self.assertEqual(program.returncode, 2, program.stderr)
            with self.assertRaises(ValueError) as refused:
                lumatlas.build(self.scene, "other-model", settings={name: value}, **arguments)
            self.assertIn(str(refused.exception), program.stderr)
        self.assertFalse(Path("other-model").exists())

    def test_wrong_budgets_are_refused(self):
        for arguments, sentence in (
            ({"gpu_bytes": 3}, "budget: is 3 bytes, less than"),
            ({"gpu_bytes": 0}, "gpu_bytes is 0"),
            ({"texels": 0}, "texels is 0"),
            ({"gpu_bytes": 1 << 20, "loss": 1}, "more than one is given"),
            ({"loss": -1}, "loss"),
            ({"faces": "many"}, "faces is 'many', must be a number, keep or auto"),
            ({"texture": 1}, "texture"),
            ({"quality": 90}, "quality is 90, but image is png, which is exact"),
            ({"image": "jpeg", "quality": 0}, "quality"),
            ({"image": "gif"}, "image is 'gif'"),
        ):
            with self.assertRaisesRegex(ValueError, sentence):
                lumatlas.build(self.scene, "other-model", **arguments)
        with self.assertRaisesRegex(lumatlas.InputError, "office"):
            lumatlas.build(self.scene, ".", mesh="office/mesh.ply")
        self.assertFalse(Path("other-model").exists())

    def test_a_model_is_exported_in_every_form(self):
        for form, output, file in (("glb", "plain.glb", "plain.glb"), ("gltf", "plain", "plain/scene.gltf"),
                                   ("obj", "wavefront", "wavefront/scene.obj"), ("web", "page.html", "page.html"),
                                   ("web", "site", "site/index.html")):
            with self.subTest(output=output):
                facts = lumatlas.export(self.model, output, form=form)
                self.assertEqual((facts["format"], facts["output"]), (form, output))
                self.assertTrue(Path(file).is_file())
        facts = lumatlas.export(self.model, "more.glb", image="webp", quality=80, texture=512, pages=2, density=0.5,
                                exposure="model", as_scene=True, scene=self.scene)
        self.assertLessEqual(facts["texture"]["side"], 512)
        self.assertEqual(facts["photographs"]["used"] + facts["photographs"]["outliers"], 9)

    def test_wrong_exports_are_refused(self):
        for arguments, sentence in (
            ({"output": "a.obj"}, "'a.obj', must end in .glb"),
            ({"output": "a", "form": "ply"}, "form is 'ply', must be glb, gltf, obj or web"),
            ({"output": "a", "form": "web", "texture": 64}, "texture is for textured meshes, and the form is web"),
            ({"output": "a", "form": "obj", "image": "webp"}, "webp is for glb and gltf"),
            ({"output": "a.glb", "texture": 3}, "3"),
        ):
            with self.assertRaisesRegex(ValueError, sentence):
                lumatlas.export(self.model, **arguments)
        Path("mine.glb").write_text("a file that no export wrote")
        with self.assertRaisesRegex(lumatlas.InputError, "mine.glb: is nothing that `lumatlas export` wrote"):
            lumatlas.export(self.model, "mine.glb")

    def test_inspect_tells_of_scenes_and_models(self):
        facts = lumatlas.inspect(self.scene)
        self.assertEqual((facts["views"]["count"], facts["views"]["form"]), (12, "COLMAP"))
        self.assertEqual(lumatlas.inspect(self.scene, mesh="office/mesh.ply")["mesh"]["file"], "office/mesh.ply")
        self.assertEqual(lumatlas.inspect(self.model)["views"]["count"], len(self.model.cameras))
        with self.assertRaisesRegex(ValueError, "mesh, its frame and cell_size are for scenes"):
            lumatlas.inspect(self.model, cell_size=1)
        vertices, faces = read_ply(Path("office/mesh.ply"))
        with open("millimetres.obj", "w", encoding="utf-8") as obj:
            obj.writelines(f"v {x!r} {y!r} {z!r}\n" for x, y, z in (1000 * vertices).tolist())
            obj.writelines(f"f {a} {b} {c}\n" for a, b, c in (faces + 1).tolist())
        facts = lumatlas.inspect(self.scene, mesh="millimetres.obj")
        self.assertEqual(facts["fit"]["remedy"]["mesh_scale"], 0.001)
        told = lumatlas.inspect(self.scene, mesh="millimetres.obj", mesh_scale=0.001)
        self.assertIsNone(told["fit"]["likely"])
        self.assertAlmostEqual(told["mesh"]["diameter"], lumatlas.inspect(self.scene)["mesh"]["diameter"], places=4)
        model = lumatlas.build(self.scene, "metres", mesh="millimetres.obj", mesh_scale=0.001, mesh_axes="x,y,z",
                               mesh_shift=(0, 0, 0), refine="none")
        self.assertEqual(len(model.cameras), 12)
        with self.assertRaisesRegex(ValueError, "names x twice"):
            lumatlas.build(self.scene, "metres", mesh="millimetres.obj", mesh_axes="x,x,z")
        with self.assertRaisesRegex(ValueError, "images or masks of its own"):
            lumatlas.inspect(lumatlas.load_scene("office", images="office/images"))

    def test_a_mode_shows_what_the_model_knows(self):
        for mode in ("coverage", "references", "valid-views", "winner", "weights", "trust", "cells", "depth"):
            with self.subTest(mode=mode):
                self.assertEqual(self.model.render(self.camera, mode=mode).shape, (72, 96, 3))
                values = self.model.render_values(self.camera, mode=mode)
                self.assertEqual(values.shape, (72, 96, 3 if mode == "weights" else 1))
        np.testing.assert_allclose(self.model.render_values(self.camera, mode="depth")[..., 0],
                                   self.model.depth(self.camera), rtol=1e-6)
        barred = self.model.render(self.camera, mode="depth", color_bar=True)
        self.assertGreater(barred.shape[0], 72)
        light = self.model.render_values(self.camera)
        self.assertEqual((light.dtype, light.shape), (np.dtype(np.float32), (72, 96, 3)))
        photograph = self.scene.photograph(self.scene.names[0])
        errors = self.model.render_values(self.camera, mode="error", photograph=photograph)
        self.assertGreater(np.nanmax(errors), 0)

    def test_a_background_fills_what_is_empty(self):
        away = lumatlas.Camera.looking_at((0, 0, 500), (0, 0, 1000), (0, 1, 0), 64, 48)
        self.assertEqual(self.model.render(away, background="#102030")[0, 0].tolist(), [16, 32, 48])
        clear = self.model.render(away, background="alpha")
        self.assertEqual((clear.shape, clear[..., 3].max()), ((48, 64, 4), 0))

    def test_wrong_pictures_are_refused(self):
        draw = self.model.render
        for call, sentence in (
            (lambda: draw(self.camera, mode="x"), "mode is 'x', must be picture, coverage"),
            (lambda: draw(self.camera, background="x"), "background is 'x', must be alpha"),
            (lambda: draw(self.camera, mode="depth", background="blur"), "background is for the mode picture"),
            (lambda: draw(self.camera, mode="winner", value_range=(0, 1)), "value_range: the mode winner has none"),
            (lambda: draw(self.camera, mode="error"), "photograph is None"),
            (lambda: draw(self.camera, mode="error", photograph=np.zeros((3, 3, 3), np.uint8)), "\\(3, 3, 3\\)"),
            (lambda: self.model.tour("spiral"), "kind is 'spiral', must be orbit, walk or hilbert"),
            (lambda: self.model.tour(frames=0), "frames is 0"),
            (lambda: lumatlas.render(self.model, [], "none"), "cameras: is empty"),
            (lambda: lumatlas.render(self.model, {"../x": self.camera}, "none"), "leads out of its folder"),
            (lambda: lumatlas.render(self.model, [self.camera], "none", format="gif"), "format is 'gif'"),
            (lambda: lumatlas.render(self.model, [self.camera], "none", mode="error"), "mode is 'error'"),
        ):
            with self.assertRaisesRegex(ValueError, sentence):
                call()
        self.assertFalse(Path("none").exists())

    def test_pictures_along_a_path_are_files(self):
        cameras = self.model.tour("orbit", frames=3, width=64, height=48)
        files = lumatlas.render(self.model, cameras, "orbit")
        self.assertEqual([str(file) for file in files], [f"orbit/0000{i}.png" for i in range(3)])
        self.assertTrue(all(file.is_file() for file in files))
        subprocess.run([PROGRAM, "render", "model", "--orbit", "--frames", "3", "--width", "64", "--height", "48",
                        "--background", "white", "-o", "theirs", "--quiet"], check=True, stdout=subprocess.DEVNULL)
        ours = lumatlas.render(self.model, cameras, "ours", background="white")
        for file in ours:
            self.assertEqual(file.read_bytes(), (Path("theirs") / file.name).read_bytes())
        named = lumatlas.render(self.model, self.scene.cameras, "named", mode="depth", format="exr")
        self.assertEqual([file.stem for file in named], [Path(name).stem for name in self.scene.names])
        Path("keys.json").write_text('{"keys": [{"time": 0, "position": [0, 0, 1], "look_at": [1, 0, 1]}, '
                                     '{"time": 1, "position": [1, 0, 1], "look_at": [2, 0, 1]}]}')
        keyed = self.model.tour(path="keys.json", frames=2, width=64, height=48)
        np.testing.assert_allclose(keyed[1].center, [1, 0, 1], atol=1e-9)

    @unittest.skipUnless(shutil.which("ffmpeg"), "ffmpeg is not installed")
    def test_a_path_becomes_a_video(self):
        cameras = self.model.tour("walk", frames=3, width=64, height=48)
        self.assertEqual(lumatlas.render(self.model, cameras, "film", format="mp4", fps=10), [Path("film/video.mp4")])
        self.assertGreater(Path("film/video.mp4").stat().st_size, 0)

    def test_progress_false_ends_each_job_and_leaves_what_was_there(self):
        cameras = self.model.tour("walk", frames=3, width=64, height=48)
        lumatlas.make_mesh(self.scene, "kept.ply", source="points")
        lumatlas.export(self.model, "kept.glb")
        lumatlas.render(self.model, cameras, "kept")
        lumatlas.build(self.scene, "kept-model", refine="none", max_views=3, cell_size=0.5)
        kept = [Path("kept.ply"), Path("kept.glb"), Path("kept/00000.png"), Path("kept-model/tileset.json")]
        before = [path.read_bytes() for path in kept]
        jobs = {
            "mesh": lambda progress: lumatlas.make_mesh(self.scene, "kept.ply", match_size=96, progress=progress),
            "export": lambda progress: lumatlas.export(self.model, "kept.glb", texture=512, progress=progress),
            "rendering": lambda progress: lumatlas.render(self.model, cameras, "kept", mode="depth", progress=progress),
            "build": lambda progress: lumatlas.build(self.scene, "kept-model", progress=progress),
            "validation": lambda progress: lumatlas.validate(self.model, self.scene, progress=progress),
        }

        def press(stage, done, total):
            os.kill(os.getpid(), signal.SIGINT)

        for name, job in jobs.items():
            with self.subTest(job=name):
                for at in (1, 3):
                    with self.assertRaisesRegex(lumatlas.Stopped, f"the {name} was stopped by its caller"):
                        job(stopping(at))
                with self.assertRaises(KeyboardInterrupt):
                    job(press)
                with self.assertRaisesRegex(TypeError, "progress: is a value of type int"):
                    job(3)
        self.assertEqual(before, [path.read_bytes() for path in kept])


class Capture(InOffice):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.bin = Path("bin").absolute()
        shutil.copytree("office/sparse", cls.bin / "model")
        (cls.bin / "colmap").write_text(COLMAP)
        (cls.bin / "colmap").chmod(stat.S_IRWXU)
        cls.path = os.environ["PATH"]

    def setUp(self):
        warnings.simplefilter("ignore")
        os.environ["PATH"] = f"{self.bin}:{self.path}"

    def tearDown(self):
        os.environ["PATH"] = self.path
        (self.bin / "slow").unlink(missing_ok=True)

    def test_a_capture_goes_from_photographs_to_a_model(self):
        stages = []
        facts = lumatlas.capture("office/images", "room", source="points", hold=4, max_views=5,
                                 progress=lambda stage, done, total: stages.append(stage))
        self.assertEqual((facts["output"], facts["scene"]), ("room", "room-capture"))
        self.assertEqual(facts["photographs"]["count"], 12)
        self.assertEqual([step["name"] for step in facts["steps"]], ["features", "matching", "mapping", "mesh", "build"])
        self.assertLessEqual(len(lumatlas.open_model("room").cameras), 5)
        self.assertIn("planning views", stages)
        again = lumatlas.capture("office/images", "room", source="points", hold=4, max_views=5)
        self.assertTrue(all(step["done_before"] for step in again["steps"]))
        scores = lumatlas.validate(lumatlas.open_model("room"), lumatlas.load_scene("room-capture"))
        self.assertEqual(scores["held"], 3)

    def test_a_capture_that_is_stopped_goes_on_later(self):
        (self.bin / "slow").touch()
        with self.assertRaisesRegex(lumatlas.Stopped, "the capture was stopped by its caller"):
            lumatlas.capture("office/images", "later", work="work", source="points",
                             progress=lambda stage, done, total: stage != "matching")
        self.assertFalse(Path("later").exists())
        (self.bin / "slow").unlink()
        facts = lumatlas.capture("office/images", "later", work="work", source="points")
        self.assertEqual([step["done_before"] for step in facts["steps"]], [True, False, False, False, False])

    def test_what_is_missing_is_told(self):
        with self.assertRaisesRegex(ValueError, "matching is 'x', must be automatic, exhaustive, sequential or spatial"):
            lumatlas.capture("office/images", "none", matching="x")
        Path("empty").mkdir(exist_ok=True)
        with self.assertRaisesRegex(lumatlas.InputError, "empty: holds 0 photographs"):
            lumatlas.capture("empty", "none")
        os.environ["PATH"] = str(Path("empty").absolute())
        with self.assertRaisesRegex(lumatlas.InputError, "colmap: no such program in PATH"):
            lumatlas.capture("office/images", "none")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
