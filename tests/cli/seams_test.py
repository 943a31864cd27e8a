#!/usr/bin/env python3
"""Points that are joined and had different values: what the commands say of them. Usage: seams_test.py TETFUSION"""
import json
import re

from harness import FolderTest, finish, least_memory, main, report_of, run
from tiny_vtu import TinyVtu

JOINED = "points in the places of others were merged with them"
OTHERS = "of these had other values in some array"
BOUNDS = "bounds are for the values that were taken"


def half(n, side, jump=0.0, ids=None, **keywords):
    """The cells on one side of a cube's middle plane, whose temperatures are larger by `jump` on the second."""
    mesh = TinyVtu(n, **keywords)
    chosen = [t for t in mesh.tets if (sum(mesh.points[v][0] for v in t) / 4 > n / 2) == side]
    old = sorted({v for t in chosen for v in t})
    number = {v: i for i, v in enumerate(old)}
    points = [mesh.points[v] for v in old]
    mesh.array("Points")[4] = [c for p in points for c in p]
    mesh.array("temperature")[4] = [p[0] + 2 * p[1] + (jump if side else 0) for p in points]
    mesh.array("id")[4] = [int(side)] * len(chosen)
    mesh.array("connectivity")[4] = [number[v] for t in chosen for v in t]
    mesh.array("offsets")[4] = list(range(4, 4 * len(chosen) + 1, 4))
    mesh.array("types")[4] = [10] * len(chosen)
    mesh.counts = {"NumberOfPoints": str(len(points)), "NumberOfCells": str(len(chosen))}
    if ids:
        mesh.arrays.insert(0, ["PointData", "GlobalNodeIds", "Int64", 1, [ids(v, side) for v in old]])
    return mesh


