#!/usr/bin/env python3
"""Results in several files, as VTK's own reader sees them. Usage: pieces_test.py TETFUSION"""
import signal

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from harness import IO, USAGE, FolderTest, finish, least_memory, main, report_of, run
from sample_meshes import mesh_of_all_sorts
from tiny_vtu import TinyVtu


class Grid:
    """What VTK reads: points, cells, arrays."""

    def __init__(self, reader, path):
        errors = []
        reader.AddObserver("ErrorEvent", lambda *_: errors.append(True))
        reader.SetFileName(str(path))
        reader.Update()
        grid = reader.GetOutput()
        if errors or grid.GetNumberOfCells() == 0:
            raise AssertionError(f"VTK cannot read {path}")
        self.points = vtk_to_numpy(grid.GetPoints().GetData())
        self.types = vtk_to_numpy(grid.GetCellTypesArray())
        self.ends = vtk_to_numpy(grid.GetCells().GetOffsetsArray())[1:]
        self.corners = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
        ids = grid.GetPointData().GetGlobalIds()
        self.ids = None if ids is None else vtk_to_numpy(ids)
        self.point_data, self.cell_data, self.field_data = (self.arrays(d) for d in (
            grid.GetPointData(), grid.GetCellData(), grid.GetFieldData()))

    @staticmethod
    def arrays(data):
        arrays = (data.GetArray(i) for i in range(data.GetNumberOfArrays()))
        return {a.GetName(): vtk_to_numpy(a) for a in arrays if a}


