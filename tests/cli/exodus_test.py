#!/usr/bin/env python3
"""Exodus II files, and the time steps that they have. Usage: exodus_test.py TETFUSION"""
import itertools
import os
import shutil
import signal
import struct
import subprocess
import xml.etree.ElementTree as ElementTree

import numpy as np

from follow_test import jittered, values, with_arrays
from harness import BAD, USAGE, FolderTest, finish, least_memory, main, report_of, run
from independent_check import Vtu
from tiny_vtu import TinyVtu

try:
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
    from vtkmodules.vtkIOExodus import vtkExodusIIWriter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader, vtkXMLUnstructuredGridWriter
except ImportError:
    vtkExodusIIWriter = None

TIMES = [0.5, 1, 1, 4]
GOAL = ["--reduction", "40%"]


def write_exodus(path, grid, times, arrays_at):
    """The points and cells of a .vtu; arrays_at(step) gives values at points and cells by name."""
    told = times  # but VTK asks only once for times that are the same
    times = [time + i / 1024 for i, time in enumerate(told)]

    class Steps(VTKPythonAlgorithmBase):
        step = -1  # they are asked for one after the other

        def RequestInformation(self, request, inputs, outputs):
            information = outputs.GetInformationObject(0)
            information.Set(vtkStreamingDemandDrivenPipeline.TIME_STEPS(), times, len(times))
            information.Set(vtkStreamingDemandDrivenPipeline.TIME_RANGE(), [times[0], times[-1]], 2)
            return 1

        def RequestData(self, request, inputs, outputs):
            self.step += 1
            output = self.GetOutputDataObject(0)
            output.ShallowCopy(reader.GetOutput())
            for data, named in zip((output.GetPointData(), output.GetCellData()), arrays_at(self.step)):
                data.Initialize()
                for name, rows in named.items():
                    array = numpy_to_vtk(np.ascontiguousarray(rows, dtype="f8"), deep=1)
                    array.SetName(name)
                    data.AddArray(array)
            output.GetInformation().Set(output.DATA_TIME_STEP(), times[self.step])
            return 1

    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(grid))
    reader.Update()
    steps = Steps(nInputPorts=0, nOutputPorts=1, outputType="vtkUnstructuredGrid")
    writer = vtkExodusIIWriter()
    writer.SetFileName(str(path))
    writer.SetInputConnection(steps.GetOutputPort())
    writer.SetStoreDoubles(1)
    writer.WriteAllTimeStepsOn()
    writer.Write()
    data = path.read_bytes()
    for time, wanted in zip(times, told):
        if time != wanted:
            assert data.count(struct.pack(">d", time)) == 1
            data = data.replace(struct.pack(">d", time), struct.pack(">d", wanted))
    path.write_bytes(data)


def netcdf(dimensions, attributes, variables):
    """A file of NetCDF's classic format: name -> length; name -> value; name -> (dimensions, values, attributes)."""
    kinds = {np.dtype("S1"): 2, np.dtype("i4"): 4, np.dtype("f4"): 5, np.dtype("f8"): 6}

    def padded(data):
        return data + bytes(-len(data) % 4)

    def text(word):
        return struct.pack(">I", len(word)) + padded(word.encode())

    def listed(tag, items):
        return struct.pack(">II", tag if items else 0, len(items)) + b"".join(items)

    def attribute(name, value):
        if isinstance(value, str):
            return text(name) + struct.pack(">I", 2) + text(value)
        value = np.asarray(value)
        return text(name) + struct.pack(">II", kinds[value.dtype], 1) + value.astype(value.dtype.newbyteorder(">")).tobytes()

    def head(begins):
        names = list(dimensions)
        entries = []
        for (name, (shape, values, own)), begin in zip(variables.items(), begins):
            entries.append(text(name) + struct.pack(f">I{len(shape)}I", len(shape), *map(names.index, shape)) +
                           listed(12, [attribute(*item) for item in own.items()]) +
                           struct.pack(">III", kinds[values.dtype], values.nbytes, begin))
        return (b"CDF\x01" + bytes(4) + listed(10, [text(name) + struct.pack(">I", length) for name, length in dimensions.items()]) +
                listed(12, [attribute(*item) for item in attributes.items()]) + listed(11, entries))

    parts = [padded(values.astype(values.dtype.newbyteorder(">")).tobytes()) for _, values, _ in variables.values()]
    begins, at = [], len(head([0] * len(parts)))
    for part in parts:
        begins.append(at)
        at += len(part)
    return head(begins) + b"".join(parts)


