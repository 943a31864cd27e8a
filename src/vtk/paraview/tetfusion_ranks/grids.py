"""Grids with global ids of their points."""
import math

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkIdList, vtkIdTypeArray, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid

IDS = "GlobalNodeIds"


def cells_of(grid):
    return grid.GetNumberOfCells()


def types_of(grid):
    """VTK's type of each cell. Before VTK 9.6 GetCellTypes() was something else."""
    return grid.GetCellTypesArray() if hasattr(grid, "GetCellTypesArray") else grid.GetCellTypes()


def ids_of(grid):
    return vtk_to_numpy(grid.GetPointData().GetGlobalIds())


def diagonal(box):
    return math.dist(box[::2], box[1::2])


def whole_box(grid, ranks):
    own = grid.GetBounds() if cells_of(grid) else (math.inf, -math.inf) * 3
    rows = ranks.gather(own)
    return [f(rows[:, i]) for i, f in enumerate((min, max) * 3)]


def copy_rows(data, rows, out):
    """These rows of all arrays of `data`, in this order."""
    kept, places = vtkIdList(), vtkIdList()
    for place, row in enumerate(rows):
        kept.InsertNextId(int(row))
        places.InsertNextId(place)
    out.CopyAllOn()
    out.CopyAllocate(data, len(rows))
    out.CopyData(data, kept, places)


def join_by_ids(grid, anew=False):
    """The grid with one point for each global id that cells use; `anew`: a copy where it is that already."""
    if cells_of(grid) == 0:
        return grid
    used, corners = np.unique(vtk_to_numpy(grid.GetCells().GetConnectivityArray()), return_inverse=True)
    _, first, place = np.unique(ids_of(grid)[used], return_index=True, return_inverse=True)
    if first.size == grid.GetNumberOfPoints() and not anew:
        return grid
    first = used[first]
    out = vtkUnstructuredGrid()
    points = vtkPoints()
    points.SetData(numpy_to_vtk(vtk_to_numpy(grid.GetPoints().GetData())[first], deep=1))
    out.SetPoints(points)
    corners = place.ravel()[corners.ravel()].astype(np.int64)
    cells = vtkCellArray()
    cells.SetData(numpy_to_vtk(vtk_to_numpy(grid.GetCells().GetOffsetsArray()).astype(np.int64), deep=1), numpy_to_vtk(corners, deep=1))
    out.SetCells(types_of(grid), cells)
    copy_rows(grid.GetPointData(), first, out.GetPointData())
    out.GetCellData().ShallowCopy(grid.GetCellData())
    out.GetFieldData().ShallowCopy(grid.GetFieldData())
    return out


def take_cells(grid, chosen):
    """The cells of a grid that a mask chooses, and their points."""
    sizes = np.diff(vtk_to_numpy(grid.GetCells().GetOffsetsArray()))
    used, corners = np.unique(vtk_to_numpy(grid.GetCells().GetConnectivityArray())[np.repeat(chosen, sizes)], return_inverse=True)
    offsets = np.concatenate(([0], np.cumsum(sizes[chosen])))
    out = vtkUnstructuredGrid()
    points, cells = vtkPoints(), vtkCellArray()
    points.SetData(numpy_to_vtk(vtk_to_numpy(grid.GetPoints().GetData())[used], deep=1))
    out.SetPoints(points)
    cells.SetData(numpy_to_vtk(offsets.astype(np.int64), deep=1), numpy_to_vtk(corners.ravel().astype(np.int64), deep=1))
    out.SetCells(numpy_to_vtk(vtk_to_numpy(types_of(grid))[chosen], deep=1), cells)
    for to, data, rows in ((out.GetPointData(), grid.GetPointData(), used), (out.GetCellData(), grid.GetCellData(), np.flatnonzero(chosen))):
        copy_rows(data, rows, to)
        for kind in range(to.NUM_ATTRIBUTES):  # legacy files would have those first
            to.SetActiveAttribute(-1, kind)
    out.GetFieldData().ShallowCopy(grid.GetFieldData())
    return out


def with_vtks_id_type(grid):
    """ParaView's filters crash on global ids of another type, which is what its reader makes of 64-bit integers."""
    data = grid.GetPointData()
    old = data.GetGlobalIds()
    if old is not None and not old.IsA("vtkIdTypeArray"):
        ids = vtkIdTypeArray()
        ids.DeepCopy(old)
        data.SetGlobalIds(ids)
    return grid


def with_points_of(grid, kind):
    """Coordinates of the type `kind`: ParaView's filters make doubles of floats, which loses nothing, nor does the way back."""
    if grid.GetPoints() is not None and grid.GetPoints().GetDataType() != kind:
        points = vtkPoints()
        points.SetDataType(kind)
        points.DeepCopy(grid.GetPoints())
        grid.SetPoints(points)
    return grid
