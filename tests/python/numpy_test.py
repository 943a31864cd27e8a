#!/usr/bin/env python3
"""The Python package tetfusion. Usage: numpy_test.py TETFUSION PACKAGES [unittest's arguments], where PACKAGES holds it. What is about VTK
and meshio is skipped where these are not installed."""
import _thread
import dataclasses
import gc
import itertools
import logging
import math
import os
import pathlib
import pickle
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest
import weakref
from decimal import Decimal
from fractions import Fraction
from unittest import mock

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
COMMAND, PACKAGES = (pathlib.Path(sys.argv.pop(1)).resolve() for _ in range(2))
sys.path[:0] = [str(PACKAGES), str(HERE.parent / "support"), str(HERE.parent / "cli")]
from independent_check import Vtu  # noqa: E402
from tetfusion import Mesh, TetFusionError, TetFusionWarning, simplify  # noqa: E402

try:
    from vtkmodules.numpy_interface import dataset_adapter
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkPoints, vtkSOADataArrayTemplate, vtkStringArray
    from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkUnstructuredGrid
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
except ImportError:
    vtkUnstructuredGrid = None
try:
    import meshio
except ImportError:
    meshio = None


def command(*arguments):
    subprocess.run([COMMAND, *map(str, arguments)], check=True, capture_output=True, timeout=300)


def box(n, dtype=np.float64):
    """n^3 cubes in six tetrahedra each, with a wave and which half a cell lies in."""
    side = n + 1
    points = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1).reshape(-1, 3).astype(dtype)
    inside = np.all((points > 0) & (points < n), axis=1)
    points[inside] += 0.1 * np.sin(np.arange(3 * inside.sum()).reshape(-1, 3) * 12.9898)
    number = np.arange(side ** 3).reshape(side, side, side)
    tets = []
    for order in itertools.permutations(range(3)):
        low = np.zeros(3, int)
        corners = []
        for axis in (None, *order):
            if axis is not None:
                low[axis] = 1
            corners.append(number[low[0]:n + low[0], low[1]:n + low[1], low[2]:n + low[2]].ravel())
        tets.append(np.stack(corners, axis=1))
    tets = np.concatenate(tets)
    x, y, z = points.T
    return Mesh(points, tets, {"wave": np.sin(6 * x / n) * y + z}, {"material": (points[tets].mean(axis=1)[:, 0] > n / 2).astype(np.int32)})


