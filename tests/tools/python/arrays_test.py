# SPDX-License-Identifier: GPL-3.0-or-later
"""Usage: arrays_test.py PROGRAM, the program `lumatlas`.

Scenes that Python makes of NumPy arrays.
"""

import gc
import resource
import subprocess
import sys
import unittest
import warnings
from pathlib import Path

from support import InOffice, lumatlas, np, read_ply


class Arrays(InOffice):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.disk = lumatlas.load_scene("office")
        cls.photographs = {name: cls.disk.photograph(name) for name in cls.disk.names}
        cls.cameras = cls.disk.cameras
        cls.vertices, cls.faces = read_ply(Path("office/mesh.ply"))
        cls.scene = lumatlas.Scene.from_arrays(cls.photographs, cls.cameras, cls.vertices, cls.faces)

    @classmethod
    def tearDownClass(cls):
        del cls.scene
        super().tearDownClass()

    def setUp(self):
        warnings.simplefilter("ignore")

    def test_nothing_is_lost(self):
        self.assertEqual(self.scene.names, self.disk.names)
        self.assertEqual(self.scene.held_out(4), self.disk.held_out(4))
        for name in self.scene.names:
            np.testing.assert_array_equal(self.scene.photograph(name), self.photographs[name])
            np.testing.assert_allclose(self.scene.cameras[name].cam_from_world, self.cameras[name].cam_from_world,
                                       rtol=0, atol=1e-14)
        vertices, faces = read_ply(self.scene.path / "mesh.ply")
        np.testing.assert_array_equal(vertices, self.vertices)
        np.testing.assert_array_equal(faces, self.faces)

    def test_the_model_is_that_of_the_scene_on_disk(self):
        scores = []
        for name, scene in (("disk", self.disk), ("memory", self.scene)):
            model = lumatlas.build(scene, name, hold=4, max_views=6)
            scores.append((sorted(model.cameras), lumatlas.validate(model, scene)["methods"]["store"]["frame"]["raw"]))
        self.assertEqual(scores[0][0], scores[1][0])
        self.assertAlmostEqual(scores[0][1]["psnr"], scores[1][1]["psnr"], delta=0.01)
        self.assertAlmostEqual(scores[0][1]["ssim"], scores[1][1]["ssim"], delta=0.001)

    def test_every_kind_of_array_that_fits_is_taken(self):
        some = {name: self.photographs[name] for name in self.disk.names[:2]}
        cameras = {name: self.cameras[name] for name in some}
        flipped = {name: picture[::-1, ::-1] for name, picture in some.items()}
        scene = lumatlas.Scene.from_arrays(flipped, cameras, self.vertices.astype(np.float32).tolist(),
                                           self.faces.astype(np.int64))
        for name in some:
            np.testing.assert_array_equal(scene.photograph(name), flipped[name])
        names = {"IMG 1.jpg": some[self.disk.names[0]], "kitchen/\u00fc": some[self.disk.names[1]]}
        scene = lumatlas.Scene.from_arrays(names, dict(zip(names, cameras.values())))
        self.assertEqual(scene.names, sorted(names))
        for name in names:
            np.testing.assert_array_equal(scene.photograph(name), names[name])

    def test_masks_and_points_are_used(self):
        name = self.disk.names[0]
        mask = np.ones((72, 96), bool)
        mask[:30] = False
        for kind in (bool, np.uint8):
            scene = lumatlas.Scene.from_arrays(self.photographs, self.cameras, self.vertices, self.faces,
                                               masks={name: mask.astype(kind)})
            self.assertEqual(lumatlas.inspect(scene)["views"]["masked"], 1)
        points = self.vertices[self.faces].mean(axis=1)
        scene = lumatlas.Scene.from_arrays(self.photographs, self.cameras, points=points)
        facts = lumatlas.make_mesh(scene, "points.ply")
        self.assertEqual((facts["from"], facts["points"]["read"]), ("points", len(points)))
        model = lumatlas.build(scene, "of-points", mesh="points.ply", refine="none")
        self.assertGreater(len(model.cameras), 0)
        with self.assertRaisesRegex(lumatlas.InputError, "mesh"):
            lumatlas.build(scene, "without-mesh")

    def test_its_folder_goes_with_the_scene(self):
        scene = lumatlas.Scene.from_arrays(self.photographs, self.cameras)
        folder = scene.path
        self.assertTrue(folder.is_dir())
        del scene
        gc.collect()
        self.assertFalse(folder.exists())
        script = ("import lumatlas, numpy as np; camera = lumatlas.Camera(8, 8, 8); "
                  "scene = lumatlas.Scene.from_arrays({'a': np.zeros((8, 8, 3), np.uint8)}, {'a': camera}); "
                  "print(scene.path)")
        folder = Path(subprocess.run([sys.executable, "-c", script], check=True, capture_output=True,
                                     text=True).stdout.strip())
        self.assertFalse(folder.exists())

    def test_each_wrong_array_is_named(self):
        name, other = self.disk.names[:2]
        picture, camera = self.photographs[name], self.cameras[name]
        good = ({name: picture}, {name: camera})
        mesh = (self.vertices, self.faces)
        spoilt = self.vertices.copy()
        spoilt[7, 1] = np.nan
        wrong_face = self.faces.astype(np.int64)
        wrong_face[3, 2] = len(self.vertices)
        photograph = f"photographs\\['{name}'\\]: is an array of"
        for arguments, options, sentence in (
            (({}, {}), {}, "photographs: is empty"),
            ((3, {}), {}, "photographs: is a value of type int, must be a mapping"),
            (({1: picture}, {1: camera}), {}, "photographs: has a name of type int, must be str"),
            (({"\ud800": picture}, {"\ud800": camera}), {}, r"photographs: has the name '.ud800', must be text that UTF-8 can"),
            (({name: picture[:9]}, {name: camera}), {}, photograph + r" uint8, \(9, 96, 3\), must be .*\(72, 96, 3\)"),
            (({name: picture[..., 0]}, {name: camera}), {}, photograph + r" uint8, \(72, 96\), must be"),
            (({name: picture / 255}, {name: camera}), {}, photograph + " float64"),
            (({name: None}, {name: camera}), {}, photograph + " object"),
            (({name: picture}, {other: camera}), {}, f"photographs\\['{name}'\\]: cameras has nothing of this name"),
            (({name: picture}, {name: camera, other: camera}), {}, "photographs has nothing of this name"),
            (({name: picture}, {name: 3}), {}, "is a value of type int, must be a lumatlas.Camera"),
            ((*good, spoilt, self.faces), {}, r"vertices\[7, 1\]: is nan, must be finite"),
            ((*good, self.vertices[:0], self.faces), {}, "vertices: is empty"),
            ((*good, self.vertices[:, :2], self.faces), {}, r"vertices: is an array of float64, \(\d+, 2\), must be"),
            ((*good, [["a", "b", "c"]], self.faces), {}, "vertices: is an array of <U1"),
            ((*good, self.vertices, self.faces[:0]), {}, "faces: is empty"),
            ((*good, self.vertices, wrong_face), {}, rf"faces\[3, 2\]: is {len(self.vertices)}, must be 0 to"),
            ((*good, self.vertices, -wrong_face - 1), {}, r"faces\[0, 0\]: is -"),
            ((*good, self.vertices, self.faces.astype(float)), {}, "faces: is an array of float64"),
            ((*good, self.vertices), {}, "faces is None, but the other is not"),
            ((*good, *mesh), {"masks": {other: picture}}, "photographs has nothing of this name"),
            ((*good, *mesh), {"masks": {name: picture}}, r"masks\['.*'\]: is an array of uint8, \(72, 96, 3\)"),
            ((*good, *mesh), {"points": [[0, 0, np.inf]]}, r"points\[0, 2\]: is inf, must be finite"),
            ((*good, *mesh), {"points": np.zeros((0, 3))}, "points: is empty"),
        ):
            with self.subTest(sentence=sentence), self.assertRaisesRegex(ValueError, sentence):
                lumatlas.Scene.from_arrays(*arguments, **options)

    def test_a_photograph_of_more_than_a_billion_pixels_is_refused_before_memory_is_taken(self):
        side = 33000
        one = np.broadcast_to(np.uint8(3), (side, side, 3))
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        with self.assertRaisesRegex(ValueError, r"photographs\['a'\]: its camera has 1089000000 pixels, must have at most"):
            lumatlas.Scene.from_arrays({"a": one}, {"a": lumatlas.Camera(side, side, side)})
        self.assertLess(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before, 100_000)  # KB

    def test_no_name_leads_out_of_the_folder(self):
        picture, camera = next(iter(self.photographs.values())), next(iter(self.cameras.values()))
        for name in ("", "/x", "x/", "../x", "a/../../x", ".", "a/./b", "a\0b", "x" * 300):
            with self.subTest(name=name), self.assertRaisesRegex(ValueError, "photographs: the name '"):
                lumatlas.Scene.from_arrays({name: picture}, {name: camera})
        with self.assertRaisesRegex(ValueError, r"photographs\['a/b'\]: 'a' is the name of a photograph too"):
            lumatlas.Scene.from_arrays({"a": picture, "a/b": picture}, {"a": camera, "a/b": camera})


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
