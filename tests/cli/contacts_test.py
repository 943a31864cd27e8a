#!/usr/bin/env python3
"""Parts that touch but share no points, as in a contact: values of one are never held against those of the other.
Usage: contacts_test.py TETFUSION"""
import numpy as np

from harness import FolderTest, finish, main, report_of, run
from independent_check import Vtu
from sample_meshes import rebuilt
from tiny_vtu import TinyVtu, grid


def contact(cells=(9, 7), step=100.0, depth=0.0):
    """Two blocks, one on top of the other along a bent surface, each with a mesh of its own, and a field that jumps there
    and is smooth within each. The upper one may be driven into the lower one."""
    mesh = TinyVtu(1)
    mesh.points, mesh.tets, values = [], [], []
    for part, n in enumerate(cells):
        points, tets = grid(n)
        p = np.array(points) / n
        p[:, 2] = (p[:, 2] - 1 if part == 0 else p[:, 2] - depth) + 0.15 * p[:, 0] * p[:, 0] + 0.1 * p[:, 1]
        first = len(mesh.points)
        mesh.points += [tuple(float(np.float32(c)) for c in row) for row in p]
        mesh.tets += [[v + first for v in t] for t in tets]
        values += [part * step + np.sin(3 * x) + y * z for x, y, z in p]
    rebuilt(mesh)
    mesh.array("temperature")[4] = [float(np.float32(v)) for v in values]
    return mesh


class Contacts(FolderTest):
    def setUp(self):
        super().setUp()
        self.path = self.write(contact())
        self.out = self.folder / "out.vtu"

    def compare(self, *paths):
        report = report_of("compare", *paths)
        return report, next(a for a in report["arrays"] if a["name"] == "temperature")

    def test_a_mesh_and_itself(self):
        """One block is driven into the other."""
        path = self.write(contact(depth=0.3), "deep.vtu")
        report, temperature = self.compare(path, path)
        self.assertEqual(temperature["max"], 0)
        self.assertLess(temperature["cell_max"], 1e-6)
        self.assertEqual(next(a for a in report["arrays"] if a["name"] == "id")["differing"], 0)

    def test_bounds_are_found_kept(self):
        for options in (["--max-error", "0.5%"], ["--reduction", "60%"]):
            run("simplify", self.path, "-o", self.out, "--boundary", "2%", "--verify", "--quiet", *options)
            report, temperature = self.compare(self.path, self.out)
            self.assertLess(report["simplified"]["tets"], 0.7 * report["original"]["tets"])
            self.assertLess(temperature["max"], 0.006)
            self.assertLess(temperature["cell_max"], 0.006)

    def test_what_was_moved_across_is_seen(self):
        """A part whose points now have the other's values."""
        run("simplify", self.path, "-o", self.out, "--boundary", "2%", "--reduction", "60%", "--quiet")
        worse = contact(step=80.0)
        path = self.write(worse, "worse.vtu")
        _, temperature = self.compare(path, self.out)
        self.assertGreater(temperature["max"], 0.1)

    def test_surfaces_are_held_against_those_of_their_part(self):
        """The upper block has drawn back from the contact by a twentieth: the lower one's surface is where it was."""
        moved = contact()
        heights = np.repeat(np.arange(8), 64) / 7  # of the upper block's points
        first = len(moved.points) - len(heights)
        moved.points[first:] = [(x, y, z + 0.05 * (1 - h)) for (x, y, z), h in zip(moved.points[first:], heights)]
        values = moved.array("temperature")[4]
        rebuilt(moved).array("temperature")[4] = values
        report, _ = self.compare(self.path, self.write(moved, "moved.vtu"))
        distance = 0.05 / np.linalg.norm(np.ptp(np.array(moved.points), axis=0))
        for way in ("original_to_simplified", "simplified_to_original"):
            self.assertGreater(report["surface"][way]["max"], 0.9 * distance)

    def test_maps_stay_within_parts(self):
        """The steps of a series, and what is applied to another mesh of the same points, jump where the input does."""
        path = self.folder / "out.map"
        run("simplify", self.path, "-o", self.out, "--boundary", "2%", "--reduction", "60%", "--map", path, "--quiet")
        step = contact()
        step.array("temperature")[4] = [0.0 if v < 10**3 else 1.0 for v in range(len(step.points))]
        other = self.write(step, "step.vtu")
        again = self.folder / "again.vtu"
        for options in ([], ["--fit"]):
            said = finish("apply", path, other, "-o", again, *options)
            self.assertEqual(said.returncode, 0, said.stderr)
            values = np.unique(np.squeeze(Vtu(again).arrays["point"]["temperature"][1]))
            self.assertLess(np.minimum(np.abs(values), np.abs(values - 1)).max(), 1e-6)
            _, temperature = self.compare(other, again)
            self.assertLess(temperature["max"], 1e-6)

    def test_cells_have_means_where_parts_do_not_overlap(self):
        """One block is driven into the other, and cells have the height of their middles."""
        mesh = contact(cells=(12, 10), depth=0.3)
        heights = np.array(mesh.points)[:, 2][np.array(mesh.tets)].mean(axis=1)
        mesh.arrays.insert(1, ["CellData", "height", "Float64", 1, heights.tolist()])
        path = self.write(mesh, "deep.vtu")
        run("simplify", path, "-o", self.out, "--reduction", "70%", "--quiet")
        out = Vtu(self.out)
        middles = out.points[:, 2][out.tets].mean(axis=1)
        off = np.abs(np.squeeze(out.arrays["cell"]["height"][1]) - middles)
        apart = (middles < -0.3) | (middles > 0.3)  # in one of them alone
        self.assertGreater(apart.sum(), 1000)
        self.assertLess(off[apart].mean(), 0.016)  # 0.021 without

    def test_many_parts(self):
        """Cubes that touch at their sides, and cubes within cubes, each with a value of its own."""
        mesh = TinyVtu(1)
        mesh.points, mesh.tets, values = [], [], []
        for number, (scale, at) in enumerate([(1, (x, y, z)) for x in range(3) for y in range(3) for z in range(3)]
                                             + [(0.5, (0.25, 0.25, 0.25)), (0.25, (0.25, 0.25, 0.25))]):
            n = 3 + number % 3
            points, tets = grid(n)
            first = len(mesh.points)
            mesh.points += [tuple(float(np.float32(a + scale * c / n)) for a, c in zip(at, p)) for p in points]
            mesh.tets += [[v + first for v in t] for t in tets]
            values += [float(number % 2 * 50 + number)] * len(points)
        rebuilt(mesh)
        mesh.array("temperature")[4] = values
        path = self.write(mesh, "many.vtu")
        _, temperature = self.compare(path, path)
        self.assertLess(temperature["cell_max"], 1e-12)
        run("simplify", path, "-o", self.out, "--boundary", "1%", "--reduction", "30%", "--verify", "--quiet")
        _, temperature = self.compare(path, self.out)
        self.assertLess(max(temperature["max"], temperature["cell_max"]), 1e-6)


if __name__ == "__main__":
    main()
