#!/usr/bin/env python3
"""The programs of bench/, on small meshes: do they still run? Usage: bench_test.py TETFUSION BUILD PACKAGES
BUILD has the programs that they measure with, PACKAGES the Python packages; what needs VTK or numpy is skipped where it is not there."""
import importlib.util
import pathlib
import subprocess
import sys
import unittest

from harness import HERE, FolderTest, command, main

BUILD, PACKAGES = (pathlib.Path(sys.argv.pop(2)).resolve() for _ in range(2))
BENCH = HERE.parents[1] / "bench"


def needs(*modules, program=None):
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    if program and not (BUILD / program).exists():
        missing.append(program)
    return unittest.skipIf(missing, f"without {', '.join(missing)}")


class Benchmarks(FolderTest):
    def bench(self, script, *arguments):
        ended = subprocess.run([sys.executable, BENCH / f"{script}.py", *map(str, arguments)], capture_output=True, text=True,
                               timeout=280, cwd=self.folder)
        self.assertEqual(ended.returncode, 0, f"{script}: {ended.stdout}{ended.stderr}")
        return ended.stdout

    def test_layers(self):
        for options in [], ["--plate"]:
            self.bench("layers", self.folder / "layers.vtu", "--tets", "5k", *options)

    def test_big(self):
        self.bench("big", command(), self.folder, "--tets", "20k", "--cold")

    def test_bounds(self):
        self.bench("bounds", command(), self.folder, "--meshes", self.generate(), "--bounds", "1%")

    @needs("vtkmodules", program="peer_vtk")
    def test_peers(self):
        self.bench("peers", command(), BUILD / "peer_vtk", self.folder, "--meshes", self.generate(), "--match", "--repeat", 1)

    @needs("vtkmodules", "numpy")
    def test_probe(self):
        self.bench("probe", command(), self.folder, "--data", self.folder, "--meshes", self.generate().stem, "--repeat", 1,
                   "--reduction", "50%")

    def test_kill_resume(self):
        self.bench("kill_resume", command(), self.folder, "--tets", "100k", "--kills", 2)

    def test_progressive(self):
        self.bench("progressive", command(), self.folder, self.generate("--jitter", "0.3"), "--levels", 3, "--reduction", "50%")

    @needs("numpy")
    def test_roi(self):
        self.bench("roi", command(), self.folder, self.generate(), "--sphere", "0.5,0.5,0.5,0.2", "--reduction", "60%")

    def test_rates(self):
        self.bench("rates", command(), self.folder, "20k", 1)

    @needs("vtkmodules", program="bench_read")
    def test_read_vs_vtk(self):
        self.bench("read_vs_vtk", command(), BUILD / "bench_read", self.folder, "20k", 1)

    @needs("vtkmodules", program="bench_write")
    def test_writing(self):
        self.bench("writing", BUILD / "bench_write", self.generate(), "--rounds", 1, "--folder", self.folder)

    def test_scaling(self):
        self.bench("scaling", command(), self.folder, "--tets", "20k", "--repeat", 1)

    @needs(program="scrambled")
    def test_scrambled(self):
        self.bench("scrambled", BUILD / "scrambled", self.folder, "--tets", "20k", "--seeds", 1)

    @needs("numpy")
    def test_seams(self):
        self.bench("seams", command(), self.folder, "--tets", "50k")

    def test_series(self):
        self.bench("series", command(), self.folder, "--tets", "20k", "--steps", 2, "--options=--reduction 50%")

    def test_survey(self):
        self.generate()
        self.bench("survey", command(), self.folder)

    @needs("vtkmodules", "numpy")
    def test_the_filter(self):
        mesh = self.generate()
        self.bench("filter_memory", PACKAGES, mesh, "reduction=0.5")
        self.bench("abort", PACKAGES, mesh, "TargetReduction=0.5", "--moments", 1, "--limit", 60)


if __name__ == "__main__":
    main()
