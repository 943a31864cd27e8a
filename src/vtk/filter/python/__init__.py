"""TetFusion for Python: simplifies tetrahedral meshes with all their arrays.

    import vtktetfusion
    smaller = vtktetfusion.simplify(grid, reduction=0.9)

simplify() takes and returns a vtkUnstructuredGrid, or what stands for one in vtkmodules.numpy_interface or in PyVista.
vtkTetFusion is the filter itself, for a pipeline; help(vtktetfusion.vtkTetFusion) explains every option.
"""
import logging
import os
import signal
import sys
import threading
import warnings

from vtkmodules import vtkCommonCore, vtkCommonDataModel, vtkCommonExecutionModel  # what the wrapped module builds on

from . import _built_with, _option_values as values
from ._option_values import TetFusionError, TetFusionWarning

_here = "{0}.{1}".format(*vtkCommonCore.vtkVersion().GetVTKVersion().split("."))
if _here != _built_with.VTK:  # the process would crash
    raise ImportError(f"vtktetfusion was built with VTK {_built_with.VTK}, and this is {_here}: the package tetfusion takes grids of any")

from .vtkTetFusionFilter import vtkTetFusion  # noqa: E402

__all__ = ["TetFusionError", "TetFusionWarning", "simplify", "vtkTetFusion"]

_log = logging.getLogger("vtktetfusion")

# One run at a time: who waits here lets other threads of Python go on, which the run itself does not.
_turn = threading.Lock()
_runs_here = threading.local()


def _begin_in_child():
    """A run of the parent's threads goes on there alone."""
    global _turn
    _turn = threading.Lock()


os.register_at_fork(after_in_child=_begin_in_child)

_USER_ERROR = 40000  # vtkErrorCode::UserError, which Python does not have


def simplify(grid, reduction=None, *, tets=None, max_error=None, max_rms=None, strict=None, method=None, boundary=None, feature_angle=None,
             min_quality=None, conserve=None, scalar_tolerance=None, stretch_factor=None, aspect_ratio=None, max_volume=None,
             boundary_tets_stay=None, arrays=None, regions=None, roi=None, weight=None, original_ids=None, tetrahedralize=None,
             linearize=None, drop_patches=None, drop_patch=None, threads=None, memory=None, scratch=None, chunk_tets=None, progress=None):
    """Return a grid with fewer tetrahedra than `grid`, which stays as it is. None is the default of every option.

    Of a composite data set each block for itself (blocks that touch fit afterwards with an exact boundary); one without cells that have a volume (a patch, a side set) comes back as it is. Each block must have the arrays that are named.

    @OPTIONS@
    progress: called with the share that is done, from 0 to 1; False as its answer ends the run. It cannot call simplify().
    Shares may be texts as the command takes them, "50%" or "0.5", and so may counts, "20k", and memory, "2G".
    One call runs at a time: those of other threads wait for it. What handlers of signals raise ends the run, as Ctrl-C does.

    What the command would say meanwhile goes to the logger "vtktetfusion", as info.

    Raises TetFusionError.
    """
    method = "fuse" if method is None else method
    if min_quality is not None and isinstance(method, str) and method == "tetfuse":
        values.refuse("min_quality belongs to method fuse")
    if feature_angle is not None and boundary in (None, "exact"):
        values.refuse("feature_angle is for a surface that may move: give boundary as well")
    if progress is not None and not callable(progress):
        values.refuse(f"progress: give a function that takes a share, not {progress!r}")
    grid_of_vtk = getattr(grid, "VTKObject", grid)
    if not isinstance(grid_of_vtk, vtkCommonDataModel.vtkDataObject):
        values.refuse(f"grid must be a vtkUnstructuredGrid, or what stands for one, not {type(grid).__name__}")
    run = vtkTetFusion()
    run.SetInputDataObject(grid_of_vtk)
    given = {"reduction": ("TargetReduction", values.share(reduction)), "tets": ("NumberOfTetsOutput", values.count(tets)),
             "max_error": ("MaximumError", values.share(max_error)), "max_rms": ("MaximumRMS", values.share(max_rms)),
             "feature_angle": ("FeatureAngle", values.numeric(feature_angle)),
             "min_quality": ("MinimumQuality", values.numeric(min_quality)),
             "scalar_tolerance": ("ScalarTolerance", values.share(scalar_tolerance)),
             "stretch_factor": ("StretchFactor", values.numeric(stretch_factor)),
             "aspect_ratio": ("AspectRatio", values.numeric(aspect_ratio)),
             "max_volume": ("MaximumVolume", values.numeric(max_volume)), "weight": ("WeightArrayName", weight),
             "scratch": ("ScratchDirectory", values.path(scratch)), "chunk_tets": ("ChunkTets", values.count(chunk_tets)),
             "threads": ("NumberOfThreads", values.whole(threads)), "memory": ("MemoryLimit", values.size(memory)),
             "strict": ("Strict", values.flag(strict)), "conserve": ("Conserve", values.flag(conserve)),
             "boundary_tets_stay": ("BoundaryTetsStay", values.flag(boundary_tets_stay)),
             "original_ids": ("OriginalIds", values.flag(original_ids)), "tetrahedralize": ("Tetrahedralize", values.flag(tetrahedralize)),
             "linearize": ("Linearize", values.flag(linearize)), "drop_patches": ("DropPatches", values.flag(drop_patches))}
    for option, (name, value) in given.items():
        if value is not None:
            _set(run, option, name, _no_default(name, value))
    methods = {"fuse": run.FUSE, "tetfuse": run.TETFUSE}
    run.SetMethod(methods[values.choice("method", method, methods)])
    _set_boundary(run, "exact" if boundary is None else boundary)
    _set_arrays(run, arrays)
    _set_regions(run, regions)
    for region in values.texts("roi", () if roi is None else roi, "a text, or a list of them, as in 'pressure>0.5'"):
        run.AddRegionOfInterest(_name(region))
    for patch in values.texts("drop_patch", () if drop_patch is None else drop_patch, "a text, or a list of them, as in 'patch=3'"):
        run.AddDroppedPatch(_name(patch))
    _execute(run, progress)
    return _like(grid, run.GetOutputDataObject(0))


