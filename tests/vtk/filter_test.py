#!/usr/bin/env python3
"""The filter vtkTetFusion in VTK pipelines, beside the command. Usage: filter_test.py TETFUSION PACKAGES DATA_FOLDER
[unittest's arguments], where PACKAGES holds the Python package vtktetfusion. Without the data folder the tests of real meshes are
skipped."""
import inspect
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest
import unittest.mock
import warnings

import numpy as np
from vtkmodules.numpy_interface import dataset_adapter
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import (vtkBitArray, vtkDoubleArray, vtkFloatArray, vtkObject, vtkPoints, vtkSOADataArrayTemplate,
                                      vtkStringArray)
from vtkmodules.vtkCommonDataModel import (vtkCellArray, vtkCompositeDataSet, vtkDataObject, vtkImageData, vtkMultiBlockDataSet,
                                           vtkMultiPieceDataSet, vtkPartitionedDataSet, vtkPartitionedDataSetCollection, vtkPolyData,
                                           vtkTable, vtkUnstructuredGrid, VTK_HEXAHEDRON, VTK_POLY_LINE, VTK_POLYGON, VTK_TETRA,
                                           VTK_TRIANGLE)
from vtkmodules.vtkCommonExecutionModel import vtkTrivialProducer
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader, vtkXMLUnstructuredGridWriter

COMMAND, PACKAGES, DATA = (pathlib.Path(sys.argv.pop(1)).resolve() for _ in range(3))
sys.path[:0] = [str(PACKAGES)]
import vtktetfusion  # noqa: E402
from vtktetfusion import TetFusionError, TetFusionWarning, vtkTetFusion  # noqa: E402

USER_ERROR = 40000


def command(*arguments):
    subprocess.run([COMMAND, *map(str, arguments)], check=True, capture_output=True, timeout=300)


