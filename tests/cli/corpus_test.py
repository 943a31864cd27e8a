#!/usr/bin/env python3
"""Simplifies a corpus of small odd meshes, made by counter, and judges every result twice.

    corpus_test.py TETFUSION

Once by tests/support/independent_check.py, and once by what that cannot know: every cell and point carries its number, so
that each value of the result can be traced to the input. No code of the project is used but that script.
"""
import itertools
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zlib
from collections import Counter, defaultdict
from fractions import Fraction
from xml.sax.saxutils import quoteattr

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import independent_check  # noqa: E402

COMMAND = None
TETRAHEDRON, TRIANGLE, LINE, VERTEX = 10, 5, 3, 1
NAMES = {"i1": "Int8", "u1": "UInt8", "i4": "Int32", "u4": "UInt32", "i8": "Int64", "f4": "Float32", "f8": "Float64"}
# value = SLOPE . x + OFFSET at every point: a linear field must stay one.
SLOPE, OFFSET = np.array([0.75, -1.25, 0.5]), 2.0
ODD_NAMES = ["", "two words", "<&>", "quo\"te'", "\u00e9\u6e29", "a:b", "x:5%", "tab\there", "{lod}", "n" * 300]


class Mesh:
    """points (n, 3), tets (m, 4), others (type, ids); arrays are added by dress()."""

    def __init__(self, points, tets, others=()):
        self.points, self.tets, self.others = np.asarray(points), np.asarray(tets, np.int64), list(others)
        self.point_data, self.cell_data, self.regions = {}, {}, None

    @property
    def cells(self):
        return len(self.tets) + len(self.others)


# ---- Shapes ----

def determinants(points, tets):
    p = points.astype(np.longdouble)[tets]
    u, v, w = (p[:, k] - p[:, 0] for k in (1, 2, 3))
    return np.einsum("ij,ij->i", np.cross(u, v), w)


def wound(points, tets):
    tets = np.array(tets, np.int64)
    wrong = determinants(points, tets) < 0
    tets[wrong] = tets[wrong][:, [0, 1, 3, 2]]
    return tets


def lattice(rng, size, per_cube=6, jitter=0.0, keep=None):
    """Cubes cut in five or six; `keep` says which cubes there are. Inner points move by up to jitter / 2."""
    nx, ny, nz = size
    at = lambda i, j, k: (k * (ny + 1) + j) * (nx + 1) + i
    points = np.array([(i, j, k) for k in range(nz + 1) for j in range(ny + 1) for i in range(nx + 1)], float)
    fives = [[(0, 1, 2, 4), (3, 1, 2, 7), (5, 1, 4, 7), (6, 2, 4, 7), (1, 2, 4, 7)],
             [(1, 0, 3, 5), (2, 0, 3, 6), (4, 0, 5, 6), (7, 3, 5, 6), (0, 3, 5, 6)]]
    sixes = [tuple(np.cumsum((0,) + order)) for order in itertools.permutations((1, 2, 4))]
    tets = []
    for k, j, i in itertools.product(range(nz), range(ny), range(nx)):
        if keep and not keep(i, j, k):
            continue
        corner = [at(i + (b & 1), j + (b >> 1 & 1), k + (b >> 2)) for b in range(8)]
        tets += [[corner[b] for b in t] for t in (sixes if per_cube == 6 else fives[(i + j + k) % 2])]
    tets = wound(points, tets)
    inner = np.all((points > 0) & (points < size), axis=1)
    moved = points + jitter * rng.uniform(-0.5, 0.5, points.shape) * inner[:, None]
    for _ in range(8):  # what a move has turned over goes back
        bad = np.unique(tets[determinants(moved, tets) <= 0])
        moved[bad] = points[bad]
    return compact(moved, tets)


def compact(points, tets):
    used, ids = np.unique(tets, return_inverse=True)
    return points[used], ids.reshape(-1, 4)


def joined(a, b):
    return np.concatenate([a[0], b[0]]), np.concatenate([a[1], b[1] + len(a[0])])


def welded(points, tets, places):
    """Makes one point of the points at each of these places."""
    tets = tets.copy()
    for place in places:
        same = np.flatnonzero(np.all(points == place, axis=1))
        tets[np.isin(tets, same)] = same[0]
    return compact(points, tets)


def nearest(points, place):
    return int(np.argmin(np.sum((points - place) ** 2, axis=1)))


