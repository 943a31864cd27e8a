#!/usr/bin/env python3
"""Conversions between formats and encodings. Usage: convert_test.py TETFUSION"""
import pathlib
import struct

import numpy as np

from harness import BAD, INVALID, IO, USAGE, FolderTest, command, finish, main, report_of, run
from independent_check import Vtu
from sample_meshes import HEXAHEDRA, STRUCTURED, mesh_of_all_sorts
from tiny_vtu import TinyVtu


class Convert(FolderTest):
    def assert_same(self, before, after):
        """`after` has the tetrahedra of `before` first, then its other cells, each with its values."""
        np.testing.assert_array_equal(before.points, after.points)
        np.testing.assert_array_equal(before.tets, after.tets)
        self.assertEqual([(k, list(ids)) for k, ids in before.others], [(k, list(ids)) for k, ids in after.others])
        for association in ("point", "cell"):
            self.assertEqual(list(before.arrays[association]), list(after.arrays[association]))
            for name, (info, values) in before.arrays[association].items():
                self.assertEqual(info, after.arrays[association][name][0], name)
                if association == "cell":
                    values = np.concatenate([values[2:-1], values[:2], values[-1:]]) if before.others else values
                np.testing.assert_array_equal(values, after.arrays[association][name][1], name)

    def test_round_trips_through_every_encoding(self):
        original = self.write(mesh_of_all_sorts())
        raw, back, coded = self.folder / "raw.vtu", self.folder / "back.vtu", self.folder / "coded.vtu"
        run("convert", original, raw)
        self.assert_same(Vtu(original), Vtu(raw))
        for encoding in ("raw", "zlib", "lz4", "inline", "ascii"):
            run("convert", original, coded, "--encoding", encoding)
            if encoding != "lz4":
                self.assert_same(Vtu(original), Vtu(coded))
            run("convert", coded, back)
            self.assertEqual(back.read_bytes(), raw.read_bytes(), encoding)

    def test_says_which_ghosts_it_leaves_out(self):
        mesh = TinyVtu()
        cells, points = [0] * len(mesh.tets), [0] * len(mesh.points)
        cells[5], points[0] = 32, 2
        mesh.arrays.insert(0, ["PointData", "vtkGhostType", "UInt8", 1, points])
        mesh.arrays.insert(2, ["CellData", "vtkGhostType", "UInt8", 1, cells])
        path = self.write(mesh)
        for name in ("out.vtu", "out.vtk", "out.msh"):
            told = finish("convert", path, self.folder / name)
            self.assertEqual(told.returncode, 0)
            self.assertIn(b"1 ghost or hidden cell (vtkGhostType) was dropped", told.stderr, name)
            self.assertIn(b"marks of what is hidden, or another piece's, are left out: vtkGhostType, cell:vtkGhostType", told.stderr)
        told = finish("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "10%")
        self.assertIn(b"marks of what is hidden", told.stderr)

    def test_says_so_where_cells_alone_have_marks(self):
        mesh = TinyVtu()
        mesh.arrays.insert(0, ["CellData", "vtkGhostType", "UInt8", 1, [2] * len(mesh.tets)])
        told = finish("convert", self.write(mesh), self.folder / "out.vtu")
        self.assertIn(b"another piece's, are left out: cell:vtkGhostType", told.stderr)

    def test_labels_are_the_array_that_was_named(self):
        """Also before those that the mesh has of another format."""
        mesh = TinyVtu()
        values = [1 + i % 2 for i in range(len(mesh.tets))]
        mesh.array("id")[1:] = "scalars", "UInt8", 1, values
        mesh.arrays.insert(2, ["CellData", "gmsh:physical", "Int32", 1, [9] * len(values)])
        path, back = self.write(mesh), self.folder / "back.vtu"
        for suffix, name in ((".mesh", "medit:ref"), (".msh", "gmsh:physical"), (".node", "tetgen:ref")):
            out = self.folder / ("out" + suffix)
            for options, expected in (([], [9] * len(values)), (["--labels", "scalars"], values), (["--labels", "cell:scalars"], values)):
                told = finish("convert", path, out, *options)
                self.assertEqual(told.returncode, 0, told.stderr)
                self.assertEqual(b"gmsh:physical" in told.stderr, bool(options), told.stderr)
                run("convert", out, back)
                self.assertEqual(Vtu(back).arrays["cell"][name][1].ravel().tolist(), expected, (suffix, options))
        for name in ("none", "temperature", ""):
            run("convert", path, self.folder / "out.mesh", "--labels", name, code=USAGE)
        self.assertIn(b"--labels none: there is no cell array of numbers of one component with that name; there are: scalars, gmsh:physical",
                      finish("convert", path, self.folder / "out.mesh", "--labels", "none").stderr)

    def test_labels_that_were_named_and_cannot_be_are_refused(self):
        mesh = TinyVtu()
        material = [1 + i % 2 for i in range(len(mesh.tets))]
        mesh.array("id")[1:] = "material", "Int32", 1, material
        mesh.arrays.insert(2, ["CellData", "tissue", "Float64", 1, [1, 2.5] + material[2:]])
        path = self.write(mesh)
        for suffix, place in ((".mesh", "references"), (".msh", "physical groups"), (".node", "attributes")):
            out = self.folder / ("out" + suffix)
            refused = finish("convert", path, out, "--labels", "tissue")
            self.assertEqual(refused.returncode, USAGE)
            self.assertIn(f"--labels tissue: cannot be the {place} of {out}: its value 2.5 is no whole number".encode(), refused.stderr)
            self.assertEqual(self.files(), ["mesh.vtu"])

    def test_says_what_it_has_done(self):
        path = self.write(TinyVtu())
        for name in ("out.vtu", "out.mesh", "out.node", "-"):
            out = name if name == "-" else self.folder / name
            told = finish("convert", path, out)
            self.assertRegex(told.stderr.decode(), rf"(?m)^(tetfusion: )?{path}: {len(TinyVtu().tets):,} tetrahedra -> {out} in \d+\.\d\d s$")
            self.assertEqual(told.stdout[:5], b"<?xml" if name == "-" else b"")
            self.assertEqual(finish("convert", path, out, "--quiet").stderr, b"")

    def test_an_array_whose_name_is_empty_gets_one(self):
        mesh, out = TinyVtu(), self.folder / "out.vtu"
        mesh.array("temperature")[1] = ""
        run("simplify", self.write(mesh), "-o", out, "--reduction", "20%", "--verify")
        self.assertEqual([*Vtu(out).arrays["point"]], ["unnamed_0"])

    def test_onto_itself(self):
        path = self.write(mesh_of_all_sorts())
        original = Vtu(path)
        path.chmod(0o640)
        for encoding in ("zlib", "raw"):
            run("convert", path, path, "--encoding", encoding)
            self.assertEqual(path.stat().st_mode & 0o777, 0o640)
        self.assert_same(original, Vtu(path))
        self.assertEqual(self.files(), ["mesh.vtu"])

    def test_a_failed_conversion_leaves_the_output_alone(self):
        out = self.write(b"precious", "out.vtu")
        run("convert", self.write(TinyVtu().bytes()[:2000]), out, code=BAD)
        run("convert", self.folder / "missing.vtu", out, code=IO)
        self.assertEqual(out.read_bytes(), b"precious")
        self.assertEqual(self.files(), ["mesh.vtu", "out.vtu"])

    def test_bad_outputs(self):
        path = self.write(TinyVtu())
        run("convert", path, self.folder / "no" / "out.vtu", code=IO)
        (self.folder / "folder.vtu").mkdir()
        run("convert", path, self.folder / "folder.vtu", code=IO)
        run("convert", path, "/dev/full", code=IO)
        refused = finish("convert", path, self.folder / "out_{lod}.msh")
        self.assertEqual(refused.returncode, USAGE)
        self.assertIn(b"holds {lod}", refused.stderr)
        run("convert", path, code=USAGE)

    def test_hexahedra_in_a_vtu(self):
        mesh = TinyVtu(1)
        mesh.arrays = [a for a in mesh.arrays if a[1] != "id"]
        mesh.array("connectivity")[4] = [0, 1, 3, 2, 4, 5, 7, 6] + [1, 3, 7, 5] + [0, 1, 2, 3]
        mesh.array("offsets")[4] = [8, 12, 16]
        mesh.array("types")[4] = [12, 9, 8]
        mesh.counts["NumberOfCells"] = "3"
        mesh.arrays.insert(1, ["CellData", "ids", "Int64", 1, [1, 2, 3]])
        path, out = self.folder / "mesh.vtu", self.folder / "out.vtu"
        path.write_bytes(mesh.bytes().replace(b"<CellData>", b'<CellData GlobalIds="ids">'))
        result = finish("convert", path, out)
        self.assertEqual(result.returncode, BAD)
        self.assertIn(b"--tetrahedralize", result.stderr)
        self.assertFalse(out.exists())
        run("convert", path, out, "--tetrahedralize")
        report = report_of("check", out, "--strict")
        self.assertEqual((report["volume"], report["lower_cells"], report["boundary_triangles"]), (1.0, 4, 12))
        ids = next(a for a in report_of("info", out)["arrays"] if a["name"] == "ids")
        self.assertEqual(ids["active"], ["PedigreeIds"])  # the parts of a cell have one number
        faces = {frozenset(np.delete(t, k).tolist()) for t in Vtu(out).tets for k in range(4)}
        for kind, ids in Vtu(out).others:
            self.assertEqual(kind, 5)
            self.assertIn(frozenset(ids.tolist()), faces, "a carried triangle is no face")


def with_own_points(mesh):
    """The same cells, each with points of its own."""
    corners = mesh.array("connectivity")[4]
    for section, name, kind, width, old in list(mesh.arrays):
        if section in ("PointData", "Points"):
            mesh.array(name)[4] = [x for v in corners for x in old[width * v:width * v + width]]
    mesh.array("connectivity")[4] = list(range(len(corners)))
    mesh.counts["NumberOfPoints"] = str(len(corners))
    return mesh


def hexahedra(n):
    """n^3 of them, whose points are in an order of their own, so that the smallest of a face is anywhere."""
    mesh = TinyVtu(n)
    number = np.random.default_rng(5).permutation(len(mesh.points))
    place = np.argsort(number)
    for name in ("temperature", "Points"):
        values = np.array(mesh.array(name)[4]).reshape(len(place), -1)
        mesh.array(name)[4] = values[place].ravel().tolist()
    at = lambda x, y, z: int(number[x + (n + 1) * (y + (n + 1) * z)])
    order = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    cells = [[at(x + i, y + j, z + k) for i, j, k in order] for z in range(n) for y in range(n) for x in range(n)]
    mesh.remove("id")
    mesh.array("connectivity")[4] = [v for cell in cells for v in cell]
    mesh.array("offsets")[4] = list(range(8, 8 * len(cells) + 1, 8))
    mesh.array("types")[4] = [12] * len(cells)
    mesh.counts["NumberOfCells"] = str(len(cells))
    return mesh


class MergedPoints(FolderTest):
    """Cells with points of their own, and --merge-points."""

    def places(self, mesh):
        """The tetrahedra, by the places of their corners."""
        return sorted(sorted(map(tuple, mesh.points[tet].tolist())) for tet in mesh.tets)

    def test_tetrahedra(self):
        shared, own = self.write(TinyVtu(6), "shared.vtu"), self.write(with_own_points(TinyVtu(6)), "own.vtu")
        counts = report_of("info", shared)
        apart, merged = report_of("info", own), report_of("info", own, "--merge-points")
        self.assertEqual((apart["points"], apart["boundary_triangles"]), (4 * counts["tets"], 4 * counts["tets"]))
        self.assertEqual([merged[k] for k in ("points", "tets", "boundary_triangles")],
                         [counts[k] for k in ("points", "tets", "boundary_triangles")])
        joined, legacy = self.folder / "joined.vtu", self.folder / "own.vtk"
        run("convert", own, joined, "--merge-points")
        self.assertEqual(self.places(Vtu(joined)), self.places(Vtu(shared)))
        run("convert", own, legacy)
        expected = self.folder / "expected.vtu"
        run("simplify", joined, "-o", expected, "--reduction", "60%")
        for path, more in ((own, []), (own, ["--threads", "2", "--memory", "2G", "--verify"]), (legacy, [])):
            out = self.folder / "out.vtu"
            said = finish("simplify", path, "-o", out, "--reduction", "60%", "--merge-points", *more)
            self.assertEqual(said.returncode, 0, said.stderr)
            self.assertIn(b"points in the places of others were merged with them", said.stderr)
            self.assertEqual(Vtu(out).points.tolist(), Vtu(expected).points.tolist())
            self.assertEqual(Vtu(out).tets.tolist(), Vtu(expected).tets.tolist())

    def test_values_are_those_of_the_first(self):
        mesh = with_own_points(TinyVtu(1))
        first = {}
        for i in range(int(mesh.counts["NumberOfPoints"])):
            first.setdefault(tuple(mesh.array("Points")[4][3 * i:3 * i + 3]), i)
        mesh.array("temperature")[4] = list(range(int(mesh.counts["NumberOfPoints"])))
        mesh.arrays.insert(1, ["PointData", "GlobalNodeIds", "Int64", 1, mesh.array("temperature")[4]])  # which tell all apart
        out = self.folder / "out.vtu"
        run("convert", self.write(mesh), out, "--merge-points")
        made = Vtu(out)
        found = dict(zip(map(tuple, made.points.tolist()), np.squeeze(made.arrays["point"]["temperature"][1]).tolist(), strict=True))
        self.assertEqual(found, first)

    def test_hexahedra_are_cut_alike_from_both_sides(self):
        shared, own = self.write(hexahedra(3), "shared.vtu"), self.write(with_own_points(hexahedra(3)), "own.vtu")
        report = report_of("check", own, "--tetrahedralize", "--merge-points")
        counts = report_of("check", shared, "--tetrahedralize")
        self.assertEqual([(r["valid"], r["points"], r["boundary_triangles"], r["components"]) for r in (report, counts)],
                         [(True, 64, 108, 1)] * 2)
        self.assertEqual(report_of("check", own, "--tetrahedralize")["components"], 27)

    def test_formats_that_number_points(self):
        path, mesh = self.write(TinyVtu()), self.folder / "a.mesh"
        run("convert", path, mesh)
        said = finish("info", mesh, "--merge-points")
        self.assertEqual(said.returncode, USAGE)
        self.assertIn(b"convert the mesh to .vtu first", said.stderr)
        said = finish("simplify", path, "-o", self.folder / "o.vtu", "--progressive", self.folder / "p.tfp", "--merge-points", "--reduction", "10%")
        self.assertEqual(said.returncode, USAGE)


class DroppedPatches(FolderTest):
    """Cells of lower dimension, and --drop-patches."""

    def sample(self):
        """Triangles on one side, a line, and a vertex with a point of its own, before, among and behind the tetrahedra."""
        mesh = TinyVtu(4)
        side = [v for v, p in enumerate(mesh.points) if p[2] == 0]
        patch = [[v for v in t if v in side] for t in mesh.tets]
        tets = [(10, t) for t in mesh.tets]
        cells = [(5, f) for f in patch if len(f) == 3] + tets[:50] + [(3, [0, 1])] + tets[50:] + [(1, [len(mesh.points)])]
        mesh.points.append((9.0, 9.0, 9.0))
        flat = {"temperature": [float(v) for v in range(len(mesh.points))], "id": list(range(len(cells))),
                "Points": [c for p in mesh.points for c in p], "connectivity": [v for _, ids in cells for v in ids],
                "offsets": np.cumsum([len(ids) for _, ids in cells]).tolist(), "types": [kind for kind, _ in cells]}
        for name, values in flat.items():
            mesh.array(name)[4] = values
        mesh.counts = {"NumberOfPoints": str(len(mesh.points)), "NumberOfCells": str(len(cells))}
        return mesh

    def expect_tetrahedra_alone(self, path, points, tets, *options):
        keys = ("points", "tets", "lower_cells", "boundary_triangles", "volume", "components")
        expected = [points, tets, 0, 192, 64.0, 1]
        self.assertGreater(report_of("info", path, *options)["lower_cells"], 30)
        for command in ("info", "check"):
            for memory in ([], ["--memory", "70M", "--threads", "1"]):
                found = report_of(command, path, "--drop-patches", *options, *memory)
                self.assertEqual([found[k] for k in keys], expected, (command, path, memory))
        out = self.folder / "out.vtu"
        run("convert", path, out, "--drop-patches", *options)
        self.assertEqual((len(Vtu(out).others), len(Vtu(out).tets)), (0, tets))
        mended = report_of("check", path, "--drop-patches", *options, "--fix", out)["fix"]
        self.assertTrue(mended["valid"])
        self.assertEqual((len(Vtu(out).others), len(Vtu(out).tets), len(Vtu(out).points)), (0, tets, points))
        return Vtu(out)

    def test_every_command_has_it(self):
        mesh = self.sample()
        original, points, tets = self.write(mesh), len(mesh.points) - 1, len(mesh.tets)
        for suffix in (".vtu", ".vtk", ".mesh", ".meshb", ".msh"):
            path = self.folder / ("in" + suffix)
            run("convert", original, path)
            mended = self.expect_tetrahedra_alone(path, points, tets)
            np.testing.assert_array_equal(mended.points, mesh.points[:-1])
        # As the file is, rows of cells lie between those of others.
        mended = self.expect_tetrahedra_alone(original, points, tets)
        self.assertEqual(mended.tets.tolist(), mesh.tets)
        kinds = np.array(mesh.array("types")[4])
        self.assertEqual(mended.arrays["cell"]["id"][1][:, 0].tolist(), np.flatnonzero(kinds == 10).tolist())
        self.assertEqual(mended.arrays["point"]["temperature"][1][:, 0].tolist(), list(range(points)))
        run("convert", original, self.folder / "out.vtu", "--drop-patches")
        piped = run("convert", "-", "-", "--drop-patches", input=original.read_bytes())
        self.assertEqual(piped, (self.folder / "out.vtu").read_bytes())

    def test_one_of_them(self):
        mesh, out = self.sample(), self.folder / "out.vtu"
        kinds = np.array(mesh.array("types")[4])
        patch = np.where(kinds == 5, 1 + np.arange(len(kinds)) % 2, 7)
        mesh.arrays.insert(1, ["CellData", "patch", "Int32", 1, patch.tolist()])
        path, all_of = self.write(mesh), np.count_nonzero(kinds != 10)
        for suffix in (".vtu", ".vtk"):
            path = self.folder / ("in" + suffix)
            run("convert", self.write(mesh), path)
            for patches, gone in ((["patch=1"], (kinds == 5) & (patch == 1)), (["patch=2", "patch=1"], kinds == 5),
                                  (["patch=7", "patch=7"], np.isin(kinds, (1, 3)))):
                options = [word for name in patches for word in ("--drop-patch", name)]
                run("convert", path, out, *options)
                kept = Vtu(out)
                self.assertEqual((len(kept.others), len(kept.tets)), (all_of - np.count_nonzero(gone), len(mesh.tets)))
                self.assertEqual(sorted(kept.arrays["cell"]["id"][1][:, 0]), sorted(np.flatnonzero(~gone)))
                for memory in ([], ["--memory", "70M", "--threads", "1"]):
                    self.assertEqual(report_of("info", path, *options, *memory)["lower_cells"], len(kept.others))
                simplify = ["simplify", path, "-o", out, "--boundary", "planar", "--reduction", "80%", "--regions", "none", *options]
                run(*simplify)
                self.assertEqual(len(Vtu(out).others), len(kept.others))
        # What is left out is not looked for in what was made without it.
        dropped = ["--drop-patch", "patch=1"]
        run("simplify", path, "-o", out, "--reduction", "0%", *dropped)
        run("compare", path, out, *dropped)
        self.assertIs(report_of("check", path, "--fix", self.folder / "fixed.vtu", *dropped)["fix"]["valid"], True)
        for name in ("wall", "patch=x", "path=1", "Points=1", "patch"):
            said = finish("info", path, "--drop-patch", name)
            self.assertEqual(said.returncode, USAGE)
            self.assertIn(f"--drop-patch {name}: the mesh has no named blocks; of a cell array".encode(), said.stderr)
        bare = self.folder / "bare.vtu"
        run("convert", path, bare, "--drop-patches")
        said = finish("convert", path, bare, "--drop-patches", "--drop-patch", "patch=1")
        self.assertEqual(said.returncode, USAGE)
        self.assertIn(b"--drop-patches leaves out all patches", said.stderr)
        for mesh in (path, bare):
            for command in (["info", mesh], ["convert", mesh, out], ["simplify", mesh, "-o", out, "--reduction", "80%"]):
                said = finish(*command, "--drop-patch", "patch=2", "--drop-patch", "patch=9")
                self.assertEqual(said.returncode, USAGE)
                self.assertRegex(said.stderr.decode(), "--drop-patch patch=[29]: no triangle, line or point of the mesh has that")

    def test_pieces(self):
        path = self.folder / "pieces.pvtu"
        run("simplify", self.write(self.sample()), "-o", path, "--pieces", "3", "--reduction", "0%", "--chunk-tets", "60")
        self.expect_tetrahedra_alone(path, 125, 384)

    def add_cell(self, mesh, kind, points):
        mesh.array("types")[4].append(kind)
        mesh.array("connectivity")[4] += points
        mesh.array("offsets")[4].append(len(mesh.array("connectivity")[4]))
        mesh.array("id")[4].append(0)
        mesh.counts["NumberOfCells"] = str(len(mesh.array("types")[4]))

    def test_patches_of_types_that_are_not_read(self):
        """Whatever has no volume: a polyline, a polygon, a quadratic triangle, a pixel, an empty cell."""
        mesh = self.sample()
        bare = self.folder / "bare.vtu"
        run("convert", self.write(mesh), bare, "--drop-patches")
        for kind, points in (4, [0, 1, 2]), (7, [0, 1, 6, 5, 2]), (22, [0, 1, 2, 3, 4, 5]), (8, [0, 1, 5, 6]), (0, []):
            mesh = self.sample()
            self.add_cell(mesh, kind, points)
            path = self.write(mesh)
            said = finish("convert", path, self.folder / "out.vtu")
            self.assertEqual(said.returncode, BAD)
            self.assertRegex(said.stderr.decode(), "--drop-patches leaves such cells out|: use --")
            for memory in ([], ["--memory", "70M", "--threads", "1"]):
                self.assertEqual(report_of("check", path, "--drop-patches", *memory)["tets"], 384)
            run("convert", path, self.folder / "out.vtu", "--drop-patches")
            self.assertEqual((self.folder / "out.vtu").read_bytes(), bare.read_bytes(), kind)

    def test_what_is_read_whole(self):
        """Where a cell is to be split (a pyramid that names a vertex twice, so that it is one tetrahedron), a mesh is not read in windows."""
        mesh = self.sample()
        types, ids, ends = (mesh.array(name)[4] for name in ("types", "connectivity", "offsets"))
        first = types.index(10)
        types[first] = 14
        ids.insert(ends[first] - 1, ids[ends[first] - 2])
        ends[first:] = [end + 1 for end in ends[first:]]
        self.add_cell(mesh, 9, [0, 1, 6, len(mesh.points) - 1])
        path, out = self.write(mesh), self.folder / "out.vtu"
        self.assertEqual(report_of("info", path, "--drop-patches")["needs"], ["--tetrahedralize"])
        self.expect_tetrahedra_alone(path, len(mesh.points) - 1, len(mesh.tets), "--tetrahedralize")
        run("convert", path, out, "--drop-patches", "--tetrahedralize")
        self.assertEqual(len(Vtu(out).points), len(mesh.points) - 1)
        run("convert", path, out, "--drop-patches", code=BAD)
        run("simplify", path, "-o", out, "--drop-patches", "--tetrahedralize", "--reduction", "30%", "--verify", "--map", self.folder / "a.map")
        # Points are numbered without those of the patches.
        options = ["apply", self.folder / "a.map", path, "-o", self.folder / "moved.vtu", "--tetrahedralize"]
        run(*options, code=BAD)
        run(*options, "--drop-patches")
        np.testing.assert_array_equal(Vtu(self.folder / "moved.vtu").tets, Vtu(out).tets)

    def test_a_simplification_without_patches(self):
        original, out, moved = self.write(self.sample()), self.folder / "simple.vtu", self.folder / "moved.vtu"
        options = ["--reduction", "30%", "--boundary", "planar", "--drop-patches", "--original-ids", "--verify", "--quiet"]
        run("simplify", original, "-o", out, *options, "--map", self.folder / "a.map")
        self.assertEqual(len(Vtu(out).others), 0)
        bare = self.folder / "bare.vtu"
        run("convert", original, bare, "--drop-patches")
        again = self.folder / "again.vtu"
        run("simplify", bare, "-o", again, *[o for o in options if o != "--drop-patches"])
        self.assertEqual(Vtu(out).points.tolist(), Vtu(again).points.tolist())
        self.assertEqual(Vtu(out).tets.tolist(), Vtu(again).tets.tolist())
        self.assertEqual(*(Vtu(p).arrays["point"]["OriginalPointIds"][1].tolist() for p in (out, again)))
        found = [report_of("compare", original, out, *more) for more in ([], ["--drop-patches"])]
        for report in found:
            for key in ("seconds", "cpu_seconds", "peak_rss_bytes"):
                report.pop(key)
        self.assertEqual(*found)
        self.assertEqual(found[0]["outside_points"], 0)
        for more in ([], ["--drop-patches"]):
            run("apply", self.folder / "a.map", original, "-o", moved, "--quiet", *more)
            np.testing.assert_array_equal(Vtu(moved).tets, Vtu(out).tets)

    def test_the_way_back_is_that_of_a_mesh_without_them(self):
        path = self.write(self.sample())
        options = ["-o", self.folder / "out.vtu", "--progressive", self.folder / "out.tfp", "--reduction", "20%"]
        said = finish("simplify", path, *options, "--drop-patches")
        self.assertEqual(said.returncode, USAGE)
        self.assertIn(b"--drop-patches do not go together yet: convert the mesh first", said.stderr)
        run("convert", path, path, "--drop-patches")
        run("simplify", path, *options)
        run("refine", self.folder / "out.tfp", "-o", self.folder / "back.vtu")
        self.assertEqual(len(Vtu(self.folder / "back.vtu").tets), 384)


class OtherFormats(FolderTest):
    def setUp(self):
        super().setUp()
        plugin = pathlib.Path(command()).resolve().parent / "tetfusion-vtk.so"
        if not plugin.exists():
            self.skipTest(f"{plugin} is not built: VTK was not found")

    def test_hexahedra_need_the_option(self):
        for name, data in (("a.vtk", HEXAHEDRA), ("a.vts", STRUCTURED)):
            path = self.write(data, name)
            for arguments in (["check", path], ["convert", path, self.folder / "out.vtu"],
                              ["simplify", path, "-o", self.folder / "out.vtu"]):
                result = finish(*arguments)
                self.assertEqual((result.returncode, result.stdout), (BAD, b""))
                self.assertRegex(result.stderr.decode(), rf"{name}: cell 0 is a hexahedron .*--tetrahedralize")
            path.unlink()
        self.assertEqual(self.files(), [])

    def test_hexahedra_are_split(self):
        for name, data, lower, array in (("a.vtk", HEXAHEDRA, 2, ("cell", "number")),
                                         ("a.vts", STRUCTURED, 0, ("point", "height"))):
            path, out = self.write(data, name), self.folder / "out.vtu"
            before = report_of("check", path, "--tetrahedralize", "--strict")
            self.assertEqual((before["volume"], before["points"], before["lower_cells"]), (2.0, 12, lower))
            run("convert", path, out, "--tetrahedralize")
            after = report_of("check", out, "--strict")
            self.assertEqual([after[k] for k in ("volume", "tets", "points", "lower_cells", "boundary_triangles")],
                             [before[k] for k in ("volume", "tets", "points", "lower_cells", "boundary_triangles")])
            self.assertIn(array[1], Vtu(out).arrays[array[0]])
            run("simplify", path, "-o", out, "--tetrahedralize", "--reduction", "50%", "--quiet")
            self.assertEqual(report_of("check", out, "--strict")["volume"], 2.0)

    def test_legacy_grids_that_are_cut_off(self):
        """VTK warns at most, and has zeros for what is not there."""
        head = "# vtk DataFile Version 3.0\nt\n{}\nDATASET RECTILINEAR_GRID\nDIMENSIONS 9 9 9\n"
        axis, numbers = range(9), range(729)
        for form in "ASCII", "BINARY":
            def put(values):
                return struct.pack(f">{len(values)}f", *values) if form == "BINARY" else " ".join(map(str, values)).encode()
            data = head.format(form).encode()
            for name in "XYZ":
                data += f"{name}_COORDINATES 9 float\n".encode() + put(axis) + b"\n"
            data += b"POINT_DATA 729\nSCALARS a float 1\nLOOKUP_TABLE default\n" + put(numbers) + b"\n"
            options = ["--tetrahedralize", "--quiet"]
            run("convert", self.write(data, "a.vtk"), self.folder / "out.vtu", *options)
            for share in (0.3, 0.6, 0.9):
                said = finish("convert", self.write(data[:int(share * len(data))], "a.vtk"), self.folder / "cut.vtu", *options)
                self.assertEqual(said.returncode, BAD)
                self.assertIn(b"a.vtk", said.stderr)

    def test_tells_of_seams_where_values_jump(self):
        block = TinyVtu()
        block.array("temperature")[4] = [p[1] for p in block.points]
        self.write(block, "a.vtu")
        block.array("Points")[4] = [c for x, y, z in block.points for c in (x + 4, y, z)]
        block.array("temperature")[4] = [0.0] * len(block.points)
        self.write(block, "b.vtu")
        path = self.write(b"""<VTKFile type="vtkMultiBlockDataSet" version="1.0"><vtkMultiBlockDataSet>
<DataSet index="0" file="a.vtu"/><DataSet index="1" file="b.vtu"/></vtkMultiBlockDataSet></VTKFile>""", "a.vtm")
        for name in ("out.vtu", "out.msh"):
            told = finish("convert", path, self.folder / name).stderr
            self.assertIn(b"25 points in the places of others were merged with them", told)
            self.assertIn(b"20 of these had other values in some array", told)
        report = report_of("info", path)
        self.assertEqual((report["merged_points"], report["differing_points"]), (25, 20))
        told = finish("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "50%")
        self.assertIn(b"interfaces of cell array block are kept", told.stderr)

    def test_broken_indices_are_an_invalid_mesh(self):
        path = self.write(HEXAHEDRA.replace(b"8 1 2 5 4 7 8 11 10", b"8 1 2 5 4 7 8 11 12"), "a.vtk")
        report = report_of("check", path, "--tetrahedralize", code=INVALID)
        self.assertFalse(report["valid"])
        self.assertIn("cell 1 uses point 12", report["error"])
        run("simplify", path, "-o", self.folder / "out.vtu", "--tetrahedralize", "--reduction", "50%", code=BAD)

    def test_damaged_files(self):
        path = self.write(HEXAHEDRA[:300], "a.vtk")
        run("check", path, "--tetrahedralize", code=BAD)


if __name__ == "__main__":
    main()
