#!/usr/bin/env python3
"""`tetfusion compare` against VTK's probe filter: the errors that each finds, and their processor time.

Usage: probe.py TETFUSION WORK_FOLDER [--meshes bluntfin,spx,five1m] [--reduction 80%] [--repeat 3]   (needs vtkmodules, numpy)
Simplifies each mesh, then measures the errors at its points and at the centres of its cells in turn, in fresh processes: with `compare`, which finds
gradients, integrals, surfaces and volumes beside, and with vtkProbeFilter over a vtkStaticCellLocator, which interpolates alone. VTK's points outside of
the simplified mesh take the nearest point of its surface, as compare's do. Times are processor time and, as "wall", elapsed time, reading included. Prints a Markdown table and
writes probe.csv; exit code 1 where an rms differs by more than 1 %.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import time

from measure import print_table, write_csv

TOLERANCE = 0.01
GENERATED = {"five1m": ["five", "--tets", "1M", "--jitter", "0.3"]}
BALLS = {"ball1m": "1M"}


def evaluate(original, simplified):
    """Prints what the probe filter finds, as JSON: errors by array, as shares of the range, and processor time."""
    import numpy as np
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import reference
    from vtkmodules.vtkCommonDataModel import vtkCellLocatorStrategy, vtkGenericCell, vtkStaticCellLocator
    from vtkmodules.vtkFiltersCore import vtkCellCenters, vtkProbeFilter
    from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    def read(path):
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(path)
        reader.Update()
        return reader.GetOutput()

    def values(data, name):
        array = vtk_to_numpy(data.GetArray(name)).astype(float)
        return array.reshape(len(array), -1)

    class Surface:
        """Of the simplified mesh: what lies nearest on it."""

        def __init__(self, mesh):
            outer = vtkDataSetSurfaceFilter()
            outer.SetInputData(mesh)
            outer.Update()
            self.data = outer.GetOutput()
            self.locator = vtkStaticCellLocator()
            self.locator.SetDataSet(self.data)
            self.locator.BuildLocator()

        def nearest(self, points):
            corners, weights = np.zeros((len(points), 3), int), np.zeros((len(points), 3))
            cell, place, number, sub, squared = vtkGenericCell(), [0.0] * 3, reference(0), reference(0), reference(0.0)
            for i, point in enumerate(points):
                self.locator.FindClosestPoint(point, place, cell, number, sub, squared)
                corners[i] = [cell.GetPointId(k) for k in range(3)]
                triangle = np.array([self.data.GetPoint(v) for v in corners[i]])
                weights[i] = np.linalg.lstsq(np.vstack([triangle.T, np.ones(3)]), np.append(place, 1), rcond=None)[0]
            return corners, weights

    def probe(places):
        """Values at places by array, and how many lie outside."""
        strategy = vtkCellLocatorStrategy()
        strategy.SetCellLocator(vtkStaticCellLocator())
        probing = vtkProbeFilter()
        probing.SetInputData(places)
        probing.SetSourceData(after)
        probing.SetFindCellStrategy(strategy)
        probing.Update()
        found = probing.GetOutput().GetPointData()
        outside = np.flatnonzero(vtk_to_numpy(found.GetArray("vtkValidPointMask")) == 0)
        result = {name: values(found, name) for name in names}
        if len(outside):
            surface = Surface(after)
            corners, weights = surface.nearest(np.array([places.GetPoint(i) for i in outside]))
            for name in names:
                on_surface = values(surface.data.GetPointData(), name)
                result[name][outside] = np.einsum("pk,pkc->pc", weights, on_surface[corners])
        return result, len(outside)

    start, wall = time.process_time(), time.perf_counter()
    before, after = read(original), read(simplified)
    arrays = [before.GetPointData().GetArray(i) for i in range(before.GetPointData().GetNumberOfArrays())]
    names = [a.GetName() for a in arrays if a.GetDataTypeAsString() in ("float", "double")]
    at_points, outside = probe(before)
    points_done = time.process_time()
    centres = vtkCellCenters()
    centres.SetInputData(before)
    centres.Update()
    at_centres, _ = probe(centres.GetOutput())
    cells = vtk_to_numpy(before.GetCells().GetConnectivityArray()).reshape(-1, 4)
    corners = vtk_to_numpy(before.GetPoints().GetData()).astype(float)[cells]
    volumes = np.abs(np.einsum("ij,ij->i", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]),
                               corners[:, 3] - corners[:, 0]))
    report = {"arrays": {}, "outside": outside}
    for name in names:
        old = values(before.GetPointData(), name)
        scale = np.linalg.norm(old.max(axis=0) - old.min(axis=0))
        errors = np.linalg.norm(at_points[name] - old, axis=1) / scale
        in_cells = np.linalg.norm(at_centres[name] - old[cells].mean(axis=1), axis=1) / scale
        report["arrays"][name] = {"rms": float(np.sqrt((errors ** 2).mean())), "max": float(errors.max()),
                                  "cell_rms": float(np.sqrt(np.average(in_cells ** 2, weights=volumes)))}
    report["points_seconds"] = points_done - start
    report["seconds"] = time.process_time() - start
    report["wall"] = time.perf_counter() - wall
    print(json.dumps(report))


def compare(command, original, simplified, threads):
    report = json.loads(subprocess.run([command, "compare", original, simplified, "--report", "-", "--threads", threads],
                                       check=True, capture_output=True).stdout)
    return {"arrays": {a["name"]: a for a in report["arrays"]}, "outside": report["outside_points"],
            "seconds": report["cpu_seconds"], "wall": report["seconds"]["total"]}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", metavar="TETFUSION", type=pathlib.Path)
    parser.add_argument("work", metavar="WORK_FOLDER", type=pathlib.Path, help="for meshes, results and probe.csv")
    parser.add_argument("--data", type=pathlib.Path, default="../shared/data", help="folder of real meshes; default %(default)s")
    parser.add_argument("--meshes", default="bluntfin,spx,five1m", help="default %(default)s")
    parser.add_argument("--reduction", default="80%", help="default 80%%; the best mesh where that is out of reach")
    parser.add_argument("--options", default="--regions none", help='more options for simplify; default "%(default)s"')
    parser.add_argument("--threads", default="1", help="of compare; VTK's filter uses as many as it was built for; default 1")
    parser.add_argument("--repeat", type=int, default=3)
    args = parser.parse_args()
    args.command = args.command.resolve()
    args.work.mkdir(parents=True, exist_ok=True)
    return args


def find_mesh(args, name):
    path = args.work / f"{name}.vtu"
    if name not in GENERATED and name not in BALLS:
        return args.data / f"{name}.vtu"
    if path.exists():
        return path
    if name in BALLS:
        make = [sys.executable, pathlib.Path(__file__).with_name("ball.py"), path, "--tets", BALLS[name]]
    else:
        make = [args.command, "generate", *GENERATED[name], "--quiet", "-o", path]
    subprocess.run(make, check=True)
    return path


def main():
    args = arguments()
    rows, agree = [], True
    for name in args.meshes.split(","):
        original, simplified = find_mesh(args, name), args.work / f"{name}_simplified.vtu"
        subprocess.run([args.command, "simplify", original, "-o", simplified, "--reduction", args.reduction, "--quiet",
                        *args.options.split()], check=True)
        ours, theirs = [], []
        for _ in range(args.repeat):
            ours.append(compare(args.command, original, simplified, args.threads))
            theirs.append(json.loads(subprocess.run([sys.executable, __file__, "--evaluate", original, simplified], check=True,
                                                    capture_output=True).stdout))
        seconds, vtk_seconds = (statistics.median(run["seconds"] for run in runs) for runs in (ours, theirs))
        wall, vtk_wall = (statistics.median(run["wall"] for run in runs) for runs in (ours, theirs))
        vtk_points = statistics.median(run["points_seconds"] for run in theirs)
        for array, vtk in theirs[0]["arrays"].items():
            own = ours[0]["arrays"][array]
            apart = [abs(own[key] - vtk[key]) / vtk[key] if vtk[key] > 0 else 0 for key in ("rms", "cell_rms")]
            agree &= max(apart) <= TOLERANCE
            rows.append({"mesh": name, "array": array, **{f"{who}{key} %": f"{100 * found[key]:.5g}"
                                                          for key in ("rms", "cell_rms", "max")
                                                          for who, found in (("", own), ("VTK ", vtk))},
                         "apart %": f"{100 * max(apart):.2g}", "outside": ours[0]["outside"],
                         "VTK outside": theirs[0]["outside"], "compare s": f"{seconds:.3g}",
                         "VTK s": f"{vtk_seconds:.3g}", "VTK, points alone s": f"{vtk_points:.3g}",
                         "wall s": f"{wall:.3g}", "VTK wall s": f"{vtk_wall:.3g}"})
    print_table(rows)
    write_csv(args.work / "probe.csv", rows)
    return 0 if agree else 1


if __name__ == "__main__":
    if sys.argv[1:2] == ["--evaluate"]:
        evaluate(*sys.argv[2:])
    else:
        sys.exit(main())
