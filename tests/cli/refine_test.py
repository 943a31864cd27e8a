#!/usr/bin/env python3
"""simplify --progressive, and refine. Usage: refine_test.py TETFUSION"""
import pathlib

import numpy as np

from follow_test import jittered, with_arrays
from harness import (BAD, IO, MEMORY, USAGE, FolderTest, finish, least_memory, main, report_of, run, sanitized,
                     size_of)
from independent_check import Vtu
from sample_meshes import mesh_of_all_sorts
from tiny_vtu import TinyVtu

DATA = pathlib.Path(__file__).resolve().parents[3] / "shared" / "data"
WAYS = {"fuse": ["--reduction", "90%"], "chunks": ["--reduction", "90%", "--chunk-tets", "3k"],
        "moving": ["--reduction", "90%", "--boundary", "1%", "--chunk-tets", "3k"],
        "tetfuse": ["--method", "tetfuse", "--chunk-tets", "4k"]}


class Refine(FolderTest):
    def simplify(self, path, *options, name="out.vtu"):
        out, back = self.folder / name, self.folder / "run.tfp"
        run("simplify", path, "-o", out, "--progressive", back, "--quiet", *options)
        return out, back

    def assert_same(self, first, second):
        """Number by number, bit by bit."""
        a, b = Vtu(first), Vtu(second)
        self.assertEqual(a.points.tobytes(), b.points.tobytes())
        np.testing.assert_array_equal(a.tets, b.tets)
        for kind in a.arrays:
            self.assertEqual(list(a.arrays[kind]), list(b.arrays[kind]))
            for name, (_, values) in a.arrays[kind].items():
                self.assertEqual(np.asarray(values).tobytes(), np.asarray(b.arrays[kind][name][1]).tobytes(), name)

    def test_back_to_the_original(self):
        path = self.generate("--jitter", "0.5", "--shuffle", tets="30k")
        for name, options in WAYS.items():
            with self.subTest(name):
                out, back = self.simplify(path, *options)
                report = report_of("refine", back, "-o", self.folder / "full.vtu")
                self.assertEqual(report["base"]["tets"], len(Vtu(out).tets))
                self.assertEqual(report["result"], report["original"])
                self.assertEqual(report["undone"], report["fusions"])
                self.assertEqual((self.folder / "full.vtu").read_bytes(), path.read_bytes())

    def test_levels_are_valid_and_come_nearer(self):
        path = self.generate("--jitter", "0.5", tets="30k")
        _, back = self.simplify(path, "--reduction", "90%", "--chunk-tets", "6k")
        level, errors = self.folder / "level.vtu", []
        full = report_of("refine", back, "-o", level)
        base, tets = full["base"]["tets"], full["original"]["tets"]
        for i in range(11):
            goal = base + (tets - base) * i // 10
            report = report_of("refine", back, "-o", level, "--tets", goal)
            self.assertTrue(goal - 40 < report["result"]["tets"] <= goal)
            run("check", level)
            found = report_of("compare", path, level)
            errors.append(found["arrays"][0]["rms"])  # of the one that steers
        self.assertEqual(errors, sorted(errors, reverse=True))
        self.assertEqual(errors[-1], 0)
        self.assertGreater(errors[0], 0)
        half = report_of("refine", back, "-o", level, "--reduction", "50%")["result"]["tets"]
        self.assertTrue(tets / 2 - 40 < half <= tets / 2 + 1)

    def test_cells_of_lower_dimension_and_order(self):
        path = self.write(mesh_of_all_sorts())
        _, back = self.simplify(path, "--reduction", "50%")
        run("refine", back, "-o", self.folder / "full.vtu", "--quiet")
        # Those before the tetrahedra stay before them.
        self.assertEqual(Vtu(self.folder / "full.vtu").arrays["cell"]["id"][1].ravel().tolist(),
                         list(range(len(Vtu(path).arrays["cell"]["id"][1]))))
        self.assert_same(path, self.folder / "full.vtu")

    def test_other_formats_and_encodings(self):
        path = self.generate(tets="5k")
        _, back = self.simplify(path, "--reduction", "50%")
        for name, options in {"z.vtu": ["--encoding", "zlib"], "a.vtu": ["--encoding", "ascii"], "m.msh": []}.items():
            run("refine", back, "-o", self.folder / name, "--quiet", *options)
            run("convert", self.folder / name, self.folder / "plain.vtu", "--quiet")
            if name.endswith(".vtu"):
                self.assertEqual((self.folder / "plain.vtu").read_bytes(), path.read_bytes())
            else:
                np.testing.assert_array_equal(Vtu(self.folder / "plain.vtu").tets, Vtu(path).tets)
        said = finish("refine", back, "-o", self.folder / "m.mesh").stderr.decode()
        self.assertIn("front", said)  # has no place in such a file
        stdout = run("refine", back, "-o", "-")
        self.assertEqual(stdout, path.read_bytes())

    def test_messages_and_exit_codes(self):
        path = self.generate(tets="5k")
        out, back = self.simplify(path, "--reduction", "50%")
        new = self.folder / "new.vtu"
        before = out.read_bytes()
        run("refine", back, "-o", new, "--tets", "100", "--reduction", "10%", code=USAGE)
        run("refine", back, "-o", new, "--tets", "0", code=USAGE)
        run("refine", back, "-o", self.folder / "{lod}.vtu", "--tets", "100", code=USAGE)
        run("refine", back, "-o", new, "--reduction", "100%", code=USAGE)
        for option in ("--reduction", "--tets", "--max-error", "--max-rms"):  # as a script's empty variable
            run("refine", back, "-o", new, option, "", code=USAGE)
        run("refine", back, "-o", back, code=USAGE)
        run("refine", path, "-o", new, code=BAD)
        run("refine", self.folder / "none.tfp", "-o", new, code=IO)
        run("refine", back, "-o", self.folder / "no" / "where.vtu", code=IO)
        for options in (["--conserve"], ["--lods", "10%,20%"], ["--tetrahedralize"]):
            name = "l_{lod}.vtu" if "--lods" in options else "out.vtu"
            run("simplify", path, "-o", self.folder / name, "--progressive", self.folder / "2.tfp", "--reduction", "50%",
                *options, code=USAGE)
        run("simplify", path, "-o", out, "--progressive", path, "--reduction", "50%", code=USAGE)
        damaged = bytearray(back.read_bytes())
        damaged[len(damaged) // 2] ^= 1
        bad = self.folder / "bad.tfp"
        bad.write_bytes(damaged)
        run("refine", bad, "-o", new, code=BAD)
        bad.write_bytes(damaged[:-100])
        run("refine", bad, "-o", new, code=BAD)
        self.assertFalse(new.exists())
        self.assertFalse((self.folder / "2.tfp").exists())
        self.assertEqual(out.read_bytes(), before)
        said = finish("refine", back, "-o", new, "--tets", "7").stderr.decode()
        self.assertIn("no level of it has fewer", said)

    def test_the_file_is_the_same_with_less_memory_than_the_mesh(self):
        path = self.generate("--jitter", "0.5", tets="1M")
        options = ("--reduction", "80%", "--chunk-tets", "20k")
        _, back = self.simplify(path, *options)
        in_memory = back.read_bytes()
        for threads in (1, 2):
            report = report_of("simplify", path, "-o", self.folder / "out.vtu", "--progressive", back, *options, "--memory", "150M",
                               "--threads", threads)
            self.assertGreater(report["scratch_bytes"], 40e6)
            if not sanitized():
                self.assertLess(report["peak_rss_bytes"], 150 << 20)
            self.assertTrue(back.read_bytes() == in_memory)
        self.assertEqual(self.files(), [path.name, "out.vtu", "run.tfp"])

    def test_a_level_is_the_same_with_less_memory_than_the_mesh(self):
        if sanitized():
            self.skipTest("with what a sanitizer takes beside, pages would come and go all the time")
        path = self.generate("--jitter", "0.5", tets="1M")
        _, back = self.simplify(path, "--reduction", "80%", "--chunk-tets", "20k")
        level, on_disk = self.folder / "level.vtu", self.folder / "on_disk.vtu"
        for options in ([], ["--tets", "700k"], ["--reduction", "70%"], ["--max-rms", "0.1%"], ["--roi", "sphere=0.5,0.5,0.5,0.1"]):
            expected = report_of("refine", back, "-o", level, *options)
            self.assertFalse(expected["on_disk"])
            report = report_of("refine", back, "-o", on_disk, "--memory", "150M", "--scratch", self.folder, *options)
            self.assertTrue(report["on_disk"])
            if not sanitized():
                self.assertLess(report["peak_rss_bytes"], 150 << 20)
            self.assertTrue(on_disk.read_bytes() == level.read_bytes(), options)
            for name in ("result", "undone", "error"):
                self.assertEqual(report[name], expected[name])
        said = finish("refine", back, "-o", on_disk, "--memory", "128M").stderr.decode()  # as the manual says, with field data
        self.assertIn("the mesh is kept on disk, as it would take about ", said)
        said = finish("refine", back, "-o", self.folder / "none.vtu", "--memory", "100M")
        self.assertEqual(said.returncode, MEMORY)
        self.assertIn(b"give --memory 128M or more", said.stderr)
        self.assertEqual(self.files(), [path.name, "level.vtu", "on_disk.vtu", "out.vtu", "run.tfp"])

    def test_wide_rows_are_counted(self):
        mesh = jittered(14)
        wide = np.tile(np.array(mesh.points)[:, :1], 1200)
        path = self.write(with_arrays(mesh, wide=("Float64", wide), f=("Float64", wide[:, 0] ** 2)))
        _, back = self.simplify(path, "--reduction", "80%", "--array", "f")
        asked = least_memory("refine", back, "-o", self.folder / "level.vtu")
        report = report_of("refine", back, "-o", self.folder / "level.vtu", "--memory", asked)
        if not sanitized():
            self.assertLess(report["peak_rss_bytes"], size_of(asked))

    def test_a_budget_that_is_too_small_is_refused(self):
        path = self.generate(tets="400k")
        for options in (["--memory", "60M"], ["--memory", "100M", "--threads", "16"]):
            run("simplify", path, "-o", self.folder / "out.vtu", "--progressive", self.folder / "run.tfp", "--reduction", "50%",
                *options, code=MEMORY)
        self.assertEqual(self.files(), [path.name])

    def turn_cells(self, path):
        """Each third cell of a raw file wound the other way."""
        tets = np.asarray(Vtu(path).tets)
        turned = tets.copy()
        turned[::3, 2:] = tets[::3, :1:-1]
        content = path.read_bytes()
        for width in (np.int32, np.int64):
            old = tets.astype(width).tobytes()
            if content.count(old) == 1:
                path.write_bytes(content.replace(old, turned.astype(width).tobytes()))
                return
        self.fail(f"{path} is not raw")

    def test_a_run_that_was_killed_goes_on(self):
        """The bytes of both files are those of a run that was left alone."""
        path = self.generate("--jitter", "0.5", tets="400k")
        self.turn_cells(path)
        options = ("simplify", path, "-o", self.folder / "out.vtu", "--progressive", self.folder / "run.tfp", "--reduction", "80%",
                   "--chunk-tets", "20k", "--memory", "110M", "--threads", "1")
        run(*options, "--quiet")
        whole = [(self.folder / name).read_bytes() for name in ("run.tfp", "out.vtu")]
        gone_on = 0
        for phase, times in (("assembling", 1), ("assembling", 4), ("fusing", 1), ("fusing", 2), ("writing", 1)):
            (self.folder / "run.tfp").unlink()
            (self.folder / "out.vtu").unlink()
            job = self.start(*options, until=phase, times=times)
            job.kill()
            self.end(job)
            # The run went on while the kill was under way; whatever has its name is whole.
            for name, expected in zip(("run.tfp", "out.vtu"), whole):
                found = self.folder / name
                self.assertTrue(not found.exists() or found.read_bytes() == expected, (phase, times, name))
            resumed = finish(*options, "--resume")
            self.assertEqual(resumed.returncode, 0, resumed.stderr)
            gone_on += b"going on after" in resumed.stderr
            for name, expected in zip(("run.tfp", "out.vtu"), whole):
                self.assertTrue((self.folder / name).read_bytes() == expected, (phase, times, name))
            self.assertEqual(self.files(), [path.name, "out.vtu", "run.tfp"])
        self.assertGreater(gone_on, 0)

    def test_ghost_cells_are_refused(self):
        mesh = TinyVtu()
        ghosts = [0] * len(mesh.tets)
        ghosts[5] = 1
        mesh.arrays.insert(2, ["CellData", "vtkGhostType", "UInt8", 1, ghosts])
        path = self.write(mesh)
        run("simplify", path, "-o", self.folder / "out.vtu", "--progressive", self.folder / "run.tfp", "--reduction", "50%",
            code=USAGE)
        self.assertEqual(self.files(), [path.name])

    def test_the_verified_result_has_its_way_back(self):
        path = self.generate(tets="10k")
        self.simplify(path, "--reduction", "50%", "--verify", "--map", self.folder / "run.map", "--original-ids")
        self.assertEqual(self.files(), ["generated.vtu", "out.vtu", "run.map", "run.tfp"])
        run("refine", self.folder / "run.tfp", "-o", self.folder / "full.vtu", "--quiet")
        self.assertEqual((self.folder / "full.vtu").read_bytes(), path.read_bytes())

    def test_real_meshes(self):
        if not DATA.exists():
            self.skipTest("no real meshes here")
        for name in ("spx", "bluntfin"):
            path = DATA / f"{name}.vtu"
            _, back = self.simplify(path, "--reduction", "80%", "--chunk-tets", "20k")
            run("refine", back, "-o", self.folder / "full.vtu", "--quiet")
            self.assert_same(path, self.folder / "full.vtu")


if __name__ == "__main__":
    main()
