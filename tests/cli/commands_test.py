#!/usr/bin/env python3
"""The command from end to end: every subcommand, exit codes, reports, pipes, interruption, a disk too small.
Usage: commands_test.py TETFUSION [unittest's arguments]"""
import json
import os
import pathlib
import pty
import resource
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "support")]
from independent_check import Vtu
from tiny_vtu import TinyVtu

COMMAND = None
INVALID, USAGE, BAD, IO, INTERRUPTED = 1, 2, 3, 4, 130
COMMANDS = ("simplify", "info", "check", "convert", "generate")
EVERYWHERE = ["--help", "--threads", "--progress", "--quiet", "--verbose"]
READING = ["--tetrahedralize", "--linearize"]
OPTIONS = {
    "simplify": READING + ["--output", "--reduction", "--tets", "--scalar-tolerance", "--stretch-factor", "--aspect-ratio",
                           "--method", "--boundary-rule", "--boundary", "--array", "--regions", "--lods", "--encoding",
                           "--report", "--strict"],
    "info": READING + ["--report"],
    "check": READING + ["--report", "--strict"],
    "convert": READING + ["--encoding"],
    "generate": ["--tets", "--output", "--jitter", "--grading", "--shuffle", "--seed", "--encoding"]}


def run(*arguments, code=0, **keywords):
    """Runs the command and returns what it wrote to standard output; its standard error must say why where it fails."""
    result = finish(*arguments, **keywords)
    if result.returncode != code:
        raise AssertionError(f"{arguments}: exit code {result.returncode}, not {code}\n{result.stderr.decode()}")
    if code > INVALID and b"tetfusion: error: " not in result.stderr:
        raise AssertionError(f"{arguments}: no error message but {result.stderr}")
    return result.stdout


def finish(*arguments, **keywords):
    return subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, timeout=300, **keywords)


def report_of(command, *arguments, code=0, **keywords):
    return json.loads(run(command, *arguments, "--report", "-", code=code, **keywords))


def tets_as_coordinates(mesh):
    """The tetrahedra as a sorted array of their corners' coordinates, whatever their order and that of the points."""
    corners = mesh.points[mesh.tets].astype("f8")
    order = np.lexsort((corners[:, :, 2], corners[:, :, 1], corners[:, :, 0]))
    rows = np.take_along_axis(corners, order[:, :, None], axis=1).reshape(len(corners), 12)
    return rows[np.lexsort(rows.T[::-1])]


class FolderTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, mesh, name="mesh.vtu"):
        path = self.folder / name
        path.write_bytes(mesh if isinstance(mesh, bytes) else mesh.bytes())
        return path

    def generate(self, *options, kind="bcc", tets="20k", name="generated.vtu"):
        path = self.folder / name
        run("generate", kind, "--tets", tets, "-o", path, *options)
        return path

    def files(self):
        return sorted(p.name for p in self.folder.iterdir())


class Help(unittest.TestCase):
    def test_version(self):
        self.assertRegex(run("--version").decode(), r"^tetfusion \d+\.\d+\.\d+\n$")

    def test_the_command_lists_its_subcommands(self):
        for option in ("--help", "-h"):
            text = run(option).decode()
            for word in (*COMMANDS, "--version"):
                self.assertIn(word, text)

    def test_each_subcommand_lists_its_options(self):
        for command in COMMANDS:
            result = finish(command, "--help")
            self.assertEqual((result.returncode, result.stderr), (0, b""))
            listed = result.stdout.decode().replace(",", " ").split()
            for option in EVERYWHERE + OPTIONS[command]:
                self.assertIn(option, listed, command)
            self.assertGreater(len(result.stdout.splitlines()), 8)

    def test_the_defaults_of_tetfuse_are_stated(self):
        text = run("simplify", "--help").decode()
        for default in ("tetfuse", "--scalar-tolerance TEXT=0.025", "--stretch-factor TEXT=5", "--encoding ENUM=raw"):
            self.assertIn(default, text)


def two_tets(shared):
    """Two tetrahedra that share so many points."""
    mesh = TinyVtu(1)
    corner = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    other = [(0, 0, 0), (1, 0, 0), (0, -1, 0), (0, 0, -1)]
    mesh.points = corner + other[shared:]
    ids = [0, 1, 2, 3] + list(range(shared)) + list(range(4, 8 - shared))
    ids[6:8] = ids[7:5:-1]
    mesh.tets = [ids[:4], ids[4:]]
    return rebuilt(mesh)


