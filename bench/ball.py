#!/usr/bin/env python3
"""A Delaunay mesh of the unit ball by tetgen, with a point array `f` that has a front and a bump.

The surface is an icosphere that stays as it is (20,480 triangles for 1M); the inside is tetgen's, so that vertices lie where
its refinement put them, and in its order, in which neighbours are far apart: --ordered puts them along a curve. The count is
met within a few per cent: a mesh of an eighth of the size is made first, to see what bound on the volume gives how many.
"""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np

import raw_vtu

UNITS = {"k": 10**3, "M": 10**6, "G": 10**9}
SMALLEST = 2000  # tetrahedra; below it the surface alone decides the count


def number(text):
    return int(float(text[:-1]) * UNITS[text[-1]]) if text[-1] in UNITS else int(text)


def icosphere(subdivisions):
    """Points and triangles, wound outwards: 20 * 4**subdivisions of them."""
    golden = (1 + 5**0.5) / 2
    points = np.array([(0, a, b * golden) for a in (-1, 1) for b in (-1, 1)])
    points = np.concatenate([points, points[:, [2, 0, 1]], points[:, [1, 2, 0]]])
    distance = np.linalg.norm(points[:, None] - points[None], axis=2)
    near = (distance < 2.1) & (distance > 0)
    triangles = np.array([(a, b, c) for a in range(12) for b in range(a + 1, 12) for c in range(b + 1, 12)
                          if near[a, b] and near[b, c] and near[a, c]])
    inward = np.einsum("ij,ij->i", np.cross(points[triangles[:, 0]], points[triangles[:, 1]]), points[triangles[:, 2]]) < 0
    triangles[inward] = triangles[inward][:, [0, 2, 1]]
    for _ in range(subdivisions):
        edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
        unique, inverse = np.unique(edges, axis=0, return_inverse=True)
        ab, bc, ca = (len(points) + inverse.reshape(3, -1))
        a, b, c = triangles.T
        points = np.concatenate([points, points[unique].mean(axis=1)])
        triangles = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
    return points / np.linalg.norm(points, axis=1, keepdims=True), triangles


def table(path, columns, kind):
    """The rows of one of tetgen's files, without their running numbers; a comment ends it."""
    with open(path) as file:
        rows = int(file.readline().split()[0])
        values = np.fromfile(file, kind, rows * columns, sep=" ")
    return values.reshape(rows, columns)[:, 1:]


def mesh_ball(surface, volume_bound):
    """Points and tetrahedra, wound for positive volume."""
    points, triangles = surface
    with tempfile.TemporaryDirectory() as folder:
        base = pathlib.Path(folder) / "ball"
        with open(base.with_suffix(".smesh"), "w") as file:
            file.write(f"{len(points)} 3 0 0\n")
            np.savetxt(file, np.column_stack([np.arange(len(points)), points]), "%d %.17g %.17g %.17g")
            file.write(f"{len(triangles)} 0\n")
            np.savetxt(file, np.column_stack([np.full(len(triangles), 3), triangles]), "%d")
            file.write("0\n0\n")
        result = subprocess.run(["tetgen", f"-pq1.4Ya{volume_bound:.12f}BFQ", base.with_suffix(".smesh")], text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        if result.returncode != 0:
            sys.exit(f"tetgen ended with {result.returncode}: {result.stdout[-500:]}")
        points = table(f"{base}.1.node", 4, "f8")
        tets = table(f"{base}.1.ele", 5, "i8")
    p = points[tets]
    volume = np.einsum("ij,ij->i", np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), p[:, 3] - p[:, 0])
    if volume.sum() < 0:
        tets = tets[:, [1, 0, 2, 3]]
    return points, tets


def field(points):
    """A front that is a twentieth wide, and a bump."""
    x, y, z = points.T
    front = np.tanh(20 * (x + 0.3 * np.sin(3 * y) + 0.2 * z))
    return front + np.exp(-((points - (0.2, -0.4, 0.3))**2).sum(axis=1) / 0.02)


def order(points):
    """Along a Z curve with 1024 cells a side."""
    low, high = points.min(axis=0), points.max(axis=0)
    cells = ((points - low) / (high - low) * 1023).astype("i8")
    code = np.zeros(len(points), "i8")
    for bit in range(10):
        for axis in range(3):
            code |= (cells[:, axis] >> bit & 1) << (3 * bit + axis)
    return np.argsort(code, kind="stable")


def reorder(points, tets):
    old_of_new = order(points)
    new_of_old = np.empty(len(points), "i8")
    new_of_old[old_of_new] = np.arange(len(points))
    return points[old_of_new], new_of_old[tets[order(points[tets].mean(axis=1))]]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tets", type=number, default=10**6, help="about so many, as in 1M, 300k; default 1M")
    parser.add_argument("--ordered", action="store_true", help="points and tetrahedra along a space-filling curve")
    parser.add_argument("out", metavar="OUT.vtu", type=pathlib.Path)
    args = parser.parse_args()
    if not shutil.which("tetgen"):
        sys.exit("tetgen is not there: install it (apt-get install tetgen)")
    if args.tets < SMALLEST:
        sys.exit(f"--tets {args.tets}: at least {SMALLEST}")
    subdivisions = round(5 + np.log(args.tets / 10**6) / np.log(8))
    mean = 4 / 3 * np.pi / args.tets
    trial = mesh_ball(icosphere(subdivisions - 1), 8 * 1.8 * mean)[1]
    print(f"trial: {len(trial)} tetrahedra of {args.tets // 8}", flush=True)
    points, tets = mesh_ball(icosphere(subdivisions), 1.8 * mean * 8 * len(trial) / args.tets)
    if args.ordered:
        points, tets = reorder(points, tets)
    part = args.out.with_name(args.out.name + ".part")
    raw_vtu.write(part, raw_vtu.Mesh(points, tets, {"f": field(points)}))
    os.replace(part, args.out)
    print(f"{args.out}: {len(points)} points, {len(tets)} tetrahedra, {20 * 4**subdivisions} boundary triangles")


if __name__ == "__main__":
    main()
