#!/usr/bin/env python3
"""simplify --roi and --weight, from file to file. Usage: roi_test.py TETFUSION"""
import math
import numpy as np
from harness import BAD, USAGE, FolderTest, finish, main, report_of, run
from independent_check import Vtu
from tiny_vtu import TinyVtu

BOX, SPHERE = "box=0.1,0.4,0.2,0.6,0,0.5", "sphere=0.5,0.5,0.5,0.25"


def cells_inside(mesh, inside):
    """The corners of tetrahedra all of whose points are inside, in an order of their own."""
    corners = mesh.points[mesh.tets[inside(mesh)[mesh.tets].all(axis=1)]]
    return sorted(tuple(sorted(map(tuple, cell))) for cell in corners.tolist())


def in_box(mesh):
    return ((mesh.points >= [0.1, 0.2, 0]) & (mesh.points <= [0.4, 0.6, 0.5])).all(axis=1)


def in_sphere(mesh):
    return ((mesh.points - [0.5, 0.5, 0.5]) ** 2).sum(axis=1) <= 0.25 ** 2


def is_above(mesh):
    return mesh.arrays["point"]["front"][-1].ravel() > 0.8


class RegionOfInterest(FolderTest):
    def simplify(self, path, *options):
        out = self.folder / "out.vtu"
        report = report_of("simplify", path, "-o", out, "--quiet", "--regions", "none", *options)
        report_of("check", out, "--strict")
        return Vtu(out), report

    def test_what_is_inside_stays(self):
        path = self.generate("--jitter", "0.5", "--double", tets="40k")
        original = Vtu(path)
        options = ("--reduction", "80%", "--chunk-tets", "9k", "--threads", "2")
        without, _ = self.simplify(path, *options)
        for inside, text in ((in_box, BOX), (in_sphere, SPHERE), (is_above, "front>0.8"), (is_above, " front  > 0.8 ")):
            mesh, _ = self.simplify(path, *options, "--roi", text)
            expected = cells_inside(original, inside)
            self.assertGreater(len(expected), 1000, text)
            self.assertLessEqual(set(expected), set(cells_inside(mesh, inside)), text)
            self.assertLess(len(cells_inside(without, inside)), 0.5 * len(expected), text)

    def test_several(self):
        path = self.generate("--jitter", "0.5", "--double", tets="40k")
        original = Vtu(path)
        mesh, _ = self.simplify(path, "--method", "tetfuse", "--roi", BOX, "--roi", SPHERE)
        for inside in (in_box, in_sphere):
            self.assertLessEqual(set(cells_inside(original, inside)), set(cells_inside(mesh, inside)))

    def test_all_of_the_mesh(self):
        path = self.generate(tets="5k")
        mesh, report = self.simplify(path, "--reduction", "50%", "--roi", "box=0,1,0,1,0,1")
        self.assertEqual(report["output"]["tets"], report["input"]["tets"])
        self.assertEqual(len(mesh.tets), report["input"]["tets"])

    def test_the_bytes_do_not_depend_on_the_memory(self):
        path = self.generate("--jitter", "0.5", tets="40k")
        files = []
        for name, more in (("a.vtu", ("--threads", "1")), ("b.vtu", ("--threads", "2", "--scratch", self.folder / "s", "--memory", "96M"))):
            report = report_of("simplify", path, "-o", self.folder / name, "-q", "--reduction", "50%", "--roi", "front>0.8",
                               "--chunk-tets", "5k", *more)
            self.assertEqual(report["scratch_bytes"] > 0, name == "b.vtu")
            files.append((self.folder / name).read_bytes())
        self.assertEqual(*files)

    def test_verify_looks_at_it(self):
        path = self.generate(tets="5k")
        _, report = self.simplify(path, "--reduction", "50%", "--roi", "sphere=0,0,0,0.2", "--max-volume", "0.1", "--verify")
        self.assertLessEqual({"region of interest", "largest volume"}, {c["name"] for c in report["verified"][0]["checks"]})
        self.assertEqual(report["verified"][0]["not_verified"], [])

    def test_a_region_without_points_is_told_of(self):
        path = self.generate(tets="3k")
        for region, told in (("sphere=1e9,0,0,1", True), ("sphere=0,0,0,0.3", False)):
            result = finish("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "30%", "--roi", region)
            self.assertEqual(b"no point of the mesh is in the region of interest" in result.stderr, told, result.stderr)

    def test_what_makes_no_sense_is_refused(self):
        path = self.generate(tets="1k")
        for text, why in (("box=0,1,0,1", "six bounds"), ("box=1,0,0,1,0,1", "lower one of each pair first"), ("box=a,1,0,1,0,1", '"a" is no number'),
                          ("sphere=0,0,0", "a centre and a radius"), ("sphere=0,0,0,-1", "a centre and a radius"),
                          ("nothing>1", 'no point array "nothing"; it has temperature, front'), ("front>high", "give box="), ("front", "give box="), ("", "give box=")):
            result = finish("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "50%", "--roi", text)
            self.assertEqual(result.returncode, USAGE, text)
            self.assertIn(why, result.stderr.decode(), text)
            self.assertFalse((self.folder / "out.vtu").exists())


class Weight(FolderTest):
    OPTIONS = ("--array", "temperature", "--regions", "none", "--quiet")

    def with_weights(self, weights):
        mesh = TinyVtu(8)
        mesh.arrays.insert(1, ["PointData", "heavy", "Float64", 1, weights])
        return mesh

    def points(self, path, *options):
        """How many there are where the weight is less than a half, and elsewhere."""
        out = self.folder / "out.vtu"
        run("simplify", path, "-o", out, *self.OPTIONS, *options)
        report_of("check", out, "--strict")
        front = Vtu(out).arrays["point"]["front"][-1].ravel()
        return int((front < 0.5).sum()), int((front >= 0.5).sum())

    def test_the_mesh_stays_finer_where_errors_count_more(self):
        path = self.generate("--jitter", "0.5", "--time", "8", tets="100k")
        for options in (("--reduction", "60%"), ("--reduction", "60%", "--boundary", "0.5%")):
            light, heavy = self.points(path, *options, "--weight", "front")
            light_before, heavy_before = self.points(path, *options)
            self.assertLess(light, 0.5 * light_before, options)
            self.assertGreater(heavy, 1.5 * heavy_before, options)

    def test_an_array_of_cells_says_it_as_well(self):
        """Where a cell has the weight its points have, the result is the same to the bit."""
        cells = len(TinyVtu(8).tets)
        files = []
        for association, count, name in (("PointData", 9 ** 3, "heavy"), ("CellData", cells, "cell:heavy")):
            mesh = TinyVtu(8)
            mesh.array("temperature")[4] = [math.sin(x) + 0.3 * math.cos(2 * y * z) for x, y, z in mesh.points]
            mesh.arrays.insert(1, [association, "heavy", "Float32", 1, [3.0] * count])
            path = self.write(mesh)
            run("simplify", path, "-o", self.folder / "out.vtu", *self.OPTIONS, "--max-rms", "1%", "--weight", name, "--chunk-tets", "500")
            run("convert", self.folder / "out.vtu", self.folder / "out.mesh", "--quiet")  # without the weights
            files.append((self.folder / "out.mesh").read_bytes())
        self.assertEqual(*files)

    def test_only_ratios_of_weights_count(self):
        """Towards a goal; and a bound is divided by them."""
        base = 1 + 99 * (np.array(TinyVtu(12).points)[:, 2] > 6)
        files = {}
        for scale, options in ((1, [("--reduction", "40%"), ("--max-rms", "0.05")]),
                               (2.0 ** 4, [("--max-rms", "0.8")]), (2.0 ** -30, [("--max-rms", repr(0.05 * 2.0 ** -30))]),
                               (2.0 ** 60, [("--reduction", "40%")]), (2.0 ** -60, [("--reduction", "40%")]),
                               (3, [("--reduction", "40%")]), (1e-3, [("--reduction", "40%")])):
            mesh = TinyVtu(12)
            mesh.arrays.insert(1, ["PointData", "heavy", "Float64", 1, list(base * scale)])
            mesh.array("temperature")[4] = [math.sin(x) + 0.3 * math.cos(2 * y * z) for x, y, z in mesh.points]
            path = self.write(mesh)
            for option in options:
                run("simplify", path, "-o", self.folder / "out.vtu", *self.OPTIONS, "--weight", "heavy", "--chunk-tets", "2k", *option)
                run("convert", self.folder / "out.vtu", self.folder / "out.mesh", "--quiet")  # without the weights
                files.setdefault(option[0], []).append((self.folder / "out.mesh").read_bytes())
                self.assertLess(len(Vtu(self.folder / "out.vtu").tets), 0.9 * len(mesh.tets), (scale, option))
        self.assertEqual({option: (len(same), len(set(same))) for option, same in files.items()}, {"--reduction": (5, 1), "--max-rms": (3, 1)})

    def test_the_same_weight_everywhere_is_told_of(self):
        for weight, said in ((0, "is 0 everywhere"), (2.5, "is 2.5 everywhere")):
            mesh = TinyVtu(6)
            mesh.arrays.insert(1, ["PointData", "heavy", "Float64", 1, [weight] * len(mesh.points)])
            path = self.write(mesh)
            told = finish("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "20%", "--weight", "heavy").stderr.decode()
            self.assertIn(f"--weight heavy {said}: all places count alike", told)

    def test_the_mesh_stays_finer_round_heavy_cells(self):
        mesh = TinyVtu(12)
        centres = [[sum(mesh.points[v][k] for v in tet) / 4 for k in range(3)] for tet in mesh.tets]
        middle = max(p[0] for p in mesh.points) / 2
        mesh.arrays.insert(1, ["CellData", "heavy", "Float64", 1, [50.0 if c[0] > middle else 0.1 for c in centres]])
        mesh.array("temperature")[4] = [math.sin(x) + 0.3 * math.cos(2 * y * z) for x, y, z in mesh.points]
        path = self.write(mesh)
        shares = []
        for more in ((), ("--weight", "cell:heavy")):
            run("simplify", path, "-o", self.folder / "out.vtu", *self.OPTIONS, "--reduction", "40%", "--chunk-tets", "2k", *more)
            points = Vtu(self.folder / "out.vtu").points
            shares.append(float((points[:, 0] > middle).mean()))
        self.assertGreater(shares[1], shares[0] + 0.03)

    def test_a_bound_holds_where_the_weight_is_one(self):
        path = self.generate("--jitter", "0.5", "--time", "8", tets="100k")
        light, heavy = self.points(path, "--max-rms", "0.1%", "--weight", "front")
        light_before, heavy_before = self.points(path, "--max-rms", "0.1%")
        self.assertLess(light, 0.5 * light_before)
        self.assertAlmostEqual(heavy / heavy_before, 1, delta=0.1)

    def simplify_weighted(self, weights, *options):
        """The result's bytes without the weights, and how much is gone."""
        mesh = self.with_weights(weights)
        mesh.array("temperature")[4] = [math.sin(x) + 0.3 * math.cos(2 * y * z) for x, y, z in mesh.points]
        report = report_of("simplify", self.write(mesh), "-o", self.folder / "out.vtu", *self.OPTIONS, "--weight", "heavy", *options)
        run("convert", self.folder / "out.vtu", self.folder / "out.mesh", "--quiet")
        return (self.folder / "out.mesh").read_bytes(), report["reduction"]

    def test_a_bound_at_points_does_not_depend_on_the_scale_of_weights(self):
        results = [self.simplify_weighted([weight] * 9 ** 3, "--max-error", "2%", "--chunk-tets", "500") for weight in (1.0, 64.0)]
        self.assertGreater(results[0][1], 0.1)
        self.assertEqual(*results)

    def test_towards_a_goal_only_ratios_of_weights_matter(self):
        results = [self.simplify_weighted([factor * (0.1 + (v % 9) / 9) for v in range(9 ** 3)], "--max-error", "20%", "--reduction", "50%")
                   for factor in (1.0, 0.125, 2.0 ** 40)]
        self.assertGreater(results[0][1], 0.45)
        self.assertEqual(results[0], results[1])
        self.assertEqual(results[0], results[2])

    def test_a_goal_out_of_reach_is_given_up_soon(self):
        """Bounds rise towards it, until they are what they may be, and fields without a bound are allowed anything."""
        path = self.generate("--jitter", "0.5", tets="20k")
        for more in (("--array", "temperature", "--max-error", "0.2%", "--weight", "front"), ("--array", "temperature:0.2%", "--array", "front")):
            report = report_of("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "95%", *more)
            self.assertEqual(report["stop_reason"], "saturated")
            self.assertLess(len(report["lods"]), 40)

    def test_where_all_count_alike_nothing_changes(self):
        for weight in (1.0, 3.0):
            path = self.write(self.with_weights([weight] * 9 ** 3))
            files = []
            for more in ((), ("--weight", "heavy")):
                run("simplify", path, "-o", self.folder / "out.vtu", *self.OPTIONS, "--reduction", "50%", "--chunk-tets", "500", *more)
                files.append((self.folder / "out.vtu").read_bytes())
            self.assertEqual(*files)

    def test_the_bytes_do_not_depend_on_the_memory(self):
        path = self.generate("--jitter", "0.5", tets="40k")
        files = []
        for name, more in (("a.vtu", ("--threads", "1")), ("b.vtu", ("--threads", "2", "--scratch", self.folder / "s", "--memory", "96M"))):
            report = report_of("simplify", path, "-o", self.folder / name, *self.OPTIONS, "--reduction", "70%", "--weight", "front",
                               "--chunk-tets", "5k", *more)
            self.assertEqual(report["scratch_bytes"] > 0, name == "b.vtu")
            files.append((self.folder / name).read_bytes())
        self.assertEqual(*files)

    def test_what_makes_no_sense_is_refused(self):
        path = self.write(self.with_weights([1.0] * 7 + [-1.0] + [1.0] * (9 ** 3 - 8)))
        for options, code, why in ((("--weight", "nothing"), USAGE, "--weight nothing: there is no array of one component"),
                                   (("--weight", "id"), USAGE, "point arrays: temperature, heavy"),
                                   (("--weight", "cell:nothing"), USAGE, "cell arrays (name them cell:NAME): "),
                                   (("--weight", ""), USAGE, "--weight"),
                                   (("--weight", "heavy", "--method", "tetfuse"), USAGE, "--weight belongs to --method fuse"),
                                   (("--weight", "heavy"), BAD, "--weight heavy: point 7 has the value -1")):
            result = finish("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "50%", *options)
            self.assertEqual(result.returncode, code, options)
            self.assertIn(why, result.stderr.decode())
            self.assertFalse((self.folder / "out.vtu").exists())


if __name__ == "__main__":
    main()
