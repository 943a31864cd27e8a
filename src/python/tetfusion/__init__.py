"""TetFusion for NumPy: simplifies tetrahedral meshes with all their arrays. Needs no VTK.

    import tetfusion
    mesh = tetfusion.Mesh(points, tets, point_data={"pressure": p})
    smaller = tetfusion.simplify(mesh, reduction=0.9)

simplify() takes and returns a Mesh of NumPy's arrays, a vtkUnstructuredGrid of any VTK, one of PyVista, or a meshio.Mesh.
"""
import collections.abc
import ctypes
import dataclasses
import json
import logging
import math
import numbers
import warnings

import numpy as np

from . import _meshes, _native
from . import _option_values as values
from ._option_values import TetFusionError, TetFusionWarning

__all__ = ["Mesh", "TetFusionError", "TetFusionWarning", "simplify"]
__version__ = _native.version()

_log = logging.getLogger("tetfusion")


@dataclasses.dataclass(eq=False)
class Mesh:
    """Points of three coordinates, a row each, and tetrahedra of four points' numbers, a row each; or cells of several kinds, VTK's way:
    types[c] is the VTK cell type of cell c, and its points are cells[offsets[c]:offsets[c + 1]].

    point_data and cell_data: arrays with a row for each point, or cell, by their names. In cell_data "vtkGhostType" marks ghosts, as
    VTK does: copies of other parts' cells, which are left out, and hold their points. active_scalars: the name of the array of points
    that steers if none is named. report: of a result what the command writes with --report.
    """
    points: np.ndarray
    cells: np.ndarray
    point_data: dict = dataclasses.field(default_factory=dict)
    cell_data: dict = dataclasses.field(default_factory=dict)
    offsets: np.ndarray = None
    types: np.ndarray = None
    active_scalars: str = None
    report: dict = dataclasses.field(default=None, repr=False)


def simplify(mesh, reduction=None, *, tets=None, max_error=None, max_rms=None, strict=None, method=None, boundary=None, feature_angle=None,
             min_quality=None, conserve=None, scalar_tolerance=None, stretch_factor=None, aspect_ratio=None, max_volume=None,
             boundary_tets_stay=None, arrays=None, regions=None, roi=None, weight=None, original_ids=None, tetrahedralize=None,
             linearize=None, drop_patches=None, drop_patch=None, threads=None, memory=None, scratch=None, chunk_tets=None, progress=None):
    """Return a mesh with fewer tetrahedra than `mesh`, which stays as it is, and of its kind. None is the default of every option.

    @OPTIONS@
    progress: called with the share that is done, from 0 to 1; False as its answer ends the run.
    Shares may be texts as the command takes them, "50%" or "0.5", and so may counts, "20k", and memory, "2G".
    Other threads of Python go on meanwhile, and may call simplify(), too. What progress raises ends the run, and so do handlers of
    signals: Ctrl-C is KeyboardInterrupt.

    Of a grid of VTK names of components, units and active arrays come back, too; bits and texts are left out with a TetFusionWarning. Of
    meshio's meshes sets are left out so, and what is not of points and cells. The result shares nothing with `mesh` but field data.

    What the command would say meanwhile goes to the logger "tetfusion", as info.

    Raises TetFusionError.
    """
    if progress is not None and not callable(progress):
        values.refuse(f"progress: give a function that takes a share, not {progress!r}")
    options = {"reduction": values.share(reduction), "tets": values.count(tets), "max_error": values.share(max_error),
               "max_rms": values.share(max_rms), "strict": values.flag(strict), "method": method,
               "feature_angle": feature_angle, "min_quality": min_quality,
               "conserve": values.flag(conserve), "scalar_tolerance": _shares(scalar_tolerance),
               "stretch_factor": stretch_factor, "aspect_ratio": aspect_ratio, "max_volume": max_volume,
               "boundary_tets_stay": values.flag(boundary_tets_stay), "weight": values.text(weight),
               "original_ids": values.flag(original_ids), "tetrahedralize": values.flag(tetrahedralize),
               "linearize": values.flag(linearize), "drop_patches": values.flag(drop_patches), "threads": values.whole(threads),
               "memory": values.size(memory), "scratch": values.path(scratch), "chunk_tets": values.count(chunk_tets)}
    if boundary is not None:
        options["boundary"], options["boundary_distance"] = values.boundary(boundary)
    if arrays is not None:
        options["arrays"] = [{"name": name, "of_cells": of_cells, "tolerance": bound}
                             for name, of_cells, bound in values.steering(arrays)]
    if regions is not None:
        options["regions"] = values.regions(regions)
    if roi is not None:
        options["roi"] = values.texts("roi", roi, "a text, or a list of them, as in 'pressure>0.5'")
    if drop_patch is not None:
        options["drop_patch"] = values.texts("drop_patch", drop_patch, "a text, or a list of them, as in 'patch=3'")
    has_goal = reduction is not None or tets is not None
    text = json.dumps({name: _plain(name, value) for name, value in options.items() if value is not None})
    other = None if isinstance(mesh, Mesh) else _meshes.converter(mesh)
    parts = other.parts() if other else {field.name: getattr(mesh, field.name) for field in dataclasses.fields(mesh)}
    smaller = _run(parts, text, has_goal, progress)
    return other.whole(smaller) if other else smaller