def exodus_of_blocks(points, blocks, names=(), programs=()):
    """Blocks of (element type, rows of nodes counted from 0), what they are called, and who made the file in which version, when."""
    dimensions = {"len_string": 33, "time_step": 0, "num_dim": 3, "num_nodes": len(points), "num_elem": sum(len(rows) for _, rows in blocks),
                  "num_el_blk": len(blocks)}
    variables = {f"coord{axis}": (["num_nodes"], np.ascontiguousarray(points[:, k], dtype="f8"), {}) for k, axis in enumerate("xyz")}
    variables["eb_prop1"] = ["num_el_blk"], np.arange(1, len(blocks) + 1, dtype="i4"), {"name": "ID"}
    if names:
        letters = b"".join(name.encode().ljust(33, b"\0") for name in names)
        variables["eb_names"] = ["num_el_blk", "len_string"], np.frombuffer(letters, dtype="S1"), {}
    if programs:
        letters = b"".join(text.encode().ljust(33, b"\0") for program in programs for text in program)
        dimensions |= {"len_name": 129, "four": 4, "num_qa_rec": len(programs)}
        variables["qa_records"] = ["num_qa_rec", "four", "len_string"], np.frombuffer(letters, dtype="S1"), {}
    for number, (kind, rows) in enumerate(blocks, 1):
        rows = np.asarray(rows, dtype="i4")
        dimensions[f"num_el_in_blk{number}"], dimensions[f"num_nod_per_el{number}"] = rows.shape
        variables[f"connect{number}"] = [f"num_el_in_blk{number}", f"num_nod_per_el{number}"], rows + 1, {"elem_type": kind}
    attributes = {"api_version": np.float32(5.14), "version": np.float32(5.14), "floating_point_word_size": np.int32(8),
                  "file_size": np.int32(1), "maximum_name_length": np.int32(128 if programs else 32)}
    return netcdf(dimensions, attributes, variables)


class ExodusTest(FolderTest):
    def setUp(self):
        if vtkExodusIIWriter is None:
            self.skipTest("VTK for Python is not installed")
        super().setUp()

    def steps(self, times=TIMES, mesh=None, name="run.e"):
        """A file with a bump that moves from step to step, and an array of cells that says which step it is."""
        grid = self.write(mesh or jittered(6), "grid.vtu")
        points, cells = np.array(Vtu(grid).points, dtype="f8"), len(Vtu(grid).tets)
        self.bumps = [np.exp(-0.5 * (points[:, 0] - 2 * i) ** 2 - 0.1 * points[:, 1]) for i in range(len(times))]
        write_exodus(self.folder / name, grid, times, lambda i: ({"bump": self.bumps[i]}, {"number": np.full(cells, float(i))}))
        grid.unlink()
        return self.folder / name

    def without_steps(self):
        """How many there are is in the fifth to eighth byte of such a file."""
        data = self.steps().read_bytes()
        self.assertEqual((data[:3], struct.unpack(">I", data[4:8])), (b"CDF", (len(TIMES),)))
        return self.write(data[:4] + bytes(4) + data[8:], "none.e")

    def converted(self, path, step, name="step.vtu"):
        out = self.folder / name
        run("convert", path, out, "--time-step", step, "--quiet")
        return out

    def refused(self, *arguments, code=USAGE):
        result = finish(*arguments)
        self.assertEqual(result.returncode, code, result)
        return result.stderr.decode()


