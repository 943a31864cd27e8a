#!/usr/bin/env python3
"""What check says about good and bad meshes. Usage: check_test.py TETFUSION"""
import json

from harness import BAD, INVALID, IO, USAGE, FolderTest, main, report_of, run
from sample_meshes import rebuilt, set_value, two_tets
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

    def test_the_report_as_a_file(self):
        path, report = self.write(TinyVtu()), self.folder / "report.json"
        self.assertIn(b"Valid", run("check", path, "--report", report))
        self.assertTrue(json.loads(report.read_text())["valid"])
        run("check", path, "--report", self.folder / "no" / "r.json", code=IO)


if __name__ == "__main__":
    main()
