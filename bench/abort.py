#!/usr/bin/env python3
"""How long the VTK filter goes on after an observer has asked for an abort, at moments all over the run, phase by phase.

Usage: abort.py PACKAGES MESH [--moments 8] [--limit 1] [NAME=VALUE ...], where PACKAGES holds the Python package, and NAME=VALUE is a
setting of vtkTetFusion, as in TargetReduction=0.9. A whole run comes first and tells how long each phase takes; then comes one for each
moment. Prints a table; exit code 1 where an abort took longer than the limit, in seconds.
"""
import argparse
import ast
import os
import statistics
import sys
import time

from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

ABORTED = 40000 + 130  # vtkErrorCode::UserError, and the command's exit code


def read(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = vtkUnstructuredGrid()
    grid.ShallowCopy(reader.GetOutput())
    return grid


def run(filter_class, grid, settings, look):
    """A run in which `look` gets the filter and its phase at each progress event. The error code, and when the run ended."""
    tetfusion = filter_class()
    tetfusion.SetInputData(grid)
    for name, value in settings.items():
        getattr(tetfusion, "Set" + name)(value)
    tetfusion.AddObserver("ProgressEvent", lambda caller, event: look(caller, caller.GetProgressText() or "beginning"))
    tetfusion.Update()
    return tetfusion.GetErrorCode(), time.monotonic()


def whole_run(filter_class, grid, settings):
    """The phases in their order, and how long each takes."""
    begins = {}
    code, end = run(filter_class, grid, settings, lambda caller, phase: begins.setdefault(phase, time.monotonic()))
    if code != 0:
        raise SystemExit(f"the filter's error code is {code}")
    times = [*begins.values(), end]
    return {phase: b - a for phase, a, b in zip(begins, times, times[1:])}


class Stopper:
    """Asks for an abort at the first event that is `share` of the phase's `seconds` after its first one, or in a later phase."""

    def __init__(self, phases, phase, share):
        self.order = list(phases)
        self.phase, self.wait = phase, share * phases[phase]
        self.began = self.asked = self.asked_in = None

    def look(self, caller, phase):
        now = time.monotonic()
        at, wanted = self.order.index(phase), self.order.index(self.phase)
        if at == wanted and self.began is None:
            self.began = now
        if self.asked is None and (at > wanted or at == wanted and now >= self.began + self.wait):
            self.asked_in = phase
            caller.SetAbortExecute(1)
            self.asked = time.monotonic()


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("packages")
    parser.add_argument("mesh")
    parser.add_argument("settings", nargs="*", metavar="NAME=VALUE")
    parser.add_argument("--moments", type=int, default=8, help="in each phase")
    parser.add_argument("--limit", type=float, default=1)
    options = parser.parse_intermixed_args()
    sys.path.insert(0, options.packages)
    from vtktetfusion import vtkTetFusion
    settings = {name: ast.literal_eval(value) for name, _, value in (text.partition("=") for text in options.settings)}
    grid = read(options.mesh)
    phases = whole_run(vtkTetFusion, grid, settings)
    print(f"{grid.GetNumberOfCells():,} tetrahedra, {' '.join(options.settings)}, a load of {os.getloadavg()[0]:.0f}: "
          f"{sum(phases.values()):.1f} s", flush=True)
    took = {phase: [] for phase in phases}
    for phase in phases:
        for moment in range(options.moments):
            stopper = Stopper(phases, phase, moment / options.moments)
            code, end = run(vtkTetFusion, grid, settings, stopper.look)
            if code == ABORTED:
                took[stopper.asked_in].append(end - stopper.asked)
    print("| phase | s | aborts | median s | worst s |\n| --- | ---: | ---: | ---: | ---: |")
    for phase, seconds in took.items():
        if seconds:
            print(f"| {phase} | {phases[phase]:.1f} | {len(seconds)} | {statistics.median(seconds):.3f} | {max(seconds):.3f} |")
    worst = max(max(seconds) for seconds in took.values() if seconds)
    print(f"worst {worst:.3f} s; a load of {os.getloadavg()[0]:.0f}")
    sys.exit(worst > options.limit)


if __name__ == "__main__":
    main()
