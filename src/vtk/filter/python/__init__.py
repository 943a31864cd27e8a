"""TetFusion for Python: simplifies tetrahedral meshes with all their arrays.

    import vtktetfusion
    smaller = vtktetfusion.simplify(grid, reduction=0.9)

simplify() takes and returns a vtkUnstructuredGrid, or what stands for one in vtkmodules.numpy_interface or in PyVista.
vtkTetFusion is the filter itself, for a pipeline; help(vtktetfusion.vtkTetFusion) explains every option.
"""
import logging
import math
import numbers
import re
import signal
import sys
import threading
import warnings

from vtkmodules import vtkCommonDataModel, vtkCommonExecutionModel  # what the wrapped module builds on

from .vtkTetFusionFilter import vtkTetFusion

__all__ = ["TetFusionError", "TetFusionWarning", "simplify", "vtkTetFusion"]

_log = logging.getLogger("vtktetfusion")

# One run at a time: who waits here lets other threads of Python go on, which the run itself does not.
_turn = threading.Lock()
_runs_here = threading.local()

_USER_ERROR = 40000  # vtkErrorCode::UserError, which Python does not have


class TetFusionError(RuntimeError):
    """A grid was not simplified.

    code is the exit code that the command has for the same: 2 usage, 3 bad input, 4 reading or writing, 5 memory, 6 the goal was
    not reached (with strict), 130 progress() asked for an end.
    """

    def __init__(self, code, message):
        super().__init__(message)
        self.code = code

    def __reduce__(self):
        return type(self), (self.code, str(self))


class TetFusionWarning(UserWarning):
    """A goal was not reached, an array that holds no numbers is left out, or blocks may not fit any more."""


