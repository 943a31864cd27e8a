#!/usr/bin/env python3
"""distributed.py on one and on several processes. Usage: see paraview_case.py."""
import json
import re
import textwrap
import unittest

import numpy as np

from paraview_case import ParaViewCase, command

# Writes down what each rank has: as read, on the way to the first pass, and to the second.
SCATTER = """
import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from tetfusion_ranks import grids, ranks, reading, redistribution
own = ranks.Ranks()
def save(grid, stage):
    table, layout = {{}}, []
    if grids.cells_of(grid):
        corners = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
        points = vtk_to_numpy(grid.GetPoints().GetData())[corners]
        table = {{"ids": grids.ids_of(grid)[corners], "points": points, "place": points[:, 0].min(axis=0).round(1)}}
        for kind, data in ("point", grid.GetPointData()), ("cell", grid.GetCellData()):
            for i in range(data.GetNumberOfArrays()):
                name, values = data.GetArrayName(i), vtk_to_numpy(data.GetArray(i))
                table[kind + " " + name] = values[corners] if kind == "point" else values
                layout.append((kind, name, data.IsArrayAnAttribute(i)))
        table["layout"] = repr(layout)
    numpy.savez("{folder}/" + str(stage) + "-" + str(own.rank) + ".npz", **table)
grid = reading.with_global_ids(reading.read("{mesh}", own), own)
save(grid, 0)
for number in 0, 1:
    grid = redistribution.redistribute(grid, own, number)
    save(grid, number + 1)
"""


