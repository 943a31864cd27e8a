#!/usr/bin/env python3
"""What the VTK filter takes beside its input, in bytes a tetrahedron, phase by phase.

PACKAGES holds the Python package.
"""
import argparse
import ast
import sys


def resident(line):
    with open("/proc/self/status") as status:
        return next(int(text.split()[1]) * 1024 for text in status if text.startswith(line))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("packages", metavar="PACKAGES")
    parser.add_argument("mesh", metavar="MESH")
    parser.add_argument("options", metavar="OPTION=VALUE", nargs="*", help="of vtktetfusion.simplify()")
    a = parser.parse_args()
    sys.path.insert(0, a.packages)
    import vtktetfusion
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(a.mesh)
    reader.Update()
    grid = vtktetfusion.vtkCommonDataModel.vtkUnstructuredGrid()
    grid.ShallowCopy(reader.GetOutput())
    del reader
    tets = grid.GetNumberOfCells()
    options = {name: ast.literal_eval(value) for name, _, value in (text.partition("=") for text in a.options)}
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
    print(f"peak {(resident('VmHWM:') - before) / tets:.1f} B a tetrahedron, "
          f"of which the result {out.GetActualMemorySize() * 1024 / tets:.1f}")


if __name__ == "__main__":
    main()
