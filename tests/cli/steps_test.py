#!/usr/bin/env python3
"""apply and convert where they take all steps of a series. Usage: steps_test.py TETFUSION"""
from xml.etree import ElementTree

from follow_test import jittered
from harness import BAD, IO, USAGE, finish, main, report_of, run
from independent_check import Vtu
from series_test import SeriesTest, wave


def listed(path):
    """Times and files of a .pvd."""
    return [(float(d.get("timestep")), d.get("file")) for d in ElementTree.parse(path).iter("DataSet")]


class StepsTest(SeriesTest):
    def setUp(self):
        super().setUp()
        self.original = self.write(wave(jittered(10), 1.0), "original.vtu")
        self.map = self.folder / "a.map"
        run("simplify", self.original, "-o", self.folder / "small.vtu", "--reduction", "60%", "--map", self.map, "--quiet")

    def timed(self, times):
        """Steps that say their times, of one mesh, and a map that is for it."""
        steps = [self.generate("--time", str(t), tets="3k", name=f"t{i}.vtu") for i, t in enumerate(times)]
        run("simplify", steps[0], "-o", self.folder / "small.vtu", "--reduction", "60%", "--map", self.map, "--quiet")
        return steps

    def refused(self, *arguments, code=USAGE):
        before = self.files()
        result = finish(*arguments)
        self.assertEqual(result.returncode, code, result)
        self.assertEqual(self.files(), before)
        return result.stderr.decode()


