#!/usr/bin/env python3
"""How series run: memory, threads, each step by itself. Usage: series_runs_test.py TETFUSION"""
import itertools

import numpy as np

from follow_test import jittered, with_arrays
from harness import USAGE, finish, least_memory, main, run, sanitized, size_of
from independent_check import Vtu
from series_test import GOAL, SeriesTest, wave

class Shared(SeriesTest):
    def test_same_bytes_for_any_threads_and_memory(self):
        steps = [self.generate("--jitter", "0.5", "--time", str(t), tets="60k", name=f"s{t}.vtu") for t in range(3)]
        options = ["--max-error", "3%", "--array", "front", "--chunk-tets", "8k"]
        self.simplify(steps, *options, "--threads", "1")
        first = [p.read_bytes() for p in self.outputs()]
        for threads, on_disk in itertools.product("12", (True, False)):
            memory = self.least_memory(steps, *options, "--threads", threads) if on_disk else "2G"
            report = self.simplify(steps, *options, "--threads", threads, "--memory", memory)
            self.assertEqual(report["scratch_bytes"] > 0, on_disk)
            self.assertEqual([p.read_bytes() for p in self.outputs()], first)

    def test_memory_does_not_grow_with_the_number_of_steps(self):
        steps = [self.generate("--jitter", "0.5", "--time", str(t / 4), tets="200k", name=f"s{t:02d}.vtu") for t in range(20)]
        options = [*GOAL, "--array", "front", "--chunk-tets", "10k", "--threads", "1"]
        memory = self.least_memory(steps, *options)
        reports = [self.simplify(steps[:n], *options, "--memory", memory, out=f"{n}_{{step}}.vtu") for n in (8, 20)]
        self.assertGreater(reports[0]["scratch_bytes"], 0)
        if not sanitized():
            peaks = [r["peak_rss_bytes"] for r in reports]
            self.assertLess(peaks[1], peaks[0] + (6 << 20))
            self.assertLess(max(peaks), size_of(memory))

    def test_what_is_said_to_be_enough_memory_is_for_wide_arrays_too(self):
        steps = []
        for i in range(2):
            mesh = jittered(16)
            many = {f"a{k}": ("Float64", np.full((len(mesh.points), 9), float(i))) for k in range(30)}
            steps.append(self.write(with_arrays(wave(mesh, float(i)), **many), f"s{i}.vtu"))
        options = ["--reduction", "10%", "--chunk-tets", "1000", "--threads", "1"]
        self.simplify(steps, *options, "--memory", self.least_memory(steps, *options))

    def test_arrays_that_only_later_steps_have_are_counted(self):
        steps = []
        for i in range(2):
            mesh = wave(jittered(24), float(i))
            if i > 0:
                mesh.arrays.insert(2, ["CellData", "wide", "Float64", 40, [0.1] * (40 * len(mesh.tets))])
            steps.append(self.write(mesh, f"s{i}.vtu"))
        options = ["--reduction", "10%", "--chunk-tets", "5000", "--threads", "2"]
        memory = self.least_memory(steps, *options)
        report = self.simplify(steps, *options, "--memory", memory)
        if not sanitized():
            self.assertLess(report["peak_rss_bytes"], size_of(memory))


class Each(SeriesTest):
    def test_every_step_by_itself(self):
        steps = self.steps(3)
        report = self.simplify(steps, "--max-error", "3%", "--series", "each", "--verify")
        self.assertEqual(report["series"], "each")
        self.assertLess(sum(s["run"]["cpu_seconds"] for s in report["steps"]), report["cpu_seconds"] + 1e-3)
        self.assertGreater(report["peak_rss_bytes"], 1 << 20)
        self.assertGreater(report["threads"], 0)
        for step, entry, path in zip(steps, report["steps"], self.outputs(), strict=True):
            alone = self.folder / "alone.vtu"
            run("simplify", step, "-o", alone, "--max-error", "3%", "--quiet")
            self.assertEqual(path.read_bytes(), alone.read_bytes())
            self.assertEqual(entry["run"]["output"]["tets"], len(Vtu(path).tets))

    def test_an_interrupted_step_is_gone_on_with(self):
        steps = [self.generate("--jitter", "0.5", "--time", str(t), tets="200k", name=f"s{t}.vtu") for t in range(2)]
        options = ["--series", "each", "--array", "front", "--reduction", "70%", "--chunk-tets", "10k", "--threads", "1",
                   "--memory", "73M", "--scratch", self.folder / "work", "--quiet"]
        run("simplify", *steps, "-o", self.folder / "whole_{step}.vtu", *options)
        arguments = ["simplify", *steps, "-o", self.folder / "out_{step}.vtu", *options]
        said = self.stop_when("work-1/round-*.state", *arguments)
        self.assertIn("--resume", said)
        self.assertIn("steps written: 1 of 2", said)
        run(*arguments, "--resume")
        self.assertEqual([p.read_bytes() for p in self.outputs()], [p.read_bytes() for p in self.outputs("whole_*.vtu")])
        self.assertFalse([n for n in self.files() if n.startswith("work")])

    def test_a_step_that_is_the_same_everywhere_ends_no_series(self):
        """It goes as far as it can, as with --array; but what has no array at all is refused."""
        steps = self.steps(2, make=lambda mesh, time: with_arrays(mesh, f=("Float32", np.array(mesh.points)[:, 0] ** 2 * time)))
        report = self.simplify(steps, "--series", "each")
        self.assertEqual([s["run"]["steering"] for s in report["steps"]], [[], ["f"]])
        named = self.folder / "named.vtu"
        run("simplify", steps[0], "-o", named, "--array", "f", "--quiet")
        self.assertEqual(self.outputs()[0].read_bytes(), named.read_bytes())
        bare = jittered(4)
        bare.remove("temperature")
        said = finish("simplify", self.write(bare, "a0.vtu"), self.write(bare, "a1.vtu"), "-o", self.folder / "b_{step}.vtu", "--series", "each")
        self.assertEqual(said.returncode, USAGE)
        self.assertIn(b"give --reduction or --tets; steps written: 0 of 2", said.stderr)

    def test_meshes_may_differ(self):
        steps = [self.write(wave(jittered(4 + i), 1.0), f"s{i}.vtu") for i in range(2)]
        self.simplify(steps, *GOAL, "--series", "each")
        self.assertEqual(len(self.outputs()), 2)


if __name__ == "__main__":
    main()
