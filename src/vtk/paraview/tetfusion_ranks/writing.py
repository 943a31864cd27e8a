"""From a part on each rank to a .pvtu."""
import os
import pathlib
import tempfile

from vtkmodules.vtkIOParallelXML import vtkXMLPUnstructuredGridWriter

from .failure import IO, Failure
from .piece_files import pieces_named_in, remove_pieces


def write(grid, output, ranks):
    """The pieces, in a new folder, and then the file that names them; the pieces of the old one go last."""
    output = pathlib.Path(output)
    old = pieces_named_in(output) if output.exists() else []
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
    remove_pieces(old, output, folder)
