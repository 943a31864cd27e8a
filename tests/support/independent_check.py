#!/usr/bin/env python3
"""Judges what a simplification did, with nothing of TetFusion's: Python, numpy and a reader of its own.

    independent_check.py ORIGINAL.vtu SIMPLIFIED.vtu     exact boundary: the surface must be the same
    independent_check.py --free-boundary ORIGINAL.vtu SIMPLIFIED.vtu
    independent_check.py ONE.vtu                         counts only

Exit code 0 when all of these hold for SIMPLIFIED, else 1 and the reasons in "failures" (2: usage, unreadable file):
  - indices in range, offsets and arrays as long as they should be, coordinates finite;
  - no more inverted, degenerate or duplicate cells, fold-over faces or faces with more than two cells than ORIGINAL;
  - the boundary triangles, as coordinates, are the same, and so are the values of point arrays at their corners;
  - the volume is equal within 1e-12;
  - every array of ORIGINAL is there with the same name, type and components, and so are cells that are no tetrahedra.
Prints its numbers as JSON. Reads .vtu with appended raw data (plain or zlib), inline binary and ascii; several
pieces; little-endian.
"""
import argparse
import base64
import json
import re
import sys
import xml.etree.ElementTree as ElementTree
import zlib

try:
    import numpy as np
except ImportError:
    sys.exit("independent_check.py needs numpy (apt-get install python3-numpy, then /usr/bin/python3)")

DTYPES = {"Int8": "i1", "UInt8": "u1", "Int16": "<i2", "UInt16": "<u2", "Int32": "<i4", "UInt32": "<u4",
          "Int64": "<i8", "UInt64": "<u8", "Float32": "<f4", "Float64": "<f8"}
TETRAHEDRON = 10
# Volumes that rounding in double precision could make of nothing, as a share of the three edges' product.
NO_VOLUME = 5e-16