class Pieces(FolderTest):
    def write_both(self, path, *options, pieces="5"):
        """The same result in one file and in pieces, read by VTK. Appended data is what VTK 9.1 cannot read any more."""
        one, many = self.folder / "one.vtu", self.folder / "many.pvtu"
        run("simplify", path, "-o", one, "--encoding", "inline", *options)
        run("simplify", path, "-o", many, "--encoding", "inline", "--pieces", pieces, *options)
        return Grid(vtk.vtkXMLUnstructuredGridReader(), one), Grid(vtk.vtkXMLPUnstructuredGridReader(), many)

    def expect_the_same(self, one, many):
        self.assertIsNotNone(many.ids, "no array is marked as global ids")
        count = len(one.points)
        self.assertTrue(np.array_equal(np.unique(many.ids), np.arange(count)), "points were lost or made")
        self.assertTrue(np.array_equal(many.points, one.points[many.ids]))
        for name, values in one.point_data.items():
            self.assertEqual(many.point_data[name].dtype, values.dtype)
            self.assertTrue(np.array_equal(many.point_data[name], values[many.ids], equal_nan=values.dtype.kind == "f"))
        self.assertTrue(np.array_equal(many.types, one.types))
        self.assertTrue(np.array_equal(many.ends, one.ends))
        self.assertTrue(np.array_equal(many.ids[many.corners], one.corners))
        self.assertEqual(many.cell_data.keys(), one.cell_data.keys())
        for name, values in one.cell_data.items():
            self.assertTrue(np.array_equal(many.cell_data[name], values, equal_nan=values.dtype.kind == "f"), name)
        self.assertEqual(many.field_data.keys(), one.field_data.keys())

    def pieces(self, folder="many_pieces"):
        return sorted(p.name for p in (self.folder / folder).iterdir())

    def test_vtk_reads_the_mesh_of_one_file(self):
        path = self.generate(tets="60k")
        one, many = self.write_both(path, "--reduction", "30%", "--chunk-tets", "3000")
        self.expect_the_same(one, many)
        self.assertEqual(self.pieces(), [f"many_{i}.vtu" for i in range(5)])
        # Every piece is lean and of about the same size.
        for name in self.pieces():
            piece = Grid(vtk.vtkXMLUnstructuredGridReader(), self.folder / "many_pieces" / name)
            self.assertAlmostEqual(len(piece.types), len(one.types) / 5, delta=1)
            self.assertEqual(len(np.unique(piece.ids)), len(piece.ids))
            self.assertEqual(len(np.unique(piece.corners)), len(piece.ids))
        self.assertEqual(self.files(), ["generated.vtu", "many.pvtu", "many_pieces", "one.vtu"])

    def test_cells_of_lower_dimension_are_the_last_piece(self):
        one, many = self.write_both(self.write(mesh_of_all_sorts()), "--reduction", "30%", pieces="3")
        self.expect_the_same(one, many)
        self.assertTrue((one.types != 10).any())
        last = Grid(vtk.vtkXMLUnstructuredGridReader(), self.folder / "many_pieces" / "many_3.vtu")
        self.assertTrue((last.types != 10).all())

    def test_out_of_core_the_bytes_are_the_same(self):
        path = self.generate(tets="200k")
        options = ("--reduction", "30%", "--chunk-tets", "5000", "--pieces", "4")
        run("simplify", path, "-o", self.folder / "a.pvtu", *options)
        for threads, name in ("1", "b"), ("2", "c"):
            arguments = ["simplify", path, "-o", self.folder / f"{name}.pvtu", *options, "--threads", threads]
            report = report_of(*arguments, "--memory", least_memory(*arguments))
            self.assertGreater(report["scratch_bytes"], 0)
            for i in range(4):
                self.assertEqual(self.bytes_of(name, i), self.bytes_of("a", i))

    def bytes_of(self, name, i):
        return (self.folder / f"{name}_pieces" / f"{name}_{i}.vtu").read_bytes()

    def test_our_reader_puts_them_together(self):
        path = self.generate(tets="30k")
        one, many = self.write_both(path, "--chunk-tets", "3000")
        info = report_of("info", self.folder / "many.pvtu")
        self.assertEqual(info["tets"], len(one.types))
        check = [report_of("check", self.folder / name) for name in ("one.vtu", "many.pvtu")]
        self.assertTrue(check[1]["valid"])
        self.assertAlmostEqual(check[0]["volume"], check[1]["volume"], places=12)
        for key in ("points", "tets", "boundary_triangles"):
            self.assertEqual(check[0].get(key), check[1].get(key), key)

    def test_pieces_are_simplified_without_being_read_whole(self):
        whole = self.generate(tets="200k")
        many = self.folder / "in.pvtu"
        run("simplify", whole, "-o", many, "--pieces", "6", "--reduction", "1%", "--chunk-tets", "20k")
        options = ("--reduction", "60%", "--chunk-tets", "20k")
        arguments = ["simplify", many, *options, "-o"]
        run(*arguments, self.folder / "a.vtu", "--threads", "1")
        arguments.append(self.folder / "b.vtu")
        report = report_of(*arguments, "--memory", least_memory(*arguments))
        self.assertGreater(report["scratch_bytes"], 0)
        self.assertEqual((self.folder / "a.vtu").read_bytes(), (self.folder / "b.vtu").read_bytes())
        self.assertAlmostEqual(report["reduction"], 0.6, places=3)
        self.assertTrue(report_of("check", self.folder / "b.vtu")["valid"])
        (self.folder / "in_pieces" / "in_3.vtu").unlink()
        self.assertIn("in_3.vtu", finish(*arguments).stderr.decode())

    def test_what_a_killed_run_leaves_goes_with_the_next(self):
        path, out = self.generate(tets="200k"), self.folder / "out.pvtu"
        run("simplify", path, "-o", out, "--pieces", "2")
        self.stop_when("out_pieces-2/out_5.vtu", "simplify", path, "-o", out, "--pieces", "60", "--encoding", "ascii",
                       by=signal.SIGKILL, code=-signal.SIGKILL)
        self.assertEqual(self.files(), ["generated.vtu", "out.pvtu", "out_pieces", "out_pieces-2"])
        run("simplify", path, "-o", out, "--pieces", "3")
        self.assertEqual(self.files(), ["generated.vtu", "out.pvtu", "out_pieces-2"])
        self.assertEqual(self.pieces("out_pieces-2"), [f"out_{i}.vtu" for i in range(3)])

    def test_new_pieces_replace_old_ones(self):
        path, out = self.generate(), self.folder / "out.pvtu"
        run("simplify", path, "-o", out, "--pieces", "4")
        run("simplify", path, "-o", out, "--pieces", "2")
        self.assertEqual(self.files(), ["generated.vtu", "out.pvtu", "out_pieces-2"])
        run("simplify", path, "-o", out)
        self.assertEqual(self.files(), ["generated.vtu", "out.pvtu", "out_pieces"])
        self.assertEqual(self.pieces("out_pieces"), ["out_0.vtu"])
        run("simplify", path, "-o", self.folder / "l{lod}.pvtu", "--lods", "10%,20%", "--pieces", "3")
        self.assertEqual(self.pieces("l1_pieces"), ["l1_0.vtu", "l1_1.vtu", "l1_2.vtu"])
        self.assertEqual(len(self.pieces("l2_pieces")), 3)

    def test_an_interrupted_run_leaves_the_old_pieces(self):
        path, out = self.generate(tets="200k"), self.folder / "out.pvtu"
        run("simplify", path, "-o", out, "--pieces", "2", "--encoding", "ascii")
        expected = (out.read_bytes(), (self.folder / "out_pieces" / "out_1.vtu").read_bytes())
        for written in ("", "/out_5.vtu"):
            self.stop_when("out_pieces-2" + written, "simplify", path, "-o", out, "--pieces", "60", "--encoding", "ascii")
            self.assertEqual(self.files(), ["generated.vtu", "out.pvtu", "out_pieces"])
            self.assertEqual((out.read_bytes(), (self.folder / "out_pieces" / "out_1.vtu").read_bytes()), expected)

    def test_global_ids_of_the_input_become_pedigree_ids(self):
        """Pieces are joined by numbers that are certainly different; a message and the markers say what has become of the others."""
        mesh = TinyVtu(6)
        mesh.arrays.insert(1, ["PointData", "solver_ids", "Int64", 1, [7] * len(mesh.points)])  # no ids at all
        path = self.folder / "marked.vtu"
        path.write_bytes(mesh.bytes().replace(b"<PointData>", b'<PointData GlobalIds="solver_ids">'))
        for name, told in (("many.pvtu", True), ("one.vtu", False)):
            said = finish("simplify", path, "-o", self.folder / name, "--reduction", "30%", "--encoding", "inline").stderr.decode()
            self.assertEqual("the mark GlobalIds in place of solver_ids, whose values stay (marked PedigreeIds)" in said, told, said)
        reader = vtk.vtkXMLPUnstructuredGridReader()
        reader.SetFileName(str(self.folder / "many.pvtu"))
        reader.Update()
        data = reader.GetOutput().GetPointData()
        self.assertEqual(data.GetGlobalIds().GetName(), "GlobalNodeIds")
        self.assertEqual(data.GetPedigreeIds().GetName(), "solver_ids")
        check = [report_of("check", self.folder / name) for name in ("one.vtu", "many.pvtu")]
        self.assertTrue(check[1]["valid"])
        self.assertEqual(check[0]["volume"], check[1]["volume"])
        # And once more: what was written so is read so.
        run("convert", self.folder / "many.pvtu", self.folder / "joined.vtu", "--encoding", "inline", "--quiet")
        joined = next(a for a in report_of("info", self.folder / "joined.vtu")["arrays"] if a["name"] == "solver_ids")
        self.assertEqual(joined["active"], ["PedigreeIds"])

    def test_an_empty_piece_may_come_first(self):
        path = self.generate(tets="3k")
        run("simplify", path, "-o", self.folder / "many.pvtu", "--pieces", "2", "--reduction", "30%", "--quiet")
        empty = TinyVtu()
        for array in empty.arrays:
            array[4] = []
        empty.counts = {"NumberOfPoints": "0", "NumberOfCells": "0"}
        empty.remove("temperature"), empty.remove("id")
        self.write(empty, "many_pieces/empty.vtu")
        text = (self.folder / "many.pvtu").read_text()
        at = text.index("<Piece ")
        (self.folder / "more.pvtu").write_text(text[:at] + '<Piece Source="many_pieces/empty.vtu"/>' + text[at:])
        for name in ("many", "more"):
            run("convert", self.folder / f"{name}.pvtu", self.folder / f"{name}.vtu", "--quiet")
        self.assertEqual((self.folder / "more.vtu").read_bytes(), (self.folder / "many.vtu").read_bytes())

    def test_pieces_of_the_input_are_not_written_over(self):
        path = self.generate(tets="3k")
        many = self.folder / "many.pvtu"
        run("simplify", path, "-o", many, "--pieces", "2", "--reduction", "30%", "--quiet")
        piece = self.folder / "many_pieces" / self.pieces()[0]
        before = piece.read_bytes()
        for options in (["-o", piece], ["-o", self.folder / "o.vtu", "--map", piece], ["-o", self.folder / "o.vtu", "--report", piece]):
            said = finish("simplify", many, *options, "--reduction", "10%")
            self.assertEqual(said.returncode, USAGE)
            self.assertIn("is one of the files of", said.stderr.decode())
        for command in (["info", many, "--report", piece], ["check", many, "--report", piece], ["check", many, "--fix", piece],
                        ["compare", many, many, "--report", piece], ["convert", many, piece]):
            said = finish(*command)
            self.assertEqual(said.returncode, USAGE, command)
            self.assertIn("is one of the files of", said.stderr.decode())
        self.assertEqual(piece.read_bytes(), before)

    def test_a_report_is_not_written_over_the_mesh(self):
        path = self.generate(tets="3k")
        run("convert", path, self.folder / "in.node", "--quiet")
        tetgen = self.folder / "in.ele"
        before = path.read_bytes(), tetgen.read_bytes()
        for command in (["info", path, "--report", path], ["check", path, "--report", path],
                        ["check", path, "--fix", self.folder / "o.vtu", "--report", path],
                        ["info", self.folder / "in.node", "--report", tetgen], ["check", self.folder / "in.node", "--report", tetgen],
                        ["compare", path, self.folder / "in.node", "--report", tetgen],
                        ["simplify", self.folder / "in.node", "-o", self.folder / "o.vtu", "--report", tetgen],
                        ["simplify", path, "-o", self.folder / "o.node", "--report", self.folder / "o.ele"]):
            self.assertEqual(finish(*command).returncode, USAGE, command)
        self.assertEqual((path.read_bytes(), tetgen.read_bytes()), before)

    def test_files_of_the_input_are_written_over_under_its_own_name_alone(self):
        """A mesh of TetGen is several files."""
        path = self.generate(tets="3k")
        names = [self.folder / f"{name}.node" for name in "ab"]
        for name in names:
            run("convert", path, name, "--quiet")
        before = {p: p.read_bytes() for p in self.folder.iterdir()}
        goal = ["--reduction", "20%", "--regions", "none"]
        for inputs, out, word in ((names[:1], "a.ele", "is one of the files of"), (names, "{step}.ele", "is an input of the series"),
                                  (names, "{step}.node", "is an input of the series")):
            said = finish("simplify", *inputs, "-o", self.folder / out, *goal)
            self.assertEqual(said.returncode, USAGE, said.stderr)
            self.assertIn(word, said.stderr.decode())
            self.assertEqual({p: p.read_bytes() for p in self.folder.iterdir()}, before)
        run("convert", names[0], self.folder / "c.ele", "--quiet")
        rows = [p.read_bytes().split(b"\n", 1)[1] for p in (self.folder / "c.node", names[0])]  # after the arrays' names
        self.assertEqual(rows[0], rows[1])
        run("simplify", names[0], "-o", names[0], *goal, "--quiet")
        self.assertLess(report_of("info", names[0])["tets"], report_of("info", self.folder / "c.node")["tets"])

    def test_what_is_refused(self):
        path = self.generate()
        for code, word, arguments in ((USAGE, "pvtu", ["-o", self.folder / "a.vtu", "--pieces", "2"]),
                                      (USAGE, "pvtu", ["-o", "-", "--pieces", "2"]),
                                      (USAGE, "--pieces", ["-o", self.folder / "a.pvtu", "--pieces", "0"]),
                                      (IO, "does not exist", ["-o", self.folder / "missing" / "a.pvtu"])):
            result = finish("simplify", path, *arguments)
            self.assertEqual((result.returncode, result.stdout), (code, b""), result.stderr)
            self.assertIn(word, result.stderr.decode())
        for other in (["convert", path, self.folder / "a.pvtu"], ["generate", "bcc", "--tets", "1k", "-o", self.folder / "a.pvtu"]):
            self.assertEqual(finish(*other).returncode, USAGE)
        self.assertEqual(self.files(), ["generated.vtu"])


if __name__ == "__main__":
    main()
