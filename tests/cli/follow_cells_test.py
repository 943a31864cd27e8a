#!/usr/bin/env python3
"""Arrays of cells that follow a simplification: simplify --map and apply. Usage: follow_cells_test.py TETFUSION"""
import numpy as np

from follow_test import METHODS, Map, jittered
from harness import BAD, USAGE, FolderTest, finish, main, report_of, run
from independent_check import Vtu
from sample_meshes import mesh_of_all_sorts, rebuilt
from tiny_vtu import TinyVtu

NO_TET = 2**32 - 1


def volumes(mesh):
    a, b, c, d = (mesh.points[mesh.tets[:, k]].astype(float) for k in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6


def with_cells(mesh, **arrays):
    """Cell arrays by name: (type, rows)."""
    for name, (kind, rows) in arrays.items():
        rows = np.asarray(rows)
        mesh.arrays.insert(1, ["CellData", name, kind, rows[0].size, rows.ravel().tolist()])
    return mesh


def cell_values(mesh, name):
    return np.squeeze(mesh.arrays["cell"][name][1])


class FollowCells(FolderTest):
    def simplify(self, path, *options):
        run("simplify", path, "-o", self.folder / "out.vtu", "--map", self.folder / "out.map", "--quiet", *options)
        return Vtu(self.folder / "out.vtu"), Map(self.folder / "out.map")

    def moved(self, path, *options):
        report = report_of("apply", self.folder / "out.map", path, "-o", self.folder / "moved.vtu", "--quiet", *options)
        return Vtu(self.folder / "moved.vtu"), report

    def test_each_cell_has_a_home_or_is_left(self):
        path = self.generate("--jitter", "0.5", "--shuffle", tets="30k")
        original = Vtu(path)
        before = volumes(original)
        for name, options in METHODS.items():
            with self.subTest(name):
                result, the_map = self.simplify(path, "--chunk-tets", "6k", "--regions", "none", *options)
                after = volumes(result)
                homes, origins = the_map.homes, the_map.origins
                self.assertEqual((len(homes), len(origins)), (len(before), len(after)))
                self.assertEqual(len(np.unique(origins["cell"])), len(after))
                counts = homes["tet"] != NO_TET
                # What is as it was takes no other's values, and gives none away.
                old = np.sort(original.points[original.tets[origins["cell"]]].reshape(len(after), -1), axis=1)
                is_left = np.all(old == np.sort(result.points[result.tets].reshape(len(after), -1), axis=1), axis=1)
                self.assertFalse(origins["is_mean"][is_left].any())
                self.assertFalse(counts[origins["cell"][is_left]].any())
                self.assertTrue(is_left.sum() > 100 or name == "bound")
                self.assertEqual(len(before) - counts.sum(), is_left.sum())
                np.testing.assert_allclose(homes["share"][counts] * after[homes["tet"][counts]], before[counts], rtol=1e-5)
                # Centres lie where the map says.
                centres = original.points[original.tets].mean(axis=1)[counts]
                corners = result.points[result.tets[homes["tet"][counts]]].astype(float)
                edges = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
                weights = np.linalg.solve(edges, (centres - corners[:, 0])[..., None])[..., 0]
                self.assertGreater(min(weights.min(), (1 - weights.sum(axis=1)).min()), -1e-4)

    def test_values_are_means_or_those_of_one(self):
        mesh = jittered()
        path = self.write(mesh)
        result, the_map = self.simplify(path, "--reduction", "60%")
        count = len(mesh.tets)
        rng = np.random.default_rng(3)
        noise, numbers = rng.normal(size=(count, 3)), rng.integers(-2**62, 2**62, count)
        step = self.write(with_cells(mesh, noise=("Float64", noise), single=("Float32", noise[:, 0]), numbers=(
            "Int64", numbers), labels=("Float64", np.arange(count)), constant=("Float64", np.full(count, 0.1))), "step.vtu")
        moved, report = self.moved(step)
        np.testing.assert_array_equal(moved.tets, result.tets)
        origins, homes = the_map.origins, the_map.homes
        self.assertEqual([(a["name"], a["components"], a["means"]) for a in report["cell_arrays"]], [
            ("constant", 1, True), ("labels", 1, False), ("numbers", 1, False), ("single", 1, True), ("noise", 3, True), ("id", 1, False)])
        for name in ("numbers", "labels", "id"):
            np.testing.assert_array_equal(cell_values(moved, name), cell_values(Vtu(step), name)[origins["cell"]])
        np.testing.assert_array_equal(cell_values(moved, "constant"), 0.1)
        is_mean = origins["is_mean"] == 1
        self.assertGreater(is_mean.mean(), 0.5)
        counts = (homes["tet"] != NO_TET)
        sums, weights = np.zeros((len(origins), 3)), np.zeros(len(origins))
        np.add.at(sums, homes["tet"][counts], homes["share"][counts, None] * noise[counts])
        np.add.at(weights, homes["tet"][counts], homes["share"][counts])
        expected = np.where(is_mean[:, None], sums / np.maximum(weights, 1e-9)[:, None], noise[origins["cell"]])
        np.testing.assert_allclose(cell_values(moved, "noise"), expected, atol=1e-12)
        np.testing.assert_allclose(cell_values(moved, "single"), expected[:, 0], atol=1e-6)
        # Some of them, and the same bytes.
        whole = (self.folder / "moved.vtu").read_bytes()
        self.moved(step, "--threads", "1")
        self.assertEqual((self.folder / "moved.vtu").read_bytes(), whole)
        one, _ = self.moved(step, "--array", "cell:noise", "--array", "cell:noise")
        self.assertEqual((list(one.arrays["point"]), list(one.arrays["cell"])), ([], ["noise"]))
        both, _ = self.moved(step, "--array", "temperature", "--array", "cell:id")
        self.assertEqual((list(both.arrays["point"]), list(both.arrays["cell"])), (["temperature"], ["id"]))
        run("apply", self.folder / "out.map", step, "-o", self.folder / "no.vtu", "--array", "cell:nose", code=USAGE)

    def test_they_are_what_simplify_makes(self):
        mesh = jittered()
        centres = np.array(mesh.points)[np.array(mesh.tets)].mean(axis=1)
        path = self.write(with_cells(mesh, f=("Float64", np.sin(centres.sum(axis=1)) + 0.01)))
        for options in (["--reduction", "60%"], ["--reduction", "60%", "--boundary", "2%"]):
            result, _ = self.simplify(path, *options)
            moved, _ = self.moved(path)
            f, applied = cell_values(result, "f"), cell_values(moved, "f")
            self.assertGreater(np.isclose(f, applied, atol=1e-6).mean(), 0.99)
            np.testing.assert_array_equal(cell_values(result, "id"), cell_values(moved, "id"))

    def test_values_that_are_none_do_not_spread(self):
        mesh = jittered()
        path = self.write(mesh)
        _, the_map = self.simplify(path, "--reduction", "60%")
        count = len(mesh.tets)
        one = the_map.homes["tet"][the_map.homes["tet"] != NO_TET][0]
        lost = np.full(count, 1.5)
        lost[np.arange(count) % 7 == 0] = np.nan
        lost[the_map.homes["tet"] == one] = np.inf
        moved, _ = self.moved(self.write(with_cells(mesh, f=("Float64", lost)), "step.vtu"))
        f = cell_values(moved, "f")
        self.assertEqual(f[one], np.inf)
        self.assertLess(np.isnan(f).mean(), 1 / 7)
        np.testing.assert_array_equal(f[np.isfinite(f)], 1.5)

    def test_regions_do_not_mix(self):
        mesh = jittered(10)
        centres = np.array(mesh.points)[np.array(mesh.tets)].mean(axis=1)
        material = np.where(np.linalg.norm(centres - 5, axis=1) < 3, 2, 1)
        path = self.write(with_cells(mesh, material=("Int32", material)))
        for options in ([], ["--boundary", "3%"]):
            self.simplify(path, "--reduction", "60%", *options)
            moved, _ = self.moved(self.write(with_cells(mesh, f=("Float64", material + 0.25)), "step.vtu"))
            np.testing.assert_array_equal(cell_values(moved, "f"), cell_values(moved, "material") + 0.25)
            mesh.remove("f")

    def test_cells_of_lower_dimension_keep_their_values(self):
        path = self.write(mesh_of_all_sorts())
        result, the_map = self.simplify(path, "--reduction", "30%")
        self.assertEqual(sorted(the_map.origins["cell"][-3:].tolist()), [0, 1, len(the_map.homes) - 1])
        moved, _ = self.moved(path)
        for name in ("id", "large"):
            np.testing.assert_array_equal(moved.arrays["cell"][name][1], result.arrays["cell"][name][1])

    def test_other_cells_are_told_of(self):
        mesh = jittered()
        path = self.write(mesh)
        self.simplify(path, "--reduction", "60%")
        order = np.random.default_rng(1).permutation(len(mesh.tets))
        mesh.tets = [mesh.tets[i] for i in order]
        for other in (self.write(rebuilt(mesh), "shuffled.vtu"), self.fewer(mesh)):
            said = finish("apply", self.folder / "out.map", other, "-o", self.folder / "moved.vtu").stderr
            self.assertIn(b"arrays of cells do not follow: its tetrahedra are not those", said)
            self.assertEqual(list(Vtu(self.folder / "moved.vtu").arrays["cell"]), [])
            run("apply", self.folder / "out.map", other, "-o", self.folder / "no.vtu", "--array", "cell:id", code=BAD)
        self.assertNotIn("no.vtu", self.files())

    def test_ghost_marks_do_not_follow(self):
        mesh = with_cells(jittered(4), vtkGhostType=("UInt8", np.zeros(6 * 64, int)))
        path = self.write(mesh)
        self.simplify(path, "--reduction", "20%")
        moved, _ = self.moved(path)
        self.assertEqual(list(moved.arrays["cell"]), ["id"])
        for name in "cell:vtkGhostType", "vtkGhostType":
            run("apply", self.folder / "out.map", path, "-o", self.folder / "no.vtu", "--array", name, code=USAGE)

    def fewer(self, mesh):
        mesh.tets = mesh.tets[:-1]
        mesh.array("id")[4] = mesh.array("id")[4][:-1]
        mesh.counts["NumberOfCells"] = str(len(mesh.tets))
        return self.write(rebuilt(mesh), "fewer.vtu")

    def test_split_cells_follow(self):
        options = ["--tetrahedralize", "--regions", "none"]
        path = self.write(self.hexahedra(), "hex.vtu")
        self.simplify(path, *options, "--reduction", "50%", "--array", "temperature")
        moved, report = self.moved(path, "--tetrahedralize")
        self.assertEqual([(a["name"], a["means"]) for a in report["cell_arrays"]], [("f", True)])
        f = cell_values(moved, "f")
        self.assertEqual(len(f), len(moved.tets))
        self.assertGreater(len(np.unique(f)), 20)

    def hexahedra(self, n=6):
        mesh = TinyVtu(n)
        side = n + 1
        at = lambda x, y, z: (z * side + y) * side + x
        corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
        cells = [[at(x + i, y + j, z + k) for i, j, k in corners] for z in range(n) for y in range(n) for x in range(n)]
        mesh.remove("id")
        mesh.counts["NumberOfCells"] = str(len(cells))
        mesh.array("connectivity")[4] = [v for c in cells for v in c]
        mesh.array("offsets")[4] = list(range(8, 8 * len(cells) + 1, 8))
        mesh.array("types")[4] = [12] * len(cells)
        mesh.arrays.insert(1, ["CellData", "f", "Float64", 1, [i / 7 for i in range(len(cells))]])
        return mesh


if __name__ == "__main__":
    main()
