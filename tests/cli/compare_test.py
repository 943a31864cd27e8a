#!/usr/bin/env python3
"""What compare says about two meshes. Usage: compare_test.py TETFUSION"""
import json
import math
import re

from harness import BAD, INVALID, IO, USAGE, FolderTest, finish, least_memory, main, report_of, run, sanitized, size_of
from sample_meshes import mesh_of_all_sorts, rebuilt, set_value
from tiny_vtu import TinyVtu


def without_times(report):
    return {k: v for k, v in report.items() if k not in ("seconds", "cpu_seconds", "peak_rss_bytes", "threads")}


class Compare(FolderTest):
    def pair(self, original, simplified):
        return self.write(original, "original.vtu"), self.write(simplified, "simplified.vtu")

    def changed(self, index=62, by=0.75):
        """The grid, and the same with another value at a point. The field's range is 12."""
        mesh = TinyVtu()
        mesh.array("temperature")[4][index] += by
        return self.pair(TinyVtu(), mesh)

    def test_a_named_array_that_is_lost_breaks_the_bound(self):
        path, other = self.generate(tets="1k"), self.folder / "in.mesh"
        run("convert", path, other, "--quiet")
        for options in ([], ["--array", "temperature"]):
            said = finish("compare", path, other, "--max-error", "1%", *options, "--quiet")
            self.assertEqual(said.returncode, 1)
            self.assertIn(b"no point array temperature", said.stderr)
        self.assertEqual(finish("compare", path, other, "--max-error", "1%", "--array", "none").returncode, USAGE)

    def test_bounds_of_cell_arrays(self):
        """By name alone; where there are no others they must be named, so that nothing is kept that was not looked at."""
        def mesh(value, points=True):
            made = TinyVtu()
            made.arrays.insert(1, ["CellData", "p", "Float64", 1, [value] + [i % 8 for i in range(1, len(made.tets))]])
            if not points:
                made.remove("temperature")
            return made
        original, simplified = self.pair(mesh(0), mesh(2))
        run("compare", original, simplified, "--max-error", "1%")
        run("compare", original, simplified, "--max-error", "29%", "--array", "cell:p", "--array", "temperature")
        text = run("compare", original, simplified, "--max-error", "28%", "--array", "cell:p", code=INVALID).decode()
        self.assertIn("--max-error is broken: the largest error of cell:p is 28.57 %, above 28 %", text)
        lost = self.write(TinyVtu(), "lost.vtu")
        text = run("compare", original, lost, "--max-rms", "1%", "--array", "cell:p", code=INVALID).decode()
        self.assertIn("the simplified mesh has no cell array p", text)
        alone = self.pair(mesh(0, points=False), mesh(2, points=False))
        said = finish("compare", *alone, "--max-error", "100%")
        self.assertEqual(said.returncode, USAGE)
        self.assertIn(b"no floating-point point array that --max-error could be for", said.stderr)
        self.assertIn(b"--array cell:p", said.stderr)
        run("compare", *alone, "--surface", "0")

    def test_shows_the_arrays_that_are_named(self):
        made = TinyVtu()
        made.arrays.insert(1, ["CellData", "p", "Float64", 1, [i % 8 for i in range(len(made.tets))]])
        original, simplified = self.pair(made, made)
        report = self.folder / "report.json"
        for wanted in (["cell:p"], ["temperature"], ["temperature", "cell:p"]):
            named = [word for name in wanted for word in ("--array", name)]
            text = run("compare", original, simplified, *named, "--surface", "0", "--report", report).decode()
            shown = [array["name"] for array in json.loads(report.read_text())["arrays"]]
            self.assertEqual(shown, [name.split(":")[-1] for name in wanted])
            self.assertEqual("temperature" in text, "temperature" in wanted)
        self.assertIn("--array cell:p", finish("compare", original, simplified, "--array", "p").stderr.decode())
        run("compare", original, self.write(TinyVtu(), "lost.vtu"), "--array", "temperature", "--report", report)
        self.assertEqual(json.loads(report.read_text())["missing_arrays"], [])
        # A bound is for these, and all are shown.
        run("compare", original, simplified, "--array", "cell:p", "--max-error", "0", "--report", report)
        self.assertIn("temperature", [array["name"] for array in json.loads(report.read_text())["arrays"]])

    def test_parts_without_any_number(self):
        """Fields may be known in a part of the mesh alone, so that whole blocks have none."""
        original, simplified = TinyVtu(32), TinyVtu(32)
        here = [max(p) < 6 for p in original.points]
        for mesh, factor in ((original, 1), (simplified, 0)):
            mesh.array("temperature")[4] = [factor * p[0] if h else math.nan for p, h in zip(mesh.points, here)]
            inside = [all(here[v] for v in tet) for tet in mesh.tets]
            mesh.arrays.insert(1, ["CellData", "heat", "Float32", 1,
                                   [factor * (i % 7) if h else math.nan for i, h in enumerate(inside)]])
        path, other = self.pair(original, simplified)
        said = finish("compare", path, other, "--max-error", "1%", "--report", "-", "--quiet")
        self.assertEqual(said.returncode, 1)
        arrays = {a["name"]: a for a in json.loads(said.stdout)["arrays"]}
        self.assertEqual(arrays["temperature"]["range"], 5)
        self.assertEqual(arrays["temperature"]["max"], 1)
        self.assertEqual(arrays["heat"]["max"], 1)

    def test_integers_far_apart_and_regions_of_long_integers(self):
        original, simplified = TinyVtu(3), TinyVtu(3)
        count = len(original.tets)
        for mesh, offset in ((original, 0), (simplified, 1)):
            mesh.arrays.insert(1, ["CellData", "region", "Int64", 1, [2 ** 60 + (i + offset) % 2 for i in range(count)]])
            mesh.arrays.insert(1, ["CellData", "wide", "Int64", 1, [-9 * 10 ** 18] + [9 * 10 ** 18 * (1 - offset)] * (count - 1)])
            mesh.arrays.insert(1, ["CellData", "unsigned", "UInt64", 1, [5] + [(2 ** 64 - 1) * (1 - offset)] * (count - 1)])
        arrays = {a["name"]: a for a in report_of("compare", *self.pair(original, simplified))["arrays"]}
        self.assertEqual(arrays["region"]["differing"], 1)
        self.assertEqual(len(arrays["region"]["regions"]), 2)
        self.assertAlmostEqual(arrays["wide"]["range"] / 18e18, 1)
        self.assertAlmostEqual(arrays["wide"]["max"], 0.5)
        self.assertAlmostEqual(arrays["unsigned"]["max"], 1)

    def test_a_mesh_and_itself(self):
        path = self.write(mesh_of_all_sorts())
        report = report_of("compare", path, path)
        for key in ("version", "original", "simplified", "arrays", "volume_change", "outside_points", "surface", "missing_arrays",
                    "retyped_arrays", "bounds", "seconds", "cpu_seconds", "peak_rss_bytes", "threads"):
            self.assertIn(key, report)
        self.assertEqual(report["original"]["tets"], 162)
        self.assertEqual(report["original"]["boundary_triangles"], 108)
        self.assertEqual((report["reduction"], report["volume_change"], report["outside_points"]), (0, 0, 0))
        self.assertEqual(report["surface"]["identical"], True)
        self.assertEqual((report["surface"]["max"], report["surface"]["mean"]), (0, 0))
        self.assertEqual([a["name"] for a in report["arrays"]], ["temperature", "double", "vector", "bytes", "id", "large"])
        for array in report["arrays"]:
            self.assertEqual((array["rms"], array["max"]), (0, 0))
            self.assertIn("integral_change", array)
        self.assertIn(b"identical", run("compare", path, path, "--max-error", "0", "--max-rms", "0%", "--surface", "0"))

    def test_what_rounding_makes_is_told(self):
        """A field whose range is a few units in the last place: what is found is no error of the simplification."""
        meshes = []
        for more in (0, 2.0 ** -12):
            mesh = TinyVtu()
            mesh.arrays.insert(1, ["PointData", "far", "Float64", 1, [2.0 ** 40 + 2.0 ** -10 * p[0] + (i == 7) * more for i, p in enumerate(mesh.points)]])
            meshes.append(mesh)
        text = run("compare", *self.pair(*meshes), "--max-error", "1%").decode()
        self.assertIn("All bounds are kept", text)
        self.assertRegex(text, r"rounding to Float64 makes up to \d+\.?\d* % of this")
        self.assertNotIn("rounding to", run("compare", *self.changed()).decode())

    def test_columns_stand_apart(self):
        """However wide a number is, as that of a change below zero."""
        original, simplified = self.changed(by=-1.2e-6)
        lines = run("compare", original, simplified).decode().splitlines()
        head = next(line for line in lines if line.startswith("Point arrays"))
        row = next(line for line in lines if line.startswith("  temperature"))
        self.assertRegex(row, r" -\d\.\d+e-\d+ %$")
        self.assertEqual(len(row), len(head))
        self.assertEqual(len(re.findall(r" +(?:0(?= |$)|[^ ]+ %)", row)), 6, row)

    def test_an_array_that_is_gone_breaks_bounds(self):
        mesh = TinyVtu()
        mesh.remove("temperature")
        original, simplified = self.pair(TinyVtu(), mesh)
        for bound in ("--max-error", "--max-rms"):
            text = run("compare", original, simplified, bound, "50%", code=INVALID).decode()
            self.assertIn(f"{bound} is broken: the simplified mesh has no point array temperature", text)
        text = run("compare", simplified, simplified, "--max-error", "1%").decode()
        self.assertIn("no floating-point array to hold against the bounds", text)

    def test_long_integers_are_told_apart(self):
        for kind, start in (("Int64", 2 ** 60), ("UInt64", 2 ** 64 - 1000), ("Int64", -2 ** 63)):
            meshes = []
            for more in (0, 1):
                mesh = TinyVtu()
                mesh.arrays.insert(1, ["PointData", "n", kind, 1, [start + i + more for i in range(len(mesh.points))]])
                meshes.append(mesh)
            array = next(a for a in report_of("compare", *self.pair(*meshes))["arrays"] if a["name"] == "n")
            count = len(meshes[0].points)
            self.assertEqual((array["range"], array["differing"]), (count - 1, 1))
            self.assertAlmostEqual(array["max"], 1 / (count - 1))

    def test_values_out_of_nothing_break_bounds(self):
        nothing = TinyVtu()
        nothing.array("temperature")[4] = [float("nan")] * len(nothing.points)
        original, simplified = self.pair(nothing, TinyVtu())
        text = run("compare", original, simplified, "--max-error", "1%", code=INVALID).decode()
        self.assertIn("no value of temperature in the original is finite, but the simplified mesh has such", text)
        run("compare", original, original, "--max-error", "1%")

    def test_one_value_that_is_another(self):
        original, simplified = self.changed()
        array = report_of("compare", original, simplified)["arrays"][0]
        self.assertEqual(array["range"], 12)
        self.assertEqual(array["max"], 0.0625)
        self.assertAlmostEqual(array["rms"], 0.0625 / 125**0.5, places=15)
        self.assertEqual(array["max_at"], [2, 2, 2])

    def test_bounds(self):
        original, simplified = self.changed()
        kept = ["--max-error", "6.3%", "--max-rms", "0.0056", "--surface", "0", "--array", "temperature"]
        self.assertIn(b"All bounds are kept", run("compare", original, simplified, *kept))
        for bound, value in (("--max-error", "6.2%"), ("--max-rms", "0.0055"), ("--max-error", "0")):
            text = run("compare", original, simplified, bound, value, code=INVALID).decode()
            self.assertRegex(text, f"{bound} is broken: the .* error of temperature is .* above")
            self.assertNotIn("kept", text)
            for quiet in (["--quiet"], ["--report", "-"]):
                result = finish("compare", original, simplified, bound, value, *quiet)
                self.assertEqual(result.returncode, INVALID)
                self.assertIn(f"{bound} is broken", result.stderr.decode())
        report = report_of("compare", original, simplified, "--max-error", "1%", "--max-rms", "1%", code=INVALID)
        self.assertEqual([(b["bound"], b["array"], b["broken"], "sentence" in b) for b in report["bounds"]],
                         [("max_rms", "temperature", False, False), ("max_error", "temperature", True, True)])
        for option in ("--max-error", "--max-rms", "--surface"):
            result = finish("compare", original, simplified, option, "5")
            self.assertEqual(result.returncode, USAGE)
            self.assertIn(f"{option} 5: give a share from 0 to 100%", result.stderr.decode())

    def test_a_surface_that_moved(self):
        mesh = TinyVtu()
        mesh.points = [(p[0] + 0.25, p[1], p[2]) for p in mesh.points]
        mesh.array("Points")[4] = [c for p in mesh.points for c in p]
        original, simplified = self.pair(TinyVtu(), mesh)
        report = report_of("compare", original, simplified, "--surface", "3.7%")
        self.assertFalse(report["surface"]["identical"])
        for side in (report["surface"], report["surface"]["original_to_simplified"], report["surface"]["simplified_to_original"]):
            self.assertAlmostEqual(side["max"] * 48**0.5, 0.25, places=12)
        self.assertEqual(report["outside_points"], 25)
        self.assertAlmostEqual(report["outside_max"] * 48**0.5, 0.25, places=12)
        text = run("compare", original, simplified, "--surface", "3.6%", code=INVALID).decode()
        self.assertRegex(text, "--surface is broken: the surfaces are up to 3.608 % of the diagonal apart, above 3.6 %")

    def test_interfaces_that_moved(self):
        """Those of each array of regions, though the boundary is where it was."""
        mesh, n = TinyVtu(4), 4
        centres = [sum(mesh.points[v][0] for v in tet) / 4 for tet in mesh.tets]
        for name, values in (("zone", [7] * len(mesh.tets)), ("material", [int(x > 2) for x in centres])):
            mesh.arrays.insert(1, ["CellData", name, "Int32", 1, values])
        path, other = self.write(mesh), self.folder / "other.vtu"

        def compared(*options, code=0):
            return report_of("compare", path, other, *options, code=code)

        def of_array(report, name):
            return next(a for a in report["arrays"] if a["name"] == name)

        self.write(mesh, other.name)
        report = compared("--interfaces", "0")
        self.assertEqual(of_array(report, "material")["interfaces"]["identical"], True)
        self.assertNotIn("interfaces", of_array(report, "zone"))
        self.assertIn(b"interfaces identical", run("compare", path, other))
        inside = [i for i, p in enumerate(mesh.points) if p[0] == 2 and 0 < p[1] < n and 0 < p[2] < n]
        for i in inside:
            mesh.points[i] = (2.25, *mesh.points[i][1:])
        self.write(rebuilt(mesh), other.name)
        share = 0.25 / math.sqrt(3 * n * n)
        report = compared()
        found = of_array(report, "material")["interfaces"]
        self.assertFalse(found["identical"])
        self.assertAlmostEqual(found["max"], share)
        self.assertTrue(0 < found["mean"] < share)
        self.assertEqual(report["surface"]["max"], 0)
        compared("--surface", "0", "--interfaces", str(1.01 * share))
        broken = compared("--surface", "0", "--interfaces", str(0.99 * share), code=INVALID)["bounds"]
        self.assertEqual([(b.get("array"), b["broken"]) for b in broken], [(None, False), ("material", True)])
        self.assertIn("--interfaces is broken: the interfaces of material are up to", broken[1]["sentence"])
        # Where one of the meshes has none.
        mesh.array("material")[4] = [0] * len(mesh.tets)
        self.write(rebuilt(mesh), other.name)
        self.assertIsNone(of_array(compared(), "material")["interfaces"]["max"])
        compared("--interfaces", "50%", code=INVALID)
        # Where one lacks the array: that of several regions alone.
        mesh.remove("zone")
        mesh.remove("material")
        self.write(rebuilt(mesh), other.name)
        broken = compared("--interfaces", "50%", code=INVALID)["bounds"]
        self.assertEqual([(b["array"], b["broken"]) for b in broken], [("material", True)])
        self.assertIn("--interfaces is broken: the simplified mesh has no cell array material", broken[0]["sentence"])
        result = finish("compare", other, other, "--interfaces", "0")
        self.assertEqual(result.returncode, 0)
        self.assertIn(b"nothing to hold against it", result.stderr)

    def test_arrays_that_are_gone(self):
        mesh = TinyVtu()
        mesh.array("temperature")[2] = "Float64"
        mesh.remove("id")
        original, simplified = self.pair(TinyVtu(), mesh)
        report = report_of("compare", original, simplified)
        self.assertEqual(report["missing_arrays"], ["cell:id"])
        self.assertEqual(report["retyped_arrays"], [{"name": "temperature", "original": "Float32", "simplified": "Float64"}])
        text = run("compare", original, simplified).decode()
        self.assertIn("Missing: cell:id", text)
        self.assertIn("Other type: temperature: Float64, was Float32", text)

    def test_infinite_shares_are_null(self):
        mesh, other = TinyVtu(), TinyVtu()
        mesh.array("temperature")[4] = [0] * 125
        other.array("temperature")[4] = [0] * 124 + [1]
        report = report_of("compare", *self.pair(mesh, other))
        self.assertIsNone(report["arrays"][0]["max"])
        run("compare", *self.pair(mesh, other), "--max-error", "100%", code=INVALID)

    def test_the_same_for_any_number_of_threads(self):
        original = self.generate("--jitter", "0.2", kind="kuhn", tets="300k", name="big.vtu")
        simplified = self.generate("--jitter", "0.2", kind="bcc", tets="60k", name="small.vtu")
        first = without_times(report_of("compare", original, simplified, "--threads", 1))
        self.assertEqual(first["outside_points"], 0)
        self.assertLess(first["surface"]["max"], 1e-7)
        self.assertTrue(all(0 < a["max"] < 1 for a in first["arrays"]))
        for threads in (2, 3, 4):
            self.assertEqual(without_times(report_of("compare", original, simplified, "--threads", threads)), first)

    def test_within_a_budget(self):
        path = self.generate("--jitter", "0.3", tets="300k")
        small = self.folder / "small.vtu"
        run("simplify", path, "-o", small, "--reduction", "50%")
        least = least_memory("compare", path, small)
        within = report_of("compare", path, small, "--memory", least)
        if not sanitized():
            self.assertLess(within["peak_rss_bytes"], size_of(least))
        self.assertEqual(without_times(within), without_times(report_of("compare", path, small)))

    def test_the_order_of_the_file_hardly_matters(self):
        straight = self.generate("--jitter", "0.2", name="a.vtu")
        shuffled = self.generate("--jitter", "0.2", "--shuffle", name="b.vtu")
        report = report_of("compare", straight, shuffled)
        self.assertTrue(report["surface"]["identical"])
        self.assertEqual(report["outside_points"], 0)
        for array in report["arrays"]:
            self.assertLess(array["max"], 1e-6, array["name"])

    def test_simplify_and_compare(self):
        original, out = self.generate("--jitter", "0.2"), self.folder / "out.vtu"
        run("simplify", original, "-o", out, "--method", "tetfuse", "--scalar-tolerance", "1%", "--quiet")
        report = report_of("compare", original, out, "--surface", "0")
        self.assertGreater(report["reduction"], 0.05)
        self.assertTrue(report["surface"]["identical"])
        self.assertEqual((report["outside_points"], report["outside_cells"]), (0, 0))
        self.assertLess(abs(report["volume_change"]), 1e-12)
        self.assertEqual((report["missing_arrays"], report["retyped_arrays"]), ([], []))

    def test_standard_input_and_the_report_as_a_file(self):
        original, simplified = self.changed()
        report = self.folder / "report.json"
        with open(original, "rb") as mesh:
            self.assertIn(b"temperature", run("compare", "-", simplified, "--report", report, stdin=mesh))
        self.assertEqual(json.loads(report.read_text())["arrays"][0]["max"], 0.0625)
        self.assertEqual(run("compare", original, simplified, "--quiet"), b"")

    def test_usage(self):
        original, simplified = self.changed()
        for options in ([], ["--max-error", "-1%"], ["--max-rms", "much"], ["--surface", ""], ["--array", "pressure"],
                        ["--max-error", "1%", "--array", "pressure"], ["--max-error", "1%", "--array", "id"],
                        ["--report", original], ["--threads", "-1"]):
            files = [original, simplified] if options else [original]
            run("compare", *files, *options, code=USAGE)
        run("compare", "-", "-", code=USAGE)
        said = finish("compare", original, simplified, "--max-error", "1%", "--array", "cell:none")
        self.assertIn(b"no numeric array of that name", said.stderr)
        # Before any work: nothing is shown.
        for command in (["compare", original, simplified], ["check", original], ["info", original]):
            said = finish(*command, "--report", self.folder / "none" / "report.json")
            self.assertEqual((said.returncode, said.stdout), (IO, b""))
        self.assertEqual(self.files(), ["original.vtu", "simplified.vtu"])

    def test_meshes_that_are_none(self):
        good = self.write(TinyVtu(), "good.vtu")
        doubled = TinyVtu(1)
        doubled.tets += doubled.tets
        bad = [b"no mesh at all", b"", set_value("offsets", 3, 17), set_value("connectivity", 7, 125), set_value("Points", 10, float("nan")),
               rebuilt(doubled)]
        for mesh in bad:
            path = self.write(mesh, "bad.vtu")
            for files in ((good, path), (path, good)):
                message = finish("compare", *files).stderr.decode()
                run("compare", *files, code=BAD)
                self.assertIn("bad.vtu", message)
        run("compare", good, self.folder / "missing.vtu", code=IO)
        run("compare", self.folder / "missing.vtu", good, code=IO)


if __name__ == "__main__":
    main()
