#!/usr/bin/env python3
"""Names that are not UTF-8, or that would move a terminal's cursor. Usage: names_test.py TETFUSION"""

from harness import BAD, FolderTest, finish, main, report_of, run
from tiny_vtu import TinyVtu, grid

NAMES = [b"Temp\xe9rature", b"h\xe9", b"h\xe8", b"\x1b[31mred"]
LEGIBLE = ["Temp\u00e9rature", "h\u00e9", "h\u00e8", "%1B[31mred"]


def legacy():
    points, tets = grid(4)
    lines = [b"# vtk DataFile Version 3.0", b"names", b"ASCII", b"DATASET UNSTRUCTURED_GRID", b"POINTS %d float" % len(points)]
    lines += [b"%g %g %g" % p for p in points]
    lines += [b"CELLS %d %d" % (len(tets), 5 * len(tets))] + [b"4 %d %d %d %d" % tuple(t) for t in tets]
    lines += [b"CELL_TYPES %d" % len(tets)] + [b"10"] * len(tets)
    lines += [b"POINT_DATA %d" % len(points), b"FIELD FieldData %d" % len(NAMES)]
    for k, name in enumerate(NAMES):
        lines += [b"%s 1 %d double" % (name, len(points))] + [b"%g" % (p[k % 3] + k) for p in points]
    return b"\n".join(lines) + b"\n"


def gmsh():
    points, tets = grid(2)
    lines = [b"$MeshFormat", b"2.2 0 8", b"$EndMeshFormat", b"$PhysicalNames", b"2", b'3 1 "entr\xe9e"', b'3 2 "entr\xe8e"',
             b"$EndPhysicalNames", b"$Nodes", b"%d" % len(points)]
    lines += [b"%d %g %g %g" % (i + 1, *p) for i, p in enumerate(points)]
    lines += [b"$EndNodes", b"$Elements", b"%d" % len(tets)]
    lines += [b"%d 4 2 %d %d %d %d %d %d" % (i + 1, 1 + i % 2, 1 + i % 2, *(v + 1 for v in t)) for i, t in enumerate(tets)]
    return b"\n".join(lines + [b"$EndElements", b""])


class Names(FolderTest):
    def names_in(self, path):
        return [a["name"] for a in report_of("info", path)["arrays"] if a["association"] == "point"]

    def test_latin_1_becomes_utf_8_in_every_format(self):
        source = self.write(legacy(), "in.vtk")
        self.assertEqual(self.names_in(source), LEGIBLE)
        for suffix in ("vtu", "vtk", "pvtu"):
            out = self.folder / f"out.{suffix}"
            run("simplify", source, "-o", out, "--reduction", "20%", "--array", LEGIBLE[0], "--verify")
            self.assertEqual(self.names_in(out)[:len(NAMES)], LEGIBLE)
            run("compare", source, out)

    def test_a_file_in_place_can_be_read_again(self):
        path = self.write(TinyVtu().bytes().replace(b'"1.0"?', b'"1.0" encoding="ISO-8859-1"?').replace(b"temperature", b"\xe9"))
        names = self.names_in(path)
        self.assertIn("\u00e9", names)
        run("simplify", path, "-o", path, "--reduction", "20%")
        self.assertEqual(self.names_in(path), names)
        run("check", path)

    def test_groups_of_gmsh_stay_apart(self):
        source, out = self.write(gmsh(), "in.msh"), self.folder / "out.msh"
        run("simplify", source, "-o", out, "--reduction", "10%")
        text = out.read_bytes()
        for name in ("entr\u00e9e", "entr\u00e8e"):
            self.assertIn(f'"{name}"'.encode(), text)

    def test_messages_move_no_cursor(self):
        source = self.write(legacy().replace(b"double", b"\x1b[2Jouble", 1), "in.vtk")
        result = finish("info", source)
        self.assertEqual(result.returncode, BAD)
        self.assertIn(b"?[2J", result.stderr)
        source = self.write(legacy(), "in.vtk")
        for command in (("info", source), ("simplify", source, "-o", self.folder / "o.vtu", "--reduction", "10%")):
            result = finish(*command)
            self.assertEqual(result.returncode, 0)
            self.assertNotIn(b"\x1b", result.stdout + result.stderr)


if __name__ == "__main__":
    main()
