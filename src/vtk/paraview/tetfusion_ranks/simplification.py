"""One rank's part with ghosts round it, and TetFusion on that."""
import math

from vtkmodules.vtkFiltersParallelDIY2 import vtkGhostCellsGenerator
import vtktetfusion

from .failure import USAGE, Failure
from .grids import cells_of, diagonal, with_vtks_id_type


def with_ghosts(grid):
    run = vtkGhostCellsGenerator()
    run.SetInputDataObject(with_vtks_id_type(grid))
    run.SetBuildIfRequired(False)
    run.SetNumberOfGhostLayers(1)
    run.Update()
    return run.GetOutputDataObject(0)


def steering(grid, options):
    """What steers, as the filter would choose it."""
    if options.array:
        return options.array
    data = grid.GetPointData()
    if data.GetScalars() is not None:
        return [data.GetScalars().GetName()]
    arrays = (data.GetArray(i) for i in range(data.GetNumberOfArrays()))
    return [a.GetName() for a in arrays if a is not None and a.GetDataTypeAsString() in ("float", "double")][:1]


def extent(grid, name):
    """The range of a point array, component by component: low, high, low, high, ..."""
    array = grid.GetPointData().GetArray(name)
    if array is None:
        raise Failure(USAGE, f"there is no point array {name} to steer by (name one of the cells cell:NAME)")
    return [value for c in range(array.GetNumberOfComponents()) for value in array.GetFiniteRange(c)]


def bounds_of_arrays(grid, options, error, ranks):
    """The bound of each steering array as a share of the range that it has on this rank."""
    bounds = {}
    for name in ranks.agree(steering(grid, options) if cells_of(grid) else []):
        if name.startswith("cell:"):
            bounds[name] = error  # of the range on this rank, which is none the larger
            continue
        own = extent(grid, name) if cells_of(grid) else []
        size = int(ranks.gather(len(own)).max())
        rows = ranks.gather(own or (math.inf, -math.inf) * (size // 2))
        whole = [f(rows[:, i]) for i, f in zip(range(size), (min, max) * size)]
        here = diagonal(own) if own else 0
        # New values stay within the range here, which is then all that they may be off by.
        bounds[name] = min(error * diagonal(whole) / here, 1) if here > 0 else None
    return bounds


def simplify(grid, options, goal, error, passes, ranks, box):
    regions = "none" if options.regions == ["none"] else options.regions
    tets = None
    arrays = options.array or None
    if error is not None and options.method == "fuse":
        arrays = bounds_of_arrays(grid, options, error, ranks)
        if goal is None and not any(arrays.values()):
            tets = 1  # every field is constant here: as far as it goes
    surface = options.boundary
    if not isinstance(surface, str):
        # Of a small part it may be so much that it needs a percent sign.
        surface = f"{100 * min(surface / passes * diagonal(box) / diagonal(grid.GetBounds()), 0.999)}%" if cells_of(grid) else "exact"
    return vtktetfusion.simplify(
        grid, reduction=goal, tets=tets, arrays=arrays, boundary=surface, regions=regions, roi=options.roi, weight=options.weight,
        min_quality=options.min_quality, conserve=options.conserve, method=options.method, threads=options.threads or ranks.threads(),
        memory=options.memory, scratch=options.scratch)