def simplify(grid, reduction=None, *, tets=None, max_error=None, max_rms=None, strict=False, method="fuse", boundary="exact",
             min_quality=None, conserve=False, scalar_tolerance=None, stretch_factor=None, aspect_ratio=None, max_volume=None,
             boundary_tets_stay=False, arrays=None, regions=None, roi=(), weight=None, original_ids=False,
             tetrahedralize=False, linearize=False, drop_patches=False, threads=0, memory=0, scratch=None, chunk_tets=200000, progress=None):
    """Return a grid with fewer tetrahedra than `grid`, which stays as it is.

    Of a composite data set each block for itself (blocks that touch fit afterwards with an exact boundary); one without cells that have a volume (a patch, a side set) comes back as it is.

    reduction: the share of the tetrahedra that is to go, as in 0.9; of 0 the mesh stays as it is.
    tets: the same goal as the number that is to be left. Without a goal: as far as max_error allows.
    max_error: at no point is a steering field off by more than this share of its range; default 0.01 where nothing else limits.
    max_rms: no fusion changes a steering field by more in the mean of squares, as a share of its range.
    strict: a goal that cannot be reached is an error, and not only a TetFusionWarning.
    method: "fuse", or "tetfuse", the operation of the paper.
    boundary: "exact", "planar", or how far it may move, as a share of the diagonal of the bounding box.
    min_quality: the lowest mean ratio of a new tetrahedron, in [0, 1); default 0.22.
    conserve: the integrals of all floating-point arrays stay; cells keep the values of regions.
    scalar_tolerance, stretch_factor, aspect_ratio, max_volume: bounds for each fusion; math.inf is off.
    boundary_tets_stay: with "tetfuse", no tetrahedron that touches the boundary is fused.
    arrays: what steers: a name, or a list of names, "cell:NAME" for an array of the cells, or a dict from names to the largest error
        of each (None: no other than max_error). Default: the active scalars, else the first floating-point array of the points,
        of these the first that is not the same everywhere.
    regions: names of cell arrays of one component whose interfaces are kept, or "none"; default: those of integers named like materials.
    roi: where the mesh stays as it is: a text, or a list of them, "box=X0,X1,Y0,Y1,Z0,Z1", "sphere=X,Y,Z,RADIUS" or "pressure>0.5".
    weight: the name of a point array, or "cell:NAME": errors count so many times as much there, so that the mesh stays finer.
    original_ids: the result has the point array OriginalPointIds: the number of a point of `grid` that stayed, -1 of a new one.
    drop_patches: leave out cells without volume, of any type, which else hold their points where they are.
    tetrahedralize, linearize: split hexahedra, voxels, wedges and pyramids; take cells of higher order, as
        ten-node tetrahedra, as straight ones.
    threads, memory, scratch: threads (0: all), bytes (0: half of the machine's), and a folder for what does not fit.
    chunk_tets: tetrahedra in each of the chunks that threads work on; the result depends on it.
    progress: called with the share that is done, from 0 to 1; False as its answer ends the run. It cannot call simplify().
    Shares may be texts as the command takes them, "50%", and so may memory, "2G".
    One call runs at a time: those of other threads wait for it. Ctrl-C ends the run: KeyboardInterrupt.

    What the command would say meanwhile goes to the logger "vtktetfusion", as info.

    Raises TetFusionError.
    """
    if min_quality is not None and method == "tetfuse":
        _refuse("min_quality belongs to method fuse")
    grid_of_vtk = getattr(grid, "VTKObject", grid)
    if not isinstance(grid_of_vtk, vtkCommonDataModel.vtkDataObject):
        _refuse(f"grid must be a vtkUnstructuredGrid, or what stands for one, not {type(grid).__name__}")
    run = vtkTetFusion()
    run.SetInputDataObject(grid_of_vtk)
    given = {"reduction": ("TargetReduction", _share("reduction", reduction)), "tets": ("NumberOfTetsOutput", tets),
             "max_error": ("MaximumError", _share("max_error", max_error)),
             "max_rms": ("MaximumRMS", _share("max_rms", max_rms)), "min_quality": ("MinimumQuality", min_quality),
             "scalar_tolerance": ("ScalarTolerance", _share("scalar_tolerance", scalar_tolerance)),
             "stretch_factor": ("StretchFactor", stretch_factor), "aspect_ratio": ("AspectRatio", aspect_ratio),
             "max_volume": ("MaximumVolume", max_volume), "weight": ("WeightArrayName", weight),
             "scratch": ("ScratchDirectory", scratch), "chunk_tets": ("ChunkTets", chunk_tets)}
    for option, (name, value) in given.items():
        if value is not None:
            _set(run, option, name, _no_default(name, value))
    for option, name, value in (("threads", "NumberOfThreads", threads), ("memory", "MemoryLimit", _size(memory))):
        if _is_number(value) and value < 0:
            _refuse(f"{option} must be at least 0")
        _set(run, option, name, value)
    run.SetStrict(strict)
    run.SetConserve(conserve)
    run.SetBoundaryTetsStay(boundary_tets_stay)
    run.SetOriginalIds(original_ids)
    run.SetTetrahedralize(tetrahedralize)
    run.SetLinearize(linearize)
    run.SetDropPatches(drop_patches)
    run.SetMethod(_choice("method", method, {"fuse": run.FUSE, "tetfuse": run.TETFUSE}))
    _set_boundary(run, _share("boundary", boundary))
    _set_arrays(run, arrays)
    _set_regions(run, regions)
    for region in [roi] if isinstance(roi, str) else roi:
        run.AddRegionOfInterest(region)
    _execute(run, progress)
    return _like(grid, run.GetOutputDataObject(0))


def _refuse(message):
    raise TetFusionError(2, message)


def _is_number(value):
    return isinstance(value, numbers.Real)


def _set(run, option, name, value):
    try:
        getattr(run, "Set" + name)(value)
    except (TypeError, OverflowError):
        _refuse(f"{option} cannot be {value!r}")


def _share(option, value):
    """A text such as "50%" as a number; all else as it is."""
    if not isinstance(value, str) or not value.endswith("%"):
        return value
    try:
        return float(value[:-1]) / 100
    except ValueError:
        _refuse(f"{option} cannot be {value!r}: give a share, as in 0.5 or '50%'")


def _size(value):
    """A text such as "2G" as a number of bytes, as the command takes it; all else as it is."""
    if not isinstance(value, str):
        return value
    match = re.fullmatch(r"([0-9.]+)([KMGT]?)(iB|B)?", value.strip())
    try:
        return int(float(match[1]) * 1024 ** " KMGT".index(match[2] or " "))
    except (TypeError, ValueError):
        _refuse(f"memory cannot be {value!r}: give bytes, or a text as in '2G'")


def _no_default(name, value):
    """The filter takes a 0 for its default, but here the default is None: another value that means what 0 says."""
    if not _is_number(value) or value != 0 or name == "ChunkTets" or name == "MinimumQuality":
        return value
    if name == "TargetReduction":
        return sys.float_info.min  # so small a share is no tetrahedron of any mesh
    return -1  # refused as the command refuses 0, in its words


