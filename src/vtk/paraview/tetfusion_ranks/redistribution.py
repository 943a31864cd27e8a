"""Cells on their way between the ranks."""
import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid
from vtkmodules.vtkFiltersCore import vtkAppendFilter

from .failure import IO, Failure
from .grids import IDS, cells_of, ids_of, join_by_ids, take_cells, whole_box, with_vtks_id_type


def cut(points, weights, box, count, axes, divisor):
    """Boxes for `count` ranks, with as much weight in each."""
    if count == 1:
        return [box]
    left = max(1, count // divisor)
    axis = axes[0]
    order = np.argsort(points[:, axis], kind="stable")
    sums = np.cumsum(weights[order])
    at = order[min(np.searchsorted(sums, sums[-1] * left / count), order.size - 1)] if order.size else None
    place = points[at, axis] if at is not None else 0.5 * (box[2 * axis] + box[2 * axis + 1])
    low, high = list(box), list(box)
    low[2 * axis + 1] = high[2 * axis] = place
    below = points[:, axis] <= place
    axes = axes[1:] + axes[:1]
    return cut(points[below], weights[below], low, left, axes, divisor) + \
        cut(points[~below], weights[~below], high, count - left, axes, divisor)


def active_arrays(grid):
    """Which of the point arrays, and of the cell arrays, is active as what, by its place; -1: none is."""
    found = []
    for data in grid.GetPointData(), grid.GetCellData():
        arrays = [data.GetAbstractArray(i) for i in range(data.GetNumberOfArrays())]
        for kind in range(data.NUM_ATTRIBUTES):
            array = data.GetAbstractAttribute(kind)
            found.append(arrays.index(array) if array is not None else -1)
    return found


def put_in_order(data, order):
    """The arrays as `order` has them: vtkAppendFilter sorts them by their names."""
    for name in map(order.GetArrayName, range(order.GetNumberOfArrays())):
        array = data.GetAbstractArray(name)
        data.RemoveArray(name)
        data.AddArray(array)


def exchange(parts, ranks):
    """What all ranks have for this one, in their order; `parts`: what this one has for each.

    The controller sends grids as legacy files, in which VTK's type of ids has 32 bits: so global ids are numbers like others meanwhile.
    """
    got = []
    for giver in range(ranks.count):
        for taker in range(ranks.count):
            if giver == taker == ranks.rank:
                got.append(parts[taker])
            elif giver == ranks.rank:
                ranks.controller.Send(parts[taker], taker, 1)
            elif taker == ranks.rank:
                got.append(ranks.controller.ReceiveDataObject(giver, 1))
    return [grid for grid in got if cells_of(grid)]


def redistribute(grid, ranks, number):
    """As many cells on each rank. Pass by pass the cuts lie elsewhere: along other axes, at other shares."""
    box = whole_box(grid, ranks)
    before = ranks.gather(cells_of(grid)).sum()
    samples = 4096
    own = np.zeros((samples, 4))
    corner = np.zeros((0, 3))
    if cells_of(grid):
        first = vtk_to_numpy(grid.GetCells().GetOffsetsArray())[:-1]
        corner = vtk_to_numpy(grid.GetPoints().GetData())[vtk_to_numpy(grid.GetCells().GetConnectivityArray())[first]]
        own[:, :3] = corner[np.linspace(0, first.size - 1, samples).astype(np.int64)]
        own[:, 3] = first.size / samples
        ids = numpy_to_vtk(ids_of(grid).astype(np.int64), deep=1, array_type=16)  # VTK_LONG_LONG
        ids.SetName(IDS)
        grid.GetPointData().SetGlobalIds(None)
        grid.GetPointData().RemoveArray(IDS)
        grid.GetPointData().AddArray(ids)
    active = ranks.gather(active_arrays(grid)).max(axis=0).astype(int).tolist()
    rows = ranks.gather(own).reshape(-1, 4)
    rows = rows[rows[:, 3] > 0]
    longest = sorted(range(3), key=lambda axis: box[2 * axis] - box[2 * axis + 1])
    axes, divisor = (longest, 2) if number == 0 else (longest[1:], 3)
    left = np.ones(len(corner), dtype=bool)  # cells that have no rank yet
    parts = []
    for place in cut(rows[:, :3], rows[:, 3], box, ranks.count, axes, divisor):
        inside = left & (corner <= place[1::2]).all(axis=1) & (corner >= place[::2]).all(axis=1)
        left &= ~inside
        parts.append(take_cells(grid, inside) if inside.any() else vtkUnstructuredGrid())
    append = vtkAppendFilter()
    got = exchange(parts, ranks)
    for part in got:
        append.AddInputData(part)
    if got:
        append.Update()
    out = append.GetOutput() if got else vtkUnstructuredGrid()
    if got:
        out.GetFieldData().ShallowCopy(got[0].GetFieldData())
        put_in_order(out.GetPointData(), got[0].GetPointData())
        put_in_order(out.GetCellData(), got[0].GetCellData())
        out.GetPointData().SetActiveAttribute(IDS, out.GetPointData().GLOBALIDS)
        out = join_by_ids(with_vtks_id_type(out), anew=True)
        kinds = out.GetPointData().NUM_ATTRIBUTES
        for i, place in enumerate(active):
            data = out.GetPointData() if i < kinds else out.GetCellData()
            if place >= 0:
                data.SetActiveAttribute(place, i % kinds)
    if ranks.gather(cells_of(out)).sum() != before:
        raise Failure(IO, "cells were lost on their way between the ranks", of_all=True)
    return out
