#!/usr/bin/env python3
"""The meshes that generate makes. Usage: generate_test.py TETFUSION"""
import numpy as np

from harness import USAGE, FolderTest, main, report_of, run
from independent_check import Vtu


def tets_as_coordinates(mesh):
    """The tetrahedra as a sorted array of their corners' coordinates, whatever their order and that of the points."""
    corners = mesh.points[mesh.tets].astype("f8")
    order = np.lexsort((corners[:, :, 2], corners[:, :, 1], corners[:, :, 0]))
    rows = np.take_along_axis(corners, order[:, :, None], axis=1).reshape(len(corners), 12)
    return rows[np.lexsort(rows.T[::-1])]


class Generate(FolderTest):
    def test_kinds_and_sizes(self):
        for kind in ("five", "kuhn", "bcc"):
            for tets in (1000, 30000):
                path = self.generate("--jitter", "0.5", kind=kind, tets=str(tets))
                report = report_of("check", path, "--strict")
                self.assertLess(abs(report["tets"] / tets - 1), 0.1)
                self.assertAlmostEqual(report["volume"], 1, delta=1e-6)
                self.assertEqual((report["components"], report["surface_euler"]), (1, 2))

    def test_shuffled_is_the_same_mesh(self):
        plain = self.generate("--jitter", "0.3", tets="5k")
        shuffled = self.generate("--jitter", "0.3", "--shuffle", tets="5k", name="shuffled.vtu")
        self.assertNotEqual(plain.read_bytes(), shuffled.read_bytes())
        a, b = Vtu(plain), Vtu(shuffled)
        self.assertFalse(np.array_equal(a.points, b.points))
        np.testing.assert_array_equal(tets_as_coordinates(a), tets_as_coordinates(b))
        of_points = [m.arrays["point"]["temperature"][1][np.lexsort(m.points.T)] for m in (a, b)]
        np.testing.assert_array_equal(*of_points)

    def test_long_after_the_front_has_passed(self):
        for time in ("1e100", "1e200", "1e308"):
            front = Vtu(self.generate("--time", time, tets="2k")).arrays["point"]["front"][1]
            self.assertEqual(np.abs(front).max(), 0)

    def test_bytes_depend_on_the_seed_alone(self):
        options = ["--jitter", "0.4", "--shuffle", "--grading", "3"]
        one = self.generate(*options, "--threads", "1", "--seed", "7").read_bytes()
        self.assertEqual(one, self.generate(*options, "--threads", "2", "--seed", "7").read_bytes())
        self.assertNotEqual(one, self.generate(*options, "--seed", "8").read_bytes())

    def test_bad_options(self):
        for options in (["--tets", "0"], ["--tets", "many"], ["--jitter", "1"], ["--jitter", "nan"], ["--grading", "0"],
                        ["--seed", "-1"], ["--seed", "18446744073709551616"], ["--seed", "1k"], ["--tets", "2e30"]):
            run("generate", "five", "-o", self.folder / "a.vtu", *options, code=USAGE)
        run("generate", "six", "-o", self.folder / "a.vtu", code=USAGE)
        run("generate", "five", code=USAGE)
        self.assertEqual(self.files(), [])


if __name__ == "__main__":
    main()
