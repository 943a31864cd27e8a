"""How both packages take and explain options, and what they raise: one file, which each has a copy of."""
import collections.abc
import math
import numbers
import os
import re


OPTIONS = """\
    reduction: the share of the tetrahedra that is to go, as in 0.9; of 0 the mesh stays as it is, but for the order of points and cells.
    tets: the same goal as the number that is to be left. Without a goal: as far as max_error allows.
    max_error: at no point is a steering field off by more than this share of its range, in (0, 1]; default 0.01 where nothing else limits.
    max_rms: no fusion changes a steering field by more in the mean of squares, as a share of its range, in (0, 1].
    strict: a goal that cannot be reached is an error, and not only a TetFusionWarning.
    method: "fuse", the default, or "tetfuse", the operation of the paper.
    boundary: "exact", the default, "planar", or how far it may move, as a share of the diagonal of the bounding box, as in
        0.005 or "0.5%"; from 0.1 on only with a percent sign, as "10%", since 0.5 may stand for 0.5 %.
    feature_angle: where the surface may move, edges at which it bends by so many degrees or more stay; in (0, 180]; default 40.
    min_quality: the lowest mean ratio of a new tetrahedron, in [0, 1); default 0.22.
    conserve: the integrals of all floating-point arrays stay; cells keep the values of regions.
    scalar_tolerance, stretch_factor, aspect_ratio, max_volume: bounds for each fusion; math.inf is off. A list for the first two has one
        value a round, the last one repeated (but not in vtktetfusion).
    boundary_tets_stay: with "tetfuse", no tetrahedron that touches the boundary is fused.
    arrays: what steers: a name, or a list of names, "cell:NAME" for an array of the cells, or a dict from names to the largest error
        of each, in (0, 1] (None: no other than max_error); "all": the floating-point arrays of the points that are not named besides.
        Default: the active scalars, else the first floating-point array of the points, of these the first that is not the same everywhere.
    regions: names of cell arrays of one component whose interfaces are kept, or "none"; default: those of integers named like materials,
        and ObjectId, medit:ref and tetgen:ref.
    roi: where the mesh stays as it is: a text, or a list of them, "box=X0,X1,Y0,Y1,Z0,Z1", "sphere=X,Y,Z,RADIUS" or "pressure>0.5".
    weight: the name of a point array, or "cell:NAME": errors count so many times as much there, so that the mesh stays finer.
    original_ids: the result has the point array OriginalPointIds: the number that a point which stayed has in the input, -1 of a new one.
    drop_patches: leave out cells without volume, of any type, which else hold their points where they are.
    drop_patch: leave out some of them alone: a text, or a list of them, "ARRAY=VALUE" of a cell array of numbers, as "patch=3".
    tetrahedralize, linearize: split hexahedra, voxels, wedges and pyramids; take cells of higher order, as
        ten-node tetrahedra, as straight ones.
    threads, memory, scratch: threads (0: all), bytes (0: half of the machine's), and a folder for what does not fit.
    chunk_tets: tetrahedra in each of the chunks that threads work on; the result depends on it. Default: 200000.
"""


