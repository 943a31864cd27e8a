#!/usr/bin/env python3
"""What the filter vtkTetFusion takes: arrays, cells and blocks of all kinds. Usage: as filter_support.py."""
import unittest
import warnings

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import (vtkBitArray, vtkDoubleArray, vtkFloatArray, vtkPoints, vtkSOADataArrayTemplate,
                                      vtkStringArray)
from vtkmodules.vtkCommonDataModel import (vtkCellArray, vtkCompositeDataSet, vtkDataObject, vtkImageData, vtkMultiBlockDataSet,
                                           vtkMultiPieceDataSet, vtkPartitionedDataSet, vtkPartitionedDataSetCollection,
                                           vtkPolyData, vtkTable, vtkUnstructuredGrid, VTK_HEXAHEDRON, VTK_POLYGON,
                                           VTK_POLY_LINE, VTK_TETRA, VTK_TRIANGLE)
from vtkmodules.vtkCommonExecutionModel import vtkTrivialProducer

from filter_support import (USER_ERROR, Errors, FilterTest, TetFusionError, add, box, numbers, set_cells, vtkTetFusion,
                            vtktetfusion)


class Arrays(FilterTest):
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
        self.assertEqual([data.GetArray(i).GetDataTypeAsString() for i in range(5)], ["float", "double", "int", "float", "bit"])
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

    def test_arrays_without_memory(self):
        """As of vtkAngularPeriodicFilter, whose points are turned when somebody asks for them."""
        blocks = vtkMultiBlockDataSet()
        blocks.SetBlock(0, box(4))
        try:
            from vtkmodules.vtkFiltersParallel import vtkAngularPeriodicFilter
        except ImportError:
            self.skipTest("this VTK is without such a filter")
        turn = vtkAngularPeriodicFilter()
        turn.SetInputDataObject(blocks)
        turn.AddIndex(1)
        turn.SetIterationModeToMax()
        turn.SetRotationModeToDirectAngle()
        turn.SetRotationAngle(45)
        turn.SetRotationAxisToZ()
        turn.Update()
        turned = turn.GetOutput().GetBlock(0).GetPartition(1)
        self.assertFalse(turned.GetPoints().GetData().HasStandardMemoryLayout())
        whole = vtkUnstructuredGrid()
        whole.DeepCopy(turned)
        self.expect_same(vtktetfusion.simplify(turned, 0.5), vtktetfusion.simplify(whole, 0.5))

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

    def test_arrays_without_names_take_none_of_others(self):
        grid = box(5)
        nameless = numpy_to_vtk(np.zeros(grid.GetNumberOfPoints()), deep=1)
        points = grid.GetPointData()
        wave = points.GetArray("wave")
        points.Initialize()
        points.AddArray(nameless)
        wave.SetName("array_0")
        points.AddArray(wave)
        run = self.run_on(grid, TargetReduction=0.5)
        run.AddSteeringPointArray("array_0")
        run.Update()
        self.assertIn('"array_0"', run.GetReport())
        other = self.run_on(grid, TargetReduction=0.5)
        other.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_POINTS, "array_0")
        other.Update()
        self.expect_same(run.GetOutput(), other.GetOutput())

    def test_names_that_are_not_utf8(self):
        grid = box(5)
        wave = grid.GetPointData().GetArray("wave")
        wave.SetName(b"h\xf6he")
        texts = vtkStringArray()
        texts.SetName(b"W\xf6rter")
        texts.SetNumberOfValues(grid.GetNumberOfPoints())
        grid.GetPointData().AddArray(texts)
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            for name in b"h\xf6he", "h\udcf6he":
                out = vtktetfusion.simplify(grid, 0.5, arrays=name)
        self.assertIn("W\\xf6rter", str(said[0].message))
        self.assertLess(out.GetNumberOfCells(), grid.GetNumberOfCells())
        with self.assertRaisesRegex(TetFusionError, r"h\\xf6he"):
            vtktetfusion.simplify(grid, 0.5, arrays="nothing")

    def test_names_as_the_command_takes_them(self):
        grid = box(6)
        add(grid.GetCellData(), "material", np.arange(grid.GetNumberOfCells()) % 2, np.int32)
        self.expect_same(vtktetfusion.simplify(grid, 0.2, regions="cell:material"),
                         vtktetfusion.simplify(grid, 0.2, regions="material"))
        add(grid.GetPointData(), "other", np.arange(grid.GetNumberOfPoints()), np.float32)
        floats = [name for name in ("wave", "velocity", "other") if grid.GetPointData().HasArray(name)]
        self.expect_same(vtktetfusion.simplify(grid, 0.5, regions=[], arrays="all"),
                         vtktetfusion.simplify(grid, 0.5, regions=[], arrays=floats))

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