def read(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def box(n, point_type=np.float64):
    """n^3 cubes in six tetrahedra each, with arrays of many kinds."""
    side = n + 1
    z, y, x = np.meshgrid(*[np.arange(side)] * 3, indexing="ij")
    xyz = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1).astype(np.float64)
    inside = np.all((xyz > 0) & (xyz < n), axis=1)
    xyz[inside] += 0.1 * np.sin(np.arange(3 * inside.sum()).reshape(-1, 3) * 12.9898)
    corner = (xyz[:, 0] * 0).astype(np.int64) + np.arange(side ** 3)
    cells = corner.reshape(side, side, side)[:-1, :-1, :-1].ravel()
    steps = np.array([1, side, side * side])
    tets = []
    for number, order in enumerate([(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (1, 0, 2), (2, 1, 0)]):
        path = [cells]
        for axis in order:
            path.append(path[-1] + steps[axis])
        if number >= 3:
            path[1], path[2] = path[2], path[1]
        tets.append(np.stack(path, axis=1))
    ids = np.concatenate(tets, axis=1).reshape(-1, 4)
    grid = vtkUnstructuredGrid()
    points = vtkPoints()
    points.SetData(numpy_to_vtk(xyz.astype(point_type), deep=1))
    grid.SetPoints(points)
    set_cells(grid, VTK_TETRA, ids)
    add(grid.GetPointData(), "wave", np.sin(6 * xyz[:, 0] / n) * xyz[:, 1] + xyz[:, 2], np.float32)
    add(grid.GetPointData(), "velocity", xyz[:, ::-1].copy(), np.float64)
    add(grid.GetPointData(), "number", np.arange(len(xyz)), np.int32)
    add(grid.GetCellData(), "material", np.where(np.arange(len(ids)) < len(ids) // 2, 1, 2), np.uint8)
    add(grid.GetCellData(), "heat", np.arange(len(ids)) * 0.5, np.float64)
    grid.GetPointData().SetActiveScalars("wave")
    grid.GetPointData().SetActiveVectors("velocity")
    return grid


def set_cells(grid, kind, ids):
    cells = vtkCellArray()
    size = ids.shape[1]
    offsets = numpy_to_vtk(np.arange(0, ids.size + 1, size, dtype=np.int64), deep=1)
    cells.SetData(offsets, numpy_to_vtk(np.ascontiguousarray(ids, dtype=np.int64).ravel(), deep=1))
    grid.SetCells(kind, cells)


def add(data, name, values, kind):
    array = numpy_to_vtk(np.ascontiguousarray(values.astype(kind)), deep=1)
    array.SetName(name)
    data.AddArray(array)


def numbers(grid):
    """Everything that a grid holds, as numpy arrays by name."""
    cells = grid.GetCells()
    out = {"points": vtk_to_numpy(grid.GetPoints().GetData()), "offsets": vtk_to_numpy(cells.GetOffsetsArray()),
           "connectivity": vtk_to_numpy(cells.GetConnectivityArray()), "types": vtk_to_numpy(grid.GetCellTypesArray())}
    for kind, data in (("point", grid.GetPointData()), ("cell", grid.GetCellData())):
        for i in range(data.GetNumberOfArrays()):
            out[f"{kind} {data.GetArray(i).GetName()}"] = vtk_to_numpy(data.GetArray(i))
    return out


class Errors:
    """What a filter complains about; nothing is printed meanwhile."""

    def __init__(self, run):
        self.messages = []

        def listen(caller, event, text):
            self.messages.append(text)
        listen.CallDataType = "string0"
        for speaker in (run, run.GetExecutive()):
            speaker.AddObserver("ErrorEvent", listen)
            speaker.AddObserver("WarningEvent", listen)

    def first(self):
        return self.messages[0] if self.messages else ""


class FilterTest(unittest.TestCase):
    def expect_same(self, one, other):
        one, other = numbers(one), numbers(other)
        self.assertEqual(sorted(one), sorted(other))
        for name in one:
            self.assertEqual(one[name].dtype, other[name].dtype, name)
            self.assertEqual(one[name].shape, other[name].shape, name)
            self.assertEqual(one[name].tobytes(), other[name].tobytes(), name)

    def beside_command(self, path, options, **arguments):
        """What the command makes of a file, and the filter of what VTK reads from it."""
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "out.vtu"
            command("simplify", path, "-o", out, "--quiet", *options)
            expected = read(out)
        grid = read(path)
        result = vtktetfusion.simplify(grid, **arguments)
        self.assertLess(result.GetNumberOfCells(), grid.GetNumberOfCells())
        self.expect_same(result, expected)
        return result

    def run_on(self, grid, **settings):
        run = vtkTetFusion()
        run.SetInputDataObject(grid)
        for name, value in settings.items():
            getattr(run, "Set" + name)(value)
        return run


class SameMesh(FilterTest):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, grid):
        path = self.folder / "in.vtu"
        writer = vtkXMLUnstructuredGridWriter()
        writer.SetFileName(str(path))
        writer.SetInputData(grid)
        writer.Write()
        return path

    def test_generated_mesh(self):
        path = self.folder / "five.vtu"
        command("generate", "five", "--tets", "40k", "--jitter", "0.1", "-o", path)
        self.beside_command(path, ["--reduction", "80%"], reduction=0.8)
        self.beside_command(path, ["--max-error", "3%", "--boundary", "planar", "--chunk-tets", "5000"], max_error=0.03,
                            boundary="planar", chunk_tets=5000, threads=3)
        self.beside_command(path, ["--method", "tetfuse", "--tets", "20k", "--scalar-tolerance", "10%"], method="tetfuse", tets=20000,
                            scalar_tolerance=0.1)

    def test_arrays_of_many_kinds(self):
        for point_type in np.float32, np.float64:
            path = self.write(box(10, point_type))
            self.beside_command(path, ["--reduction", "60%"], reduction=0.6)
            self.beside_command(path, ["--reduction", "60%", "--array", "velocity", "--array", "cell:heat", "--regions", "none"],
                                reduction=0.6, arrays=["velocity", "cell:heat"], regions="none")
            self.beside_command(path, ["--reduction", "40%", "--roi", "wave>0.1", "--max-volume", "0.8"], reduction=0.4, roi="wave>0.1",
                                max_volume=0.8)
            self.beside_command(path, ["--reduction", "60%", "--weight", "number"], reduction=0.6, weight="number")
            self.beside_command(path, ["--array", "wave:2%", "--boundary", "1%"], arrays={"wave": 0.02}, boundary=0.01)

    def test_blunt_fin(self):
        path = DATA / "bluntfin.vtu"
        if not path.exists():
            self.skipTest(f"{path} is not there")
        result = self.beside_command(path, ["--reduction", "50%"], reduction=0.5)
        self.assertEqual(result.GetPointData().GetNumberOfArrays(), read(path).GetPointData().GetNumberOfArrays())


class Filter(FilterTest):
    def test_all_that_arrays_have_comes_out(self):
        grid = box(6)
        grid.GetPointData().GetArray("velocity").SetComponentName(1, "up")
        nameless = numpy_to_vtk(np.arange(grid.GetNumberOfPoints(), dtype=np.float32), deep=1)
        grid.GetPointData().AddArray(nameless)
        bits = vtkBitArray()
        bits.SetName("bits")
        for i in range(grid.GetNumberOfPoints()):
            bits.InsertNextValue(i % 2)
        grid.GetPointData().AddArray(bits)
        time_value = vtkDoubleArray()
        time_value.SetName("TimeValue")
        time_value.InsertNextValue(2.5)
        grid.GetFieldData().AddArray(time_value)
        out = vtktetfusion.simplify(grid, 0.5)
        data = out.GetPointData()
        self.assertEqual([data.GetArrayName(i) for i in range(data.GetNumberOfArrays())],
                         ["wave", "velocity", "number", None, "bits"])
        self.assertEqual([data.GetArray(i).GetClassName() for i in range(5)],
                         ["vtkFloatArray", "vtkDoubleArray", "vtkIntArray", "vtkFloatArray", "vtkBitArray"])
        self.assertEqual(data.GetArray(1).GetComponentName(1), "up")
        self.assertEqual(data.GetScalars().GetName(), "wave")
        self.assertEqual(data.GetVectors().GetName(), "velocity")
        kept = data.GetArray(4)
        self.assertEqual({kept.GetValue(i) for i in range(kept.GetNumberOfValues())}, {0, 1})
        for i, number in enumerate(vtk_to_numpy(data.GetArray("number"))):
            self.assertEqual(kept.GetValue(i), number % 2)
        self.assertEqual(out.GetFieldData().GetArray("TimeValue").GetValue(0), 2.5)
        self.assertEqual(len(set(vtk_to_numpy(data.GetArray("number")))), out.GetNumberOfPoints())
        for i in range(data.GetNumberOfArrays()):
            self.assertEqual(data.GetArray(i).GetNumberOfTuples(), out.GetNumberOfPoints())
        self.assertEqual(out.GetCellData().GetArray("heat").GetNumberOfTuples(), out.GetNumberOfCells())

    def test_strings_are_left_out_with_a_warning(self):
        grid = box(4)
        words = vtkStringArray()
        words.SetName("words")
        words.SetNumberOfValues(grid.GetNumberOfPoints())
        grid.GetPointData().AddArray(words)
        run = self.run_on(grid, TargetReduction=0.5)
        errors = Errors(run)
        run.Update()
        self.assertIn("point array 'words' (string) holds no numbers and is left out", errors.first())
        self.assertEqual(run.GetOutput().GetPointData().GetNumberOfArrays(), 3)
        self.assertEqual(run.GetErrorCode(), 0)

    def test_the_input_stays_as_it_is(self):
        grid = box(5)
        before = {name: values.copy() for name, values in numbers(grid).items()}
        vtktetfusion.simplify(grid, 0.7)
        for name, values in numbers(grid).items():
            np.testing.assert_array_equal(values, before[name])

    def test_memory_that_is_laid_out_otherwise(self):
        grid = box(6)
        expected = vtktetfusion.simplify(grid, 0.5)
        grid.GetCells().ConvertTo32BitStorage()
        out = vtktetfusion.simplify(grid, 0.5)
        self.assertFalse(out.GetCells().IsStorage64Bit())
        one, other = numbers(expected), numbers(out)
        for name in one:
            np.testing.assert_array_equal(one[name], other[name])

    def test_long_integers_that_are_laid_out_otherwise(self):
        grid = box(4)
        ids = vtkSOADataArrayTemplate["int64"]()
        ids.SetName("ids")
        ids.SetNumberOfComponents(1)
        ids.SetNumberOfTuples(grid.GetNumberOfPoints())
        for i in range(grid.GetNumberOfPoints()):
            ids.SetTypedComponent(i, 0, 2 ** 60 + i)
        grid.GetPointData().AddArray(ids)
        out = vtktetfusion.simplify(grid, 0.5)
        values = set(numbers(out)["point ids"].tolist())
        self.assertGreater(len(values), 0.9 * out.GetNumberOfPoints())
        self.assertLessEqual(values, set(range(2 ** 60, 2 ** 60 + grid.GetNumberOfPoints())))

    def test_arrays_of_one_name(self):
        grid = box(4)
        for name, components in (("one", 1), ("two", 1), ("way", 3)):
            array = vtkFloatArray()
            array.SetName(name)
            array.SetNumberOfComponents(components)
            array.SetNumberOfTuples(grid.GetNumberOfPoints())
            array.Fill(1)
            grid.GetPointData().AddArray(array)
        grid.GetPointData().SetActiveVectors("way")
        grid.GetPointData().GetArray("two").SetName("one")
        out = vtktetfusion.simplify(grid, 0.5)
        self.assertEqual(out.GetPointData().GetVectors().GetName(), "way")

    def test_input_array_to_process(self):
        grid = box(7)
        run = self.run_on(grid, TargetReduction=0.6, KeepRegions=False)
        run.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, "velocity")
        run.SetInputArrayToProcess(1, 0, 0, vtkDataObject.FIELD_ASSOCIATION_CELLS, "heat")
        run.Update()
        expected = vtktetfusion.simplify(grid, 0.6, arrays=["velocity", "cell:heat"], regions=[])
        self.expect_same(run.GetOutput(), expected)
        self.assertIn('"velocity"', run.GetReport())
        run = self.run_on(grid, TargetReduction=0.6)
        run.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, "nothing")
        errors = Errors(run)
        run.Update()
        self.assertEqual(run.GetErrorCode(), USER_ERROR + 2)
        self.assertIn("the input has no numbers by the name 'nothing' for input array to process 0", errors.first())

    def test_ghost_cells_are_left_out_and_their_points_stay(self):
        n = 8
        grid = box(n)
        ids = numbers(grid)["connectivity"].reshape(-1, 4)
        xyz = numbers(grid)["points"]
        high = xyz[ids][:, :, 2].mean(axis=1) > n - 1.5
        add(grid.GetCellData(), "vtkGhostType", high, np.uint8)
        out = vtktetfusion.simplify(grid, 0.9, boundary=0.05, regions=[])
        self.assertFalse(out.GetCellData().HasArray("vtkGhostType"))
        shared = np.intersect1d(ids[high], ids[~high])
        left = {tuple(p) for p in numbers(out)["points"]}
        self.assertTrue(all(tuple(p) in left for p in xyz[shared]))
        self.assertLess(out.GetNumberOfCells(), (~high).sum() // 2)

    def test_original_ids(self):
        """Points that stayed have the input's place and values; unused points, and those of ghosts alone, are counted."""
        grid = box(14)
        ids = numbers(grid)["connectivity"].reshape(-1, 4) + 5
        points = vtkPoints()
        points.SetData(numpy_to_vtk(np.concatenate([np.full((5, 3), 99.0), numbers(grid)["points"]]), deep=1))
        unused_first = vtkUnstructuredGrid()
        unused_first.SetPoints(points)
        set_cells(unused_first, VTK_TETRA, ids)
        add(unused_first.GetPointData(), "wave", np.concatenate([np.zeros(5), numbers(grid)["point wave"]]), np.float32)
        add(unused_first.GetCellData(), "vtkGhostType", np.arange(len(ids)) % 14 ** 3 >= 12 * 14 ** 2, np.uint8)
        before = numbers(unused_first)
        out = vtktetfusion.simplify(unused_first, 0.6, original_ids=True, chunk_tets=3000)
        self.assertEqual(out.GetPointData().GetArrayName(1), "OriginalPointIds")
        after = numbers(out)
        found = after["point OriginalPointIds"]
        self.assertEqual(found.dtype, np.int64)
        stayed = found >= 0
        self.assertTrue((found[~stayed] == -1).all())
        self.assertGreater((~stayed).sum(), 10)
        np.testing.assert_array_equal(after["points"][stayed], before["points"][found[stayed]])
        np.testing.assert_array_equal(after["point wave"][stayed], before["point wave"][found[stayed]])
        empty = vtktetfusion.simplify(vtkUnstructuredGrid(), 0.6, original_ids=True)
        self.assertEqual(empty.GetPointData().GetArray("OriginalPointIds").GetNumberOfTuples(), 0)
        with self.assertRaises(TetFusionError) as caught:
            vtktetfusion.simplify(out, 0.5, original_ids=True)
        self.assertIn("leave original_ids out", str(caught.exception))

    def test_empty_pieces(self):
        grid = box(2)
        only_ghosts = box(2)
        add(only_ghosts.GetCellData(), "vtkGhostType", np.ones(only_ghosts.GetNumberOfCells()), np.uint8)
        for empty in vtkUnstructuredGrid(), only_ghosts:
            run = self.run_on(empty, TargetReduction=0.5)
            errors = Errors(run)
            run.Update()
            self.assertEqual(errors.messages, [])
            self.assertEqual(run.GetErrorCode(), 0)
            self.assertEqual(run.GetOutput().GetNumberOfCells(), 0)
        self.assertEqual([run.GetOutput().GetPointData().GetArrayName(i) for i in range(3)],
                         [grid.GetPointData().GetArrayName(i) for i in range(3)])

    def test_composite_inputs(self):
        blocks = vtkMultiBlockDataSet()
        blocks.SetBlock(0, box(5))
        blocks.SetBlock(2, box(6))
        source = vtkTrivialProducer()
        source.SetOutput(blocks)
        run = vtkTetFusion()
        run.SetInputConnection(source.GetOutputPort())
        run.SetTargetReduction(0.5)
        run.Update()
        out = run.GetOutputDataObject(0)
        self.assertTrue(out.IsA("vtkMultiBlockDataSet"))
        self.assertIsNone(out.GetBlock(1))
        for block in 0, 2:
            self.expect_same(out.GetBlock(block), vtktetfusion.simplify(blocks.GetBlock(block), 0.5))
        self.assertTrue(vtktetfusion.simplify(blocks, 0.5).IsA("vtkMultiBlockDataSet"))

    def test_blocks_without_volume_come_back_as_they_are(self):
        volume = box(4)
        side_set = vtkUnstructuredGrid()
        side_set.SetPoints(volume.GetPoints())
        side_set.InsertNextCell(VTK_TRIANGLE, 3, [0, 1, 5])
        add(side_set.GetCellData(), "pressure", np.array([7]), np.float64)
        patch = vtkPolyData()
        patch.SetPoints(volume.GetPoints())
        triangles = vtkCellArray()
        triangles.InsertNextCell(3, [1, 6, 5])
        patch.SetPolys(triangles)
        add(patch.GetPointData(), "wave", np.arange(volume.GetNumberOfPoints()), np.float32)
        blocks = vtkMultiBlockDataSet()
        for number, block in enumerate((volume, side_set, patch)):
            blocks.SetBlock(number, block)
        out = vtktetfusion.simplify(blocks, 0.5, original_ids=True)
        self.expect_same(out.GetBlock(0), vtktetfusion.simplify(volume, 0.5, original_ids=True))
        for number, corners in (1, [0, 1, 5]), (2, [1, 6, 5]):
            block = out.GetBlock(number)
            held = numbers(block)
            self.assertEqual(held["connectivity"].tolist(), corners)
            self.assertEqual(held["types"].tolist(), [VTK_TRIANGLE])
            np.testing.assert_array_equal(held["points"], numbers(volume)["points"])
            np.testing.assert_array_equal(held["point OriginalPointIds"], np.arange(volume.GetNumberOfPoints()))
        self.assertEqual(numbers(out.GetBlock(1))["cell pressure"], [7])
        np.testing.assert_array_equal(numbers(out.GetBlock(2))["point wave"], np.arange(volume.GetNumberOfPoints()))
        for alone in (side_set,), (patch, side_set):
            surfaces = vtkMultiBlockDataSet()
            for number, block in enumerate(alone):
                surfaces.SetBlock(number, block)
            with self.assertRaisesRegex(TetFusionError, "no block of the input has tetrahedra") as caught:
                vtktetfusion.simplify(surfaces, 0.5)
            self.assertEqual(caught.exception.code, 3)

    def test_blocks_that_may_move_apart_are_warned_of(self):
        blocks = vtkMultiBlockDataSet()
        for i in range(3):
            blocks.SetBlock(i, box(3))
        for boundary, expected in (("exact", 0), ("planar", 1)):
            with warnings.catch_warnings(record=True) as said:
                warnings.simplefilter("always")
                vtktetfusion.simplify(blocks, 0.1, boundary=boundary)
            self.assertEqual(sum("where blocks touch" in str(one.message) for one in said), expected)

    def test_other_blocks_are_refused(self):
        image = vtkImageData()
        image.SetDimensions(2, 2, 2)
        for block, name in (image, "vtkImageData"), (vtkTable(), "vtkTable"):
            blocks = vtkMultiBlockDataSet()
            blocks.SetBlock(0, block)
            with self.assertRaisesRegex(TetFusionError, f"block 1: it is a {name}, and not a vtkUnstructuredGrid") as caught:
                vtktetfusion.simplify(blocks, 0.5)
            self.assertEqual(caught.exception.code, 3)

    def test_composite_inputs_of_other_kinds(self):
        grid = box(4)
        names = ["fluid", None]
        parts = vtkPartitionedDataSetCollection()
        for number, name in enumerate(names):
            part = vtkPartitionedDataSet()
            part.SetPartition(0, grid)
            parts.SetPartitionedDataSet(number, part)
            if name:
                parts.GetMetaData(number).Set(vtkCompositeDataSet.NAME(), name)
        inner = vtkMultiBlockDataSet()
        inner.SetBlock(0, grid)
        inner.GetMetaData(0).Set(vtkCompositeDataSet.NAME(), "inside")
        outer = vtkMultiBlockDataSet()
        outer.SetBlock(0, inner)
        add(outer.GetFieldData(), "time", np.array([2.5]), np.float64)
        pieces = vtkMultiPieceDataSet()
        pieces.SetPiece(0, grid)
        expected = vtktetfusion.simplify(grid, 0.5)
        run = vtkTetFusion()
        run.SetTargetReduction(0.5)
        for blocks, find in ((parts, lambda out: out.GetPartition(1, 0)), (outer, lambda out: out.GetBlock(0).GetBlock(0)),
                             (pieces, lambda out: out.GetPiece(0)), (grid, lambda out: out)):
            run.SetInputDataObject(blocks)  # one filter for all of them
            run.Update()
            out = run.GetOutputDataObject(0)
            self.assertEqual(out.GetClassName(), blocks.GetClassName())
            self.expect_same(find(out), expected)
            if blocks is parts:
                self.assertEqual(out.GetMetaData(0).Get(vtkCompositeDataSet.NAME()), "fluid")
            if blocks is outer:
                self.assertEqual(out.GetBlock(0).GetMetaData(0).Get(vtkCompositeDataSet.NAME()), "inside")
                self.assertEqual(out.GetFieldData().GetArray("time").GetValue(0), 2.5)
        self.assertEqual(vtkTetFusion().GetOutput().GetNumberOfCells(), 0)

    def test_what_is_said_of_a_block_has_its_name(self):
        hexahedra = vtkUnstructuredGrid()
        hexahedra.SetPoints(box(1).GetPoints())
        hexahedra.InsertNextCell(VTK_HEXAHEDRON, 8, [0, 1, 3, 2, 4, 5, 7, 6])
        blocks = vtkMultiBlockDataSet()
        for number, block in enumerate((box(3), hexahedra, box(3), hexahedra)):
            blocks.SetBlock(number, block)
        blocks.GetMetaData(0).Set(vtkCompositeDataSet.NAME(), "inlet")
        blocks.GetMetaData(1).Set(vtkCompositeDataSet.NAME(), "valve")
        run = self.run_on(blocks, TargetReduction=0.99)
        errors = Errors(run)
        run.Update()
        self.assertEqual(run.GetErrorCode(), USER_ERROR + 3)
        self.assertTrue(run.GetErrorMessage().startswith("block 'valve': the mesh: cell 0 is a hexahedron"), run.GetErrorMessage())
        warned = run.GetWarnings().splitlines()
        self.assertEqual([line.partition(": The goal was not reached")[0] for line in warned], ["block 'inlet'", "block 3"])
        self.assertTrue(run.GetNotices().startswith("block 'inlet': array wave steers"), run.GetNotices())
        for part in "block 'inlet': ", "block 'valve': ", "block 3: ", "block 4: ":
            self.assertTrue(any(part in message for message in errors.messages), part)

    def test_progress_and_errors_of_composite_inputs(self):
        blocks = vtkMultiBlockDataSet()
        for block in range(3):
            blocks.SetBlock(block, box(8))
        run = self.run_on(blocks, TargetReduction=0.5)
        shares = []
        run.AddObserver("ProgressEvent", lambda caller, event: shares.append(caller.GetProgress()))
        run.Update()
        self.assertEqual(shares, sorted(shares))
        for block in (1, 2):  # each is a third of the way, however often there was something to tell
            self.assertLess(min(abs(share - block / 3) for share in shares), 1e-6)
        self.assertTrue(any(share < 0.3 for share in shares))
        self.assertEqual(shares[-1], 1)
        hexahedra = vtkUnstructuredGrid()
        hexahedra.SetPoints(box(1).GetPoints())
        hexahedra.InsertNextCell(VTK_HEXAHEDRON, 8, [0, 1, 3, 2, 4, 5, 7, 6])
        blocks.SetBlock(1, hexahedra)
        blocks.Modified()
        errors = Errors(run)
        run.Update()
        self.assertEqual(run.GetErrorCode(), USER_ERROR + 3)
        self.assertIn("cell 0 is a hexahedron", errors.first())
        blocks.SetBlock(1, None)
        blocks.Modified()
        run.Update()
        self.assertEqual(run.GetErrorCode(), 0)

    def test_lower_cells_are_kept_and_others_refused_or_split(self):
        grid = box(3)
        n = grid.GetNumberOfCells()
        mixed = vtkUnstructuredGrid()
        mixed.SetPoints(grid.GetPoints())
        mixed.InsertNextCell(VTK_TRIANGLE, 3, [0, 1, 4])
        for c in range(n):
            ids = grid.GetCell(c).GetPointIds()
            mixed.InsertNextCell(VTK_TETRA, 4, [ids.GetId(k) for k in range(4)])
        out = vtktetfusion.simplify(mixed, 0.3)
        self.assertEqual(out.GetCellType(out.GetNumberOfCells() - 1), VTK_TRIANGLE)
        self.assertEqual(out.GetCellType(0), VTK_TETRA)
        mixed.InsertNextCell(VTK_HEXAHEDRON, 8, [0, 1, 5, 4, 16, 17, 21, 20])
        with self.assertRaises(TetFusionError) as caught:
            vtktetfusion.simplify(mixed, 0.3)
        self.assertEqual(caught.exception.code, 3)
        self.assertIn(f"cell {n + 1} is a hexahedron (VTK cell type 12): use tetrahedralize", str(caught.exception))
        hexes = vtkUnstructuredGrid()
        hexes.SetPoints(grid.GetPoints())
        hexes.InsertNextCell(VTK_HEXAHEDRON, 8, [0, 1, 5, 4, 16, 17, 21, 20])
        ids = numpy_to_vtk(np.array([7]))
        ids.SetName("ids")
        hexes.GetCellData().SetGlobalIds(ids)
        out = vtktetfusion.simplify(hexes, 0.5, tetrahedralize=True)
        self.assertGreaterEqual(out.GetNumberOfCells(), 5)
        self.assertIsNone(out.GetCellData().GetGlobalIds())  # its parts have the one number
        self.assertEqual(set(vtk_to_numpy(out.GetCellData().GetPedigreeIds())), {7})
        ids = numpy_to_vtk(np.arange(n), deep=1)
        ids.SetName("ids")
        grid.GetCellData().SetGlobalIds(ids)
        out = vtktetfusion.simplify(grid, 0.3, tetrahedralize=True)  # where nothing is split they stay what they are
        self.assertIsNotNone(out.GetCellData().GetGlobalIds())

    def test_patches_are_dropped(self):
        volume = box(5)
        expected = vtktetfusion.simplify(volume, 0.5, regions=[])
        mixed = vtkUnstructuredGrid()
        mixed.SetPoints(volume.GetPoints())
        ids = numbers(volume)["connectivity"].reshape(-1, 4)
        for tet in ids.tolist():
            mixed.InsertNextCell(VTK_TETRA, 4, tet)
        for kind, corners in (VTK_TRIANGLE, [50, 51, 57]), (VTK_POLY_LINE, [0, 1, 2, 3]), (VTK_POLYGON, [0, 1, 7, 6, 3]):
            mixed.InsertNextCell(kind, len(corners), corners)
        add(mixed.GetPointData(), "wave", numbers(volume)["point wave"], np.float32)
        with self.assertRaisesRegex(TetFusionError, "drop_patches leaves such cells out"):
            vtktetfusion.simplify(mixed, 0.5)
        out = vtktetfusion.simplify(mixed, 0.5, drop_patches=True)
        self.assertEqual(set(numbers(out)["types"]), {VTK_TETRA})
        for name in "points", "connectivity", "point wave":
            np.testing.assert_array_equal(numbers(out)[name], numbers(expected)[name])
        patch = vtkPolyData()
        patch.SetPoints(volume.GetPoints())
        patch.Allocate()
        patch.InsertNextCell(VTK_TRIANGLE, 3, [0, 1, 7])
        add(patch.GetPointData(), "wave", numbers(volume)["point wave"], np.float32)
        blocks = vtkMultiBlockDataSet()
        blocks.SetBlock(0, mixed)
        blocks.SetBlock(1, patch)
        run = self.run_on(blocks, TargetReduction=0.5)
        run.DropPatchesOn()
        self.assertIn("DropPatches: 1", str(run))
        run.Update()
        self.assertEqual(run.GetErrorMessage(), "")
        self.assertEqual(run.GetOutputDataObject(0).GetBlock(0).GetNumberOfCells(), out.GetNumberOfCells())
        dropped = run.GetOutputDataObject(0).GetBlock(1)
        self.assertEqual((dropped.GetNumberOfCells(), dropped.GetNumberOfPoints()), (0, 0))
        self.assertTrue(dropped.GetPointData().HasArray("wave"))

    def test_errors(self):
        grid = box(3)
        run = self.run_on(grid, TargetReduction=1.5)
        errors = Errors(run)
        run.Update()
        self.assertEqual(run.GetErrorCode(), USER_ERROR + 2)
        self.assertIn("reduction must be at least 0% and less than 100%", errors.first())
        run.SetTargetReduction(0.2)
        run.Update()
        self.assertEqual(run.GetErrorCode(), 0)
        self.assertGreater(run.GetOutput().GetNumberOfCells(), 0)

    def test_options_of_the_other_method_are_refused(self):
        for settings, part in (({"Method": vtkTetFusion.TETFUSE, "MinimumQuality": 0.3}, "min_quality belongs to method fuse"),
                               ({"MemoryLimit": -1}, "memory must be at least 0")):
            run = self.run_on(box(2), **settings)
            errors = Errors(run)
            run.Update()
            self.assertEqual(run.GetErrorCode(), USER_ERROR + 2)
            self.assertIn(part, errors.first())

    def test_callers_may_remove_all_observers(self):
        run = self.run_on(box(5), TargetReduction=1.5)
        run.RemoveAllObservers()
        errors = Errors(run)
        run.Update()
        self.assertEqual(run.GetErrorCode(), USER_ERROR + 2)
        for reduction in 0.5, 0.4:
            run.SetTargetReduction(reduction)
            run.Update()
            self.assertEqual((run.GetErrorCode(), run.GetErrorMessage()), (0, ""))
            self.assertEqual(run.GetNotices().count("wave steers"), 1)
        surface = vtkUnstructuredGrid()
        surface.SetPoints(box(1).GetPoints())
        surface.InsertNextCell(VTK_TRIANGLE, 3, [0, 1, 2])
        run.SetInputData(surface)
        run.Update()
        self.assertEqual(run.GetErrorCode(), USER_ERROR + 3)
        self.assertIn("no tetrahedra", errors.messages[-2])

    def test_what_it_says_is_kept(self):
        """Also where VTK's warnings are off, so that no event says it."""
        vtkObject.GlobalWarningDisplayOff()
        self.addCleanup(vtkObject.GlobalWarningDisplayOn)
        run = self.run_on(box(5), TargetReduction=1.5, KeepRegions=False)
        run.Update()
        self.assertEqual(run.GetErrorMessage(), "reduction must be at least 0% and less than 100%")
        self.assertFalse(run.GetGoalReached())
        run.SetTargetReduction(0.1)
        run.Update()
        self.assertEqual((run.GetErrorMessage(), run.GetWarnings()), ("", ""))
        self.assertTrue(run.GetGoalReached())
        run.SetTargetReduction(0.99)
        run.Update()
        self.assertIn("The goal was not reached: ", run.GetWarnings())
        self.assertFalse(run.GetGoalReached())
        with self.assertRaisesRegex(TetFusionError, "reduction must be at least 0%"):
            vtktetfusion.simplify(box(3), 1.5)
        with self.assertWarnsRegex(TetFusionWarning, "The goal was not reached: "):
            vtktetfusion.simplify(box(3), 0.99)

    def test_a_goal_out_of_reach(self):
        """A warning, with Strict an error; the grid is there in any case."""
        run = self.run_on(box(3), TargetReduction=0.99)
        errors = Errors(run)
        for strict in (False, True):
            run.SetStrict(strict)
            run.Update()
            self.assertEqual(run.GetErrorCode(), USER_ERROR + 6 if strict else 0)
            self.assertIn("The goal was not reached: ", errors.first())
            self.assertGreater(run.GetOutput().GetNumberOfCells(), 0)
            errors.messages.clear()

    def test_settings_are_printed_and_kept(self):
        run = self.run_on(box(2), TargetReduction=0.25, MaximumError=0.01, BoundaryMode=vtkTetFusion.PLANAR)
        run.AddSteeringArray(vtkDataObject.FIELD_ASSOCIATION_POINTS, "wave", 0.1)
        run.OriginalIdsOn()
        text = str(run)
        for part in "OriginalIds: 1", "TargetReduction: 0.25", "BoundaryMode: planar", "SteeringArrays: wave", "Method: fuse":
            self.assertIn(part, text)
        before = run.GetMTime()
        run.SetTargetReduction(0.25)
        self.assertEqual(run.GetMTime(), before)
        run.SetTargetReduction(0.3)
        self.assertGreater(run.GetMTime(), before)


class Progress(FilterTest):
    def test_never_falls(self):
        run = self.run_on(box(14), TargetReduction=0.8, ChunkTets=1500, NumberOfThreads=3)
        shares = []
        run.AddObserver("ProgressEvent", lambda caller, event: shares.append(caller.GetProgress()))
        run.Update()
        self.assertEqual(shares, sorted(shares))
        self.assertEqual(shares[-1], 1)
        self.assertGreater(len(set(shares)), 5)

    def test_moves_within_a_chunk(self):
        run = self.run_on(box(40), TargetReduction=0.9, ChunkTets=1000000)
        shares = set()
        run.AddObserver("ProgressEvent", lambda caller, event: shares.add(caller.GetProgress()))
        run.Update()
        self.assertGreater(len([share for share in shares if 0.3 < share < 0.6]), 3)

    def test_abort_from_an_observer(self):
        run = self.run_on(box(40), TargetReduction=0.9)
        asked = []

        def stop(caller, event):
            if caller.GetProgress() > 0.1 and not asked:
                asked.append(time.monotonic())
                caller.SetAbortExecute(1)
        observer = run.AddObserver("ProgressEvent", stop)
        errors = Errors(run)
        run.Update()
        took = time.monotonic() - asked[0]
        self.assertLess(took, 5)
        self.assertEqual(errors.messages, [])
        self.assertEqual(run.GetErrorCode(), USER_ERROR + 130)
        self.assertEqual(run.GetOutput().GetNumberOfCells(), 0)
        run.RemoveObserver(observer)
        run.Modified()
        run.Update()
        self.assertEqual(run.GetErrorCode(), 0)
        self.assertGreater(run.GetOutput().GetNumberOfCells(), 0)


    def test_an_abort_ends_the_blocks_that_are_not_done(self):
        blocks = vtkMultiBlockDataSet()
        for i in range(4):
            blocks.SetBlock(i, box(8))
        patch = vtkPolyData()
        patch.SetPoints(box(1).GetPoints())
        patch.Allocate()
        patch.InsertNextCell(VTK_TRIANGLE, 3, [0, 1, 2])
        blocks.SetBlock(4, patch)
        run = self.run_on(blocks, TargetReduction=0.5)

        def stop(caller, event):
            if 0.26 < caller.GetProgress() < 0.5:
                caller.SetAbortExecute(1)
        observer = run.AddObserver("ProgressEvent", stop)
        errors = Errors(run)
        run.Update()
        self.assertEqual((run.GetErrorCode(), errors.messages), (USER_ERROR + 130, []))
        cells = [run.GetOutputDataObject(0).GetBlock(i).GetNumberOfCells() for i in range(5)]
        self.assertGreater(cells[0], 0)
        self.assertEqual(cells[1:], [0] * 4)
        run.RemoveObserver(observer)
        run.Modified()
        run.Update()
        self.assertEqual(run.GetErrorCode(), 0)
        self.assertEqual(run.GetOutputDataObject(0).GetBlock(3).GetNumberOfCells(), cells[0])

    def test_no_filter_waits_for_another_one(self):
        """One's observer lets go of Python's lock, which the other one holds while it runs."""
        script = """if True:
            import sys, threading, time
            from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
            import vtktetfusion
            def read():
                reader = vtkXMLUnstructuredGridReader()
                reader.SetFileName(sys.argv[1])
                reader.Update()
                return reader.GetOutput()
            def made(reduction):
                run = vtktetfusion.vtkTetFusion()
                run.SetInputData(read())
                run.SetTargetReduction(reduction)
                return run
            watched, other, third = made(0.8), made(0.7), made(0.6)
            watched.AddObserver("ProgressEvent", lambda caller, event: time.sleep(0.01))
            grid = read()
            works = [watched.Update, other.Update, third.Update,
                     lambda: vtktetfusion.simplify(grid, 0.8, progress=lambda share: time.sleep(0.01))]
            threads = [threading.Thread(target=work) for work in works]
            for thread in threads:
                thread.start()
                time.sleep(0.05)
            for thread in threads:
                thread.join()
            for run in watched, other, third:
                assert run.GetErrorCode() == 0 and run.GetOutput().GetNumberOfCells() > 0
        """
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "five.vtu"
            command("generate", "five", "--tets", "60k", "-o", path)
            subprocess.run([sys.executable, "-c", script, path], check=True, timeout=120, capture_output=True,
                           env=os.environ | {"PYTHONPATH": str(PACKAGES)})


class Function(FilterTest):
    def test_takes_and_returns_what_stands_for_grids(self):
        grid = box(5)
        wrapped = vtktetfusion.simplify(dataset_adapter.WrapDataObject(grid), reduction=0.5)
        self.assertIsInstance(wrapped, dataset_adapter.UnstructuredGrid)
        self.assertEqual(wrapped.PointData["wave"].shape, (wrapped.GetNumberOfPoints(),))
        self.expect_same(wrapped.VTKObject, vtktetfusion.simplify(grid, reduction=0.5))

    def test_grids_of_pyvista_come_back_as_such(self):
        class Grid(vtkUnstructuredGrid):
            pass
        Grid.__module__ = "pyvista.core.pointset"
        wrapped = []
        sys.modules["pyvista"] = types.SimpleNamespace(wrap=lambda grid: wrapped.append(grid) or "wrapped")
        self.addCleanup(sys.modules.pop, "pyvista")
        grid = Grid()
        grid.ShallowCopy(box(6))
        self.assertEqual(vtktetfusion.simplify(grid, 0.4), "wrapped")
        self.assertLess(wrapped[0].GetNumberOfCells(), grid.GetNumberOfCells())

    def test_progress(self):
        shares = []
        vtktetfusion.simplify(box(6), 0.5, progress=shares.append)
        self.assertEqual(shares, sorted(shares))
        with self.assertRaises(TetFusionError) as caught:
            vtktetfusion.simplify(box(20), 0.9, progress=lambda share: False)
        self.assertEqual(caught.exception.code, 130)
        with self.assertRaises(TetFusionError) as caught:
            vtktetfusion.simplify(box(20), 0.9, progress=lambda share: np.bool_(False))
        self.assertEqual(caught.exception.code, 130)
        with self.assertRaises(ZeroDivisionError):
            vtktetfusion.simplify(box(20), 0.9, progress=lambda share: 1 / 0)

    def test_several_threads_of_python(self):
        """One waits for the other, which its progress keeps busy with other threads of Python."""
        results = []
        first = threading.Thread(target=lambda: results.append(
            vtktetfusion.simplify(box(20), 0.9, progress=lambda share: time.sleep(0.005))))
        first.start()
        time.sleep(0.05)
        results.append(vtktetfusion.simplify(box(8), 0.5))
        first.join(120)
        self.assertFalse(first.is_alive())
        self.assertEqual(len(results), 2)

    def test_an_interrupt_ends_the_run(self):
        """Ctrl-C comes at the first report; nobody asked for reports."""
        shares = []

        def interrupt(caller, event):
            shares.append(caller.GetProgress())
            if len(shares) == 1:
                os.kill(os.getpid(), signal.SIGINT)

        def made():
            run = vtkTetFusion()
            run.AddObserver("ProgressEvent", interrupt)
            return run

        with unittest.mock.patch.object(vtktetfusion, "vtkTetFusion", made), self.assertRaises(KeyboardInterrupt):
            vtktetfusion.simplify(box(40), 0.9)
        self.assertLess(shares[-1], 1)
        self.assertIs(signal.getsignal(signal.SIGINT), signal.default_int_handler)

    def test_progress_cannot_simplify(self):
        with self.assertRaises(TetFusionError) as caught:
            vtktetfusion.simplify(box(8), 0.5, progress=lambda share: vtktetfusion.simplify(box(4), 0.5))
        self.assertEqual(caught.exception.code, 2)
        vtktetfusion.simplify(box(4), 0.5)

    def test_bad_arguments(self):
        grid = box(2)
        for arguments, part in (({"reduction": 2}, "reduction must be at least 0%"),
                                ({"method": "magic"}, "method must be one of fuse, tetfuse"),
                                ({"boundary": "soft"}, "boundary must be one of exact, planar"),
                                ({"boundary": 0.0}, "boundary must be a share of the diagonal"),
                                ({"arrays": "nothing"}, 'no array "nothing" to steer by'),
                                ({"arrays": {"wave": -1}}, "must be greater than 0"),
                                ({"arrays": {"wave": 1.5}}, 'arrays: the tolerance of "wave" is 1.5: it must be greater than 0 and at most 1'),
                                ({"regions": ["wave"]}, "no cell array of numbers of one component"),
                                ({"reduction": 0.5, "tets": 3}, "two goals"),
                                ({"reduction": 0, "tets": 3}, "two goals"),
                                ({"tets": 0}, "tets must be at least 1"),
                                ({"max_error": 0}, "max_error must be greater than 0"),
                                ({"max_error": np.float64(0), "reduction": 0.5}, "max_error must be greater than 0"),
                                ({"max_rms": 0}, "max_rms must be greater than 0"),
                                ({"scalar_tolerance": 0}, "scalar_tolerance must be greater than 0"),
                                ({"stretch_factor": 0}, "stretch_factor must be at least 1"),
                                ({"aspect_ratio": 0}, "aspect_ratio must be at least 1"),
                                ({"max_volume": 0}, "max_volume must be greater than 0"),
                                ({"memory": -1}, "memory must be at least 0"),
                                ({"threads": -1}, "threads must be at least 0"),
                                ({"threads": "two"}, "threads cannot be 'two'"),
                                ({"tets": 1e30}, "tets cannot be 1e+30"),
                                ({"reduction": "half"}, "reduction cannot be 'half'"),
                                ({"reduction": "x%"}, "reduction cannot be 'x%': give a share"),
                                ({"memory": "much"}, "memory cannot be 'much'"),
                                ({"boundary": 0.5}, "boundary cannot be 0.5, which is 50 % of the diagonal: give '0.5%' or '50%'"),
                                ({"boundary": "0.1"}, "boundary cannot be '0.1', which is 10 % of the diagonal: give '0.1%' or '10%'"),
                                ({"boundary": []}, "boundary must be one of exact, planar"),
                                ({"arrays": {"wave": "1"}}, "arrays: the bound of wave cannot be '1': give '100%' or '1%'"),
                                ({"arrays": {"wave": "x"}}, "arrays: the bound of wave cannot be 'x': give a share"),
                                ({"arrays": {"wave": [1]}}, "arrays: the bound of wave cannot be [1]"),
                                ({"chunk_tets": None, "max_volume": [1]}, "max_volume cannot be [1]"),
                                ({"arrays": [("wave", 0.01)]}, "arrays: give a name, a list of names, or {'f': 0.01}"),
                                ({"arrays": ("wave", 0.01)}, "arrays: give a name, a list of names, or"),
                                ({"arrays": 1}, "arrays: give a name, a list of names, or"),
                                ({"arrays": {1: 0.01}}, "arrays: give a name, a list of names, or"),
                                ({"regions": False}, "regions: give a name, a list of names, or 'none', not False"),
                                ({"roi": 1}, "roi: give a text, or a list of them"),
                                ({"method": []}, "method must be one of fuse, tetfuse, not []"),
                                ({"progress": 1}, "progress: give a function that takes a share, not 1"),
                                ({"strict": "no"}, "strict cannot be 'no': give True or False"),
                                ({"drop_patches": 2}, "drop_patches cannot be 2: give True or False"),
                                ({"max_error": "1"}, "max_error cannot be '1': give '100%' or '1%'"),
                                ({"tets": 10.5}, "tets cannot be 10.5"),
                                ({"tets": "10.5"}, "tets cannot be '10.5': give a whole number"),
                                ({"memory": 1.5}, "memory cannot be 1.5"),
                                ({"memory": "2GB"}, "memory cannot be '2GB': give bytes, or a text"),
                                ({"memory": "0"}, "memory cannot be '0'"),
                                ({"scratch": 5}, "scratch cannot be 5"),
                                ({"weight": 5}, "weight cannot be 5"),
                                ({"min_quality": 0.3, "method": "tetfuse"}, "min_quality belongs to method fuse")):
            with self.subTest(arguments=arguments), self.assertRaises(TetFusionError) as caught:
                vtktetfusion.simplify(grid, **arguments)
            self.assertEqual(caught.exception.code, 2)
            self.assertIn(part, str(caught.exception))
            self.assertNotIn("vtkTetFusion", str(caught.exception))

    def test_what_is_worth_knowing_is_said(self):
        blocks = vtkMultiBlockDataSet()
        for i in range(2):
            blocks.SetBlock(i, box(3 + i))
        with self.assertLogs("vtktetfusion", "INFO") as said, self.assertWarns(TetFusionWarning) as warned:
            vtktetfusion.simplify(blocks, 0.99)
        self.assertEqual(sum("array wave steers" in line for line in said.output), 2, said.output)
        self.assertEqual(warned.filename, __file__)
        self.assertEqual(["The goal was not reached: " in str(w.message) for w in warned.warnings], [True, True])
        with self.assertRaises(TetFusionError) as caught:
            vtktetfusion.simplify(box(3), 0.99, strict=True)
        self.assertEqual(caught.exception.code, 6)

    def test_errors_pass_between_processes(self):
        error = pickle.loads(pickle.dumps(TetFusionError(3, "why")))
        self.assertIsInstance(error, TetFusionError)
        self.assertEqual((error.code, str(error)), (3, "why"))

    def test_texts_are_what_the_command_takes(self):
        grid = box(5)
        texts = {"reduction": "30%", "max_error": "5%", "boundary": "1%", "memory": "1.5G", "arrays": {"wave": "2%"}}
        same = {"reduction": 0.3, "max_error": 0.05, "boundary": 0.01, "memory": 3 << 29, "arrays": {"wave": 0.02}}
        self.expect_same(vtktetfusion.simplify(grid, **texts), vtktetfusion.simplify(grid, **same))
        self.expect_same(vtktetfusion.simplify(grid, 0.3, boundary="50%"), vtktetfusion.simplify(grid, 0.3, boundary="50.0%"))
        texts = {"tets": "0.4k", "max_error": "0.05", "boundary": "0.01", "memory": "2g", "arrays": {"wave": ".02"}, "chunk_tets": "1k"}
        same = {"tets": 400, "max_error": 0.05, "boundary": 0.01, "memory": 2 << 30, "arrays": {"wave": 0.02}, "chunk_tets": 1000}
        self.expect_same(vtktetfusion.simplify(grid, **texts), vtktetfusion.simplify(grid, **same))

    def test_numbers_and_folders_of_other_types(self):
        grid = box(5)
        with tempfile.TemporaryDirectory() as folder:
            out = vtktetfusion.simplify(grid, tets=400.0, threads=2.0, memory=np.float64(2 ** 31), chunk_tets=1e3, strict=np.bool_(False),
                                        conserve=0, arrays=types.MappingProxyType({"wave": 0.02}), scratch=pathlib.Path(folder))
        self.expect_same(out, vtktetfusion.simplify(grid, tets=400, chunk_tets=1000, arrays={"wave": 0.02}))

    def test_none_is_the_default(self):
        grid = box(5)
        options = inspect.signature(vtktetfusion.simplify).parameters
        self.assertEqual({option.default for name, option in options.items() if name != "grid"}, {None})
        nothing = dict.fromkeys(name for name in options if name != "grid")
        self.expect_same(vtktetfusion.simplify(grid, **nothing), vtktetfusion.simplify(grid))

    def test_what_is_no_grid_is_refused(self):
        for nothing in None, "mesh.vtu", [1, 2]:
            with self.assertRaises(TetFusionError) as caught:
                vtktetfusion.simplify(nothing, 0.5)
            self.assertIn(f"grid must be a vtkUnstructuredGrid, or what stands for one, not {type(nothing).__name__}", str(caught.exception))

    def test_a_reduction_of_nothing_leaves_the_mesh_as_it_is(self):
        grid = box(6)
        for nothing in 0, 0.0, -0.0, np.float32(0):
            self.assertEqual(vtktetfusion.simplify(grid, nothing).GetNumberOfCells(), grid.GetNumberOfCells())
        self.assertLess(vtktetfusion.simplify(grid, min_quality=0).GetNumberOfCells(), grid.GetNumberOfCells())
        blocks = vtkMultiBlockDataSet()
        blocks.SetBlock(0, grid)
        out = vtktetfusion.simplify(blocks, reduction=0)
        self.assertEqual(out.GetBlock(0).GetNumberOfCells(), grid.GetNumberOfCells())

    def test_other_data_are_refused(self):
        with self.assertRaises(TetFusionError) as caught:
            vtktetfusion.simplify(vtkPolyData(), 0.5)
        self.assertEqual(caught.exception.code, 3)

    def test_docstrings_come_from_the_header(self):
        self.assertIn("simplifies tetrahedral meshes", vtkTetFusion.__doc__)
        self.assertIn("share of the tetrahedra", vtkTetFusion.SetTargetReduction.__doc__)


if __name__ == "__main__":
    unittest.main(warnings="ignore")  # most goals are beyond what tiny meshes have
