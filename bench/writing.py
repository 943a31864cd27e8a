#!/usr/bin/env python3
"""How fast compressed .vtu files are written, beside VTK's writer.

    writing.py BENCH_WRITE MESH.vtu [--rounds 5] [--folder /dev/shm]

Per encoding (zlib, lz4): wall and processor seconds and the size of the file, of VTK's writer (appended, not base64, the rest
as it is by default) and of ours on one and on two threads, of a mesh that is in memory. The folder should be there, too:
ours syncs what it writes, VTK does not. Everything takes its turn in each round, and writes four times, of which the last counts;
what is printed are medians. Needs the system's Python with VTK.
"""
import argparse
import pathlib
import statistics
import subprocess
import tempfile
import time

import vtk


def vtk_writer(grid, encoding, path):
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid)
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    (writer.SetCompressorTypeToZLib if encoding == "zlib" else writer.SetCompressorTypeToLZ4)()
    writer.SetFileName(str(path))
    return writer


def write_with_vtk(writer, path):
    for _ in range(4):
        wall, cpu = time.perf_counter(), time.process_time()
        writer.Write()
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    return wall, cpu, path.stat().st_size


def write_with_ours(program, mesh, path, encoding, threads):
    command = [program, mesh, path, encoding, "4", str(threads)]
    out = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return tuple(float(word) for word in out.split("\n")[3].split())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bench_write")
    parser.add_argument("mesh", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--folder", default="/dev/shm")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=args.folder) as folder:
        out = pathlib.Path(folder) / "out.vtu"
        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(args.mesh))
        reader.Update()
        grid = reader.GetOutput()
        print(f"{grid.GetNumberOfCells():,} cells, median of {args.rounds}\n")
        runs = {}
        for _ in range(args.rounds):
            for encoding in ("zlib", "lz4"):
                runs.setdefault((encoding, "VTK"), []).append(write_with_vtk(vtk_writer(grid, encoding, out), out))
                for threads in (1, 2):
                    runs.setdefault((encoding, f"ours, {threads}"), []).append(
                        write_with_ours(args.bench_write, args.mesh, out, encoding, threads))
        print("| encoding | writer | wall s | x VTK | cpu s | x VTK | MB | of VTK's |\n| --- | --- | --- | --- | --- | --- | --- | --- |")
        for (encoding, writer), found in runs.items():
            wall, cpu, size = (statistics.median(values) for values in zip(*found))
            base = [statistics.median(values) for values in zip(*runs[encoding, "VTK"])]
            print(f"| {encoding} | {writer} | {wall:.3f} | {base[0] / wall:.1f} | {cpu:.3f} | {base[1] / cpu:.1f} | {size / 1e6:.1f} "
                  f"| {100 * size / base[2]:.1f} % |")


if __name__ == "__main__":
    main()
