#!/usr/bin/env python3
"""simplify --original-ids and --map, and apply. Usage: follow_test.py TETFUSION"""
import itertools
import struct

import numpy as np

from harness import BAD, IO, MEMORY, USAGE, FolderTest, finish, least_memory, main, report_of, run, sanitized
from independent_check import Vtu
from sample_meshes import mesh_of_all_sorts, rebuilt
from tiny_vtu import TinyVtu

METHODS = {"fuse": ["--reduction", "70%"], "planar": ["--reduction", "80%", "--boundary", "planar"],
           "bound": ["--max-error", "2%"], "tetfuse": ["--method", "tetfuse"]}


def values(mesh, name):
    return np.squeeze(mesh.arrays["point"][name][1])


class OriginalIds(FolderTest):
    def simplify(self, path, *options, name="out.vtu"):
        out = self.folder / name
        run("simplify", path, "-o", out, "--quiet", *options)
        return out

    def test_points_that_stayed_are_those_of_the_input(self):
        path = self.generate("--jitter", "0.5", "--shuffle", tets="30k")
        original = Vtu(path)
        value = next(iter(original.arrays["point"]))
        for name, options in METHODS.items():
            with self.subTest(name):
                result = Vtu(self.simplify(path, "--original-ids", "--chunk-tets", "6k", *options))
                ids = values(result, "OriginalPointIds")
                stayed = ids >= 0
                self.assertEqual(len(np.unique(ids[stayed])), stayed.sum())
                np.testing.assert_array_equal(result.points[stayed], original.points[ids[stayed]])
                np.testing.assert_array_equal(values(result, value)[stayed], values(original, value)[ids[stayed]])
                # The others lie where no point of the input was.
                places = {tuple(p) for p in original.points.tolist()}
                new = [tuple(p) in places for p in result.points[~stayed].tolist()]
                self.assertGreater(len(new), 20)
                self.assertLess(sum(new), 0.01 * len(new))

    def test_the_rest_of_the_result_is_the_same(self):
        path = self.generate("--jitter", "0.5", tets="30k")
        options = ["--reduction", "60%", "--chunk-tets", "6k"]
        plain = Vtu(self.simplify(path, *options))
        first = self.simplify(path, "--original-ids", *options)
        ids = Vtu(first)
        self.assertEqual(set(ids.arrays["point"]) - set(plain.arrays["point"]), {"OriginalPointIds"})
        np.testing.assert_array_equal(ids.points, plain.points)
        np.testing.assert_array_equal(ids.tets, plain.tets)
        for threads, memory in itertools.product("12", ("100M", "1G")):
            again = self.simplify(path, "--original-ids", "--threads", threads, "--memory", memory, *options, name="2.vtu")
            self.assertEqual(again.read_bytes(), first.read_bytes())

    def test_cells_of_lower_dimension_keep_their_points(self):
        path = self.write(mesh_of_all_sorts())
        for out in ("out.vtu", "out.pvtu"):
            result = self.simplify(path, "--original-ids", "--reduction", "50%", name=out)
        run("convert", result, self.folder / "joined.vtu", "--quiet")
        for name in ("out.vtu", "joined.vtu"):
            mesh = Vtu(self.folder / name)
            ids = values(mesh, "OriginalPointIds")
            self.assertGreaterEqual(ids.min(), -1)
            stayed = ids >= 0
            np.testing.assert_array_equal(mesh.points[stayed], Vtu(path).points[ids[stayed]])
            self.assertLessEqual({0, 1, 2, 5, 6, 7}, set(ids.tolist()))

    def test_where_unused_points_are_not_counted_that_is_said(self):
        mesh = jittered(6)
        mesh = with_arrays(mesh, f=("Float32", np.append(np.array(mesh.points)[:, 0], 0)))
        mesh.array("Points")[4] = list(mesh.array("Points")[4]) + [20.0, 0.0, 0.0]
        mesh.counts["NumberOfPoints"] = str(int(mesh.counts["NumberOfPoints"]) + 1)
        path = self.write(mesh, "unused.vtu")
        for option, is_said in ("--merge-points", True), ("--quiet", False):
            said = finish("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "30%", "--original-ids", option).stderr
            self.assertEqual(b"OriginalPointIds leaves out 1 point that no cell uses" in said, is_said, said)

    def test_an_array_of_that_name_is_not_overwritten(self):
        path = self.generate()
        out = self.simplify(path, "--original-ids", "--reduction", "50%")
        run("simplify", out, "-o", self.folder / "2.vtu", "--original-ids", "--reduction", "50%", code=USAGE)
        self.assertEqual(self.files(), ["generated.vtu", "out.vtu"])


class Map:
    """The file, read as io/FORMAT.md says."""

    def __init__(self, path):
        data = path.read_bytes()
        head = struct.unpack("<8sII12Q", data[:112])
        assert head[:3] == (b"TFPTSMAP", 0x01020304, 2) and head[3] == len(data), head
        original, original_cells, points, tets, cells, corners, shares, coordinate = head[4:12]
        at = 112

        def take(dtype, count):
            nonlocal at
            at += -at % 8
            rows = np.frombuffer(data, dtype, count, at)
            at += rows.nbytes
            return rows
        self.points = take(f"<f{coordinate}", 3 * points).reshape(-1, 3)
        self.tets = take("<i8", corners)[:4 * tets].reshape(-1, 4)
        take("<i8", cells + 1)
        take("u1", cells)
        self.places = take([("cell", "<u8"), ("weights", "<f8", 4)], original)
        self.homes = take([("tet", "<u4"), ("share", "<f4")], original_cells)
        self.origins = take([("cell", "<u8"), ("is_mean", "<u8")], cells)
        self.shares = take([("original", "<u8"), ("point", "<u8"), ("weight", "<f8")], shares)
        assert at == len(data), (at, len(data))

    def back(self, values):
        """Values at the original's points, of those at the result's."""
        corners = self.tets[self.places["cell"].astype(np.int64)]
        return np.einsum("pk,pkc->pc", self.places["weights"], values[corners])

    def forth(self, values):
        result = np.zeros((len(self.points), values.shape[1]))
        np.add.at(result, self.shares["point"], self.shares["weight"][:, None] * values[self.shares["original"]])
        return result


def jittered(n=8, seed=1):
    """A box of six tetrahedra a cube, whose inner points are off the lattice."""
    mesh = TinyVtu(n)
    points = np.array(mesh.points)
    inner = np.all((points > 0) & (points < n), axis=1)
    points[inner] += np.random.default_rng(seed).uniform(-0.2, 0.2, (inner.sum(), 3))
    mesh.points = [tuple(map(float, p)) for p in points.astype("f4")]
    return rebuilt(mesh)


def ball(n, seed):
    """The cube blown up."""
    mesh = TinyVtu(n)
    points = 2 * np.array(mesh.points) / n - 1
    largest, length = np.abs(points).max(axis=1), np.linalg.norm(points, axis=1)
    points *= (largest / np.maximum(length, 1e-9))[:, None]
    points += (largest < 0.99)[:, None] * np.random.default_rng(seed).normal(size=points.shape) * 0.1 / n
    mesh.points = [tuple(point) for point in points.tolist()]
    return rebuilt(mesh)


def with_arrays(mesh, **arrays):
    """Point arrays by name: (type, rows)."""
    mesh.arrays = [a for a in mesh.arrays if a[0] != "PointData"]
    for name, (kind, rows) in reversed(arrays.items()):
        rows = np.asarray(rows)
        components = 1 if rows.ndim == 1 else rows.shape[1]
        mesh.arrays.insert(0, ["PointData", name, kind, components, rows.ravel().tolist()])
    return mesh


class Maps(FolderTest):
    def simplify(self, path, *options):
        run("simplify", path, "-o", self.folder / "out.vtu", "--map", self.folder / "out.map", "--original-ids", "--quiet",
            *options)
        return Vtu(self.folder / "out.vtu"), Map(self.folder / "out.map")

    def apply(self, path, *options, name="moved.vtu"):
        out = self.folder / name
        return out, report_of("apply", self.folder / "out.map", path, "-o", out, "--quiet", *options)

    def test_places_and_shares_lead_to_the_coordinates(self):
        path = self.generate("--jitter", "0.5", "--shuffle", tets="30k")
        original = Vtu(path)
        for name, options in METHODS.items():
            with self.subTest(name):
                result, the_map = self.simplify(path, "--chunk-tets", "6k", "--regions", "none", *options)
                np.testing.assert_array_equal(the_map.points, result.points)
                np.testing.assert_array_equal(the_map.tets, result.tets)
                np.testing.assert_allclose(the_map.back(result.points), original.points, atol=1e-6)
                np.testing.assert_allclose(the_map.forth(original.points), result.points, atol=1e-6)
                ids = values(result, "OriginalPointIds")
                kept = the_map.shares[the_map.shares["weight"] == 1]
                stayed = ids[kept["point"]] >= 0
                np.testing.assert_array_equal(kept["original"][stayed], ids[kept["point"]][stayed])
                self.assertEqual(stayed.sum(), (ids >= 0).sum())

    def test_points_that_lie_elsewhere_are_told_of(self):
        mesh = jittered()
        path = self.write(mesh)
        self.simplify(path, "--reduction", "60%")
        stayed = self.apply(path)[1]
        self.assertGreater(stayed["stayed_points"], 100)
        self.assertEqual(stayed["stayed_points_elsewhere"], 0)
        nearly = jittered()
        nearly.array("Points")[2] = "Float64"
        nearly.array("Points")[4] = [c if c != 0 else 1e-16 for c in nearly.array("Points")[4]]
        self.assertEqual(self.apply(self.write(nearly, "nearly.vtu"))[1]["stayed_points_elsewhere"], 0)
        mesh.points = [(x, y, z + 1 if z > 3 else z) for x, y, z in mesh.points]
        moved = self.write(rebuilt(mesh), "moved_mesh.vtu")
        elsewhere = self.apply(moved)[1]["stayed_points_elsewhere"]
        self.assertGreater(elsewhere, 0.3 * stayed["stayed_points"])
        said = finish("apply", self.folder / "out.map", moved, "-o", self.folder / "x.vtu").stderr
        self.assertRegex(said, rb"points that stayed, but lie elsewhere in \S+moved_mesh.vtu: \d+ of \d+;")

    def test_a_new_point_whose_nearest_is_a_vertex_has_not_stayed(self):
        for seed in 0, 2:
            path = self.write(ball(10, seed))
            for boundary in "2%", "4%":
                result, the_map = self.simplify(path, "--boundary", boundary, "--reduction", "90%")
                report = self.apply(path)[1]
                self.assertEqual((report["stayed_points"], report["stayed_points_elsewhere"]),
                                 ((values(result, "OriginalPointIds") >= 0).sum(), 0))

    def test_points_outside_go_to_the_nearest_of_the_boundary(self):
        path = self.generate("--jitter", "0.5", tets="30k")
        run("simplify", path, "-o", self.folder / "round.vtu", "--reduction", "60%", "--regions", "none", "--quiet")
        path = self.folder / "round.vtu"
        result, the_map = self.simplify(path, "--reduction", "60%", "--boundary", "2%", "--regions", "none")
        np.testing.assert_allclose(the_map.back(result.points), Vtu(path).points, atol=0.02 * 3 ** 0.5)
        np.testing.assert_allclose(the_map.forth(Vtu(path).points), result.points, atol=0.02 * 3 ** 0.5)

    def test_other_arrays_follow(self):
        mesh = jittered()
        path = self.write(mesh)
        result, _ = self.simplify(path, "--reduction", "60%")
        ids = values(result, "OriginalPointIds")
        stayed = ids >= 0
        self.assertGreater((~stayed).sum(), 20)
        points = np.array(mesh.points)
        rng = np.random.default_rng(3)
        noise, numbers = rng.normal(size=(len(points), 3)), rng.integers(-2**62, 2**62, len(points))
        linear = points @ [3.0, -2.0, 0.5] + 7
        holes = np.where(np.arange(len(points)) % 97 == 0, np.nan, linear)
        ones = np.where(np.arange(len(points)) % 7 == 0, np.nan, 1)
        step = self.write(with_arrays(mesh, linear=("Float64", linear), noise=("Float32", noise), constant=(
            "Float64", np.full(len(points), 0.1)), numbers=("Int64", numbers), holes=("Float64", holes), ones=("Float64", ones)), "step.vtu")
        out, report = self.apply(step)
        moved = Vtu(out)
        np.testing.assert_array_equal(moved.points, result.points)
        np.testing.assert_array_equal(moved.tets, result.tets)
        self.assertEqual(list(moved.arrays["point"]), ["linear", "noise", "constant", "numbers", "holes", "ones"])
        np.testing.assert_array_equal(values(moved, "noise")[stayed], noise.astype("f4")[ids[stayed]])
        np.testing.assert_array_equal(values(moved, "numbers")[stayed], numbers[ids[stayed]])
        self.assertLessEqual(set(values(moved, "numbers").tolist()), set(numbers.tolist()))
        np.testing.assert_allclose(values(moved, "linear"), moved.points @ [3.0, -2.0, 0.5] + 7, atol=1e-5)
        np.testing.assert_array_equal(values(moved, "constant"), 0.1)
        self.assertLessEqual(np.abs(values(moved, "noise")).max(), np.abs(noise.astype("f4")).max())
        broken = np.isnan(values(moved, "holes"))
        self.assertGreater(broken.sum(), 0)
        # They do not spread: where most of the weight is with numbers, these have their mean.
        self.assertLessEqual(broken.mean(), 2 * np.isnan(holes).mean())
        known = values(moved, "ones")[~np.isnan(values(moved, "ones"))]
        np.testing.assert_array_equal(known, 1)
        error = np.abs(values(moved, "holes") - values(moved, "linear"))[~broken]
        self.assertLess(error.max(), 6.5)  # as far as the field goes in a cube
        self.assertLess((error > 1e-9).mean(), 0.2)
        endless = np.where(points[:, 0] < points[:, 0].mean(), -np.inf, linear)
        endless = self.write(with_arrays(mesh, endless=("Float64", endless)), "endless.vtu")
        for options in [], ["--fit"]:
            there = values(Vtu(self.apply(endless, *options, name="endless_moved.vtu")[0]), "endless")
            self.assertGreater((there == -np.inf).sum(), 20)
            self.assertFalse((np.isnan(there) | (there == np.inf)).any())
        # It says what compare finds.
        found = {a["name"]: a for a in report_of("compare", step, out, "--quiet")["arrays"]}
        for array in report["arrays"]:
            if array["name"] == "numbers":
                continue
            for key in ("rms", "max"):
                self.assertAlmostEqual(array[key], found[array["name"]][key], delta=1e-9 + 1e-6 * array[key])
        self.assertGreater(report["arrays"][-1]["undefined"], 0)
        # Files may have arrays without names.
        bare = self.write(with_arrays(mesh, **{"": ("Float64", linear), "noise": ("Float32", noise)}), "bare.vtu")
        self.assertEqual(list(Vtu(self.apply(bare, name="bare_moved.vtu")[0]).arrays["point"]), ["unnamed_0", "noise"])
        # One of them alone.
        out, _ = self.apply(step, "--array", "noise", name="one.vtu")
        self.assertEqual(list(Vtu(out).arrays["point"]), ["noise"])
        for name in "nose", "cell:nose":
            said = finish("apply", self.folder / "out.map", step, "-o", out, "--array", name)
            self.assertEqual(said.returncode, USAGE)
            self.assertIn(f"{step}: --array {name}: there is no such array", said.stderr.decode())
        self.apply(step, "--array", "noise", "--array", "noise", name="twice.vtu")
        self.assertEqual((self.folder / "twice.vtu").read_bytes(), out.read_bytes())

    def test_values_can_be_fitted(self):
        path = self.write(jittered())
        result, the_map = self.simplify(path, "--reduction", "60%")
        ids = values(result, "OriginalPointIds")
        stayed = ids >= 0
        x, y, z = np.array(jittered().points).T
        wave, numbers = np.sin(x) * np.cos(y + z), np.arange(len(x))
        linear, holes = 3 * x - y, np.where(np.arange(len(x)) % 97 == 0, np.nan, wave)
        step = self.write(with_arrays(jittered(), wave=("Float32", wave), numbers=("Int32", numbers), linear=("Float64", linear),
                                      holes=("Float64", holes)), "step.vtu")
        between, report = self.apply(step)
        (self.folder / "scratch").mkdir()
        fitted, fitted_report = self.apply(step, "--fit", "--scratch", self.folder / "scratch", name="fitted.vtu")
        self.assertEqual((report["fitted"], fitted_report["fitted"]), (False, True))
        self.assertEqual(list((self.folder / "scratch").iterdir()), [])
        between, fitted = Vtu(between), Vtu(fitted)
        self.assertEqual(list(fitted.arrays["point"]), ["wave", "numbers", "linear", "holes"])
        wave = wave.astype("f4")
        error, fitted_error = (np.sqrt(np.mean((the_map.back(values(m, "wave")[:, None])[:, 0] - wave)**2))
                               for m in (between, fitted))
        self.assertLess(fitted_error, 0.95 * error)
        self.assertAlmostEqual(fitted_report["arrays"][0]["rms"], fitted_error / np.ptp(wave), delta=1e-6)
        np.testing.assert_array_equal(values(fitted, "wave")[stayed], wave[ids[stayed]])
        self.assertTrue(wave.min() <= values(fitted, "wave").min() and values(fitted, "wave").max() <= wave.max())
        np.testing.assert_array_equal(values(fitted, "numbers"), values(between, "numbers"))
        np.testing.assert_allclose(values(fitted, "linear"), values(between, "linear"), atol=1e-9)
        np.testing.assert_array_equal(np.isnan(values(fitted, "holes")), np.isnan(values(between, "holes")))
        # One of them alone.
        one, _ = self.apply(step, "--fit", "--array", "wave", name="one.vtu")
        np.testing.assert_array_equal(values(Vtu(one), "wave"), values(fitted, "wave"))
        run("apply", self.folder / "out.map", step, "-o", one, "--scratch", self.folder, code=USAGE)
        run("apply", self.folder / "out.map", step, "-o", one, "--fit", "--scratch", self.folder / "none", code=USAGE)

    def test_names_of_components_follow(self):
        path = self.generate(tets="3k")
        self.simplify(path, "--reduction", "30%")
        head = self.apply(path)[0].read_bytes().partition(b"<AppendedData")[0].decode()
        self.assertIn('ComponentName0="x" ComponentName1="y" ComponentName2="z"', head)

    def test_the_time_follows(self):
        path = self.generate("--time", "2.5", tets="3k")
        self.simplify(path, "--reduction", "30%")
        out, _ = self.apply(path)
        self.assertIn(b"TimeValue", run("info", out))

    def test_the_same_bytes(self):
        path = self.generate("--jitter", "0.5", tets="100k")
        maps, meshes, fitted = set(), set(), set()
        for threads, memory in (("1", "1G"), ("2", "1G"), ("1", "140M"), ("2", "200M")):
            self.simplify(path, "--reduction", "60%", "--chunk-tets", "10k", "--threads", threads, "--memory", memory)
            maps.add((self.folder / "out.map").read_bytes())
            meshes.add(self.apply(path, "--threads", threads)[0].read_bytes())
            fitted.add(self.apply(path, "--threads", threads, "--fit")[0].read_bytes())
        self.assertEqual((len(maps), len(meshes), len(fitted)), (1, 1, 1))
        # Of a mesh that goes elsewhere, in another format, and for each level.
        run("simplify", path, "-o", "-", "--map", self.folder / "2.map", "--original-ids", "--reduction", "60%", "--chunk-tets",
            "10k")
        self.assertEqual({(self.folder / "2.map").read_bytes()}, maps)
        run("simplify", path, "-o", self.folder / "out.msh", "--map", self.folder / "2.map", "--reduction", "60%",
            "--chunk-tets", "10k")
        self.assertEqual({(self.folder / "2.map").read_bytes()}, maps)
        run("simplify", path, "-o", self.folder / "{lod}.vtu", "--map", self.folder / "{lod}.map", "--lods", "30%,60%")
        for lod in "12":
            np.testing.assert_array_equal(Map(self.folder / f"{lod}.map").tets, Vtu(self.folder / f"{lod}.vtu").tets)

    def test_after_an_interruption(self):
        path = self.generate("--jitter", "0.5", tets="300k")
        out, the_map = self.folder / "out.vtu", self.folder / "out.map"
        arguments = ["simplify", path, "-o", out, "--map", the_map, "--reduction", "80%", "--chunk-tets", "10k", "--threads", "1",
                     "--original-ids", "--quiet"]
        arguments += ["--memory", least_memory(*arguments)]
        run(*arguments)
        whole = out.read_bytes(), the_map.read_bytes()
        the_map.unlink()
        self.assertIn("--resume", self.stop_when("out.vtu.tetfusion/round-*.state", *arguments))
        self.assertEqual((out.read_bytes(), the_map.exists()), (whole[0], False))
        run(*arguments, "--resume", "--verify")
        self.assertEqual((out.read_bytes(), the_map.read_bytes()), whole)
        self.assertEqual(self.files(), ["generated.vtu", "out.map", "out.vtu"])

    def test_memory_is_kept_to(self):
        path = self.generate("--jitter", "0.5", tets="400k")
        report = report_of("simplify", path, "-o", self.folder / "out.vtu", "--map", self.folder / "out.map", "--reduction",
                           "80%", "--chunk-tets", "10k", "--memory", "160M", "--threads", "1", "--quiet")
        self.assertIn("map", report["seconds"])
        if not sanitized():
            self.assertLess(report["peak_rss_bytes"], 160 << 20)

    def test_the_two_sides_of_a_crack(self):
        mesh = TinyVtu(6)
        count, points = len(mesh.points), np.array(mesh.points)
        mesh.tets += [[v + count for v in t] for t in mesh.tets]
        mesh.points += [(p[0] + 6, p[1], p[2]) for p in mesh.points]
        side = np.repeat([0.0, 1.0], count)
        mesh = with_arrays(rebuilt(mesh), temperature=("Float32", np.concatenate([points[:, 0], points[:, 1]])))
        path = self.write(mesh)
        self.simplify(path, "--reduction", "50%")
        out, report = self.apply(self.write(with_arrays(mesh, side=("Float64", side)), "step.vtu"))
        moved = Vtu(out)
        sides = values(moved, "side")[moved.tets]
        self.assertGreater(len(sides), 500)
        np.testing.assert_allclose(sides.min(axis=1), sides.max(axis=1), atol=1e-15)
        self.assertLess(report["arrays"][0]["max"], 1e-15)

    def test_cells_of_lower_dimension_and_unused_points(self):
        mesh = mesh_of_all_sorts()
        mesh.arrays[0][4] += [5.0]
        for a in mesh.arrays:
            if a[0] == "PointData" and a is not mesh.arrays[0]:
                a[4] += [1] * a[3] if "Int" in a[2] else [1.0] * a[3]
        mesh.array("Points")[4] += [9.0, 9.0, 9.0]
        mesh.counts["NumberOfPoints"] = str(len(mesh.points) + 1)
        path = self.write(mesh)
        result, the_map = self.simplify(path, "--reduction", "30%")
        self.assertEqual(the_map.places["cell"][-1], 2**64 - 1)
        out, _ = self.apply(path)
        moved = Vtu(out)
        self.assertEqual([(t, ids.tolist()) for t, ids in moved.others], [(t, ids.tolist()) for t, ids in result.others])
        self.assertEqual(set(moved.arrays["point"]), set(Vtu(path).arrays["point"]))

    def test_damaged_maps_are_refused(self):
        path = self.write(jittered(4))
        self.simplify(path, "--reduction", "20%")
        whole = (self.folder / "out.map").read_bytes()
        places = [*range(112), *range(112, len(whole), 997)]
        for at in places:
            (self.folder / "bad.map").write_bytes(whole[:at] + bytes([whole[at] ^ 0x41]) + whole[at + 1:])
            run("apply", self.folder / "bad.map", path, "-o", self.folder / "bad.vtu", code=BAD)
        for end in (1, 50, 112, 1000, len(whole) - 8):
            (self.folder / "bad.map").write_bytes(whole[:end])
            run("apply", self.folder / "bad.map", path, "-o", self.folder / "bad.vtu", code=BAD)
        run("apply", path, path, "-o", self.folder / "bad.vtu", code=BAD)
        run("apply", self.folder / "out.map", self.write(TinyVtu(3), "3.vtu"), "-o", self.folder / "bad.vtu", code=BAD)
        run("apply", self.folder / "none.map", path, "-o", self.folder / "bad.vtu", code=IO)
        self.assertNotIn("bad.vtu", self.files())

    def test_what_cannot_be_is_refused_at_the_start(self):
        path = self.generate(tets="100k")
        before = self.files()
        goal = ["--reduction", "50%"]
        for options in (["-o", self.folder / "o.pvtu", "--map", self.folder / "o.map"],
                        ["-o", self.folder / "o.vtu", "--map", "-"],
                        ["-o", self.folder / "o.vtu", "--map", path],
                        ["-o", self.folder / "o.vtu", "--map", self.folder / "o.vtu"],
                        ["-o", self.folder / "o.vtu", "--map", self.folder / "{lod}.map"],
                        ["-o", self.folder / "{lod}.vtu", "--map", self.folder / "o.map", "--lods", "20%,30%"]):
            run("simplify", path, *options, *goal, code=USAGE)
        run("apply", self.folder / "o.map", path, "-o", self.folder / "o_{lod}.vtu", code=USAGE)
        run("simplify", path, "-o", self.folder / "o.vtu", "--map", self.folder / "none" / "o.map", *goal, code=IO)
        run("simplify", path, "-o", self.folder / "o.vtu", "--map", self.folder / "o.map", *goal, "--memory", "72M",
            "--threads", "1", "--chunk-tets", "4k", code=MEMORY)
        self.assertEqual(self.files(), before)

    def test_it_says_how_far_arrays_are_off(self):
        path = self.generate()
        self.simplify(path, "--reduction", "50%")
        said = finish("apply", self.folder / "out.map", path, "-o", self.folder / "moved.vtu").stderr.decode()
        self.assertRegex(said, r": off by [0-9.e-]+ % of its range in the mean of squares, [0-9.e-]+ % at most \(point \d+\)")


if __name__ == "__main__":
    main()