def block(rng):
    return lattice(rng, rng.integers(4, 7, 3), rng.choice([5, 6]), rng.choice([0, 0.3, 0.6]))


def torus(rng):
    return lattice(rng, (7, 7, 4), 6, 0.2, lambda i, j, k: not (i == 3 and j == 3))


def cavity(rng):
    return lattice(rng, (7, 6, 6), 5, 0.2, lambda i, j, k: not (i == 3 and j == 3 and k in (2, 3)))


def sponge(rng):
    gone = {tuple(c) for c in rng.integers(1, 6, (10, 3))}
    return lattice(rng, (7, 7, 7), 6, 0.2, lambda *cube: cube not in gone)


def shells(rng):
    hollow = lambda i, j, k: not all(2 <= c < 5 for c in (i, j, k))
    points, tets = lattice(rng, (5, 5, 5), 6, 0.4)
    return joined(lattice(rng, (7, 7, 7), 6, 0.2, hollow), (0.5 * points + 2.25, tets))


def two_at_a_vertex(rng):
    a = lattice(rng, (5, 5, 5), 6, 0.4)
    return welded(*joined(a, (a[0] + 5, a[1])), [(5, 5, 5)])


def two_at_an_edge(rng):
    a = lattice(rng, (5, 5, 4), 6, 0.4)
    return welded(*joined(a, (a[0] + (5, 5, 0), a[1])), [(5, 5, z) for z in range(5)])


def crack(rng):
    points, tets = lattice(rng, (6, 6, 6), 6)
    sheet = np.flatnonzero((points[:, 2] == 3) & np.all((points[:, :2] > 1) & (points[:, :2] < 5), axis=1))
    double = np.arange(len(points))
    double[sheet] = len(points) + np.arange(len(sheet))
    above = points[tets].mean(axis=1)[:, 2] > 3
    tets[above] = double[tets[above]]
    return np.concatenate([points, points[sheet]]), tets


def layers(rng):
    points, tets = lattice(rng, (5, 5, 7), 6)
    points[:, 2] = (2.0 ** (2 * points[:, 2]) - 1) / 1e4
    return points, tets


def single(rng):
    return np.eye(4, 3), [[0, 1, 2, 3]]


def star(rng):
    """One inner vertex: the middle of an octahedron whose faces are split."""
    corners = np.concatenate([np.eye(3), -np.eye(3), [[0, 0, 0]]])
    return corners, wound(corners, [(x, y, z, 6) for x in (0, 3) for y in (1, 4) for z in (2, 5)])


