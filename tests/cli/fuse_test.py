#!/usr/bin/env python3
"""simplify --method fuse, from file to file. Usage: fuse_test.py TETFUSION"""
import collections
import itertools
import math

import numpy as np
from follow_test import jittered, with_arrays
from harness import INVALID, USAGE, FolderTest, finish, least_memory, main, report_of, run, sanitized, size_of
from independent_check import Vtu, judge_pair, load
from sample_meshes import rebuilt
from tiny_vtu import TinyVtu


class Fuse(FolderTest):
    def fuse(self, path, *options):
        out = self.folder / "out.vtu"
        return out, report_of("simplify", path, "-o", out, "--method", "fuse", "--quiet", *options)

    def compare(self, path, out):
        """The report of compare, on a mesh that is as valid as the original and has its surface: by its own judgement, by
        that of check, and by that of a checker which shares no code with them."""
        report_of("check", out, "--strict")
        _, failures = judge_pair(load(path, "original"), load(out, "simplified"), False)
        self.assertEqual(failures, [])
        report = report_of("compare", path, out, "--surface", "0")
        self.assertEqual(report["outside_points"], 0)
        self.assertIs(report["surface"]["identical"], True)
        return report

    def test_towards_a_goal(self):
        path = self.generate("--jitter", "0.5", tets="120k")
        for reduction, options in ((0.8, []), (0.9, []), (0.8, ["--chunk-tets", "15k", "--threads", "2"])):
            out, report = self.fuse(path, "--regions", "none", "--reduction", reduction, *options)
            self.assertEqual(report["stop_reason"], "goal")
            goal = report["input"]["tets"] * (1 - reduction)
            self.assertGreaterEqual(report["output"]["tets"], goal - 1e-6)
            self.assertLess(report["output"]["tets"], goal + 12)
            self.assertEqual(report["output"]["tets"], len(Vtu(out).tets))
            self.assertEqual(report["output"]["boundary_triangles"], report["input"]["boundary_triangles"])
            self.compare(path, out)

    def test_a_goal_that_nothing_leads_to_is_not_reached(self):
        path = self.write(TinyVtu(1))  # all of its vertices lie on the boundary
        count = len(Vtu(path).tets)
        for tets in count - 1, count - 2, count - 3:
            report = report_of("simplify", path, "-o", self.folder / "out.vtu", "--tets", tets, "--strict", "--quiet", code=6)
            self.assertEqual((report["stop_reason"], report["output"]["tets"]), ("saturated", count))
        self.assertEqual(self.fuse(path, "--tets", count, "--strict")[1]["stop_reason"], "goal")
        # With inner vertices, and none whose tetrahedra are so few.
        path = self.generate("--jitter", "0.5", tets="2k")
        count = len(Vtu(path).tets)
        self.assertEqual(self.fuse(path, "--tets", count - 1, "--strict")[1]["stop_reason"], "goal")

    def test_as_far_as_the_error_allows(self):
        path = self.generate("--jitter", "0.5", tets="40k")
        left = []
        for rms in ("0.01%", "0.1%"):
            out, report = self.fuse(path, "--max-rms", rms)
            self.assertEqual(report["stop_reason"], "saturated")
            self.assertGreater(report["lods"][-1]["rejected"]["error"], 0)
            left.append(report["output"]["tets"])
            steering = [a for a in self.compare(path, out)["arrays"] if a["name"] == report["steering"][0]]
            self.assertLess(steering[0]["rms"], float(rms[:-1]) / 100)
        self.assertLess(left[1], left[0])
        # It goes before the goal.
        _, report = self.fuse(path, "--max-rms", "0.01%", "--reduction", "99%")
        self.assertEqual((report["stop_reason"], report["output"]["tets"]), ("saturated", left[0]))

    def test_infinities_change_no_other_values(self):
        mesh = TinyVtu(12)
        values = [p[0] for p in mesh.points]
        values[::37] = [math.inf if i % 2 else -math.inf for i in range(len(values[::37]))]
        mesh.array("temperature")[4] = values
        out, report = self.fuse(self.write(mesh), "--reduction", "40%")
        self.assertEqual(report["stop_reason"], "goal")
        result = Vtu(out)
        after, x = result.arrays["point"]["temperature"][-1].ravel(), result.points[:, 0]
        self.assertEqual(int(np.isinf(after).sum()), len(values[::37]))
        self.assertLess(float(np.abs(after - x)[np.isfinite(after)].max()), 1e-4)

    def test_bounds_without_a_field_are_told_of(self):
        tiny = TinyVtu()
        tiny.remove("temperature")
        mesh = self.write(tiny)
        results = set()
        for limits, said in (([], b"geometry alone decides\n"), (["--max-error", "1%"], b"decides, and no error is limited\n"),
                             (["--max-rms", "0.1%"], b"decides, and no error is limited\n")):
            result = finish("simplify", mesh, "-o", self.folder / "out.vtu", "--reduction", "50%", *limits)
            self.assertEqual(result.returncode, 0)
            self.assertIn(said, result.stderr)
            results.add((self.folder / "out.vtu").read_bytes())
        self.assertEqual(len(results), 1)
        tiny.array("id")[1:3] = "heat", "Float32"
        said = finish("simplify", self.write(tiny), "-o", self.folder / "out.vtu", "--reduction", "50%").stderr
        self.assertIn(b"no array steers (--array NAME makes one: cell:heat): geometry alone decides\n", said)
        said = finish("simplify", self.write(tiny), "-o", self.folder / "out.vtu").stderr
        self.assertIn(b"give --reduction or --tets (--array NAME makes one: cell:heat)\n", said)

    def test_a_field_that_is_the_same_everywhere(self):
        """Any bound holds for it. Where the user has named it the run goes as far as it can; else another one steers, or
        nobody has said how far."""
        mesh = TinyVtu(6)
        mesh.array("temperature")[4] = [3.5] * len(mesh.points)
        mesh.arrays.insert(1, ["PointData", "flow", "Float32", 1, [p[0] for p in mesh.points]])
        path, out = self.write(mesh), self.folder / "out.vtu"
        said = finish("simplify", path, "-o", out)
        self.assertEqual(said.returncode, 0)
        self.assertIn(b"array temperature has no two finite values that differ (as doubles): it does not steer\n", said.stderr)
        self.assertIn(b"array flow steers (choose others with --array)\n", said.stderr)
        self.assertNotIn(b"whose errors nothing limits: flow", said.stderr)
        run("compare", path, out, "--max-error", "1%", "--array", "flow")
        for number, flow in enumerate(([math.nan] * len(mesh.points), [-1.0, *[math.inf] * (len(mesh.points) - 1)])):
            mesh.array("flow")[4] = flow
            said = finish("simplify", self.write(mesh, "uniform.vtu"), "-o", out)
            self.assertEqual(said.returncode, USAGE, number)
            self.assertIn(b"array flow has no two finite values that differ (as doubles): it does not steer\n", said.stderr)
            self.assertIn(b"give --reduction or --tets, or --array temperature, which is the same everywhere, to go as far as "
                          b"shapes allow\n", said.stderr)
        for value in (3.5, 0.0, -1e30):
            mesh.array("temperature")[4] = [math.nan if i % 41 == 7 else value for i in range(len(mesh.points))]
            gaps = self.write(mesh, "gaps.vtu")
            names = ["--array", "temperature"]
            run("simplify", gaps, "-o", out, *names, "--max-error", "1%", "--verify")
            self.assertLess(len(Vtu(out).tets), len(Vtu(gaps).tets))
            run("compare", gaps, out, "--max-error", "1%", *names)
        said = finish("simplify", path, "-o", out, "--array", "temperature", "--max-error", "1%")
        self.assertEqual(said.returncode, 0)
        self.assertIn(b"no array steers (--array NAME makes one: flow): geometry alone decides, as far as it can\n", said.stderr)
        for bound in ([], ["--max-rms", "0.1%"]):
            out, report = self.fuse(path, "--array", "temperature", *bound)
            self.assertEqual((report["stop_reason"], report["steering"]), ("saturated", []))
            self.assertLess(report["output"]["tets"], report["input"]["tets"])
            self.compare(path, out)

    def test_all_arrays_may_steer(self):
        path, out = self.generate("--jitter", "0.3", tets="20k"), self.folder / "out.vtu"
        bound = ["--max-error", "2%"]
        run("simplify", path, "-o", out, *bound)
        run("compare", path, out, *bound, code=INVALID)
        for names in (["all", *bound], ["all:2%"], ["front:1%", "--array", "all:2%"]):
            report = report_of("simplify", path, "-o", out, "--array", *names)
            self.assertEqual(sorted(report["steering"]), ["front", "temperature", "velocity"])
            self.assertGreater(report["reduction"], 0.1)
            run("compare", path, out, *bound)
        run("compare", path, out, "--max-error", "1%", "--array", "front")
        self.assertIn(b"--array all:0: the tolerance", finish("simplify", path, "-o", out, "--array", "all:0").stderr)
        # A name comes first.
        mesh = TinyVtu(4)
        mesh.array("temperature")[1] = "all"
        mesh.arrays.insert(1, ["PointData", "flow", "Float32", 1, [p[0] for p in mesh.points]])
        self.assertEqual(report_of("simplify", self.write(mesh), "-o", out, "--array", "all")["steering"], ["all"])
        mesh.arrays = [a for a in mesh.arrays if a[0] != "PointData"]
        self.assertIn(b"--array all: the points have no floating-point array", finish("simplify", self.write(mesh), "-o", out, "--array", "all").stderr)

    def test_labels_of_what_lies_beside_tetrahedra_say_no_regions(self):
        """A boundary triangle with another label makes no interface."""
        mesh = TinyVtu(3)
        tets = len(mesh.tets)
        mesh.array("connectivity")[4] = mesh.array("connectivity")[4] + [0, 1, 5]
        mesh.array("offsets")[4] = mesh.array("offsets")[4] + [4 * tets + 3]
        mesh.array("types")[4] = [10] * tets + [5]
        mesh.counts["NumberOfCells"] = str(tets + 1)
        for label in ("material", "lab"):
            mesh.array(mesh.arrays[1][1])[1:] = label, "Int32", 1, [0] * tets + [5]
            said = finish("simplify", self.write(mesh), "-o", self.folder / "out.vtu", "--reduction", "10%").stderr
            self.assertNotIn(b"interfaces", said)
            mesh.array(label)[4] = [0] * (tets - 1) + [5, 5]
            said = finish("simplify", self.write(mesh), "-o", self.folder / "out.vtu", "--reduction", "10%").stderr
            self.assertIn(b"interfaces", said)

    def test_labels_may_be_as_large_as_their_type_allows(self):
        mesh = TinyVtu()
        mesh.array("id")[1:] = "lab", "UInt64", 1, [2**64 - 1 - i % 2 for i in range(len(mesh.tets))]
        result = finish("simplify", self.write(mesh), "-o", self.folder / "out.vtu", "--reduction", "10%")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(b"cell array lab may be regions, too", result.stderr)

    def test_a_linear_array_stays_linear_beside_another(self):
        """Where a bound holds, points are moved and fitted for the sake of the other one, too."""
        linear = np.array([0.3, -0.2, 0.5])
        for seed in range(6):
            mesh = jittered(9, seed)
            points = np.array(mesh.points)
            mesh = with_arrays(mesh, s=("Float64", np.sin(0.8 * points[:, 0]) + points[:, 1]**2 / 81),
                               lin=("Float64", points @ linear + 1))
            mesh.array("Points")[2] = "Float64"
            out, _ = self.fuse(self.write(mesh), "--array", "s", "--array", "lin", "--max-error", "0.5%")
            result = Vtu(out)
            off = np.abs(result.arrays["point"]["lin"][1].ravel() - (result.points @ linear + 1))
            self.assertLess(off.max(), 1e-12)

    def test_an_array_that_is_called_none(self):
        mesh = TinyVtu()
        mesh.array("id")[1:] = "none", "Int32", 1, [i % 2 for i in range(len(mesh.tets))]
        options = ["simplify", self.write(mesh), "-o", self.folder / "out.vtu", "--reduction", "10%"]
        self.assertIn(b"(--regions cell:none keeps them)", finish(*options).stderr)
        self.assertEqual(report_of(*options, "--regions", "cell:none", "--quiet")["regions"], ["none"])

    def test_cells_with_points_of_their_own(self):
        mesh, soup = TinyVtu(), TinyVtu()
        points = [mesh.points[v] for tet in mesh.tets for v in tet]
        soup.counts["NumberOfPoints"] = str(len(points))
        soup.array("temperature")[4] = [p[0] for p in points]
        soup.array("Points")[4] = [x for p in points for x in p]
        soup.array("connectivity")[4] = list(range(len(points)))
        said = finish("simplify", self.write(soup), "-o", self.folder / "out.vtu", "--reduction", "50%")
        self.assertEqual(said.returncode, 0)
        self.assertIn(b"no two tetrahedra share a face", said.stderr)
        said = finish("simplify", self.write(mesh), "-o", self.folder / "out.vtu", "--reduction", "50%")
        self.assertNotIn(b"share a face", said.stderr)

    def test_levels_that_are_not_reached(self):
        """Files under the names of those that are not written are of an earlier run, and stay."""
        path, old = self.write(TinyVtu(6)), self.folder / "l_3.vtu"
        old.write_text("mine")
        said = finish("simplify", path, "-o", self.folder / "l_{lod}.vtu", "--lods", "5%,98%,99%,99.5%")
        self.assertEqual(said.returncode, 0)
        self.assertIn(b"level 2 of 4 could not be reached: ", said.stderr)
        self.assertIn(b"l_3.vtu was there before and is no level of this run", said.stderr)
        self.assertNotIn(b"l_4.vtu", said.stderr)
        self.assertEqual(old.read_text(), "mine")

    def test_a_boundary_that_moves(self):
        path = self.generate("--jitter", "0.5", tets="60k")
        _, exact = self.fuse(path, "--reduction", "90%")
        self.assertEqual((exact["stop_reason"], exact["boundary"]), ("saturated", {"mode": "exact", "deviation": 0}))
        for mode, most in (("planar", 2e-9), ("0.5%", 0.005)):
            out, report = self.fuse(path, "--reduction", "80%", "--boundary", mode)
            report_of("check", out, "--strict")
            _, failures = judge_pair(load(path, "original"), load(out, "simplified"), True)
            self.assertEqual(failures, [])
            self.assertLessEqual(report["boundary"]["deviation"], most)
            self.assertLess(report["output"]["boundary_triangles"], exact["output"]["boundary_triangles"] / 2)
            compared = report_of("compare", path, out)
            self.assertLessEqual(compared["surface"]["max"], max(report["boundary"]["deviation"], 1e-15))
        out, report = self.fuse(path, "--reduction", "90%", "--boundary", "planar", "--regions", "none")
        self.assertEqual(report["stop_reason"], "goal")
        self.assertLess(abs(report["output"]["volume"] / report["input"]["volume"] - 1), 1e-6)

    def test_coincident_sheets_stay_together(self):
        """The sides of a slit that ends inside, and of two parts in contact, where the boundary may move."""
        for slit_ends in (4, 99):
            mesh = TinyVtu(8)
            middle = [v for v, p in enumerate(mesh.points) if p[0] == 4 and p[1] < slit_ends]
            twin = {v: len(mesh.points) + i for i, v in enumerate(middle)}
            mesh.points += [mesh.points[v] for v in middle]
            beyond = lambda t: sum(mesh.points[v][0] for v in t) > 16
            mesh.tets = [[twin.get(v, v) for v in t] if beyond(t) else t for t in mesh.tets]
            path = self.write(rebuilt(mesh))

            def sheet(path):
                """The boundary's triangles in the middle, by coordinates, and how often each is there."""
                made, faces = Vtu(path), collections.Counter()
                for tet in made.tets.tolist():
                    faces.update(tuple(sorted(f)) for f in itertools.combinations(tet, 3))
                outer = [f for f, n in faces.items() if n == 1 and all(made.points[v][0] == 4 for v in f)]
                return collections.Counter(tuple(sorted(tuple(made.points[v]) for v in f)) for f in outer)
            before = sheet(path)
            self.assertEqual(set(before.values()), {2})
            for boundary in ("planar", "2%"):
                for options in ([], ["--chunk-tets", "500"]):
                    out, report = self.fuse(path, "--boundary", boundary, "--reduction", "70%", *options)
                    self.assertLess(report["output"]["tets"], report["input"]["tets"] / 2)
                    self.assertEqual(set(sheet(out).values()), {2})
            said = finish("simplify", path, "-o", self.folder / "out.vtu", "--boundary", "planar", "--reduction", "70%").stderr
            self.assertIn(f"{2 * len(middle)} points lie where others do".encode(), said)

    def test_triangles_of_the_file_that_hold_the_boundary_are_told_of(self):
        mesh = TinyVtu(6)
        faces = {tuple(sorted(f)) for t in mesh.tets for f in itertools.combinations(t, 3)}
        outside = [f for f in sorted(faces) if all(mesh.points[v][0] == 0 for v in f)]
        count = len(mesh.tets) + len(outside)
        mesh.counts["NumberOfCells"] = str(count)
        mesh.array("id")[4] = list(range(count))
        mesh.array("connectivity")[4] += [v for f in outside for v in f]
        mesh.array("offsets")[4] += [4 * len(mesh.tets) + 3 * (i + 1) for i in range(len(outside))]
        mesh.array("types")[4] += [5] * len(outside)
        path = self.write(mesh)
        notice = f"{len(outside)} triangles are cells of the file: they stay, and the boundary with them"
        for boundary, told in (("planar", True), ("2%", True), ("exact", False)):
            for options in ([], ["--chunk-tets", "300"]):
                said = finish("simplify", path, "-o", self.folder / "out.vtu", "--boundary", boundary, "--reduction", "50%",
                              *options).stderr.decode()
                self.assertIs(notice in said, told, said)

    def test_a_surface_that_did_not_move_is_said_to_have_stayed(self):
        """On flat sides the bound of its movement is far below what coordinates are rounded by."""
        path = self.write(TinyVtu(6))
        for boundary in "planar", "0.5%":
            said = finish("simplify", path, "-o", self.folder / "out.vtu", "--boundary", boundary, "--reduction", "50%").stderr.decode()
            self.assertIn("the surface has stayed in place", said)
            self.assertNotIn("moved by", said)
            said = finish("simplify", path, "-o", self.folder / "out.vtu", "--boundary", boundary, "--reduction", "50%",
                          "--regions", "id").stderr.decode()
            self.assertIn("the surface and what lies between regions of id have stayed in place", said)

    def test_what_it_promises_for_every_point(self):
        path = self.generate("--jitter", "0.5", tets="40k")
        left = []
        for options in (["--max-error", "0.1%"], ["--max-error", "1%"], []):
            out, report = self.fuse(path, "--regions", "none", *options)
            name = report["steering"][0]
            self.assertEqual(report["stop_reason"], "saturated")
            if "0.1%" in options:
                self.assertIn("at a point of the original", report["stop_sentence"])
            self.assertGreater(report["lods"][-1]["rejected"]["deviation"], 0)
            left.append((report["output"]["tets"], out.read_bytes()))
            self.compare(path, out)
            report_of("compare", path, out, "--array", name, "--max-error", (options or ["1%"])[-1])
        self.assertLess(left[1][0], left[0][0])
        self.assertEqual(left[1], left[2])
        # One array's own bound.
        out, _ = self.fuse(path, "--array", name + ":0.3%")
        report_of("compare", path, out, "--array", name, "--max-error", "0.3%")

    def test_memory_does_not_grow_with_what_has_gone(self):
        if sanitized():
            self.skipTest("a sanitizer takes memory of its own")
        mesh = TinyVtu(56)  # a chunk of the result has the rows of 20 times as many cells
        mesh.arrays.insert(2, ["CellData", "wide", "Float64", 24, [0.1] * (24 * len(mesh.tets))])
        options = ["simplify", self.write(mesh), "-o", self.folder / "out.vtu", "--reduction", "96%", "--chunk-tets", "20k"]
        memory = least_memory(*options)
        report = report_of(*options, "--memory", memory)
        self.assertGreater(report["scratch_bytes"], 0)
        self.assertLess(report["peak_rss_bytes"], size_of(memory))

    def test_integrals_stay(self):
        path = self.generate("--jitter", "0.5", tets="40k")
        for boundary in ("exact", "planar"):
            for conserve in ([], ["--conserve"]):
                out, report = self.fuse(path, "--regions", "none", "--reduction", "70%", "--boundary", boundary, *conserve)
                report_of("check", out, "--strict")
                changes = [abs(a["integral_change"]) for a in report_of("compare", path, out)["arrays"]
                           if a["type"].startswith("Float") and a["integral_change"] is not None]
                self.assertGreater(len(changes), 1)
                if conserve:
                    self.assertLess(max(changes), 1e-6)
                elif boundary == "exact":
                    self.assertGreater(max(changes), 1e-6)

    def test_the_criteria_of_the_paper_bound_fusions(self):
        path = self.generate("--jitter", "0.5", tets="40k")
        _, free = self.fuse(path, "--max-rms", "1%")
        for option, value, reason in (("--aspect-ratio", "2.5", "aspect"), ("--stretch-factor", "1.5", "stretch"),
                                      ("--scalar-tolerance", "0.5%", "scalar"), ("--max-volume", "1e-4", "volume")):
            out, report = self.fuse(path, "--max-rms", "1%", option, value)
            report_of("check", out, "--strict")
            self.assertGreater(report["output"]["tets"], free["output"]["tets"])
            self.assertGreater(report["lods"][-1]["rejected"][reason], 0)

    def test_criteria_that_are_off_are_as_if_they_had_not_been_given(self):
        path = self.generate("--jitter", "0.3")
        out, _ = self.fuse(path, "--reduction", "60%")
        expected = out.read_bytes()
        for options in (["--scalar-tolerance", "off"], ["--stretch-factor", "off,off"], ["--aspect-ratio", "off"]):
            self.assertEqual(self.fuse(path, "--reduction", "60%", *options)[0].read_bytes(), expected, options)

    def test_points_without_a_value_are_a_reason_beside_others(self):
        """Most of what is left has none; a layer of another material is not to blame."""
        mesh = TinyVtu(6)
        mesh.array("temperature")[4] = [math.nan if p[2] < 5 else p[0] * p[0] for p in mesh.points]
        mesh.array("id")[1:] = "material", "Int32", 1, [int(min(mesh.points[v][2] for v in tet) >= 5) for tet in mesh.tets]
        _, report = self.fuse(self.write(mesh), "--reduction", "80%")
        self.assertIn("lies between regions of material or has a value that is no number, and stays", report["stop_sentence"])

    def test_arrays_that_are_named_twice(self):
        path = self.generate()
        for names in (["all", "all:0.1%"], ["front", "front:1%"]):
            options = [word for name in names for word in ("--array", name)]
            said = finish("simplify", path, "-o", self.folder / "out.vtu", *options)
            self.assertEqual(said.returncode, USAGE)
            self.assertIn(b"already", said.stderr)

    def test_values_that_are_none(self):
        path = self.write(TinyVtu(3))
        for option, values in (("--min-quality", ("-0.1", "1", "2", "nan", "good", "")),
                               ("--max-volume", ("0", "-1", "nan", "large", "")),
                               ("--boundary", ("0", "-1%", "100%", "nan", "flat", "")),
                               ("--max-error", ("0", "0%", "-1%", "nan", "little", "")),
                               ("--max-rms", ("0", "0%", "-1%", "nan", "little", ""))):
            for value in values:
                result = finish("simplify", path, "-o", self.folder / "out.vtu", "--method", "fuse", f"{option}={value}")
                self.assertEqual(result.returncode, USAGE, (option, value))
                self.assertIn(option, result.stderr.decode())
        self.assertEqual(self.files(), ["mesh.vtu"])


if __name__ == "__main__":
    main()
