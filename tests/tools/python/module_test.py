# SPDX-License-Identifier: GPL-3.0-or-later
"""Usage: module_test.py PROGRAM FOLDER, the program `lumatlas` and the folder of the module's page and stubs."""

import contextlib
import copy
import io
import json
import os
import pickle
import re
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path

from support import lumatlas, make_office, np

PROGRAM, FOLDER = sys.argv[1], Path(sys.argv[2])


class Module(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.temporary.name)
        os.chdir(cls.folder)
        make_office(PROGRAM)
        cls.scene = lumatlas.load_scene("office")
        cls.steps = []
        cls.model = lumatlas.build(cls.scene, "model", hold=4, progress=lambda *step: cls.steps.append(step))

    @classmethod
    def tearDownClass(cls):
        os.chdir("/")
        cls.temporary.cleanup()

    def camera(self):
        return self.scene.cameras[self.scene.held_out(4)[0]]

    def test_the_example_of_the_page(self):
        blocks = re.findall(r"```python\n(.*?)```", (FOLDER / "README.md").read_text(), re.DOTALL)
        self.assertEqual(len(blocks), 1)
        said = io.StringIO()
        names = {}
        work = self.folder / "example"
        work.mkdir()
        (work / "office").symlink_to(self.folder / "office")
        with contextlib.redirect_stdout(said), contextlib.chdir(work):
            exec(compile(blocks[0], "README.md", "exec"), names)
        self.assertIn("planning views 9 of 9", said.getvalue())
        self.assertRegex(said.getvalue(), r"\d\d\.\d\d dB on 3 held-out photographs")
        self.assertEqual(names["picture"].shape, (480, 640, 3))
        self.assertEqual(names["state"].shape, (480, 640))
        self.assertEqual(names["depth"].shape, (72, 96))
        self.assertEqual(names["photograph"].shape, (72, 96, 3))

    def test_a_scene_has_its_photographs_and_cameras(self):
        self.assertEqual(len(self.scene), 12)
        self.assertEqual(self.scene.names, sorted(self.scene.names))
        self.assertEqual(self.scene.held_out(4), self.scene.names[::4])
        self.assertEqual(self.scene.held_out(hold=6, block=1), self.scene.names[::6])
        camera = self.camera()
        matrix = camera.cam_from_world
        again = lumatlas.Camera(camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, matrix)
        np.testing.assert_array_equal(again.cam_from_world, matrix)
        np.testing.assert_allclose(matrix[:3, :3].T @ -matrix[:3, 3], camera.center, atol=1e-12)

    def test_a_build_tells_its_progress_and_its_summary(self):
        planned = [step for step in self.steps if step[0] == "planning views"]
        self.assertEqual(planned[0], ("planning views", 0, 9))
        self.assertEqual(planned[-1], ("planning views", 9, 9))
        self.assertEqual(self.model.summary["views"]["offered"], 9)
        held = set(self.scene.held_out(4))
        self.assertFalse(held & set(self.model.cameras))

    def test_stored_cameras_are_in_the_coordinates_of_the_scene(self):
        poses = lumatlas.build(self.scene, "as-given", refine="none").cameras
        for name, camera in poses.items():
            np.testing.assert_allclose(camera.cam_from_world, self.scene.cameras[name].cam_from_world, atol=1e-9)

    def test_a_picture_is_near_the_photograph_and_says_where_it_is_from(self):
        picture = self.model.render(self.camera())
        self.assertEqual((picture.dtype, picture.shape), (np.dtype(np.uint8), (72, 96, 3)))
        photograph = self.scene.photograph(self.scene.held_out(4)[0])
        self.assertLess(np.abs(picture.astype(float) - photograph).mean(), 40)
        both, states = self.model.render_with_state(self.camera())
        np.testing.assert_array_equal(both, picture)
        self.assertEqual(states.shape, (72, 96))
        self.assertGreater((states == 3).mean(), 0.3)
        np.testing.assert_array_equal(picture[states == 0], 0)

    def test_depth_is_where_the_surface_is(self):
        depth = self.model.depth(self.camera())
        self.assertEqual((depth.dtype, depth.shape), (np.dtype(np.float32), (72, 96)))
        _, states = self.model.render_with_state(self.camera())
        self.assertGreater((np.isnan(depth) == (states == 0)).mean(), 0.98)
        # Twice as near along the line of sight, the middle of the picture is half as deep.
        camera = self.camera()
        middle = float(depth[36, 48])
        matrix = camera.cam_from_world.copy()
        matrix[2, 3] -= middle / 2
        nearer = lumatlas.Camera(camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, matrix)
        self.assertAlmostEqual(float(self.model.depth(nearer)[36, 48]), middle / 2, delta=0.1 * middle)

    def test_pictures_from_several_threads_are_the_same(self):
        pictures = [None] * 4

        def draw(at):
            pictures[at] = self.model.render(self.camera())

        threads = [threading.Thread(target=draw, args=(at,)) for at in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for picture in pictures:
            np.testing.assert_array_equal(picture, pictures[0])

    def test_scores_are_those_of_the_program(self):
        scores = lumatlas.validate(lumatlas.open_model("model"), self.scene)
        printed = subprocess.run([PROGRAM, "validate", "model", "--views", "office", "--no-alignment", "--no-pictures",
                                  "--baselines", "none", "-o", "report", "--quiet", "--json"], check=True,
                                 capture_output=True, text=True).stdout
        self.assertEqual(scores["methods"], json.loads(printed)["methods"])
        self.assertEqual(scores["held"], 3)

    def test_errors_have_the_sentences_of_the_program(self):
        with self.assertRaisesRegex(RuntimeError, "nowhere: no such folder"):
            lumatlas.load_scene("nowhere")
        with self.assertRaisesRegex(lumatlas.InputError, "nowhere: no such folder"):
            lumatlas.load_scene("nowhere")
        for kind in (lumatlas.InputError, lumatlas.GlError, lumatlas.Stopped):
            self.assertTrue(issubclass(kind, lumatlas.Error) and issubclass(lumatlas.Error, RuntimeError))
            self.assertIs(pickle.loads(pickle.dumps(kind)), kind)
        with self.assertRaisesRegex(RuntimeError, "give a folder or a .glb"):
            lumatlas.open_model("office")
        with self.assertRaisesRegex(ValueError, "hold is 1, must be at least 2"):
            lumatlas.build(self.scene, "other", hold=1)
        with self.assertRaisesRegex(ValueError, "refine is 'much', must be none, exposure"):
            lumatlas.build(self.scene, "other", refine="much")
        with self.assertRaisesRegex(ValueError, "camera"):
            lumatlas.Camera(64, 48, -1)
        with self.assertRaisesRegex(ValueError, "4 x 4 or 3 x 4"):
            lumatlas.Camera(64, 48, 50, cam_from_world=np.eye(3))
        with self.assertRaisesRegex(RuntimeError, "has no photograph named x"):
            self.scene.photograph("x")
        everything = lumatlas.build(self.scene, "everything", refine="none")
        with self.assertRaisesRegex(RuntimeError, "was built from every photograph"):
            lumatlas.validate(everything, self.scene)
        self.assertFalse(Path("other").exists())

    def test_a_picture_of_more_pixels_than_the_program_draws_is_refused_before_memory_is_taken(self):
        huge = lumatlas.Camera(65536, 65536, 30000)
        for function in (self.model.render, self.model.render_with_state, self.model.depth):
            with self.assertRaisesRegex(ValueError, "65536x65536 is more than 2\\^30 pixels"):
                function(huge)
        peak_kib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        self.assertLess(peak_kib, 3 << 20)  # the states alone of such a picture would be 4 GiB

    def test_objects_without_init_are_refused_wherever_they_are_given(self):
        camera, scene, model = (kind.__new__(kind) for kind in (lumatlas.Camera, lumatlas.Scene, lumatlas.Model))
        kinds = [kind for kind in vars(lumatlas).values() if isinstance(kind, type) and not issubclass(kind, Exception)]
        self.assertEqual(set(kinds), {lumatlas.Camera, lumatlas.Scene, lumatlas.Model})
        for made in (camera, scene, model):
            for name, member in vars(type(made)).items():
                if isinstance(member, property):
                    with self.assertRaisesRegex(TypeError, "without __init__", msg=name):
                        getattr(made, name)
        for call in (
            lambda: camera.scaled_to(8, 8),
            lambda: repr(camera),
            lambda: copy.copy(self.camera()).width,
            lambda: self.model.render(camera),
            lambda: model.render(self.camera()),
            lambda: model.depth(self.camera()),
            lambda: len(scene),
            lambda: scene.held_out(4),
            lambda: scene.photograph("0000.png"),
            lambda: lumatlas.build(scene, "other"),
            lambda: lumatlas.make_mesh(scene, "other.ply"),
            lambda: lumatlas.validate(model, self.scene),
            lambda: lumatlas.validate(self.model, scene),
        ):
            with self.assertRaises(TypeError):
                call()

    def test_every_exception_says_something(self):
        def told(call):
            with self.assertRaises(Exception) as caught:
                call()
            sentence = str(caught.exception)
            self.assertGreater(len(sentence), 10, repr(caught.exception))
            self.assertNotRegex(sentence, r"Unable to cast|filesystem error|std::|\.lumatlas-|json\.exception")
            return sentence

        self.assertIn("returned a value of type str, must return None, True or False",
                      told(lambda: lumatlas.build(self.scene, "other", progress=lambda *step: "yes")))
        loop = self.folder / "loop"
        loop.symlink_to(loop)
        not_utf8 = os.fsdecode(b"not-\xff-utf8")
        for path in (loop, loop / "below", "", "x" * 5000, "/proc/self/mem", "/root/../proc/1/x", not_utf8, "\0"):
            with self.subTest(path=path):
                told(lambda: lumatlas.load_scene(path))
                told(lambda: lumatlas.open_model(path))
                told(lambda: lumatlas.load_scene("office", images=path))
                told(lambda: lumatlas.load_scene("office", masks=path))
                told(lambda: lumatlas.build(self.scene, "other", mesh=path))
                told(lambda: lumatlas.make_mesh(self.scene, "other.ply", points=path))
        for path in (loop, "", "x" * 5000, "/proc/self/x", "\0"):
            with self.subTest(output=path):
                told(lambda: lumatlas.build(self.scene, path))
                told(lambda: lumatlas.make_mesh(self.scene, path))
        told(lambda: self.scene.photograph(not_utf8))
        told(lambda: self.scene.held_out(0))
        told(lambda: lumatlas.build(self.scene, "other", max_views=0))
        told(lambda: lumatlas.build(self.scene, "other", hold=2, block=2 ** 62))
        told(lambda: lumatlas.Camera(64, 48, float("nan")))
        told(lambda: lumatlas.Camera(64, 48, 50, cam_from_world=[["a"] * 4] * 4))
        told(lambda: lumatlas.Camera(64, 48, 50, cam_from_world=np.zeros((4, 4))))
        told(lambda: lumatlas.Camera.looking_at((0, 0, 0), (0, 0, 0), (0, 0, 1), 8, 8))
        told(lambda: lumatlas.validate(self.model, self.scene, baselines={"x"}))
        told(lambda: self.camera().scaled_to(0, 0))

    def test_a_build_can_be_stopped(self):
        with self.assertRaisesRegex(lumatlas.Stopped, "stopped by its caller"):
            lumatlas.build(self.scene, "stopped", progress=lambda stage, done, total: done < 3)

        def press(stage, done, total):
            if done == 2:
                os.kill(os.getpid(), signal.SIGINT)

        with self.assertRaises(KeyboardInterrupt):
            lumatlas.build(self.scene, "stopped", progress=press)

        def fail(stage, done, total):
            raise LookupError("of the caller's own")

        with self.assertRaisesRegex(LookupError, "of the caller's own"):
            lumatlas.build(self.scene, "stopped", progress=fail)
        self.assertFalse(Path("stopped").exists())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
