#!/usr/bin/env python3
"""A sphere of interest: what stays in it, what goes outside, and whether cells change in size by more at its edge than elsewhere.

Usage: roi.py TETFUSION WORK_FOLDER MESH.vtu --sphere X,Y,Z,RADIUS [--reduction 95%] [--options ...]
MESH is simplified to the goal with the sphere and without. "ratio" is of the volumes of two tetrahedra with a common face, the larger
over the smaller; tetrahedra without volume are left out. Needs numpy.
"""
import argparse
import pathlib
import sys

import numpy as np

from measure import print_table, simplify

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "tests" / "support"))
from independent_check import Vtu  # noqa: E402


def volumes(points, tets):
    a, b, c, d = (points[tets[:, k]] for k in range(4))
    return np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)) / 6


def ratios(points, tets):
    """Of the volumes of each two tetrahedra with a common face."""
    volume = volumes(points, tets)
    faces = np.sort(np.concatenate([np.delete(tets, k, axis=1) for k in range(4)]), axis=1)
    order = np.lexsort(faces.T)
    same = (faces[order][1:] == faces[order][:-1]).all(axis=1)
    cells = order % len(tets)
    a, b = volume[cells[:-1][same]], volume[cells[1:][same]]
    solid = np.minimum(a, b) > 1e-12 * volume.mean()
    return (np.maximum(a, b)[solid] / np.minimum(a, b)[solid])


def row(name, path, sphere, original=None):
    mesh = Vtu(path)
    points = mesh.points.astype("f8")
    inside = (((points - sphere[:3]) ** 2).sum(axis=1) <= sphere[3] ** 2)[mesh.tets].all(axis=1)
    ratio = ratios(points, mesh.tets)
    out = {"mesh": name, "tetrahedra": len(mesh.tets), "inside": int(inside.sum()), "outside": int((~inside).sum()),
           "outside less %": "", "ratio 99.9 %": round(np.percentile(ratio, 99.9), 1), "ratio max": round(ratio.max(), 1)}
    if original:
        out["outside less %"] = round(100 * (1 - out["outside"] / original["outside"]), 2)
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", metavar="TETFUSION", type=pathlib.Path)
    parser.add_argument("work", metavar="WORK_FOLDER", type=pathlib.Path)
    parser.add_argument("mesh", metavar="MESH.vtu", type=pathlib.Path)
    parser.add_argument("--sphere", required=True)
    parser.add_argument("--reduction", default="95%")
    parser.add_argument("--options", default="--boundary 0.5%%", help="for simplify; default --boundary 0.5%%")
    args = parser.parse_args()
    args.work.mkdir(parents=True, exist_ok=True)
    sphere = np.array([float(x) for x in args.sphere.split(",")])
    rows = [row("original", args.mesh, sphere)]
    goal = ["--reduction", args.reduction, *args.options.replace("%%", "%").split()]
    for name, more in (("without", []), ("with", ["--roi", "sphere=" + args.sphere])):
        out = args.work / f"roi_{name}_{args.mesh.name}"
        run = simplify(args.command.resolve(), args.mesh, out, goal + more)
        if run.status != 0:
            sys.exit(f"exit code {run.status}: {run.stderr}")
        rows.append(row(name, out, sphere, rows[0]))
    print_table(rows)


if __name__ == "__main__":
    main()
