#!/usr/bin/env python3
"""Layers of flat cells: a boundary layer round a cylinder, as of a flow past it, each layer a fifth thicker than the last;
or with --plate eight even ones that undulate, as of rock.

Cells in rings round the cylinder, in layers outwards and in slices along it, each cut into six tetrahedra; corners are moved
by a fifth of a cell along the wall, the same way in all layers, as where triangles of a wall are extruded. Point arrays: `u`,
a velocity that rises from the wall within the layers, and `p`, a pressure; of the plate `u`, and of cells `material`, one for
each two layers. The count is met within a few per cent.
"""
import argparse
import itertools
import os
import pathlib

import numpy as np

import raw_vtu
from ball import number

GROWTH = 1.2


def radii(layers, first, largest):
    heights = np.minimum(first * GROWTH ** np.arange(layers), largest)
    return 1 + np.concatenate([[0], np.cumsum(heights)])


def cut_cells(rings, layers, slices, closed=True):
    """Six tetrahedra a cell, from its first corner to its last one; points by ring, layer and slice, the rings closed or not."""
    cell = np.stack(np.meshgrid(np.arange(rings), np.arange(layers), np.arange(slices), indexing="ij"), -1).reshape(-1, 3)
    tets = []
    for order in itertools.permutations(range(3)):
        corners = [cell]
        for axis in order:
            corners.append(corners[-1] + np.eye(3, dtype=int)[axis])
        odd = np.linalg.det(np.eye(3)[list(order)]) < 0
        ids = [((c[:, 0] % rings if closed else c[:, 0]) * (layers + 1) + c[:, 1]) * (slices + 1) + c[:, 2] for c in corners]
        tets.append(np.stack([ids[0], ids[2], ids[1], ids[3]] if odd else ids, 1))
    return np.stack(tets, 1).reshape(-1, 4)


def layered_cylinder(tets, flatness):
    """Of n rings there are n/2 layers and n/7 slices; `flatness` is width over height of a cell at the wall."""
    rings = round((tets * 7 / 3) ** (1 / 3))
    layers, slices = rings // 2, round(rings / 7)
    width = 2 * np.pi / rings
    r = radii(layers, width / flatness, width * 4)
    random = np.random.default_rng(1)
    moved = random.uniform(-0.2, 0.2, (2, rings, slices + 1)) * width
    moved[1][:, [0, -1]] = 0
    ring, layer, slice_ = np.meshgrid(np.arange(rings), np.arange(layers + 1), np.arange(slices + 1), indexing="ij")
    angle = ring * width + moved[0][:, None, :]
    along = slice_ * width + moved[1][:, None, :]
    radius = r[layer]
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), along], -1).reshape(-1, 3)
    u = (1 - np.exp(-(radius - 1) / 0.02)) * (1 + 0.3 * np.cos(angle) / radius)
    p = np.cos(2 * angle) / radius**2
    corners = cut_cells(rings, layers, slices)
    return raw_vtu.Mesh(points, wound(points, corners), {"u": u.ravel().astype("f4"), "p": p.ravel().astype("f4")})


def wound(points, corners):
    a, b, c, d = (points[corners[:, i]] for i in range(4))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)[0] < 0
    return corners[:, [0, 2, 1, 3]] if inward else corners


def layered_plate(tets, flatness):
    layers = 8
    n = round((tets / (6 * layers)) ** 0.5)
    x, layer, y = np.meshgrid(np.arange(n + 1) / n, np.arange(layers + 1), np.arange(n + 1) / n, indexing="ij")
    z = layer / n / flatness + 0.02 * np.sin(3 * x) * np.cos(4 * y) + 0.003 * np.sin(20 * x + 9 * y)
    points = np.stack([x, y, z], -1).reshape(-1, 3)
    u = np.tanh(8 * (x + 0.4 * y - 0.7)) + np.sin(5 * y)
    material = np.tile(np.repeat(np.arange(layers) // 2, n * 6), n)
    return raw_vtu.Mesh(points, wound(points, cut_cells(n, layers, n, closed=False)), {"u": u.ravel().astype("f4")},
                        {"material": material.astype("i4")})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tets", type=number, default=10**6, help="about so many, as in 1M, 300k; default 1M")
    parser.add_argument("--flatness", type=float, default=130, help="of a cell (at the wall), width over height; default %(default)s")
    parser.add_argument("--plate", action="store_true", help="even layers, not those round a cylinder")
    parser.add_argument("out", metavar="OUT.vtu", type=pathlib.Path)
    args = parser.parse_args()
    mesh = (layered_plate if args.plate else layered_cylinder)(args.tets, args.flatness)
    part = args.out.with_name(args.out.name + ".part")
    raw_vtu.write(part, mesh)
    os.replace(part, args.out)
    print(f"{args.out}: {len(mesh.points)} points, {len(mesh.tets)} tetrahedra")


if __name__ == "__main__":
    main()