def _choice(option, value, choices):
    if value not in choices:
        _refuse(f"{option} must be one of {', '.join(choices)}, not {value!r}")
    return choices[value]


def _set_boundary(run, boundary):
    if not _is_number(boundary):
        run.SetBoundaryMode(_choice("boundary", boundary, {"exact": run.EXACT, "planar": run.PLANAR}))
        return
    run.SetBoundaryModeToWithin()
    run.SetBoundaryTolerance(boundary)


def _set_arrays(run, arrays):
    if arrays is None:
        return
    if isinstance(arrays, str):
        arrays = [arrays]
    bounds = arrays if isinstance(arrays, dict) else dict.fromkeys(arrays)
    for name, bound in bounds.items():
        of_cells = name.startswith("cell:")
        association = vtkCommonDataModel.vtkDataObject.FIELD_ASSOCIATION_CELLS if of_cells else \
            vtkCommonDataModel.vtkDataObject.FIELD_ASSOCIATION_POINTS
        bound = _share("arrays", bound)
        if bound is not None and not (_is_number(bound) and bound > 0 and not math.isnan(bound)):
            _refuse(f"arrays: the bound of {name} must be greater than 0, a share of its range")
        run.AddSteeringArray(association, name[len("cell:"):] if of_cells else name, bound or 0)


def _set_regions(run, regions):
    if regions is None:
        return
    if isinstance(regions, str):
        regions = [] if regions == "none" else [regions]
    run.SetKeepRegions(bool(regions))
    for name in regions:
        run.AddRegionArray(name)


def _execute(run, progress):
    errors = []

    def on_error(caller, name, text="unknown error"):
        errors.append(_plain(text))
    on_error.CallDataType = "string0"
    # The executive complains, too; with an observer neither prints. What the filter has to say it keeps, as events do not come
    # where VTK's warnings are off.
    for speaker in (run, run.GetExecutive()):
        speaker.AddObserver("ErrorEvent", on_error)
        speaker.AddObserver("WarningEvent", lambda caller, name: None)
    raised = []

    def on_progress(caller, event):
        if interrupt.came:
            caller.SetAbortExecute(1)
            return
        try:
            answer = None if raised or progress is None else progress(caller.GetProgress())
            if answer is not None and not answer:
                caller.SetAbortExecute(1)
        except BaseException as error:  # an exception of an observer would be printed and forgotten
            raised.append(error)
            caller.SetAbortExecute(1)
    run.AddObserver("ProgressEvent", on_progress)
    if getattr(_runs_here, "any", False):
        _refuse("progress() cannot simplify another grid meanwhile")
    with _turn, _Interrupt() as interrupt:
        _runs_here.any = True
        try:
            run.Update()
        finally:
            _runs_here.any = False
    if raised:
        raise raised[0]
    for line in run.GetNotices().splitlines():
        _log.info(line)
    for concern in run.GetWarnings().splitlines():
        warnings.warn(concern, TetFusionWarning, stacklevel=3)
    code = run.GetErrorCode()
    if code == 0 and not errors:
        return
    code = code - _USER_ERROR if code >= _USER_ERROR else 3
    said = run.GetErrorMessage() or (errors or ["it was not simplified"])[0]
    raise TetFusionError(code, "the run was ended" if code == 130 else said)


class _Interrupt:
    """Ctrl-C during a run: noted, so that the run ends at its next report, and then handled as it is elsewhere."""

    def __enter__(self):
        self.came = False
        self._handler = None
        handler = signal.getsignal(signal.SIGINT)
        if callable(handler) and threading.current_thread() is threading.main_thread():
            self._handler = handler
            signal.signal(signal.SIGINT, self._note)
        return self

    def _note(self, number, frame):
        self.came = True

    def __exit__(self, *raised):
        if self._handler is None:
            return
        signal.signal(signal.SIGINT, self._handler)
        if self.came:
            self._handler(signal.SIGINT, None)


def _plain(message):
    """VTK puts the source file, the line and the object before what was said."""
    return message.partition("): ")[2].strip() or message.strip()


def _like(grid, output):
    """The output as the caller has grids."""
    if hasattr(grid, "VTKObject"):
        from vtkmodules.numpy_interface import dataset_adapter
        return dataset_adapter.WrapDataObject(output)
    if type(grid).__module__.partition(".")[0] == "pyvista":
        import pyvista
        return pyvista.wrap(output)
    return output
