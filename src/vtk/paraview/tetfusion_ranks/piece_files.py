"""The files of a .pvtu's pieces. Needs neither VTK nor ParaView."""
import re


def pieces_named_in(path):
    text = path.read_text(errors="replace")
    return [path.parent / name for name in re.findall(r'<Piece\s[^>]*?Source="([^"]*)"', text)]


def remove_pieces(pieces, output, folder):
    """Those of them that lie in another folder of pieces of `output` than this one; and what folders are empty then.

    Whatever else lies there is somebody's, and stays.
    """
    def is_old(before):
        return before != folder and before.parent == output.parent and before.name.startswith(output.stem + "_pieces")
    old = [piece for piece in pieces if is_old(piece.parent)]
    for piece in old:
        try:
            piece.unlink()
        except OSError:
            pass  # the new file is whole: a piece that stays is in nobody's way
    for before in {piece.parent for piece in old}:
        try:
            before.rmdir()
        except OSError:
            pass
