#!/usr/bin/env python3
"""The filter vtkTetFusion in VTK pipelines, beside the command. Usage: as filter_support.py; without the data folder the tests of
real meshes are skipped."""
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np
from vtkmodules.vtkCommonCore import vtkObject
from vtkmodules.vtkCommonDataModel import vtkDataObject, vtkMultiBlockDataSet, vtkPolyData, vtkUnstructuredGrid, VTK_TRIANGLE
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader, vtkXMLUnstructuredGridWriter

from filter_support import (DATA, PACKAGES, USER_ERROR, Errors, FilterTest, TetFusionError, TetFusionWarning, box, command, read,
                            vtkTetFusion, vtktetfusion)


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
        run.SetAbortExecute(0)  # which VTK did itself before 9.3
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
        output = run.GetOutputDataObject(0)
        cells = [output.GetBlock(i).GetNumberOfCells() for i in range(output.GetNumberOfBlocks())]  # none since VTK 9.3
        self.assertEqual(cells[2:], [0] * len(cells[2:]))
        # The second one may have been done when it was asked.
        self.assertTrue(not cells or (cells[0] > 0 and cells[1] in (0, cells[0])))
        run.RemoveObserver(observer)
        run.SetAbortExecute(0)  # which VTK did itself before 9.3
        run.Modified()
        run.Update()
        self.assertEqual(run.GetErrorCode(), 0)
        whole = [run.GetOutputDataObject(0).GetBlock(i).GetNumberOfCells() for i in (0, 3)]
        self.assertTrue(whole[0] == whole[1] > 0 and cells[:1] in ([], whole[:1]))

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
                           env=os.environ | {"PYTHONPATH": os.pathsep.join([str(PACKAGES), os.environ.get("PYTHONPATH", "")])})


if __name__ == "__main__":
    unittest.main(warnings="ignore")  # most goals are beyond what tiny meshes have
