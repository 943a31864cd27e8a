"""What steers on all ranks, and how far it may be off on each."""
import math

from .failure import USAGE, Failure
from .grids import cells_of, diagonal


def steering_by_default(grid):
    """The filter takes the first of these that is not the same everywhere."""
    data = grid.GetPointData()
    scalars = data.GetScalars()
    arrays = (data.GetArray(i) for i in range(data.GetNumberOfArrays()))
    floats = [a.GetName() for a in arrays if a is not None and a.GetDataTypeAsString() in ("float", "double")]
    return floats if scalars is None else [scalars.GetName(), *(name for name in floats if name != scalars.GetName())]


def extent(grid, name):
    """The range of a point array, component by component: low, high, low, high, ..."""
    array = grid.GetPointData().GetArray(name)
    if array is None:
        raise Failure(USAGE, f"there is no point array {name} to steer by (name one of the cells cell:NAME)")
    return [value for c in range(array.GetNumberOfComponents()) for value in array.GetFiniteRange(c)]


def bounds_of_arrays(grid, options, error, ranks):
    """The bound of each steering array as a share of the range that it has on this rank."""
    bounds = {}
    for name in ranks.agree((options.array or steering_by_default(grid)) if cells_of(grid) else []):
        if name.startswith("cell:"):
            bounds[name] = error  # of the range on this rank, which is none the larger
            continue
        own = extent(grid, name) if cells_of(grid) else []
        size = int(ranks.gather(len(own)).max())
        rows = ranks.gather(own or (math.inf, -math.inf) * (size // 2))
        whole = [f(rows[:, i]) for i, f in zip(range(size), (min, max) * size)]
        if not options.array and not diagonal(whole) > 0:
            continue
        here = diagonal(own) if own else 0
        # New values stay within the range here, which is then all that they may be off by.
        bounds[name] = min(error * diagonal(whole) / here, 1) if here > 0 else None
        if not options.array:
            break
    return bounds
