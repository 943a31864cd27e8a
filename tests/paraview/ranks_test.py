#!/usr/bin/env python3
"""Of the run on several processes what needs no ParaView. Usage: ranks_test.py"""
import argparse
import contextlib
import io
import pathlib
import sys
import tempfile
import unittest

import numpy as np

try:
    from vtkmodules.vtkCommonCore import vtkDoubleArray, vtkIdTypeArray, vtkPoints
    from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkUnstructuredGrid
except ImportError:
    VTK_TETRA = None

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "src/vtk/paraview"))
from tetfusion_ranks import command_line, piece_files  # noqa: E402


class PieceFiles(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="tetfusion-ranks-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.output = self.folder / "out.pvtu"

    def pvtu(self, *names):
        """A file that names these, which are there."""
        for name in names:
            file = self.folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text("a piece")
        self.output.write_text("".join(f'<Piece Source="{name}"/>\n' for name in names))

    def remove(self, folder="out_pieces-2"):
        piece_files.remove_pieces(piece_files.pieces_named_in(self.output), self.output, self.folder / folder)

    def left(self):
        return sorted(str(path.relative_to(self.folder)) for path in self.folder.rglob("*"))

    def test_the_old_pieces_go_with_their_folder(self):
        self.pvtu("out_pieces/piece_0.vtu", "out_pieces/piece_1.vtu")
        self.remove()
        self.assertEqual(self.left(), ["out.pvtu"])

    def test_what_else_lies_there_stays(self):
        self.pvtu("out_pieces/piece_0.vtu", "out_pieces/piece_1.vtu")
        for name in "thesis.txt", "piece_2.vtu":
            (self.folder / "out_pieces" / name).write_text("years of work")
        self.remove()
        self.assertEqual(self.left(), ["out.pvtu", "out_pieces", "out_pieces/piece_2.vtu", "out_pieces/thesis.txt"])

    def test_pieces_elsewhere_and_new_ones_stay(self):
        names = "in.vtu", "elsewhere/piece_0.vtu", "other/out_pieces/piece_0.vtu", "out_pieces-2/piece_0.vtu"
        self.pvtu(*names)
        before = self.left()
        self.remove()
        self.assertEqual(self.left(), before)

    def test_a_piece_that_is_gone_does_not_matter(self):
        self.pvtu("out_pieces/piece_0.vtu", "out_pieces/piece_1.vtu")
        (self.folder / "out_pieces/piece_0.vtu").unlink()
        self.remove()
        self.assertEqual(self.left(), ["out.pvtu"])


class CommandLine(unittest.TestCase):
    def test_a_boundary_without_a_percent_sign_is_small(self):
        self.assertEqual(command_line.boundary("planar"), "planar")
        self.assertEqual([command_line.boundary(text) for text in ("0.09", "0.5%", "50%")], [0.09, 0.005, 0.5])
        for text, told in ("0.5", "0.5 is 50 % of the diagonal; give 0.5% or 50%"), ("0.1", "give 0.1% or 10%"):
            with self.assertRaises(argparse.ArgumentTypeError) as refused:
                command_line.boundary(text)
            self.assertIn(told, str(refused.exception))


    def test_numbers_are_those_of_the_command(self):
        def parsed(*options):
            return command_line.parse(["in.vtu", "-o", "out.pvtu", *options])
        self.assertEqual([parsed("--memory", text).memory for text in ("2G", "2g", "1.5MiB", "4096")], [2 << 30, 2 << 30, 3 << 19, 4096])
        self.assertEqual([parsed("--max-error", text).max_error for text in ("1%", "0.01", "100%")], [0.01, 0.01, 1])
        for options in ("--memory=-5", "--memory=0", "--memory=much", "--max-error=1", "--max-error=5", "--max-error=0", "--boundary=0",
                        "--boundary=200%", "--threads=-1", "--feature-angle=60", "--reduction=1"):
            with self.subTest(options), contextlib.redirect_stderr(io.StringIO()) as said, self.assertRaises(SystemExit) as ended:
                parsed(options)
            self.assertEqual(ended.exception.code, 2)
            self.assertIn(options.partition("=")[0], said.getvalue())


class OneRank:
    def agree(self, names):
        return names

    def gather(self, values):
        return np.array([values])


def tetrahedron(**arrays):
    """One, of the first four of the points that the arrays have values for."""
    grid = vtkUnstructuredGrid()
    points = vtkPoints()
    for p in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (9, 9, 9))[:len(next(iter(arrays.values())))]:
        points.InsertNextPoint(p)
    grid.SetPoints(points)
    grid.InsertNextCell(VTK_TETRA, 4, range(4))
    for name, numbers in arrays.items():
        array = vtkDoubleArray()
        array.SetName(name)
        for number in numbers:
            array.InsertNextValue(number)
        grid.GetPointData().AddArray(array)
    return grid


@unittest.skipIf(VTK_TETRA is None, "VTK for Python is not installed")
class Steering(unittest.TestCase):
    def test_the_first_array_that_varies_has_the_bound(self):
        from tetfusion_ranks.steering import bounds_of_arrays
        grid = tetrahedron(same=[1, 1, 1, 1], p=[0, 1, 2, 3], q=[0, 1, 2, 3])
        options = argparse.Namespace(array=[])
        self.assertEqual(bounds_of_arrays(grid, options, 0.01, OneRank()), {"p": 0.01})
        grid.GetPointData().SetActiveScalars("q")
        self.assertEqual(bounds_of_arrays(grid, options, 0.01, OneRank()), {"q": 0.01})
        options.array = ["same", "p"]
        self.assertEqual(bounds_of_arrays(grid, options, 0.01, OneRank()), {"same": None, "p": 0.01})

    def test_a_point_of_no_cell_widens_no_range(self):
        from tetfusion_ranks.grids import IDS, join_by_ids
        from tetfusion_ranks.steering import extent
        grid = tetrahedron(p=[0, 1, 2, 3, 1e6])
        ids = vtkIdTypeArray()
        ids.SetName(IDS)
        for id in 7, 5, 6, 9, 8:
            ids.InsertNextValue(id)
        grid.GetPointData().SetGlobalIds(ids)
        joined = join_by_ids(grid)
        self.assertEqual(joined.GetNumberOfPoints(), 4)
        self.assertEqual([joined.GetPoint(joined.GetCell(0).GetPointId(k)) for k in range(4)], [grid.GetPoint(k) for k in range(4)])
        self.assertEqual(extent(joined, "p"), [0, 3])


if __name__ == "__main__":
    unittest.main()
