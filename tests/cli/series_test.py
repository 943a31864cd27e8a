#!/usr/bin/env python3
"""simplify over the steps of a series. Usage: series_test.py TETFUSION"""
import re

import numpy as np

from follow_test import jittered, values, with_arrays
from harness import BAD, USAGE, FolderTest, finish, least_memory, main, report_of, run
from independent_check import Vtu
from roi_test import cells_inside
from sample_meshes import mesh_of_all_sorts
from tiny_vtu import TinyVtu

GOAL = ["--reduction", "60%", "--quiet"]


def wave(mesh, time, dtype="Float32"):
    """The mesh with a bump that moves along x, and a vector of which one component is linear."""
    x, y, z = np.array(mesh.points).T
    bump = np.exp(-0.5 * (x - time) ** 2 - 0.1 * y)
    return with_arrays(mesh, bump=(dtype, bump), drift=(dtype, np.stack([bump, x + time * y, z], axis=1)))


def expect_the_same(path, other, *arrays):
    """The same points and tetrahedra, and values of these arrays."""
    one, two = Vtu(path), Vtu(other)
    np.testing.assert_array_equal(one.points, two.points)
    np.testing.assert_array_equal(one.tets, two.tets)
    for name in arrays:
        np.testing.assert_array_equal(values(one, name), values(two, name))


class SeriesTest(FolderTest):
    def steps(self, count=5, name="step_{:03d}.vtu", make=wave):
        return [self.write(make(jittered(10), 2.0 * i), name.format(7 * i)) for i in range(count)]

    def simplify(self, steps, *options, out="out_{step}.vtu", code=0):
        return report_of("simplify", *steps, "-o", self.folder / out, *options, "--quiet", code=code)

    def least_memory(self, steps, *options):
        return least_memory("simplify", *steps, "-o", self.folder / "out_{step}.vtu", *options)

    def outputs(self, pattern="out_*.vtu"):
        found = sorted(self.folder.glob(pattern))
        self.assertTrue(found, pattern)
        return found