class Cells(FilterTest):
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

    def test_ghost_marks_of_other_types_and_programs_are_obeyed(self):
        n = 6
        grid = box(n)
        high = numbers(grid)["points"][numbers(grid)["connectivity"].reshape(-1, 4)][:, :, 2].mean(axis=1) > n - 1.5
        add(grid.GetCellData(), "vtkGhostType", high, np.uint8)
        expected = vtktetfusion.simplify(grid, 0.5, regions=[])
        for name, kind in ("vtkGhostType", np.int64), ("vtkGhostLevels", np.uint8), ("vtkGhostLevels", np.int32):
            marked = box(n)
            add(marked.GetCellData(), name, 3 * high if name == "vtkGhostLevels" else high, kind)
            self.expect_same(vtktetfusion.simplify(marked, 0.5, regions=[]), expected)

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
        triangles = vtkUnstructuredGrid()
        triangles.SetPoints(volume.GetPoints())
        for tet in ids.tolist():
            triangles.InsertNextCell(VTK_TETRA, 4, tet)
        for _ in range(3):
            triangles.InsertNextCell(VTK_TRIANGLE, 3, [50, 51, 57])
        add(triangles.GetPointData(), "wave", numbers(volume)["point wave"], np.float32)
        add(triangles.GetCellData(), "patch", np.array([3] * len(ids) + [3, 4, 3]), np.int32)
        for patches, left in ("patch=3", 1), (["patch=3", "patch=4"], 0), ((), 3):
            out = vtktetfusion.simplify(triangles, 0.5, regions=[], drop_patch=patches)
            self.assertEqual((numbers(out)["types"] == VTK_TRIANGLE).sum(), left)
        run = self.run_on(triangles, TargetReduction=0.5)
        run.AddDroppedPatch("patch=3")
        self.assertEqual(run.GetNumberOfDroppedPatches(), 1)
        self.assertIn("DroppedPatches: patch=3", str(run))
        run.RemoveAllDroppedPatches()
        self.assertEqual(run.GetNumberOfDroppedPatches(), 0)
        out = vtktetfusion.simplify(mixed, 0.5, drop_patches=True)
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


class Blocks(FilterTest):
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
        points_alone = vtkUnstructuredGrid()
        points_alone.SetPoints(volume.GetPoints())
        for number, block in enumerate((points_alone, vtkPolyData(), vtkImageData())):
            blocks.SetBlock(3 + number, block)
        out = vtktetfusion.simplify(blocks, 0.5)
        self.assertEqual([out.GetBlock(3 + i).GetNumberOfPoints() for i in range(3)], [volume.GetNumberOfPoints(), 0, 0])
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

    def test_an_input_of_a_wrong_type_leaves_no_result(self):
        """Nor that of the input before."""
        given = vtktetfusion.vtkTetFusion()
        given.AddObserver("ErrorEvent", lambda *_: None)
        for one, cells in (box(3), True), (vtkImageData(), False), (box(3), True):
            given.SetInputDataObject(one)
            given.Update()
            self.assertEqual(given.GetOutput().GetNumberOfCells() > 0, cells)
            self.assertEqual(given.GetErrorCode() == 0, cells)

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


if __name__ == "__main__":
    unittest.main(warnings="ignore")  # most goals are beyond what tiny meshes have
