#!/usr/bin/env python3
"""Polyhedra, which are cut from a point in their middle. Usage: polyhedra_test.py TETFUSION"""
import itertools
import re

import numpy as np

from harness import BAD, FolderTest, finish, least_memory, main, report_of, run, size_of
from independent_check import Vtu

try:
    import vtkmodules.vtkCommonCore  # what reads them is there, too
except ImportError:
    vtkmodules = None

TRIANGLE, POLYGON, HEXAHEDRON, POLYHEDRON = 5, 7, 12, 42
CUBE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
SIDES = {(0, -1): (0, 4, 7, 3), (0, 1): (1, 2, 6, 5), (1, -1): (0, 1, 5, 4), (1, 1): (3, 7, 6, 2),
         (2, -1): (0, 3, 2, 1), (2, 1): (4, 5, 6, 7)}  # axis and direction -> corners, seen from outside


class Refined:
    """n^3 unit cubes, of which some are cut in eight: where others touch these, they are polyhedra."""

    def __init__(self, n, cut, move=lambda p: p):
        self.numbers, self.cells = {}, []  # of points in half units; type, vertices, faces
        self.cut = set(cut)
        for cell in itertools.product(range(n), repeat=3):
            low = tuple(2 * c for c in cell)
            if cell in self.cut:
                for half in CUBE:
                    self.add_cube(tuple(a + b for a, b in zip(low, half)), 1)
            else:
                faces = [face for side in SIDES for face in self.faces_of(cell, side)]
                if all(len(face) == 4 for face in faces) and len(faces) == 6:
                    self.add_cube(low, 2)
                else:
                    faces = [[self.number(p) for p in face] for face in faces]
                    self.cells.append((POLYHEDRON, sorted({v for face in faces for v in face}), faces))
        self.points = np.array([move(np.array(p) / 2) for p in self.numbers], float)

    def number(self, point):
        return self.numbers.setdefault(tuple(int(x) for x in point), len(self.numbers))

    def add_cube(self, low, edge):
        corners = [self.number(np.array(low) + edge * np.array(corner)) for corner in CUBE]
        self.cells.append((HEXAHEDRON, corners, None))

    def faces_of(self, cell, side):
        """Four where the neighbour is cut, else one, with the middles of edges that have one."""
        axis, direction = side
        corners = [2 * np.array(cell) + 2 * np.array(CUBE[c]) for c in SIDES[side]]
        middles = [(a + b) // 2 for a, b in zip(corners, corners[1:] + corners[:1])]
        neighbour = list(cell)
        neighbour[axis] += direction
        if tuple(neighbour) in self.cut:
            centre = sum(corners) // 4
            return [[corners[i], middles[i], centre, middles[i - 1]] for i in range(4)]
        face = []
        for corner, middle in zip(corners, middles):
            face += [corner, middle] if self.is_cut_at(middle) else [corner]
        return [face]

    def is_cut_at(self, middle):
        """Is a cube round this middle of an edge cut?"""
        reach = [[x // 2] if x % 2 else [x // 2 - 1, x // 2] for x in middle]
        return any(cell in self.cut for cell in itertools.product(*reach))

    def grid(self, point_arrays, cell_arrays, cells=None):
        """As the text of a piece; arrays are (name, type, values)."""
        cells = self.cells if cells is None else cells
        flat = lambda lists: [v for values in lists for v in values]
        faces, ends = [], []
        for _, _, of_cell in cells:
            if of_cell:
                faces += [len(of_cell)] + flat([len(face), *face] for face in of_cell)
            ends.append(len(faces) if of_cell else -1)
        lists = [("connectivity", "Int64", flat(vertices for _, vertices, _ in cells)),
                 ("offsets", "Int64", np.cumsum([len(vertices) for _, vertices, _ in cells])),
                 ("types", "UInt8", [kind for kind, _, _ in cells])]
        if faces:
            lists += [("faces", "Int64", faces), ("faceoffsets", "Int64", ends)]
        return (f'<Piece NumberOfPoints="{len(self.points)}" NumberOfCells="{len(cells)}">'
                f'<PointData GlobalIds="ids">{arrays(point_arrays)}</PointData><CellData>{arrays(cell_arrays)}</CellData>'
                f'<Points>{arrays([("Points", "Float64", self.points)])}</Points><Cells>{arrays(lists)}</Cells></Piece>')


def arrays(named):
    text = ""
    for name, kind, values in named:
        values = np.asarray(values)
        width = values.shape[1] if values.ndim > 1 else 1
        text += (f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{width}" format="ascii">'
                 f'{" ".join(repr(v) for v in values.ravel().tolist())}</DataArray>')
    return text


def vtu(pieces):
    return (f'<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">'
            f'<UnstructuredGrid>{pieces}</UnstructuredGrid></VTKFile>').encode()


def linear(points):
    return 1 + points @ [2.0, -3.0, 0.5]


def values(mesh, association, name):
    rows = mesh.arrays[association][name][1]
    return rows[:, 0] if rows.shape[1] == 1 else rows


class Polyhedra(FolderTest):
    def setUp(self):
        super().setUp()
        if vtkmodules is None:
            self.skipTest("VTK, which reads polyhedra, is not there")

    def mesh(self, n=4, cut=((1, 1, 1), (2, 1, 1), (3, 3, 0)), move=lambda p: p, cells=None):
        made = Refined(n, cut, move)
        points = made.points
        return made, made.grid([("f", "Float64", linear(points)), ("v", "Float32", np.stack([linear(points)] * 3, 1)),
                                ("label", "Int32", np.arange(len(points)) % 5), ("ids", "Int64", 1000 + np.arange(len(points)))],
                               [("c", "Float64", np.arange(len(made.cells if cells is None else cells)))], cells)

    def test_are_cut_into_valid_tetrahedra(self):
        made, piece = self.mesh()
        path = self.write(vtu(piece))
        check = report_of("check", path, "--tetrahedralize")
        polyhedra = [cell for cell in made.cells if cell[0] == POLYHEDRON]
        self.assertEqual(check["points"], len(made.points) + len(polyhedra))
        self.assertTrue(check["valid"])
        self.assertEqual([check[k] for k in ("degenerate", "rewound", "nonmanifold_edges")], [0, 0, 0])
        self.assertAlmostEqual(check["volume"], 4**3, delta=1e-12)
        self.assertGreater(check["min_dihedral_deg"], 20)

    def test_bring_what_is_linear_to_their_middles(self):
        """Also where cubes are skewed and cells are no boxes."""
        for move in (lambda p: p, lambda p: p + 0.1 * np.sin(3 * p[::-1])):
            with self.subTest(move=move):
                made, piece = self.mesh(move=move)
                path, out = self.write(vtu(piece)), self.folder / "out.vtu"
                run("convert", path, out, "--tetrahedralize", "--encoding", "inline")
                mesh = Vtu(out)
                self.assertLess(np.abs(values(mesh, "point", "f") - linear(mesh.points)).max(), 1e-13)
                self.assertLess(np.abs(values(mesh, "point", "v") - linear(mesh.points)[:, None]).max(), 1e-5)
                before = len(made.points)
                first = np.array([cell[1][0] for cell in made.cells if cell[0] == POLYHEDRON])
                self.assertEqual(values(mesh, "point", "label")[before:].tolist(), (first % 5).tolist())
                self.assertEqual(values(mesh, "point", "ids").tolist(), [*range(1000, 1000 + before), *(1000 + first)])
                self.assertIn(b'PedigreeIds="ids"', out.read_bytes())  # they are not unique any more

    def test_may_list_their_faces_either_way_round(self):
        made, _ = self.mesh()
        cells = [(kind, vertices, faces and [face[::-1] if i % 2 else face for i, face in enumerate(faces)])
                 for kind, vertices, faces in made.cells]
        checks = [report_of("check", self.write(vtu(self.mesh(cells=c)[1])), "--tetrahedralize") for c in (cells, made.cells)]
        for check in checks:
            self.assertEqual((check["valid"], check["rewound"]), (True, 0))
        self.assertAlmostEqual(checks[0]["volume"], checks[1]["volume"], delta=1e-12)

    def test_their_tetrahedra_have_their_values(self):
        made, piece = self.mesh()
        path, out = self.write(vtu(piece)), self.folder / "out.vtu"
        run("convert", path, out, "--tetrahedralize")
        mesh = Vtu(out)
        corners = mesh.points[mesh.tets]
        volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
        of_cells = np.bincount(values(mesh, "cell", "c").astype(int), volumes, len(made.cells))
        edges = [1 if kind == POLYHEDRON else np.ptp(made.points[vertices, 0]) for kind, vertices, _ in made.cells]
        np.testing.assert_allclose(of_cells, np.array(edges)**3, rtol=1e-12)

    def test_simplify_keeps_its_promises(self):
        _, piece = self.mesh(n=6, cut=[(x, y, z) for x, y, z in itertools.product(range(6), repeat=3) if (x + y * z) % 4 == 0])
        path, out = self.write(vtu(piece)), self.folder / "out.vtu"
        report = report_of("simplify", path, "-o", out, "--tetrahedralize", "--reduction", "70%", "--verify")
        self.assertGreater(report["reduction"], 0.69)
        compared = report_of("compare", path, out, "--tetrahedralize", "--max-error", "1e-12", "--array", "f")
        self.assertTrue(compared["surface"]["identical"])

    def test_the_memory_that_is_asked_for_is_enough(self):
        n = 24  # 13,824 cubes, of which a fifth are cut
        _, piece = self.mesh(n=n, cut=[p for p in itertools.product(range(n), repeat=3) if sum(p) % 5 == 0])
        path, out = self.write(vtu(piece)), self.folder / "out.vtu"
        options = ["simplify", path, "-o", out, "--tetrahedralize", "--reduction", "50%"]
        memory = least_memory(*options)
        report = report_of(*options, "--memory", memory)
        self.assertLess(report["peak_rss_bytes"], size_of(memory))
        self.assertGreater(report["input"]["tets"], 300_000)

    def test_conform_to_hexahedra_on_thin_faces(self):
        """A hexahedron and a polyhedron share a face so thin that its triangles have hardly an area."""
        corners = [(1, 0, 0), (1, 1, 0), (1, 1.2, .0022), (1, .2, .0022)]
        for turn in range(4):
            made = Refined(1, [])
            face = [(i + turn) % 4 for i in range(4)]
            made.points = np.array([corners[i] for i in np.argsort(face)]
                                   + [(x, y, z) for x in (0, 2) for _, y, z in corners])
            left, right = [4, 5, 6, 7], [8, 9, 10, 11]
            faces = [face[::-1], right] + [[face[i], face[(i + 1) % 4], right[(i + 1) % 4], right[i]] for i in range(4)]
            cells = [(HEXAHEDRON, left + face, None), (POLYHEDRON, sorted(face + right), faces)]
            path = self.write(vtu(made.grid([("f", "Float64", linear(made.points))], [], cells)).replace(b' GlobalIds="ids"', b""))
            check = report_of("check", path, "--tetrahedralize")
            self.assertEqual((check["components"], check["boundary_triangles"]), (1, 20))

    def test_take_faces_that_name_a_vertex_twice_and_whole_coordinates(self):
        wedge = [[0, 2, 1, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]]
        made = Refined(1, [])
        made.points = np.array([(0, 0, 0), (4, 0, 0), (0, 4, 0), (0, 0, 4), (4, 0, 4), (0, 4, 4)])
        piece = made.grid([], [], [(POLYHEDRON, list(range(6)), wedge)]).replace(' GlobalIds="ids"', "")
        for text in (piece, re.sub(r'"Float64"( Name="Points")', r'"Int32"\1', piece)):
            check = report_of("check", self.write(vtu(text)), "--tetrahedralize")
            self.assertEqual((check["tets"], check["boundary_triangles"], check["degenerate"]), (8, 8, 0))
            self.assertAlmostEqual(check["volume"], 32, delta=1e-12)

    def test_polygons_on_them_are_cut_alike(self):
        """All faces of the mesh beside its cells: each is two or more triangles, and each of these a tetrahedron's."""
        made = Refined(3, [(1, 1, 1)])
        faces = [face for kind, _, of_cell in made.cells if kind == POLYHEDRON for face in of_cell]
        cells = made.cells + [(POLYGON, face, None) for face in faces]
        path, out = self.write(vtu(self.mesh(3, [(1, 1, 1)], cells=cells)[1])), self.folder / "out.vtu"
        run("convert", path, out, "--tetrahedralize")
        mesh = Vtu(out)
        triangles = [ids.tolist() for kind, ids in mesh.others if kind == TRIANGLE]
        self.assertEqual(len(triangles), sum(len(face) - 2 for face in faces))
        of_tets = {tuple(sorted(face)) for tet in mesh.tets.tolist() for face in itertools.combinations(tet, 3)}
        self.assertEqual([t for t in triangles if tuple(sorted(t)) not in of_tets], [])

    def test_of_two_pieces_are_one_mesh(self):
        """The second piece lies beside the first one; their common points have the same global ids."""
        pieces = [Refined(3, [(1, 1, 1)], lambda p, shift=shift: p + [shift, 0, 0]) for shift in (0, 3)]
        places = np.unique(np.concatenate([piece.points for piece in pieces]), axis=0)
        ids = {tuple(p): i for i, p in enumerate(places.tolist())}
        texts = [piece.grid([("f", "Float64", linear(piece.points)),
                             ("ids", "Int64", [ids[tuple(p)] for p in piece.points.tolist()])], []) for piece in pieces]
        for i, text in enumerate(texts):
            self.write(vtu(text), f"piece_{i}.vtu")
        self.write(vtu("".join(texts)), "whole.vtu")
        self.write(b'<VTKFile type="PUnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">'
                   b'<PUnstructuredGrid GhostLevel="0"><PPoints><PDataArray type="Float64" NumberOfComponents="3"/></PPoints>'
                   b'<PPointData GlobalIds="ids"><PDataArray type="Float64" Name="f"/><PDataArray type="Int64" Name="ids"/></PPointData>'
                   b'<Piece Source="piece_0.vtu"/><Piece Source="piece_1.vtu"/></PUnstructuredGrid></VTKFile>', "all.pvtu")
        # Numbers that are none in double precision, for the third of them.
        self.write(re.sub(rb'(Name="ids"[^>]*>)([^<]*)', lambda m: m[1] + b" ".join(b"%d" % (2**60 + int(v)) for v in m[2].split()),
                          (self.folder / "whole.vtu").read_bytes()), "large.vtu")
        for name in ("whole.vtu", "all.pvtu", "large.vtu"):
            with self.subTest(name=name):
                check = report_of("check", self.folder / name, "--tetrahedralize")
                self.assertTrue(check["valid"])
                self.assertAlmostEqual(check["volume"], 2 * 27, delta=1e-12)
                polyhedra = sum(kind == POLYHEDRON for piece in pieces for kind, _, _ in piece.cells)
                self.assertEqual((polyhedra, check["points"]), (36, len(ids) + 36))
                self.assertEqual(check["components"], 1)

    def test_messages(self):
        _, piece = self.mesh()
        path = self.write(vtu(piece))
        cells = [cell for cell in Refined(4, [(1, 1, 1)]).cells if cell[0] == POLYHEDRON]
        only = self.write(vtu(self.mesh(cells=cells)[1]), "only.vtu")
        self.assertIn("polyhedron (VTK cell type 42): use --tetrahedralize", self.refused("check", only))
        self.assertEqual(report_of("info", only)["needs"], ["--tetrahedralize"])
        with open(path, "rb") as pipe:
            said = self.refused("info", "-", "--tetrahedralize", stdin=pipe)
        self.assertIn("standard input is a .vtu with polyhedra", said)
        for old, new in ((r'(Name="faces"[^>]*>)', rb"\g<1>999 "), (r'(Name="connectivity"[^>]*>)', rb"\g<1>77777 ")):
            damaged = self.write(re.sub(old.encode(), new, path.read_bytes()), "damaged.vtu")
            self.refused("info", damaged, "--tetrahedralize")

    def refused(self, *arguments, **keywords):
        result = finish(*arguments, **keywords)
        self.assertEqual((result.returncode, result.stdout), (BAD, b""), result.stderr)
        return result.stderr.decode()


if __name__ == "__main__":
    main()
