#!/usr/bin/env python3
"""What the VTK filter takes beside its input, in bytes a tetrahedron, phase by phase.

Usage: filter_memory.py PACKAGES MESH [unset or OPTION=VALUE of vtktetfusion.simplify() ...], where PACKAGES holds the Python package.
"""
import ast
import sys

sys.path.insert(0, sys.argv[1])
import vtktetfusion  # noqa: E402
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader  # noqa: E402


def resident(line):
    with open("/proc/self/status") as status:
        return next(int(text.split()[1]) * 1024 for text in status if text.startswith(line))


def main():
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(sys.argv[2])
    reader.Update()
    grid = vtktetfusion.vtkCommonDataModel.vtkUnstructuredGrid()
    grid.ShallowCopy(reader.GetOutput())
    del reader
    tets = grid.GetNumberOfCells()
    options = {name: ast.literal_eval(value) for name, _, value in (text.partition("=") for text in sys.argv[3:])}
    with open("/proc/self/clear_refs", "w") as peak:
        peak.write("5")  # the peak begins here
    before = resident("VmRSS:")
    shares = []
    run_memory = []

    def look(share):
        shares.append(share)
        run_memory.append(resident("VmRSS:") - before)
    out = vtktetfusion.simplify(grid, progress=look, **options)
    print(f"{tets:,} tetrahedra, the grid itself {grid.GetActualMemorySize() * 1024 / tets:.1f} B each")
    for percent in range(0, 100, 5):
        seen = [m for s, m in zip(shares, run_memory) if percent <= 100 * s < percent + 5]
        if seen:
            print(f"{percent:3d} % done: at most {max(seen) / tets:.1f} B a tetrahedron")
    print(f"peak {(resident('VmHWM:') - before) / tets:.1f} B a tetrahedron, of which the result {out.GetActualMemorySize() * 1024 / tets:.1f}")


if __name__ == "__main__":
    main()