def face_of_three_cells(rng):
    points, tets = block(rng)
    cell = tets[len(tets) // 2]
    extra = points[cell].mean(axis=0) + 0.1
    return np.concatenate([points, [extra]]), np.concatenate([tets, [[*cell[:3], len(points)]]])


def duplicates(rng):
    points, tets = block(rng)
    some = tets[rng.integers(0, len(tets), 3)]
    return points, np.concatenate([tets, some, some[:1][:, [1, 2, 0, 3]]])


def vertex_named_twice(rng):
    points, tets = block(rng)
    some = tets[rng.integers(0, len(tets), 2)]
    some[:, 1] = some[:, 0]
    return points, np.concatenate([tets, some])


def folded(rng):
    points, tets = lattice(rng, (7, 6, 6), 6)
    points[nearest(points, (3, 3, 3))] += (1.4, 0.3, 0.2)
    return points, tets


def collapsed(rng):
    points, tets = lattice(rng, (7, 6, 6), 6, 0.2)
    points[nearest(points, (2, 3, 3))] = points[nearest(points, (3, 3, 3))]
    return points, tets


def all_in_one_place(rng):
    return np.tile(rng.random(3), (30, 1)), rng.integers(0, 30, (40, 4))


def soup(rng):
    return rng.random((60, 3)), rng.integers(0, 60, (100, 4))


SHAPES = [block, torus, cavity, sponge, shells, two_at_a_vertex, two_at_an_edge, crack, layers, single, star,
          face_of_three_cells, duplicates, vertex_named_twice, folded, collapsed, all_in_one_place, soup]
PLACES = {"plain": (1.0, 0.0, "f8"), "float32": (1.0, 0.0, "f4"), "far": (1.0, 1e5, "f8"), "far float32": (1.0, 1e5, "f4"),
          "very far float32": (1.0, 1e7, "f4"), "huge": (1e30, 0.0, "f4"), "tiny": (1e-30, 0.0, "f4"), "flat": (1.0, 0.0, "f8"),
          "needle": (1.0, 0.0, "f4")}
STRETCHED = {"flat": (1, 1, 1e-6), "needle": (1, 1, 1000)}


# ---- A mesh from its number: shape, place, winding, order, arrays, options ----

def make_mesh(rng, shape, place):
    points, tets = SHAPES[shape](rng)
    scale, offset, dtype = PLACES[place]
    points = (points * STRETCHED.get(place, (1, 1, 1)) * scale + offset).astype(dtype)
    tets = np.array(tets)
    winding = rng.choice(["right", "all wrong", "half wrong"])
    wrong = {"right": tets[:, 0] < 0, "all wrong": tets[:, 0] >= 0, "half wrong": rng.random(len(tets)) < 0.5}[winding]
    tets[wrong] = tets[wrong][:, [1, 0, 2, 3]]
    if rng.random() < 0.5:
        order = rng.permutation(len(points))
        points, tets = points[order], np.argsort(order)[tets][rng.permutation(len(tets))]
    if rng.random() < 0.2:  # points that no cell uses
        points = np.concatenate([points[:1], points])
        tets = tets + 1
    others = []
    if rng.random() < 0.4:
        for kind in rng.choice([VERTEX, LINE, TRIANGLE], 6):
            corners = {VERTEX: 1, LINE: 2, TRIANGLE: 3}[kind]
            others.append((int(kind), tets[rng.integers(len(tets))][:corners]))
    return Mesh(points, tets, others)


def dress(rng, mesh):
    """Adds arrays of many kinds; 'point' and 'cell' number the rows."""
    points, cells = len(mesh.points), mesh.cells
    x = mesh.points.astype("f8")
    middle, size = x.mean(axis=0), max(np.ptp(x, axis=0).max(), 1e-300)
    wave = np.sin(3 * (x - middle) @ SLOPE / size)
    mesh.point_data = {
        "wave": wave.astype("f4"), "point": np.arange(points, dtype="i4"), "linear": mesh.points.astype("f8") @ SLOPE + OFFSET,
        "vector": rng.normal(size=(points, 3)), "bytes": rng.integers(0, 256, (points, 2)).astype("u1"),
        "wide": rng.integers(-2**62, 2**62, points), "constant": np.full(points, 3.25, "f4")}
    mesh.cell_data = {"cell": np.arange(cells, dtype="i8"), "noise": rng.normal(size=(cells, 2)).astype("f4")}
    for name in rng.choice(ODD_NAMES, 2, replace=False):
        mesh.point_data[str(name)], mesh.cell_data[str(name)] = wave.copy(), rng.normal(size=cells)
    if rng.random() < 0.25:
        holes = wave.astype("f4")
        holes[rng.integers(0, points, 1 + points // 100)] = rng.choice([np.nan, np.inf, -np.inf])
        mesh.point_data = {"holes": holes, **mesh.point_data}
    if rng.random() < 0.4:
        along = x[mesh.tets].mean(axis=1)[:, rng.integers(3)]
        region = np.searchsorted(np.quantile(along, [0.35, 0.7]), along)
        mesh.cell_data["Material"] = np.append(region, np.zeros(len(mesh.others))).astype(rng.choice(["i1", "u4", "i8"]))
        mesh.regions = "Material"


def choose_options(rng, mesh):
    options = ["--threads", str(rng.integers(1, 4)), "--chunk-tets", "600" if len(mesh.points) % 5 == 0 else "200k"]
    fuse = rng.random() < 0.5
    if fuse:
        options += ["--min-quality", str(rng.choice(["0", "0.1", "0.22"])), "--max-rms", str(rng.choice(["1%", "20%"]))]
    else:
        options += ["--method", "tetfuse", "--scalar-tolerance", str(rng.choice(["off", "off", "2.5%", "0.01,0.2"])),
                    "--stretch-factor", str(rng.choice(["off", "5", "1.5,10"])),
                    "--boundary-rule", str(rng.choice(["vertices", "tets"]))]
        if rng.random() < 0.2:
            options += ["--aspect-ratio", "4"]
    if mesh.regions and rng.random() < 0.3:
        options, mesh.regions = options + ["--regions", "none"], None
    goal = 1
    if rng.random() < 0.4 or (fuse and not mesh.point_data):
        goal = int(rng.integers(1, len(mesh.tets) + 2))
        options += ["--tets", str(goal)]
    return options, goal


# ---- Writing ----

def array_text(name, values, appended, compress):
    values = np.ascontiguousarray(values)
    raw = values.tobytes()
    if compress:
        block = zlib.compress(raw)
        data = np.array([1, len(raw), 0, len(block)], "u8").tobytes() + block
    else:
        data = np.uint64(len(raw)).tobytes() + raw
    offset = sum(map(len, appended))
    appended.append(data)
    components = values.shape[1] if values.ndim > 1 else 1
    quoted = quoteattr(name, {"\t": "&#9;"})
    return (f'<DataArray type="{NAMES[values.dtype.str[1:]]}" Name={quoted} NumberOfComponents="{components}" '
            f'format="appended" offset="{offset}"/>')


def write(path, mesh, compress=False):
    cells = [ids for ids in mesh.tets] + [ids for _, ids in mesh.others]
    types = [TETRAHEDRON] * len(mesh.tets) + [kind for kind, _ in mesh.others]
    sections = {"PointData": mesh.point_data, "CellData": mesh.cell_data, "Points": {"Points": mesh.points},
                "Cells": {"connectivity": np.concatenate(cells).astype("i8"),
                          "offsets": np.cumsum([len(c) for c in cells], dtype="i8"), "types": np.array(types, "u1")}}
    appended = []
    body = "\n".join(f"<{tag}>" + "\n".join(array_text(n, a, appended, compress) for n, a in arrays.items()) + f"</{tag}>"
                     for tag, arrays in sections.items())
    compressor = ' compressor="vtkZLibDataCompressor"' if compress else ""
    head = (f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
            f'header_type="UInt64"{compressor}>\n<UnstructuredGrid><Piece NumberOfPoints="{len(mesh.points)}" '
            f'NumberOfCells="{mesh.cells}">\n{body}\n</Piece></UnstructuredGrid>\n<AppendedData encoding="raw">\n_')
    path.write_bytes(head.encode() + b"".join(appended) + b"\n</AppendedData></VTKFile>\n")


# ---- Judging ----

def exact_sign(corners):
    p = [[Fraction(float(c)) for c in corner] for corner in corners]
    u, v, w = ([p[k][i] - p[0][i] for i in range(3)] for k in (1, 2, 3))
    det = (u[1] * v[2] - u[2] * v[1]) * w[0] + (u[2] * v[0] - u[0] * v[2]) * w[1] + (u[0] * v[1] - u[1] * v[0]) * w[2]
    return (det > 0) - (det < 0)


def same_bits(a, b):
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


def rows(values):
    return np.ascontiguousarray(values).reshape(len(values), -1)


def faces_of(tets, labels):
    """Faces, as sorted ids -> the cells' labels."""
    faces = defaultdict(list)
    for tet, label in zip(np.sort(tets, axis=1).tolist(), labels):
        if len(set(tet)) == 4:
            for face in itertools.combinations(tet, 3):
                faces[face].append(label)
    return faces


def place_keys(before, after):
    both = np.concatenate([before, after]) + 0.0
    _, keys = np.unique(both, axis=0, return_inverse=True)
    return keys[:len(before)], keys[len(before):]


class Judge:
    """Traces a result to its input. `fail` is called with a sentence for each broken promise."""

    def __init__(self, mesh, path, fail):
        self.mesh, self.fail = mesh, fail
        mesh.point_data, mesh.cell_data = independent_check.named(mesh.point_data), independent_check.named(mesh.cell_data)
        self.result = independent_check.Vtu(path)
        self.point = {n: values for n, (_, values) in self.result.arrays["point"].items()}
        self.cell = {n: values for n, (_, values) in self.result.arrays["cell"].items()}
        self.key_before, self.key_after = place_keys(mesh.points, self.result.points)
        self.cell_ids = self.cell["cell"].ravel()

    def judge(self, options, goal):
        tets = len(self.result.tets)
        if tets < min(goal, len(self.mesh.tets)):
            self.fail(f"{tets} tetrahedra are fewer than the goal of {goal}")
        changed = self.changed_tets()
        self.judge_cell_values(changed, may_be_means="tetfuse" not in options)
        self.judge_carried_cells()
        self.judge_signs(changed)
        before = faces_of(self.mesh.tets, range(len(self.mesh.tets)))
        self.judge_faces(before)
        if "tets" in options:  # boundary tetrahedra stay
            boundary = {v for face, cells in before.items() if len(cells) == 1 for v in face}
            near = [t for t, tet in enumerate(self.mesh.tets) if boundary & set(tet.tolist())]
            stayed = set(self.cell_ids[:tets][~changed].tolist())
            if not stayed.issuperset(near):
                self.fail("a boundary tetrahedron is gone, or another one")
        self.judge_fixed_points(before)
        self.judge_point_values()
        self.judge_linear_field()

    def judge_cell_values(self, changed, may_be_means):
        if len(np.unique(self.cell_ids)) != len(self.cell_ids):
            self.fail("a cell is there twice")
        for name, values in self.mesh.cell_data.items():
            before, after = rows(values), rows(self.cell[name])
            if same_bits(after, before[self.cell_ids]):
                continue
            if may_be_means and before.dtype.kind == "f" and name != self.mesh.regions:
                self.judge_means(name, before, after, changed)
            else:
                self.fail(f"surviving cells have other values of {name!r}")

    def judge_means(self, name, before, after, changed):
        """Those of changed tetrahedra are within the range; others have their own, but where cells lie over each other."""
        tets = len(self.result.tets)
        own = before[self.cell_ids]
        differ = np.array([not same_bits(a, b) for a, b in zip(after, own)])
        if np.any(differ[tets:]):
            self.fail(f"carried cells have other values of {name!r}")
        inside = before[:len(self.mesh.tets)]
        for t in np.flatnonzero(differ[:tets]):
            if not changed[t] and not self.is_overlapped(self.cell_ids[t]):
                self.fail(f"cell {t} is as it was but for its value of {name!r}")
            elif not np.all((after[t] >= inside.min(axis=0)) & (after[t] <= inside.max(axis=0))):
                self.fail(f"cell {t} has a value of {name!r} beyond its range")

    def is_overlapped(self, cell):
        """Has another cell its centre in it?"""
        corners = self.mesh.points[self.mesh.tets].astype(float)
        centres = np.delete(corners.mean(axis=1), cell, axis=0)
        edges = (corners[cell][1:] - corners[cell][0]).T
        if np.linalg.det(edges) == 0:
            return True
        weights = np.linalg.solve(edges, (centres - corners[cell][0]).T)
        return bool(np.any((weights.min(axis=0) >= -1e-9) & (weights.sum(axis=0) <= 1 + 1e-9)))

    def judge_carried_cells(self):
        tets = len(self.mesh.tets)
        carried = self.cell_ids[len(self.result.tets):]
        if carried.tolist() != list(range(tets, self.mesh.cells)):
            self.fail("carried cells are lost or in another order")
        for (kind, ids), (kind_after, ids_after) in zip(self.mesh.others, self.result.others):
            if kind != kind_after or not np.array_equal(self.key_before[ids], self.key_after[ids_after]):
                self.fail("a carried cell has other points")

    def changed_tets(self):
        was = np.sort(self.key_before[self.mesh.tets[self.cell_ids[:len(self.result.tets)]]], axis=1)
        return np.any(was != np.sort(self.key_after[self.result.tets], axis=1), axis=1)

    def judge_signs(self, changed):
        corners = self.result.points[self.result.tets]
        flipped = [t for t in np.flatnonzero(changed) if exact_sign(corners[t]) <= 0]
        if flipped:
            self.fail(f"tetrahedron {flipped[0]} and {len(flipped) - 1} more were turned over or flattened")

    def judge_faces(self, before):
        after = faces_of(self.result.tets, self.cell_ids[:len(self.result.tets)].tolist())

        def places(faces, keys, chosen):
            return Counter(tuple(sorted(keys[list(face)])) for face, cells in faces.items() if chosen(cells))

        region = self.mesh.cell_data.get(self.mesh.regions)
        kinds = {"boundary": lambda cells: len(cells) == 1, "overfull": lambda cells: len(cells) > 2,
                 "interface": lambda cells: region is not None and len(set(region[cells].tolist())) > 1}
        for name, chosen in kinds.items():
            if places(before, self.key_before, chosen) != places(after, self.key_after, chosen):
                self.fail(f"the {name} faces are others")

    def judge_fixed_points(self, before):
        """Boundary, interface and carried points are still there with all their values; so are NaN's."""
        fixed = {v for face, cells in before.items() if len(cells) != 2 for v in face}
        fixed.update(int(v) for _, ids in self.mesh.others for v in ids)
        holes = self.mesh.point_data.get("holes")
        if holes is not None:  # the first array: it steers
            fixed.update(set(np.flatnonzero(~np.isfinite(holes)).tolist()) & set(self.mesh.tets.ravel().tolist()))
        found = {(number, key): p for p, (number, key) in enumerate(zip(self.point["point"].ravel(), self.key_after))}
        fixed = np.array(sorted(fixed), np.int64)
        at = np.array([found.get((p, self.key_before[p]), -1) for p in fixed], np.int64)
        if np.any(at < 0):
            self.fail(f"{np.count_nonzero(at < 0)} points that must stay are gone")
            return
        for name, values in self.mesh.point_data.items():
            if not same_bits(rows(self.point[name])[at], rows(values)[fixed]):
                self.fail(f"points that stay have other values of {name!r}")

    def judge_point_values(self):
        for name, values in self.mesh.point_data.items():
            before, after = rows(values), rows(self.point[name])
            if before.dtype.kind != "f":
                if not set(map(tuple, after.tolist())) <= set(map(tuple, before.tolist())):
                    self.fail(f"integer array {name!r} has values that its input has not")
            elif np.isfinite(before).all():
                if np.any(after > before.max(axis=0)) or np.any(after < before.min(axis=0)) or np.isnan(after).any():
                    self.fail(f"array {name!r} leaves its range")

    def judge_linear_field(self):
        points = self.result.points.astype(np.longdouble)
        error = np.abs(points @ SLOPE.astype(np.longdouble) + OFFSET - self.point["linear"].ravel())
        size = float(np.abs(self.mesh.points).max(axis=0) @ np.abs(SLOPE)) + abs(OFFSET)
        # Each pass rounds a position once, and there are not many passes.
        if error.max() > 20 * np.finfo(self.mesh.points.dtype).eps * size:
            self.fail(f"a linear field is off by {float(error.max()):g}")


class Corpus(unittest.TestCase):
    judged = fused = 0

    @classmethod
    def tearDownClass(cls):
        # A mesh that comes back as it was proves little.
        if cls.judged > 20 and 3 * cls.fused < cls.judged:
            raise AssertionError(f"only {cls.fused} of {cls.judged} meshes were simplified at all")

    def run_case(self, number, shape, place):
        rng = np.random.default_rng(number)
        mesh = make_mesh(rng, shape, place)
        dress(rng, mesh)
        options, goal = choose_options(rng, mesh)
        encoding = str(rng.choice(["raw", "zlib", "inline", "ascii"]))
        with tempfile.TemporaryDirectory() as folder:
            before, after, report = (pathlib.Path(folder) / name for name in ("in.vtu", "out.vtu", "report.json"))
            write(before, mesh, compress=number % 3 == 0)
            command = [COMMAND, "simplify", before, "-o", after, "--report", report, "--encoding", encoding, *options]
            result = subprocess.run(command, capture_output=True, text=True, timeout=60)
            problems = [" ".join(options)]
            self.assertEqual(result.returncode, 0, problems + [result.stderr])
            problems += self.judge_pair(before, after)
            Judge(mesh, after, problems.append).judge(options, goal)
            tets = len(independent_check.Vtu(after).tets)
            self.assertEqual(json.loads(report.read_text())["output"]["tets"], tets)
            Corpus.judged += 1
            Corpus.fused += tets < len(mesh.tets)
            self.assertEqual(problems[1:], [], problems[0])

    def judge_pair(self, before, after):
        judged = [independent_check.load(path, path.name) for path in (before, after)]
        return independent_check.judge_pair(*judged, False)[1]


def add_case(number, shape, place):
    name = f"test_{number:03}_{SHAPES[shape].__name__}_{place.replace(' ', '_')}"
    setattr(Corpus, name, lambda self: self.run_case(number, shape, place))


# Every shape at three places, and the plainest one at all of them.
for case in range(3 * len(SHAPES)):
    add_case(case, case % len(SHAPES), list(PLACES)[(case + case // len(SHAPES)) % len(PLACES)])
for case, name_of_place in enumerate(PLACES):
    add_case(100 + case, 0, name_of_place)

if __name__ == "__main__":
    COMMAND = sys.argv.pop(1)
    unittest.main()
