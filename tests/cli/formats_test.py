#!/usr/bin/env python3
"""The formats of Medit, Gmsh and TetGen from outside, and what these programs say to our files. Usage: formats_test.py
TETFUSION"""
import collections
import itertools
import shutil
import subprocess
import unittest

import numpy as np

from harness import BAD, IO, USAGE, FolderTest, finish, main, report_of, run
from independent_check import Vtu
from tiny_vtu import TinyVtu

try:
    import meshio
except ImportError:
    meshio = None

SUFFIXES = (".mesh", ".meshb", ".msh", ".node", ".vtk")

CUBE = """8 3 0 1
1 0 0 0 1
2 1 0 0 1
3 1 1 0 1
4 0 1 0 1
5 0 0 1 2
6 1 0 1 2
7 1 1 1 2
8 0 1 1 2
6 1
1 0 5
4 1 2 3 4
1 0 6
4 5 6 7 8
1 0 7
4 1 2 6 5
1 0 8
4 2 3 7 6
1 0 9
4 3 4 8 7
1 0 10
4 4 1 5 8
0
1
1 0.5 0.5 0.5 3 0.01
"""

BOX = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Box(2) = {1, 0, 0, 1, 1, 1};
BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }
Mesh.MeshSizeMax = 0.3;
Physical Volume("left", 11) = {1};
Physical Volume("right", 12) = {2};
Physical Surface("all sides", 21) = Surface{:};
"""


def needs(program):
    return unittest.skipUnless(shutil.which(program), f"{program} is not installed")


class Formats(FolderTest):
    def mesh(self, **keywords):
        return self.generate("--double", "--jitter", "0.3", tets="5k", **keywords)

    def test_the_same_mesh_in_every_format_is_simplified_alike(self):
        original = self.mesh()
        bare = self.folder / "bare.vtu"
        run("convert", original, self.folder / "bare.mesh")
        run("convert", self.folder / "bare.mesh", bare)
        run("simplify", bare, "-o", self.folder / "expected.vtu", "--reduction", "60%")
        expected = Vtu(self.folder / "expected.vtu")
        for suffix in SUFFIXES:
            copy, out = self.folder / ("copy" + suffix), self.folder / "out.vtu"
            run("convert", bare, copy)
            self.assertEqual(report_of("info", copy)["tets"], report_of("info", bare)["tets"])
            run("check", copy)
            run("compare", bare, copy, "--surface", "0")
            run("simplify", copy, "-o", out, "--reduction", "60%")
            found = Vtu(out)
            np.testing.assert_array_equal(found.points, expected.points)
            np.testing.assert_array_equal(found.tets, expected.tets)

    def test_the_content_says_what_is_read(self):
        original = self.mesh()
        for suffix in (".mesh", ".meshb", ".msh", ".vtk", ".vtu"):
            copy = self.folder / ("copy" + suffix)
            run("convert", original, copy)
            expected = report_of("info", copy)
            for other in (*SUFFIXES, ".vtu", ".dat"):
                renamed = self.folder / ("renamed" + other)
                shutil.copy(copy, renamed)
                with self.subTest(content=suffix, name=other):
                    found = report_of("info", renamed)
                    self.assertEqual((found["format"], found["tets"]), (expected["format"], expected["tets"]))

    def test_simplify_and_generate_write_every_format(self):
        original, expected = self.mesh(), self.folder / "expected.vtu"
        run("simplify", original, "-o", expected, "--reduction", "60%")
        for suffix in SUFFIXES:
            found, back = self.folder / ("found" + suffix), self.folder / "back.vtu"
            for options in ([], ["--memory", "170M", "--threads", "1", "--chunk-tets", "200000"]):
                run("simplify", original, "-o", found, "--reduction", "60%", *options)
                run("convert", found, back)
                np.testing.assert_array_equal(Vtu(back).points, Vtu(expected).points)
                np.testing.assert_array_equal(Vtu(back).tets, Vtu(expected).tets)
            made, copy = self.mesh(name="made" + suffix), self.folder / ("copy" + suffix)
            run("convert", original, copy)
            self.assertEqual(made.read_bytes(), copy.read_bytes())
        self.assertFalse([name for name in self.files() if "part" in name])

    def test_long_integers_that_a_format_rounds_are_told_of(self):
        mesh = TinyVtu()
        mesh.arrays.insert(0, ["PointData", "gid", "Int64", 1, [10**17 + i for i in range(len(mesh.points))]])
        path = self.write(mesh)
        said = finish("convert", path, self.folder / "out.msh").stderr.decode()
        self.assertIn("rounded from 2^53 on: gid", said)
        self.assertNotIn("rounded", finish("convert", path, self.folder / "out.vtk").stderr.decode())

    def test_what_holds_vertices_is_named_as_it_is(self):
        """Regions that are one hold nothing; faces that are cells do."""
        mesh = self.folder / "mesh.ele"
        run("convert", self.mesh(), mesh)
        rows = [line.split() for line in mesh.read_text().split("\n")[1:-1]]
        base = int(rows[0][0])
        tets = [row[1:5] for row in rows]
        options = ["simplify", mesh, "-o", self.folder / "out.vtu", "--reduction", "90%"]

        def simplify(regions, marker, *more):
            mesh.write_text(f"{len(tets)} 4 1\n" + "".join(
                f"{base + i} {' '.join(t)} {regions(i)}\n" for i, t in enumerate(tets)))
            (self.folder / "mesh.face").write_text(f"{2 * len(tets)} 1\n" + "".join(
                f"{i} {' '.join(t[k:k + 3])} {marker}\n" for i, t in enumerate(2 * tets) for k in [i // len(tets)]))
            return report_of(*options, *more)["stop_sentence"]

        held = "a vertex of theirs is held by a cell of lower dimension, and stays."
        self.assertIn(held, simplify(lambda i: 42, 7))
        self.assertIn("theirs lies between regions of tetgen:ref or is held by a cell of lower", simplify(lambda i: i, 7))
        self.assertIn("a vertex of theirs lies between regions of tetgen:ref, and stays.", simplify(lambda i: i, 0))
        self.assertIn(held, simplify(lambda i: i, 7, "--regions", "none"))

    def test_patches_hold_the_boundary_unless_they_are_dropped(self):
        mesh, out = self.folder / "mesh.ele", self.folder / "out.vtu"
        source = self.generate("--jitter", "0.3", tets="20k")
        run("convert", source, mesh)
        summary = report_of("info", source)
        points, tets = Vtu(source).points, Vtu(source).tets
        faces = collections.Counter(tuple(sorted(f)) for t in tets.tolist() for f in itertools.combinations(t, 3))
        outer = [f for f, n in faces.items() if n == 1 and all(points[v][2] == points[:, 2].min() for v in f)]
        base = int(mesh.read_text().split("\n")[1].split()[0])
        (self.folder / "mesh.face").write_text(
            f"{len(outer)} 1\n" + "".join(f"{i} {' '.join(str(v + base) for v in f)} 5\n" for i, f in enumerate(outer)))
        options = ["simplify", mesh, "-o", out, "--reduction", "80%", "--boundary", "planar", "--regions", "none", "--chunk-tets", "6k"]
        kept = report_of(*options)
        self.assertEqual(len(Vtu(out).others), len(outer))
        said = finish(*options)
        self.assertIn(b"triangles are cells of the file: they stay, and the boundary with them (where their patches do not matter: "
                      b"--drop-patches, or --drop-patch NAME for one)", said.stderr)
        first = None
        for more in ([], ["--memory", "170M", "--threads", "2"]):
            dropped = report_of(*options, "--drop-patches", "--verify", *more)
            self.assertEqual(len(Vtu(out).others), 0)
            self.assertLess(dropped["output"]["boundary_triangles"], kept["output"]["boundary_triangles"] - len(outer) / 2)
            self.assertEqual(first or out.read_bytes(), out.read_bytes())
            first = out.read_bytes()
        self.assertEqual(summary["tets"], dropped["input"]["tets"])
        said = finish("simplify", mesh, "-o", out, "--progressive", self.folder / "p.tfp", "--drop-patches", "--reduction", "50%")
        self.assertEqual(said.returncode, USAGE)

    def test_lists_of_all_faces_do_not_hold_the_mesh(self):
        mesh, faces = self.folder / "mesh.ele", self.folder / "mesh.face"
        run("convert", self.mesh(), mesh)
        tets = [line.split()[1:5] for line in mesh.read_text().split("\n")[1:-1]]
        corners = sorted({tuple(sorted(t[:k] + t[k + 1:], key=int)) for t in tets for k in range(4)})
        for head, marker, words in (("1", " 0", "with marker 0"), ("0", "", "without markers")):
            faces.write_text(f"{len(corners)} {head}\n" + "".join(
                f"{i} {' '.join(face)}{marker}\n" for i, face in enumerate(corners)))
            told = finish("simplify", mesh, "-o", self.folder / "out.vtu", "--reduction", "30%", "--regions", "none")
            self.assertEqual(told.returncode, 0)
            self.assertIn(f"left out: {len(corners):,} faces {words}, as mesh.face lists all faces", told.stderr.decode())
            self.assertLess(report_of("info", self.folder / "out.vtu")["tets"], 0.75 * len(tets))

    def test_values_beside_a_mesh_of_medit_are_named(self):
        mesh, values = self.folder / "mesh.mesh", self.folder / "mesh.sol"
        run("convert", self.mesh(), mesh)
        self.assertNotIn("left out", run("info", mesh).decode())
        values.write_text("MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n1\n1 1\n0.5\nEnd\n")
        self.assertIn("left out: the values in mesh.sol", run("info", mesh).decode())
        self.assertIn("left out: the values in mesh.sol",
                      finish("simplify", mesh, "-o", self.folder / "out.vtu", "--reduction", "50%").stderr.decode())
        refused = finish("info", values)
        self.assertEqual(refused.returncode, BAD)
        self.assertIn("there are no Vertices but values (SolAtVertices): a .sol has no mesh", refused.stderr.decode())

    def test_levels(self):
        original = self.mesh()
        run("simplify", original, "-o", self.folder / "level_{lod}.meshb", "--lods", "10%,30%")
        self.assertIn("level_2.meshb", self.files())
        self.assertLess(report_of("info", self.folder / "level_2.meshb")["tets"],
                        report_of("info", self.folder / "level_1.meshb")["tets"])

    def test_references_are_regions(self):
        original = self.folder / "two.mesh"
        run("convert", self.mesh(), original)
        text = original.read_text().split("\n")
        first = text.index("Tetrahedra") + 2
        for i in range(first, first + 2000):
            text[i] = text[i][:-1] + "5"
        original.write_text("\n".join(text))
        for suffix in SUFFIXES:
            copy = self.folder / ("copy" + suffix)
            run("convert", original, copy)
            said = run("simplify", copy, "-o", self.folder / "out.vtu", "--reduction", "50%", "--dry-run").decode()
            self.assertRegex(said, r"regions +(medit:ref|gmsh:physical|tetgen:ref)")

    def test_a_region_that_was_named_is_what_the_format_has_for_it(self):
        """Though its name does not say so, and whatever its type; nothing tells that it is left out then."""
        mesh = TinyVtu(4)
        half = len(mesh.tets) // 2
        values = [3 + (i >= half) for i in range(len(mesh.tets))]
        for (suffix, name), kind in itertools.product(((".mesh", "medit:ref"), (".meshb", "medit:ref"), (".msh", "gmsh:physical"),
                                                       (".node", "tetgen:ref")), ("Int32", "UInt64", "Float32", "Float64")):
            mesh.arrays[1][1:] = "layer", kind, 1, values
            original = self.write(mesh)
            out = self.folder / ("labelled" + suffix)
            for options, labelled in (([], False), (["--regions", "layer"], True), (["--regions", "cell:layer"], True)):
                result = finish("simplify", original, "-o", out, "--reduction", "20%", *options)
                self.assertEqual(result.returncode, 0, result.stderr)
                run("convert", out, self.folder / "back.vtu")
                cells = Vtu(self.folder / "back.vtu").arrays["cell"]
                found = set(cells[name][1].ravel().tolist()) if name in cells else set()
                self.assertEqual(found == {3, 4}, labelled, (suffix, kind, options))
                if suffix != ".msh":
                    left_out = result.stderr.partition(b"left out: ")[2].partition(b"\n")[0]
                    self.assertEqual(b"layer" in left_out, not labelled)

    def test_labels_that_a_format_has_no_room_for_are_named_with_the_reason(self):
        mesh = TinyVtu(4)
        for suffix, name, value, told in (
                (".mesh", "layer", 4.5, "cannot be the references of {}, and is left out: its value 4.5 is no whole number"),
                (".node", "layer", 4.5, "cannot be the attributes of {}, and is left out: its value 4.5 is no whole number"),
                (".msh", "layer", 4.5, "cannot be the physical groups of {}: its value 4.5 is no whole number"),
                (".msh", "layer", 3e9, "cannot be the physical groups of {}: its value 3000000000 has more than 32 bits"),
                (".mesh", "layer", 1e30, "cannot be the references of {}, and is left out: its value 1e+30 has more than 64 bits"),
                (".mesh", "layer", 3e9, ""), (".mesh", "material", 2.5, "references of {}, and is left out"), (".msh", "material", 2.5, "")):
            mesh.arrays[1][1:] = name, "Float64", 1, [1.0] * (len(mesh.tets) - 1) + [value]
            out = self.folder / ("out" + suffix)
            options = [] if name == "material" else ["--regions", name]
            result = finish("simplify", self.write(mesh), "-o", out, "--reduction", "1%", *options)
            self.assertEqual(result.returncode, 0, result.stderr)
            if told:
                self.assertIn(f"cell array {name} " * (name == "layer") + told.format(out), result.stderr.decode())
            else:
                self.assertNotIn(b"cannot be", result.stderr)

    def test_each_physical_group_of_gmsh_has_entities_of_its_own(self):
        """Gmsh gives an entity to all groups that elements of it are in."""
        mesh, out = TinyVtu(4), self.folder / "out.msh"
        count = len(mesh.tets)

        def pairs(labels, entities=None):
            mesh.arrays[1][1:] = "material", "Int32", 1, labels
            mesh.arrays[:] = [a for a in mesh.arrays if a[1] != "gmsh:geometrical"]
            if entities:
                mesh.arrays.insert(2, ["CellData", "gmsh:geometrical", "Int32", 1, entities])
            told = finish("convert", self.write(mesh), out, "--labels", "material").stderr
            run("convert", out, self.folder / "back.vtu")
            cells = Vtu(self.folder / "back.vtu").arrays["cell"]
            tags = [np.squeeze(cells[name][1]).tolist() for name in ("gmsh:physical", "gmsh:geometrical")]
            self.assertEqual(tags[0], labels)
            return sorted(set(zip(*tags))), b"values below 1" in told

        thirds = [i % 3 for i in range(count)]
        self.assertEqual(pairs([t + 1 for t in thirds]), ([(1, 1), (2, 2), (3, 3)], False))
        self.assertEqual(pairs(thirds), ([(0, 3), (1, 1), (2, 2)], True))
        self.assertEqual(pairs([t - 1 for t in thirds]), ([(-1, 2), (0, 3), (1, 1)], True))
        # Entities that are parts of groups stay; those that several groups have do not.
        self.assertEqual(pairs([t + 1 for t in thirds], [7 + i % 6 for i in range(count)])[0],
                         [(1, 7), (1, 10), (2, 8), (2, 11), (3, 9), (3, 12)])
        self.assertEqual(pairs([t + 1 for t in thirds], [1] * count)[0], [(1, 1), (2, 2), (3, 3)])

    def test_groups_that_are_0_everywhere_are_none(self):
        """As a Gmsh file has them where nobody gave any: the first array that says more takes their place."""
        mesh, out = TinyVtu(4), self.folder / "out.mesh"
        values = [1 + i % 2 for i in range(len(mesh.tets))]
        mesh.arrays[1][1:] = "material", "Float64", 1, values
        mesh.arrays.insert(1, ["CellData", "gmsh:physical", "Int32", 1, [0] * len(values)])

        def references(path):
            run("convert", path, self.folder / "back.vtu")
            return Vtu(self.folder / "back.vtu").arrays["cell"]["medit:ref"][1].ravel().tolist()

        told = finish("convert", self.write(mesh), out).stderr.decode()
        self.assertIn(f"cell array gmsh:physical is 0 everywhere: material becomes the references of {out} in its place", told)
        self.assertEqual(references(out), values)
        mesh.array("gmsh:physical")[4][-1] = 7
        self.assertIn("left out: temperature, material", finish("convert", self.write(mesh), out).stderr.decode())
        mesh.array("temperature")[1] = "material"
        self.assertIn("left out: material, cell:material", finish("convert", self.write(mesh), out).stderr.decode())
        self.assertEqual(references(out), [0] * (len(values) - 1) + [7])

    def test_labels_that_went_through_gmsh_are_regions_still(self):
        """The first as the physical group, an integer; a second one as a floating-point number, by its name."""
        mesh, back = TinyVtu(6), self.folder / "back.msh"
        mesh.array("id")[1:] = "material", "Int32", 1, [1 + i % 2 for i in range(len(mesh.tets))]
        where = np.array(mesh.points)[np.array(mesh.tets)].mean(axis=1)[:, 0] > 3
        mesh.arrays.insert(2, ["CellData", "phase", "UInt8", 1, where.astype(int).tolist()])
        run("convert", self.write(mesh), back)
        types = {a["name"]: a["type"] for a in report_of("info", back)["arrays"] if a["association"] == "cell"}
        self.assertEqual(types, {"gmsh:physical": "Int32", "gmsh:geometrical": "Int32", "material": "Float64", "phase": "Float64"})
        options = ["simplify", back, "-o", self.folder / "out.vtu", "--reduction", "30%"]
        self.assertEqual(report_of(*options)["regions"], ["gmsh:physical"])
        report = report_of(*options, "--regions", "phase", "--verify")
        self.assertEqual(report["regions"], ["phase"])
        self.assertGreater(report["reduction"], 0.1)
        result = Vtu(self.folder / "out.vtu")
        centres = result.points[result.tets].mean(axis=1)[:, 0]
        np.testing.assert_array_equal(np.squeeze(result.arrays["cell"]["phase"][1]), centres > 3)

    def test_labels_that_cannot_be_groups_are_told_of_without_an_option(self):
        mesh, out = TinyVtu(4), self.folder / "out.msh"
        mesh.array("id")[1:] = "material", "UInt32", 1, [1] * (len(mesh.tets) - 1) + [4000000000]
        told = finish("convert", self.write(mesh), out).stderr.decode()
        self.assertIn(f"cell array material cannot be the physical groups of {out}: its value 4000000000 has more than 32 bits", told)

    def test_arrays_that_find_no_place_are_named(self):
        result = finish("convert", self.mesh(), self.folder / "out.mesh")
        self.assertIn(b"left out: temperature, front, velocity, TimeValue", result.stderr)
        result = finish("simplify", self.mesh(), "-o", self.folder / "out.msh", "--reduction", "50%")
        self.assertNotIn(b"left out", result.stderr)

    def test_names_of_groups_come_back(self):
        original = self.folder / "a.msh"
        run("convert", self.mesh(), original, "--encoding", "ascii")
        names = '$PhysicalNames\n2\n2 1 "rock"\n3 1 "rock"\n$EndPhysicalNames\n'
        original.write_text(original.read_text().replace("$Nodes\n", names + "$Nodes\n", 1))
        between = self.folder / "between.vtu"
        run("convert", original, between)
        for mesh in original, between:
            small = self.folder / "small.msh"
            run("simplify", mesh, "-o", small, "--reduction", "50%", "--encoding", "ascii")
            self.assertIn(names, small.read_text())

    def test_parts_of_a_file_that_are_not_read_are_named(self):
        original, out = self.folder / "a.msh", self.folder / "out.vtu"
        run("convert", self.mesh(), original, "--encoding", "ascii")
        with open(original, "a") as file:
            file.write('$ElementNodeData\n1\n"q"\n0\n3\n0\n1\n0\n$EndElementNodeData\n')
        words = b"a.msh has parts that are not read, and left out: ElementNodeData"
        self.assertIn(words, finish("convert", original, out).stderr)
        self.assertIn(words, finish("simplify", original, "-o", out, "--reduction", "50%").stderr)
        self.assertIn(words, finish("check", original, "--fix", out).stderr)
        self.assertIn("text; left out: ElementNodeData", run("info", original).decode())
        self.assertEqual(report_of("info", original)["left_out"], ["ElementNodeData"])

    def test_standard_input(self):
        original = self.folder / "a.meshb"
        run("convert", self.mesh(), original)
        out = self.folder / "out.vtu"
        run("convert", "-", out, input=original.read_bytes())
        self.assertEqual(len(Vtu(out).tets), report_of("info", original)["tets"])

    def test_bad_names_and_encodings(self):
        original = self.mesh()
        for name in ("out.stl", "out", "out.meshbb"):
            result = finish("convert", original, self.folder / name)
            self.assertEqual(result.returncode, USAGE)
            for known in (b".vtu", b".pvd", b".vtk", b".mesh", b".meshb", b".msh", b".node"):
                self.assertIn(known, result.stderr)
            run("simplify", original, "-o", self.folder / name, code=USAGE)
        run("convert", original, self.folder / "out.mesh", "--encoding", "zlib", code=USAGE)
        run("convert", original, self.folder / "out.meshb", "--encoding", "ascii", code=USAGE)
        run("convert", original, self.folder / "out.msh", "--encoding", "ascii")
        self.assertTrue((self.folder / "out.msh").read_bytes().startswith(b"$MeshFormat\n2.2 0 8\n"))
        run("convert", original, self.folder / "no" / "out.msh", code=IO)
        self.write(b"MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 0 x 0\n", "bad.mesh")
        run("info", self.folder / "bad.mesh", code=BAD)

    def assert_meshio_agrees(self, path):
        out = self.folder / "ours.vtu"
        run("convert", path, out)
        theirs, ours = meshio.read(path), Vtu(out)
        tets = np.concatenate([block.data for block in theirs.cells if block.type == "tetra"])
        self.assertEqual(len(tets), len(ours.tets))
        np.testing.assert_array_equal(theirs.points[tets], np.asarray(ours.points)[np.asarray(ours.tets)])
        for name in ("medit:ref", "gmsh:physical", "tetgen:ref"):
            if name not in theirs.cell_data:
                continue
            values = np.concatenate([v for v, block in zip(theirs.cell_data[name], theirs.cells) if block.type == "tetra"])
            np.testing.assert_array_equal(ours.arrays["cell"][name][1][: len(tets)].ravel(), values)

    @unittest.skipUnless(meshio, "meshio is not installed")
    def test_meshio_reads_our_files(self):
        original = self.mesh()
        for suffix in (".mesh", ".meshb", ".msh", ".node"):
            for options in ([], ["--encoding", "ascii"]):
                if suffix == ".meshb" and options:
                    continue
                path = self.folder / ("ours" + suffix)
                run("convert", original, path, *options)
                self.assert_meshio_agrees(path)

    @unittest.skipUnless(meshio, "meshio is not installed")
    def test_we_read_meshios_files(self):
        points = np.array([[0, 0, 0], [1, 0, 0.1], [0, 1, 0], [0, 0, 1], [1, 1, -1]], dtype=float)
        cells = [("tetra", np.array([[0, 1, 2, 3], [4, 1, 3, 2]])), ("triangle", np.array([[1, 2, 3]]))]
        mesh = meshio.Mesh(points, cells)
        refs = [np.array([3, 4]), np.array([5])]
        mesh.cell_data["medit:ref"] = refs
        for name in ("a.mesh", "a.meshb"):
            meshio.write(self.folder / name, mesh)
            self.assert_meshio_agrees(self.folder / name)
        mesh.cell_data = {"gmsh:physical": refs, "gmsh:geometrical": refs}
        mesh.point_data = {"T": np.arange(5.0)}
        for binary in (True, False):
            for kind in ("gmsh22", "gmsh"):
                if kind == "gmsh":
                    mesh.point_data["gmsh:dim_tags"] = np.array([[2, 5], [3, 3], [3, 3], [3, 4], [3, 4]])
                meshio.write(self.folder / "a.msh", mesh, file_format=kind, binary=binary)
                self.assert_meshio_agrees(self.folder / "a.msh")
                mesh.point_data.pop("gmsh:dim_tags", None)

    @needs("gmsh")
    def test_gmsh_and_we_read_one_another(self):
        self.write(BOX.encode(), "box.geo")
        for version in ("msh1", "msh22", "msh40", "msh41", "mesh"):
            for binary in (False, True) if version in ("msh22", "msh41") else (False,):
                path = self.folder / f"box.{'mesh' if version == 'mesh' else 'msh'}"
                options = ["-bin"] if binary else []
                subprocess.run(["gmsh", "-3", "box.geo", "-format", version, "-o", path, *options, "-v", "2"],
                               cwd=self.folder, check=True, capture_output=True, timeout=120)
                report = report_of("check", path)
                self.assertTrue(report["valid"], (version, binary))
                self.assertAlmostEqual(report["volume"], 2, places=9)
                small = self.folder / "small.msh"
                run("simplify", path, "-o", small, "--reduction", "20%")
                self.assertAlmostEqual(report_of("check", small)["volume"], 2, places=9)
                said = subprocess.run(["gmsh", "-check", small, "-v", "4"], cwd=self.folder, check=True,
                                      capture_output=True, timeout=120)
                self.assertNotIn(b"Error", said.stdout + said.stderr)
                if version != "mesh":
                    out = self.folder / "out.vtu"
                    run("convert", path, out)
                    values = set(Vtu(out).arrays["cell"]["gmsh:physical"][1].ravel().tolist())
                    self.assertEqual(values, {11, 12, 21})

    @needs("gmsh")
    def test_gmshs_versions_are_one_mesh(self):
        self.write(BOX.encode(), "box.geo")
        expected = None
        for version in ("msh1", "msh22", "msh40", "msh41"):
            path, out = self.folder / "box.msh", self.folder / "out.vtu"
            subprocess.run(["gmsh", "-3", "box.geo", "-format", version, "-o", path, "-v", "2"],
                           cwd=self.folder, check=True, capture_output=True, timeout=120)
            run("convert", path, out)
            vtu = Vtu(out)
            cells = vtu.arrays["cell"]
            tags = np.column_stack([cells[name][1].ravel() for name in ("gmsh:physical", "gmsh:geometrical")])
            tets = np.column_stack([vtu.tets, tags[: len(vtu.tets)]])
            found = [vtu.points, np.array(sorted(tets.tolist())), np.array(sorted(tags.tolist()))]
            expected = expected or found
            for is_there, should_be in zip(found, expected):
                np.testing.assert_array_equal(is_there, should_be, version)
            if version != "msh1":
                groups = {a["name"]: a.get("groups") for a in report_of("info", path)["arrays"]}
                self.assertEqual(groups["gmsh:physical:left"], [{"tag": 11, "dimension": 3}])
                self.assertEqual(groups["gmsh:physical:all sides"], [{"tag": 21, "dimension": 2}])

    @needs("tetgen")
    def test_tetgen_and_we_read_one_another(self):
        self.write(CUBE.encode(), "cube.poly")
        for options in ("-pqAa", "-pqAzYa", "-pqAnna"):
            subprocess.run(["tetgen", options, "cube.poly"], cwd=self.folder, check=True, capture_output=True, timeout=120)
            path = self.folder / "cube.1.ele"
            report = report_of("check", path)
            self.assertTrue(report["valid"], options)
            self.assertAlmostEqual(report["volume"], 1, places=12)
            run("convert", path, self.folder / "out.vtu")
            values = Vtu(self.folder / "out.vtu").arrays["cell"]["tetgen:ref"][1].ravel()
            self.assertEqual(set(values[: report["tets"]].tolist()), {3})
            self.assertLessEqual({5, 6, 7, 8, 9, 10}, set(values.tolist()))
            run("convert", path, self.folder / "again.node")
            subprocess.run(["tetgen", "-rqa0.005", "again"], cwd=self.folder, check=True, capture_output=True, timeout=120)
            self.assertGreater(report_of("info", self.folder / "again.1.node")["tets"], report["tets"])


if __name__ == "__main__":
    main()
