#!/usr/bin/env python3
"""The options and the report of simplify. Usage: simplify_test.py TETFUSION"""
import re
import shlex

import numpy as np

from harness import USAGE, FolderTest, finish, least_memory, main, report_of, run
from independent_check import Vtu
from tiny_vtu import TinyVtu


class Options(FolderTest):
    def refused(self, *options, output="out.vtu"):
        """The message, for options that make no sense."""
        result = finish("simplify", self.write(TinyVtu(3)), "-o", self.folder / output, *options)
        self.assertEqual(result.returncode, USAGE, result.stderr)
        self.assertEqual(self.files(), ["mesh.vtu"])
        return result.stderr.decode()

    def test_memory(self):
        path = self.write(TinyVtu(3))
        for size in ("2G", "512M", "1.5G", "1GiB", "900MiB", "0.001T", "1000000k", str(2**30)):
            run("simplify", path, "-o", self.folder / "out.vtu", "--memory", size)
        (self.folder / "out.vtu").unlink()
        for size in ("0", "-1G", "2GB", "much", "G", "1.5", "1e30G", " 1G"):
            message = self.refused(f"--memory={size}")
            self.assertIn(f"--memory {size}:", message)
            self.assertIn("as in 2G, 512M or 1.5G", message)
        for option in ("--memory", "--scratch", "--report", "--chunk-tets"):
            self.assertIn("empty", self.refused(option, ""))

    def test_a_name_that_is_none_of_the_choices_is_named_with_them(self):
        self.assertIn('--method: "foo" is none of fuse, tetfuse', self.refused("--method", "foo"))
        self.assertIn('--encoding: "zip" is none of ascii, inline, lz4, raw, zlib', self.refused("--encoding=zip"))
        run("simplify", self.write(TinyVtu(3)), "-o", self.folder / "out.vtu", "--method", "Fuse", "--encoding", "LZ4")

    def test_a_dry_run_says_what_it_needs_and_writes_nothing(self):
        path = self.generate(tets="3M")
        plan = run("simplify", path, "-o", self.folder / "out.vtu", "--dry-run", "--memory", "500M").decode()
        self.assertRegex(plan, r"memory +about .* of 500\.0 MiB")
        self.assertIn("none", plan.split("scratch")[1])
        plan = run("simplify", path, "-o", self.folder / "out.vtu", "--dry-run", "--memory", "300M").decode()
        self.assertRegex(plan, r"scratch +about .*out\.vtu\.tetfusion")
        self.assertRegex(plan, r"reachable +about [\d.]+ % fewer tetrahedra\n")
        self.assertRegex(plan, r"time +about \d.* with \d+ threads, without waiting for disks\n")
        self.assertRegex(plan, r"basis +\d+,\d+ tetrahedra from its middle, ")
        plan = run("simplify", path, "-o", self.folder / "out.vtu", "--dry-run", "--verify").decode()
        self.assertRegex(plan, "without waiting for disks and without --verify\n")
        self.assertEqual(run("simplify", path, "-o", self.folder / "out.vtu", "--dry-run", "--quiet"), b"")
        moving = ("--boundary", "planar", "--reduction", "99.99%")
        plan = run("simplify", path, "-o", self.folder / "out.vtu", "--dry-run", *moving).decode()
        self.assertRegex(plan, r"reachable +about [\d.]+ % fewer tetrahedra or more \([\d.]+ % with four times as many left\), as the boundary moves; whether the goal is in reach is open\n")
        self.assertEqual(len(self.files()), 1)

    def test_a_dry_run_refuses_what_the_run_refuses(self):
        path, theirs = self.generate(tets="300k"), self.folder / "theirs"
        theirs.mkdir()
        (theirs / "thesis.txt").write_text("years of work")
        for output, options in ("-", ["--memory", least_memory("simplify", path, "-o", "-")]), (self.folder / "out.vtu", ["--scratch", theirs]):
            arguments = ["simplify", path, "-o", output, *options]
            result, plan = finish(*arguments), finish(*arguments, "--dry-run")
            self.assertEqual((plan.returncode, plan.stdout), (USAGE, b""), plan)
            self.assertEqual((result.returncode, result.stderr), (USAGE, plan.stderr), result)

    def test_the_report_of_a_dry_run(self):
        path = self.generate(tets="30k")
        for options, reaches in ([], None), (["--reduction", "10%"], True), (["--tets", "10"], False):
            arguments = ["simplify", path, "-o", self.folder / "out.vtu", "--dry-run", "--threads", "2", *options]
            plan = report_of(*arguments)
            self.assertEqual(self.files(), ["generated.vtu"])
            self.assertEqual((plan["threads"], plan["scratch_bytes"], plan["scratch"]), (2, 0, None))
            estimate = plan["estimate"]
            self.assertEqual(estimate["reaches_goal"], reaches)
            self.assertEqual(estimate["sample_tets"], plan["input"]["tets"])
            self.assertIsNone(estimate["reduction_low"])
            self.assertTrue(0 < estimate["reduction"] < 1 and 0 < estimate["boundary_points_share"] < 1, estimate)
            self.assertTrue(0 < estimate["sample_seconds"] < 60 and 0 < estimate["seconds"] < 60, estimate)
            self.assertEqual("out of reach" in run(*arguments).decode(), reaches is False)
        reached = report_of("simplify", path, "-o", self.folder / "out.vtu")["reduction"]
        self.assertAlmostEqual(report_of("simplify", path, "-o", self.folder / "out.vtu", "--dry-run")["estimate"]["reduction"], reached)

    def test_the_report_is_no_level(self):
        for name in ("lod_1.vtu", "lod_2.vtu"):
            said = self.refused("--lods", "30%,50%", "--report", self.folder / name, output="lod_{lod}.vtu")
            self.assertIn("give it a name of its own", said)

    def test_levels_are_not_written_over_what_is_still_read(self):
        path = self.generate(tets="3k")
        for name in ("in_1.vtu", "in_1.pvtu"):
            run("simplify", path, "-o", self.folder / name, "--reduction", "0%")
        before = self.contents()
        for name in ("in_1.vtu", "in_1.pvtu"):
            for options in (["-o", f"in_{{lod}}{name[4:]}"], ["-o", "out_{lod}.vtu", "--map", f"in_{{lod}}{name[4:]}"],
                            ["-o", "a_1{lod}.vtu", "--map", "a_{lod}1.vtu"]):
                result = finish("simplify", name, "--lods", "20%,40%", *options, cwd=self.folder)
                self.assertEqual(result.returncode, USAGE, result.stderr)
                self.assertIn(b"give it a name of its own", result.stderr)
                self.assertEqual(self.contents(), before)
        run("simplify", "in_1.vtu", "-o", "in_{lod}.vtu", "--lods", "30%", cwd=self.folder)

    def contents(self):
        return {file: file.read_bytes() for file in self.folder.rglob("*") if file.is_file()}

    def test_a_goal_is_said_to_be_reached_where_it_is(self):
        path, out = self.generate("--jitter", "0.4", tets="3k"), self.folder / "out.vtu"
        stops = set()
        for chunk_tets in ("300", "500", "200k"):
            for goal in ("10%", "20%", "50%"):
                arguments = ["simplify", path, "-o", out, "--reduction", goal, "--chunk-tets", chunk_tets]
                report = report_of(*arguments)
                stops.add(report["stop_reason"])
                wanted = int(goal[:-1]) / 100 * report["input"]["tets"]
                gone = report["input"]["tets"] - report["output"]["tets"]
                self.assertLessEqual(gone, wanted)
                self.assertEqual(gone > wanted - 15, report["stop_reason"] == "goal", (chunk_tets, goal))
                strict = finish(*arguments, "--strict", "--quiet")
                self.assertEqual(strict.returncode, 0 if report["stop_reason"] == "goal" else 6)
                self.assertEqual("The goal was not reached" in strict.stderr.decode(), report["stop_reason"] != "goal")
        self.assertEqual(stops, {"goal", "saturated"})

    def test_shares_of_more_than_all(self):
        for option, value in (("--max-error", "5"), ("--max-rms", "101%"), ("--reduction", "90"),
                              ("--scalar-tolerance", "5"), ("--scalar-tolerance", "1%,200%")):
            self.assertRegex(self.refused(option, value), "100%.*(5%|90%)")

    def test_levels_must_differ(self):
        for options in (["--lods", "50%,50%"], ["--lods", "10%,0.1,20%"], ["--lods", "3", "--reduction", "0%"]):
            self.assertRegex(self.refused(*options, output="{lod}.vtu"), "--lods .* two levels of")

    def test_a_result_needs_its_option(self):
        result = finish("simplify", self.generate(tets="1k"), self.folder / "out.vtu")
        self.assertEqual(result.returncode, USAGE)
        self.assertIn(b"--output is required, as in -o out.vtu; see", result.stderr)

    def test_a_tolerance_that_is_none(self):
        for tolerance in ("0", "-1%", "nan"):
            message = self.refused("--array", f"temperature:{tolerance}")
            self.assertIn(f"--array temperature:{tolerance}: the tolerance", message)
        self.assertIn("no array \"colour:1%\"", self.refused("--array", "colour:1%"))


