#!/usr/bin/env python3
"""The function vtktetfusion.simplify(). Usage: as filter_support.py."""
import inspect
import os
import pathlib
import pickle
import signal
import sys
import tempfile
import threading
import time
import types
import unittest
import unittest.mock

import numpy as np
from vtkmodules.numpy_interface import dataset_adapter
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkPolyData, vtkUnstructuredGrid

from filter_support import FilterTest, TetFusionError, TetFusionWarning, box, numbers, vtkTetFusion, vtktetfusion


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

    def test_a_child_does_not_wait_for_threads_of_its_parent(self):
        # The child has the thread that forked alone.
        def in_child():
            pid = os.fork()
            if pid == 0:
                vtktetfusion.simplify(box(3), 0.5)
                os._exit(0)
            return pid

        pids = []

        def progress(share):
            if not pids:
                thread = threading.Thread(target=lambda: pids.append(in_child()))
                thread.start()
                thread.join()
            return True
        vtktetfusion.simplify(box(6), 0.5, progress=progress)
        for _ in range(300):
            done, status = os.waitpid(pids[0], os.WNOHANG)
            if done:
                break
            time.sleep(0.1)
        else:
            os.kill(pids[0], signal.SIGKILL)
            os.waitpid(pids[0], 0)
            self.fail("the child waits without end")
        self.assertEqual(status, 0)

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
        self.assertLess(max(share for share in shares if share < 1), 0.9)  # VTK since 9.3 adds a 1
        self.assertIs(signal.getsignal(signal.SIGINT), signal.default_int_handler)

    def test_what_handlers_raise_comes_through(self):
        class Timeout(Exception):
            pass

        def late(number, frame):
            raise Timeout
        self.addCleanup(signal.signal, signal.SIGALRM, signal.signal(signal.SIGALRM, late))
        grid = box(24)
        for progress in (lambda share: None, None):
            signal.setitimer(signal.ITIMER_REAL, 0.15)
            with self.assertRaises(Timeout):
                while True:
                    vtktetfusion.simplify(grid, 0.9, progress=progress)
            self.assertIs(signal.getsignal(signal.SIGALRM), late)

    def test_a_handler_that_raises_nothing_ends_nothing(self):
        came = []
        self.addCleanup(signal.signal, signal.SIGINT, signal.signal(signal.SIGINT, lambda number, frame: came.append(number)))
        sent = []
        result = vtktetfusion.simplify(box(16), 0.5, progress=lambda share: sent or sent.append(os.kill(os.getpid(), signal.SIGINT)) or True)
        self.assertEqual(came, [signal.SIGINT])
        self.assertGreater(result.GetNumberOfCells(), 0)

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
                                ({"tets": True}, "tets cannot be True: give a number"),
                                ({"max_error": True}, "max_error cannot be True: give a number"),
                                ({"stretch_factor": np.bool_(True)}, ": give a number"),
                                ({"threads": True}, "threads cannot be True: give a number"),
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
                                ({"feature_angle": 60}, "feature_angle is for a surface that may move"),
                                ({"feature_angle": "60", "boundary": "planar"}, "feature_angle cannot be '60'"),
                                ({"feature_angle": 0, "boundary": "planar"}, "feature_angle must be more than 0"),
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
