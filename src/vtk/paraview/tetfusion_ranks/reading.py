"""From a file to a part of the mesh on each rank."""
import pathlib
import re

from vtkmodules.vtkFiltersParallelDIY2 import vtkGenerateGlobalIds
from vtkmodules.vtkIOXML import vtkXMLPUnstructuredGridReader, vtkXMLUnstructuredGridReader

from .failure import BAD_INPUT, Failure
from .grids import IDS, cells_of, join_by_ids
from .piece_files import pieces_named_in


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


def with_global_ids(grid, ranks):
    """Points that are the same on several ranks have the same id, and one rank has them once."""
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
