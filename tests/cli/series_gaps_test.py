#!/usr/bin/env python3
"""Series whose bounds are loose, whose steps have no values, and what is said of them. Usage: series_gaps_test.py TETFUSION"""
import numpy as np

from follow_test import jittered, values, with_arrays
from harness import USAGE, finish, main, run
from independent_check import Vtu
from series_test import SeriesTest, wave


class LooseBounds(SeriesTest):
    def test_a_looser_bound_is_no_stricter_one(self):
        """Where all errors are allowed the bound that is the default without any has no say."""
        steps = self.steps(3)
        left = [self.simplify(steps, "--max-error", bound, "--boundary", "2%")["output"]["tets"] for bound in ("3%", "30%", "100%")]
        self.assertLess(left[1], left[0])
        self.assertLessEqual(left[2], left[1])
        mesh = jittered(10)
        bumps = {f"p_{i}": ("Float32", wave(mesh, 2.0 * i).array("bump")[4]) for i in range(3)}
        one = self.write(with_arrays(jittered(10), **bumps), "one.vtu")
        left = [self.simplify([one], "--array", f"p_{{step}}:{bound}", out="o.vtu")["output"]["tets"] for bound in ("3%", "60%")]
        self.assertLess(left[1], left[0])


class Gaps(SeriesTest):
    def gappy(self, *kept):
        """Steps with a bump, but for points that have no value: kept[i](x) says which of step i have one."""
        mesh = jittered(10)
        x = np.array(mesh.points)[:, 0]
        bump = [np.where(keep(x), np.array(wave(mesh, 3.0 * i).array("bump")[4]), np.nan) for i, keep in enumerate(kept)]
        return [self.write(with_arrays(jittered(10), bump=("Float64", b)), f"s{i}.vtu") for i, b in enumerate(bump)]

    def check(self, steps, *options):
        report = self.simplify(steps, "--array", "bump", *options)
        self.assertEqual(len(self.outputs()), len(steps))
        for step, out in zip(steps, self.outputs(), strict=True):
            before, after = (values(Vtu(path), "bump") for path in (step, out))
            if np.isnan(before).all():
                self.assertTrue(np.isnan(after).all())
            else:
                run("compare", step, out, "--max-error", "3%", "--array", "bump")
        return report["reduction"]

    def test_a_step_without_any_value_takes_nothing_from_the_others(self):
        all_of, none = (lambda x: x > -1), (lambda x: x > 99)
        alone = self.check(self.gappy(none, all_of)[1:], "--max-error", "3%")
        self.assertGreater(alone, 0.2)
        for kept in ((none, all_of), (all_of, none), (none, all_of, none, all_of), [all_of] * 8 + [none]):
            for path in self.outputs():
                path.unlink()
            self.assertGreater(self.check(self.gappy(*kept), "--max-error", "3%"), 0.1)
        self.simplify(self.gappy(none, none), "--array", "bump", "--reduction", "30%")

    def test_steps_whose_values_never_meet(self):
        """Nine steps: the ninth is in one sum with the first, and that sum has a value nowhere."""
        left, right, all_of = (lambda x: x < 5), (lambda x: x >= 5), (lambda x: x > -1)
        self.check(self.gappy(left, *[all_of] * 7, right), "--max-error", "3%")


class Interest(SeriesTest):
    def test_where_points_are_joined_when_they_are_read(self):
        whole, pieces = self.steps(2), []
        for step in whole:
            pieces.append(step.with_suffix(".pvtu"))
            run("simplify", step, "-o", pieces[-1], "--pieces", "3", "--reduction", "0%", "--quiet")
        options = ["--array", "bump", "--roi", "bump>0.5", "--reduction", "20%"]
        self.simplify(pieces, *options)
        for step, out in zip(whole, self.outputs(), strict=True):
            before, after = Vtu(step), Vtu(out)
            inside = {tuple(p) for p in before.points[values(before, "bump") > 0.5].tolist()}
            self.assertGreater(len(inside), 10)
            self.assertLessEqual(inside, {tuple(p) for p in after.points.tolist()})

    def test_values_that_are_next_to_nothing(self):
        """The inverse of their range is no number of double precision."""
        steps = self.steps(3, make=lambda mesh, time: with_arrays(
            mesh, bump=("Float64", np.array(wave(mesh, time).array("bump")[4], dtype="f8") * 1e-310)))
        large = self.steps(3, name="large_{:03d}.vtu", make=lambda mesh, time: with_arrays(
            mesh, bump=("Float64", np.array(wave(mesh, time).array("bump")[4], dtype="f8"))))
        left = [self.simplify(some, "--array", "bump", "--max-error", "3%")["output"]["tets"] for some in (steps, large)]
        self.assertLess(abs(left[0] - left[1]), 0.05 * left[1])

    def test_a_range_above_the_largest_number(self):
        scale = {"huge": 1.6e308, "plain": 1.0}
        left = []
        for name, factor in scale.items():
            steps = self.steps(3, name=name + "_{:03d}.vtu", make=lambda mesh, time: with_arrays(
                mesh, bump=("Float64", factor * np.sin(4 * np.array(mesh.points)[:, 0] / 10 + time))))
            report = self.simplify(steps, "--array", "bump", "--max-error", "3%")
            left.append(report["output"]["tets"])
            self.assertLess(left[-1], 0.7 * report["input"]["tets"])
        self.assertLess(abs(left[0] - left[1]), 0.05 * left[1])