if simplify.__doc__:  # not with -OO
    simplify.__doc__ = simplify.__doc__.replace("    @OPTIONS@\n", values.OPTIONS)


def _shares(value):
    return [values.share(item) for item in value] if isinstance(value, (list, tuple)) else values.share(value)


def _plain(option, value):
    """As JSON has it."""
    if isinstance(value, values.Wrong):
        values.refuse(f"{option} cannot be {value.value!r}{value.advice}")
    if isinstance(value, np.ndarray):
        value = value.tolist()  # of no dimension a number
    if isinstance(value, dict):
        return {name: _plain(option, part) for name, part in value.items()}
    if isinstance(value, (list, tuple)) and not any(isinstance(item, (list, tuple)) for item in value):
        return [_plain(option, item) for item in value]
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, str):
        if not _is_unicode(value):
            values.refuse(f"{option} cannot be {value!r}, which is no UTF-8: give the array another name")
        return value
    if not values.is_number(value) or option in _TEXTS:
        values.refuse(f"{option} cannot be {value!r}")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if math.isnan(number):
        values.refuse(f"{option} cannot be {value!r}")
    if math.isinf(number):
        return "inf" if number > 0 else -1
    return int(value) if isinstance(value, numbers.Integral) else number


_TEXTS = ("method", "weight", "scratch")


def _is_unicode(text):
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _run(parts, options, has_goal, progress):
    inputs = _Inputs(parts)
    result = _native.simplify(inputs.mesh, options, progress or (lambda share: None), _log.info)
    if result.code != 0:
        raise TetFusionError(result.code, "the run was ended" if result.code == _native.INTERRUPTED else result.message)
    report = json.loads(result.report)
    if has_goal and report["stop_reason"] != "goal":
        warnings.warn(report["stop_sentence"], TetFusionWarning, stacklevel=3)
    return inputs.mesh_of(result, report)


