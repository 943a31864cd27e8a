"""Meshes of others as ours, and back: VTK's and PyVista's of any version, meshio's."""
import warnings

import numpy as np

from ._option_values import TetFusionWarning, refuse, refuse_mesh, text

GHOST_MARKS = ("vtkGhostType", "vtkGhostLevels")
_OF_MESHIO = {"vertex": 1, "line": 3, "triangle": 5, "polygon": 7, "quad": 9, "tetra": 10, "hexahedron": 12, "wedge": 13, "pyramid": 14,
              "line3": 21, "triangle6": 22, "quad8": 23, "tetra10": 24, "hexahedron20": 25, "wedge15": 26, "pyramid13": 27, "quad9": 28,
              "hexahedron27": 29, "wedge18": 32, "triangle7": 34, "line4": 35, "triangle10": 69, "triangle15": 69}
_OF_VTK = {number: name for name, number in _OF_MESHIO.items()}


def converter(mesh):
    """What takes such a mesh apart, and puts one together."""
    grid = getattr(mesh, "VTKObject", mesh)
    if not isinstance(grid, type) and hasattr(grid, "IsA") and grid.IsA("vtkUnstructuredGrid"):
        return _Grid(mesh, grid)
    if _is_of(mesh, "meshio"):
        return _OfMeshio(mesh)
    refuse(f"mesh must be a tetfusion.Mesh, a vtkUnstructuredGrid, one of PyVista or a meshio.Mesh, not {type(mesh).__name__}")


def _is_of(thing, package):
    return any(kind.__module__.partition(".")[0] == package for kind in type(thing).__mro__)


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
            refuse_mesh("it has no cells")
        active = grid.GetPointData().GetScalars()
        point_data = self._arrays(grid.GetPointData(), "point")
        types = grid.GetCellTypesArray() if hasattr(grid, "GetCellTypesArray") else grid.GetCellTypes()  # since VTK 9.6
        return {"points": self._rows(grid.GetPoints().GetData()), "cells": self._rows(grid.GetCells().GetConnectivityArray()),
                "offsets": self._rows(grid.GetCells().GetOffsetsArray()), "types": self._rows(types),
                "point_data": point_data, "cell_data": self._arrays(grid.GetCellData(), "cell"),
                "active_scalars": text(active.GetName()) if active is not None and text(active.GetName()) in point_data else None}

    def _arrays(self, data, kind):
        found = {}
        for i in range(data.GetNumberOfArrays()):
            array, name = data.GetAbstractArray(i), text(data.GetArrayName(i))
            is_mark = name in GHOST_MARKS
            if is_mark and (kind == "point" or array.GetDataTypeAsString() in ("float", "double")):
                continue  # the filter obeys none of these either
            if not name or name in found:
                _leave_out(kind, name, "it has no name" if not name else "another one has its name")
            elif data.GetArray(i) is None or array.IsA("vtkBitArray"):
                _leave_out(kind, name, "it holds no numbers that NumPy has")
            else:
                found[name] = self._rows(array)
        return found

    def _rows(self, array):
        if array.HasStandardMemoryLayout():
            return self._numpy.vtk_to_numpy(array)
        plain = array.CreateDataArray(array.GetDataType())  # some newer ones have no memory at all
        plain.DeepCopy(array)
        rows = self._numpy.vtk_to_numpy(plain)
        if rows.dtype.itemsize == 8 and rows.dtype.kind in "iu":  # VTK copies by way of doubles
            take = "ToLongLong" if rows.dtype.kind == "i" else "ToUnsignedLongLong"
            exact = (getattr(array.GetVariantValue(i), take)() for i in range(rows.size))
            rows = np.fromiter(exact, rows.dtype, rows.size).reshape(rows.shape)
        return rows

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
        if _is_of(self._given, "pyvista"):
            import pyvista
            return pyvista.wrap(out)
        return out

    def _copy(self, numbers, like=None):
        kind = like.GetDataType() if like is not None else None
        return self._numpy.numpy_to_vtk(numbers, deep=1, array_type=kind)

    def _put(self, arrays, before, data):
        """Arrays with what VTK knows of them: names and units of components, and which are active."""
        for name, numbers in arrays.items():
            given = before.GetArray(_name(name))
            array = self._copy(numbers.reshape(len(numbers), -1) if numbers.ndim > 2 else numbers, given)
            array.SetName(_name(name))
            if given is not None:
                array.CopyComponentNames(given)
                if given.HasInformation():
                    array.CopyInformation(given.GetInformation(), 1)
            data.AddArray(array)
        for kind in range(before.NUM_ATTRIBUTES):
            active = before.GetAbstractAttribute(kind)
            name = text(active.GetName()) if active is not None else None
            if name not in arrays:
                continue
            if kind == before.GLOBALIDS and len(np.unique(arrays[name])) < len(arrays[name]):  # of cells that were split
                if before.GetPedigreeIds() is None:
                    data.SetActiveAttribute(active.GetName(), before.PEDIGREEIDS)
                continue
            data.SetActiveAttribute(active.GetName(), kind)