class Distributed(ParaViewCase):
    TETS = "200k"

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.in_pieces = cls.folder / "pieces.pvtu"
        command("simplify", cls.mesh, "-o", cls.in_pieces, "--reduction", "0", "--pieces", "3", "--encoding", "inline", "--quiet")

    def distributed(self, arguments, processes, symmetric=False, code=0):
        run = self.run_pvbatch([self.plugin / "python" / "distributed.py", *arguments], processes=processes, symmetric=symmetric, load=False)
        self.assertEqual(run.returncode, code, run.stdout)
        return run.stdout

    def on_ranks(self, text, processes, code=0):
        """What a script says that runs on all ranks at once, with the modules of distributed.py to be changed."""
        script = self.folder / "on_ranks.py"
        script.write_text(f"import sys\nsys.path.insert(0, {str(self.plugin / 'python')!r})\n" + textwrap.dedent(text))
        run = self.run_pvbatch([script], processes=processes, symmetric=True, load=False)
        self.assertEqual(run.returncode, code, run.stdout)
        return run.stdout

    def report(self, name, *arguments, code=0):
        """What check or compare say of a mesh."""
        file = self.folder / "report.json"
        command(name, *arguments, "--quiet", "--report", file, code=code)
        return json.loads(file.read_text())

    def expect_sound(self, out, original, surface_stays=True):
        """The pieces, joined by their global ids, are one mesh, with the original's boundary and arrays."""
        found, before = self.report("check", out), self.report("check", original)
        self.assertTrue(found["valid"])
        for fault in "inverted", "duplicate_tets", "nonconforming_faces", "degenerate", "nonmanifold_edges", "nonmanifold_vertices":
            self.assertEqual(found[fault], 0, fault)
        self.assertAlmostEqual(found["volume"], before["volume"], delta=1e-5)
        if surface_stays:
            self.assertEqual(found["boundary_triangles"], before["boundary_triangles"])
        compared = self.report("compare", original, out)
        self.assertEqual(compared["missing_arrays"], [])
        return found["tets"], compared

    def test_conforms_and_goes_as_far_as_the_command(self):
        command("simplify", self.mesh, "-o", self.folder / "serial.vtu", "--reduction", "80%", "--regions", "none", "--quiet")
        serial = self.report("check", self.folder / "serial.vtu")["tets"]
        before = self.report("check", self.mesh)["tets"]
        for processes, source, symmetric in (1, self.mesh, False), (2, self.mesh, False), (2, self.in_pieces, True), (4, self.in_pieces, False):
            with self.subTest(processes=processes, source=source.name):
                out = self.folder / f"out{processes}.pvtu"
                said = self.distributed([source, "-o", out, "--reduction", "80%", "--regions", "none"], processes, symmetric)
                tets, compared = self.expect_sound(out, self.mesh)
                self.assertTrue(compared["surface"]["identical"])
                self.assertLess(abs(tets - serial) / before, 0.01)
                passes = 1 if processes == 1 else 2
                lines = re.findall(r"pass \d, rank \d: .* redistribute [\d.]+ s, ghosts [\d.]+ s, simplify [\d.]+ s", said)
                self.assertEqual(len(lines), passes * processes, said)
                point_type = re.search(r"points .*\((Float\d\d)\)", command("info", out)).group(1)
                self.assertEqual(point_type, "Float32")
                self.assertRegex(command("info", out), r"temperature .*\[active Scalars\]\n +point front .*\n +point velocity .*\[active Vectors\]")

    def test_makes_global_ids_where_there_are_none(self):
        bare = self.folder / "bare.pvtu"
        for file in [self.in_pieces, *(self.folder / "pieces_pieces").iterdir()]:
            text = file.read_text().replace(' GlobalIds="GlobalNodeIds"', "").replace("GlobalNodeIds", "number")
            target = bare if file == self.in_pieces else self.folder / "bare_pieces" / file.name
            target.parent.mkdir(exist_ok=True)
            target.write_text(text.replace("pieces_pieces/", "bare_pieces/"))
        out = self.folder / "ids.pvtu"
        for processes in 1, 2, 4:
            self.distributed([bare, "-o", out, "--reduction", "70%"], processes)
            self.expect_sound(out, self.mesh)
            self.assertIn("active GlobalIds", command("info", out))
        # The pieces of the results before are gone.
        self.assertEqual(len(list(self.folder.glob("ids_pieces*"))), 1)

    def test_bounds_hold(self):
        out = self.folder / "bounded.pvtu"
        self.distributed([self.mesh, "-o", out, "--max-error", "2%", "--array", "front", "--boundary", "0.3%"], 3)
        self.expect_sound(out, self.mesh, surface_stays=False)
        self.report("compare", self.mesh, out, "--max-error", "2%", "--array", "front", "--surface", "0.3%")
        self.distributed([self.mesh, "-o", out, "--reduction", "90%", "--boundary", "0.3%", "--feature-angle", "120"], 3)
        self.report("compare", self.mesh, out, "--surface", "0.3%")

    def test_ranks_without_cells(self):
        tiny, out = self.folder / "tiny.vtu", self.folder / "tiny_out.pvtu"
        command("generate", "five", "--tets", "5", "--quiet", "-o", self.folder / "raw_tiny.vtu")
        command("convert", self.folder / "raw_tiny.vtu", tiny, "--encoding", "inline", "--quiet")
        for goal in ["--max-error", "1%"], ["--max-error", "1%", "--array", "front"], ["--reduction", "50%"], []:
            with self.subTest(goal=goal):
                said = self.distributed([tiny, "-o", out, *goal], 7)
                self.assertRegex(said, r"rank \d: 0 cells")
                self.expect_sound(out, tiny)

    def test_the_mesh_stays_finer_where_errors_count_more(self):
        late, out, text = (self.folder / name for name in ("late.vtu", "weighted.pvtu", "weighted.vtu"))
        command("generate", "five", "--tets", "60k", "--jitter", "0.5", "--time", "8", "--quiet", "-o", self.folder / "raw_late.vtu")
        command("convert", self.folder / "raw_late.vtu", late, "--encoding", "inline", "--quiet")
        heavy = []  # points where the array front is a half or more
        for weight in ([], ["--weight", "front"]):
            self.distributed([late, "-o", out, "--reduction", "60%", "--regions", "none", "--array", "temperature", *weight], 2)
            self.expect_sound(out, late)
            command("convert", out, text, "--encoding", "ascii", "--quiet")
            values = re.search(r'Name="front"[^>]*>([^<]*)<', text.read_text()).group(1)
            heavy.append(sum(value >= 0.5 for value in map(float, values.split())))
        self.assertGreater(heavy[1], 1.2 * heavy[0])
        said = self.distributed([late, "-o", out, "--reduction", "60%", "--weight", "nothing"], 2, code=2)
        self.assertIn("nothing", said)

    def test_the_second_pass_frees_the_cuts_of_the_first(self):
        """Where two ranks met in the first pass there are no more points than elsewhere: the mesh is 1 long, the cut lies across x."""
        out = self.folder / "freed.vtu"
        self.distributed([self.mesh, "-o", self.folder / "freed.pvtu", "--reduction", "80%", "--regions", "none"], 2)
        command("convert", self.folder / "freed.pvtu", out, "--encoding", "ascii", "--quiet")
        text = re.search(r'Name="Points"[^>]*>([^<]*)<', out.read_text()).group(1)
        numbers = list(map(float, text.split()))
        inside = [x for x, y, z in zip(numbers[::3], numbers[1::3], numbers[2::3]) if all(0.02 < c < 0.98 for c in (x, y, z))]
        near = max(sum(abs(x - place) < 0.02 for x in inside) for place in (0.48, 0.5, 0.52))
        self.assertLess(near, 3 * 0.04 * len(inside))

    def test_ends_where_cells_were_lost_between_ranks(self):
        """One cell on one rank, on the way to the first pass or to the second."""
        out = self.folder / "lossy.pvtu"
        for lossy in 1, 2:
            with self.subTest(lossy=lossy):
                said = self.on_ranks(f"""
                    import numpy
                    import distributed
                    from tetfusion_ranks import grids, redistribution
                    exchange, calls = redistribution.exchange, []
                    def lossy(parts, ranks):
                        got = exchange(parts, ranks)
                        calls.append(got)
                        if len(calls) == {lossy} and ranks.rank == 1:
                            got[0] = grids.take_cells(got[0], numpy.arange(grids.cells_of(got[0])) > 0)
                        return got
                    redistribution.exchange = lossy
                    distributed.run([{str(self.mesh)!r}, "-o", {str(out)!r}, "--reduction", "50%"])
                    """, 2, code=4)
                self.assertEqual(said.count("error: cells were lost on their way between the ranks"), 1, said)
                self.assertEqual(said.count("pass 1, rank"), 2 * (lossy - 1), said)
                self.assertEqual(list(self.folder.glob("lossy*")), [])

    def test_scatters_where_ranks_are_uneven_and_before_the_second_pass(self):
        pieces = {1: self.mesh, 3: self.in_pieces, 2: self.folder / "two.pvtu"}
        command("simplify", self.mesh, "-o", pieces[2], "--reduction", "0", "--pieces", "2", "--encoding", "inline", "--quiet")
        for count, goal, scattered in (
                (1, "--reduction=50%", [0, 1]), (3, "--reduction=50%", [0, 1]), (2, "--reduction=50%", [1]),
                (3, "--max-error=5%", [0]), (2, "--max-error=5%", [])):
            with self.subTest(pieces=count, goal=goal):
                said = self.on_ranks(f"""
                    import distributed
                    from tetfusion_ranks import job, ranks
                    redistribute = job.redistribute
                    def watched(grid, ranks, number):
                        ranks.say(f"scattered before pass {{number}}")
                        return redistribute(grid, ranks, number)
                    job.redistribute = watched
                    distributed.run([{str(pieces[count])!r}, "-o", {str(self.folder / "scattered.pvtu")!r}, "--array=front", {goal!r}])
                    """, 2)
                self.assertEqual(list(map(int, re.findall(r"scattered before pass (\d)", said))), scattered, said)

    def test_scattering_keeps_cells_and_arrays(self):
        """On the way to the first pass, and then to the second: the same cells with the same values, once each, cut at other places."""
        for processes in 2, 3, 4:
            with self.subTest(processes=processes):
                self.on_ranks(SCATTER.format(mesh=str(self.in_pieces), folder=str(self.folder)), processes)
                stages = [[np.load(self.folder / f"{stage}-{rank}.npz") for rank in range(processes)] for stage in range(3)]
                read, *scattered = ([rank for rank in stage if "ids" in rank.files] for stage in stages)
                before = self.joined(read)
                for ranks in scattered:
                    after = self.joined(ranks)
                    for name in before:
                        self.assertEqual(before[name].dtype, after[name].dtype, name)
                        np.testing.assert_array_equal(before[name], after[name], name)
                    for rank in ranks:
                        self.assertEqual(str(rank["layout"]), str(read[0]["layout"]))
                    sizes = [len(rank["ids"]) for rank in ranks]
                    self.assertEqual(len(sizes), processes)
                    self.assertLess(max(sizes), 1.1 * np.mean(sizes))
                self.assertNotEqual(*(sorted(tuple(rank["place"]) for rank in ranks) for ranks in scattered))

    def joined(self, ranks):
        """The cells of all ranks with their values, in the order of their corners' ids."""
        order = np.lexsort(np.concatenate([rank["ids"] for rank in ranks]).T)
        return {name: np.concatenate([rank[name] for rank in ranks])[order] for name in ranks[0].files if name not in ("layout", "place")}

    def test_is_found_however_it_is_started(self):
        script = self.plugin / "python" / "distributed.py"
        (self.folder / "link.py").symlink_to(script)
        out = self.folder / "found.pvtu"
        for start in "link.py", script.relative_to(self.folder):
            for processes, symmetric in (1, False), (2, False), (2, True):
                with self.subTest(start=start, processes=processes, symmetric=symmetric):
                    run = self.run_pvbatch([start, "no.vtu", "-o", out], processes=processes, symmetric=symmetric, load=False)
                    self.assertEqual(run.returncode, 3, run.stdout)
                    self.assertIn("no.vtu: No such file", run.stdout)

    def test_errors_end_all_processes(self):
        out = self.folder / "none.pvtu"
        for code, part, arguments in (
                (2, 'no array "cell:nothing" to steer by', [self.mesh, "-o", out, "--reduction", "50%", "--array", "cell:nothing"]),
                (2, "must be called .pvtu", [self.mesh, "-o", self.folder / "none.vtu"]),
                (3, "No such file", [self.folder / "missing.vtu", "-o", out])):
            for symmetric in False, True:
                with self.subTest(part=part, symmetric=symmetric):
                    self.assertIn(part, self.distributed(arguments, 2, symmetric, code=code))
                    self.assertFalse(out.exists())

    def test_says_when_paraview_reads_less_than_there_is(self):
        """As ParaView does with appended data where the XML library is too new for it; here the head promises a piece too many."""
        short = self.folder / "short.vtu"
        text = self.mesh.read_text()
        empty = '<Piece NumberOfPoints="0" NumberOfCells="17"/>'
        short.write_text(text.replace("</UnstructuredGrid>", empty + "</UnstructuredGrid>"))
        said = self.distributed([short, "-o", self.folder / "none.pvtu"], 2, code=3)
        self.assertRegex(said, r"ParaView reads \d+ of \d+ cells|ParaView cannot read it")
        self.assertNotIn("Traceback", said)


if __name__ == "__main__":
    unittest.main()