class Vtu:
    """A .vtu: points (n, 3), tets (m, 4), other cells as (type, ids), arrays[association][name]."""

    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        start = re.search(rb"<AppendedData[^>]*>\s*_", data)
        self.appended = data[start.end():] if start else b""
        head = data if start is None else data[:start.start()] + b"</VTKFile>"
        root = ElementTree.fromstring(head)
        if root.get("byte_order") == "BigEndian":
            raise ValueError("big-endian files are not read")
        compressor = root.get("compressor")
        if compressor not in (None, "vtkZLibDataCompressor"):
            raise ValueError(compressor + " is not read")
        self.compressed = compressor is not None
        self.header = np.dtype(DTYPES[root.get("header_type", "UInt32")])
        grid = root.find("UnstructuredGrid")
        pieces = [self.read_piece(p) for p in grid.findall("Piece")]
        self.join(pieces)
        self.arrays["field"] = {a.get("Name"): self.describe(a) for a in self.data_arrays(grid.find("FieldData"))}

    @staticmethod
    def data_arrays(node):
        return [] if node is None else [a for a in node if a.tag in ("DataArray", "Array")]

    @staticmethod
    def describe(node):
        return node.get("type"), int(node.get("NumberOfComponents", "1"))

    def join(self, pieces):
        shifts = np.cumsum([0] + [len(p["points"]) for p in pieces])
        self.points = np.concatenate([p["points"] for p in pieces])
        self.tets = np.concatenate([p["tets"] + s for p, s in zip(pieces, shifts)])
        self.others = [(t, ids + s) for p, s in zip(pieces, shifts) for t, ids in p["others"]]
        self.cells = sum(p["cells"] for p in pieces)
        self.out_of_range = sum(p["out_of_range"] for p in pieces)
        self.arrays = {}
        for kind in ("point", "cell"):
            self.arrays[kind] = {name: (info, np.concatenate([p[kind][name][1] for p in pieces]))
                                 for name, (info, _) in pieces[0][kind].items()}

    def read_piece(self, node):
        points, cells = int(node.get("NumberOfPoints")), int(node.get("NumberOfCells"))
        piece = {"points": self.values(node.find("Points")[0], points).reshape(points, 3), "cells": cells}
        parts = {a.get("Name"): self.values(a) for a in node.find("Cells")}
        ids, ends = parts["connectivity"].astype(np.int64), parts["offsets"].astype(np.int64)
        types = parts["types"]
        if len(ends) != cells or len(types) != cells or (cells and ends[-1] != len(ids)):
            raise ValueError("offsets, types and connectivity do not fit each other")
        piece["out_of_range"] = int(np.count_nonzero((ids < 0) | (ids >= points)))
        starts = np.concatenate([[0], ends[:-1]]) if cells else ends
        is_tet = types == TETRAHEDRON
        if np.any((ends - starts)[is_tet] != 4):
            raise ValueError("a tetrahedron without four vertices")
        piece["tets"] = ids[starts[is_tet][:, None] + np.arange(4)]
        piece["others"] = [(int(types[i]), ids[starts[i]:ends[i]]) for i in np.flatnonzero(~is_tet)]
        for kind, tag, tuples in (("point", "PointData", points), ("cell", "CellData", cells)):
            piece[kind] = {a.get("Name"): (self.describe(a), self.values(a, tuples))
                           for a in self.data_arrays(node.find(tag))}
        return piece

    def values(self, node, tuples=None):
        dtype, form = np.dtype(DTYPES[node.get("type")]), node.get("format", "appended")
        if form == "ascii":
            values = np.array((node.text or "").split(), dtype=dtype)
        elif form == "appended":
            values = np.frombuffer(self.payload(self.appended[int(node.get("offset")):]), dtype)
        else:
            values = np.frombuffer(self.payload_base64((node.text or "").strip()), dtype)
        if tuples is None:
            return values
        components = int(node.get("NumberOfComponents", "1"))
        if len(values) != tuples * components:
            raise ValueError(f"array {node.get('Name')}: {len(values)} values, not {tuples} x {components}")
        return values.reshape(tuples, components)

    def payload(self, data):
        word = self.header.itemsize
        if not self.compressed:
            size = int(np.frombuffer(data[:word], self.header)[0])
            if len(data) < word + size:
                raise ValueError("appended data is cut off")
            return data[word:word + size]
        blocks = int(np.frombuffer(data[:word], self.header)[0])
        sizes = np.frombuffer(data[3 * word:(3 + blocks) * word], self.header)
        return self.inflate(data[(3 + blocks) * word:], sizes)

    @staticmethod
    def inflate(data, sizes):
        ends = np.cumsum(sizes, dtype=np.int64)
        return b"".join(zlib.decompress(data[int(e) - int(s):int(e)]) for s, e in zip(sizes, ends))

    def payload_base64(self, text):
        if not self.compressed:
            return self.payload(base64.b64decode(text))
        # The header is encoded by itself: first its three words, to know how long it is.
        word = self.header.itemsize
        blocks = int(np.frombuffer(base64.b64decode(text[:4 * ((word + 2) // 3 + 1)])[:word], self.header)[0])
        length = 4 * (((3 + blocks) * word + 2) // 3)
        header = np.frombuffer(base64.b64decode(text[:length]), self.header)
        return self.inflate(base64.b64decode(text[length:]), header[3:3 + blocks])


def runs(rows):
    """Equal rows of a sorted 2-D array: start and length of each run."""
    if not len(rows):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    starts = np.flatnonzero(np.concatenate([[True], np.any(rows[1:] != rows[:-1], axis=1)]))
    return starts, np.diff(np.append(starts, len(rows)))


def sort_rows(rows):
    return np.lexsort(rows.T[::-1])


class Judged:
    """A mesh's defects, boundary and volume."""

    def __init__(self, mesh):
        self.mesh = mesh
        points = mesh.points.astype(np.longdouble)
        self.non_finite = int(np.count_nonzero(~np.isfinite(mesh.points)))
        tets = mesh.tets
        u, v, w = (points[tets[:, k]] - points[tets[:, 0]] for k in (1, 2, 3))
        det = np.einsum("ij,ij->i", np.cross(u, v), w)
        scale = np.sqrt(np.einsum("ij,ij->i", u, u) * np.einsum("ij,ij->i", v, v) * np.einsum("ij,ij->i", w, w))
        flat = np.abs(det) <= NO_VOLUME * scale
        self.sign = np.where(flat, 0, np.sign(det)).astype(np.int8)
        self.degenerate = int(np.count_nonzero(flat))
        self.negative = int(np.count_nonzero(self.sign < 0))
        self.volume = float(np.sum(np.abs(det)) / 6)
        rows = np.sort(tets, axis=1)
        order = sort_rows(rows)
        starts, _ = runs(rows[order])
        self.duplicates = len(tets) - len(starts)
        self.judge_faces(rows)

    def judge_faces(self, rows):
        """rows: the cells' vertices, ascending in each."""
        distinct = np.flatnonzero(np.all(np.diff(rows, axis=1) > 0, axis=1))
        rows = rows[distinct]
        cells = np.tile(distinct, 4)
        faces = np.concatenate([np.delete(rows, k, axis=1) for k in range(4)])
        apexes = np.concatenate([rows[:, k] for k in range(4)])
        order = sort_rows(faces)
        faces, apexes, cells = faces[order], apexes[order], cells[order]
        starts, lengths = runs(faces)
        self.overfull = int(np.count_nonzero(lengths > 2))
        self.boundary = faces[starts[lengths == 1]]
        first = starts[lengths == 2]
        self.foldover = self.count_foldovers(faces[first], apexes[first], apexes[first + 1],
                                             cells[first], cells[first + 1])

    def count_foldovers(self, faces, apex_a, apex_b, cell_a, cell_b):
        p = self.mesh.points.astype(np.longdouble)
        normal = np.cross(p[faces[:, 1]] - p[faces[:, 0]], p[faces[:, 2]] - p[faces[:, 0]])
        sides = [np.einsum("ij,ij->i", normal, p[apex] - p[faces[:, 0]]) > 0 for apex in (apex_a, apex_b)]
        judged = (self.sign[cell_a] != 0) & (self.sign[cell_b] != 0) & (apex_a != apex_b)
        return int(np.count_nonzero(judged & (sides[0] == sides[1])))

    def numbers(self):
        return {"points": len(self.mesh.points), "tets": len(self.mesh.tets), "cells": self.mesh.cells,
                "out_of_range": self.mesh.out_of_range, "non_finite": self.non_finite,
                "wound_the_other_way": self.negative, "degenerate": self.degenerate,
                "duplicates": self.duplicates, "foldover_faces": self.foldover, "overfull_faces": self.overfull,
                "boundary_triangles": len(self.boundary),
                "boundary_points": len(np.unique(self.boundary)), "volume": self.volume}


def places(original, simplified):
    """Ids of points by their coordinates, the same in both meshes."""
    both = np.concatenate([original.points, simplified.points.astype(original.points.dtype)]) + 0.0
    keys = np.ascontiguousarray(both).view([("", both.dtype)] * 3).ravel()
    _, ids = np.unique(keys, return_inverse=True)
    return ids[:len(original.points)], ids[len(original.points):]


def triangle_set(judged, ids):
    triangles = np.sort(ids[judged.boundary], axis=1)
    return triangles[sort_rows(triangles)]


def changed_values(original, simplified, ids):
    """Boundary points, alone at their place, at which some point array has another value."""
    kept, found = ids
    count = np.bincount(np.concatenate([kept, found]))
    a, b = np.unique(original.boundary), np.unique(simplified.boundary)
    alone = np.intersect1d(kept[a], found[b])
    alone = alone[count[alone] == 2]
    index_a, index_b = np.full(len(count), -1), np.full(len(count), -1)
    index_a[kept], index_b[found] = np.arange(len(kept)), np.arange(len(found))
    differ = np.zeros(len(alone), bool)
    for name, (_, values) in original.mesh.arrays["point"].items():
        if name not in simplified.mesh.arrays["point"]:
            continue
        x, y = values[index_a[alone]], simplified.mesh.arrays["point"][name][1][index_b[alone]]
        if x.shape == y.shape:
            differ |= np.any((x != y) & ~((x != x) & (y != y)), axis=1)
    return int(np.count_nonzero(differ))


def named(arrays):
    """With the names that results have: that of an array without one is from its place."""
    return {name or f"unnamed_{place}": entry for place, (name, entry) in enumerate(arrays.items())}


def compare_arrays(original, simplified, failures):
    for kind in ("point", "cell", "field"):
        for name, entry in named(original.arrays[kind]).items():
            want = entry if kind == "field" else entry[0]
            found = simplified.arrays[kind].get(name)
            have = found if kind == "field" or found is None else found[0]
            if have != want:
                failures.append(f"{kind} array {name}: {want} became {have}")


def judge_pair(original, simplified, free_boundary):
    failures = []
    for name in ("degenerate", "duplicates", "foldover", "overfull", "negative"):
        before, after = getattr(original, name), getattr(simplified, name)
        if after > before:
            failures.append(f"{name}: {after}, the original has {before}")
    compare_arrays(original.mesh, simplified.mesh, failures)
    if original.mesh.points.dtype != simplified.mesh.points.dtype:
        failures.append("the points have another type")
    kinds = [sorted(t for t, _ in m.mesh.others) for m in (original, simplified)]
    if kinds[0] != kinds[1]:
        failures.append(f"{len(kinds[0])} cells are no tetrahedra, now {len(kinds[1])}")
    change = abs(simplified.volume - original.volume) / original.volume if original.volume else 0.0
    result = {"reduction": 1 - len(simplified.mesh.tets) / max(1, len(original.mesh.tets)), "volume_change": change}
    if not free_boundary:
        ids = places(original.mesh, simplified.mesh)
        result["boundary_identical"] = bool(
            np.array_equal(triangle_set(original, ids[0]), triangle_set(simplified, ids[1])))
        result["boundary_values_changed"] = changed_values(original, simplified, ids)
        if not result["boundary_identical"]:
            failures.append("the boundary triangles differ")
        if result["boundary_values_changed"]:
            failures.append(f"{result['boundary_values_changed']} boundary points have other values")
        if change > 1e-12:
            failures.append(f"the volume changed by {change:.3g} of itself")
    return result, failures


def load(path, role):
    mesh = Vtu(path)
    if mesh.out_of_range:
        raise ValueError(f"{role}: {mesh.out_of_range} indices are out of range")
    judged = Judged(mesh)
    if judged.non_finite:
        raise ValueError(f"{role}: {judged.non_finite} coordinates are not finite")
    return judged


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("original")
    parser.add_argument("simplified", nargs="?")
    parser.add_argument("--free-boundary", action="store_true", help="the surface and the volume may change")
    args = parser.parse_args()
    try:
        original = load(args.original, "original")
    except (OSError, ValueError, ElementTree.ParseError, zlib.error) as error:
        print(f"{args.original}: {error}", file=sys.stderr)
        return 2
    report = {"original": original.numbers()}
    if args.simplified is None:
        print(json.dumps(report, indent=1))
        return 0
    try:
        simplified = load(args.simplified, "simplified")
        report["simplified"] = simplified.numbers()
        result, failures = judge_pair(original, simplified, args.free_boundary)
        report.update(result)
    except (OSError, ValueError, ElementTree.ParseError, zlib.error) as error:
        failures = [str(error)]
    report["failures"] = failures
    print(json.dumps(report, indent=1))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
