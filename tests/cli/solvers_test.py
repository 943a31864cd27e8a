#!/usr/bin/env python3
"""Files of solvers that VTK reads: series of EnSight and OpenFOAM, VTKHDF, CGNS. Usage: solvers_test.py TETFUSION"""
import gzip
import os
import pathlib
import signal
import time
import xml.etree.ElementTree as ElementTree

import numpy as np

from follow_test import jittered, values
from harness import BAD, INTERRUPTED, MEMORY, USAGE, FolderTest, command, finish, least_memory, main, report_of, run
from independent_check import Vtu

try:
    import h5py
except ImportError:
    h5py = None

TIMES = [0, 0.1, 0.25]
GOAL = ["--reduction", "40%"]


def plugin_is_there():
    return os.path.exists(os.path.join(os.path.dirname(command()), "tetfusion-vtk.so"))


class SolverTest(FolderTest):
    def setUp(self):
        if not plugin_is_there():
            self.skipTest("the plugin is not built")
        super().setUp()
        self.grid = self.write(jittered(6), "grid.vtu")
        self.points, self.tets = np.array(Vtu(self.grid).points, dtype="f4"), Vtu(self.grid).tets

    def heat(self, step):
        """A bump that moves from step to step."""
        return np.exp(-0.5 * (self.points[:, 0] - 2 * step) ** 2 - 0.1 * self.points[:, 1]).astype("f4")

    def refused(self, *arguments, code=BAD):
        result = finish(*arguments)
        self.assertEqual(result.returncode, code, result)
        self.assertEqual(result.stderr.count(b"\n"), 1, result.stderr)  # nothing but our one line
        return result.stderr.decode()

    def converted(self, path, *options):
        out = self.folder / "converted.vtu"
        result = finish("convert", path, out, *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        return Vtu(out), result.stderr.decode()

    def series(self, path, mode, *options):
        report = report_of("simplify", path, "-o", self.folder / f"{mode}.pvd", "--series", mode, *options)
        listed = [(float(d.get("timestep")), d.get("file"))
                  for d in ElementTree.parse(self.folder / f"{mode}.pvd").iter("DataSet")]
        self.assertEqual(listed, [(t, f"{mode}_{i}.vtu") for i, t in enumerate(TIMES)])
        self.assertEqual([s["time"] for s in report["steps"]], TIMES)
        return [Vtu(self.folder / name) for _, name in listed]

    def expect_series(self, path):
        for mode in "shared", "each":
            for threads in "1", "2":
                steps = self.series(path, mode, "--max-error", "3%", "--threads", threads)
                for i, mesh in enumerate(steps):
                    self.assertLess(len(mesh.tets), len(self.tets))
                    np.testing.assert_array_equal(mesh.arrays["cell"]["number"][1][:len(mesh.tets)], i)
                    run("compare", path, self.folder / f"{mode}_{i}.vtu", "--time-step", i, "--max-error", "3%", "--array", "heat")
                if mode == "shared":
                    for mesh in steps:
                        np.testing.assert_array_equal(mesh.tets, steps[0].tets)

    def expect_resumed_only_as_it_was(self, path, changed):
        """A run that was interrupted is not gone on with when one of the case's files is another one."""
        out = self.folder / "out.vtu"
        arguments = ["simplify", path, "-o", out, "--reduction", "80%", "--chunk-tets", "4k", "--threads", "1"]
        arguments += ["--memory", least_memory(*arguments)]
        pattern = "out.vtu.tetfusion/round-*.state"
        self.stop_when(pattern, *arguments)
        self.assertIn(b"going on after", finish(*arguments, "--resume").stderr)
        self.stop_when(pattern, *arguments)
        changed.write_bytes(changed.read_bytes() + b"\n")
        self.assertIn("input pieces", self.refused_in_lines(*arguments, "--resume"))

    def refused_in_lines(self, *arguments):
        result = finish(*arguments)
        self.assertEqual(result.returncode, USAGE, result)
        return result.stderr.decode()


class EnSight(SolverTest):
    def write_case(self):
        """One part, with its heat and the number of the step."""
        def column(values):
            return "".join(f"{v:12.5e}\n" for v in values)

        head = "a part\nof tetrahedra\nnode id off\nelement id off\npart\n1\nall\ncoordinates\n"
        self.write((head + f"{len(self.points)}\n" + "".join(column(self.points[:, axis]) for axis in range(3)) +
                    f"tetra4\n{len(self.tets)}\n" + "".join("%d %d %d %d\n" % tuple(t + 1) for t in self.tets)).encode(), "mesh.geo")
        for i in range(len(TIMES)):
            self.write(("heat\npart\n1\ncoordinates\n" + column(self.heat(i))).encode(), f"heat.{i:03}")
            self.write(("number\npart\n1\ntetra4\n" + column(np.full(len(self.tets), i))).encode(), f"number.{i:03}")
        return self.write(f"""FORMAT
type: ensight gold
GEOMETRY
model: mesh.geo
VARIABLE
scalar per node: 1 heat heat.***
scalar per element: 1 number number.***
TIME
time set: 1
number of steps: {len(TIMES)}
filename start number: 0
filename increment: 1
time values:
{" ".join(map(str, TIMES))}
""".encode(), "run.case")

    def test_info(self):
        path = self.write_case()
        report = report_of("info", path, "--time-step", "1")
        self.assertEqual((report["time_steps"], report["time_step"]), (TIMES, 1))
        self.assertEqual(report["format"], "EnSight case, read with VTK")
        self.assertEqual(report["tets"], len(self.tets))
        ranges = {a["name"]: a["ranges"] for a in report["arrays"]}
        self.assertEqual(ranges["number"], [[1, 1]])
        self.assertEqual(ranges["TimeValue"], [[0.1, 0.1]])
        self.assertIn("\ntime steps    3, from 0 to 0.25; number 0, at 0, is read (--time-step)\n", run("info", path).decode())

    def test_one_step(self):
        path = self.write_case()
        for step in range(len(TIMES)):
            mesh, told = self.converted(path, "--time-step", step)
            np.testing.assert_allclose(values(mesh, "heat"), self.heat(step), rtol=1e-5)
            np.testing.assert_allclose(mesh.points, self.points, rtol=1e-5, atol=1e-9)
            np.testing.assert_array_equal(mesh.tets, self.tets)
            np.testing.assert_array_equal(mesh.arrays["cell"]["number"][1], step)
            self.assertNotIn("left out", told)
        self.assertIn("the time steps from 0.1 to 0.25 (the first of 3, at 0, is read; --time-step", self.converted(path)[1])

    def test_all_steps_are_a_series(self):
        self.expect_series(self.write_case())

    def test_a_changed_file_is_noticed(self):
        self.write(jittered(24), "grid.vtu")
        self.points, self.tets = np.array(Vtu(self.grid).points, dtype="f4"), Vtu(self.grid).tets
        self.expect_resumed_only_as_it_was(self.write_case(), self.folder / "heat.000")

    def test_what_is_not_read_is_named(self):
        path = self.write_case()
        self.assertNotIn("'heat'", self.converted(path)[1])
        path.write_text(path.read_text().replace("VARIABLE\n", "VARIABLE\nconstant per case: gravity 9.81\n"))
        self.assertIn("left out: variable 'gravity'", self.converted(path)[1])

    def test_files_that_lack_lines(self):
        path = self.write_case()
        self.assertNotIn("cut off", self.converted(path)[1])
        for name, count in ("mesh.geo", 8 + 1 + 3 * len(self.points) + 2 + len(self.tets)), ("heat.000", 4 + len(self.points)), \
                ("number.000", 4 + len(self.tets)):
            file = self.folder / name
            whole = file.read_bytes()
            lines = whole.splitlines(keepends=True)
            self.assertEqual(len(lines), count)
            for left in (count - 1, count - 5, count // 2, 5):
                file.write_bytes(b"".join(lines[:left]))
                self.assertRegex(self.refused("info", path), f"{name} .*(cut off|damaged)|VTK cannot read it")
            # Comments and blank lines are none, and the last one may have no end.
            file.write_bytes(b"".join(lines[:2] + [b"# so it is\n", b"\n"] + lines[2:])[:-1])
            if name != "mesh.geo":
                self.assertNotIn("cut off", self.converted(path)[1])
            file.write_bytes(whole)

    def test_an_interrupt_ends_vtk_that_reads_without_end(self):
        """Of a pipe that nobody writes to. Only the process itself is told, not the child in which VTK reads."""
        path = self.write_case()
        (self.folder / "heat.000").unlink()
        os.mkfifo(self.folder / "heat.000")
        out = self.folder / "out.vtu"
        for arguments in ("info", path), ("check", path), ("convert", path, out), ("simplify", path, "-o", out, *GOAL):
            for by in signal.SIGINT, signal.SIGTERM, signal.SIGHUP:
                with self.subTest(command=arguments[0], by=by):
                    process = self.start(*arguments, until="reading")
                    self.addCleanup(process.kill)
                    child = self.child_of(process)
                    process.send_signal(by)
                    code, message = self.end(process)
                    self.assertEqual(code, INTERRUPTED, message)
                    self.assertIn("interrupted", message)
                    self.assertFalse(os.path.exists(f"/proc/{child}"))
                    self.assertFalse(out.exists())

    def child_of(self, process):
        end = time.monotonic() + 30
        while time.monotonic() < end:
            children = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
            if children:
                return children[0]
            time.sleep(0.01)
        self.fail("no child reads")

    def test_no_output_takes_the_place_of_a_file_of_the_case(self):
        path = self.write_case()
        (self.folder / "heat.000").rename(self.folder / "heat_000.vtu")
        path.write_bytes(path.read_bytes().replace(b"heat.***", b"heat_***.vtu"))
        for i in 1, 2:
            (self.folder / f"heat.00{i}").rename(self.folder / f"heat_00{i}.vtu")
        told = self.refused("simplify", path, "-o", self.folder / "heat_000.vtu", *GOAL, code=USAGE)
        self.assertIn("that is one of the files of", told)


class OpenFoam(SolverTest):
    def faces(self):
        """Inner ones first, each with its owner and neighbour; seen from the owner they turn to the outside."""
        seen = {}
        for cell, tet in enumerate(self.tets):
            for face in ([1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]):
                seen.setdefault(tuple(sorted(tet[face])), []).append((cell, tet[face]))
        inner = sorted(((a[0], b[0], a[1]) for a, b in (f for f in seen.values() if len(f) == 2)), key=lambda f: f[:2])
        outer = [f[0] for f in seen.values() if len(f) == 1]
        return inner, outer

    def write_case(self):
        inner, outer = self.faces()
        self.outer = len(outer)

        def put(name, kind, text):
            path = self.folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(f"FoamFile\n{{ version 2.0; format ascii; class {kind}; object {path.name}; }}\n{text}\n")

        def listed(rows):
            return f"{len(rows)}(\n" + "\n".join(rows) + "\n)"

        mesh = "constant/polyMesh/"
        put(mesh + "points", "vectorField", listed(["(%.9g %.9g %.9g)" % tuple(p) for p in self.points]))
        put(mesh + "faces", "faceList", listed(["3(%d %d %d)" % tuple(f) for *_, f in inner + [(0, 0, f) for _, f in outer]]))
        put(mesh + "owner", "labelList", listed([str(o) for o, *_ in inner] + [str(o) for o, _ in outer]))
        put(mesh + "neighbour", "labelList", listed([str(n) for _, n, _ in inner]))
        put(mesh + "boundary", "polyBoundaryMesh", f"1( skin {{ type wall; nFaces {len(outer)}; startFace {len(inner)}; }} )")
        for i, time in enumerate(TIMES):
            put(f"{time}/number", "volScalarField", f"dimensions [0 0 0 0 0 0 0]; internalField uniform {i};"
                f"boundaryField {{ skin {{ type fixedValue; value uniform {i + 10}; }} }}")
            put(f"{time}/heat", "pointScalarField", "dimensions [0 0 0 0 0 0 0]; internalField nonuniform List<scalar> " +
                listed([f"{v:.9g}" for v in self.heat(i)]) + "; boundaryField { skin { type calculated; } }")
        return self.write(b"", "case.foam")

    def test_one_step(self):
        path = self.write_case()
        report = report_of("info", path)
        self.assertEqual((report["time_steps"], report["tets"], report["lower_cells"]), (TIMES, len(self.tets), self.outer))
        names = next(a for a in report["arrays"] if a["name"] == "block_names")
        self.assertEqual(names["texts"], ["internalMesh", "skin"])
        for step in range(len(TIMES)):
            mesh, _ = self.converted(path, "--time-step", step)
            np.testing.assert_array_equal(mesh.points, self.points)
            np.testing.assert_array_equal(np.sort(mesh.tets), np.sort(self.tets))
            np.testing.assert_array_equal(values(mesh, "heat"), self.heat(step))
            number, block = (mesh.arrays["cell"][name][1][:, 0] for name in ("number", "block"))
            np.testing.assert_array_equal(number, np.where(block == 1, step + 10, step))
            self.assertEqual(np.count_nonzero(block), self.outer)

    def test_all_steps_are_a_series(self):
        self.expect_series(self.write_case())

    def test_the_patches_are_the_boundary_of_the_result(self):
        path = self.write_case()
        out = self.folder / "out.vtu"
        run("simplify", path, "-o", out, "--array", "heat", *GOAL, "--verify", "--quiet")
        mesh = Vtu(out)
        self.assertEqual(len(mesh.others), self.outer)
        run("check", out)
        run("simplify", path, "-o", out, "--array", "heat", *GOAL, "--verify", "--quiet", "--drop-patches")
        self.assertEqual(len(Vtu(out).others), 0)
        found = report_of("info", path, "--drop-patches")
        self.assertEqual((found["tets"], found["lower_cells"], found["boundary_triangles"]), (len(self.tets), 0, self.outer))
        self.assertEqual(len(self.converted(path, "--drop-patches")[0].others), 0)
        self.assertEqual(len(self.converted(path, "--drop-patch", "skin")[0].others), 0)
        said = finish("info", path, "--drop-patch", "skim")
        self.assertIn(b"--drop-patch skim: there is no block of that name, but internalMesh, skin; of", said.stderr)

    def test_a_changed_file_is_noticed(self):
        self.write(jittered(24), "grid.vtu")
        self.points, self.tets = np.array(Vtu(self.grid).points, dtype="f4"), Vtu(self.grid).tets
        path = self.write_case()
        path.write_text("not empty")
        self.expect_resumed_only_as_it_was(path, self.folder / "constant/polyMesh/points")

    def test_fields_that_are_not_read_are_named(self):
        path = self.write_case()
        text = "FoamFile { version 2.0; format ascii; class surfaceScalarField; object phi; } internalField uniform 0; boundaryField { }"
        self.write(text.encode(), "0/phi")
        self.assertIn("left out: phi (surfaceScalarField)", self.converted(path)[1])
        (self.folder / "0/phi").unlink()
        self.write(gzip.compress(text.encode()), "0/phi.gz")
        self.assertIn("left out: phi (surfaceScalarField)", self.converted(path)[1])

    def test_texts_have_brackets_of_their_own(self):
        path = self.write_case()
        file = self.folder / "0" / "number"
        whole = file.read_text()
        expected = self.converted(path)[0].arrays["cell"]["number"][1]
        for note in ("see http://example.org/a", "in (m", r"a \" and {", "}"):
            file.write_text(whole.replace("format ascii;", f'format ascii; note "{note}";'))
            np.testing.assert_array_equal(self.converted(path)[0].arrays["cell"]["number"][1], expected)

    def test_packed_files_that_are_cut_off(self):
        path = self.write_case()
        file = self.folder / "0" / "number"
        packed = gzip.compress(file.read_bytes())
        file.unlink()
        for size in range(20, len(packed), 40):
            (self.folder / "0" / "number.gz").write_bytes(packed[:size])
            self.assertIn("number.gz is cut off or damaged", self.refused("info", path))
        (self.folder / "0" / "number.gz").write_bytes(packed)
        self.assertIn("number", self.converted(path)[0].arrays["cell"])

    def test_the_dictionary_from_its_own_folder(self):
        self.write_case()
        (self.folder / "system").mkdir()
        self.write(b"FoamFile { version 2.0; format ascii; class dictionary; object controlDict; }\n", "system/controlDict")
        for name, folder in (("controlDict", "system"), ("./controlDict", "system"), ("system/controlDict", ".")):
            run("convert", name, self.folder / "out.vtu", cwd=self.folder / folder)

    def test_memory_bounds_vtk_too(self):
        path = self.write_case()
        file = self.folder / "0" / "number"
        file.write_text(file.read_text().replace("uniform 0", "nonuniform List<scalar> 200000000{5}"))
        told = self.refused("info", path, "--memory", "1M", code=MEMORY)
        self.assertIn("VTK takes more than 256.0 MiB of memory to read it: give --memory 256M or more; or the file is damaged", told)

    def test_damaged_files_are_errors(self):
        path = self.write_case()
        for name in "constant/polyMesh/points", "constant/polyMesh/faces", "constant/polyMesh/owner", "0/number":
            file = self.folder / name
            data = file.read_bytes()
            for place in range(len(data) // 8, len(data), len(data) // 8):
                file.write_bytes(data[:place])
                result = finish("info", path)
                self.assertNotIn(-result.returncode, [s.value for s in signal.Signals], (name, place))
                if result.returncode != 0:
                    self.assertEqual((result.returncode, result.stderr.count(b"\n")), (BAD, 1), result.stderr)
            file.write_bytes(data)
        run("info", path)


class Hdf5Test(SolverTest):
    def setUp(self):
        if h5py is None:
            self.skipTest("h5py is not installed")
        super().setUp()

    def parts(self):
        """The tetrahedra below and above a height, each with points of its own: points, cells, which points these are."""
        above = self.points[self.tets][:, :, 2].mean(axis=1) > 3
        for chosen in self.tets[~above], self.tets[above]:
            ids, cells = np.unique(chosen, return_inverse=True)
            yield self.points[ids], cells.reshape(-1, 4), ids

    def expect_joined(self, mesh):
        """The mesh of grid.vtu, whatever the numbers of its points."""
        place = {tuple(p): i for i, p in enumerate(self.points.tolist())}
        number = np.array([place[tuple(p)] for p in mesh.points.tolist()])
        self.assertEqual(sorted(number), list(range(len(self.points))))
        self.assertEqual(sorted(map(sorted, number[mesh.tets].tolist())), sorted(map(sorted, self.tets.tolist())))
        return number

    def expect_errors_where_damaged(self, path):
        data, damaged = path.read_bytes(), self.folder / ("damaged" + path.suffix)
        codes = set()
        for place in range(16, len(data), len(data) // 40):
            for bytes_ in data[:place], data[:place] + b"\xff\xff\xff\x7f" + data[place + 4:]:
                damaged.write_bytes(bytes_)
                result = finish("info", damaged)
                self.assertNotIn(-result.returncode, [s.value for s in signal.Signals], place)
                codes.add(result.returncode)
                if result.returncode == BAD:
                    self.assertEqual(result.stderr.count(b"\n"), 1, result.stderr)
        self.assertIn(BAD, codes)


class VtkHdf(Hdf5Test):
    def write_file(self, name="mesh.vtkhdf", **attributes):
        path = self.folder / name
        parts = list(self.parts())
        with h5py.File(path, "w") as file:
            root = file.create_group("VTKHDF")
            root.attrs["Version"] = [1, 0]
            root.attrs.create("Type", np.bytes_("UnstructuredGrid"))
            for key, value in attributes.items():
                root.attrs.create(key, value)
            root["NumberOfPoints"] = [len(points) for points, *_ in parts]
            root["NumberOfCells"] = [len(cells) for _, cells, _ in parts]
            root["NumberOfConnectivityIds"] = [cells.size for _, cells, _ in parts]
            root["Points"] = np.concatenate([points for points, *_ in parts]).astype("f8")
            root["Connectivity"] = np.concatenate([cells.ravel() for _, cells, _ in parts]).astype("i8")
            root["Offsets"] = np.concatenate([4 * np.arange(len(cells) + 1) for _, cells, _ in parts]).astype("i8")
            root["Types"] = np.full(sum(len(cells) for _, cells, _ in parts), 10, dtype="u1")
            root["PointData/heat"] = np.concatenate([self.heat(1)[ids] for *_, ids in parts])
            root["CellData/part"] = np.repeat(np.arange(2, dtype="i4"), [len(cells) for _, cells, _ in parts])
            root["FieldData/run"] = np.array([7], dtype="i8")
        return path

    def test_partitions_are_one_mesh(self):
        path = self.write_file()
        mesh, told = self.converted(path)
        self.assertNotIn("left out", told)
        number = self.expect_joined(mesh)
        np.testing.assert_array_equal(values(mesh, "heat"), self.heat(1)[number])
        heights = mesh.points[mesh.tets][:, :, 2].mean(axis=1)
        np.testing.assert_array_equal(mesh.arrays["cell"]["part"][1][:, 0], heights > 3)
        self.assertNotIn("block", mesh.arrays["cell"])
        report = report_of("info", path)
        self.assertEqual((report["pieces"], report["point_type"], report["time_steps"]), (2, "Float64", []))
        self.assertEqual(report["format"], "VTKHDF file of type UnstructuredGrid, read with VTK")
        self.assertAlmostEqual(report["volume"], report_of("info", self.grid)["volume"], places=4)

    def test_what_is_not_read_is_said(self):
        path = self.write_file()
        with h5py.File(path, "a") as file:
            file["VTKHDF"].create_group("Steps")
        self.assertIn("with time steps, which are not read", self.refused("info", path))
        self.assertIn("of type 'PolyData'", self.refused("info", self.write_file("poly.vtkhdf", Type=np.bytes_("PolyData"))))
        self.assertIn("there are no time steps", self.refused("info", self.write_file(), "--time-step", "1", code=USAGE))
        other = self.folder / "other.h5"
        with h5py.File(other, "w") as file:
            file["numbers"] = [1, 2]
        self.assertIn("none of those that this build's VTK reads: VTKHDF, CGNS and Exodus", self.refused("info", other))

    def test_damaged_files_are_errors(self):
        self.expect_errors_where_damaged(self.write_file())


class Cgns(Hdf5Test):
    def node(self, parent, name, label, value=None):
        """As the library lays its nodes out in HDF5."""
        group = parent.create_group(name, track_order=True)
        kinds = {"i4": "I4", "i8": "I8", "f4": "R4", "f8": "R8", "i1": "C1"}
        if isinstance(value, str):
            value = np.frombuffer(value.encode(), dtype="i1")
        kind = "MT" if value is None else kinds[np.dtype(value.dtype).str[1:]]
        for key, text, length in ("name", name, 33), ("label", label, 33), ("type", kind, 3):
            group.attrs.create(key, np.bytes_(text), dtype=f"S{length}")
        group.attrs["flags"] = np.array([1], dtype="i4")
        if value is not None:
            group[" data"] = value
        return group

    def write_file(self, times=(), name="mesh.cgns"):
        path = self.folder / name
        with h5py.File(path, "w", track_order=True) as file:
            for key, text, length in ("name", "HDF5 MotherNode", 33), ("label", "Root Node of HDF5 File", 33), ("type", "MT", 3):
                file.attrs.create(key, np.bytes_(text), dtype=f"S{length}")
            file[" format"] = np.frombuffer(b"IEEE_LITTLE_32\0", dtype="i1")
            file[" hdf5version"] = np.frombuffer(b"HDF5 Version 1.10.8".ljust(33, b"\0"), dtype="i1")
            self.node(file, "CGNSLibraryVersion", "CGNSLibraryVersion_t", np.array([3.4], dtype="f4"))
            base = self.node(file, "Base", "CGNSBase_t", np.array([3, 3], dtype="i4"))
            self.node(base, "inlet", "Family_t")
            if times:
                iterations = self.node(base, "Iterations", "BaseIterativeData_t", np.array([len(times)], dtype="i4"))
                self.node(iterations, "TimeValues", "DataArray_t", np.array(times, dtype="f8"))
            for part, (points, cells, ids) in zip(("lower", "upper"), self.parts()):
                self.write_zone(base, part, points, cells, ids, len(times))
        return path

    def write_zone(self, base, name, points, cells, ids, steps):
        skin = self.skin_of(cells)
        zone = self.node(base, name, "Zone_t", np.array([[len(points)], [len(cells)], [0]], dtype="i4"))
        self.node(zone, "ZoneType", "ZoneType_t", "Unstructured")
        grid = self.node(zone, "GridCoordinates", "GridCoordinates_t")
        for axis, at in zip("XYZ", points.T):
            self.node(grid, "Coordinate" + axis, "DataArray_t", at.astype("f8"))
        first = 1
        for section, element, rows in ("tets", 10, cells), ("skin", 5, skin):
            elements = self.node(zone, section, "Elements_t", np.array([element, 0], dtype="i4"))
            self.node(elements, "ElementRange", "IndexRange_t", np.array([first, first + len(rows) - 1], dtype="i4"))
            self.node(elements, "ElementConnectivity", "DataArray_t", (rows + 1).astype("i4").ravel())
            first += len(rows)
        conditions = self.node(zone, "ZoneBC", "ZoneBC_t")
        middle = len(cells) + len(skin) // 2
        for name, kind, first, last in (("wall", "BCWall", len(cells) + 1, middle),
                                        ("opening", "FamilySpecified", middle + 1, len(cells) + len(skin)),
                                        ("farfield", "BCFarfield", middle, middle)):
            patch = self.node(conditions, name, "BC_t", kind)
            self.node(patch, "GridLocation", "GridLocation_t", "FaceCenter")
            self.node(patch, "PointRange", "IndexRange_t", np.array([[first, last]], dtype="i4"))
            if kind == "FamilySpecified":
                self.node(patch, "FamilyName", "FamilyName_t", "inlet")
        for step in range(max(1, steps)):
            for place, values_ in ("Vertex", self.heat(step)[ids]), ("CellCenter", np.full(len(cells), step)):
                solution = self.node(zone, f"{place}{step}", "FlowSolution_t")
                self.node(solution, "GridLocation", "GridLocation_t", place)
                self.node(solution, "heat" if place == "Vertex" else "number", "DataArray_t", values_.astype("f8"))
        if steps:
            iterations = self.node(zone, "ZoneIterations", "ZoneIterativeData_t")
            names = b"".join(f"Vertex{step}".encode().ljust(32) for step in range(steps))
            self.node(iterations, "FlowSolutionPointers", "DataArray_t", np.frombuffer(names, dtype="i1").reshape(steps, 32))

    @staticmethod
    def skin_of(cells):
        seen = {}
        for tet in cells:
            for face in ([1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]):
                seen.setdefault(tuple(sorted(tet[face])), []).append(tet[face])
        return np.array([faces[0] for faces in seen.values() if len(faces) == 1])

    def test_zones_and_their_patches_are_blocks(self):
        path = self.write_file()
        mesh, told = self.converted(path)
        self.assertIn("'Skipping BC_t node: BC_t type 'BCFarfield' not supported yet.'", told)
        number = self.expect_joined(mesh)
        np.testing.assert_allclose(values(mesh, "heat"), self.heat(0)[number])
        report = report_of("info", path)
        names = next(a for a in report["arrays"] if a["name"] == "block_names")
        self.assertEqual(names["texts"], ["lower", "lower/wall", "lower/opening", "upper", "upper/wall", "upper/opening"])
        self.assertEqual((report["format"], report["time_steps"]), ("CGNS file, read with VTK", []))
        (*_, lower), (*_, upper) = self.parts()
        self.assertEqual(report["merged_points"], len(np.intersect1d(lower, upper)))  # patches have their zone's points
        block = mesh.arrays["cell"]["block"][1][:, 0]
        heights = mesh.points[mesh.tets][:, :, 2].mean(axis=1)
        np.testing.assert_array_equal(block[:len(mesh.tets)], np.where(heights > 3, 3, 0))
        skins = [len(self.skin_of(cells)) for _, cells, _ in self.parts()]
        counts = [np.count_nonzero(block[len(mesh.tets):] == b) for b in (1, 2, 4, 5)]
        self.assertEqual(counts, [n for skin in skins for n in (skin // 2, skin - skin // 2)])
        self.assertEqual(report["lower_cells"], sum(skins))
        # Each patch lies where its triangles do: all of them are faces of tetrahedra.
        faces = {tuple(sorted(tet[face])) for tet in mesh.tets for face in ([1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2])}
        self.assertTrue(all(tuple(sorted(ids)) in faces for _, ids in mesh.others))

    def test_steps(self):
        path = self.write_file(TIMES)
        self.assertEqual(report_of("info", path)["time_steps"], TIMES)
        for step in range(len(TIMES)):
            mesh, _ = self.converted(path, "--time-step", step)
            np.testing.assert_allclose(values(mesh, "heat"), self.heat(step)[self.expect_joined(mesh)])
        run("simplify", path, "-o", self.folder / "o.pvd", *GOAL, "--quiet")
        self.assertEqual(len(list(self.folder.glob("o_*.vtu"))), len(TIMES))

    def test_damaged_files_are_errors(self):
        self.expect_errors_where_damaged(self.write_file())


if __name__ == "__main__":
    main()
