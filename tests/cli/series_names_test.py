#!/usr/bin/env python3
"""Which files are the steps of a series, what {step} stands for, and what a series cannot be. Usage: series_names_test.py TETFUSION"""
import json
import os
import resource
import xml.etree.ElementTree as ElementTree

import numpy as np

from follow_test import jittered, with_arrays
from harness import BAD, INVALID, IO, USAGE, finish, main, report_of, run
from series_test import GOAL, SeriesTest, wave


class Names(SeriesTest):
    def test_a_list_of_steps(self):
        (self.folder / "in").mkdir()
        (self.folder / "results").mkdir()
        steps = self.steps(3, name="in/step{}.vtu")
        rows = "".join(f'<DataSet timestep="{t}" part="0" file="{p.relative_to(self.folder)}"/>'
                       for t, p in zip((0.5, 3, 1e-3), steps))
        (self.folder / "run.pvd").write_text(f'<VTKFile type="Collection"><Collection>{rows}</Collection></VTKFile>')
        report = self.simplify([self.folder / "run.pvd"], *GOAL, out="results/out.pvd")
        listed = [(float(d.get("timestep")), d.get("file")) for d in ElementTree.parse(self.folder / "results/out.pvd").iter("DataSet")]
        self.assertEqual(listed, [(1e-3, "out_14.vtu"), (0.5, "out_0.vtu"), (3.0, "out_7.vtu")])
        self.assertEqual([s["time"] for s in report["steps"]], [1e-3, 0.5, 3.0])
        self.assertTrue(all((self.folder / "results" / f).exists() for _, f in listed))
        self.simplify([self.folder / "results/out.pvd"], "--reduction", "10%", out="b_{step}.vtu")
        self.assertEqual([p.name for p in self.outputs("b_*")], ["b_0.vtu", "b_14.vtu", "b_7.vtu"])
        # The same as JSON, as ParaView names the files that it saves.
        files = [{"name": f"results/{f}", "time": t} for t, f in listed]
        (self.folder / "run.vtu.series").write_text(json.dumps({"file-series-version": "1.0", "files": files}))
        self.simplify([self.folder / "run.vtu.series"], "--reduction", "10%", out="c_{step}.vtu")
        self.assertEqual([(self.folder / f"c_{s}.vtu").read_bytes() for s in (0, 7, 14)],
                         [(self.folder / f"b_{s}.vtu").read_bytes() for s in (0, 7, 14)])
        self.assertEqual(report_of("info", self.folder / "run.vtu.series")["path"], str(self.folder / "results/out_14.vtu"))

    def test_a_list_is_looked_at_step_by_step(self):
        steps = self.steps(3)
        rows = "".join(f'<DataSet timestep="{t}" file="{p.name}"/>' for t, p in zip((" +0.5", 3, "1e-3"), steps))
        listed, out = self.folder / "run.pvd", self.folder / "out.pvd"
        listed.write_text(f"<VTKFile><Collection>{rows}</Collection></VTKFile>")
        in_order = [(str(steps[i]), t) for i, t in ((2, 1e-3), (0, 0.5), (1, 3.0))]
        self.simplify([listed], *GOAL, out="out.pvd")

        for number, options in ((0, []), (1, ["--time-step", "1"]), (2, ["--time-step", "last"])):
            info = report_of("info", listed, *options)
            self.assertEqual((info["path"], info["list"]["step"]), (in_order[number][0], number))
            self.assertEqual([(s["path"], s["time"]) for s in info["list"]["steps"]], in_order)
        self.assertIn("steps         3, from 0.001 to 3; number 1, at 0.5, is read (--time-step)\nfiles         "
                      + ", ".join(path for path, _ in in_order) + "\nfile ", run("info", listed, "--time-step", "1").decode())

        report = report_of("check", listed)
        self.assertEqual([(s["path"], s["time"], s["valid"]) for s in report["steps"]], [(*s, True) for s in in_order])
        compared = report_of("compare", listed, out, "--max-error", "100%")
        self.assertEqual([s["original"]["path"] for s in compared["steps"]], [path for path, _ in in_order])
        self.assertEqual([s["time"] for s in compared["steps"]], [t for _, t in in_order])
        alone = report_of("compare", steps[0], self.folder / "out_000.vtu", "--max-error", "100%")
        self.assertEqual(compared["steps"][1]["arrays"], alone["arrays"])
        self.assertEqual(report_of("compare", listed, self.folder / "out_000.vtu", "--time-step", "1")["steps"][0]["arrays"], alone["arrays"])
        errors = sorted(max(a["max"] for a in s["arrays"] if a["name"] == "bump") for s in compared["steps"])
        between = f"{(errors[1] + errors[2]) / 2:.9f}"
        said = finish("compare", listed, out, "--array", "bump", "--max-error", between)
        self.assertEqual(said.returncode, INVALID)
        self.assertIn(b"3 steps compared, bounds broken at 1\n", said.stdout)
        said = finish("compare", listed, out, "--array", "bump", "--max-error", between, "--quiet")
        self.assertRegex(said.stderr.decode(), r"^tetfusion: error: \S*out_\d+.vtu: .*bump")

        broken = jittered(10)
        broken.array("connectivity")[4][-4:] = broken.array("connectivity")[4][:4]
        self.write(broken, steps[0].name)
        report = report_of("check", listed, code=INVALID)
        self.assertEqual((report["valid"], [s["valid"] for s in report["steps"]]), (False, [True, False, True]))
        self.assertIn(b"1 of 3 steps invalid\n", finish("check", listed).stdout)
        run("check", listed, "--time-step", "0")
        for arguments, why in ((["check", listed, "--fix", self.folder / "fixed.vtu"], "give one of the files that the list names"),
                               (["check", listed, "--time-step", "3"], "there is no time step 3"),
                               (["check", listed, "--report", steps[1]], "step_007.vtu"),
                               (["info", listed, "--time-step", "3"], "there is no time step 3"),
                               (["info", listed, "--report", steps[1]], "step_007.vtu"),
                               (["compare", listed, steps[0]], "is 3 steps, and"),
                               (["compare", listed, out, "--report", self.folder / "out_007.vtu"], "out_007.vtu")):
            self.assertIn(why, self.refused_command(*arguments))
        the_map = self.folder / "step.map"
        run("simplify", steps[0], "-o", self.folder / "one.vtu", "--reduction", "30%", "--map", the_map)
        for arguments in ["convert", listed, self.folder / "one.vtu"], ["apply", the_map, listed, "-o", self.folder / "one.vtu"]:
            self.assertIn("there is no time step 3", self.refused_command(*arguments, "--time-step", "3"))

    def refused_command(self, *arguments, code=USAGE):
        result = finish(*arguments)
        self.assertEqual(result.returncode, code, result)
        return result.stderr.decode()

    def test_times_are_those_of_the_files(self):
        steps = [self.generate("--time", str(t), tets="3k", name=f"s{i}.vtu") for i, t in enumerate((0.5, 1.25))]
        for mode in ("shared", "each"):
            self.simplify(steps, *GOAL, "--series", mode, out=f"{mode}.pvd")
            times = [float(d.get("timestep")) for d in ElementTree.parse(self.folder / f"{mode}.pvd").iter("DataSet")]
            self.assertEqual(times, [0.5, 1.25])
            self.assertEqual(len(self.outputs(f"{mode}_*.vtu")), 2)

    def test_what_stands_for_the_step(self):
        for names, *labels in ((["a_9.vtu", "a_10.vtu"], "9", "10"), (["a_10.vtu", "a_9.vtu"], "10", "9"),
                               (["f011.vtu", "f010.vtu"], "011", "010"), (["before.vtu", "after.vtu"], "before", "after"),
                               (["y/m.vtu", "x/m.vtu"], "y", "x"), (["t12.vtu"], "12"), (["t.vtu"], "0"),
                               (["a\u00f6.vtu", "a\u00e4.vtu"], "\u00f6", "\u00e4"),
                               (["x\u00e4b.vtu", "x\u03a4b.vtu"], "\u00e4", "\u03a4"), (["aa.vtu", "a.vtu"], "0", "1")):
            with self.subTest(names):
                for name in names:
                    (self.folder / name).parent.mkdir(exist_ok=True)
                    self.write(wave(jittered(4), 1.0), name)
                report = self.simplify([self.folder / n for n in names], "--reduction", "10%", out="o{step}.vtu")
                expected = [(str(self.folder / name), label) for name, label in zip(names, labels, strict=True)]
                if labels[0].isdigit():
                    expected.sort(key=lambda step: int(step[1]))
                self.assertEqual([(s["input"], s["step"]) for s in report["steps"]], expected)
                self.assertEqual(report["outputs"], [str(self.folder / f"o{label}.vtu") for _, label in expected])

    def test_each_step_in_a_folder_of_its_own(self):
        folders = [self.folder / f"case_{step}" for step in (0, 1)]
        for folder in folders:
            folder.mkdir()
            self.write(wave(jittered(4), 1.0), folder / "internal.vtu")
        self.simplify([folder / "internal.vtu" for folder in folders], "--reduction", "10%", out="case_{step}/small.vtu")
        for folder in folders:
            self.assertEqual(sorted(path.name for path in folder.iterdir()), ["internal.vtu", "small.vtu"])

    def test_steps_come_in_the_order_of_their_numbers(self):
        steps = self.steps(3, name="s{}.vtu")
        report = self.simplify(steps[::-1], *GOAL)
        self.assertEqual([s["step"] for s in report["steps"]], ["0", "7", "14"])


