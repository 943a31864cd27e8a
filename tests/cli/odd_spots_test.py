#!/usr/bin/env python3
"""Small meshes with a spot that something once went wrong at. Usage: odd_spots_test.py TETFUSION"""
import math

from harness import FolderTest, main, report_of, run
from tiny_vtu import TinyVtu, grid


def wound(points, tet):
    a, *rest = (points[v] for v in tet)
    u, v, w = ([q - p for p, q in zip(a, b)] for b in rest)
    volume = sum(u[i] * (v[i - 2] * w[i - 1] - v[i - 1] * w[i - 2]) for i in range(3))
    return tuple(tet) if volume > 0 else (tet[0], tet[1], tet[3], tet[2])


def legacy(points, tets, values, vertices=()):
    """Tetrahedra, and vertex cells, which hold their points."""
    cells = [(10, wound(points, t)) for t in tets] + [(1, (v,)) for v in vertices]
    lines = ["# vtk DataFile Version 3.0", "spot", "ASCII", "DATASET UNSTRUCTURED_GRID", f"POINTS {len(points)} double"]
    lines += [" ".join(map(repr, p)) for p in points]
    lines += [f"CELLS {len(cells)} {sum(1 + len(c) for _, c in cells)}"] + [" ".join(map(str, (len(c), *c))) for _, c in cells]
    lines += [f"CELL_TYPES {len(cells)}"] + [str(kind) for kind, _ in cells]
    lines += [f"POINT_DATA {len(points)}", "SCALARS f double", "LOOKUP_TABLE default"] + [repr(x) for x in values]
    return "\n".join(lines + [""]).encode()


def with_unused_point(changes):
    """A cube of the point arrays, in this order, of which the last value is that of a point that no cell uses."""
    mesh = TinyVtu(6)
    mesh.array("Points")[4] += [20.0, 0.0, 0.0]
    mesh.counts["NumberOfPoints"] = str(len(mesh.points) + 1)
    mesh.remove("temperature")
    for at, (name, value_of, last) in enumerate(changes):
        mesh.arrays.insert(at, ["PointData", name, "Float64", 1, [value_of(p) for p in mesh.points] + [last]])
    return mesh


class OddSpots(FolderTest):
    def test_what_a_point_that_no_cell_uses_has_does_not_count(self):
        f = ("f", lambda p: math.sin(p[0]) + p[1] * p[2] / 9, 1e6)
        constant = ("constant", lambda p: 1.0, 7.0)
        path = self.write(with_unused_point([constant, f]))
        run("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "50%", "--boundary", "planar")
        self.assertEqual(report_of("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "50%")["steering"], ["f"])
        info = report_of("info", path)
        self.assertEqual(info["steering"], ["f"])
        ranges = {a["name"]: a["ranges"][0] for a in info["arrays"] if a["association"] == "point"}
        self.assertEqual(ranges["constant"], [1, 1])
        self.assertLess(ranges["f"][1], 10)
        left = set()
        for last in (1.0, 1e12, -1.0, float("nan")):
            path = self.write(with_unused_point([f, ("w", lambda p: 10.0 if p[0] > 3 else 1.0, last)]))
            run("simplify", path, "-o", self.folder / "out.vtu", "--array", "f", "--weight", "w", "--boundary", "planar",
                "--reduction", "60%", "--encoding", "ascii")
            left.add((self.folder / "out.vtu").read_bytes().split(b'Name="w"')[0])
        self.assertEqual(len(left), 1)

    def test_weights_of_other_cells_than_tetrahedra_do_not_count(self):
        mesh = with_unused_point([("f", lambda p: p[0] * p[1], 0.0)])
        cells = len(mesh.tets)
        mesh.array("connectivity")[4] += [0, 1, 7]
        mesh.array("offsets")[4].append(4 * cells + 3)
        mesh.array("types")[4].append(5)
        mesh.array("id")[4].append(cells)
        mesh.counts["NumberOfCells"] = str(cells + 1)
        mesh.arrays.insert(0, ["CellData", "w", "Float64", 1, [1.0 + c % 3 for c in range(cells)] + [float("nan")]])
        run("simplify", self.write(mesh), "-o", self.folder / "out.vtu", "--array", "f", "--weight", "cell:w",
            "--reduction", "30%", "--regions", "none")

    def test_a_bound_where_a_flat_cell_under_the_surface_goes(self):
        """v fuses into p, and the triangle (p, x, y) behind the cell that goes comes to the surface, under v."""
        for height, vy, boundary in ((1e-6, 0.0, "planar"), (1e-5, 0.3, "1%")):
            p, x, y, a = (0, 0, height), (2, 1.2, 0), (2, -1, 0), (0.2, 1.5, 0)
            points = [p, x, y, a, (1.5, 2.5, height), (1, 0.8, -3), (1, vy, 1.3 * height)]
            points = [tuple(map(float, point)) for point in points]
            tets = [(0, 1, 2, 5), (0, 1, 3, 5), (1, 3, 4, 5), (6, 0, 1, 2), (6, 0, 1, 3), (6, 1, 3, 4)]
            path, out = self.write(legacy(points, tets, [0.0, 0, 1, 0, 0, 0, 0], [0]), "cap.vtk"), self.folder / "out.vtu"
            run("simplify", path, "-o", out, "--boundary", boundary, "--array", "f:1%", "--min-quality", "0", "--verify")
            run("compare", path, out, "--max-error", "1%")

    def test_no_cell_twice_where_one_is_there_already(self):
        """A vertex in the middle of a cell that is still in the mesh, fused into one of its corners."""
        points, tets = grid(3)
        points = [tuple(map(float, p)) for p in points]
        inner = next(t for t in tets if all(0 < x < 3 for v in t for x in points[v]))
        points.append(tuple(sum(points[v][i] for v in inner) / 4 for i in range(3)))
        tets += [[len(points) - 1 if v == u else v for v in inner] for u in inner]
        path, out = self.write(legacy(points, tets, [p[0] + 2 * p[1] for p in points]), "twice.vtk"), self.folder / "out.vtu"
        before = report_of("check", path, code=1)["duplicate_tets"]
        run("simplify", path, "-o", out, "--reduction", "99%", "--min-quality", "0", "--verify")
        self.assertEqual((before, report_of("check", out, code=1)["duplicate_tets"]), (0, 0))

    def test_a_region_of_interest_by_lengths_beyond_double_precision(self):
        points, tets = grid(4)
        rows = {"v": (3e-171, "v>1e-171"), "w": (1e200, "w<1e250")}
        text = legacy([tuple(map(float, p)) for p in points], tets, [p[0] * p[1] for p in points]).decode()
        for name, (value, _) in rows.items():
            text += f"VECTORS {name} double\n" + f"{value!r} {value!r} 0\n" * len(points)
        path = self.write(text.encode(), "lengths.vtk")
        for _, roi in rows.values():
            report = report_of("simplify", path, "-o", self.folder / "out.vtu", "--array", "f", "--reduction", "90%", "--roi", roi)
            self.assertEqual(report["output"]["tets"], len(tets))


if __name__ == "__main__":
    main()