class _Inputs:
    """Arrays as the library reads them, where they can stay without a copy."""

    def __init__(self, parts):
        self._kept = []  # what the structures refer to
        self._like = {}  # of each array, by kind and name, the shape of its rows, and whether it is of bools
        points = self._numbers("points", parts["points"])
        if points.ndim != 2 or points.shape[1] != 3:
            values.refuse_mesh(f"points must have three columns, not the shape {points.shape}")
        if points.dtype.kind != "f":
            points = self._numbers("points", points.astype(np.float64))
        cells = self._whole_numbers("cells", parts["cells"], (np.int32, np.int64))
        types, offsets = parts.get("types"), parts.get("offsets")
        if (types is None) != (offsets is None):
            values.refuse_mesh("types and offsets go together")
        self._is_flat = types is not None
        if self._is_flat:
            types, offsets = self._whole_numbers("types", types, (np.uint8,)), self._whole_numbers("offsets", offsets, (cells.dtype,))
            if types.ndim != 1 or offsets.shape != (len(types) + 1,):
                values.refuse_mesh(f"offsets must be one more than types, not of the shape {offsets.shape} for {types.shape}")
        elif cells.ndim != 2 or cells.shape[1] != 4:
            values.refuse_mesh(f"cells must have four columns, not the shape {cells.shape}; other kinds need offsets and types")
        count = len(types) if self._is_flat else len(cells)
        self.mesh = _native.Mesh(points=_native.values_of(points), connectivity=_native.values_of(cells))
        if self._is_flat:
            self.mesh.offsets, self.mesh.types = _native.values_of(offsets), _native.values_of(types)
        point_data, cell_data = _named("point_data", parts["point_data"]), _named("cell_data", parts["cell_data"])
        self._take_ghosts(point_data, cell_data, count)
        self.mesh.point_arrays, self.mesh.point_array_count = self._arrays("point", point_data, len(points))
        self.mesh.cell_arrays, self.mesh.cell_array_count = self._arrays("cell", cell_data, count)
        active = parts.get("active_scalars")
        if active is not None:
            if values.text(active) not in point_data:
                values.refuse_mesh(f"active_scalars: there is no point array {active!r}")
            self.mesh.active_scalars = _bytes_of(values.text(active))

    def _numbers(self, what, given):
        if np.ma.is_masked(given):
            values.refuse_mesh(f"{what}: entries are masked; fill them, with nan perhaps")
        try:
            array = np.asarray(given)
        except (TypeError, ValueError) as error:
            values.refuse_mesh(f"{what}: {error}")
        if array.dtype.kind not in "biuf" or array.dtype.itemsize > 8 or array.dtype == np.float16:
            values.refuse_mesh(f"{what}: numbers of type {array.dtype} are not taken; give float64, float32 or integers")
        if array.dtype.kind == "b":
            array = array.view(np.uint8)
        array = np.require(array, array.dtype.newbyteorder("="), "CA")
        self._kept.append(array)
        return array

    def _whole_numbers(self, what, given, kinds):
        """As the first of the types that holds them, if they are of none of these."""
        array = self._numbers(what, given)
        if array.dtype in kinds:
            return array
        with np.errstate(invalid="ignore"):  # NaN
            taken = self._numbers(what, array.astype(kinds[-1]))
        if array.size and not np.array_equal(taken, array):
            values.refuse_mesh(f"{what} must be whole numbers that {taken.dtype} can hold")
        return taken

    def _take_ghosts(self, point_data, cell_data, count):
        """Marks are no arrays like others."""
        flags = None
        for name in _meshes.GHOST_MARKS:
            point_data.pop(name, None)
            if name not in cell_data:
                continue
            marks = self._whole_numbers(name, cell_data.pop(name), (np.uint8,))
            if marks.size != count:
                values.refuse_mesh(f"{name} must have {count} rows of one component")
            marks = marks.reshape(-1) if name == "vtkGhostType" else (marks.reshape(-1) > 0).view(np.uint8)
            flags = marks if flags is None else flags | marks
        if flags is not None:
            self.mesh.ghosts = _native.values_of(self._numbers("ghosts", flags))

    def _arrays(self, kind, arrays, rows):
        out = (_native.Array * len(arrays))()
        for entry, (name, given) in zip(out, arrays.items()):
            what = f"{kind} array {name!r}"
            array = self._numbers(what, given)
            if array.ndim == 0 or len(array) != rows:
                values.refuse_mesh(f"{what} must have {rows} rows, not the shape {array.shape}")
            components = math.prod(array.shape[1:])
            if components == 0:
                values.refuse_mesh(f"{what} has no components")
            self._like[kind, name] = array.shape[1:], np.asarray(given).dtype.kind == "b"
            entry.name, entry.components, entry.values = _bytes_of(name), components, _native.values_of(array)
        self._kept.append(out)
        return ctypes.cast(out, ctypes.POINTER(_native.Array)), len(arrays)

    def mesh_of(self, result, report):
        mesh = result.mesh
        cells = result.numbers(mesh.connectivity)
        flat = {"offsets": result.numbers(mesh.offsets), "types": result.numbers(mesh.types)} if self._is_flat else {}
        return Mesh(result.numbers(mesh.points).reshape(-1, 3), cells if self._is_flat else cells.reshape(-1, 4),
                    self._take(result, "point", mesh.point_arrays[:mesh.point_array_count]),
                    self._take(result, "cell", mesh.cell_arrays[:mesh.cell_array_count]),
                    active_scalars=_native.readable(mesh.active_scalars) if mesh.active_scalars else None, report=report, **flat)

    def _take(self, result, kind, arrays):
        out = {}
        for array in arrays:
            name = _native.readable(array.name)
            shape, is_bool = self._like.get((kind, name), ((), False))
            rows = result.numbers(array.values).reshape(-1, *shape)
            out[name] = rows.view(np.bool_) if is_bool else rows
        return out


def _named(what, arrays):
    """A dict of our own, with names as texts."""
    arrays = {} if arrays is None else arrays
    if not isinstance(arrays, collections.abc.Mapping):
        values.refuse_mesh(f"{what} must be a dict from names to arrays, not {type(arrays).__name__}")
    named = {}
    for name, rows in arrays.items():
        if not isinstance(name, (str, bytes)) or not name or values.text(name) in named or "\0" in values.text(name):
            values.refuse_mesh(f"{what}: the name of an array cannot be {name!r}")
        _bytes_of(values.text(name))
        named[values.text(name)] = rows
    return named


def _bytes_of(name):
    try:
        return name.encode(errors="surrogateescape")
    except UnicodeEncodeError:
        values.refuse_mesh(f"the name of an array cannot be {name!r}")