def rebuilt(mesh):
    """The arrays of a TinyVtu whose points and tets were changed."""
    fresh = {"temperature": [float(p[0]) for p in mesh.points], "id": list(range(len(mesh.tets))),
             "Points": [float(c) for p in mesh.points for c in p], "connectivity": [v for t in mesh.tets for v in t],
             "offsets": list(range(4, 4 * len(mesh.tets) + 1, 4)), "types": [10] * len(mesh.tets)}
    for name, values in fresh.items():
        mesh.array(name)[4] = values
    mesh.counts = {"NumberOfPoints": str(len(mesh.points)), "NumberOfCells": str(len(mesh.tets))}
    return mesh


def set_value(name, index, value):
    mesh = TinyVtu()
    mesh.array(name)[4][index] = value
    return mesh


class Check(FolderTest):
    PROMISED = ["version", "valid", "inverted", "degenerate", "duplicate_tets", "nonconforming_faces", "nonmanifold_edges",
                "nonmanifold_vertices", "volume", "min_dihedral_deg", "mean_ratio"]

    def expect(self, mesh, code, strict=None, **counts):
        """The exit code without and with --strict, and counts of the report."""
        path = self.write(mesh)
        strict = code if strict is None else strict
        for options, expected in (([], code), (["--strict"], strict)):
            report = report_of("check", path, *options, code=expected)
            self.assertEqual(report["valid"], expected == 0)
            for key in self.PROMISED:
                self.assertIn(key, report)
            for key, value in counts.items():
                self.assertEqual(report[key], value, key)
            text = run("check", path, *options, code=expected).decode()
            self.assertEqual("INVALID" in text, expected != 0, text)
        return report

    def test_a_good_mesh(self):
        report = self.expect(TinyVtu(3), 0, inverted=0, degenerate=0, duplicate_tets=0, nonconforming_faces=0,
                             nonmanifold_edges=0, nonmanifold_vertices=0, volume=27.0, tets=162, points=64,
                             boundary_triangles=108)
        self.assertAlmostEqual(report["min_dihedral_deg"], 45, places=9)
        for key in ("min", "p1", "mean"):
            self.assertTrue(0.7 < report["mean_ratio"][key] < 0.8)

    def test_inverted_cells(self):
        report = self.expect(set_value("Points", 3 * 62, 10.0), INVALID)
        self.assertGreater(report["inverted"], 0)
        self.assertGreater(report["nonconforming_faces"], 0)

    def test_duplicate_cells(self):
        mesh = TinyVtu(2)
        mesh.tets.append(mesh.tets[5][::-1])
        self.expect(rebuilt(mesh), INVALID, duplicate_tets=1)

    def test_faces_with_three_cells(self):
        mesh = two_tets(3)
        mesh.points.append((0.1, -0.1, -2))
        mesh.tets.append([0, 2, 1, 5])
        report = self.expect(rebuilt(mesh), INVALID, duplicate_tets=0)
        self.assertGreater(report["nonconforming_faces"], 0)

    def test_degenerate_cells_are_a_warning(self):
        mesh = TinyVtu(1)  # the square x = 0 as a flat tetrahedron on the two triangles of that side
        mesh.tets.append([0, 2, 6, 4])
        self.expect(rebuilt(mesh), 0, strict=INVALID, degenerate=1, inverted=0, duplicate_tets=0, nonconforming_faces=0)

    def test_a_boundary_that_is_no_manifold_is_a_warning(self):
        self.expect(two_tets(2), 0, strict=INVALID, nonmanifold_edges=1)
        self.expect(two_tets(1), 0, strict=INVALID, nonmanifold_vertices=1)

    def test_cells_wound_the_other_way_are_not_inverted(self):
        mesh = TinyVtu(2)
        mesh.tets = [[t[1], t[0], t[2], t[3]] for t in mesh.tets]
        self.expect(rebuilt(mesh), 0, inverted=0, rewound=48, volume=8.0)
        self.assertIn(b"wound the other way", run("check", self.folder / "mesh.vtu"))

    def test_ids_out_of_range_and_coordinates_that_are_not_finite(self):
        for mesh in (set_value("connectivity", 7, 125), set_value("connectivity", 7, -1), set_value("connectivity", 0, 2**40),
                     set_value("Points", 10, float("nan")), set_value("Points", 11, float("-inf"))):
            report = self.expect(mesh, INVALID, volume=None, inverted=None)
            self.assertRegex(report["error"], r"mesh\.vtu: .*(uses point|coordinate)")
            path = self.folder / "mesh.vtu"
            self.assertEqual(run("check", path, "--quiet", code=INVALID), b"")
            for arguments in (["info", path], ["simplify", path, "-o", path], ["convert", path, self.folder / "o.vtu"]):
                run(*arguments, code=BAD)
            self.assertEqual(self.files(), ["mesh.vtu"])

    def test_points_that_no_cell_uses_may_be_anything(self):
        mesh = TinyVtu(2)
        mesh.points.append((0, 0, float("nan")))
        self.expect(rebuilt(mesh), 0, unused_points=1, points=27)

    def test_files_that_cannot_be_judged(self):
        good = TinyVtu().bytes()
        for mesh in (b"no mesh at all", good[:len(good) // 2], set_value("offsets", 3, 17).bytes(), b""):
            self.assertEqual(run("check", self.write(mesh), code=BAD), b"")
        run("check", self.folder / "missing.vtu", code=IO)
        run("check", self.folder, code=IO)
        run("check", code=USAGE)
        run("check", "a.vtu", "b.vtu", code=USAGE)

    def test_the_report_as_a_file(self):
        path, report = self.write(TinyVtu()), self.folder / "report.json"
        self.assertIn(b"Valid", run("check", path, "--report", report))
        self.assertTrue(json.loads(report.read_text())["valid"])
        run("check", path, "--report", self.folder / "no" / "r.json", code=IO)


class Info(FolderTest):
    def test_what_it_says(self):
        path = self.generate("--time", "2.5", "--double")
        report = report_of("info", path)
        for key in ("version", "path", "format", "file_bytes", "points", "tets", "boundary_triangles", "volume",
                    "bounding_box", "arrays", "pieces"):
            self.assertIn(key, report)
        self.assertEqual((report["point_type"], report["pieces"]), ("Float64", 1))
        self.assertEqual(report["file_bytes"], path.stat().st_size)
        arrays = {(a["association"], a["name"]): a for a in report["arrays"]}
        self.assertEqual(arrays["cell", "region"]["ranges"], [[1, 4]])
        self.assertEqual(arrays["point", "velocity"]["components"], 3)
        self.assertEqual(arrays["field", "TimeValue"]["ranges"], [[2.5, 2.5]])
        mesh = Vtu(path)
        self.assertEqual((report["points"], report["tets"]), (len(mesh.points), len(mesh.tets)))
        np.testing.assert_allclose(report["bounding_box"], [mesh.points.min(axis=0), mesh.points.max(axis=0)])
        text = run("info", path).decode()
        for word in ("temperature", "velocity", "region", "TimeValue", "Float64", "bounding box", "boundary", f"{report['tets']:,}"):
            self.assertIn(word, text)

    def test_what_is_odd(self):
        mesh = TinyVtu(2)
        mesh.points.append((5, 5, 5))
        mesh.tets.append(mesh.tets[0])
        path = self.write(rebuilt(mesh))
        text = run("info", path).decode()
        self.assertIn("1 duplicate cells", text)
        self.assertIn("1 unused points", text)
        self.assertEqual(report_of("info", path)["duplicate_tets"], 1)
        self.assertIn("odd           nothing", run("info", self.write(TinyVtu())).decode())

    def test_names_that_are_no_json(self):
        mesh = TinyVtu(1)
        mesh.array("temperature")[1] = 'a"\\b'.replace('"', "&quot;")
        report = report_of("info", self.write(mesh))
        self.assertIn('a"\\b', [a["name"] for a in report["arrays"]])

    def test_values_that_are_not_finite(self):
        mesh = TinyVtu(1)
        mesh.array("temperature")[4][2] = float("nan")
        report = report_of("info", self.write(mesh))
        self.assertEqual(report["arrays"][0]["non_finite"], 1)

    def test_an_input_in_a_folder_that_may_not_be_written(self):
        folder = self.folder / "read_only"
        folder.mkdir()
        (folder / "mesh.vtu").write_bytes(TinyVtu().bytes())
        folder.chmod(0o555)
        self.addCleanup(folder.chmod, 0o755)
        run("info", folder / "mesh.vtu")
        run("check", folder / "mesh.vtu")
        run("simplify", folder / "mesh.vtu", "-o", self.folder / "out.vtu")
        self.assertEqual(os.listdir(folder), ["mesh.vtu"])


def mesh_of_all_sorts():
    """Arrays of every kind, and cells of lower dimension before and after the tetrahedra."""
    mesh = TinyVtu(3)
    points, tets = len(mesh.points), len(mesh.tets)
    rng = np.random.default_rng(1)
    lower = [(5, [0, 1, 5]), (3, [2, 6])], [(1, [7])]
    cells = lower[0] + [(10, t) for t in mesh.tets] + lower[1]
    mesh.counts["NumberOfCells"] = str(len(cells))
    mesh.array("connectivity")[4] = [v for _, ids in cells for v in ids]
    mesh.array("offsets")[4] = [int(n) for n in np.cumsum([len(ids) for _, ids in cells])]
    mesh.array("types")[4] = [kind for kind, _ in cells]
    mesh.array("id")[4] = list(range(tets + 3))
    mesh.arrays += [["PointData", "double", "Float64", 1, [float(v) for v in rng.normal(size=points)]],
                    ["PointData", "vector", "Float32", 3, [float(v) for v in rng.normal(size=3 * points).astype("f4")]],
                    ["PointData", "bytes", "Int8", 2, [int(v) for v in rng.integers(-128, 128, 2 * points)]],
                    ["CellData", "large", "Int64", 1, [int(v) for v in rng.integers(-2**62, 2**62, tets + 3)]]]
    mesh.arrays.sort(key=lambda a: ["PointData", "CellData", "Points", "Cells"].index(a[0]))
    return mesh


class Convert(FolderTest):
    def assert_same(self, before, after):
        """`after` has the tetrahedra of `before` first, then its other cells, each with its values."""
        np.testing.assert_array_equal(before.points, after.points)
        np.testing.assert_array_equal(before.tets, after.tets)
        self.assertEqual([(k, list(ids)) for k, ids in before.others], [(k, list(ids)) for k, ids in after.others])
        for association in ("point", "cell"):
            self.assertEqual(list(before.arrays[association]), list(after.arrays[association]))
            for name, (info, values) in before.arrays[association].items():
                self.assertEqual(info, after.arrays[association][name][0], name)
                if association == "cell":
                    values = np.concatenate([values[2:-1], values[:2], values[-1:]]) if before.others else values
                np.testing.assert_array_equal(values, after.arrays[association][name][1], name)

    def test_round_trips_through_every_encoding(self):
        original = self.write(mesh_of_all_sorts())
        raw, back, coded = self.folder / "raw.vtu", self.folder / "back.vtu", self.folder / "coded.vtu"
        run("convert", original, raw)
        self.assert_same(Vtu(original), Vtu(raw))
        for encoding in ("raw", "zlib", "lz4", "inline", "ascii"):
            run("convert", original, coded, "--encoding", encoding)
            if encoding != "lz4":
                self.assert_same(Vtu(original), Vtu(coded))
            run("convert", coded, back)
            self.assertEqual(back.read_bytes(), raw.read_bytes(), encoding)

    def test_onto_itself(self):
        path = self.write(mesh_of_all_sorts())
        original = Vtu(path)
        path.chmod(0o640)
        for encoding in ("zlib", "raw"):
            run("convert", path, path, "--encoding", encoding)
            self.assertEqual(path.stat().st_mode & 0o777, 0o640)
        self.assert_same(original, Vtu(path))
        self.assertEqual(self.files(), ["mesh.vtu"])

    def test_a_failed_conversion_leaves_the_output_alone(self):
        out = self.write(b"precious", "out.vtu")
        run("convert", self.write(TinyVtu().bytes()[:2000]), out, code=BAD)
        run("convert", self.folder / "missing.vtu", out, code=IO)
        self.assertEqual(out.read_bytes(), b"precious")
        self.assertEqual(self.files(), ["mesh.vtu", "out.vtu"])

    def test_bad_outputs(self):
        path = self.write(TinyVtu())
        run("convert", path, self.folder / "no" / "out.vtu", code=IO)
        (self.folder / "folder.vtu").mkdir()
        run("convert", path, self.folder / "folder.vtu", code=IO)
        run("convert", path, "/dev/full", code=IO)
        run("convert", path, code=USAGE)

    def test_hexahedra_in_a_vtu(self):
        mesh = TinyVtu(1)
        mesh.arrays = [a for a in mesh.arrays if a[1] != "id"]
        mesh.array("connectivity")[4] = [0, 1, 3, 2, 4, 5, 7, 6] + [1, 3, 7, 5] + [0, 1, 2, 3]
        mesh.array("offsets")[4] = [8, 12, 16]
        mesh.array("types")[4] = [12, 9, 8]
        mesh.counts["NumberOfCells"] = "3"
        path, out = self.write(mesh), self.folder / "out.vtu"
        result = finish("convert", path, out)
        self.assertEqual(result.returncode, BAD)
        self.assertIn(b"--tetrahedralize", result.stderr)
        self.assertFalse(out.exists())
        run("convert", path, out, "--tetrahedralize")
        report = report_of("check", out, "--strict")
        self.assertEqual((report["volume"], report["lower_cells"], report["boundary_triangles"]), (1.0, 4, 12))
        faces = {frozenset(np.delete(t, k).tolist()) for t in Vtu(out).tets for k in range(4)}
        for kind, ids in Vtu(out).others:
            self.assertEqual(kind, 5)
            self.assertIn(frozenset(ids.tolist()), faces, "a carried triangle is no face")


class Generate(FolderTest):
    def test_kinds_and_sizes(self):
        for kind in ("five", "kuhn", "bcc"):
            for tets in (1000, 30000):
                path = self.generate("--jitter", "0.5", kind=kind, tets=str(tets))
                report = report_of("check", path, "--strict")
                self.assertLess(abs(report["tets"] / tets - 1), 0.1)
                self.assertAlmostEqual(report["volume"], 1, delta=1e-6)
                self.assertEqual((report["components"], report["surface_euler"]), (1, 2))

    def test_shuffled_is_the_same_mesh(self):
        plain = self.generate("--jitter", "0.3", tets="5k")
        shuffled = self.generate("--jitter", "0.3", "--shuffle", tets="5k", name="shuffled.vtu")
        self.assertNotEqual(plain.read_bytes(), shuffled.read_bytes())
        a, b = Vtu(plain), Vtu(shuffled)
        self.assertFalse(np.array_equal(a.points, b.points))
        np.testing.assert_array_equal(tets_as_coordinates(a), tets_as_coordinates(b))
        of_points = [m.arrays["point"]["temperature"][1][np.lexsort(m.points.T)] for m in (a, b)]
        np.testing.assert_array_equal(*of_points)

    def test_bytes_depend_on_the_seed_alone(self):
        options = ["--jitter", "0.4", "--shuffle", "--grading", "3"]
        one = self.generate(*options, "--threads", "1", "--seed", "7").read_bytes()
        self.assertEqual(one, self.generate(*options, "--threads", "2", "--seed", "7").read_bytes())
        self.assertNotEqual(one, self.generate(*options, "--seed", "8").read_bytes())

    def test_bad_options(self):
        for options in (["--tets", "0"], ["--tets", "many"], ["--jitter", "1"], ["--jitter", "nan"], ["--grading", "0"],
                        ["--seed", "-1"], ["--tets", "2e30"]):
            run("generate", "five", "-o", self.folder / "a.vtu", *options, code=USAGE)
        run("generate", "six", "-o", self.folder / "a.vtu", code=USAGE)
        run("generate", "five", code=USAGE)
        self.assertEqual(self.files(), [])


class Streams(FolderTest):
    def test_standard_input_and_output(self):
        mesh = mesh_of_all_sorts().bytes()
        path = self.write(mesh)
        out = self.folder / "out.vtu"
        self.assertEqual(report_of("info", "-", input=mesh)["tets"], 162)
        self.assertEqual(report_of("check", "-", input=mesh)["tets"], 162)
        run("convert", path, out)
        self.assertEqual(run("convert", "-", "-", input=mesh), out.read_bytes())
        run("simplify", path, "-o", out, "--scalar-tolerance", "off")
        self.assertEqual(run("simplify", "-", "-o", "-", "--scalar-tolerance", "off", input=mesh), out.read_bytes())
        self.generate()
        self.assertEqual(run("generate", "bcc", "--tets", "20k", "-o", "-"), (self.folder / "generated.vtu").read_bytes())

    def test_a_pipe_of_three(self):
        line = ('"$0" generate bcc --tets 20k -o - | "$0" simplify - -o - --reduction 30% --quiet | '
                '"$0" info - --report -')
        piped = subprocess.run(["bash", "-o", "pipefail", "-c", line, COMMAND], capture_output=True, timeout=120)
        self.assertEqual((piped.returncode, piped.stderr), (0, b""))
        report = json.loads(piped.stdout)
        self.assertTrue(0.69 * 20160 < report["tets"] < 0.72 * 20160)
        self.assertIn("velocity", [a["name"] for a in report["arrays"]])

    def test_a_reader_that_goes_away(self):
        path = self.generate(tets="500k")
        writer = subprocess.Popen([COMMAND, "convert", path, "-"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        writer.stdout.read(10)
        writer.stdout.close()
        message = writer.stderr.read()
        writer.stderr.close()
        self.assertEqual(writer.wait(timeout=60), IO)
        self.assertIn(b"reader has gone", message)

    def test_standard_input_that_is_no_mesh(self):
        for data in (b"", b"nothing", b"# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n"):
            self.assertEqual(run("info", "-", input=data, code=BAD), b"")

    def test_quiet_prints_nothing(self):
        path, out = self.write(mesh_of_all_sorts()), self.folder / "out.vtu"
        for arguments in (["simplify", path, "-o", out], ["info", path], ["check", path], ["convert", path, out],
                          ["generate", "five", "--tets", "1k", "-o", out]):
            result = finish(*arguments, "--quiet")
            self.assertEqual((result.returncode, result.stdout, result.stderr), (0, b"", b""), arguments)
        result = finish("info", self.folder / "missing.vtu", "--quiet")
        self.assertEqual((result.returncode, result.stdout), (IO, b""))
        self.assertIn(b"missing.vtu", result.stderr)

    def test_progress(self):
        path, out = self.generate(), self.folder / "out.vtu"
        for arguments in (["simplify", path, "-o", out], ["info", path], ["check", path], ["convert", path, out],
                          ["generate", "five", "--tets", "1k", "-o", out]):
            plain = {choice: finish(*arguments, "--progress", choice) for choice in ("always", "never", "auto")}
            self.assertIn(b"\r", plain["always"].stderr)
            for result in plain.values():
                self.assertEqual(result.returncode, 0)
                self.assertNotIn(b"\r", result.stdout)
            self.assertNotIn(b"\r", plain["never"].stderr)
            self.assertNotIn(b"\r", plain["auto"].stderr, "a bar although standard error is no terminal")
        run("info", path, "--progress", "often", code=USAGE)

    def test_progress_on_a_terminal(self):
        path = self.generate()
        for options, expected in (([], True), (["--progress", "never"], False), (["--quiet"], False)):
            try:
                ours, theirs = pty.openpty()
            except OSError as error:
                self.skipTest(f"this machine has no pseudo-terminals: {error}")
            result = subprocess.run([COMMAND, "check", path, *options], stdout=subprocess.PIPE, stderr=theirs, timeout=60)
            os.close(theirs)
            seen = b""
            try:
                while chunk := os.read(ours, 4096):
                    seen += chunk
            except OSError:  # how a terminal ends
                pass
            os.close(ours)
            self.assertEqual(result.returncode, 0)
            self.assertEqual(b"\x1b[K" in seen, expected, options)
            self.assertNotIn(b"\x1b", result.stdout)

    def test_the_report_of_simplify(self):
        path, out = self.generate(), self.folder / "out.vtu"
        report = report_of("simplify", path, "-o", out, "--reduction", "20%", "--threads", "2")
        for key in ("version", "reduction", "stop_reason", "lods", "cpu_seconds", "peak_rss_bytes", "threads", "chunks"):
            self.assertIn(key, report)
        for side in ("input", "output"):
            for key in ("points", "tets", "boundary_triangles", "volume"):
                self.assertIn(key, report[side])
        for lod in report["lods"]:
            for key in ("tets", "fused", "rejected"):
                self.assertIn(key, lod)
        self.assertGreater(report["seconds"]["total"], 0)
        self.assertEqual(report["threads"], 2)
        self.assertEqual(report["output"]["tets"], len(Vtu(out).tets))
        self.assertEqual(report["lods"][-1]["tets"], report["output"]["tets"])
        self.assertAlmostEqual(report["reduction"], 1 - report["output"]["tets"] / report["input"]["tets"])


class Trouble(FolderTest):
    TETS = "1500k"

    def start(self, *arguments, until, **keywords):
        """Starts the command and comes back when its progress bar shows that phase."""
        process = subprocess.Popen([COMMAND, *map(str, arguments), "--progress", "always"], stderr=subprocess.PIPE,
                                   stdout=subprocess.DEVNULL, **keywords)
        seen = b""
        while until.encode() not in seen:
            chunk = os.read(process.stderr.fileno(), 4096)
            if not chunk:
                raise AssertionError(f"ended before '{until}': {seen}")
            seen += chunk
        return process

    def end(self, process):
        message = process.stderr.read().decode()
        process.stderr.close()
        return process.wait(timeout=60), message

    def test_ctrl_c(self):
        mesh, out = self.generate("--shuffle", tets=self.TETS), self.folder / "out.vtu"
        jobs = [(["simplify", mesh, "-o", out, "--encoding", "ascii"], phase)
                for phase in ("reading", "inspecting", "fusing", "writing")]
        jobs += [(["convert", mesh, out, "--encoding", "ascii"], phase) for phase in ("reading", "writing")]
        jobs += [(["check", mesh], "reading"), (["info", mesh], "reading"),
                 (["generate", "five", "--tets", "20M", "-o", out], "writing")]
        for arguments, phase in jobs:
            with self.subTest(command=arguments[0], phase=phase):
                process = self.start(*arguments, until=phase)
                process.send_signal(signal.SIGINT)
                code, message = self.end(process)
                self.assertEqual(code, INTERRUPTED, message)
                self.assertIn("interrupted", message)
                self.assertEqual(self.files(), ["generated.vtu"], "something was left behind")

    def test_a_second_ctrl_c_ends_at_once(self):
        mesh, out = self.generate("--shuffle", tets=self.TETS), self.folder / "out.vtu"
        process = self.start("simplify", mesh, "-o", out, until="reading")
        process.send_signal(signal.SIGINT)
        time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        code, _ = self.end(process)
        self.assertIn(code, (-signal.SIGINT, INTERRUPTED))
        self.assertFalse(out.exists())

    def test_kill_leaves_the_old_output(self):
        mesh, out = self.generate(tets=self.TETS), self.write(b"precious", "out.vtu")
        for phase in ("fusing", "writing"):
            process = self.start("simplify", mesh, "-o", out, "--encoding", "ascii", until=phase)
            process.kill()
            code, _ = self.end(process)
            self.assertEqual(code, -signal.SIGKILL)
            self.assertEqual(out.read_bytes(), b"precious")
        # What the killed run left does not hinder the next one.
        run("simplify", mesh, "-o", out, "--reduction", "10%", "--quiet")
        run("check", out, "--quiet")

    def limited(self, *arguments, limit, code=IO):
        set_limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        result = finish(*arguments, preexec_fn=set_limit)
        self.assertEqual(result.returncode, code, result.stderr)
        return result.stderr.decode()

    def test_a_disk_too_small(self):
        mesh, out = self.generate(tets="300k"), self.write(b"precious", "out.vtu")
        size = mesh.stat().st_size
        for limit in (0, 1000, size // 10):
            for arguments in (["simplify", mesh, "-o", out], ["convert", mesh, out],
                              ["convert", mesh, out, "--encoding", "zlib"],
                              ["generate", "five", "--tets", "300k", "-o", out],
                              ["check", mesh, "--report", out] if limit == 0 else ["convert", mesh, out]):
                with self.subTest(command=arguments[0], limit=limit):
                    message = self.limited(*arguments, limit=limit)
                    self.assertRegex(message, r"out\.vtu.*(too large|space)")
                    self.assertEqual(out.read_bytes(), b"precious")
                    self.assertEqual(self.files(), ["generated.vtu", "out.vtu"])

    def test_a_full_device(self):
        mesh = self.write(TinyVtu())
        for arguments in (["simplify", mesh, "-o", "/dev/full"], ["convert", mesh, "/dev/full"],
                          ["generate", "five", "--tets", "1k", "-o", "/dev/full"], ["info", mesh, "--report", "/dev/full"]):
            self.assertIn(b"no space left", finish(*arguments).stderr)
            run(*arguments, code=IO)


HEXAHEDRA = b"""# vtk DataFile Version 3.0
two hexahedra and a side of the second one
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 12 float
0 0 0  1 0 0  2 0 0  0 1 0  1 1 0  2 1 0
0 0 1  1 0 1  2 0 1  0 1 1  1 1 1  2 1 1
CELLS 3 23
8 0 1 4 3 6 7 10 9
8 1 2 5 4 7 8 11 10
4 2 5 11 8
CELL_TYPES 3
12 12 9
CELL_DATA 3
SCALARS number int 1
LOOKUP_TABLE default
0 1 2
"""

STRUCTURED = b"""<?xml version="1.0"?>
<VTKFile type="StructuredGrid" version="1.0" byte_order="LittleEndian">
<StructuredGrid WholeExtent="0 2 0 1 0 1"><Piece Extent="0 2 0 1 0 1">
<PointData><DataArray type="Float64" Name="height" format="ascii">0 0 1 0 0 1 1 1 2 1 1 2</DataArray></PointData>
<CellData/><Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">
0 0 0  1 0 0  2 0 0  0 1 0  1 1 0  2 1 0  0 0 1  1 0 1  2 0 1  0 1 1  1 1 1  2 1 1
</DataArray></Points></Piece></StructuredGrid></VTKFile>
"""


class OtherFormats(FolderTest):
    def setUp(self):
        super().setUp()
        plugin = pathlib.Path(COMMAND).resolve().parent / "tetfusion-vtk.so"
        if not plugin.exists():
            self.skipTest(f"{plugin} is not built: VTK was not found")

    def test_hexahedra_need_the_option(self):
        for name, data in (("a.vtk", HEXAHEDRA), ("a.vts", STRUCTURED)):
            path = self.write(data, name)
            for arguments in (["info", path], ["check", path], ["convert", path, self.folder / "out.vtu"],
                              ["simplify", path, "-o", self.folder / "out.vtu"]):
                result = finish(*arguments)
                self.assertEqual((result.returncode, result.stdout), (BAD, b""))
                self.assertRegex(result.stderr.decode(), rf"{name}: cell 0 is a hexahedron .*--tetrahedralize")
            path.unlink()
        self.assertEqual(self.files(), [])

    def test_hexahedra_are_split(self):
        for name, data, lower, array in (("a.vtk", HEXAHEDRA, 2, ("cell", "number")),
                                         ("a.vts", STRUCTURED, 0, ("point", "height"))):
            path, out = self.write(data, name), self.folder / "out.vtu"
            before = report_of("check", path, "--tetrahedralize", "--strict")
            self.assertEqual((before["volume"], before["points"], before["lower_cells"]), (2.0, 12, lower))
            run("convert", path, out, "--tetrahedralize")
            after = report_of("check", out, "--strict")
            self.assertEqual([after[k] for k in ("volume", "tets", "points", "lower_cells", "boundary_triangles")],
                             [before[k] for k in ("volume", "tets", "points", "lower_cells", "boundary_triangles")])
            self.assertIn(array[1], Vtu(out).arrays[array[0]])
            run("simplify", path, "-o", out, "--tetrahedralize", "--quiet")
            self.assertEqual(report_of("check", out, "--strict")["volume"], 2.0)

    def test_broken_indices_are_an_invalid_mesh(self):
        path = self.write(HEXAHEDRA.replace(b"8 1 2 5 4 7 8 11 10", b"8 1 2 5 4 7 8 11 12"), "a.vtk")
        report = report_of("check", path, "--tetrahedralize", code=INVALID)
        self.assertFalse(report["valid"])
        self.assertIn("cell 1 uses point 12", report["error"])
        run("simplify", path, "-o", self.folder / "out.vtu", "--tetrahedralize", code=BAD)

    def test_damaged_files(self):
        path = self.write(HEXAHEDRA[:300], "a.vtk")
        run("check", path, "--tetrahedralize", code=BAD)


if __name__ == "__main__":
    COMMAND = os.path.abspath(sys.argv.pop(1))
    unittest.main()
