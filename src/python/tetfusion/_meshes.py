"""Meshes of others as ours, and back: VTK's and PyVista's of any version, meshio's."""
import warnings

import numpy as np

from ._option_values import TetFusionWarning, refuse

GHOSTS = "vtkGhostType"
_OF_MESHIO = {"vertex": 1, "line": 3, "triangle": 5, "quad": 9, "tetra": 10, "hexahedron": 12, "wedge": 13, "pyramid": 14, "line3": 21,
              "triangle6": 22, "quad8": 23, "tetra10": 24, "hexahedron20": 25, "wedge15": 26, "pyramid13": 27, "quad9": 28,
              "hexahedron27": 29, "wedge18": 32, "triangle7": 34}
_OF_VTK = {number: name for name, number in _OF_MESHIO.items()}


def converter(mesh):
    """What takes such a mesh apart, and puts one together."""
    grid = getattr(mesh, "VTKObject", mesh)
    if hasattr(grid, "IsA") and grid.IsA("vtkUnstructuredGrid"):
        return _Grid(mesh, grid)
    if type(mesh).__module__.partition(".")[0] == "meshio":
        return _OfMeshio(mesh)
    refuse(f"mesh must be a tetfusion.Mesh, a vtkUnstructuredGrid, one of PyVista or a meshio.Mesh, not {type(mesh).__name__}")


def _leave_out(kind, name, reason):
    warnings.warn(f"{kind} array {name!r} is left out: {reason}", TetFusionWarning, stacklevel=5)


class _Grid:
    """A vtkUnstructuredGrid, or what stands for one."""

    def __init__(self, given, grid):
        from vtkmodules.util import numpy_support
        self._numpy = numpy_support
        self._given, self._grid = given, grid

    def parts(self):
        grid = self._grid
        if grid.GetPoints() is None or grid.GetNumberOfCells() == 0:
            refuse("the grid has no cells")
        ghosts = grid.GetCellData().GetArray(GHOSTS)
        active = grid.GetPointData().GetScalars()
        return {"points": self._numpy.vtk_to_numpy(grid.GetPoints().GetData()),
                "cells": self._numpy.vtk_to_numpy(grid.GetCells().GetConnectivityArray()),
                "offsets": self._numpy.vtk_to_numpy(grid.GetCells().GetOffsetsArray()),
                "types": self._numpy.vtk_to_numpy(grid.GetCellTypesArray()),
                "ghosts": None if ghosts is None else self._numpy.vtk_to_numpy(ghosts).astype(np.uint8),
                "point_data": self._arrays(grid.GetPointData(), "point"),
                "cell_data": self._arrays(grid.GetCellData(), "cell"),
                "active_scalars": active.GetName() if active is not None else None}

    def _arrays(self, data, kind):
        found = {}
        for i in range(data.GetNumberOfArrays()):
            array, name = data.GetAbstractArray(i), data.GetArrayName(i)
            if name == GHOSTS:
                continue
            if not name:
                _leave_out(kind, "", "it has no name")
            elif data.GetArray(i) is None or array.IsA("vtkBitArray"):
                _leave_out(kind, name, "it holds no numbers that NumPy has")
            else:
                found[name] = self._numpy.vtk_to_numpy(array)
        return found

    def whole(self, mesh):
        from vtkmodules.vtkCommonCore import VTK_ID_TYPE, vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid
        ids = np.int32 if self._numpy.get_vtk_to_numpy_typemap()[VTK_ID_TYPE] == np.int32 else np.int64
        out = vtkUnstructuredGrid()
        points = vtkPoints()
        points.SetData(self._copy(mesh.points))
        out.SetPoints(points)
        cells = vtkCellArray()
        cells.SetData(self._numpy.numpy_to_vtkIdTypeArray(mesh.offsets.astype(ids), deep=1),
                      self._numpy.numpy_to_vtkIdTypeArray(mesh.cells.astype(ids), deep=1))
        out.SetCells(self._copy(mesh.types), cells)
        self._put(mesh.point_data, self._grid.GetPointData(), out.GetPointData())
        self._put(mesh.cell_data, self._grid.GetCellData(), out.GetCellData())
        out.GetFieldData().ShallowCopy(self._grid.GetFieldData())
        if hasattr(self._given, "VTKObject"):
            from vtkmodules.numpy_interface import dataset_adapter
            return dataset_adapter.WrapDataObject(out)
        if type(self._given).__module__.partition(".")[0] == "pyvista":
            import pyvista
            return pyvista.wrap(out)
        return out

    def _copy(self, numbers, like=None):
        kind = like.GetDataType() if like is not None else None
        return self._numpy.numpy_to_vtk(numbers, deep=1, array_type=kind)

    def _put(self, arrays, before, data):
        """Arrays with what VTK knows of them: names and units of components, and which are active."""
        for name, numbers in arrays.items():
            given = before.GetArray(name)
            array = self._copy(numbers.reshape(len(numbers), -1) if numbers.ndim > 2 else numbers, given)
            array.SetName(name)
            if given is not None:
                array.CopyComponentNames(given)
                if given.HasInformation():
                    array.CopyInformation(given.GetInformation(), 1)
            data.AddArray(array)
        for kind in range(before.NUM_ATTRIBUTES):
            active = before.GetAbstractAttribute(kind)
            if active is not None and active.GetName() in arrays:
                data.SetActiveAttribute(active.GetName(), kind)


class _OfMeshio:
    def __init__(self, mesh):
        self._mesh = mesh

    def parts(self):
        blocks = self._mesh.cells
        unknown = sorted({block.type for block in blocks} - _OF_MESHIO.keys())
        if unknown:
            refuse(f"cells of meshio's type {', '.join(unknown)} are not read")
        sizes = np.concatenate([np.full(len(block.data), np.shape(block.data)[1]) for block in blocks] or [[]])
        for what in "point_sets", "cell_sets":
            for name in getattr(self._mesh, what, {}):
                warnings.warn(f"the {what} {name!r} is left out", TetFusionWarning, stacklevel=4)
        return {"points": np.asarray(self._mesh.points),
                "cells": np.concatenate([np.ravel(block.data) for block in blocks] or [[]]).astype(np.int64),
                "offsets": np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
                "types": np.concatenate([np.full(len(block.data), _OF_MESHIO[block.type]) for block in blocks] or [[]]).astype(np.uint8),
                "point_data": dict(self._mesh.point_data),
                "cell_data": {name: np.concatenate([np.asarray(part) for part in parts])
                              for name, parts in self._mesh.cell_data.items()}}

    def whole(self, mesh):
        """Cells of one type after another are a block."""
        ends = np.concatenate([np.flatnonzero(np.diff(mesh.types.astype(int))) + 1, [len(mesh.types)]])
        begins = np.concatenate([[0], ends[:-1]])
        runs = [(begin, end) for begin, end in zip(begins, ends) if end > begin]
        cells = [(_OF_VTK[int(mesh.types[begin])], mesh.cells[mesh.offsets[begin]:mesh.offsets[end]].reshape(end - begin, -1))
                 for begin, end in runs]
        cell_data = {name: [numbers[begin:end] for begin, end in runs] for name, numbers in mesh.cell_data.items()}
        return type(self._mesh)(mesh.points, cells, point_data=mesh.point_data, cell_data=cell_data,
                                field_data=self._mesh.field_data)