class OneOfAList(SeriesTest):
    def test_a_step_of_a_list_stands_for_itself(self):
        steps = self.steps(3)
        self.simplify(steps, "--reduction", "30%", out="list.pvd")
        listed, single = sorted(self.folder.glob("list_*.vtu"))[2], self.folder / "single.vtu"
        run("simplify", listed, "-o", single, "--reduction", "30%", "--map", self.folder / "a.map")
        for options, code in ((["--time-step", "2"], 0), (["--time-step", "last"], 0), (["--time-step", "3"], USAGE)):
            out = self.folder / "one.vtu"
            result = finish("simplify", self.folder / "list.pvd", "-o", out, "--reduction", "30%", *options)
            self.assertEqual(result.returncode, code, result.stderr)
            if code == 0:
                self.assertEqual(out.read_bytes(), single.read_bytes())
        for command in (["convert"], ["apply", self.folder / "a.map"]):
            to = [self.folder / "x.vtu"] if command == ["convert"] else ["-o", self.folder / "x.vtu"]
            run(*command, listed, *to)
            expected = (self.folder / "x.vtu").read_bytes()
            run(*command, self.folder / "list.pvd", *to, "--time-step", "2")
            self.assertEqual((self.folder / "x.vtu").read_bytes(), expected)
            result = finish(*command, self.folder / "list.pvd", *to)
            self.assertEqual(result.returncode, USAGE)
            self.assertIn("its name must hold {step}, or be that of a .pvd, or one of them be chosen (--time-step)",
                          result.stderr.decode())
        run("simplify", self.folder / "list.pvd", "-o", self.folder / "again.pvd", "--reduction", "30%", "--time-step", "1")
        self.assertEqual((self.folder / "again.pvd").read_text().count("<DataSet"), 1)


class Words(SeriesTest):
    def said(self, steps, *options, code=0, out="out_{step}.vtu"):
        result = finish("simplify", *steps, "-o", self.folder / out, *options)
        self.assertEqual(result.returncode, code, result.stderr.decode())
        return result.stderr.decode()

    def with_set(self, count):
        mesh = jittered(10)
        inside = [int(p[0] > 5) for p in mesh.points]
        return self.steps(count, make=lambda mesh, time: with_arrays(
            mesh, bump=("Float32", wave(mesh, time).array("bump")[4]), clamped=("Int32", inside)))

    def test_sets_of_nodes_are_the_users(self):
        said = self.said(self.with_set(2), "--array", "bump", "--reduction", "30%", "--roi", "bump>0.9", "--boundary", "planar")
        self.assertIn("point array clamped may be a set of nodes", said)
        self.assertNotIn("region of interest may be", said)

    def test_arrays_have_the_names_that_they_have_in_the_files(self):
        steps = [self.write(with_arrays(jittered(6), f=("Float64", np.full(7 ** 3, float(i)))), f"s{i}.vtu") for i in range(3)]
        said = self.said(steps, "--array", "f", "--reduction", "30%")
        self.assertEqual(said.count("array f has no two finite values that differ"), 1)
        self.assertNotIn("sum 1 of", said)

    def test_advice_for_steps_in_one_mesh(self):
        mesh = jittered(10)
        arrays = {f"p_{i:03d}": ("Float32", wave(mesh, 2.0 * i).array("bump")[4]) for i in range(3)}
        arrays |= {f"n_{i}": ("Int32", np.arange(11 ** 3) % (3 + i)) for i in range(2)}
        one = [self.write(with_arrays(jittered(10), **arrays), "one.vtu")]
        for option in ("--verify", "--conserve", "--resume"):
            said = self.said(one, "--array", "p_{step}", option, code=USAGE, out="o.vtu")
            self.assertIn("leave it out", said)
            self.assertNotIn("--series each", said)
        said = finish("simplify", *one, "-o", self.folder / "o.vtu", "--array", "n_{step}", "--reduction", "9%").stderr.decode()
        self.assertIn("name another array", said)
        self.assertNotIn("--series each", said)
        mean = [self.write(with_arrays(jittered(10), **arrays, p_mean=arrays["p_000"]), "mean.vtu")]
        said = self.said(mean, "--array", "p_{step}", "--reduction", "9%", out="o.vtu")
        self.assertIn("named like p_{step}, but no steps, as theirs are numbers: p_mean", said)
        said = self.said(one, "--array", "p_00{step}", "--roi", "p_001>0.5", code=USAGE, out="o.vtu")
        self.assertIn("--roi 'p_00{step}>0.5' is for each of them", said)
        said = self.said(self.steps(2), "--series", "each", "--map", self.folder / "o.map", "--reduction", "9%", code=USAGE)
        self.assertIn("--map is not for --series each", said)


if __name__ == "__main__":
    main()
