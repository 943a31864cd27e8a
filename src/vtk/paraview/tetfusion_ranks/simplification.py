"""One rank's part with ghosts round it, and TetFusion on that."""
from vtkmodules.vtkFiltersParallelDIY2 import vtkGhostCellsGenerator
import vtktetfusion

from .grids import cells_of, diagonal, with_vtks_id_type
from .steering import bounds_of_arrays


def with_ghosts(grid):
    run = vtkGhostCellsGenerator()
    run.SetInputDataObject(with_vtks_id_type(grid))
    run.SetBuildIfRequired(False)
    run.SetNumberOfGhostLayers(1)
    run.Update()
    return run.GetOutputDataObject(0)


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
        surface = f"{100 * min(surface / passes * diagonal(box) / diagonal(grid.GetBounds()), 0.999)}%" if cells_of(grid) else "planar"
    return vtktetfusion.simplify(
        grid, reduction=goal, tets=tets, arrays=arrays, boundary=surface, feature_angle=options.feature_angle, regions=regions,
        roi=options.roi, weight=options.weight, min_quality=options.min_quality, conserve=options.conserve, method=options.method,
        threads=options.threads or ranks.threads(), memory=options.memory, scratch=options.scratch)