class Report(FolderTest):
    def test_the_report_of_simplify(self):
        path, out = self.generate(), self.folder / "out.vtu"
        report = report_of("simplify", path, "-o", out, "--reduction", "20%", "--threads", "2")
        for key in ("version", "reduction", "stop_reason", "lods", "cpu_seconds", "peak_rss_bytes", "threads", "chunks"):
            self.assertIn(key, report)
        for side in ("input", "output"):
            for key in ("points", "tets", "boundary_triangles", "volume"):
                self.assertIn(key, report[side])
        for lod in report["lods"]:
            for key in ("tets", "fused", "rejected"):
                self.assertIn(key, lod)
        self.assertGreater(report["seconds"]["total"], 0)
        self.assertEqual(report["threads"], 2)
        self.assertEqual(report["output"]["tets"], len(Vtu(out).tets))
        self.assertEqual(report["lods"][-1]["tets"], report["output"]["tets"])
        self.assertAlmostEqual(report["reduction"], 1 - report["output"]["tets"] / report["input"]["tets"])

    def test_the_report_has_each_level(self):
        path = self.generate()
        report = report_of("simplify", path, "-o", self.folder / "lod_{lod}.vtu", "--lods", "10%,20%,30%")
        self.assertEqual([level["path"] for level in report["levels"]], report["outputs"])
        for level in report["levels"]:
            mesh = Vtu(level["path"])
            self.assertEqual((level["tets"], level["points"]), (len(mesh.tets), len(mesh.points)))
        self.assertEqual(report["levels"][-1], report["output"])

    def test_a_number_of_levels_is_spaced_geometrically(self):
        path = self.generate()
        report = report_of("simplify", path, "-o", self.folder / "lod_{lod}.vtu", "--lods", "3", "--reduction", "48.8%")
        self.assertEqual(self.files(), ["generated.vtu", "lod_1.vtu", "lod_2.vtu", "lod_3.vtu"])
        left = [level["tets"] / report["input"]["tets"] for level in report["levels"]]
        np.testing.assert_allclose(left, [0.8, 0.8**2, 0.8**3], atol=0.001)

    def test_verbose_says_time_and_memory(self):
        path, out = self.generate(), self.folder / "out.vtu"
        for arguments in (["simplify", path, "-o", out], ["info", path], ["check", path], ["convert", path, out],
                          ["generate", "five", "--tets", "1k", "-o", out]):
            text = finish(*arguments, "-v").stderr.decode()
            self.assertRegex(text.splitlines()[-1], r"^[\d.]+ s, [\d.]+ s of processor time, [\d.]+ MiB at the peak$")
        self.assertRegex(finish("simplify", path, "-o", out, "-v").stderr.decode(), "round 1: ")

    def test_what_a_bound_of_whole_numbers_means_is_said(self):
        mesh = TinyVtu(6)
        mesh.arrays.insert(0, ["PointData", "label", "Int32", 1, list(range(len(mesh.points)))])
        path = self.write(mesh)
        for name, is_said in (("label", True), ("temperature", False)):
            said = finish("simplify", path, "-o", self.folder / "out.vtu", "--array", name, "--max-error", "5%").stderr.decode()
            self.assertEqual(f"array {name} holds whole numbers" in said, is_said, said)

    def test_what_becomes_of_mid_edge_nodes_is_said(self):
        """Tetrahedra of ten nodes: each edge has one in its middle."""
        mesh = TinyVtu(3)
        middles, cells = {}, []
        for tet in mesh.tets:
            edges = [tuple(sorted((tet[i], tet[k]))) for i, k in ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))]
            cells += tet + [middles.setdefault(edge, len(mesh.points) + len(middles)) for edge in edges]
        points = mesh.points + [tuple((a + b) / 2 for a, b in zip(mesh.points[i], mesh.points[k])) for i, k in middles]
        mesh.array("Points")[4] = [c for p in points for c in p]
        mesh.array("temperature")[4] = [p[0] + 2 * p[1] for p in points]
        mesh.counts["NumberOfPoints"] = str(len(points))
        mesh.array("connectivity")[4] = cells
        mesh.array("offsets")[4] = [10 * (i + 1) for i in range(len(mesh.tets))]
        mesh.array("types")[4] = [24] * len(mesh.tets)
        path, out = self.folder / "ten.vtu", self.folder / "out.vtu"
        path.write_bytes(mesh.bytes())
        self.assertIn(b"--linearize", finish("simplify", path, "-o", out, "--reduction", "20%").stderr)
        said = finish("simplify", path, "-o", out, "--reduction", "20%", "--linearize").stderr.decode()
        self.assertIn(f"{len(middles)} points are used by no cell, now that cells have no mid-edge nodes: dropped with their values", said)

    def test_which_array_steers_is_said_where_nobody_chose_it(self):
        path, out = self.generate(), self.folder / "out.vtu"
        notice = b"array temperature steers (choose others with --array)"
        said = finish("simplify", path, "-o", out).stderr
        self.assertIn(notice, said)
        self.assertIn(b"arrays that follow it, whose errors nothing limits: front, velocity (--array", said)
        self.assertNotIn(b"steer", finish("simplify", path, "-o", out, "--array", "temperature").stderr)
        self.assertEqual(b"", finish("simplify", path, "-o", out, "--quiet").stderr)

    def test_arrays_that_may_be_regions_are_told_of_where_nobody_chose(self):
        mesh, out = TinyVtu(), self.folder / "out.vtu"
        mesh.array("id")[1] = "cell_tags"
        numbers = mesh.array("cell_tags")[4]
        mesh.array("cell_tags")[4] = [i // 7 for i in numbers]
        path = self.folder / "tagged.vtu"
        path.write_bytes(mesh.bytes())
        notice = b"cell array cell_tags may be regions, too"
        self.assertIn(notice, finish("simplify", path, "-o", out).stderr)
        for chosen in ("none", "cell_tags"):
            self.assertNotIn(notice, finish("simplify", path, "-o", out, "--regions", chosen).stderr)
        for without in ([7] * len(numbers), numbers):  # the same everywhere, so that there are no interfaces; numbers of the cells
            mesh.array("cell_tags")[4] = without
            path.write_bytes(mesh.bytes())
            self.assertNotIn(b"may be regions", finish("simplify", path, "-o", out).stderr)

    def test_regions_of_floats_are_told_of(self):
        mesh, out = TinyVtu(), self.folder / "out.vtu"
        mesh.array("id")[1:3] = "Material", "Float32"
        path = self.folder / "floats.vtu"
        path.write_bytes(mesh.bytes())
        self.assertIn(b"cell array Material has floating-point numbers", finish("simplify", path, "-o", out).stderr)
        self.assertIn(b"(if its values say regions, --regions Material keeps them)", finish("simplify", path, "-o", out).stderr)
        self.assertNotIn(b"floating-point", finish("simplify", path, "-o", out, "--regions", "none").stderr)
        mesh.array("Material")[1] = "lab"
        path.write_bytes(mesh.bytes())
        self.assertIn(b"cell:lab (--array", finish("simplify", path, "-o", out).stderr)
        self.assertNotIn(b"cell:lab", finish("simplify", path, "-o", out, "--regions", "lab").stderr)

    def test_regions_that_may_be_a_partition_are_told_of(self):
        mesh, out = TinyVtu(), self.folder / "out.vtu"
        mesh.array("id")[4] = [i % 2 for i in mesh.array("id")[4]]
        for name, hint in (("part", b"(if it is a partition of a parallel run: --regions none)"), ("zone", b"(--regions none switches that off)")):
            mesh.arrays[1][1] = name
            path = self.write(mesh)
            self.assertIn(b"interfaces of cell array %s are kept %s" % (name.encode(), hint), finish("simplify", path, "-o", out).stderr)

    def test_directions_are_told_of(self):
        mesh, out = TinyVtu(), self.folder / "out.vtu"
        count = len(mesh.points)
        along = [[1.0, 0, 0], [0, 0.6, -0.8], [0, 0, 0]]
        for name, rows in (("fibre", along), ("force", [[1.0, 0, 0], [0, 0.6, -0.9]]), ("same", along[:1])):
            mesh.arrays.insert(1, ["PointData", name, "Float32", 3, [x for i in range(count) for x in rows[i % len(rows)]]])
        said = finish("simplify", self.write(mesh), "-o", out, "--reduction", "10%").stderr
        self.assertIn(b"\nfibre: vectors of length 1 alone", said)

    def test_sets_of_nodes_whose_borders_may_go_are_told_of(self):
        mesh, out = TinyVtu(), self.folder / "out.vtu"
        count = len(mesh.points)
        clamp = [int(p[2] == 0 and p[0] < 2) for p in mesh.points]
        for name, kind, values in (("nset_clamp", "Int32", clamp), ("numbers", "Int64", list(range(count))), ("large", "UInt64", [2**63 + i for i in range(count)]), ("flat", "UInt8", [1] * count),
                                   ("share", "Float64", clamp), ("vtkGhostType", "UInt8", [0] * count)):
            mesh.arrays.insert(1, ["PointData", name, kind, 1, values])
        path, notice = self.write(mesh), b"of nodes: "
        options = ["simplify", path, "-o", out, "--reduction", "10%"]
        self.assertNotIn(notice, finish(*options).stderr)
        for more in (["--boundary", "planar"], ["--boundary", "1%"]):
            self.assertIn(b"point array nset_clamp may be a set of nodes: its border is not kept where the surface gets other triangles "
                          b"(on the surface --boundary exact keeps it)", finish(*options, *more).stderr)
        self.assertNotIn(notice, finish(*options, "--boundary", "planar", "--array", "nset_clamp").stderr)
        mesh.arrays.insert(1, ["PointData", "nset_top", "UInt8", 1, clamp])
        self.write(mesh)
        self.assertIn(b"point arrays nset_top, nset_clamp may be sets of nodes: their borders are", finish(*options, "--boundary", "planar").stderr)

    def test_values_in_the_wrong_unit_are_answered_with_what_they_are(self):
        path = self.write(TinyVtu())
        for option, value, told in (("--boundary", "5", b"--boundary 5: that is 500 % of the diagonal; give less, as in 0.1%"),
                                    ("--boundary", "1", b"--boundary 1: that is 100 % of the diagonal"),
                                    ("--boundary", "0", b"--boundary 0: give exact, where no vertex of the surface moves"),
                                    ("--boundary", "0.5", b"--boundary 0.5: that is 50 % of the diagonal; give 0.5% or 50%, whichever is meant"),
                                    ("--boundary", "0.1", b"--boundary 0.1: that is 10 % of the diagonal; give 0.1% or 10%"),
                                    ("--memory", "2", b"--memory 2: that is 2 bytes; is 2G or 2M meant?"),
                                    ("--memory", "1000000", b"--memory 1000000: that is 1,000,000 bytes")):
            result = finish("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "10%", option, value)
            self.assertEqual(result.returncode, USAGE)
            self.assertIn(told, result.stderr)
        for value, share in ("0.09", 0.09), ("50%", 0.5), ("99%", 0.99):
            report = report_of("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "10%", "--boundary", value)
            self.assertEqual(report["boundary"]["mode"], str(share))

    def test_the_option_that_a_notice_names_is_what_to_type(self):
        """With those that are kept by default, whose place it takes, and with quotes where a shell wants them."""
        mesh, out = TinyVtu(), self.folder / "out.vtu"
        ids = mesh.array("id")[4]
        mesh.array("id")[1] = "region"
        mesh.arrays.insert(2, ["CellData", "Mo's zone", "Float64", 1, [0.5 * (i % 2) for i in ids]])
        path = self.write(mesh)
        said = finish("simplify", path, "-o", out).stderr.decode()
        option = re.search(r"\(if its values say regions, (.*) keeps them\)", said)[1]
        self.assertEqual(shlex.split(option), ["--regions", "region", "--regions", "Mo's zone"])
        report = report_of("simplify", path, "-o", out, *shlex.split(option))
        self.assertEqual(report["regions"], ["region", "Mo's zone"])
        plan = report_of("simplify", path, "-o", out, *shlex.split(option), "--dry-run")
        self.assertEqual(plan["regions"], ["region", "Mo's zone"])

    def test_regions_of_floats_are_kept_by_name(self):
        """Verified, with the volume of each, and the same bytes whatever the threads and the memory."""
        path, out = self.floats_as_regions(), self.folder / "out.vtu"
        for options in ([], ["--boundary", "planar"], ["--boundary", "planar", "--conserve"], ["--method", "tetfuse", "--scalar-tolerance", "off"]):
            goal = ["--regions", "zone", "--reduction", "60%", "--chunk-tets", "8k", *options]
            least = least_memory("simplify", path, "-o", out, *goal)
            report = report_of("simplify", path, "-o", out, *goal, "--verify", "--threads", "1")
            self.assertEqual(report["regions"], ["zone"])
            self.assertGreater(report["reduction"], 0.4)
            self.assertIn("interfaces", [c["name"] for c in report["verified"][0]["checks"]])
            expected = out.read_bytes()
            for threads, memory in (("2", "2G"), ("2", least), ("1", least)):
                run("simplify", path, "-o", out, *goal, "--threads", threads, "--memory", memory, "--quiet")
                self.assertEqual(out.read_bytes(), expected)
            zone = next(a for a in report_of("compare", path, out)["arrays"] if a["name"] == "zone")
            self.assertEqual(len(zone["regions"]), 4)
            for region in zone["regions"]:
                self.assertAlmostEqual(region["simplified"] / region["original"], 1, delta=1e-6)

    def floats_as_regions(self):
        """A generated mesh whose regions are floating-point numbers."""
        path, out = self.generate(tets="60k"), self.folder / "floats.vtu"
        mesh = Vtu(path)
        made = TinyVtu(2)
        made.points, made.tets = mesh.points.tolist(), mesh.tets.tolist()
        kinds = mesh.arrays["cell"]["region"][1].ravel()
        made.counts = {"NumberOfPoints": str(len(made.points)), "NumberOfCells": str(len(made.tets))}
        made.array("temperature")[4] = np.squeeze(mesh.arrays["point"]["temperature"][1]).tolist()
        made.array("id")[1:] = "zone", "Float32", 1, (0.25 * kinds).tolist()
        made.array("Points")[4] = mesh.points.ravel().tolist()
        made.array("connectivity")[4] = mesh.tets.ravel().tolist()
        made.array("offsets")[4] = list(range(4, 4 * len(made.tets) + 1, 4))
        made.array("types")[4] = [10] * len(made.tets)
        out.write_bytes(made.bytes())
        return out


if __name__ == "__main__":
    main()
