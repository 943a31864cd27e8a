"""The whole run, from file to file."""
import time

from .grids import cells_of, whole_box, with_points_of
from .reading import read, with_global_ids
from .redistribution import redistribute
from .simplification import simplify, with_ghosts
from .writing import write


def work(options, ranks):
    clock = time.monotonic
    error = options.max_error if options.max_error is not None or options.reduction is not None else 0.01
    # A bound holds at the points that a pass starts from, so two of them do not add up to one at the points of the input.
    passes = 2 if ranks.count > 1 and (error is None or options.method == "tetfuse") else 1
    began = clock()
    grid = with_global_ids(read(options.input, ranks), ranks)
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