class OneStep(ExodusTest):
    def expect_step(self, out, step):
        mesh = Vtu(out)
        np.testing.assert_array_equal(values(mesh, "bump"), self.bumps[step])
        np.testing.assert_array_equal(np.unique(mesh.arrays["cell"]["number"][1]), [step])
        time = next(a for a in report_of("info", out)["arrays"] if a["name"] == "TimeValue")
        self.assertEqual(time["ranges"], [[TIMES[step]] * 2])

    def test_the_one_that_is_asked_for_is_read(self):
        path = self.steps()
        for step in range(len(TIMES)):
            self.expect_step(self.converted(path, step), step)
        self.expect_step(self.converted(path, "last"), len(TIMES) - 1)
        run("convert", path, self.folder / "first.vtu", "--quiet")
        self.expect_step(self.folder / "first.vtu", 0)
        run("convert", path, self.folder / "all.pvd", "--quiet")
        for step in range(len(TIMES)):
            self.expect_step(self.folder / f"all_{step}.vtu", step)

    def test_what_is_cut_off_is_refused(self):
        """VTK would give zeros for what is not there; but steps before that are read."""
        path = self.steps()
        data = path.read_bytes()
        for share in (0.3, 0.6, 0.8, 0.95, 0.999):
            path.write_bytes(data[:int(share * len(data))])
            said = finish("convert", path, self.folder / "out.vtu", "--time-step", "last").stderr.decode()
            self.assertRegex(said, "cut off|damaged")
            self.assertFalse((self.folder / "out.vtu").exists())
        self.expect_step(self.converted(path, 1), 1)

    def test_every_command_takes_it(self):
        path, out = self.steps(), self.folder / "out.vtu"
        step = self.converted(path, 1)
        options = ["--max-error", "3%", "--quiet"]
        run("simplify", path, "-o", out, "--time-step", "1", "--map", self.folder / "a.map", "--verify", *options)
        alone = self.folder / "alone.vtu"
        run("simplify", step, "-o", alone, *options)
        self.assertTrue(out.read_bytes() == alone.read_bytes())
        # Only one of the meshes that are compared has several.
        run("compare", path, out, "--time-step", "1", "--max-error", "3%", "--array", "bump")
        run("simplify", path, "-o", self.folder / "one.pvd", "--time-step", "1", *options)
        run("compare", path, self.folder / "one.pvd", "--time-step", "1", "--max-error", "3%", "--array", "bump")
        run("compare", path, out, "--max-error", "3%", "--array", "bump", code=1)
        self.assertTrue(all(a["max"] == 0 for a in report_of("compare", path, path, "--time-step", "1")["arrays"]))
        run("apply", self.folder / "a.map", path, "-o", out, "--time-step", "3", "--quiet")
        run("apply", self.folder / "a.map", self.converted(path, 3), "-o", alone, "--quiet")
        np.testing.assert_array_equal(values(Vtu(out), "bump"), values(Vtu(alone), "bump"))
        run("check", path, "--time-step", "2", "--fix", self.folder / "mended.vtu")
        self.expect_step(self.folder / "mended.vtu", 2)
        ranges = {a["name"]: a["ranges"] for a in report_of("info", path, "--time-step", "2")["arrays"]}
        self.assertEqual(ranges["number"], [[2, 2]])

    def test_steps_that_are_not_there(self):
        path, out = self.steps(), self.folder / "out.vtu"
        self.assertIn("run.e: there is no time step 4 (--time-step): it has 4, from 0 to 3",
                      self.refused("convert", path, out, "--time-step", "4"))
        self.assertIn("there is no time step 4", self.refused("simplify", path, "-o", self.folder / "o.pvd", "--time-step", "4"))
        one = self.steps([2], name="one.e")
        self.assertIn("there is no time step 1 (--time-step): it has 1, number 0", self.refused("info", one, "--time-step", "1"))
        run("info", one, "--time-step", "last")
        grid = self.write(TinyVtu())
        for other in grid, self.without_steps():
            for step in "1", "last":
                self.assertIn(f"{other.name}: there are no time steps in it to choose from",
                              self.refused("convert", other, out, "--time-step", step))
            run("convert", other, out, "--time-step", "0")
            out.unlink()
        for text in ("x", "-1", "1.5", "1e0", "1k", "Last", "", "9" * 20):
            self.assertIn("--time-step", self.refused("convert", path, out, f"--time-step={text}"))
        self.assertFalse(out.exists())

    def test_info_lists_them(self):
        path = self.steps()
        text = run("info", path).decode()
        self.assertIn("\ntime steps    4, from 0.5 to 4; number 0, at 0.5, is read (--time-step)\n", text)
        self.assertNotIn("left out", text)
        self.assertIn("number 3, at 4, is read", run("info", path, "--time-step", "last").decode())
        report = report_of("info", path, "--time-step", "1")
        self.assertEqual((report["time_steps"], report["time_step"]), (TIMES, 1))
        report = report_of("info", self.without_steps())
        self.assertEqual((report["time_steps"], report["time_step"]), ([], None))
        self.assertIn("\ntime steps    1, at 2\n", run("info", self.steps([2], name="one.e")).decode())

    def test_steps_in_one_vtu_are_not_taken_for_parts_of_a_mesh(self):
        """VTK writes the arrays of all steps, or all steps as pieces of one mesh; a single step is like any other file."""
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(self.write(TinyVtu(), "grid.vtu")))
        reader.Update()
        path = self.folder / "steps.vtu"
        for mode, steps in itertools.product(("Appended", "Binary", "Ascii"), (3, 1)):
            writer = vtkXMLUnstructuredGridWriter()
            writer.SetFileName(str(path))
            writer.SetInputData(reader.GetOutput())
            writer.SetNumberOfTimeSteps(steps)
            getattr(writer, f"SetDataModeTo{mode}")()
            writer.Start()
            for step in range(steps):
                writer.WriteNextTime(step)
            writer.Stop()
            if steps == 1:
                self.assertEqual(report_of("info", path)["tets"], len(TinyVtu().tets))
                continue
            for arguments in (["info", path], ["simplify", path, "-o", self.folder / "out.vtu", *GOAL]):
                self.assertIn("steps.vtu: it has 3 time steps (TimeValues)", self.refused(*arguments, code=BAD))

    def test_the_others_are_named_unless_one_was_asked_for(self):
        path, out = self.steps(), self.folder / "out.vtu"
        for arguments in ["convert", path, out], ["simplify", path, "-o", out, *GOAL]:
            told = finish(*arguments).stderr.decode()
            self.assertIn("the time steps from 1 to 4 (the first of 4, at 0.5, is read; --time-step takes another one, "
                          "an output called OUT_{step}.vtu or OUT.pvd all of them)", told)
            self.assertNotIn("time steps", finish(*arguments, "--time-step", "0").stderr.decode())

    def test_other_commands_say_which_one_they_read(self):
        path = self.steps()
        step = self.converted(path, 2)
        said = "of 4 time steps number 0 is read"
        for arguments in (["compare", path, step], ["compare", step, path]):
            self.assertIn(said, finish(*arguments).stderr.decode(), arguments)
            self.assertNotIn(said, finish(*arguments, "--time-step", "2").stderr.decode(), arguments)
        report = report_of("compare", step, path, "--time-step", "2")
        self.assertEqual(max(array["max"] for array in report["arrays"]), 0)

    def test_values_that_the_library_does_not_find_are_refused(self):
        """It would give what lies in memory."""
        try:
            import meshio
            import netCDF4  # noqa: F401: meshio needs it
        except ImportError as error:
            self.skipTest(str(error))
        points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
        path = self.folder / "meshio.e"
        meshio.Mesh(points, [("tetra", np.array([[0, 1, 2, 3]]))], point_data={"T": np.arange(4.0)}).write(path)
        self.assertIn("does not find the values at the nodes", self.refused("info", path, code=BAD))
        meshio.Mesh(points, [("tetra", np.array([[0, 1, 2, 3]]))]).write(path)
        run("info", path)

    def test_check_and_compare_look_at_all_steps(self):
        path, other = self.steps(), self.folder / "other.e"
        shutil.copy(path, other)
        for arguments in ["check", path], ["compare", path, other]:
            told = finish(*arguments)
            self.assertNotIn("is read", told.stderr.decode())
            self.assertIn(f"{arguments[-1]}, time step 3:", told.stdout.decode())
            self.assertEqual(len(report_of(*arguments)["steps"]), 4)
            self.assertNotIn("steps", report_of(*arguments, "--time-step", "1"))

    def test_what_check_leaves_out_is_said_once(self):
        said = finish("check", self.steps(), "--fix", self.folder / "out.vtu").stderr
        self.assertEqual(said.count(b"--time-step"), 1, said)

    def test_a_run_is_not_gone_on_with_at_another_step(self):
        path = self.steps([0, 1, 2], mesh=jittered(24))
        arguments = ["simplify", path, "-o", self.folder / "out.vtu", "--reduction", "80%", "--chunk-tets", "4k", "--threads", "1"]
        arguments += ["--memory", least_memory(*arguments)]
        run(*arguments, "--time-step", "2", "--quiet")
        whole = (self.folder / "out.vtu").read_bytes()
        folder = "out.vtu.tetfusion/round-*.state"
        self.assertIn("--resume", self.stop_when(folder, *arguments, "--time-step", "1"))
        other = self.refused(*arguments, "--time-step", "2", "--resume")
        self.assertIn("time step: 1", other)
        self.assertIn("time step: 2", other)
        told = finish(*arguments, "--time-step", "1", "--resume").stderr
        self.assertIn(b"going on after", told)
        self.assertFalse((self.folder / "out.vtu").read_bytes() == whole)
        self.stop_when(folder, *arguments, "--time-step", "last")
        self.assertIn(b"going on after", finish(*arguments, "--time-step", "2", "--resume").stderr)
        self.assertTrue((self.folder / "out.vtu").read_bytes() == whole)


