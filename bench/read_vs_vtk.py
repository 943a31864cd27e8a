#!/usr/bin/env python3
"""Reading a raw .vtu: ours and VTK's vtkXMLUnstructuredGridReader in turn, each in a fresh process, both with all arrays.

Run with the Python that has vtkmodules. The mesh is made on the first run; the page cache is warm.
"""
import argparse
import pathlib
import statistics
import subprocess
import sys

VTK = """
import sys, time
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
reader = vtkXMLUnstructuredGridReader()
reader.SetFileName(sys.argv[1])
start = time.perf_counter()
reader.Update()
print(time.perf_counter() - start)
assert reader.GetOutput().GetNumberOfCells() > 0
"""


def last_number(*command):
    return float(subprocess.run(command, capture_output=True, check=True, text=True).stdout.split()[-1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in "TETFUSION", "BENCH_READ", "WORK_FOLDER":
        parser.add_argument(name.lower(), metavar=name)
    parser.add_argument("tets", metavar="TETS", nargs="?", default="10M")
    parser.add_argument("rounds", metavar="ROUNDS", nargs="?", type=int, default=9)
    a = parser.parse_args()
    tetfusion, bench_read, work, tets, rounds = a.tetfusion, a.bench_read, a.work_folder, a.tets, a.rounds
    mesh = pathlib.Path(work) / f"read_{tets}.vtu"
    mesh.parent.mkdir(parents=True, exist_ok=True)
    if not mesh.exists():
        subprocess.run([tetfusion, "generate", "five", "--tets", tets, "-o", mesh, "--quiet"], check=True)
    readers = {"ours, 2 threads": (bench_read, mesh, "1", "2"), "ours, 1 thread": (bench_read, mesh, "1", "1"),
               "VTK": (sys.executable, "-c", VTK, mesh)}
    seconds = {name: [] for name in readers}
    for command in readers.values():
        last_number(*command)
    for _ in range(rounds):
        for name, command in readers.items():
            seconds[name].append(last_number(*command))
    print(f"{mesh.name}, {mesh.stat().st_size / 1e6:.0f} MB, {rounds} rounds\n\n| reader | best s | median s | VTK / it |")
    print("| --- | --- | --- | --- |")
    for name, times in seconds.items():
        ratio = statistics.median(v / t for v, t in zip(seconds["VTK"], times))
        print(f"| {name} | {min(times):.3f} | {statistics.median(times):.3f} | {ratio:.2f} |")


if __name__ == "__main__":
    main()
