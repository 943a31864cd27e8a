#!/usr/bin/env python3
"""refine --max-error, --max-rms and --roi. Usage: refine_goals_test.py TETFUSION"""
import numpy as np

from harness import USAGE, FolderTest, finish, main, report_of, run
from independent_check import Vtu
from roi_test import BOX, SPHERE, in_box, in_sphere
from tiny_vtu import TinyVtu


def is_below(mesh):
    return mesh.arrays["point"]["front"][-1].ravel() < 0.9


def cells_of(mesh, which=slice(None)):
    """Corners by their coordinates, with the values there, in an order of their own."""
    rows = np.hstack([mesh.points, mesh.arrays["point"]["temperature"][-1].reshape(len(mesh.points), -1)])
    return {tuple(sorted(map(tuple, cell))) for cell in rows[mesh.tets[which]].tolist()}


class Goals(FolderTest):
    def simplify(self, path, *options):
        back = self.folder / "run.tfp"
        run("simplify", path, "-o", self.folder / "out.vtu", "--progressive", back, "--quiet", *options)
        return back

    def refine(self, back, *options):
        """The report, and the level, which is valid."""
        level = self.folder / "level.vtu"
        report = report_of("refine", back, "-o", level, *options)
        run("check", level, "--strict", "--quiet")
        return report, Vtu(level)

    def test_errors_at_points(self):
        path = self.generate("--jitter", "0.5", tets="30k")
        back = self.simplify(path, "--array", "temperature", "--array", "velocity", "--reduction", "90%", "--max-error", "100%", "--chunk-tets",
                             "6k")
        full = report_of("refine", back, "-o", self.folder / "level.vtu")
        before = full["base"]["tets"] - 1
        self.assertEqual(full["error"], {"kind": "max", "value": 0})
        for limit in (0.3, 0.1, 0.03, 0.01, 0.003, 0):
            report, level = self.refine(back, "--max-error", limit)
            found = {a["name"]: a["max"] for a in report_of("compare", path, self.folder / "level.vtu")["arrays"]}
            error = report["error"]["value"]
            self.assertLessEqual(error, limit)
            self.assertLessEqual(max(found["temperature"], found["velocity"]), error)
            self.assertGreaterEqual(max(found["temperature"], found["velocity"]), 0.3 * error)
            self.assertEqual(len(level.tets), report["result"]["tets"])
            self.assertGreaterEqual(len(level.tets), before)
            before = len(level.tets)
            if error == 0:
                continue
            # The next coarser level is not within the bound.
            coarser = report_of("refine", back, "-o", self.folder / "coarser.vtu", "--tets", len(level.tets) - 1)
            if report["undone"] > 0:
                self.assertGreater(coarser["error"]["value"], limit)
        self.assertEqual(before, full["original"]["tets"])

    def test_estimates(self):
        path = self.generate("--jitter", "0.5", tets="30k")
        back = self.simplify(path, "--reduction", "90%", "--chunk-tets", "6k")
        errors = []
        for limit in ("5%", "1%", "0.5%", "0.1%"):
            report, _ = self.refine(back, "--max-rms", limit)
            self.assertEqual(report["error"]["kind"], "rms")
            self.assertLessEqual(report["error"]["value"], float(limit[:-1]) / 100)
            found = report_of("compare", path, self.folder / "level.vtu")["arrays"][0]
            self.assertLess(found["rms"], float(limit[:-1]) / 100)
            errors.append(found["rms"])
        self.assertEqual(errors, sorted(errors, reverse=True))
        self.assertGreater(errors[0], 2 * errors[-1])

    def test_points_that_no_cell_uses_have_no_say_in_ranges(self):
        tiny = TinyVtu(n=8)
        tiny.points.append((20.0, 20.0, 20.0))
        tiny.counts["NumberOfPoints"] = str(len(tiny.points))
        tiny.array("Points")[-1] += tiny.points[-1]
        tiny.array("temperature")[-1] = [np.sin(p[0] / 2) * np.cos(p[1] / 3) + p[2] ** 2 / 50 for p in tiny.points[:-1]] + [100.0]
        path = self.write(tiny)
        back = self.simplify(path, "--reduction", "80%", "--max-error", "100%")
        report, _ = self.refine(back, "--max-error", "2%")
        run("compare", path, self.folder / "level.vtu", "--max-error", "2%", "--quiet")
        self.assertGreater(report["undone"], 0)
        self.assertLess(report["undone"], report["fusions"])

    def test_what_touches_a_region_is_the_original(self):
        path = self.generate("--jitter", "0.5", "--double", tets="40k")
        original = Vtu(path)
        for options in (["--reduction", "90%"], ["--reduction", "90%", "--boundary", "1%"], ["--method", "tetfuse"]):
            back = self.simplify(path, *options, "--chunk-tets", "9k")
            base = Vtu(self.folder / "out.vtu")
            for inside, text in ((in_box, BOX), (in_sphere, SPHERE), (is_below, "front<0.9")):
                report, level = self.refine(back, "--roi", text)
                expected = inside(original)
                self.assertEqual(report["region"]["points"], expected.sum())
                self.assertEqual(report["region"]["needed"], report["undone"])
                self.assertGreater(expected.sum(), 20, text)
                near = cells_of(original, expected[original.tets].any(axis=1))
                cells = cells_of(level)
                self.assertLessEqual(near, cells)
                self.assertLess(len(cells), 0.9 * len(original.tets), text)
                self.assertGreater(len(cells_of(base) & cells), 0.1 * len(base.tets), text)

    def test_the_rest_is_that_of_the_base(self):
        """Far from the region nothing changes: each tetrahedron of the base is there with its corners."""
        path = self.generate("--jitter", "0.5", "--double", tets="40k")
        back = self.simplify(path, "--reduction", "90%", "--chunk-tets", "9k")
        base = Vtu(self.folder / "out.vtu")
        _, level = self.refine(back, "--roi", "box=0,0.1,0,0.1,0,0.1")
        far = (base.points[base.tets] > 0.6).any(axis=2).all(axis=1)
        self.assertGreater(far.sum(), 1000)
        missing = cells_of(base, far) - cells_of(level)
        self.assertLess(len(missing), 0.15 * far.sum())

    def test_regions_and_goals(self):
        path = self.generate("--jitter", "0.5", tets="40k")
        back = self.simplify(path, "--reduction", "90%", "--max-error", "100%", "--chunk-tets", "9k")
        whole, _ = self.refine(back, "--roi", BOX)
        base, full = whole["base"]["tets"], whole["result"]["tets"]
        self.assertEqual(whole["region"]["error"], 0)
        goal = (base + full) // 2
        part, _ = self.refine(back, "--roi", BOX, "--tets", goal)
        self.assertTrue(goal - 40 < part["result"]["tets"] <= goal)
        self.assertLess(part["undone"], whole["undone"])
        self.assertGreater(part["region"]["error"], 0)
        share, _ = self.refine(back, "--roi", BOX, "--reduction", "60%")
        self.assertLessEqual(share["result"]["tets"], 0.4 * whole["original"]["tets"] + 1)
        within, _ = self.refine(back, "--roi", BOX, "--max-error", "0.5%")
        self.assertLessEqual(within["region"]["error"], 0.005)
        self.assertGreater(within["error"]["value"], 0.005)
        self.assertTrue(base < within["result"]["tets"] < full)

    def test_everything_and_nothing(self):
        path = self.generate("--jitter", "0.5", tets="10k")
        back = self.simplify(path, "--reduction", "80%")
        self.refine(back, "--roi", "box=0,1,0,1,0,1")
        self.assertEqual((self.folder / "level.vtu").read_bytes(), path.read_bytes())
        said = finish("refine", back, "-o", self.folder / "level.vtu", "--roi", "sphere=9,9,9,1").stderr.decode()
        self.assertIn("no point of the original is inside", said)
        report, level = self.refine(back, "--roi", "sphere=9,9,9,1")
        self.assertEqual(report["undone"], 0)
        self.assertEqual(len(level.tets), report["base"]["tets"])
        self.refine(back, "--roi", BOX, "--roi", SPHERE)

    def test_what_cannot_be_said(self):
        path = self.generate(tets="5k")
        back = self.simplify(path, "--reduction", "50%")
        level = self.folder / "level.vtu"

        def refuses(words, *options):
            said = finish("refine", back, "-o", level, *options)
            self.assertEqual(said.returncode, USAGE, options)
            self.assertIn(words, said.stderr.decode())
            self.assertFalse(level.exists())

        refuses("did not measure errors at points", "--max-error", "1%")
        refuses("--tets and --max-rms are 2 goals", "--max-rms", "1%", "--tets", "10k")
        refuses("--max-rms much", "--max-rms", "much")
        refuses("at least 0%", "--max-rms", "-1%")
        refuses("--max-rms 5: that is 500 %", "--max-rms", "5")
        refuses("--max-error 1: give 100% or 1%", "--max-error", "1")
        refuses("a sphere has a centre", "--roi", "sphere=1,2")
        refuses('no point array "nothing"; it has', "--roi", "nothing>1")
        back = self.simplify(path, "--method", "tetfuse", "--reduction", "30%")
        refuses("knew of no errors", "--max-rms", "1%")
        refuses("knew of no errors", "--max-error", "1%")
        back = self.simplify(path, "--reduction", "50%", "--max-error", "100%")
        refuses("measured errors at points: give --max-error", "--max-rms", "1%")


if __name__ == "__main__":
    main()