def with_a_value_for_each_cell(n):
    """Cells with points of their own, whose values jump from cell to cell, as those of discontinuous elements do."""
    mesh = TinyVtu(n)
    corners = mesh.array("connectivity")[4]
    mesh.array("Points")[4] = [c for v in corners for c in mesh.points[v]]
    mesh.array("temperature")[4] = [i // 4 for i in range(len(corners))]
    mesh.array("connectivity")[4] = list(range(len(corners)))
    mesh.counts["NumberOfPoints"] = str(len(corners))
    return mesh


class Seams(FolderTest):
    def both(self, n=4, **keywords):
        """The two halves as pieces of one file, and as two files."""
        halves = [half(n, side, encoding="ascii", **keywords).bytes().decode() for side in (False, True)]
        pieces = [re.search("<Piece .*</Piece>", text, re.DOTALL)[0] for text in halves]
        one = self.write(halves[0].replace(pieces[0], "".join(pieces)).encode(), "one.vtu")
        for side in (False, True):
            self.write(half(n, side, **keywords), f"part{int(side)}.vtu")
        many = self.write(b"""<?xml version="1.0"?><VTKFile type="PUnstructuredGrid" version="1.0"><PUnstructuredGrid>
<Piece Source="part0.vtu"/><Piece Source="part1.vtu"/></PUnstructuredGrid></VTKFile>""", "many.pvtu")
        return one, many

    def counts(self, report):
        return [report[key] for key in ("merged_points", "differing_points", "largest_difference")]

    def test_a_fault_between_pieces(self):
        out = self.folder / "out.vtu"
        for path in self.both(jump=-8.0):
            # On the one side from 0 to 10, on the other from -6 to 4.
            expected = [25, 25, {"array": "temperature", "share": 8 / 16}]
            for threads in ("1", "2"):
                for command in ("info", "check"):
                    self.assertEqual(self.counts(report_of(command, path, "--threads", threads)), expected)
            most = "by up to 50 % of the range of array temperature"
            sentence = f"25 {OTHERS}, {most}: those of the first one that has it were taken"
            for command in ("info", "check"):
                self.assertIn(most, run(command, path).decode())
            for name in ("out.vtu", "out.msh"):
                told = finish("convert", path, self.folder / name).stderr.decode()
                self.assertIn(f"25 {JOINED}", told)
                self.assertIn(sentence, told)
            for options, bounded in (([], True), (["--max-error", "1%"], True), (["--reduction", "30%"], False),
                                     (["--method", "tetfuse"], True), (["--max-rms", "1%", "--pieces", "2"], True)):
                report = self.folder / "report.json"
                result = out.with_suffix(".pvtu") if "--pieces" in options else out
                told = finish("simplify", path, "-o", result, "--report", report, "--verify", *options).stderr.decode()
                self.assertIn(sentence, told)
                self.assertEqual(BOUNDS in told, bounded, options)
                self.assertEqual(self.counts(json.loads(report.read_text())["odd"]), expected)
            told = finish("compare", path, out).stderr.decode()
            self.assertIn(sentence, told)
            self.assertEqual(report_of("compare", path, out)["differing_points"], 25)
            self.assertNotIn(OTHERS, finish("compare", out, path).stderr.decode())  # of the original alone

    def test_the_same_values_say_nothing(self):
        for path in self.both():
            self.assertEqual(self.counts(report_of("info", path)), [25, 0, None])
            told = finish("simplify", path, "-o", self.folder / "out.vtu", "--max-error", "1%").stderr.decode()
            self.assertIn(JOINED, told)
            self.assertNotIn(OTHERS, told)
            self.assertNotIn(BOUNDS, told)

    def test_global_ids_say_what_is_joined(self):
        for path in self.both(jump=-8.0, ids=lambda v, side: v):
            self.assertEqual(self.counts(report_of("info", path))[:2], [25, 25])
        for path in self.both(jump=-8.0, ids=lambda v, side: v + 1000 * side):  # the sides of a fault
            self.assertEqual(self.counts(report_of("info", path)), [0, 0, None])
            told = finish("simplify", path, "-o", self.folder / "out.vtu").stderr.decode()
            self.assertNotIn(JOINED, told)
            self.assertNotIn(OTHERS, told)

    def test_merged_points_of_one_piece(self):
        path = self.write(with_a_value_for_each_cell(2))
        report = report_of("info", path, "--merge-points")
        self.assertEqual(self.counts(report)[:2], [4 * 48 - 27, report["differing_points"]])
        self.assertGreater(report["differing_points"], 4 * 48 - 27 - 48)
        for name in ("out.vtu", "out.msh"):
            told = finish("convert", path, self.folder / name, "--merge-points").stderr.decode()
            self.assertIn(f"165 {JOINED}", told)
            self.assertIn(f"{report['differing_points']} {OTHERS}", told)
        told = finish("simplify", path, "-o", self.folder / "out.vtu", "--merge-points").stderr.decode()
        self.assertIn(f"{report['differing_points']} {OTHERS}", told)
        self.assertIn(BOUNDS, told)
        self.assertEqual(self.counts(report_of("info", path)), [0, 0, None])

    def test_steps_of_a_series(self):
        def series(name, *jumps):
            return [self.both(jump=jump)[0].rename(self.folder / f"{name}_{step}.vtu") for step, jump in enumerate(jumps)]

        out = self.folder / "out_{step}.vtu"
        told = finish("simplify", *series("later", 0.0, -8.0, 0.0), "-o", out, "--max-error", "1%").stderr.decode()
        self.assertIn(f"25 {JOINED}", told)
        self.assertNotIn(OTHERS, told)  # of the first step
        self.assertIn("step 1: 25 points that were joined with others had other values in some array, by up to 50 % of the "
                      "range of array temperature: those of the first one that has it were taken", told)
        self.assertEqual(told.count(BOUNDS), 1)
        told = finish("simplify", *series("first", -8.0, 0.0), "-o", out, "--max-error", "1%").stderr.decode()
        self.assertIn(f"25 {OTHERS}, by up to 50 % of the range", told)
        self.assertEqual(told.count("other values"), 1)
        self.assertEqual(told.count(BOUNDS), 1)

    def test_steps_that_are_compared_are_named(self):
        for step, jump in enumerate((0.0, -8.0)):
            self.both(jump=jump)[0].rename(self.folder / f"run_{step}.vtu")
        steps = self.folder / "run.pvd"
        steps.write_text('<VTKFile type="Collection"><Collection>' + "".join(
            f'<DataSet timestep="{step}" file="run_{step}.vtu"/>' for step in range(2)) + "</Collection></VTKFile>")
        told = finish("compare", steps, steps).stderr.decode()
        self.assertEqual(told.count(OTHERS), 1)
        self.assertIn(f"run_1.vtu: 25 {OTHERS}", told)

    def test_out_of_core_is_the_same(self):
        for path in self.both(n=12, jump=3.0, ids=lambda v, side: v):
            counts = self.counts(report_of("info", path))
            self.assertEqual(counts[:2], [169, 169])
            self.assertEqual(self.counts(report_of("info", path, "--memory", least_memory("info", path))), counts)
            report = self.folder / "report.json"
            for threads in ("1", "2"):
                run("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "50%", "--report", report, "--chunk-tets", "2k",
                    "--threads", threads)
                self.assertEqual(self.counts(json.loads(report.read_text())["odd"]), counts)


if __name__ == "__main__":
    main()
