"""The options of distributed.py."""
import argparse
import math
import pathlib


def share(text):
    """0.8 or 80%"""
    value = float(text[:-1]) / 100 if text.endswith("%") else float(text)
    if not 0 <= value < math.inf:
        raise ValueError
    return value


def share_of_range(text):
    """0.01 or 1%"""
    value = share(text)
    if value == 1 and not text.endswith("%"):
        raise argparse.ArgumentTypeError("give 100% or 1%, whichever is meant by 1")
    if not 0 < value <= 1:
        raise ValueError
    return value


def byte_count(text):
    """2G, 500MiB, or a number of bytes"""
    number = text.removesuffix("iB")
    power = "kmgt".find(number[-1:].lower()) + 1 if number else 0
    count = int(float(number[:-1]) * 1024 ** power) if power else int(text)
    if count < 1:
        raise ValueError
    return count


def thread_count(text):
    if int(text) < 0:
        raise ValueError
    return int(text)


def boundary(text):
    if text in ("exact", "planar"):
        return text
    distance = share(text)
    if not 0 < distance < 1:
        raise ValueError
    if distance >= 0.1 and not text.endswith("%"):  # as the command and the filter's package do
        raise argparse.ArgumentTypeError(f"{text} is {100 * distance:.6g} % of the diagonal; give {text}% or {100 * distance:.6g}%, "
                                         "whichever is meant")
    return distance


def parse(arguments):
    parser = argparse.ArgumentParser(prog="distributed.py", allow_abbrev=False,
                                     description="Simplifies a mesh on several processes, with ParaView's own engines.")
    parser.add_argument("input", help="a .vtu or .pvtu that ParaView reads: version 5.11 on Debian 12 no appended data, of any program")
    parser.add_argument("-o", "--output", required=True, help="the .pvtu to be written; its pieces go to a folder beside it")
    parser.add_argument("--reduction", type=share, help="the share of the tetrahedra that is to go")
    parser.add_argument("--max-error", type=share_of_range, help="largest error of the steering arrays, a share of their ranges; default 1%% "
                        "where there is no goal")
    parser.add_argument("--boundary", type=boundary, default="exact", help="exact, planar, or how far it may move, a share of the "
                        "bounding box's diagonal, in both passes together")
    parser.add_argument("--feature-angle", type=float, help="edges at which a surface that may move bends by so many degrees or more stay")
    parser.add_argument("--array", action="append", default=[], metavar="NAME", help="steers; cell:NAME is one of the cells; again and again")
    parser.add_argument("--regions", action="append", metavar="NAME", help="cell array whose interfaces stay, or none; again and again")
    parser.add_argument("--roi", action="append", default=[], metavar="REGION", help="region where the mesh stays; again and again")
    parser.add_argument("--weight", metavar="NAME", help="point array, or cell:NAME: errors count so many times as much there, so that the mesh "
                        "stays finer; not with --method tetfuse")
    parser.add_argument("--min-quality", type=float, help="lowest mean ratio of new tetrahedra")
    parser.add_argument("--conserve", action="store_true", help="integrals of the arrays stay")
    parser.add_argument("--method", choices=("fuse", "tetfuse"), default="fuse")
    parser.add_argument("--threads", type=thread_count, default=0, help="of each rank; default: the processors of a machine, shared among its ranks")
    parser.add_argument("--memory", type=byte_count, default=0, help="that each rank may take beside its part, as in 2G")
    parser.add_argument("--scratch", help="folder that is there, for what does not fit")
    options = parser.parse_args(arguments)
    if options.reduction is not None and options.reduction >= 1:
        parser.error("--reduction must be less than 100%, as in 80% or 0.8")
    if options.min_quality is not None and options.method == "tetfuse":
        parser.error("--min-quality belongs to --method fuse")
    if options.feature_angle is not None and options.boundary == "exact":
        parser.error("--feature-angle is for a surface that may move: give --boundary as well")
    if not options.output.endswith(".pvtu"):
        parser.error(f"the output {options.output} must be called .pvtu")
    if pathlib.Path(options.input).suffix not in (".vtu", ".pvtu"):
        parser.error(f"the input {options.input} must be a .vtu or .pvtu")
    return options