class Refused(SeriesTest):
    def refuse(self, steps, *options, code=USAGE, out="out_{step}.vtu"):
        before = self.files()
        said = finish("simplify", *steps, "-o", self.folder / out, "--reduction", "20%", *options)
        self.assertEqual(said.returncode, code, said.stderr)
        self.assertEqual(self.files(), before)
        return said.stderr.decode(errors="replace")

    def test_names_that_a_list_cannot_hold_and_a_scratch_that_is_none(self):
        steps = self.steps(2)
        self.assertIn("names in UTF-8", self.refuse(steps, out="o\udce9.pvd"))
        (self.folder / "link").symlink_to(self.folder)
        for name in "link", steps[0].name:
            self.assertIn("a file or a link has this name", self.refuse(steps, "--scratch", self.folder / name))

    def test_options_that_are_for_one_mesh(self):
        steps = self.steps(2)
        for options in (["--lods", "10%,20%"], ["--dry-run"], ["--pieces", "2"], ["--progressive", "a.tfp"]):
            for mode in ("shared", "each"):
                self.assertIn("series", self.refuse(steps, "--series", mode, *options))
        for options in (["--resume"], ["--verify"], ["--conserve"]):
            self.assertIn("--series each", self.refuse(steps, *options))
        self.assertIn("cell:id", self.refuse(steps[:1], "--array", "bump_{step}", "--array", "cell:id", out="one.vtu"))
        self.assertIn("none", self.refuse(steps, "--roi", "none>0.5"))
        other = self.write(with_arrays(jittered(10), bump=("Float32", np.array(jittered(10).points)[:, 0])), "other.vtu")
        self.assertIn("drift", self.refuse([*steps, other], "--array", "bump", "--roi", "drift>0.5"))
        self.refuse(steps, "--series", "each", "--map", self.folder / "o.map")
        self.refuse(steps, "--series", "both")

    def test_names(self):
        steps = self.steps(2)
        self.assertIn("{step}", self.refuse(steps, out="out.vtu"))
        self.assertIn("is an input", self.refuse(steps, out="step_{step}.vtu"))
        self.refuse(steps, out="out_{step}.pvtu")
        self.refuse([*steps, "-"])
        self.refuse(steps, out="out_{step}.xyz")
        self.refuse(steps, "--report", steps[1])
        for option in ("--report", "--map"):
            self.assertIn("out_007.vtu", self.refuse(steps, option, self.folder / "out_007.vtu"))
            self.refuse(steps, option, self.folder / "all.pvd", out="all.pvd")
        rows = "".join(f'<DataSet timestep="{i}" file="{p.name}"/>' for i, p in enumerate(steps))
        (self.folder / "a.pvd").write_text(f"<VTKFile type='Collection'><Collection>{rows}</Collection></VTKFile>")
        for option in ("--report", "--map"):
            self.assertIn("step_007.vtu", self.refuse([self.folder / "a.pvd"], option, steps[1]))
        (self.folder / "a.pvd").rename(self.folder / "a.xml")
        self.assertIn("a list of the steps", finish("convert", self.folder / "a.xml", self.folder / "out.vtu").stderr.decode())
        self.refuse(steps, "--map", "-")
        said = self.refuse([steps[0], self.folder / "none.vtu"], "--map", self.folder / "no" / "o.map", code=IO)
        self.assertIn("o.map", said)  # before any work
        self.refuse(steps, "--array", "bump", "--array", "bump:2%")
        self.refuse(steps, out="none/out_{step}.vtu", code=IO)
        (self.folder / "a.pvd").write_text("<VTKFile><Collection/></VTKFile>")
        self.refuse([self.folder / "a.pvd"], code=BAD)
        self.refuse([self.folder / "a.pvd", steps[0]])
        for rows in ('<DataSet timestep="x" file="step_000.vtu"/>', '<DataSet timestep="1"/>',
                     '<DataSet timestep="1" file="../step_000.vtu"/>', f'<DataSet timestep="1" file="{steps[0]}"/>',
                     '<DataSet timestep="1" file="step_000.vtu"/><DataSet timestep="1" file="step_007.vtu"/>'):
            (self.folder / "a.pvd").write_text(f"<VTKFile><Collection>{rows}</Collection></VTKFile>")
            self.refuse([self.folder / "a.pvd"], code=BAD)

    def test_what_can_be_read_only_once(self):
        steps, pipe = self.steps(1), self.folder / "pipe"
        os.mkfifo(pipe)
        for inputs, options, out in (([*steps, pipe], [], "out_{step}.vtu"), ([pipe], [], "out_{step}.vtu"),
                                     ([pipe], ["--array", "bump_{step}"], "out.vtu"),
                                     ([pipe, *steps], ["--series", "each"], "out.pvd")):
            self.assertIn(f"{pipe} can be read only once", self.refuse(inputs, *options, out=out))

    def test_pieces_of_a_step_are_inputs(self):
        steps = []
        for i, whole in enumerate(self.steps(2)):
            steps.append(self.folder / f"s_{i}.pvtu")
            run("simplify", whole, "-o", steps[i], "--pieces", "2", "--reduction", "1%", "--array", "bump", "--quiet")
        for mode in ("shared", "each"):
            for i in (0, 1):
                said = self.refuse(steps, "--series", mode, out=f"s_{{step}}_pieces/s_{i}_0.vtu")
                self.assertIn("is an input of the series", said)
                self.refuse(steps, "--series", mode, "--report", self.folder / f"s_{i}_pieces" / f"s_{i}_0.vtu")

    def test_a_step_that_does_not_go_with_the_others(self):
        first = self.write(wave(jittered(6), 1.0), "s0.vtu")
        other, moved, turned, marked = (wave(jittered(6), 2.0) for _ in range(4))
        other.remove("bump")
        moved.array("Points")[4][3 * 200 + 1] += 0.01
        corners = turned.array("connectivity")[4]
        corners[40:43] = corners[41], corners[42], corners[40]
        marked.arrays.insert(2, ["CellData", "vtkGhostType", "UInt8", 1, [int(i == 10) for i in range(len(marked.tets))]])
        for step, words in ((other, ["bump", "drift"]), (moved, ["point 200 lies at", "--series each"]),
                            (turned, ["cell 10 has the points", "--series each"]),
                            (marked, ["cell 10 is a tetrahedron, and no ghost (vtkGhostType), in one of them alone"]),
                            (wave(jittered(5), 2.0), ["points, not", "--series each"])):
            for threads in ("1", "2"):
                said = self.refuse([first, self.write(step, "s1.vtu")], "--threads", threads, code=BAD)
                for word in [*words, "s1.vtu"]:
                    self.assertIn(word, said)
        said = self.refuse([first, self.folder / "s2.vtu"], code=IO)
        self.assertIn("s2.vtu", said)

    def test_a_folder_that_is_not_ours(self):
        steps = self.steps(2)
        (self.folder / "work").mkdir()
        self.write(b"mine", "work/notes")
        self.refuse(steps, "--scratch", self.folder / "work")
        self.assertEqual((self.folder / "work/notes").read_bytes(), b"mine")

    def test_what_a_killed_process_left_is_in_nobodys_way(self):
        steps = self.steps(2)
        work = self.folder / "out_{step}.vtu.tetfusion"
        (work / "tetfusion-series.chunks").mkdir(parents=True)
        (work / "tetfusion-series.chunks/manifest").write_bytes(b"x")
        (work / ".tetfusion-4711-0.part").write_bytes(b"x")  # the mesh, in the moment in which it got its name
        self.simplify(steps, *GOAL)
        self.assertFalse(work.exists())
        # On network file systems a name may stay that nobody can remove.
        left = work / ".nfs000000000001e24000000001"
        work.mkdir()
        left.write_bytes(b"x")
        self.simplify(steps, *GOAL)
        self.assertEqual(list(work.iterdir()), [left])

    def test_a_full_disk(self):
        steps = self.steps(3)
        self.simplify(steps, *GOAL)
        size = self.outputs()[0].stat().st_size
        old = self.outputs()[2].read_bytes()
        # The limit is for each file: outputs grow with their step's own array.
        mesh = jittered(10)
        big = wave(mesh, 4.0)
        big = with_arrays(big, bump=("Float32", big.array("bump")[4]),
                          more=("Float64", np.zeros((len(mesh.points), 60))))
        self.write(big, steps[2].name)
        self.outputs()[0].unlink()
        result = finish("simplify", *steps, "-o", self.folder / "out_{step}.vtu", *GOAL, "--map", self.folder / "out.map",
                        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (3 * size, 3 * size)))
        self.assertEqual(result.returncode, IO, result.stderr)
        self.assertIn(b"steps written: 2 of 3", result.stderr)
        self.assertEqual(len(self.outputs()), 3)
        self.assertEqual(self.outputs()[2].read_bytes(), old)
        self.assertEqual([n for n in self.files() if "tetfusion" in n or n == "out.map"], [])

    def test_an_interruption_leaves_nothing(self):
        steps = [self.generate("--jitter", "0.5", "--time", str(t), tets="200k", name=f"s{t}.vtu") for t in range(4)]
        before = self.files()
        said = self.stop_when("*.tetfusion/*", "simplify", *steps, "-o", self.folder / "out_{step}.vtu", "--array", "front",
                              "--memory", "200M", "--chunk-tets", "10k", *GOAL)
        self.assertNotIn("--resume", said)
        self.assertEqual(self.files(), before)


if __name__ == "__main__":
    main()
