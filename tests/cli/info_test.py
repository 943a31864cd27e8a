#!/usr/bin/env python3
"""What info says about a mesh. Usage: info_test.py TETFUSION"""
import json
import os
import shutil
import subprocess

import numpy as np

from harness import BAD, MEMORY, FolderTest, command, finish, main, report_of, run
from independent_check import Vtu
from sample_meshes import rebuilt
from tiny_vtu import TinyVtu


ASCII_CELL = """<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian"><UnstructuredGrid>
<Piece NumberOfPoints="{points}" NumberOfCells="1">
<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">{xyz}</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">{ids}</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">{points}</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">{type}</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>
"""


class Info(FolderTest):
    def test_what_it_says(self):
        path = self.generate("--time", "2.5", "--double")
        report = report_of("info", path)
        for key in ("version", "path", "format", "file_bytes", "points", "tets", "boundary_triangles", "volume",
                    "bounding_box", "arrays", "pieces"):
            self.assertIn(key, report)
        self.assertEqual((report["point_type"], report["pieces"]), ("Float64", 1))
        self.assertEqual(report["file_bytes"], path.stat().st_size)
        arrays = {(a["association"], a["name"]): a for a in report["arrays"]}
        self.assertEqual(arrays["cell", "region"]["ranges"], [[1, 4]])
        self.assertEqual(arrays["point", "velocity"]["components"], 3)
        self.assertEqual(arrays["field", "TimeValue"]["ranges"], [[2.5, 2.5]])
        mesh = Vtu(path)
        self.assertEqual((report["points"], report["tets"]), (len(mesh.points), len(mesh.tets)))
        np.testing.assert_allclose(report["bounding_box"], [mesh.points.min(axis=0), mesh.points.max(axis=0)])
        text = run("info", path).decode()
        for word in ("temperature", "velocity", "region", "TimeValue", "Float64", "bounding box", "boundary", f"{report['tets']:,}"):
            self.assertIn(word, text)

    def test_what_steers_and_which_regions_are_kept_by_default(self):
        """As simplify says it."""
        mesh, out = TinyVtu(), self.folder / "out.vtu"
        mesh.arrays.insert(0, ["PointData", "flat", "Float64", 1, [2.5] * len(mesh.points)])
        for name, regions in (("id", []), ("material", ["material"])):
            mesh.arrays[2][1] = name
            path = self.write(mesh)
            report = report_of("info", path)
            plan = report_of("simplify", path, "-o", out, "--reduction", "10%", "--dry-run")
            self.assertEqual((report["steering"], report["regions"]), (["temperature"], regions))
            self.assertEqual((plan["steering"], plan["regions"]), (["temperature"], regions))
            text = run("info", path).decode()
            self.assertIn(f"\nsteering      temperature\nregions       {''.join(regions) or 'none'}\n", text)
        mesh.array("temperature")[4] = [1.0] * len(mesh.points)
        self.assertEqual(report_of("info", self.write(mesh))["steering"], [])

    def test_ranges_have_digits_that_tell_their_ends_apart(self):
        mesh = TinyVtu()
        count = len(mesh.points)
        for name, kind, values, told in (
                ("pressure", "Float64", [101325 + 3e-4 * (i % 2) for i in range(count)], "101325 .. 101325.0003"),
                ("short", "Float64", [0.1 * (i % 2) for i in range(count)], "0 .. 0.1"),
                ("number", "Int32", [1234567 + i % 2 for i in range(count)], "1234567 .. 1234568"),
                ("same", "Int64", [123456789] * count, "123456789 everywhere")):
            mesh.arrays[0][1:] = name, kind, 1, values
            self.assertRegex(run("info", self.write(mesh)).decode(), rf"{name} +{kind} +{told}\n")
        mesh.arrays[0][1:] = "far", "Int64", 1, [2**60 + i % 2 for i in range(count)]
        path = self.write(mesh)
        self.assertIn(", rounded\n", run("info", path).decode())
        self.assertIsNone(next(a for a in report_of("info", path)["arrays"] if a["name"] == "far")["constant"])
        empty = TinyVtu().bytes().replace(b"<Piece", b'<FieldData><DataArray type="Float64" Name="nothing" NumberOfTuples="0" format="ascii">'
                                          b"</DataArray></FieldData><Piece", 1)
        self.assertRegex(run("info", self.write(empty)).decode(), r"nothing +Float64 +empty\n")

    def test_what_is_odd(self):
        mesh = TinyVtu(2)
        mesh.points.append((5, 5, 5))
        mesh.tets.append(mesh.tets[0])
        path = self.write(rebuilt(mesh))
        text = run("info", path).decode()
        self.assertIn("duplicate cells: 1", text)
        self.assertIn("unused points: 1", text)
        self.assertEqual(report_of("info", path)["duplicate_tets"], 1)
        self.assertIn("odd           nothing", run("info", self.write(TinyVtu())).decode())

    def test_cells_with_points_of_their_own_can_be_joined(self):
        mesh = TinyVtu(1)
        self.assertNotIn("--merge-points", run("info", self.write(mesh)).decode())
        mesh.points = [mesh.points[v] for t in mesh.tets for v in t]
        mesh.tets = [tuple(range(4 * t, 4 * t + 4)) for t in range(len(mesh.tets))]
        text = run("info", self.write(rebuilt(mesh))).decode()
        self.assertRegex(text, r"parts +\d+, connected by faces: each tetrahedron has points of its own \(--merge-points\)\n")

    def test_wide_arrays_and_odd_names_keep_to_their_columns(self):
        mesh = TinyVtu(1)
        mesh.arrays.insert(1, ["PointData", "of&#10;two", "Float32", 12, [1] * 12 * len(mesh.points)])
        self.assertIn("  point of?two       Float32 x 12 length 3.4641", run("info", self.write(mesh)).decode())

    def test_what_there_is_one_of(self):
        path = self.write(ASCII_CELL.format(points=4, xyz="0 0 0 1 0 0 0 1 0 0 0 1", ids="0 1 2 3", type=10).encode())
        text = run("info", path).decode()
        self.assertIn("\ncells         1 tetrahedron\n", text)
        self.assertIn("boundary      4 triangles, 4 points (100.0 % of all), 1 surface, Euler number 2", text)
        self.assertIn(": 4 points, 1 tetrahedron, 4 boundary triangles\n", run("check", path).decode())
        said = finish("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "10%").stderr.decode()
        self.assertIn(": 1 tetrahedron -> ", said)

    def test_groups_of_gmsh_are_tags_of_a_dimension(self):
        path = self.folder / "mesh.msh"
        path.write_text("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n3 20 \"rock\"\n2 7 \"both\"\n3 9 \"both\"\n"
                        "$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
                        "$Elements\n1\n1 4 2 20 1 1 2 3 4\n$EndElements\n")
        text = run("info", path).decode()
        self.assertRegex(text, r"gmsh:physical:rock +Int32 x 2 +group 20 of dimension 3\n")
        self.assertRegex(text, r"gmsh:physical:both +Int32 x 2 +group 7 of dimension 2, group 9 of dimension 3\n")
        groups = {a["name"]: a.get("groups") for a in report_of("info", path)["arrays"]}
        self.assertEqual(groups["gmsh:physical:both"], [{"tag": 7, "dimension": 2}, {"tag": 9, "dimension": 3}])
        self.assertIsNone(groups["gmsh:physical"])

    def test_texts(self):
        texts = ["fluid", "Größe\n" + 80 * "ö"]
        bytes_of = b"\0".join(t.encode() for t in [*texts, ""])
        field = (b'<FieldData><Array type="String" Name="parts" NumberOfTuples="2" format="ascii">'
                 + b" ".join(b"%d" % b for b in bytes_of) + b"</Array></FieldData>")
        path = self.write(TinyVtu().bytes().replace(b"<UnstructuredGrid>", b"<UnstructuredGrid>" + field))
        self.assertEqual(report_of("info", path)["arrays"][-1]["texts"], texts)
        line = next(line for line in run("info", path).decode().splitlines() if " parts " in line)
        self.assertRegex(line, "String  +fluid, Größe ö{22} \\.\\.\\.$")

    def test_names_that_are_no_json(self):
        mesh = TinyVtu(1)
        mesh.array("temperature")[1] = 'a"\\b'.replace('"', "&quot;")
        report = report_of("info", self.write(mesh))
        self.assertIn('a"\\b', [a["name"] for a in report["arrays"]])

    def test_arrays_of_strings_and_bits_are_left_out(self):
        text = TinyVtu(encoding="ascii").bytes()
        odd = (b'<Array type="String" Name="label" format="ascii">112 0</Array>'
               b'<DataArray type="Bit" Name="bits" format="ascii">1</DataArray>')
        start = text.index(b">", text.index(b"<PointData")) + 1
        path = self.write(text[:start] + odd + text[start:])
        self.assertEqual(report_of("info", path)["unread_arrays"], ["label", "bits"])
        self.assertIn(b"not read      label, bits", run("info", path))
        plain = self.write(TinyVtu(encoding="ascii"), "plain.vtu")
        for name in ("o.vtu", "o.pvtu", "o.mesh"):
            said = finish("simplify", path, "-o", self.folder / name, "--reduction", "20%").stderr
            self.assertIn(b"these arrays have strings or bits, and are left out: label, bits", said)
        run("simplify", plain, "-o", self.folder / "p.vtu", "--reduction", "20%")
        self.assertEqual((self.folder / "p.vtu").read_bytes(), (self.folder / "o.vtu").read_bytes())

    def test_a_pvtu_with_cells_to_split_is_read_through_vtk(self):
        corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
        self.write(ASCII_CELL.format(points=8, xyz=" ".join(f"{x} {y} {z}" for x, y, z in corners), ids="0 1 2 3 4 5 6 7",
                                     type=12).encode(), "hexahedron.vtu")
        path = self.write(b'<VTKFile type="PUnstructuredGrid" version="1.0"><PUnstructuredGrid GhostLevel="0">'
                          b'<PPoints><PDataArray type="Float32" NumberOfComponents="3"/></PPoints>'
                          b'<Piece Source="hexahedron.vtu"/></PUnstructuredGrid></VTKFile>', "hexahedra.pvtu")
        what = ".pvtu with cells to split or straighten"
        alone = self.folder / "without" / "tetfusion"  # no module beside it
        alone.parent.mkdir()
        shutil.copy(command(), alone)
        said = subprocess.run([alone, "info", path, "--tetrahedralize"], capture_output=True, timeout=300)
        self.assertEqual(said.returncode, BAD)
        self.assertIn(f"hexahedra.pvtu: this is a {what}. Only", said.stderr.decode())
        with_module = finish("info", path, "--tetrahedralize", "--report", "-")
        if with_module.returncode == 0:  # where the module is built
            self.assertEqual(json.loads(with_module.stdout)["format"], f"{what}, read with VTK")
        else:
            self.assertIn(b"is not installed", with_module.stderr)

    def test_cells_that_are_to_be_split_or_straightened(self):
        """What is in such a file is told, and what other commands need for it."""
        corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
        edges = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
        four = [corners[i] for i in (0, 1, 3, 4)]
        ten = four + [tuple((p + q) / 2 for p, q in zip(four[a], four[b])) for a, b in edges]
        for points, kind, needs, tets in ((corners, 12, ["--tetrahedralize"], (5, 6)), (ten, 24, ["--linearize"], (1,))):
            path = self.write(ASCII_CELL.format(points=len(points), xyz=" ".join(f"{x} {y} {z}" for x, y, z in points),
                                                ids=" ".join(map(str, range(len(points)))), type=kind).encode())
            report = report_of("info", path)
            self.assertEqual(report["needs"], needs)
            self.assertIn(report["tets"], tets)
            self.assertIn(f"read with     {needs[0]}, without which".encode(), run("info", path))
            self.assertEqual(report_of("info", path, *needs)["needs"], [])
            self.assertEqual(finish("check", path).returncode, BAD)
            run("info", path, "--memory", "1M", code=MEMORY)  # and not: what these cells need
        damaged = TinyVtu(1)
        damaged.array("connectivity")[4][0] = 999
        said = finish("info", self.write(damaged))
        self.assertEqual((said.returncode, b"--tetrahedralize" in said.stderr), (BAD, False))

    def test_values_that_are_not_finite(self):
        mesh = TinyVtu(1)
        mesh.array("temperature")[4][2] = float("nan")
        report = report_of("info", self.write(mesh))
        self.assertEqual(report["arrays"][0]["non_finite"], 1)

    def test_an_input_in_a_folder_that_may_not_be_written(self):
        folder = self.folder / "read_only"
        folder.mkdir()
        (folder / "mesh.vtu").write_bytes(TinyVtu().bytes())
        folder.chmod(0o555)
        self.addCleanup(folder.chmod, 0o755)
        run("info", folder / "mesh.vtu")
        run("check", folder / "mesh.vtu")
        run("simplify", folder / "mesh.vtu", "-o", self.folder / "out.vtu")
        self.assertEqual(os.listdir(folder), ["mesh.vtu"])


if __name__ == "__main__":
    main()