class TetFusionError(RuntimeError):
    """A mesh was not simplified.

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


def refuse(message):
    raise TetFusionError(2, message)


def refuse_mesh(message):
    raise TetFusionError(3, f"the mesh: {message}")


def is_number(value):
    return isinstance(value, numbers.Real)


# What cannot be read as it should is a Wrong, which names the option when it is set.
class Wrong:
    def __init__(self, value, advice=""):
        self.value = value
        self.advice = advice


def _number(text):
    """As the command reads it; None of another text."""
    if re.fullmatch(r"-?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?", text) is None or math.isinf(float(text)):
        return None
    return float(text)


def numeric(value):
    """As it is, unless it is one that is hardly meant for a number."""
    return Wrong(value, ": give a number") if _is_flag(value) else value


def share(value):
    """A text such as "50%" or "0.5" as a number; all else that is no flag as it is."""
    if not isinstance(value, str):
        return numeric(value)
    found = _number(value[:-1] if value.endswith("%") else value)
    if found is None:
        return Wrong(value, ": give a share, as in 0.5 or '50%'")
    if value.endswith("%"):
        return found / 100
    return Wrong(value, ": give '100%' or '1%'") if found == 1 else found


def _scaled(value, thousand, units):
    """A text such as "2M" as a whole number, or None."""
    power = units.find(value[-1:].lower()) + 1 if value else 0
    number = _number(value[:-1] if power > 0 else value)
    if number is None or number < 0 or number * thousand ** power > 2 ** 53:
        return None
    return number * thousand ** power


def count(value):
    """A text such as "20k" as a number; all else that is whole as it is."""
    if not isinstance(value, str):
        return whole(value)
    number = _scaled(value, 1000, "kmg")
    return Wrong(value, ": give a whole number, as in '20k'") if number is None or number != int(number) else int(number)


def size(value):
    """A text such as "2G" as a number of bytes, as the command takes it; all else that is whole as it is."""
    if not isinstance(value, str):
        return whole(value)
    number = _scaled(value[:-2] if value.endswith("iB") else value, 1024, "kmgt")
    is_whole = number is not None and (value[-1].isalpha() or number == int(number))
    if not is_whole or number < 1 or (value.endswith("iB") and not value[-3:-2].isalpha()):
        return Wrong(value, ": give bytes, or a text as in '2G'")
    return int(number)


def whole(value):
    if _is_flag(value):
        return numeric(value)
    is_whole = is_number(value) and not isinstance(value, numbers.Integral) and float(value).is_integer()
    return int(value) if is_whole and abs(value) < 2 ** 63 else value


def path(value):
    text = os.fspath(value) if isinstance(value, os.PathLike) else value
    return text if text is None or isinstance(text, str) else Wrong(value, ": give the path of a folder")


def _is_flag(value):
    return type(value).__name__ in ("bool_", "bool")  # numpy's, too


def flag(value):
    if value is None:
        return None
    is_flag = isinstance(value, numbers.Integral) and value in (0, 1) or _is_flag(value)
    return bool(value) if is_flag else Wrong(value, ": give True or False")


def texts(option, value, what):
    """One text or several, as a list."""
    if isinstance(value, (str, bytes)):
        return [text(value)]
    try:
        items = list(value)
    except TypeError:
        items = [None]
    if not all(isinstance(item, (str, bytes)) for item in items):
        refuse(f"{option}: give {what}, not {value!r}")
    return [text(item) for item in items]


def text(value):
    """VTK gives, and takes, what is no UTF-8 as bytes."""
    return value.decode(errors="surrogateescape") if isinstance(value, bytes) else value


def choice(option, value, choices):
    if not isinstance(value, str) or value not in choices:
        refuse(f"{option} must be one of {', '.join(choices)}, not {value!r}")
    return value


def boundary(value):
    """"exact" or "planar", or "within" and how far."""
    if not isinstance(value, str) or value not in ("exact", "planar"):
        distance = share(value)
        if is_number(distance) and not isinstance(distance, bool):
            if 0.1 <= distance < 1 and not (isinstance(value, str) and value.endswith("%")):
                refuse(f"boundary cannot be {value!r}, which is {100 * distance:.6g} % of the diagonal: give '{distance:.6g}%' or "
                       f"'{100 * distance:.6g}%', whichever is meant")
            return "within", distance
    return choice("boundary", value, ("exact", "planar")), 0


def steering(arrays):
    """Of each array that steers its name, whether it is of the cells, and its bound or None."""
    names = texts("arrays", arrays, "a name, a list of names, or {'f': 0.01}")
    is_mapping = isinstance(arrays, collections.abc.Mapping)
    bounds = dict(zip(names, arrays.values())) if is_mapping else dict.fromkeys(names)
    found = []
    for name, given in bounds.items():
        bound = share(given)
        if bound is not None and (not is_number(bound) or isinstance(bound, bool)):
            refuse(f"arrays: the bound of {name} cannot be {given!r}{getattr(bound, 'advice', '')}")
        if bound is not None and not bound > 0:
            refuse(f"arrays: the bound of {name} must be greater than 0, a share of its range")
        found.append((name.removeprefix("cell:"), name.startswith("cell:"), bound))
    return found


def regions(value):
    """The names of cell arrays."""
    if isinstance(value, str) and value == "none":
        return []
    return [name.removeprefix("cell:") for name in texts("regions", value, "a name, a list of names, or 'none'")]