def _name(name):
    """VTK takes what is no UTF-8 as bytes."""
    return name if name.isascii() else name.encode(errors="surrogateescape")


class _OfMeshio:
    def __init__(self, mesh):
        self._mesh = mesh

    def parts(self):
        blocks = [(block.type, np.asarray(block.data)) for block in self._mesh.cells if len(block.data) > 0]
        unknown = sorted({kind for kind, _ in blocks} - _OF_MESHIO.keys())
        if unknown:
            refuse_mesh(f"cells of meshio's type {', '.join(unknown)} are not read")
        if not blocks:
            refuse_mesh("it has no cells")
        for what in "point_sets", "cell_sets":
            for name in getattr(self._mesh, what, None) or {}:
                warnings.warn(f"the {what} {name!r} is left out", TetFusionWarning, stacklevel=3)
        return {"points": self._mesh.points,
                "cells": np.concatenate([_turned(kind, rows).ravel() for kind, rows in blocks]),
                "offsets": np.cumsum(np.concatenate([[0], *(np.full(len(rows), rows.shape[1]) for _, rows in blocks)])),
                "types": np.concatenate([np.full(len(rows), _OF_MESHIO[kind]) for kind, rows in blocks]),
                "point_data": self._mesh.point_data,
                "cell_data": {name: self._joined(name, parts) for name, parts in self._mesh.cell_data.items()}}

    def _joined(self, name, parts):
        try:
            return np.concatenate([np.asarray(part) for part in parts if len(part) > 0])
        except ValueError as error:
            refuse_mesh(f"cell_data {name!r}: its blocks are not alike: {error}")

    def whole(self, mesh):
        """Cells of one type after another are a block."""
        ends = np.concatenate([np.flatnonzero(np.diff(mesh.types.astype(int))) + 1, [len(mesh.types)]])
        begins = np.concatenate([[0], ends[:-1]])
        runs = [(begin, end) for begin, end in zip(begins, ends) if end > begin]
        cells = []
        for begin, end in runs:
            kind = _OF_VTK[int(mesh.types[begin])]
            cells.append((kind, _turned(kind, mesh.cells[mesh.offsets[begin]:mesh.offsets[end]].reshape(end - begin, -1))))
        cell_data = {name: [numbers[begin:end] for begin, end in runs] for name, numbers in mesh.cell_data.items()}
        return type(self._mesh)(mesh.points, cells, point_data=mesh.point_data, cell_data=cell_data,
                                field_data=self._mesh.field_data)


def _turned(kind, cells):
    """meshio winds wedges the other way than VTK, and says so of no other type."""
    return cells[:, [0, 2, 1, 3, 5, 4]] if kind == "wedge" else cells