class Blocks(ExodusTest):
    def test_blocks_are_regions(self):
        """VTK's writer makes a block for each value of an integer array."""
        grid = self.write(jittered(6), "grid.vtu")
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(grid))
        reader.Update()
        mesh = reader.GetOutput()
        middles = Vtu(grid).points[Vtu(grid).tets].mean(axis=1)
        blocks = np.where(middles[:, 0] < 3, 7, 12).astype("i4")
        mesh.GetCellData().Initialize()
        array = numpy_to_vtk(blocks, deep=1)
        array.SetName("material")
        mesh.GetCellData().AddArray(array)
        energy = numpy_to_vtk(np.array([7.5]), deep=1)
        energy.SetName("energy")
        mesh.GetFieldData().AddArray(energy)
        writer = vtkExodusIIWriter()
        writer.SetFileName(str(self.folder / "run.e"))
        writer.SetInputData(mesh)
        writer.SetBlockIdArrayName("material")
        writer.WriteAllTimeStepsOn()
        writer.Write()
        said = finish("simplify", self.folder / "run.e", "-o", self.folder / "out.vtu", *GOAL).stderr.decode()
        self.assertIn("interfaces of cell array ObjectId are kept", said)
        self.assertNotIn("left out", said)
        arrays = report_of("info", self.folder / "out.vtu")["arrays"]
        by_name = {array["name"]: array for array in arrays}
        self.assertEqual(by_name["ElementBlockIds"]["ranges"], [[7, 12]])
        self.assertEqual(by_name["ElementBlockIds"]["tuples"], 2)
        self.assertEqual(by_name["energy"]["ranges"], [[7.5, 7.5]])  # a global variable
        self.assertEqual(by_name["ObjectId"]["ranges"], [[7, 12]])


