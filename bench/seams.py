#!/usr/bin/env python3
"""Seams: what cutting a mesh into chunks leaves behind in the result. One chunk against hundreds, on the same mesh.

Usage: seams.py TETFUSION WORK_FOLDER [--tets 2.5M] [--kind kuhn] [--chunk-tets 10k] [--goals none,50%] ...  (--help)
Where interfaces were is not written anywhere, so this is a statistical proxy. The unit box is divided into small boxes,
those at the surface are left out, and tetrahedra are counted by their centroids; std and quantiles are in per cent of the
mean. Seams that are denser or coarser than the rest widen the distribution of these counts: with hundreds of chunks a good
part of the mesh lies next to an interface. Errors are those of the field `temperature` at centroids, in per cent of its
range. By default the mesh is equally fine everywhere, and neither fields nor regions steer. Needs numpy. Writes seams.csv.
"""
import argparse
import sys

import numpy as np

import raw_vtu
from measure import add_mesh_options, prepare, print_table, simplify, write_csv

TETS_A_BOX = (60, 500)  # about: a box narrower than a chunk, and one that averages noise away


def temperature(p):
    """The field of that name, as src/generate makes it."""
    bump = lambda x, y, z, width: 1 / (1 + ((p - (x, y, z)) ** 2).sum(axis=1) / width ** 2)
    return 300 + 80 * bump(0.3, 0.4, 0.6, 0.2) - 50 * bump(0.8, 0.7, 0.2, 0.3) + 20 * p[:, 2]


def centroids_and_errors(path):
    """Of each tetrahedron its centroid, and how far the field is off there, as a share of the field's range."""
    mesh = raw_vtu.read(path)
    values = mesh.point_data["temperature"].astype("f8")
    centroids = mesh.points.astype("f8")[mesh.tets].mean(axis=1)
    return centroids, np.abs(values[mesh.tets].mean(axis=1) - temperature(centroids)) / np.ptp(values)


def distributions(centroids, errors, side):
    """Tetrahedra in each inner box of a grid, and the mean error there, 0 for an empty one."""
    at = np.ravel_multi_index(np.minimum((centroids * side).astype("i8"), side - 1).T, (side,) * 3)
    counts = np.bincount(at, minlength=side ** 3).reshape((side,) * 3)[1:-1, 1:-1, 1:-1].ravel()
    sums = np.bincount(at, errors, minlength=side ** 3).reshape((side,) * 3)[1:-1, 1:-1, 1:-1].ravel()
    return counts.astype("f8"), sums / np.maximum(counts, 1)


def measure(args, mesh, goal, chunk_tets):
    out = args.work / f"seams_{chunk_tets}.vtu"
    goal_options = [] if goal == "none" else ["--reduction", goal]
    run = simplify(args.command, mesh, out, ["--chunk-tets", chunk_tets, *goal_options, *args.options.split()])
    if run.status != 0:
        sys.exit(f"--chunk-tets {chunk_tets}: exit code {run.status}: {run.stderr}")
    return run.report, *centroids_and_errors(out)


def figures(goal, report, centroids, errors, side):
    counts, box_errors = distributions(centroids, errors, side)
    mean = counts.mean()
    low, high = np.quantile(counts, (0.01, 0.99))
    return {"goal": goal, "chunks": report["chunks"], "rounds": len(report["lods"]),
            "reduction %": 100 * report["reduction"], "boxes": len(counts), "tets a box": mean,
            "std": 100 * counts.std() / mean, "1 %": 100 * low / mean, "99 %": 100 * high / mean,
            "error": 100 * errors.mean(), "error, 99 %": 100 * np.quantile(errors, 0.99),
            "error, std of boxes": 100 * box_errors.std()}


def against(one, many):
    """Differences: points of what is in per cent of a mean, else in per cent of the one chunk's figure."""
    row = {name: many[name] for name in ("goal", "chunks", "boxes")}
    for name in ("reduction %", "std", "1 %", "99 %"):
        row[name] = f"{many[name] - one[name]:+.2f}"
    for name in ("tets a box", "error", "error, 99 %", "error, std of boxes"):
        row[name] = f"{100 * (many[name] / one[name] - 1):+.2f} %"
    return row


def rounded(row):
    return {name: float(f"{value:.5g}") if isinstance(value, float) else value for name, value in row.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_mesh_options(parser, "2.5M")
    parser.set_defaults(kind="kuhn", options="--method tetfuse --regions none --scalar-tolerance off")
    parser.add_argument("--chunk-tets", default="10k", help="of the run with many chunks")
    parser.add_argument("--goals", default="none,50%", help="reductions; none is until nothing fuses")
    args = parser.parse_args()
    mesh = prepare(args)
    rows, differences = [], []
    for goal in args.goals.split(","):
        one, many = (measure(args, mesh, goal, chunk_tets) for chunk_tets in ("100M", args.chunk_tets))
        for tets_a_box in TETS_A_BOX:
            side = max(4, round((one[0]["output"]["tets"] / tets_a_box) ** (1 / 3)))
            pair = [figures(goal, *measured, side) for measured in (one, many)]
            rows += [rounded(row) for row in pair]
            differences.append(against(*pair))
    print(f"{mesh.name}, simplify {args.options}\n")
    print_table(rows)
    print("Many chunks against one: what is in per cent in points, the rest in per cent of one chunk's:\n")
    print_table(differences)
    write_csv(args.work / "seams.csv", rows)


if __name__ == "__main__":
    main()