class Command(unittest.TestCase):
    """A mesh in memory gives what its file gives, bit for bit."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_the_same_mesh(self):
        path = self.folder / "in.vtu"
        command("generate", "five", "--tets", "30k", "--jitter", "0.4", "-o", path)
        given = Vtu(path)
        numbers = {kind: {name: rows for name, (_, rows) in given.arrays[kind].items()} for kind in ("point", "cell")}
        mesh = Mesh(given.points, given.tets, numbers["point"], numbers["cell"])
        name = next(iter(mesh.point_data))
        for keywords, options in (
                ({"reduction": 0.8}, ["--reduction", "80%"]),
                ({"tets": "5k", "boundary": "planar", "threads": 1}, ["--tets", "5k", "--boundary", "planar"]),
                ({"max_error": "2%", "boundary": 0.005, "regions": "none"}, ["--max-error", "2%", "--boundary", "0.5%", "--regions", "none"]),
                ({"arrays": {name: 0.01}, "chunk_tets": 5000, "original_ids": True}, ["--array", f"{name}:1%", "--chunk-tets", "5000", "--original-ids"]),
                ({"method": "tetfuse", "scalar_tolerance": [0.01, 0.02], "aspect_ratio": math.inf, "roi": "sphere=0,0,0,0.3"},
                 ["--method", "tetfuse", "--scalar-tolerance", "0.01,0.02", "--aspect-ratio", "off", "--roi", "sphere=0,0,0,0.3"])):
            with self.subTest(options):
                smaller = simplify(mesh, **keywords)
                command("simplify", path, "-o", self.folder / "out.vtu", *options)
                out = Vtu(self.folder / "out.vtu")
                np.testing.assert_array_equal(smaller.points, out.points)
                np.testing.assert_array_equal(smaller.cells, out.tets)
                self.assertEqual(smaller.points.dtype, given.points.dtype)
                for kind, data in ("point", smaller.point_data), ("cell", smaller.cell_data):
                    self.assertEqual(list(data), list(out.arrays[kind]))
                    for array, rows in data.items():
                        np.testing.assert_array_equal(rows, out.arrays[kind][array][1].reshape(rows.shape))
                self.assertEqual(smaller.report["output"]["tets"], len(out.tets))


class Meshes(unittest.TestCase):
    def test_types_and_shapes_come_back(self):
        mesh = box(5)
        count = len(mesh.points)
        arrays = {"bool": np.arange(count) % 3 == 0, "big": np.arange(count).astype(">f4"), "strided": np.arange(2 * count)[::2],
                  "fortran": np.asfortranarray(np.arange(6.0 * count).reshape(count, 6)), "tensor": np.ones((count, 3, 3)),
                  "column": np.zeros((count, 1)), "list": list(range(count)), "naïve ": np.zeros(count)}
        arrays.update({name: np.arange(count).astype(name) for name in ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8")})
        for points, cells in itertools.product((np.float32, np.float64), (np.int32, np.int64, np.uint16)):
            given = Mesh(mesh.points.astype(points), mesh.cells.astype(cells), arrays, {"of cells": np.ones((len(mesh.cells), 2), bool)})
            smaller = simplify(given, 0.5, arrays="big", original_ids=True)
            ids = smaller.point_data["OriginalPointIds"]
            self.assertEqual((smaller.points.dtype, smaller.cells.dtype), (points, np.int64 if cells is np.uint16 else cells))
            for name, rows in arrays.items():
                out, rows = smaller.point_data[name], np.asarray(rows)
                self.assertEqual((out.dtype, out.shape[1:]), (rows.dtype.newbyteorder("="), rows.shape[1:]), name)
                np.testing.assert_array_equal(out[ids >= 0], rows[ids[ids >= 0]])
            self.assertEqual((smaller.cell_data["of cells"].dtype, smaller.cell_data["of cells"].shape),
                             (bool, (len(smaller.cells), 2)))

    def test_the_result_lives_by_itself(self):
        mesh = box(6)
        before = mesh.points.copy(), mesh.cells.copy()
        smaller = simplify(mesh, 0.5)
        wave, points = smaller.point_data["wave"], smaller.points.copy()
        np.testing.assert_array_equal(mesh.points, before[0])
        np.testing.assert_array_equal(mesh.cells, before[1])
        kept = wave.copy()
        del smaller, mesh
        gc.collect()
        junk = [np.full(len(kept), np.nan) for _ in range(100)]
        np.testing.assert_array_equal(wave, kept)
        wave[:] = 1
        self.assertEqual((len(junk), len(points)), (100, len(wave)))

    def test_other_cells(self):
        mesh = box(4)
        triangles = mesh.cells[:3, :3]
        flat = np.concatenate([triangles.ravel(), mesh.cells.ravel()])
        offsets = np.concatenate([np.arange(0, 9, 3), 9 + 4 * np.arange(len(mesh.cells) + 1)])
        kinds = np.array([5] * 3 + [10] * len(mesh.cells))
        patch = np.arange(len(kinds))
        smaller = simplify(Mesh(mesh.points, flat, mesh.point_data, {"id": patch}, offsets, kinds), 0.4)
        self.assertEqual(smaller.types.tolist()[-3:], [5, 5, 5])
        self.assertEqual(smaller.cell_data["id"].tolist()[-3:], [0, 1, 2])
        self.assertEqual(smaller.types.dtype, np.uint8)
        self.assertEqual((smaller.offsets[-1], len(smaller.offsets)), (len(smaller.cells), len(smaller.types) + 1))
        without = simplify(Mesh(mesh.points, flat, mesh.point_data, {"id": patch}, offsets, kinds), 0.4, drop_patches=True)
        self.assertEqual(set(without.types.tolist()), {10})
        whole = Mesh(mesh.points, flat, mesh.point_data, {"id": patch}, offsets, kinds)
        for patches, left in ("id=1", [0, 2]), (["id=0", "id=2"], [1]):
            some = simplify(whole, 0.4, drop_patch=patches)
            self.assertEqual(some.cell_data["id"][some.types == 5].tolist(), left)
        with self.assertRaisesRegex(TetFusionError, "drop_patch id=-1: no triangle"):
            simplify(whole, 0.4, drop_patch="id=-1")
        hexahedron = Mesh(np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float), np.arange(8),
                          {"f": np.arange(8.0)}, {}, np.array([0, 8]), np.array([12]))
        with self.assertRaises(TetFusionError) as caught:
            simplify(hexahedron, 0)
        self.assertIn("tetrahedralize", str(caught.exception))
        self.assertEqual(set(simplify(hexahedron, 0, tetrahedralize=True).types.tolist()), {10})

    def test_ghosts_are_left_out(self):
        mesh = box(4)
        marks = np.zeros(len(mesh.cells), int)
        marks[::7] = 1
        for name in "vtkGhostType", "vtkGhostLevels":
            left = simplify(Mesh(mesh.points, mesh.cells, {**mesh.point_data, name: np.ones(len(mesh.points))}, {name: marks}), 0)
            self.assertEqual(len(left.cells), (marks == 0).sum())
            self.assertEqual((list(left.point_data), left.cell_data), (["wave"], {}))

    def test_names_of_any_bytes(self):
        mesh = box(4)
        rows = np.arange(3.0 * len(mesh.points)).reshape(-1, 3)
        given = {b"vel": rows, b"caf\xe9": rows > 5, "caf\udce8": rows[:, 0], "\u6e29": rows}
        smaller = simplify(Mesh(mesh.points, mesh.cells, given, {}), 0.2, arrays="vel")
        self.assertEqual([(name, out.dtype, out.ndim) for name, out in smaller.point_data.items()],
                         [("vel", float, 2), ("caf\udce9", bool, 2), ("caf\udce8", float, 1), ("\u6e29", float, 2)])
        self.assertEqual(simplify(Mesh(mesh.points, mesh.cells), 0).point_data, {})
        self.assertEqual(simplify(Mesh(mesh.points, mesh.cells, None, None), 0).cell_data, {})

    def test_cells_may_be_whole_numbers_of_any_type(self):
        mesh = box(6)
        expected = simplify(mesh, 0.3).cells
        for kind in (np.float64, np.float32, np.uint16, np.uint64):
            np.testing.assert_array_equal(simplify(dataclasses.replace(mesh, cells=mesh.cells.astype(kind)), 0.3).cells, expected)

    def test_active_scalars_steer(self):
        mesh = box(6)
        mesh.point_data["other"] = mesh.points[:, 0] ** 2
        self.assertEqual(simplify(mesh, 0.3).report["steering"], ["wave"])
        self.assertIsNone(simplify(mesh, 0.3).active_scalars)
        mesh.active_scalars = "other"
        smaller = simplify(mesh, 0.3)
        self.assertEqual((smaller.report["steering"], smaller.active_scalars), (["other"], "other"))
        self.assertEqual(simplify(smaller, 0.2).report["steering"], ["other"])
        points = np.frombuffer(b"x" + mesh.points.tobytes(), dtype=mesh.points.dtype, offset=1).reshape(-1, 3)  # not aligned
        np.testing.assert_array_equal(simplify(dataclasses.replace(mesh, points=points), 0.3).points, smaller.points)

    def test_what_is_wrong_with_a_mesh_is_said(self):
        mesh = box(3)
        whole = {"points": mesh.points, "cells": mesh.cells}
        for wrong, said in ({"points": mesh.points[:, :2]}, "three columns"), ({"cells": mesh.cells[:, :3]}, "four columns"), \
                ({"cells": mesh.cells + 0.5}, "whole numbers"), ({"cells": mesh.cells + 1000}, "point"), \
                ({"point_data": {"f": np.ones(3)}}, "'f' must have 64 rows"), ({"cell_data": {"g": np.ones(64)}}, "'g' must have 162 rows"), \
                ({"point_data": {"f": np.ones(64, complex)}}, "complex128"), ({"point_data": {"f": ["a"] * 64}}, "are not taken"), \
                ({"point_data": {"f": np.ones((64, 0))}}, "no components"), ({"point_data": {1: np.ones(64)}}, "name of an array cannot be 1"), \
                ({"points": mesh.points.astype(np.float16)}, "float16"), ({"types": np.full(162, 10)}, "go together"), \
                ({"types": np.full(162, 10), "offsets": np.arange(3)}, "one more than types"), \
                ({"points": np.full((64, 3), np.nan)}, "finite"), ({"point_data": [1]}, "must be a dict"), ({"active_scalars": "g"}, "no point array 'g'"), \
                ({"point_data": {"f": np.ma.masked_less(np.arange(64.0), 3)}}, "masked"), ({"point_data": {"f": [[1], [1, 2]] * 32}}, "'f'"), \
                ({"point_data": {"a\0b": np.ones(64)}}, "cannot be"), ({"point_data": {"": np.ones(64)}}, "cannot be"), \
                ({"point_data": {"\ud800": np.ones(64)}}, "cannot be"), ({"point_data": {b"f": np.ones(64), "f": np.ones(64)}}, "cannot be"), \
                ({"types": np.full(162, 266), "offsets": 4 * np.arange(163)}, "types must be whole numbers that uint8 can hold"), \
                ({"types": np.full(162, 10.5), "offsets": 4 * np.arange(163)}, "types must be"), \
                ({"cells": np.full((162, 4), np.nan)}, "cells must be"), ({"cells": np.full((162, 4), 1e30)}, "cells must be"), \
                ({"types": np.full(162, 10), "offsets": 4 * np.arange(163) + 0.7}, "offsets must be"), \
                ({"types": ["a"] * 162, "offsets": 4 * np.arange(163)}, "types"), ({"cells": np.zeros((0, 4), int)}, "no tetrahedra"), \
                ({"cells": np.full((162, 4), 2**63, np.uint64)}, "cells must be"), \
                ({"cell_data": {"vtkGhostType": np.ones(3, int)}}, "vtkGhostType must have 162 rows"):
            with self.subTest(said), self.assertRaises(TetFusionError) as caught:
                simplify(Mesh(**{**whole, **wrong}), 0.5)
            self.assertEqual(caught.exception.code, 3)
            self.assertIn(said, str(caught.exception))


class Options(unittest.TestCase):
    def test_what_cannot_be_is_refused(self):
        mesh = box(3)
        for options, said in ({"reduction": 2}, "reduction"), ({"reduction": "x"}, "give a share"), ({"reduction": True}, "reduction"), \
                ({"reduction": math.nan}, "reduction"), ({"max_error": 0}, "max"), ({"tets": 1.5}, "tets must be a whole number"), \
                ({"tets": -1}, "tets must be"), ({"strict": "yes"}, "True or False"), ({"method": "both"}, "tetfuse"), \
                ({"boundary": 0.5}, "whichever is meant"), ({"boundary": "round"}, "boundary must be one of"), \
                ({"arrays": "none such"}, "none such"), ({"arrays": 3}, "arrays: give"), ({"arrays": {"wave": -1}}, "greater than 0"), \
                ({"regions": "none such"}, "none such"), ({"regions": [1]}, "regions: give"), ({"roi": "cube"}, "cube"), \
                ({"threads": -1}, "threads"), ({"memory": "much"}, "give bytes"), ({"scratch": 3}, "path of a folder"), \
                ({"weight": 1}, "weight cannot be 1"), ({"feature_angle": 60}, "for a surface that may move"), \
                ({"min_quality": "good"}, "min_quality must be a number"), \
                ({"progress": 1}, "give a function"), ({"stretch_factor": [2, "x"]}, "stretch_factor must be a number"), \
                ({"boundary": True}, "boundary must be one of"), ({"arrays": {"wave": True}}, "bound of wave"), \
                ({"arrays": {"wave": 10**400}}, "tolerance"), ({"aspect_ratio": [[1]]}, "aspect_ratio cannot be"), \
                ({"reduction": Decimal("0.5")}, "reduction cannot be"), ({"weight": "\ud800"}, "weight cannot be"), \
                ({"scratch": math.inf}, "path of a folder"), ({"arrays": b"\xe9"}, "no UTF-8"), ({"arrays": "a--max-error"}, '"a--max-error"'), \
                ({"boundary_tets_stay": True}, "belongs to method tetfuse"), ({"reduction": 0.5, "tets": 3}, "tets"):
            with self.subTest(options), self.assertRaises(TetFusionError) as caught:
                simplify(mesh, **options)
            self.assertEqual(caught.exception.code, 2, caught.exception)
            self.assertIn(said, str(caught.exception))
        with self.assertRaises(TetFusionError):
            simplify(mesh.points, 0.5)
        error = pickle.loads(pickle.dumps(TetFusionError(3, "x")))
        self.assertEqual((error.code, str(error)), (3, "x"))

    def test_numbers_of_all_kinds(self):
        mesh = box(5)
        expected = simplify(mesh, 0.25, regions="none").cells
        for half in np.array(0.25), np.float32(0.25), np.longdouble(0.25), Fraction(1, 4), "25%":
            np.testing.assert_array_equal(simplify(mesh, half, regions="none").cells, expected)
        tolerances = [simplify(mesh, 0.3, scalar_tolerance=given).cells for given in (["1%", "2%"], (0.01, 0.02), np.array([0.01, 0.02]))]
        np.testing.assert_array_equal(tolerances[0], tolerances[1])
        np.testing.assert_array_equal(tolerances[0], tolerances[2])

    def test_memory_and_scratch(self):
        mesh = box(24)
        whole = simplify(mesh, 0.7, chunk_tets=5000, threads=1)
        with self.assertRaises(TetFusionError) as caught:
            simplify(mesh, 0.7, chunk_tets=5000, threads=1, memory="68M")
        self.assertEqual(caught.exception.code, 5)
        with tempfile.TemporaryDirectory() as folder:
            on_disk = simplify(mesh, 0.7, chunk_tets=5000, threads=1, memory="68M", scratch=pathlib.Path(folder))
            self.assertEqual(os.listdir(folder), [])
        self.assertGreater(on_disk.report["scratch_bytes"], 0)
        np.testing.assert_array_equal(on_disk.cells, whole.cells)

    def test_a_goal_that_is_not_reached(self):
        mesh = box(3)
        with self.assertWarnsRegex(TetFusionWarning, "goal was not reached") as caught:
            simplify(mesh, 0.99)
        self.assertEqual(caught.filename, __file__)
        with self.assertRaises(TetFusionError) as caught:
            simplify(mesh, 0.99, strict=True)
        self.assertEqual(caught.exception.code, 6)

    def test_notices_go_to_the_logger(self):
        mesh = box(5)
        mesh.point_data["more"] = np.arange(len(mesh.points)) ** 2.0
        with self.assertLogs("tetfusion", "INFO") as logs:
            simplify(mesh, 0.5)
        self.assertTrue(any("more" in line for line in logs.output), logs.output)


class Runs(unittest.TestCase):
    def test_progress(self):
        shares = []
        simplify(box(6), 0.5, progress=shares.append)
        self.assertEqual((shares, shares[-1]), (sorted(shares), 1))
        for answer in False, np.bool_(False), 0:
            with self.assertRaises(TetFusionError) as caught:
                simplify(box(20), 0.9, progress=lambda share, answer=answer: answer)
            self.assertEqual(caught.exception.code, 130)
        with self.assertRaises(ZeroDivisionError):
            simplify(box(20), 0.9, progress=lambda share: 1 / 0)
        inner = []
        outer = simplify(box(6), 0.5, progress=lambda share: inner.append(simplify(box(6), 0.5)))
        self.assertGreater(len(inner), 0)
        np.testing.assert_array_equal(inner[0].cells, outer.cells)

    def test_several_threads_of_python(self):
        mesh = box(14)
        whole = simplify(mesh, 0.7)
        results, counts = [], []
        threads = [threading.Thread(target=lambda: results.append(simplify(mesh, 0.7, threads=1))) for _ in range(4)]
        for thread in threads:
            thread.start()
        while any(thread.is_alive() for thread in threads):
            counts.append(1)
        self.assertGreater(len(counts), 10)
        self.assertEqual(len(results), 4)
        for result in results:
            np.testing.assert_array_equal(result.cells, whole.cells)
            np.testing.assert_array_equal(result.point_data["wave"], whole.point_data["wave"])

    def test_exceptions_of_others_come_through(self):
        class Timeout(Exception):
            pass

        def late(number, frame):
            raise Timeout
        self.addCleanup(signal.signal, signal.SIGALRM, signal.signal(signal.SIGALRM, late))
        for progress in (lambda share: None, None):
            signal.setitimer(signal.ITIMER_REAL, 0.15)
            with self.assertRaises(Timeout):
                while True:
                    simplify(box(24), 0.9, progress=progress)
        logger = logging.getLogger("tetfusion")
        mesh = box(20)
        mesh.point_data["more"] = mesh.points[:, 0] ** 2
        logger.addFilter(failing := (lambda record: 1 / 0))
        self.addCleanup(logger.removeFilter, failing)
        logger.setLevel(logging.INFO)
        with self.assertRaises(ZeroDivisionError):
            simplify(mesh, 0.9)

    def test_exceptions_when_all_is_done(self):
        """Whenever they come, the next run works."""
        def late(number, frame):
            raise TimeoutError
        self.addCleanup(signal.signal, signal.SIGALRM, signal.signal(signal.SIGALRM, late))
        self.addCleanup(signal.setitimer, signal.ITIMER_REAL, 0)
        mesh = box(2)
        begin = time.perf_counter()
        simplify(mesh, 0.1)
        once = time.perf_counter() - begin
        for i in range(600):
            try:
                signal.setitimer(signal.ITIMER_REAL, once * (0.5 + i % 100 / 80))
                simplify(mesh, 0.1)
                signal.setitimer(signal.ITIMER_REAL, 0)
            except TimeoutError:
                pass

    def test_exceptions_at_every_line(self):
        """As a signal's handler may raise them, be it in a module of Python's that was not made for it."""
        mesh, left, done = box(2), 0, 0

        def late(frame, event, argument):
            nonlocal left
            left -= event == "line"
            if left < 0:
                raise TimeoutError
            return late
        self.addCleanup(sys.settrace, sys.gettrace())
        while left <= 0:
            left = done = done + 1
            sys.settrace(late)
            try:
                simplify(mesh, 0.1)
            except TimeoutError:
                pass
            finally:
                sys.settrace(None)
        self.assertGreater(done, 100)

    def test_false_as_the_last_answer(self):
        for _ in range(40):
            with self.assertRaises(TetFusionError) as caught:
                simplify(box(1), 0, progress=lambda share: False)
            self.assertEqual(caught.exception.code, 130)

    def test_what_progress_raises_keeps_nothing_alive(self):
        class Rows(np.ndarray):
            pass
        mesh = box(5)
        mesh.point_data["rows"] = np.ones(2 * len(mesh.points))[::2].view(Rows)
        kept = weakref.ref(mesh.point_data["rows"])
        gc.disable()
        self.addCleanup(gc.enable)
        try:
            simplify(mesh, 0.5, progress=lambda share: 1 / 0)
        except ZeroDivisionError:
            pass
        del mesh
        self.assertIsNone(kept())

    def test_python_may_end_during_runs_of_daemons(self):
        script = (f"import sys; sys.path[:0] = [{str(PACKAGES)!r}, {str(HERE)!r}]; sys.argv = ['', '', {str(PACKAGES)!r}]\n"
                  "import threading, time, numpy_test\n"
                  "mesh, begun = numpy_test.box(40), threading.Event()\n"
                  "def work():\n"
                  "    while True: numpy_test.simplify(mesh, 0.9, progress=lambda share: begun.set())\n"
                  "for _ in range(2): threading.Thread(target=work, daemon=True).start()\n"
                  "begun.wait()\n"
                  "sys.exit(7)")
        ended = subprocess.run([sys.executable, "-c", script], capture_output=True, timeout=60)
        self.assertEqual((ended.returncode, ended.stderr), (7, b""))

    def test_where_the_library_is_looked_for(self):
        with tempfile.TemporaryDirectory() as folder:
            for below in ".", "lib/python3/other":
                package = pathlib.Path(folder) / below / "tetfusion"
                shutil.copytree(PACKAGES / "tetfusion", package)
                (pathlib.Path(folder) / "libtetfusion.so.0.1").write_bytes(b"")
                result = subprocess.run([sys.executable, "-c", "import tetfusion"], cwd=package.parent, capture_output=True,
                                        env={**os.environ, "LD_LIBRARY_PATH": ""})
                self.assertIn(b"libtetfusion.so.0.1: cannot open shared object file", result.stderr)
            link = pathlib.Path(folder) / "site-packages" / "tetfusion"
            link.parent.mkdir()
            link.symlink_to(PACKAGES / "tetfusion")
            subprocess.run([sys.executable, "-c", "import tetfusion"], cwd=link.parent, check=True)

    def test_ctrl_c(self):
        sent = []

        def send(share):
            if not sent:
                sent.append(os.kill(os.getpid(), signal.SIGINT))
        with self.assertRaises(KeyboardInterrupt):
            simplify(box(20), 0.9, progress=send)
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            while True:
                simplify(box(24), 0.9)

    def test_ctrl_c_while_the_thread_starts(self):
        """Before it has begun, and when it has: then nothing that the library reads may go."""
        start = _thread.start_new_thread
        for begins in (False, True):
            def interrupted(function, arguments):
                if begins:
                    start(function, arguments)
                raise KeyboardInterrupt
            began = _thread._count()
            with mock.patch.object(_thread, "start_new_thread", interrupted), self.assertRaises(KeyboardInterrupt):
                simplify(box(20), 0.9)
            self.assertEqual(simplify(box(4), 0.2).cells.shape[1], 4)
            while _thread._count() > began:  # a thread ends a little after its run
                time.sleep(0.01)

    def test_a_library_that_is_not_there(self):
        script = f"import sys; sys.path[:0] = [{str(PACKAGES)!r}]; import tetfusion"
        result = subprocess.run([sys.executable, "-c", script], env={**os.environ, "TETFUSION_LIBRARY": "/none.so"}, capture_output=True)
        self.assertIn(b"ImportError: /none.so", result.stderr)
        self.assertIn(b"TETFUSION_LIBRARY", result.stderr)

    def test_no_vtk_is_needed(self):
        script = (f"import sys; sys.path[:0] = [{str(PACKAGES)!r}]; import tetfusion, numpy as np\n"
                  "mesh = tetfusion.Mesh(np.eye(4, 3), np.array([[3, 0, 1, 2]]), {'f': np.arange(4.0)})\n"
                  "assert len(tetfusion.simplify(mesh, 0).cells) == 1\n"
                  "assert not [name for name in sys.modules if name.startswith(('vtk', 'meshio'))]")
        subprocess.run([sys.executable, "-c", script], check=True)


@unittest.skipIf(vtkUnstructuredGrid is None, "VTK for Python is not installed")
class Grids(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = pathlib.Path(folder.name) / "in.vtu"
        command("generate", "kuhn", "--tets", "3k", "--jitter", "0.3", "--time", "2.5", "-o", path)
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(path))
        reader.Update()
        self.grid = reader.GetOutput()

    def test_grids_come_back_as_grids(self):
        texts = vtkStringArray()
        texts.SetName("texts")
        texts.SetNumberOfValues(self.grid.GetNumberOfPoints())
        names = [self.grid.GetPointData().GetArrayName(i) for i in range(self.grid.GetPointData().GetNumberOfArrays())]
        vectors = next(name for name in names if self.grid.GetPointData().GetArray(name).GetNumberOfComponents() == 3)
        self.grid.GetPointData().SetActiveVectors(vectors)
        self.grid.GetPointData().AddArray(texts)
        with self.assertWarnsRegex(TetFusionWarning, "'texts' is left out"):
            smaller = simplify(self.grid, 0.3, regions="none")
        self.assertIsInstance(smaller, vtkUnstructuredGrid)
        self.assertLess(smaller.GetNumberOfCells(), 0.71 * self.grid.GetNumberOfCells())
        self.assertEqual([smaller.GetPointData().GetArrayName(i) for i in range(smaller.GetPointData().GetNumberOfArrays())], names)
        self.assertEqual(smaller.GetPointData().GetVectors().GetName(), vectors)
        self.assertEqual(smaller.GetPointData().GetArray(vectors).GetComponentName(1),
                         self.grid.GetPointData().GetArray(vectors).GetComponentName(1))
        self.assertEqual(smaller.GetFieldData().GetArray("TimeValue").GetValue(0), 2.5)
        for name in names:
            self.assertEqual(smaller.GetPointData().GetArray(name).GetDataType(), self.grid.GetPointData().GetArray(name).GetDataType())

    def test_memory_that_is_laid_out_otherwise(self):
        ids = vtkSOADataArrayTemplate["int64"]()
        ids.SetName("ids")
        ids.SetNumberOfComponents(2)
        ids.SetNumberOfTuples(self.grid.GetNumberOfPoints())
        for i in range(self.grid.GetNumberOfPoints()):
            ids.SetTypedComponent(i, 0, 2**60 + i)
            ids.SetTypedComponent(i, 1, -i)
        self.grid.GetPointData().AddArray(ids)
        self.grid.GetCells().ConvertTo32BitStorage()
        smaller = simplify(self.grid, 0.2, original_ids=True, regions="none")
        values = vtk_to_numpy(smaller.GetPointData().GetArray("ids"))
        stayed = vtk_to_numpy(smaller.GetPointData().GetArray("OriginalPointIds"))
        self.assertGreater((stayed >= 0).sum(), 100)
        np.testing.assert_array_equal(values[stayed >= 0], np.stack([2**60 + stayed, -stayed], axis=1)[stayed >= 0])

    def test_names_that_are_no_utf8(self):
        rows = numpy_to_vtk(np.arange(3.0 * self.grid.GetNumberOfPoints()).reshape(-1, 3), deep=1)
        rows.SetName(b"Temp\xe9rature")
        self.grid.GetPointData().SetVectors(rows)
        smaller = simplify(self.grid, 0.2, regions="none")
        self.assertEqual(smaller.GetPointData().GetVectors().GetName(), b"Temp\xe9rature")
        self.assertEqual(smaller.GetPointData().GetVectors().GetNumberOfComponents(), 3)

    def test_like_the_filter(self):
        try:
            import vtktetfusion
        except ImportError as error:
            self.skipTest(f"no filter for this VTK: {error}")
        ghosts = np.zeros(self.grid.GetNumberOfCells(), np.uint8)
        ghosts[::50] = 1
        marks = numpy_to_vtk(ghosts, deep=1)
        marks.SetName("vtkGhostType")
        self.grid.GetCellData().AddArray(marks)
        ours, filtered = simplify(self.grid, 0.5), vtktetfusion.simplify(self.grid, 0.5)
        self.assertEqual(ours.GetPointData().GetNumberOfArrays(), filtered.GetPointData().GetNumberOfArrays())
        self.assertEqual(ours.GetCellData().GetNumberOfArrays(), filtered.GetCellData().GetNumberOfArrays())
        for take in (lambda grid: grid.GetPoints().GetData(), lambda grid: grid.GetCells().GetConnectivityArray(),
                     lambda grid: grid.GetPointData().GetArray(0)):
            np.testing.assert_array_equal(vtk_to_numpy(take(ours)), vtk_to_numpy(take(filtered)))

    def test_what_stands_for_grids(self):
        wrapped = simplify(dataset_adapter.WrapDataObject(self.grid), 0.5)
        self.assertIsInstance(wrapped, dataset_adapter.UnstructuredGrid)

        class Grid(vtkUnstructuredGrid):
            pass
        Grid.__module__ = "pyvista.core.pointset"
        sys.modules["pyvista"] = types.SimpleNamespace(wrap=lambda grid: ("wrapped", grid.GetNumberOfCells()))
        self.addCleanup(sys.modules.pop, "pyvista")
        grid = Grid()
        grid.ShallowCopy(self.grid)
        self.assertEqual(simplify(grid, 0.5), ("wrapped", wrapped.GetNumberOfCells()))
        for wrong, code in (vtkPolyData(), 2), (vtkUnstructuredGrid, 2), (vtkUnstructuredGrid(), 3):
            with self.assertRaises(TetFusionError) as caught:
                simplify(wrong, 0.5)
            self.assertEqual(caught.exception.code, code)

    def test_ids_of_cells_that_were_split(self):
        """They are several cells' then."""
        points, cell = vtkPoints(), (0, 1, 3, 2, 4, 5, 7, 6)
        for i in range(8):
            points.InsertNextPoint(i & 1, i >> 1 & 1, i >> 2)
        for split in False, True:
            grid = vtkUnstructuredGrid()
            grid.SetPoints(points)
            grid.InsertNextCell(12, 8, cell) if split else grid.InsertNextCell(10, 4, (0, 1, 2, 4))
            ids = numpy_to_vtk(np.array([7]), deep=1)
            ids.SetName("ids")
            grid.GetCellData().SetGlobalIds(ids)
            data = simplify(grid, 0, tetrahedralize=True).GetCellData()
            self.assertEqual((data.GetGlobalIds() is None, data.GetPedigreeIds() is not None), (split, split))