class Texts(ExodusTest):
    def test_nothing_lies_behind_their_ends(self):
        """VTK leaves there what lay in memory, where names may be longer than texts."""
        mesh = TinyVtu(2)
        path = self.write(exodus_of_blocks(np.array(mesh.points, dtype="f8"), [("TETRA", mesh.tets)],
                                           programs=[("mesher", "1.5", "11/30/26", "12:00:00")]), "run.e")
        results = []
        for filling in "17", "99":
            run("convert", path, self.folder / "out.vtu", "--encoding", "inline", env={**os.environ, "MALLOC_PERTURB_": filling})
            results.append((self.folder / "out.vtu").read_bytes())
        self.assertIn(b"QA_Records", results[0])
        self.assertEqual(results[0], results[1])


class CurvedElements(ExodusTest):
    def test_what_vtk_takes_for_linear_ones_is_read_by_its_corners(self):
        """VTK's reader takes TET14 for TET4, and its nodes for those of several elements."""
        mesh = TinyVtu(3)
        tets = np.array(mesh.tets)
        points = np.array(mesh.points, dtype="f8")
        more = points[tets].mean(axis=1)[:, None, :].repeat(10, axis=1).reshape(-1, 3)
        beside = len(points) + np.arange(10 * len(tets)).reshape(-1, 10)
        all_points = np.concatenate([points, more])
        triangles = tets[:, 1:]
        plain = self.write(exodus_of_blocks(points, [("TETRA", tets), ("TRI3", triangles)]), "plain.e")
        volume = report_of("info", plain)["volume"]
        named = self.write(exodus_of_blocks(points, [("TETRA", tets), ("TRI3", triangles)], ["bulk", "skin"]), "named.e")
        for path, patch in (named, "skin"), (plain, "ObjectId=2"):
            self.assertEqual(report_of("info", path, "--drop-patch", patch)["lower_cells"], 0)
        self.assertIn("there is no block of that name, but bulk, skin", self.refused("info", named, "--drop-patch", "Skin"))
        for order in ("TET14", "tetra14"):
            curved = self.write(exodus_of_blocks(all_points, [(order, np.concatenate([tets, beside], axis=1)),
                                                              ("TRI7", np.concatenate([triangles, beside[:, :4]], axis=1))]), "curved.e")
            self.assertIn("use --linearize", self.refused("check", curved, code=BAD))
            found = report_of("info", curved)
            self.assertEqual(found["needs"], ["--linearize"])
            self.assertEqual((found["tets"], found["lower_cells"]), (len(tets), len(tets)))
            self.assertAlmostEqual(found["volume"], volume)
        odd = self.write(exodus_of_blocks(all_points, [("SUPER14", np.concatenate([tets, beside], axis=1))]), "odd.e")
        self.refused("info", odd, code=BAD)


