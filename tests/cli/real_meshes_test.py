#!/usr/bin/env python3
"""The main job on real meshes, from file to file. Every result is judged by independent_check.py, which shares no code with
the project, and by `tetfusion check`. Usage: real_meshes_test.py TETFUSION DATA_FOLDER
Without the data folder the tests are skipped."""
import hashlib
import pathlib
import subprocess
import sys

from harness import FolderTest, finish, main, report_of, run

DATA = None
CHECKER = pathlib.Path(__file__).parent.parent / "support" / "independent_check.py"
# name, least reduction in percent with the rules vertices and tets, stretch 5, tolerance off
MESHES = {"spx": (25, 5), "bluntfin": (40, 30), "quake_sf10": (20, 5), "disk_out_ref": (25, 10), "can": (1, 0),
          "polyfem_cubes": (5, 0), "pylith_crustal": (10, 0)}


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


class RealMeshes(FolderTest):
    def setUp(self):
        if not DATA.is_dir():
            self.skipTest(f"{DATA} is not there")
        super().setUp()

    def check_result(self, mesh, out):
        judged = subprocess.run([sys.executable, CHECKER, mesh, out], capture_output=True)
        self.assertEqual(judged.returncode, 0, judged.stdout.decode() + judged.stderr.decode())

    def simplify(self, mesh, *options):
        out = self.folder / f"{mesh.stem}_small.vtu"
        return out, report_of("simplify", mesh, "-o", out, "--method", "tetfuse", "--quiet", *options)

    def test_every_mesh_under_both_rules(self):
        for name, least in MESHES.items():
            mesh = DATA / f"{name}.vtu"
            before = report_of("check", mesh, "--quiet", code=1 if name == "can" else 0)
            for rule, reduction in zip(("vertices", "tets"), least):
                with self.subTest(mesh=name, rule=rule):
                    out, report = self.simplify(mesh, "--boundary-rule", rule, "--scalar-tolerance", "off")
                    self.assertGreaterEqual(100 * report["reduction"], reduction)
                    self.check_result(mesh, out)
                    after = report_of("check", out, "--quiet", code=1 if name == "can" else 0)
                    self.assertEqual(after["boundary_triangles"], before["boundary_triangles"])
                    self.assertLessEqual(abs(after["volume"] / before["volume"] - 1), 1e-12)
                    for count in ("inverted", "degenerate", "duplicate_tets", "nonconforming_faces", "nonmanifold_edges"):
                        self.assertLessEqual(after[count], before[count], count)
                    self.assertEqual(report["output"]["tets"], after["tets"])
                    self.assertEqual(report["output"]["boundary_triangles"], after["boundary_triangles"])

    def test_known_facts(self):
        can = report_of("check", DATA / "can.vtu", "--quiet", code=1)
        self.assertEqual((can["inverted"], can["foldover_faces"]), (77, 161))
        fin = report_of("check", DATA / "bluntfin.vtu", "--quiet")
        self.assertEqual((fin["degenerate"], fin["tets"], fin["points"]), (77, 187395, 40960))
        run("check", DATA / "bluntfin.vtu", "--quiet", "--strict", code=1)

    def test_a_goal_is_met_from_above(self):
        out, report = self.simplify(DATA / "bluntfin.vtu", "--reduction", "30%", "--scalar-tolerance", "off")
        goal = 187395 * 0.7
        self.assertEqual(report["stop_reason"], "goal")
        self.assertTrue(goal <= report["output"]["tets"] < goal + 60, report["output"]["tets"])
        self.check_result(DATA / "bluntfin.vtu", out)
        out, report = self.simplify(DATA / "bluntfin.vtu", "--tets", "150k")
        self.assertTrue(150000 <= report["output"]["tets"] < 150060)

    # Points that come to lie outside are within the bound, too, at the nearest point of the surface.
    def test_a_bound_holds_where_the_boundary_moves(self):
        outside = 0
        for name, array, error, distance in (("spx", "scalars", "1%", "0.5%"), ("disk_out_ref", "Temp", "5%", "2%"),
                                             ("bluntfin", "Density", "1%", "0.5%")):
            mesh, out = DATA / f"{name}.vtu", self.folder / "out.vtu"
            with self.subTest(mesh=name):
                run("simplify", mesh, "-o", out, "--array", array, "--max-error", error, "--boundary", distance, "--quiet")
                outside += report_of("compare", mesh, out, "--array", array, "--max-error", error, "--quiet")["outside_points"]
        self.assertGreater(outside, 500)

    def test_thin_walls_are_simplified_too(self):
        for name, reduction, distance, most in (("spx", "80%", "1%", 2600), ("can", "90%", "0.5%", 9500)):
            mesh, out = DATA / f"{name}.vtu", self.folder / "out.vtu"
            with self.subTest(mesh=name):
                report = report_of("simplify", mesh, "-o", out, "--reduction", reduction, "--boundary", distance, "--verify", "--quiet")
                self.assertLessEqual(report["output"]["tets"], most)
                run("compare", mesh, out, "--surface", distance, "--quiet")

    def test_a_goal_out_of_reach(self):
        mesh, out = DATA / "spx.vtu", self.folder / "out.vtu"
        run("simplify", mesh, "-o", out, "--reduction", "95%", "--quiet")
        self.assertTrue(out.exists())
        out.unlink()
        self.assertEqual(finish("simplify", mesh, "-o", out, "--reduction", "95%", "--quiet", "--strict").returncode, 6)
        self.assertTrue(out.exists())

    def test_levels(self):
        outputs = report_of("simplify", DATA / "bluntfin.vtu", "-o", self.folder / "lod_{lod}.vtu", "--lods", "10%,20%,30%",
                            "--quiet")["outputs"]
        self.assertEqual([pathlib.Path(o).name for o in outputs], ["lod_1.vtu", "lod_2.vtu", "lod_3.vtu"])
        for level, output in enumerate(outputs, 1):
            self.check_result(DATA / "bluntfin.vtu", pathlib.Path(output))
            tets = report_of("check", output, "--quiet")["tets"]
            goal = 187395 * (1 - 0.1 * level)
            self.assertTrue(goal - 1 <= tets < goal + 60, (level, tets))

    def test_the_bytes_do_not_depend_on_threads(self):
        for name, chunk_tets in (("bluntfin", 200000), ("bluntfin", 20000), ("disk_out_ref", 3000)):
            digests = set()
            for threads in (1, 2, 3):
                out, report = self.simplify(DATA / f"{name}.vtu", "--threads", threads, "--chunk-tets", chunk_tets)
                digests.add(digest(out))
                self.check_result(DATA / f"{name}.vtu", out)
            self.assertEqual(len(digests), 1)
            self.assertEqual(report["chunks"], -(-report["input"]["tets"] // chunk_tets))

    def test_every_encoding_holds_the_same_mesh(self):
        mesh = DATA / "disk_out_ref.vtu"
        expected, _ = self.simplify(mesh)
        expected = digest(expected)
        for encoding in ("raw", "zlib", "lz4", "inline", "ascii"):
            converted = self.folder / f"{encoding}.vtu"
            run("convert", mesh, converted, "--encoding", encoding, "--quiet")
            out, _ = self.simplify(converted)
            self.assertEqual(digest(out), expected, encoding)

    def test_pipes(self):
        mesh = (DATA / "spx.vtu").read_bytes()
        piped = finish("simplify", "-", "-o", "-", "--method", "tetfuse", "--quiet", input=mesh)
        out, _ = self.simplify(DATA / "spx.vtu")
        self.assertEqual(hashlib.sha256(piped.stdout).hexdigest(), digest(out))
        self.assertEqual(piped.stderr, b"")

    def test_the_input_may_be_the_output(self):
        mesh = self.folder / "mesh.vtu"
        mesh.write_bytes((DATA / "spx.vtu").read_bytes())
        run("simplify", mesh, "-o", mesh, "--quiet")
        self.check_result(DATA / "spx.vtu", mesh)
        self.assertLess(mesh.stat().st_size, (DATA / "spx.vtu").stat().st_size)

    def test_the_schedule_of_the_paper(self):
        mesh = DATA / "bluntfin.vtu"
        _, tight = self.simplify(mesh, "--scalar-tolerance", "0.01")
        _, schedule = self.simplify(mesh, "--scalar-tolerance", "1%,2%,5%", "--stretch-factor", "3,4,5")
        used = [(l["scalar_tolerance"], l["stretch_factor"]) for l in schedule["lods"][:4]]
        self.assertEqual(used, [(0.01, 3), (0.02, 4), (0.05, 5), (0.05, 5)])
        self.assertGreater(schedule["reduction"], tight["reduction"])

    def test_materials_keep_their_volume(self):
        sys.path.insert(0, str(CHECKER.parent.parent.parent / "bench"))
        import numpy as np
        import raw_vtu

        def volumes(path):
            mesh = raw_vtu.read(path)
            p = mesh.points[mesh.tets].astype("f8")
            volume = abs(np.einsum("ij,ij->i", np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), p[:, 3] - p[:, 0])) / 6
            region = mesh.cell_data["physical"]
            return {int(r): volume[region == r].sum() for r in np.unique(region)}

        for name in ("polyfem_cubes", "pylith_crustal"):
            out, report = self.simplify(DATA / f"{name}.vtu")
            self.assertEqual(report["regions"], ["physical"])
            before, after = volumes(DATA / f"{name}.vtu"), volumes(out)
            self.assertEqual(before.keys(), after.keys())
            for region, volume in before.items():
                self.assertAlmostEqual(after[region] / volume, 1, delta=1e-12)

    def test_compare_against_looking_at_every_cell(self):
        sys.path.insert(0, str(CHECKER.parent.parent.parent / "bench"))
        import numpy as np
        import raw_vtu

        def errors(original, simplified, name):
            """Of the simplified mesh's interpolant at the original's points, one an entry."""
            values, corners = simplified.point_data[name], simplified.points[simplified.tets].astype("f8")
            inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))
            found = []
            for p, value in zip(original.points.astype("f8"), original.point_data[name]):
                w = np.einsum("ijk,ik->ij", inverse, p - corners[:, 0])
                w = np.column_stack([1 - w.sum(axis=1), w])
                best = w.min(axis=1).argmax()
                self.assertGreater(w[best].min(), -1e-5)
                found.append(w[best] @ values[simplified.tets[best]] - value)
            return np.linalg.norm(np.reshape(found, (len(found), -1)), axis=1)

        for name, array in (("spx", "scalars"), ("disk_out_ref", "V")):
            out, _ = self.simplify(DATA / f"{name}.vtu", "--scalar-tolerance", "5%")
            report = report_of("compare", DATA / f"{name}.vtu", out)
            self.assertEqual((report["surface"]["identical"], report["outside_points"]), (True, 0))
            found = next(a for a in report["arrays"] if a["name"] == array)
            original = raw_vtu.read(DATA / f"{name}.vtu")
            error = errors(original, raw_vtu.read(out), array)
            values = np.reshape(original.point_data[array], (len(error), -1)).astype("f8")
            scale = np.linalg.norm(values.max(axis=0) - values.min(axis=0))
            self.assertAlmostEqual(found["range"] / scale, 1, places=12)
            self.assertAlmostEqual(found["max"], error.max() / scale, places=6)
            self.assertAlmostEqual(found["rms"], np.sqrt((error**2).mean()) / scale, places=6)

    def test_compare_every_mesh_with_itself_and_its_result(self):
        for name in MESHES:
            with self.subTest(mesh=name):
                mesh = DATA / f"{name}.vtu"
                same = report_of("compare", mesh, mesh, "--max-error", "0", "--surface", "0")
                self.assertEqual((same["outside_points"], same["volume_change"]), (0, 0))
                out, _ = self.simplify(mesh)
                report = report_of("compare", mesh, out, "--surface", "0")
                self.assertTrue(report["surface"]["identical"])
                self.assertEqual((report["outside_points"], report["missing_arrays"], report["retyped_arrays"]), (0, [], []))
                self.assertLess(abs(report["volume_change"]), 1e-12)
                for array in report["arrays"]:
                    for region in array.get("regions", []):
                        self.assertAlmostEqual(region["simplified"] / region["original"], 1, delta=1e-12)


if __name__ == "__main__":
    DATA = pathlib.Path(sys.argv.pop(2))
    main()
