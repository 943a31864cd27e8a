#!/usr/bin/env python3
"""What check says about good and bad meshes. Usage: check_test.py TETFUSION"""
import json

import numpy as np

from harness import BAD, INVALID, IO, USAGE, FolderTest, main, report_of, run
from independent_check import Vtu
from sample_meshes import mesh_of_all_sorts, rebuilt, set_value, two_tets
from tiny_vtu import TinyVtu


class Check(FolderTest):
    PROMISED = ["version", "valid", "inverted", "degenerate", "duplicate_tets", "nonconforming_faces", "nonmanifold_edges",
                "nonmanifold_vertices", "volume", "min_dihedral_deg", "mean_ratio"]

    def expect(self, mesh, code, strict=None, **counts):
        """The exit code without and with --strict, and counts of the report."""
        path = self.write(mesh)
        strict = code if strict is None else strict
        for options, expected in (([], code), (["--strict"], strict)):
            report = report_of("check", path, *options, code=expected)
            self.assertEqual(report["valid"], expected == 0)
            for key in self.PROMISED:
                self.assertIn(key, report)
            for key, value in counts.items():
                self.assertEqual(report[key], value, key)
            text = run("check", path, *options, code=expected).decode()
            self.assertEqual("INVALID" in text, expected != 0, text)
        return report

    def test_a_good_mesh(self):
        report = self.expect(TinyVtu(3), 0, inverted=0, degenerate=0, duplicate_tets=0, nonconforming_faces=0,
                             nonmanifold_edges=0, nonmanifold_vertices=0, volume=27.0, tets=162, points=64,
                             boundary_triangles=108)
        self.assertAlmostEqual(report["min_dihedral_deg"], 45, places=9)
        for key in ("min", "p1", "mean"):
            self.assertTrue(0.7 < report["mean_ratio"][key] < 0.8)

    def test_inverted_cells(self):
        report = self.expect(set_value("Points", 3 * 62, 10.0), INVALID)
        self.assertGreater(report["inverted"], 0)
        self.assertGreater(report["nonconforming_faces"], 0)

    def test_duplicate_cells(self):
        mesh = TinyVtu(2)
        mesh.tets.append(mesh.tets[5][::-1])
        self.expect(rebuilt(mesh), INVALID, duplicate_tets=1)

    def test_faces_with_three_cells(self):
        mesh = two_tets(3)
        mesh.points.append((0.1, -0.1, -2))
        mesh.tets.append([0, 2, 1, 5])
        report = self.expect(rebuilt(mesh), INVALID, duplicate_tets=0)
        self.assertGreater(report["nonconforming_faces"], 0)

    def test_degenerate_cells_are_a_warning(self):
        mesh = TinyVtu(1)  # the square x = 0 as a flat tetrahedron on the two triangles of that side
        mesh.tets.append([0, 2, 6, 4])
        self.expect(rebuilt(mesh), 0, strict=INVALID, degenerate=1, inverted=0, duplicate_tets=0, nonconforming_faces=0)

    def test_a_boundary_that_is_no_manifold_is_a_warning(self):
        self.expect(two_tets(2), 0, strict=INVALID, nonmanifold_edges=1)
        self.expect(two_tets(1), 0, strict=INVALID, nonmanifold_vertices=1)

    def test_cells_wound_the_other_way_are_not_inverted(self):
        mesh = TinyVtu(2)
        mesh.tets = [[t[1], t[0], t[2], t[3]] for t in mesh.tets]
        self.expect(rebuilt(mesh), 0, inverted=0, rewound=48, volume=8.0)
        self.assertIn(b"wound the other way", run("check", self.folder / "mesh.vtu"))

    def test_ids_out_of_range_and_coordinates_that_are_not_finite(self):
        for mesh in (set_value("connectivity", 7, 125), set_value("connectivity", 7, -1), set_value("connectivity", 0, 2**40),
                     set_value("Points", 10, float("nan")), set_value("Points", 11, float("-inf"))):
            report = self.expect(mesh, INVALID, volume=None, inverted=None)
            self.assertRegex(report["error"], r"mesh\.vtu: .*(uses point|coordinate)")
            path = self.folder / "mesh.vtu"
            self.assertEqual(run("check", path, "--quiet", code=INVALID), b"")
            for arguments in (["info", path], ["simplify", path, "-o", path], ["convert", path, self.folder / "o.vtu"]):
                run(*arguments, code=BAD)
            self.assertEqual(self.files(), ["mesh.vtu"])

    def test_points_that_no_cell_uses_may_be_anything(self):
        mesh = TinyVtu(2)
        mesh.points.append((0, 0, float("nan")))
        self.expect(rebuilt(mesh), 0, unused_points=1, points=27)

    def test_files_that_cannot_be_judged(self):
        good = TinyVtu().bytes()
        for mesh in (b"no mesh at all", good[:len(good) // 2], set_value("offsets", 3, 17).bytes(), b""):
            self.assertEqual(run("check", self.write(mesh), code=BAD), b"")
        run("check", self.folder / "missing.vtu", code=IO)
        run("check", self.folder, code=IO)
        run("check", code=USAGE)
        run("check", "a.vtu", "b.vtu", code=USAGE)

    def fix(self, path, *options, code=0):
        """The report of a repair, and that of check on the mended mesh, which agree."""
        out = self.folder / "mended.vtu"
        report = report_of("check", path, "--fix", out, *options, code=code)
        after = report_of("check", out, code=code)
        for key in after.keys() & report["fix"]["after"].keys():
            self.assertEqual(report["fix"]["after"][key], after[key], key)
        self.assertEqual(report["fix"]["valid"], code == 0)
        return out, report, after

    def test_what_can_be_mended_is(self):
        mesh = TinyVtu(4)
        good = self.write(mesh, "good.vtu")
        points, tets = len(mesh.points), len(mesh.tets)
        rewound = range(3, tets, 7)
        for i in rewound:
            mesh.tets[i][0:2] = mesh.tets[i][1::-1]
        twins = [5, 40, 41, 5]
        mesh.tets += [mesh.tets[i][::-1] for i in twins]
        mesh.points = [(50.0, 1.0, 2.0)] + mesh.points[:30] + [(float("nan"), 0.0, 0.0)] + mesh.points[30:] + [(0.0, 0.0, 0.0)]
        mesh.tets = [[v + (1 if v < 30 else 2) for v in t] for t in mesh.tets]
        mesh = rebuilt(mesh)
        mesh.array("temperature")[4] = list(map(float, range(points + 3)))
        path = self.write(mesh)
        for options in ([], ["--memory", "70M", "--threads", "1"]):
            out, report, after = self.fix(path, *options)
            self.assertIs(report["valid"], False)
            self.assertEqual([report["fix"][k] for k in ("rewound", "duplicate_tets_dropped", "unused_points_dropped")],
                             [len(rewound), len(twins), 3])
            self.assertEqual([after[k] for k in ("points", "tets", "rewound", "unused_points", "volume")],
                             [points, tets, 0, 0, 64.0])
            mended = Vtu(out)
            np.testing.assert_array_equal(mended.points, Vtu(good).points)
            np.testing.assert_array_equal(np.sort(mended.tets), np.sort(Vtu(good).tets))
            np.testing.assert_array_equal(mended.arrays["cell"]["id"][1][:, 0], np.arange(tets))
            ids = [1 + v + (v >= 30) for v in range(points)]
            np.testing.assert_array_equal(mended.arrays["point"]["temperature"][1][:, 0], ids)
        text = run("check", path, "--fix", out).decode()
        self.assertIn(f"mended: {len(rewound)} cells rewound, 4 duplicate cells and 3 unused points dropped", text)
        self.assertEqual(text.splitlines()[-1], "Valid")
        # In its own place, and in another format.
        run("check", path, "--fix", path, "--quiet")
        self.assertEqual(path.read_bytes(), out.read_bytes())
        run("check", path, "--fix", self.folder / "mended.msh", "--quiet")
        self.assertEqual(report_of("check", self.folder / "mended.msh")["volume"], 64.0)

    def test_points_are_joined_once(self):
        """What was written has none to join, and other formats cannot be asked for it."""
        path = self.write(TinyVtu(2))
        for out in ("joined.vtu", "joined.msh"):
            self.assertIs(report_of("check", path, "--merge-points", "--fix", self.folder / out)["fix"]["valid"], True)
            run("compare", path, self.folder / out, "--merge-points", "--max-error", "0")

    def test_what_would_be_a_guess_is_not_mended(self):
        mesh = set_value("Points", 3 * 62, 10.0)
        _, report, after = self.fix(self.write(mesh), code=INVALID)
        self.assertGreater(after["inverted"], 0)
        self.assertEqual(after["inverted"], report["inverted"])
        self.assertEqual(report["fix"]["duplicate_tets_dropped"], 0)

    def test_cells_of_all_kinds_are_kept(self):
        path = self.write(mesh_of_all_sorts())
        out, report, _ = self.fix(path)
        before, after = Vtu(path), Vtu(out)
        self.assertEqual(report["fix"]["rewound"], 0)
        self.assertEqual([(t, i.tolist()) for t, i in after.others], [(t, i.tolist()) for t, i in before.others])
        for kind in ("point", "cell"):
            self.assertEqual(after.arrays[kind].keys(), before.arrays[kind].keys())

    def test_a_mesh_that_cannot_be_mended_is_not_written(self):
        path = self.write(set_value("connectivity", 7, 125))
        said = run("check", path, "--fix", self.folder / "mended.vtu", code=INVALID).decode()
        self.assertIn("mended.vtu was not written", said)
        run("check", path, "--fix", self.folder / "out.vtu", code=INVALID)
        run("check", path, "--fix", self.folder / "out.nothing", code=USAGE)
        run("check", path, "--fix", "-", code=USAGE)
        self.assertEqual(self.files(), ["mesh.vtu"])

    def test_it_says_where(self):
        mesh = TinyVtu(2)
        mesh.tets.append(mesh.tets[5][::-1])
        centre = np.array([mesh.points[v] for v in mesh.tets[5]]).mean(axis=0)
        path = self.write(rebuilt(mesh))
        for options in ([], ["--memory", "70M", "--threads", "1"]):
            sample = report_of("check", path, *options, code=INVALID)["samples"]["duplicate_tets"]
            self.assertEqual(sample, {"cells": [48], "at": [centre.tolist()]})
        self.assertIn("cells 48; the first at ({:.9g}, {:.9g}, {:.9g})".format(*centre),
                      run("check", path, code=INVALID).decode())

    def test_the_report_as_a_file(self):
        path, report = self.write(TinyVtu()), self.folder / "report.json"
        self.assertIn(b"Valid", run("check", path, "--report", report))
        self.assertTrue(json.loads(report.read_text())["valid"])
        run("check", path, "--report", self.folder / "no" / "r.json", code=IO)


if __name__ == "__main__":
    main()