class StandIn:
    """What meshio's meshes are to the package, where meshio is not installed."""

    def __init__(self, points, cells, point_data=None, cell_data=None, field_data=None, cell_sets=None):
        self.points, self.point_data, self.cell_data, self.field_data = points, point_data or {}, cell_data or {}, field_data or {}
        self.cells = [types.SimpleNamespace(type=kind, data=np.asarray(rows)) for kind, rows in cells]
        self.cell_sets = cell_sets or {}


StandIn.__module__ = "meshio._mesh"


class Meshio(unittest.TestCase):
    def test_blocks(self):
        for kind in filter(None, [StandIn, meshio and meshio.Mesh]):
            mesh = box(5)
            half = len(mesh.cells) // 2
            cells = [("triangle", mesh.cells[:4, :3]), ("tetra", mesh.cells[:half]), ("tetra", mesh.cells[half:])]
            parts = [np.zeros(4, int), mesh.cell_data["material"][:half] + 1, mesh.cell_data["material"][half:] + 1]
            given = kind(mesh.points, cells, point_data=mesh.point_data, cell_data={"gmsh:physical": parts}, field_data={"a": np.array([1, 3])})
            smaller = simplify(given, 0.2, regions="none")
            self.assertIsInstance(smaller, kind)
            self.assertEqual([block.type for block in smaller.cells], ["tetra", "triangle"])
            count = len(smaller.cells[0].data)
            self.assertLess(count, 0.81 * len(mesh.cells))
            self.assertEqual([len(part) for part in smaller.cell_data["gmsh:physical"]], [count, 4])
            self.assertEqual(set(np.unique(smaller.cell_data["gmsh:physical"][0])), {1, 2})
            self.assertEqual(list(smaller.point_data), ["wave"])
            self.assertEqual(smaller.field_data["a"].tolist(), [1, 3])
            with self.assertWarnsRegex(TetFusionWarning, "'picked' is left out") as caught:
                simplify(kind(mesh.points, cells + [("line", np.zeros((0, 2), int))], point_data=mesh.point_data,
                              cell_data={"gmsh:physical": parts + [np.zeros(0, int)]}, cell_sets={"picked": [np.array([0])] * 4}), 0.2)
            self.assertEqual(caught.filename, __file__)
            wedge = kind(np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (0, 1))], float), [("wedge", [[0, 1, 2, 3, 4, 5]])])
            self.assertEqual(len(simplify(wedge, 0, tetrahedralize=True).cells[0].data), 3)

            class Own(kind):
                pass
            self.assertIsInstance(simplify(Own(mesh.points, cells, point_data=mesh.point_data), 0.2), Own)
            with self.assertRaisesRegex(TetFusionError, "blocks are not alike"):
                simplify(StandIn(mesh.points, cells, cell_data={"v": [np.zeros(len(rows) if i else (len(rows), 2)) for i, (_, rows) in enumerate(cells)]}), 0.2)
            patches = [("tetra", mesh.cells), ("polygon", [[0, 1, 2, 3, 4]]), ("triangle10", [np.arange(10)])]
            self.assertEqual([block.type for block in simplify(StandIn(mesh.points, patches), 0, drop_patches=True).cells], ["tetra"])
            with self.assertRaisesRegex(TetFusionError, "polygon5"):
                simplify(StandIn(mesh.points, [("polygon5", mesh.cells[:, [0, 1, 2, 3, 0]])]), 0.5)


if __name__ == "__main__":
    unittest.main(warnings="ignore")