if simplify.__doc__:  # not with -OO
    simplify.__doc__ = simplify.__doc__.replace("    @OPTIONS@\n", values.OPTIONS)


def _set(run, option, name, value):
    advice = ""
    try:
        if not isinstance(value, values.Wrong):
            if name in ("NumberOfThreads", "MemoryLimit") and value < 0:
                values.refuse(f"{option} must be at least 0")
            getattr(run, "Set" + name)(value)
            return
        value, advice = value.value, value.advice
    except (TypeError, ValueError, OverflowError):
        pass
    values.refuse(f"{option} cannot be {value!r}{advice}")


def _name(text):
    return text if text.isascii() else text.encode(errors="surrogateescape")


def _readable(value):
    return value.decode(errors="backslashreplace") if isinstance(value, bytes) else value


_ZERO_IS_DEFAULT = ("TargetReduction", "NumberOfTetsOutput", "MaximumError", "MaximumRMS", "ScalarTolerance", "StretchFactor",
                    "AspectRatio", "MaximumVolume")


def _no_default(name, value):
    """The filter takes a 0 for its default, but here the default is None: another value that means what 0 says."""
    if name not in _ZERO_IS_DEFAULT or not values.is_number(value) or value != 0:
        return value
    if name == "TargetReduction":
        return sys.float_info.min  # so small a share is no tetrahedron of any mesh
    return -1  # refused as the command refuses 0, in its words


def _set_boundary(run, boundary):
    mode, distance = values.boundary(boundary)
    run.SetBoundaryMode({"exact": run.EXACT, "planar": run.PLANAR, "within": run.WITHIN}[mode])
    if mode == "within":
        run.SetBoundaryTolerance(distance)


def _set_arrays(run, arrays):
    if arrays is None:
        return
    for name, of_cells, bound in values.steering(arrays):
        association = vtkCommonDataModel.vtkDataObject.FIELD_ASSOCIATION_CELLS if of_cells else \
            vtkCommonDataModel.vtkDataObject.FIELD_ASSOCIATION_POINTS
        run.AddSteeringArray(association, _name(name), bound or 0)


def _set_regions(run, regions):
    if regions is None:
        return
    names = values.regions(regions)
    run.SetKeepRegions(bool(names))
    for name in names:
        run.AddRegionArray(_name(name))


def _execute(run, progress):
    errors = []

    def on_error(caller, name, text="unknown error"):
        errors.append(_plain(_readable(text) or "unknown error"))
    on_error.CallDataType = "string0"
    # The executive complains, too; with an observer neither prints. What the filter has to say it keeps, as events do not come
    # where VTK's warnings are off.
    for speaker in (run, run.GetExecutive()):
        speaker.AddObserver("ErrorEvent", on_error)
        speaker.AddObserver("WarningEvent", lambda caller, name: None)
    raised = []

    def on_progress(caller, event):
        try:
            if not raised:
                signals.handle()
            answer = None if raised or progress is None else progress(caller.GetProgress())
            if answer is not None and not answer:
                caller.SetAbortExecute(1)
        except BaseException as error:  # an exception of an observer would be printed and forgotten
            raised.append(error)
            caller.SetAbortExecute(1)
    run.AddObserver("ProgressEvent", on_progress)
    if getattr(_runs_here, "any", False):
        values.refuse("progress() cannot simplify another grid meanwhile")
    with _turn, _Signals() as signals:
        _runs_here.any = True
        try:
            run.Update()
        finally:
            _runs_here.any = False
    if raised:
        raise raised[0]
    for line in _readable(run.GetNotices()).splitlines():
        _log.info(line)
    for concern in _readable(run.GetWarnings()).splitlines():
        warnings.warn(concern, TetFusionWarning, stacklevel=3)
    code = run.GetErrorCode()
    if code == 0 and not errors:
        return
    code = code - _USER_ERROR if code >= _USER_ERROR else 3
    said = _readable(run.GetErrorMessage()) or (errors or ["it was not simplified"])[0]
    raise TetFusionError(code, "the run was ended" if code == 130 else said)


class _Signals:
    """Signals during a run: noted, as VTK would print and forget what their handlers raise, and handled when the run asks next."""

    def __enter__(self):
        self._came = []
        self._handlers = {}
        if threading.current_thread() is threading.main_thread():
            found = {number: signal.getsignal(number) for number in signal.valid_signals()}
            self._handlers = {number: handler for number, handler in found.items() if callable(handler)}
        for number in self._handlers:
            signal.signal(number, self._note)
        return self

    def _note(self, number, frame):
        self._came.append((number, frame))

    def handle(self):
        """Raises what a handler raises."""
        while self._came:
            number, frame = self._came.pop(0)
            self._handlers[number](number, frame)

    def __exit__(self, *raised):
        for number, handler in self._handlers.items():
            if signal.getsignal(number) == self._note:  # and not what a handler has set
                signal.signal(number, handler)
        self.handle()


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