class Shared(SeriesTest):
    def test_all_outputs_have_one_mesh(self):
        steps = self.steps()
        report = self.simplify(steps, *GOAL)
        self.assertEqual([p.name for p in self.outputs()], [f"out_{7 * i:03d}.vtu" for i in range(5)])
        self.assertEqual([s["step"] for s in report["steps"]], ["000", "007", "014", "021", "028"])
        self.assertEqual((report["series"], report["tries"], report["outputs"]),
                         ("shared", 1, [s["output"] for s in report["steps"]]))
        first = self.outputs()[0]
        self.assertEqual(len(Vtu(first).tets), report["output"]["tets"])
        for path, step in zip(self.outputs(), steps, strict=True):
            expect_the_same(path, first)
            run("check", path)
            self.assertEqual(Vtu(path).arrays["point"].keys(), Vtu(step).arrays["point"].keys())
        self.assertEqual([p.name for p in self.folder.iterdir() if "tetfusion" in p.name], [])

    def test_the_report_has_the_errors_of_each_step(self):
        steps = self.steps()
        report = self.simplify(steps, *GOAL, "--array", "bump", "--array", "drift")
        for step, entry in zip(steps, report["steps"], strict=True):
            compared = {a["name"]: a for a in report_of("compare", step, entry["output"])["arrays"]}
            for array in entry["arrays"]:
                self.assertAlmostEqual(array["rms"], compared[array["name"]]["rms"], delta=1e-9)
                self.assertAlmostEqual(array["max"], compared[array["name"]]["max"], delta=1e-9)
            self.assertEqual([a["name"] for a in entry["arrays"]], ["bump", "drift"])

    def test_the_mesh_stays_where_any_step_is_of_interest(self):
        def cells(path, inside):
            return set(cells_inside(Vtu(path), lambda mesh: np.broadcast_to(inside, len(mesh.points))))

        steps = self.steps()
        above = [values(Vtu(p), "bump").ravel() > 0.5 for p in steps]
        points = Vtu(steps[0]).points
        box = (points[:, 0] <= 2) & (points[:, 1] <= 2) & (points[:, 2] >= 8)
        of_all, of_one = cells(steps[0], np.any(above, axis=0)), cells(steps[0], above[2])
        self.assertGreater(len(of_one), 20)
        self.assertGreater(len(of_all), 3 * len(of_one))
        self.assertGreater(len(cells(steps[0], box)), 20)
        self.simplify(steps, *GOAL)
        self.assertFalse(of_all <= cells(self.outputs()[0], True))
        self.simplify(steps, *GOAL, "--roi", "bump>0.5", "--roi", "box=0,2,0,2,8,10")
        for path, step in zip(self.outputs(), steps, strict=True):
            self.assertLessEqual(of_all | cells(step, box), cells(path, True))
            self.assertEqual(list(Vtu(path).arrays["point"]), list(Vtu(step).arrays["point"]))
        self.simplify([self.in_one_mesh()], *GOAL, "--array", "bump_{step}", "--roi", "bump_{step}>0.5", out="one.vtu")
        self.assertLessEqual(of_all, cells(self.folder / "one.vtu", True))

    def in_one_mesh(self, count=5):
        """The same steps as arrays of one mesh, and one array that is none of them."""
        arrays = {"mass": ("Float64", np.array(jittered(10).points)[:, 0])}
        for i in reversed(range(count)):
            step = wave(jittered(10), 2.0 * i)
            for name in ("bump", "drift"):
                array = step.array(name)
                flat = np.array(array[4])
                arrays[f"{name}_{7 * i}"] = (array[2], flat.reshape(-1, 3) if array[3] == 3 else flat)
        return self.write(with_arrays(jittered(10), **arrays), "all.vtu")

    def test_steps_may_be_arrays_of_one_mesh(self):
        """The result is that of the same steps in files of their own, to the bit."""
        steps, path = self.steps(), self.in_one_mesh()
        out = self.folder / "all_out.vtu"
        for options in (["--reduction", "60%"], ["--max-error", "3%"]):
            self.simplify(steps, *options, "--array", "bump", "--array", "drift")
            report = self.simplify([path], *options, "--array", "bump_{step}", "--array", "drift_{step}", out="all_out.vtu")
            self.assertEqual([s["step"] for s in report["steps"]], [str(7 * i) for i in range(5)])
            self.assertEqual(report["steps"][1]["arrays"][1]["name"], "drift_7")
            self.assertEqual(report["outputs"], [str(out)])
            result = Vtu(out)
            self.assertEqual(list(result.arrays["point"]), list(Vtu(path).arrays["point"]))
            for i, other in zip(range(5), map(Vtu, self.outputs()), strict=True):
                np.testing.assert_array_equal(result.points, other.points)
                np.testing.assert_array_equal(result.tets, other.tets)
                for name in ("bump", "drift"):
                    np.testing.assert_array_equal(values(result, f"{name}_{7 * i}"), values(other, name))
            np.testing.assert_allclose(values(result, "mass"), result.points[:, 0], atol=1e-5)
        for i in range(5):
            run("compare", path, out, "--array", f"bump_{7 * i}", "--max-error", "3%")

    def test_arrays_of_one_mesh_that_are_no_series(self):
        path = self.in_one_mesh(3)
        for options, out, why in ((["--array", "none_{step}"], "o.vtu", "no point array is named like none_{step}"),
                                  (["--array", "bump_{step}", "--array", "mass"], "o.vtu", "each array that steers holds {step}"),
                                  (["--array", "bump_{step}"], "o_{step}.vtu", "the result is one mesh"),
                                  (["--array", "bump_{step}"], "o.pvd", "the result is one mesh"),
                                  (["--array", "bump_{step}", "--series", "each"], "o.vtu", "the result is one mesh"),
                                  (["--array", "bump_{step}", "--array", "bump_1{step}"], "o.vtu", "have not the same steps")):
            result = finish("simplify", path, "-o", self.folder / out, *GOAL, *options)
            self.assertEqual(result.returncode, USAGE, options)
            self.assertIn(why, result.stderr.decode())
            self.assertEqual(self.files(), ["all.vtu"])

    def test_integers_cannot_steer_a_series(self):
        whole = [self.write(with_arrays(jittered(6), f=("Int32", np.arange(7 ** 3) % (5 + i))), f"i{i}.vtu") for i in range(2)]
        result = finish("simplify", *whole, "-o", self.folder / "out_{step}.vtu", "--array", "f", *GOAL)
        self.assertEqual(result.returncode, BAD)
        self.assertIn('the array "f", which steers, has integers', result.stderr.decode())
        self.assertEqual(self.files(), ["i0.vtu", "i1.vtu"])

    def test_messages_of_steps_in_one_mesh_name_what_is_there(self):
        path = self.in_one_mesh(2)
        both = ["--array", "bump_{step}", *GOAL[:2]]
        self.simplify([path], *both, "--weight", "bump_7", out="o.vtu")
        left_out = finish("simplify", path, "-o", self.folder / "o.mesh", *both).stderr.decode()
        self.assertIn("bump_7", left_out)
        self.assertNotIn("{step}", left_out)
        mesh = with_arrays(jittered(6), f_0=("Float32", np.arange(7.0 ** 3)), f_1=("Float32", np.zeros((7 ** 3, 2))))
        odd = finish("simplify", self.write(mesh, "odd.vtu"), "-o", self.folder / "o.vtu", "--array", "f_{step}", *GOAL).stderr.decode()
        self.assertIn("step 1: ", odd)

    def test_what_is_nowhere_negative_stays_so(self):
        def cone(mesh, time):
            distance = np.linalg.norm(np.array(mesh.points) - (2 + time, 5, 5), axis=1)
            return with_arrays(mesh, density=("Float32", np.maximum(0, 1 - 0.4 * distance)))

        steps = self.steps(4, make=cone)
        self.simplify(steps, "--array", "density", "--max-error", "5%")
        for before, after in zip(steps, self.outputs()):
            least, most = (f(values(Vtu(before), "density")) for f in (np.min, np.max))
            found = values(Vtu(after), "density")
            self.assertGreaterEqual(found.min(), least)
            self.assertLessEqual(found.max(), most)

    def test_linear_fields_stay_linear(self):
        mesh = jittered(8)
        x, y, z = np.array(mesh.points).T
        steps = [self.write(with_arrays(jittered(8), f=("Float64", 1 + i * x - y + 0.5 * i * z)), f"s{i}.vtu") for i in range(11)]
        self.simplify(steps, *GOAL)
        self.assertEqual(len(self.outputs()), 11)
        for path in self.outputs():
            label = int(re.search(r"(\d+)", path.name)[1])
            mesh = Vtu(path)
            x, y, z = mesh.points.T.astype("f8")
            np.testing.assert_allclose(values(mesh, "f"), 1 + label * x - y + 0.5 * label * z, atol=2e-5)

    def test_points_that_stayed_keep_their_values(self):
        steps = self.steps()
        self.simplify(steps, *GOAL, "--original-ids")
        for step, path in zip(steps, self.outputs(), strict=True):
            before, after = Vtu(step), Vtu(path)
            ids = values(after, "OriginalPointIds")
            stayed = ids >= 0
            self.assertGreater(stayed.sum(), 100)
            for name in ("bump", "drift"):
                np.testing.assert_array_equal(values(after, name)[stayed], values(before, name)[ids[stayed]])

    def test_the_bound_holds_at_each_step(self):
        steps = self.steps(12)
        for options in (["--max-error", "3%"], ["--max-error", "1%"], ["--max-error", "5%", "--reduction", "50%"],
                        ["--array", "bump:2%"], ["--array", "drift:4%", "--boundary", "planar"], []):
            with self.subTest(options):
                report = self.simplify(steps, *options)
                name = (options[1] if options[:1] == ["--array"] else "bump").split(":")[0]
                bound = "1%" if not options else options[1].split(":")[-1]
                self.assertGreater(report["reduction"], 0.03)
                for step, entry in zip(steps, report["steps"], strict=True):
                    run("compare", step, entry["output"], "--array", name, "--max-error", bound)

    def steps_that_come_back(self, period):
        """With the other sign after so many steps."""
        def make(mesh, time):
            place, sign = time / 2 % period, 1 if time < 2 * period else -1
            x = np.array(mesh.points)[:, 0]
            return with_arrays(mesh, bump=("Float32", sign * np.exp(-2 * (x - place - 1) ** 2)))
        return self.steps(2 * period, make=make)

    def check_bound(self, steps, report, bound):
        self.assertGreater(report["reduction"], 0.1)
        for step, entry in zip(steps, report["steps"], strict=True):
            run("compare", step, entry["output"], "--max-error", bound, "--array", "bump")

    def test_steps_that_cancel_in_a_sum(self):
        steps = self.steps_that_come_back(8)
        report = self.simplify(steps, "--max-error", "4%")
        self.assertIn(report["tries"], range(3, 7))
        self.check_bound(steps, report, "4%")

    def test_steps_that_are_nearly_the_same(self):
        # Where they enter a sum with opposite signs, a bound is more than all that it has.
        steps = self.steps(9, make=lambda mesh, time: wave(mesh, 0.001 if time == 16 else time))
        self.simplify(steps, "--array", "bump")
        for i in range(9):
            run("compare", steps[i], self.folder / f"out_{7 * i:03d}.vtu", "--max-error", "1%", "--array", "bump", "--quiet")

    def test_the_default_is_the_first_array_that_varies_at_any_step(self):
        def make(mesh, time):
            bump = wave(mesh, time).arrays[0][4]
            return with_arrays(mesh, flat=("Float64", np.ones(len(mesh.points))),
                               late=("Float64", time * np.array(bump)), bump=("Float32", bump))

        steps = self.steps(3, make=make)
        report = self.simplify(steps, *GOAL)
        self.assertEqual([[a["name"] for a in s["arrays"]] for s in report["steps"]], [["late"]] * 3)
        said = finish("simplify", *steps, "-o", self.folder / "out_{step}.vtu", *GOAL[:2]).stderr
        self.assertIn(b"array flat has no two finite values that differ", said)
        self.assertIn(b"array late steers", said)

    def test_a_goal_within_a_bound_that_few_sums_do_not_hold(self):
        steps = self.steps_that_come_back(6)
        report = self.simplify(steps, "--max-error", "4%", "--reduction", "40%")
        self.assertIn(report["tries"], range(3, 6))  # without a bound, with six sums, with eight until it holds
        self.check_bound(steps, report, "4%")
        self.assertEqual(self.simplify(steps, "--reduction", "40%")["tries"], 1)

    def test_a_bound_that_is_not_used_is_tried_again(self):
        still = [self.write(wave(jittered(10), 3.0), f"still_{i}.vtu") for i in range(40)]
        one = report_of("simplify", still[0], "-o", self.folder / "one.vtu", "--max-error", "2%", "--quiet")
        report = self.simplify(still, "--max-error", "2%")
        self.assertGreater(report["tries"], 1)
        self.assertGreater(report["reduction"], one["reduction"] - 0.08)
        for step, entry in zip(still, report["steps"], strict=True):
            run("compare", step, entry["output"], "--array", "bump", "--max-error", "2%")

    def test_arrays_of_cells_are_those_of_each_step(self):
        def make(mesh, time):
            made = wave(mesh, time)
            made.arrays.insert(2, ["CellData", "when", "Float32", 1, [time] * len(mesh.tets)])
            made.arrays.insert(2, ["CellData", "where", "Int32", 1, list(range(len(mesh.tets)))])
            made.arrays.insert(2, ["CellData", "slope", "Float64", 1, self.slope(made, time).tolist()])
            return made
        steps = self.steps(3, make=make)
        self.simplify(steps, *GOAL)
        for step, path in zip(steps, self.outputs(), strict=True):
            before, after = Vtu(step), Vtu(path)
            cells = {k: np.squeeze(v) for k, (_, v) in after.arrays["cell"].items()}
            original = {k: np.squeeze(v) for k, (_, v) in before.arrays["cell"].items()}
            self.assertEqual(cells.keys(), original.keys())
            np.testing.assert_array_equal(cells["when"], original["when"][0])
            self.assertEqual(len(np.unique(cells["where"])), len(after.tets))
            # The means of cells are nearer to what is in a tetrahedron than one of them.
            wanted = self.slope(after, original["when"][0])
            errors = [np.abs(some - wanted).mean() for some in (cells["slope"], original["slope"][cells["where"]])]
            self.assertLess(errors[0], 0.8 * errors[1])

    @staticmethod
    def slope(mesh, time):
        """In the middle of each cell."""
        return np.array(mesh.points)[np.array(mesh.tets)].mean(axis=1) @ [1, 2, time]

    def test_arrays_of_cells_steer_by_their_means_at_points(self):
        """As an array of points that holds these does: on a grid whose cells are of one size means have no rounding of their own."""
        def make(time, points):
            mesh = TinyVtu(10)
            centres = np.array(mesh.points)[np.array(mesh.tets)].mean(axis=1)
            p = np.floor(64 * np.exp(-0.3 * (centres[:, 0] - time) ** 2 - 0.1 * centres[:, 1]))
            u = np.stack([p, centres[:, 0] // 1, p % 3], axis=1)
            for name, of_cells in (("p", p), ("u", u)):
                sums, counts = np.zeros((len(mesh.points), *of_cells.shape[1:])), np.zeros(len(mesh.points))
                for k in range(4):
                    np.add.at(sums, np.array(mesh.tets)[:, k], of_cells)
                    np.add.at(counts, np.array(mesh.tets)[:, k], 1)
                means = sums / counts.reshape(-1, *[1] * (sums.ndim - 1))
                width = 1 if of_cells.ndim == 1 else 3
                mesh.arrays.insert(1, ["CellData", name, "Float64", width, of_cells.ravel().tolist()])
                if points:
                    mesh.arrays.insert(1, ["PointData", name, "Float64", width, means.ravel().tolist()])
            mesh.remove("temperature")
            return mesh
        steps = [self.write(make(3.0 * i, False), f"cells_{i}.vtu") for i in range(4)]
        others = [self.write(make(3.0 * i, True), f"points_{i}.vtu") for i in range(4)]
        options = ["--reduction", "70%", "--max-error", "10%", "--threads", "2"]
        report = self.simplify(steps, *options, "--array", "cell:p", "--array", "cell:u:20%")
        by_points = self.simplify(others, *options, "--array", "p", "--array", "u:20%", out="p_{step}.vtu")
        self.assertEqual((report["steering"], by_points["steering"]), (["cell:p", "cell:u"], ["p", "u"]))
        for path, other, step, entry in zip(self.outputs(), self.outputs("p_*.vtu"), steps, report["steps"], strict=True):
            expect_the_same(path, other)
            after, before = Vtu(path), Vtu(step)
            self.assertEqual((after.arrays["point"].keys(), set(after.arrays["cell"])), (before.arrays["point"].keys(), {"p", "u", "id"}))
            cells, old = ({k: np.squeeze(v) for k, (_, v) in mesh.arrays["cell"].items()} for mesh in (after, before))
            np.testing.assert_array_equal(cells["p"], old["p"][cells["id"]])
            self.assertEqual([a["name"] for a in entry["arrays"]], ["cell:p", "cell:u"])
            for array, bound in zip(entry["arrays"], (0.1, 0.2)):
                self.assertLessEqual(array["max"], bound * (1 + 1e-12))
        out = self.outputs()
        first = [p.read_bytes() for p in out]
        self.simplify(steps, *options[:-1], "1", "--array", "cell:p", "--array", "cell:u:20%")
        self.assertEqual([p.read_bytes() for p in out], first)
        lacks = TinyVtu(10)
        said = finish("simplify", steps[0], self.write(lacks, "cells_9.vtu"), "-o", self.folder / "o_{step}.vtu", "--array", "cell:p", *GOAL)
        self.assertEqual(said.returncode, BAD)
        self.assertIn(b'"cell:p"', said.stderr)

    def test_regions_that_change_from_step_to_step(self):
        """What any step tells apart stays so, in each step's own values."""
        def make(mesh, time):
            made = wave(mesh, time)
            axis = int(time) // 2 % 2
            where = np.array(mesh.points)[np.array(mesh.tets)].mean(axis=1)[:, axis] > 5
            made.arrays.insert(2, ["CellData", "material", "UInt8", 1, where.astype(int).tolist()])
            return made
        steps = self.steps(3, make=make)
        said = finish("simplify", *steps, "-o", self.folder / "out_{step}.vtu", "--reduction", "40%").stderr
        self.assertIn(b"cell array material changes from step to step", said)
        self.simplify(steps, "--reduction", "40%", "--threads", "1", out="one_{step}.vtu")
        self.simplify(steps, "--reduction", "40%", "--threads", "4", out="four_{step}.vtu")
        for of_one, of_four in zip(self.outputs("one_*.vtu"), self.outputs("four_*.vtu"), strict=True):
            self.assertEqual(of_one.read_bytes(), of_four.read_bytes())
        for step, path in zip(steps, self.outputs(), strict=True):
            material = next(a for a in report_of("compare", step, path)["arrays"] if a["name"] == "material")
            self.assertEqual(material["differing"], 0)
        # The same labels as floating-point numbers make the same mesh.
        def make_floats(mesh, time):
            made = make(mesh, time)
            material = made.array("material")
            material[2:] = "Float64", 1, [m / 3 for m in material[4]]
            return made
        steps_of_floats = self.steps(3, make=make_floats)
        self.simplify(steps_of_floats, "--reduction", "40%", "--regions", "material", out="float_{step}.vtu")
        for step, path, other in zip(steps_of_floats, self.outputs("float_*.vtu"), self.outputs("one_*.vtu"), strict=True):
            self.assertEqual(Vtu(path).tets.tolist(), Vtu(other).tets.tolist())
            labels = [np.squeeze(Vtu(p).arrays["cell"]["material"][1]) for p in (path, other)]
            np.testing.assert_array_equal(3 * labels[0], labels[1])
        steps = self.steps(3, make=make)
        said = finish("simplify", steps[0], steps[2], "-o", self.folder / "same_{step}.vtu", "--reduction", "40%").stderr
        self.assertNotIn(b"changes from step to step", said)

    def test_cells_of_lower_dimension_come_along(self):
        steps = [self.write(mesh_of_all_sorts(), f"all{i}.vtu") for i in range(2)]
        alone = self.folder / "alone.vtu"
        run("simplify", steps[0], "-o", alone, "--reduction", "30%", "--quiet")
        self.simplify(steps, "--reduction", "30%")
        self.assertEqual(len(self.outputs()), 2)
        for path in self.outputs():
            self.assertEqual([(t, len(ids)) for t, ids in Vtu(path).others], [(t, len(ids)) for t, ids in Vtu(alone).others])
            self.assertEqual(Vtu(path).arrays["cell"].keys(), Vtu(alone).arrays["cell"].keys())

    def test_cells_of_lower_dimension_may_be_dropped(self):
        steps = [self.write(mesh_of_all_sorts(), f"all{i}.vtu") for i in range(2)]
        bare = [self.folder / f"bare{i}.vtu" for i in range(2)]
        for step, path in zip(steps, bare):
            run("convert", step, path, "--drop-patches")
        for mode, more in (("shared", []), ("each", ["--verify"])):
            self.simplify(steps, "--reduction", "30%", "--series", mode, "--drop-patches", *more)
            self.simplify(bare, "--reduction", "30%", "--series", mode, out="bare_out_{step}.vtu")
            for path, expected in zip(self.outputs(), self.outputs("bare_out_*.vtu"), strict=True):
                self.assertEqual(len(Vtu(path).others), 0)
                np.testing.assert_array_equal(Vtu(path).tets, Vtu(expected).tets)
                np.testing.assert_array_equal(Vtu(path).points, Vtu(expected).points)

    def test_steps_without_change_and_values_that_are_no_numbers(self):
        mesh = jittered(8)
        x = np.array(mesh.points)[:, 0]
        odd = np.where(np.arange(len(x)) == 300, np.nan, np.sin(x))
        steps = [self.write(with_arrays(jittered(8), f=("Float64", f)), f"s{i}.vtu")
                 for i, f in enumerate((np.zeros(len(x)), np.sin(x), odd, 0 * x + 4))]
        self.simplify(steps, "--max-error", "5%")
        self.assertIn(np.isnan(values(Vtu(self.folder / "out_2.vtu"), "f")).sum(), (1, 2, 3))
        self.assertTrue((values(Vtu(self.folder / "out_0.vtu"), "f") == 0).all())
        np.testing.assert_allclose(values(Vtu(self.folder / "out_3.vtu"), "f"), 4, rtol=1e-14)

    def test_steps_without_arrays(self):
        steps = [self.write(with_arrays(jittered(8)), f"s{i}.vtu") for i in range(2)]
        report = self.simplify(steps, *GOAL)
        self.assertEqual((report["series"], report["steering"]), ("shared", []))
        expect_the_same(*self.outputs())

    def test_points_without_a_value_in_a_step_without_change(self):
        mesh = jittered(8)
        x = np.array(mesh.points)[:, 0]
        gaps = np.where(np.arange(len(x)) % 50 == 7, np.nan, 5.0)
        steps = [self.write(with_arrays(mesh, f=("Float64", f)), f"s{i}.vtu") for i, f in enumerate((gaps, np.sin(x), np.cos(x)))]
        report = self.simplify(steps, "--max-error", "5%")
        self.assertGreater(report["reduction"], 0.1)
        self.assertEqual(np.isnan(values(Vtu(self.outputs()[0]), "f")).sum(), np.isnan(gaps).sum())

    def test_steps_come_in_the_order_of_decimal_numbers(self):
        mesh = jittered(4)
        x = np.array(mesh.points)[:, 0]
        for label in "10.0", "0.5", "2.0", "-1":
            self.write(with_arrays(mesh, f=("Float64", float(label) * x)), f"t_{label}.vtu")
        report = self.simplify(sorted(self.folder.glob("t_*.vtu")), "--reduction", "20%", out="o.pvd")
        self.assertEqual([s["step"] for s in report["steps"]], ["-1", "0.5", "2.0", "10.0"])
        self.assertEqual(re.findall(r'timestep="(.*?)".*file="(.*?)"', (self.folder / "o.pvd").read_text()),
                         [(str(i), f"o_{label}.vtu") for i, label in enumerate(("-1", "0.5", "2.0", "10.0"))])

    def test_times_of_the_files_are_written_where_they_tell_all_steps_apart(self):
        mesh = jittered(4)
        x = np.array(mesh.points)[:, 0]
        listed = '<VTKFile type="Collection"><Collection>' + "".join(f'<DataSet file="s{i}.vtu"/>' for i in range(3)) + "</Collection></VTKFile>"
        (self.folder / "in.pvd").write_text(listed)
        for times, written in (((10, 9, 8), "10 9 8"), ((0, 0, 1), "0 1 2"), ((1, np.nan, 3), "0 1 2"), ((7, None, None), "0 1 2")):
            for i, time in enumerate(times):
                field = '<FieldData><DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">' \
                    f"{time}</DataArray></FieldData>" if time is not None else ""
                step = with_arrays(mesh, f=("Float64", np.sin(x + i))).bytes()
                (self.folder / f"s{i}.vtu").write_bytes(step.replace(b"<UnstructuredGrid>", b"<UnstructuredGrid>" + field.encode()))
            for inputs in [self.folder / "in.pvd"], [self.folder / f"s{i}.vtu" for i in range(3)]:
                for options in [], ["--series", "each"]:
                    self.simplify(inputs, "--reduction", "20%", *options, out="o.pvd")
                    times_of = re.findall(r'timestep="(.*?)"', (self.folder / "o.pvd").read_text())
                    self.assertEqual(" ".join(times_of), written)

    def test_regions_that_only_a_later_step_has(self):
        mesh = jittered(8)
        x = np.array(mesh.points)[:, 0]
        side = (x[np.array(mesh.tets)].mean(axis=1) > 4).astype(np.int32)
        steps = []
        for i in range(4):
            step = with_arrays(jittered(8), f=("Float64", np.sin(x + i)))
            if i in (1, 2):
                step.arrays.append(["CellData", "material", "Int32", 1, side.tolist()])
            steps.append(self.write(step, f"s{i}.vtu"))
        for options in [], ["--regions", "material"]:
            bytes_of = []
            for threads in "1", "2":
                self.simplify(steps, "--max-error", "20%", "--threads", threads, *options)
                bytes_of.append([p.read_bytes() for p in self.outputs()])
            self.assertEqual(bytes_of[0], bytes_of[1])
            material = next(a for a in report_of("compare", steps[1], self.outputs()[1])["arrays"] if a["name"] == "material")
            for region in material["regions"]:
                self.assertAlmostEqual(region["simplified"] / region["original"], 1, delta=1e-9)
        result = finish("simplify", *steps, "-o", self.folder / "x_{step}.vtu", "--max-error", "20%", "--regions", "nothing")
        self.assertEqual(result.returncode, USAGE)
        self.assertIn(b"--regions nothing: there is no cell array", result.stderr)

    def test_a_map_takes_other_results_along(self):
        steps = self.steps(2)
        self.simplify(steps, *GOAL, "--map", self.folder / "out.map")
        run("apply", self.folder / "out.map", steps[1], "-o", self.folder / "moved.vtu", "--quiet")
        pair = self.folder / "moved.vtu", self.outputs()[1]
        expect_the_same(*pair)
        # In a series all is fitted to the step, whether it steers or not; what is linear stays so.
        errors = [{a["name"]: a["rms"] for a in report_of("compare", steps[1], path, "--quiet")["arrays"]} for path in pair]
        for name in ("bump", "drift"):
            moved, fitted = (values(Vtu(path), name) for path in pair)
            np.testing.assert_allclose(moved, fitted, atol=0.05)
            self.assertLess(errors[1][name], 0.9 * errors[0][name])
        np.testing.assert_allclose(moved[:, 1:], fitted[:, 1:], atol=1e-5)

    def test_points_that_no_cell_uses_have_no_say(self):
        def steps(value):
            for i in range(2):
                mesh = wave(jittered(8), 2.0 * i)
                mesh.remove("drift")
                mesh.array("Points")[4] = list(mesh.array("Points")[4]) + [20.0, 0.0, 0.0]
                mesh.array("bump")[4] = list(mesh.array("bump")[4]) + [value]
                mesh.counts["NumberOfPoints"] = str(int(mesh.counts["NumberOfPoints"]) + 1)
                for array in mesh.arrays:
                    if array[0] == "PointData" and array[1] != "bump":
                        array[4] = list(array[4]) + [0] * array[3]
                yield self.write(mesh, f"s{i}.vtu")
        reports = [self.simplify(list(steps(value)), "--array", "bump", "--max-error", "3%") for value in (0.5, -9999.0)]
        # Costs are shares of a range that is ten thousand times as large then, and what lengths add to them is not, so that
        # the order is another one; a bound that is as much larger would leave next to nothing inside.
        self.assertAlmostEqual(reports[1]["output"]["tets"] / reports[0]["output"]["tets"], 1, delta=0.3)

    def test_weights_are_those_of_the_first_step(self):
        def make(mesh, time):
            right = np.array(mesh.points)[:, 0] > 5
            return with_arrays(mesh, bump=("Float32", np.sin(np.array(mesh.points)).sum(axis=1) + time),
                               weight=("Float32", np.where(right, 50.0, 1.0) if time == 0 else 0 * right))
        steps = self.steps(2, make=make)
        plain, weighted = (self.simplify(steps, *GOAL, "--array", "bump", *more, out=f"{len(more)}_{{step}}.vtu")
                           for more in ([], ["--weight", "weight"]))
        right = [(Vtu(r["outputs"][1]).points[:, 0] > 5).sum() for r in (plain, weighted)]
        self.assertGreater(right[1], 1.1 * right[0])
        # An array of cells may steer, by its means at points, and weigh as well.
        parts = [self.generate("--time", str(time), tets="2k", name=f"part_{time}.vtu") for time in range(2)]
        both = ["--array", "cell:region", "--weight", "cell:region", *GOAL]
        self.assertEqual(len(self.simplify(parts, "--array", "front", *both, out="p_{step}.vtu")["outputs"]), 2)
        said = finish("simplify", *steps, "-o", self.folder / "x_{step}.vtu", *GOAL, "--weight", "none")
        self.assertEqual(said.returncode, USAGE)

    def test_tetfuse(self):
        steps = [self.generate("--jitter", "0.5", "--time", str(t), tets="20k", name=f"s{t}.vtu") for t in range(3)]
        reports = [self.simplify(steps, "--method", "tetfuse", "--array", "front" + share) for share in (":0.1%", ":50%")]
        self.assertEqual([r["tries"] for r in reports], [1, 1])
        self.assertLess(reports[0]["reduction"], reports[1]["reduction"])

    def test_other_formats(self):
        steps = self.steps(2)
        self.simplify(steps, *GOAL)
        self.simplify(steps, *GOAL, out="o_{step}.msh")
        said = finish("simplify", *steps, "-o", self.folder / "o_{step}.mesh", "--reduction", "60%").stderr.decode()
        self.assertIn("bump", said)  # has no place in such a file
        for kind, arrays in (("msh", ["bump", "drift"]), ("mesh", [])):
            for path, other in zip(self.outputs(), self.outputs(f"o_*.{kind}"), strict=True):
                run("convert", other, self.folder / "back.vtu", "--quiet")
                expect_the_same(self.folder / "back.vtu", path, *arrays)
        self.simplify(self.outputs("o_*.msh"), "--reduction", "20%", out="again_{step}.vtu")
        for path, again in zip(self.outputs(), self.outputs("again_*.vtu"), strict=True):
            run("compare", path, again, "--max-error", "5%", "--surface", "0")

    def test_steps_may_be_written_in_different_ways(self):
        steps = self.steps(3)
        self.simplify(steps, *GOAL)
        expected = [p.read_bytes() for p in self.outputs()]
        for step, encoding in zip(steps[1:], ("zlib", "ascii")):
            packed = self.folder / "packed.vtu"
            run("convert", step, packed, "--encoding", encoding)
            packed.rename(step)
        self.simplify(steps, *GOAL)
        self.assertEqual([p.read_bytes() for p in self.outputs()], expected)


    def test_what_is_the_same_everywhere_at_each_step(self):
        """Any bound holds for it. Where the user has named it the run goes as far as it can, else nobody has said how far."""
        def make(mesh, time):
            return with_arrays(mesh, f=("Float32", [time] * len(mesh.points)))

        alone = self.steps(2, name="alone_{}.vtu", make=make)
        said = finish("simplify", *alone, "-o", self.folder / "out_{step}.vtu")
        self.assertEqual(said.returncode, USAGE)
        self.assertIn(b"give --reduction or --tets, or --array f, which is the same everywhere, to go as far as shapes allow",
                      said.stderr)
        steps = self.steps(2, make=lambda mesh, time: with_arrays(mesh, f=("Float32", [time] * len(mesh.points)),
                                                                  g=("Float32", np.array(mesh.points)[:, 0])))
        self.assertEqual([a["name"] for a in self.simplify(steps)["steps"][1]["arrays"]], ["g"])
        for options in ["--array", "f"], ["--array", "f:1%"], GOAL:
            report = self.simplify(steps, *options)
            self.assertLess(report["output"]["tets"], 0.6 * report["input"]["tets"])
            self.assertLess(max(s["arrays"][0]["max"] for s in report["steps"]), 1e-12)



if __name__ == "__main__":
    main()