class Wedges(ExodusTest):
    def test_they_are_wound_as_their_points_lie(self):
        """Exodus sees a wedge's first triangle from inside, VTK, and what its writer makes, from outside."""
        cube = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype="f8")
        points = np.concatenate([cube, cube[4:] + [0, 0, 1]])
        hexahedron = [4, 5, 7, 6, 8, 9, 11, 10]
        for wedges in ([[0, 1, 3, 4, 5, 7], [0, 3, 2, 4, 7, 6]], [[0, 3, 1, 4, 7, 5], [0, 2, 3, 4, 6, 7]],
                       [[0, 1, 3, 4, 5, 7], [0, 2, 3, 4, 6, 7]]):
            path = self.write(exodus_of_blocks(points, [("WEDGE6", wedges), ("HEX8", [hexahedron])]), "mixed.e")
            run("convert", path, self.folder / "out.vtu", "--tetrahedralize")
            found = report_of("check", self.folder / "out.vtu")
            self.assertEqual((found["valid"], found["rewound"]), (True, 0))
            self.assertAlmostEqual(found["volume"], 2)


class AllSteps(ExodusTest):
    def simplify(self, *arguments, out="out_{step}.vtu"):
        return report_of("simplify", *arguments, "-o", self.folder / out, "--quiet")

    def outputs(self, pattern):
        return [p.read_bytes() for p in sorted(self.folder.glob(pattern))]

    def test_the_result_is_that_of_the_steps_in_files_of_their_own(self):
        path = self.steps()
        files = [self.converted(path, i, f"s{i}.vtu") for i in range(len(TIMES))]
        for mode, options in itertools.product(("shared", "each"), (GOAL, ["--max-error", "3%"])):
            self.simplify(*files, *options, "--series", mode, out="alone_{step}.vtu")
            for threads in "1", "2":
                report = self.simplify(path, *options, "--series", mode, "--threads", threads)
                self.assertTrue(self.outputs("out_*.vtu") == self.outputs("alone_*.vtu"), (mode, options))
                self.assertEqual([s["step"] for s in report["steps"]], ["0", "1", "2", "3"])
                self.assertEqual({s["input"] for s in report["steps"]}, {str(path)})
        first, second, *_ = self.outputs("out_*.vtu")
        self.assertFalse(first == second)

    def test_arrays_of_cells_are_those_of_each_step(self):
        path = self.steps()
        self.simplify(path, *GOAL)
        for i in range(len(TIMES)):
            mesh = Vtu(self.folder / f"out_{i}.vtu")
            np.testing.assert_array_equal(np.unique(mesh.arrays["cell"]["number"][1]), [i])

    def test_their_times_are_listed(self):
        path = self.steps([0.5, 1, 4])
        for mode in "shared", "each":
            report = self.simplify(path, *GOAL, "--series", mode, out=f"{mode}.pvd")
            listed = [(float(d.get("timestep")), d.get("file")) for d in ElementTree.parse(self.folder / f"{mode}.pvd").iter("DataSet")]
            self.assertEqual(listed, [(t, f"{mode}_{i}.vtu") for i, t in enumerate([0.5, 1, 4])])
            self.assertEqual([s["time"] for s in report["steps"]], [0.5, 1, 4])

    def test_one_of_them_alone(self):
        path = self.steps()
        run("simplify", path, "-o", self.folder / "alone.vtu", "--max-error", "3%", "--time-step", "3", "--quiet")
        for step in "3", "last":
            for mode in "shared", "each":
                report = self.simplify(path, "--max-error", "3%", "--time-step", step, "--series", mode)
                self.assertEqual([(s["step"], s["time"]) for s in report["steps"]], [("3", 4)])
                self.assertEqual([p.name for p in self.folder.glob("out_*")], ["out_3.vtu"])
            self.assertTrue(self.outputs("out_3.vtu") == self.outputs("alone.vtu"), mode)

    def test_what_is_left_out_of_a_mesh_is_said_once(self):
        text = "MeshVersionFormatted 2\nDimension 3\nVertices 4\n0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 1\nRidges 0\nTetrahedra 1\n1 2 3 4 1\nEnd\n"
        names = [self.write(text.encode(), f"step_{i}.mesh") for i in range(2)]
        said = finish("simplify", *names, "-o", self.folder / "o_{step}.vtu", "--reduction", "10%").stderr.decode()
        self.assertEqual(said.count("left out: Ridges"), 1, said)

    def test_their_numbers_sort_as_they_do(self):
        path = self.steps(times=range(11), mesh=TinyVtu(2))
        self.simplify(path, *GOAL)
        self.simplify(path, *GOAL, "--time-step", "3", out="alone_{step}.vtu")
        expected = [*(f"out_{i:02}.vtu" for i in range(11)), path.name]
        self.assertEqual(self.files(), ["alone_03.vtu", *expected])

    def test_a_file_with_one_step_counts_like_the_others(self):
        path = self.steps(times=[0.5], name="run_017.e")
        self.simplify(path, *GOAL, "--quiet")
        self.assertEqual(sorted(p.name for p in self.folder.glob("out_*.vtu")), ["out_0.vtu"])

    def test_steps_of_several_formats_are_read_in_turns(self):
        """The first one in windows, so that two steps are in hand at once; VTK reads one at a time."""
        path = self.steps()
        names = [self.converted(path, 0, "m_0.vtu")]
        names += [self.write(self.steps(times=[i], name="one.e").read_bytes(), f"m_{i}.e") for i in range(1, 7)]
        for _ in range(3):
            run("simplify", *names, "-o", self.folder / "mixed_{step}.vtu", "--array", "bump", *GOAL, "--threads", "2", "--quiet")
        self.assertEqual(len(list(self.folder.glob("mixed_*.vtu"))), 7)

    def test_nobody_is_told_of_other_steps(self):
        path = self.steps()
        for mode in "shared", "each":
            told = finish("simplify", path, "-o", self.folder / "out_{step}.vtu", "--series", mode, *GOAL)
            self.assertEqual(told.returncode, 0)
            self.assertNotIn(b"time steps", told.stderr)

    def test_several_files_go_on_with_one_another(self):
        files = [self.steps(name=f"part{i}.e") for i in range(2)]
        for options, numbers in ([], [0, 1, 2, 3] * 2), (["--time-step", "2"], [2, 2]):
            report = self.simplify(*files, *GOAL, *options)
            self.assertEqual([s["step"] for s in report["steps"]], [str(i) for i in range(len(numbers))])
            for i, number in enumerate(numbers):
                np.testing.assert_array_equal(np.unique(Vtu(self.folder / f"out_{i}.vtu").arrays["cell"]["number"][1]), [number])
        # Those with one step each have it by their names.
        files = [self.steps(times=[float(i)], name=f"t_{i:02d}.e") for i in (3, 5)]
        self.assertEqual([s["step"] for s in self.simplify(*files, *GOAL)["steps"]], ["03", "05"])

    def test_nothing_is_taken_of_a_pipe_to_see_whether_it_has_some(self):
        whole, pipe = self.write(jittered(6)), self.folder / "pipe"
        os.mkfifo(pipe)
        for source in whole, pipe:
            feeder = subprocess.Popen(["cp", whole, pipe]) if source == pipe else None
            run("simplify", source, "-o", self.folder / f"{source.stem}_{{step}}.vtu", "--series", "each", *GOAL, "--quiet")
            if feeder:
                self.assertEqual(feeder.wait(timeout=60), 0)
        self.assertTrue(self.outputs("pipe_0.vtu") == self.outputs("mesh_0.vtu"))

    def test_the_output_of_a_series_has_a_place_for_the_step(self):
        path = self.steps()
        told = self.refused("simplify", path, "-o", self.folder / "out.vtu", "--series", "each", *GOAL)
        self.assertIn(f"would be the output of all time steps of {path}: its name must hold {{step}}", told)

    def test_damaged_files_are_errors(self):
        data, path = self.steps(mesh=TinyVtu(2)).read_bytes(), self.folder / "damaged.e"
        codes = set()
        for place in range(0, len(data), len(data) // 60):
            for damaged in data[:place], data[:place] + b"\xff\xff\xff\x7f" + data[place + 4:]:
                path.write_bytes(damaged)
                result = finish("simplify", path, "-o", self.folder / "out_{step}.vtu", *GOAL)
                self.assertNotIn(-result.returncode, [s.value for s in signal.Signals], place)
                codes.add(result.returncode)
        self.assertIn(BAD, codes)


if __name__ == "__main__":
    main()
