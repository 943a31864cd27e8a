"""Simplifies a mesh on several processes, with ParaView's own engines.

    mpirun -n 4 pvbatch distributed.py in.pvtu -o out.pvtu --reduction 80%

Each process (rank) takes a part, with a layer of ghost cells round it, and simplifies it; the points that ghost cells have, too, stay
where they are, so that the parts fit at every moment. Then the mesh is cut elsewhere, and a second pass frees what the first one
had to leave at its cuts; not with --max-error, since only a single pass can keep that. The result does not depend on the order of events, but on the number of processes. Read are .vtu and .pvtu,
written a .pvtu and the folder of its pieces, with the global ids that join them. distributed.py --help lists the options.

An error on one rank is printed and ends all, with the exit code that the command tetfusion would have.
"""
import argparse
import math
import os
import pathlib
import re
import shutil
import sys
import tempfile
import time
import traceback

HERE = pathlib.Path(__file__).resolve().parent
IDS = "GlobalNodeIds"
USAGE, BAD_INPUT, IO = 2, 3, 4


class Failure(Exception):
    """What, where and what to do. `of_all`: every rank has seen it, and one is enough to say it."""

    def __init__(self, code, message, of_all=False):
        super().__init__(message)
        self.code, self.of_all = code, of_all


# ---- The command line ----

def share(text):
    """0.8 or 80%"""
    value = float(text[:-1]) / 100 if text.endswith("%") else float(text)
    if not 0 <= value < math.inf:
        raise ValueError
    return value


def byte_count(text):
    """2G, 500M, or a number of bytes"""
    units = {"K": 1 << 10, "M": 1 << 20, "G": 1 << 30, "T": 1 << 40}
    return int(float(text[:-1]) * units[text[-1]]) if text[-1:] in units else int(text)


def boundary(text):
    return text if text in ("exact", "planar") else share(text)


def parse(arguments):
    parser = argparse.ArgumentParser(prog="distributed.py", description=__doc__.partition("\n\n")[0], allow_abbrev=False)
    parser.add_argument("input", help="a .vtu or .pvtu that ParaView reads: version 5.11 on Debian 12 no appended data, of any program")
    parser.add_argument("-o", "--output", required=True, help="the .pvtu to be written; its pieces go to a folder beside it")
    parser.add_argument("--reduction", type=share, help="the share of the tetrahedra that is to go")
    parser.add_argument("--max-error", type=share, help="largest error of the steering arrays, a share of their ranges; default 1%% "
                        "where there is no goal")
    parser.add_argument("--boundary", type=boundary, default="exact", help="exact, planar, or how far it may move, a share of the "
                        "bounding box's diagonal, in both passes together")
    parser.add_argument("--array", action="append", default=[], metavar="NAME", help="steers; cell:NAME is one of the cells; again and again")
    parser.add_argument("--regions", action="append", metavar="NAME", help="cell array whose interfaces stay, or none; again and again")
    parser.add_argument("--roi", action="append", default=[], metavar="REGION", help="region where the mesh stays; again and again")
    parser.add_argument("--weight", metavar="NAME", help="point array: errors count so many times as much there, so that the mesh stays finer; "
                        "not with --method tetfuse")
    parser.add_argument("--min-quality", type=float, help="lowest mean ratio of new tetrahedra")
    parser.add_argument("--conserve", action="store_true", help="integrals of the arrays stay")
    parser.add_argument("--method", choices=("fuse", "tetfuse"), default="fuse")
    parser.add_argument("--threads", type=int, default=0, help="of each rank; default: the processors of a machine, shared among its ranks")
    parser.add_argument("--memory", type=byte_count, default=0, help="that each rank may take beside its part, as in 2G")
    parser.add_argument("--scratch", help="folder that is there, for what does not fit")
    options = parser.parse_args(arguments)
    if not options.output.endswith(".pvtu"):
        parser.error(f"the output {options.output} must be called .pvtu")
    if pathlib.Path(options.input).suffix not in (".vtu", ".pvtu"):
        parser.error(f"the input {options.input} must be a .vtu or .pvtu")
    return options