class Apply(StepsTest):
    def test_each_step_comes_out_as_by_itself(self):
        steps = self.steps(3)
        for options in ([], ["--fit"], ["--array", "bump", "--encoding", "zlib"]):
            with self.subTest(options):
                report = report_of("apply", self.map, *steps, "-o", self.folder / "out_{step}.vtu", "--quiet", *options)
                self.assertEqual([s["step"] for s in report["steps"]], ["000", "007", "014"])
                self.assertNotIn("list", report)
                for step, entry in zip(steps, report["steps"], strict=True):
                    alone = self.folder / "alone.vtu"
                    single = report_of("apply", self.map, step, "-o", alone, "--quiet", *options)
                    self.assertEqual((self.folder / f"out_{entry['step']}.vtu").read_bytes(), alone.read_bytes())
                    self.assertEqual((entry["path"], entry["output"]),
                                     (str(step), str(self.folder / f"out_{entry['step']}.vtu")))
                    for key in ("arrays", "cell_arrays", "stayed_points", "stayed_points_elsewhere"):
                        self.assertEqual(entry[key], single[key])

    def test_a_list_gives_a_list_with_its_times(self):
        steps = self.timed((0.5, 1.25, 8.0))
        run("apply", self.map, *steps, "-o", self.folder / "out.pvd", "--quiet")
        expected = [(0.5, "out_0.vtu"), (1.25, "out_1.vtu"), (8.0, "out_2.vtu")]
        self.assertEqual(listed(self.folder / "out.pvd"), expected)
        run("convert", self.write_list(steps, (3, 4, 5)), self.folder / "in.pvd", "--quiet")  # its own times, not the files'
        report = report_of("apply", self.map, self.folder / "in.pvd", "-o", self.folder / "again.pvd", "--quiet")
        self.assertEqual(report["list"], str(self.folder / "again.pvd"))
        self.assertEqual([s["time"] for s in report["steps"]], [3, 4, 5])
        self.assertEqual([time for time, _ in listed(self.folder / "again.pvd")], [3, 4, 5])
        for i in range(3):
            again = Vtu(self.folder / listed(self.folder / "again.pvd")[i][1])
            out = Vtu(self.folder / expected[i][1])
            self.assertTrue((again.arrays["point"]["front"][1] == out.arrays["point"]["front"][1]).all())
        run("apply", self.map, self.folder / "in.pvd", "-o", self.folder / "one.pvd", "--time-step", "last", "--quiet")
        self.assertEqual([time for time, _ in listed(self.folder / "one.pvd")], [5])

    def write_list(self, steps, times):
        path = self.folder / "steps.pvd"
        path.write_text('<VTKFile type="Collection"><Collection>' + "".join(
            f'<DataSet timestep="{t}" file="{s.name}"/>' for s, t in zip(steps, times, strict=True)) + "</Collection></VTKFile>")
        return path

    def test_what_is_worst_is_said(self):
        steps = self.steps(2)
        said = finish("apply", self.map, *steps, "-o", self.folder / "out_{step}.vtu", "--verbose").stderr.decode()
        for name in ("out_000.vtu", "out_007.vtu"):
            self.assertRegex(said, rf"{name}: bump: off by [0-9.e-]+ % of its range")
        report = report_of("apply", self.map, *steps, "-o", self.folder / "out_{step}.vtu", "--quiet")
        errors = [next(a for a in step["arrays"] if a["name"] == "bump") for step in report["steps"]]
        worst = max(range(2), key=lambda i: errors[i]["max"])
        said = finish("apply", self.map, *steps, "-o", self.folder / "out_{step}.vtu").stderr.decode()
        self.assertIn(f"bump: off by {100 * errors[worst]['max']:.3g} % of its range in a step at most "
                      f"(step {report['steps'][worst]['step']}), by up to {100 * max(e['rms'] for e in errors):.3g} % in the mean", said)
        moved = wave(jittered(10), 1.0)
        moved.array("Points")[4] = [c + 1 for c in moved.array("Points")[4]]
        steps = [*steps, self.write(moved, "step_100.vtu")]
        said = finish("apply", self.map, *steps, "-o", self.folder / "out_{step}.vtu").stderr.decode()
        self.assertIn("in 1 of 3 steps: points that stayed, but lie elsewhere in step 100: ", said)

    def test_arrays_that_not_all_steps_have(self):
        steps = self.steps(2)
        less = wave(jittered(10), 5.0)
        less.arrays = [a for a in less.arrays if a[1] != "drift"]
        steps.append(self.write(less, "step_100.vtu"))
        said = finish("apply", self.map, *steps, "-o", self.folder / "out_{step}.vtu").stderr.decode()
        self.assertIn("arrays that not all steps have: drift (not in step 100)", said)
        said = finish("simplify", *steps, "-o", self.folder / "s_{step}.vtu", "--array", "bump", "--reduction", "30%").stderr.decode()
        self.assertIn("arrays that not all steps have: drift (not in step 100)", said)

    def test_a_list_names_no_steps_of_two_runs(self):
        steps = self.steps(3)
        for command in ["apply", self.map], ["simplify", "--reduction", "30%"], ["simplify", "--reduction", "30%", "--series", "each"]:
            run(*command, *steps, "-o", self.folder / "out.pvd", "--quiet")
            whole = steps[2].read_bytes()
            steps[2].write_bytes(whole[:-500])  # in the midst of its values
            run(*command, *steps, "-o", self.folder / "out.pvd", "--quiet", code=BAD)
            # A series that is shared has read them all before.
            self.assertEqual((self.folder / "out.pvd").exists(), command == ["simplify", "--reduction", "30%"])
            steps[2].write_bytes(whole)

    def test_times_that_no_output_has_are_told_of(self):
        steps = self.timed((0.5, 1.25))
        for times, is_told in ((0.5, 1.25), False), ((3, 4), True):
            given = self.write_list(steps, times)
            for out in "out.pvd", "out_{step}.vtu":
                for command in (["apply", self.map, given, "-o"], ["convert", given], ["simplify", given, "--reduction", "30%", "-o"]):
                    said = finish(*command, self.folder / out).stderr.decode()
                    self.assertEqual("the times that the list gives" in said, is_told and out != "out.pvd", (command, out))

    def test_whole_numbers_are_times(self):
        steps = self.timed((5, 15, 25))
        for step in steps:
            run("convert", step, step, "--encoding", "ascii", "--quiet")
            text = step.read_text()
            self.assertEqual(text.count('type="Float64" Name="TimeValue"'), 1)
            step.write_text(text.replace('type="Float64" Name="TimeValue"', 'type="Int64" Name="TimeValue"'))
        run("apply", self.map, *steps, "-o", self.folder / "out.pvd", "--quiet")
        self.assertEqual([time for time, _ in listed(self.folder / "out.pvd")], [5, 15, 25])

    def test_what_cannot_be_is_refused_before_anything_is_written(self):
        steps = self.steps(2)
        to = ["-o", self.folder / "out_{step}.vtu"]
        self.assertIn("its name must hold {step}", self.refused("apply", self.map, *steps, "-o", self.folder / "out.vtu"))
        self.assertIn("standard input and output hold one mesh", self.refused("apply", self.map, *steps, "-o", "-"))
        self.assertIn("standard input and output hold one mesh", self.refused("apply", self.map, "-", *to))
        self.assertIn("is an input of the series", self.refused("apply", self.map, *steps, "-o", self.folder / "step_{step}.vtu"))
        self.assertIn("step_007.vtu", self.refused("apply", self.map, *steps, *to, "--report", steps[1]))
        self.assertIn("out_007.vtu", self.refused("apply", self.map, *steps, *to, "--report", self.folder / "out_007.vtu"))
        self.assertIn("a.map", self.refused("apply", self.map, *steps, *to, "--report", self.map))
        self.assertIn("no .pvtu", self.refused("apply", self.map, *steps, "-o", self.folder / "out_{step}.pvtu"))
        self.assertIn("--time-step", self.refused("apply", self.map, self.write_list(steps, (0, 1)), "-o", self.folder / "o.vtu"))
        run("apply", self.folder / "none.map", *steps, *to, code=IO)

    def test_a_failure_says_how_many_are_written(self):
        steps = [*self.steps(2), self.write(wave(jittered(6), 0.0), "step_999.vtu")]
        said = finish("apply", self.map, *steps, "-o", self.folder / "out_{step}.vtu")
        self.assertEqual(said.returncode, BAD)
        self.assertIn(b"step_999.vtu: the mesh has", said.stderr)
        self.assertIn(b"; steps written: 2 of 3", said.stderr)
        self.assertEqual(len(self.outputs()), 2)


class Convert(StepsTest):
    def test_each_step_comes_out_as_by_itself(self):
        steps = self.timed((0.5, 1.25))
        run("apply", self.map, *steps, "-o", self.folder / "in.pvd", "--quiet")
        run("convert", self.folder / "in.pvd", self.folder / "out_{step}.vtk", "--quiet")
        for i in "01":
            run("convert", self.folder / f"in_{i}.vtu", self.folder / "alone.vtk", "--quiet")
            self.assertEqual((self.folder / f"out_{i}.vtk").read_bytes(), (self.folder / "alone.vtk").read_bytes())
        run("convert", self.folder / "in.pvd", self.folder / "out.pvd", "--encoding", "ascii", "--quiet")
        self.assertEqual(listed(self.folder / "out.pvd"), [(0.5, "out_0.vtu"), (1.25, "out_1.vtu")])
        said = finish("convert", self.folder / "in.pvd", self.folder / "more.pvd").stderr.decode()
        self.assertEqual(len([line for line in said.splitlines() if "tetrahedra -> " in line]), 2)
        self.assertIn("its name must hold {step}", self.refused("convert", self.folder / "in.pvd", self.folder / "no.vtk"))
        self.assertIn("is an input of the series", self.refused("convert", self.folder / "in.pvd", self.folder / "in_{step}.vtu"))


if __name__ == "__main__":
    main()
