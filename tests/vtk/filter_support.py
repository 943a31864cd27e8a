"""What the tests of the filter share: meshes, and what the command makes of them. Arguments: TETFUSION PACKAGES DATA_FOLDER
[unittest's arguments], where PACKAGES holds the Python package vtktetfusion."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid, VTK_TETRA
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

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


def cell_types(grid):
    """By the name that it has in this VTK: another one since 9.6."""
    return grid.GetCellTypesArray() if hasattr(grid, "GetCellTypesArray") else grid.GetCellTypes()


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
           "connectivity": vtk_to_numpy(cells.GetConnectivityArray()), "types": vtk_to_numpy(cell_types(grid))}
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