# ---- Processes ----

def tell(stream, text):
    """At once: in a source's script Python's own streams end in a buffer that os._exit() forgets."""
    os.write(stream, (text + "\n").encode())


class Ranks:
    """What the processes tell one another. Every method must be called on all of them."""

    def __init__(self):
        from paraview.modules.vtkRemotingCore import vtkProcessModule
        self.controller = vtkProcessModule.GetProcessModule().GetGlobalController()
        self.rank = self.controller.GetLocalProcessId() if self.controller else 0
        self.count = self.controller.GetNumberOfProcesses() if self.controller else 1

    def gather(self, values):
        """The numbers of all ranks, as many of each, a row a rank."""
        import numpy as np
        from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
        own = np.ascontiguousarray(values, dtype=np.float64).ravel()
        if self.count == 1:
            return own.reshape(1, -1)
        out = numpy_to_vtk(np.zeros(own.size * self.count), deep=1)
        self.controller.AllGather(numpy_to_vtk(own, deep=1), out)
        return vtk_to_numpy(out).reshape(self.count, -1).copy()

    def wait(self):
        if self.count > 1:
            self.controller.Barrier()

    def say(self, text):
        if self.rank == 0:
            tell(1, text)

    def end(self, code, message, of_all):
        """Ends this process; mpirun then ends the others."""
        if not of_all or self.rank == 0:
            where = f" on rank {self.rank}" if self.count > 1 and not of_all else ""
            tell(2, f"distributed.py: error{where}: {message}")
        if of_all:
            self.wait()
        os._exit(code)

    def threads(self):
        beside = int(os.environ.get("OMPI_COMM_WORLD_LOCAL_SIZE", self.count))
        return max(1, len(os.sched_getaffinity(0)) // beside if beside == 1 else (os.cpu_count() or 1) // beside)


# ---- Grids ----

def cells_of(grid):
    return grid.GetNumberOfCells()


def ids_of(grid):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    return vtk_to_numpy(grid.GetPointData().GetGlobalIds())


def join_by_ids(grid, anew=False):
    """The grid with one point for each global id; `anew`: a copy where it is that already."""
    import numpy as np
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkIdList, vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid
    if cells_of(grid) == 0:
        return grid
    _, first, place = np.unique(ids_of(grid), return_index=True, return_inverse=True)
    if first.size == grid.GetNumberOfPoints() and not anew:
        return grid
    out = vtkUnstructuredGrid()
    points = vtkPoints()
    points.SetData(numpy_to_vtk(vtk_to_numpy(grid.GetPoints().GetData())[first], deep=1))
    out.SetPoints(points)
    corners = place.ravel()[vtk_to_numpy(grid.GetCells().GetConnectivityArray())].astype(np.int64)
    cells = vtkCellArray()
    cells.SetData(numpy_to_vtk(vtk_to_numpy(grid.GetCells().GetOffsetsArray()).astype(np.int64), deep=1), numpy_to_vtk(corners, deep=1))
    out.SetCells(grid.GetCellTypesArray(), cells)
    kept = vtkIdList()
    kept.SetNumberOfIds(first.size)
    for to, of in enumerate(first):
        kept.SetId(to, int(of))
    out.GetPointData().CopyAllOn()
    out.GetPointData().CopyAllocate(grid.GetPointData(), first.size)
    out.GetPointData().CopyData(grid.GetPointData(), kept)
    out.GetCellData().ShallowCopy(grid.GetCellData())
    out.GetFieldData().ShallowCopy(grid.GetFieldData())
    return out


def with_vtks_id_type(grid):
    """ParaView's filters crash on global ids of another type, which is what its reader makes of 64-bit integers."""
    from vtkmodules.vtkCommonCore import vtkIdTypeArray
    data = grid.GetPointData()
    old = data.GetGlobalIds()
    if old is not None and not old.IsA("vtkIdTypeArray"):
        ids = vtkIdTypeArray()
        ids.DeepCopy(old)
        data.SetGlobalIds(ids)
    return grid


def with_points_of(grid, kind):
    """Coordinates of the type `kind`: ParaView's filters make doubles of floats, which loses nothing, nor does the way back."""
    from vtkmodules.vtkCommonCore import vtkPoints
    if grid.GetPoints() is not None and grid.GetPoints().GetDataType() != kind:
        points = vtkPoints()
        points.SetDataType(kind)
        points.DeepCopy(grid.GetPoints())
        grid.SetPoints(points)
    return grid


# ---- Reading ----

def pieces_named_in(path):
    text = path.read_text(errors="replace")
    return [path.parent / name for name in re.findall(r'<Piece\s[^>]*?Source="([^"]*)"', text)]


def head_of(path):
    """The text of a .vtu up to the data of its last piece that is not appended, as far as a scan finds it."""
    cells, appended = 0, False
    with open(path, "rb") as file:
        tail = b""
        while block := file.read(1 << 22):
            block = tail + block
            end = block.find(b"<AppendedData")
            text = block if end < 0 else block[:end]
            for match in re.finditer(rb'<Piece\s[^>]*?NumberOfCells="\s*(\d+)\s*"[^>]*>', text):
                if match.end() > len(tail):
                    cells += int(match.group(1))
            appended = appended or b'format="appended"' in text
            if end >= 0:
                break
            tail = block[-4096:]
    return cells, appended


def read(path, ranks):
    """This rank's pieces. Refuses a file of which ParaView reads less than it says that it holds."""
    from vtkmodules.vtkIOXML import vtkXMLPUnstructuredGridReader, vtkXMLUnstructuredGridReader
    path = pathlib.Path(path)
    is_parallel = path.suffix == ".pvtu"
    try:
        files = pieces_named_in(path) if is_parallel else [path]
        heads = [head_of(file) for file in files[ranks.rank::ranks.count]]
    except OSError as error:
        raise Failure(BAD_INPUT, f"{error.filename}: {error.strerror}")
    reader = vtkXMLPUnstructuredGridReader() if is_parallel else vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.UpdatePiece(ranks.rank, ranks.count, 0)
    if reader.GetErrorCode() != 0:
        raise Failure(BAD_INPUT, f"{path}: ParaView cannot read it (its error code is {reader.GetErrorCode()})")
    grid = reader.GetOutput()
    found, said, appended = ranks.gather([cells_of(grid), sum(h[0] for h in heads), sum(h[1] for h in heads)]).sum(axis=0)
    if found < said:
        why = "ParaView 5.11 on Debian 12 reads no appended data" if appended else "a piece is damaged"
        raise Failure(BAD_INPUT, f"{path}: ParaView reads {found:.0f} of {said:.0f} cells: {why}. Write the file anew with "
                      f"'tetfusion convert IN OUT --encoding inline' (a .pvtu with 'simplify --encoding inline')", of_all=True)
    if found == 0:
        raise Failure(BAD_INPUT, f"{path}: there are no cells in it", of_all=True)
    grid.RemoveGhostCells()
    for data in grid.GetPointData(), grid.GetCellData():
        data.RemoveArray("vtkGhostType")
    return grid


def with_global_ids(grid, path, ranks):
    """Points that are the same on several ranks have the same id, and one rank has them once."""
    from vtkmodules.vtkFiltersParallelDIY2 import vtkGenerateGlobalIds
    data = grid.GetPointData()
    if data.GetGlobalIds() is None and data.HasArray(IDS):
        data.SetActiveAttribute(IDS, data.GLOBALIDS)
    parts = ranks.gather([cells_of(grid), data.GetGlobalIds() is not None])
    if not parts[parts[:, 0] > 0, 1].all():
        made = vtkGenerateGlobalIds()
        made.SetInputDataObject(grid)
        made.Update()
        before, grid = grid, made.GetOutputDataObject(0)
        grid.GetCellData().RemoveArray("GlobalCellIds")
        if before.GetCellData().HasArray("GlobalCellIds"):
            grid.GetCellData().AddArray(before.GetCellData().GetAbstractArray("GlobalCellIds"))
        if cells_of(grid):
            grid.GetPointData().GetGlobalIds().SetName(IDS)
    return join_by_ids(grid, anew=True)  # ParaView's filters crash on some grids that come from its reader as they are


# ---- One pass ----

def cut(points, weights, box, count, axes, divisor):
    """Boxes for `count` ranks, with as much weight in each."""
    import numpy as np
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


def take_cells(grid, chosen):
    """The cells of a grid that a mask chooses, and their points."""
    import numpy as np
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkIdList, vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid
    sizes = np.diff(vtk_to_numpy(grid.GetCells().GetOffsetsArray()))
    used, corners = np.unique(vtk_to_numpy(grid.GetCells().GetConnectivityArray())[np.repeat(chosen, sizes)], return_inverse=True)
    offsets = np.concatenate(([0], np.cumsum(sizes[chosen])))
    out = vtkUnstructuredGrid()
    points, cells = vtkPoints(), vtkCellArray()
    points.SetData(numpy_to_vtk(vtk_to_numpy(grid.GetPoints().GetData())[used], deep=1))
    out.SetPoints(points)
    cells.SetData(numpy_to_vtk(offsets.astype(np.int64), deep=1), numpy_to_vtk(corners.ravel().astype(np.int64), deep=1))
    out.SetCells(numpy_to_vtk(vtk_to_numpy(grid.GetCellTypesArray())[chosen], deep=1), cells)
    for to, data, rows in ((out.GetPointData(), grid.GetPointData(), used), (out.GetCellData(), grid.GetCellData(), np.flatnonzero(chosen))):
        ids = vtkIdList()
        ids.SetNumberOfIds(rows.size)
        for i, row in enumerate(rows):
            ids.SetId(i, int(row))
        to.CopyAllOn()
        to.CopyAllocate(data, rows.size)
        to.CopyData(data, ids)
        for kind in range(to.NUM_ATTRIBUTES):  # legacy files would have those first
            to.SetActiveAttribute(-1, kind)
    out.GetFieldData().ShallowCopy(grid.GetFieldData())
    return out


def active_arrays(grid):
    """Which of the point arrays, and of the cell arrays, is active as what, by its place; -1: none is."""
    found = []
    for data in grid.GetPointData(), grid.GetCellData():
        arrays = [data.GetAbstractArray(i) for i in range(data.GetNumberOfArrays())]
        for kind in range(data.NUM_ATTRIBUTES):
            array = data.GetAbstractAttribute(kind)
            found.append(arrays.index(array) if array is not None else -1)
    return found


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
    import numpy as np
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid
    from vtkmodules.vtkFiltersCore import vtkAppendFilter
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


def whole_box(grid, ranks):
    own = grid.GetBounds() if cells_of(grid) else (math.inf, -math.inf) * 3
    rows = ranks.gather(own)
    return [f(rows[:, i]) for i, f in enumerate((min, max) * 3)]


def with_ghosts(grid):
    from vtkmodules.vtkFiltersParallelDIY2 import vtkGhostCellsGenerator
    run = vtkGhostCellsGenerator()
    run.SetInputDataObject(with_vtks_id_type(grid))
    run.SetBuildIfRequired(False)
    run.SetNumberOfGhostLayers(1)
    run.Update()
    return run.GetOutputDataObject(0)


def diagonal(box):
    return math.dist(box[::2], box[1::2])


def steering(grid, options):
    """What steers, as the filter would choose it."""
    if options.array:
        return options.array
    data = grid.GetPointData()
    if data.GetScalars() is not None:
        return [data.GetScalars().GetName()]
    arrays = (data.GetArray(i) for i in range(data.GetNumberOfArrays()))
    return [a.GetName() for a in arrays if a.GetDataTypeAsString() in ("float", "double")][:1]


def extent(grid, name):
    """The range of a point array, component by component: low, high, low, high, ..."""
    array = grid.GetPointData().GetArray(name)
    if array is None:
        raise Failure(USAGE, f"there is no point array {name} to steer by (name one of the cells cell:NAME)")
    return [value for c in range(array.GetNumberOfComponents()) for value in array.GetRange(c)]


def bounds_of_arrays(grid, options, error, ranks):
    """The bound of each steering array as a share of the range that it has on this rank."""
    bounds = {}
    names = steering(grid, options) if cells_of(grid) else options.array
    for name in names:
        if name.startswith("cell:"):
            bounds[name] = error  # of the range on this rank, which is none the larger
            continue
        own = extent(grid, name)
        rows = ranks.gather(own)
        whole = [f(rows[:, i]) for i, f in zip(range(len(own)), (min, max) * len(own))]
        here = diagonal(own)
        bounds[name] = error * diagonal(whole) / here if here > 0 else None
    return bounds


def simplify(grid, options, goal, error, passes, ranks, box):
    import vtktetfusion
    regions = "none" if options.regions == ["none"] else options.regions
    tets = None
    arrays = options.array or None
    if error is not None and options.method == "fuse":
        arrays = bounds_of_arrays(grid, options, error, ranks)
        if goal is None and not any(arrays.values()):
            tets = 1  # every field is constant here: as far as it goes
    surface = options.boundary
    if not isinstance(surface, str):
        surface = min(surface / passes * diagonal(box) / diagonal(grid.GetBounds()), 0.999) if cells_of(grid) else "exact"
    return vtktetfusion.simplify(
        grid, reduction=goal, tets=tets, arrays=arrays, boundary=surface, regions=regions, roi=options.roi, weight=options.weight,
        min_quality=options.min_quality, conserve=options.conserve, method=options.method, threads=options.threads or ranks.threads(),
        memory=options.memory, scratch=options.scratch)


# ---- Writing ----

def write(grid, output, ranks):
    """The pieces, in a new folder, and then the file that names them; the pieces of the old one go last."""
    from vtkmodules.vtkIOParallelXML import vtkXMLPUnstructuredGridWriter
    output = pathlib.Path(output)
    old = {file.parent for file in pieces_named_in(output)} if output.exists() else set()
    number = 1
    while (folder := output.with_name(output.stem + "_pieces" + (f"-{number}" if number > 1 else ""))).exists():
        number += 1
    ranks.wait()
    if ranks.rank == 0:
        folder.mkdir()
    ranks.wait()
    writer = vtkXMLPUnstructuredGridWriter()
    if ranks.controller:
        writer.SetController(ranks.controller)
    writer.SetInputDataObject(grid)
    writer.SetFileName(str(folder / "piece.pvtu"))
    writer.SetNumberOfPieces(ranks.count)
    writer.SetStartPiece(ranks.rank)
    writer.SetEndPiece(ranks.rank)
    writer.SetUseSubdirectory(False)
    writer.SetDataModeToBinary()
    if writer.Write() == 0 or writer.GetErrorCode() != 0:
        raise Failure(IO, f"{folder}: ParaView could not write (its error code is {writer.GetErrorCode()})")
    ranks.wait()
    if ranks.rank != 0:
        return
    summary = folder / "piece.pvtu"
    text = summary.read_text().replace('Source="', f'Source="{folder.name}/')
    handle, part = tempfile.mkstemp(dir=output.parent, prefix=f".{output.name}-")
    with os.fdopen(handle, "w") as file:
        file.write(text)
    mask = os.umask(0)
    os.umask(mask)
    os.chmod(part, 0o666 & ~mask)
    os.replace(part, output)
    summary.unlink()
    for before in old - {folder}:
        if before.parent == output.parent and before.name.startswith(output.stem + "_pieces"):
            shutil.rmtree(before, ignore_errors=True)


# ---- The whole ----

def work(options, ranks):
    clock = time.monotonic
    error = options.max_error if options.max_error is not None or options.reduction is not None else 0.01
    # A bound holds at the points that a pass starts from, so two of them do not add up to one at the points of the input.
    passes = 2 if ranks.count > 1 and (error is None or options.method == "tetfuse") else 1
    began = clock()
    grid = with_global_ids(read(options.input, ranks), options.input, ranks)
    read_seconds = clock() - began
    parts = ranks.gather(cells_of(grid)).ravel()
    at_first = parts.sum()
    left = None if options.reduction is None else (1 - options.reduction) * at_first
    ranks.say(f"read {at_first:,.0f} cells on {ranks.count} rank{'s' if ranks.count > 1 else ''} in {read_seconds:.1f} s")
    box = whole_box(grid, ranks)
    kind = int(ranks.gather(grid.GetPoints().GetDataType() if cells_of(grid) else 0).max())
    for number in range(passes):
        times = [clock()]
        if ranks.count > 1 and (number > 0 or parts.max() > 1.25 * parts.mean()):
            grid = redistribute(grid, ranks, number)
        own = cells_of(grid)
        parts = ranks.gather(own).ravel()
        times.append(clock())
        if ranks.count > 1:
            grid = with_points_of(with_ghosts(grid), kind)
        ghosts = cells_of(grid) - own
        times.append(clock())
        goal = None
        if left is not None:
            # Both passes take the same share, so that the second one still has something to do at the cuts of the first.
            goal = max(0.0, 1 - (left / parts.sum()) ** (1 / (passes - number)))
        grid = simplify(grid, options, goal, error, passes, ranks, box)
        times.append(clock())
        report_pass(number, ranks, [own, ghosts, cells_of(grid), *(b - a for a, b in zip(times, times[1:]))])
        parts = ranks.gather(cells_of(grid)).ravel()
    begin = clock()
    write(grid, options.output, ranks)
    ranks.say(f"wrote {parts.sum():,.0f} cells in {clock() - begin:.1f} s: {1 - parts.sum() / at_first:.2%} are gone, after "
              f"{clock() - began:.1f} s in all")


def report_pass(number, ranks, own):
    rows = ranks.gather(own)
    for rank, (before, ghosts, after, moved, ghosted, simplified) in enumerate(rows):
        ranks.say(f"pass {number + 1}, rank {rank}: {before:,.0f} cells (and {ghosts:,.0f} ghosts) to {after:,.0f}; "
                  f"redistribute {moved:.1f} s, ghosts {ghosted:.1f} s, simplify {simplified:.1f} s")


def run(arguments):
    """On all ranks at once."""
    if str(HERE) not in sys.path:
        sys.path.insert(0, str(HERE))
    ranks = Ranks()
    try:
        work(parse(arguments), ranks)
    except Failure as failure:
        ranks.end(failure.code, failure, failure.of_all)
    except Exception as error:
        is_ours = hasattr(error, "code")
        ranks.end(error.code if is_ours else IO, error if is_ours else traceback.format_exc(), False)


def main():
    """Started with --sym all ranks come here, else the first one, which sends the others to run()."""
    from paraview import simple  # ends the other ranks when this one ends
    from paraview.modules.vtkRemotingCore import vtkProcessModule
    parse(sys.argv[1:])
    process = vtkProcessModule.GetProcessModule()
    if process.GetNumberOfLocalPartitions() == 1 or process.GetSymmetricMPIMode():
        run(sys.argv[1:])
        return
    source = simple.ProgrammableSource(
        Script=f"import sys\nsys.path.insert(0, {str(HERE)!r})\nimport distributed\ndistributed.run({sys.argv[1:]!r})\n")
    source.UpdatePipeline()


if __name__ == "__main__":
    main()
