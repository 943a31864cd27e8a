#!/usr/bin/env python3
"""src/cli/REPORTS.md names what the reports have, and the reports have what it names. Usage: reports_test.py TETFUSION"""
import re

from harness import HERE, INVALID, FolderTest, main, report_of, run
from seams_test import half
from tiny_vtu import TinyVtu

DOCUMENT = HERE.parents[1] / "src" / "cli" / "REPORTS.md"


def documented():
    """For each heading the keys of its tables; the first is the one of them all."""
    sections = re.split(r"^#+ (.*)$", DOCUMENT.read_text(), flags=re.MULTILINE)[1:]
    return {title: [key for row in re.findall(r"^\| (`.*?`) \|", text, re.MULTILINE) for key in re.findall("`(.*?)`", row)]
            for title, text in zip(sections[::2], sections[1::2])}


def paths(value, path):
    if isinstance(value, dict):
        return {p for key, inner in value.items() for p in paths(inner, f"{path}.{key}" if path else key)}
    if isinstance(value, list) and any(isinstance(item, dict) for item in value):
        return {p for item in value for p in paths(item, path + "[]")}
    if isinstance(value, list):
        return {path + "[]" if value else path + "?"}  # of an empty list nobody knows what would be in it
    return {path if value is not None else path + "?"}  # nor of what is not there


class Reports(FolderTest):
    keys = documented()

    def agree(self, expected, *reports, only=None):
        """All keys are expected, and all that are expected are there."""
        if only:
            reports = [step for report in reports for step in report[only]]
        seen = set().union(*(paths(report, "") for report in reports))
        families = tuple(key[:-1] for key in expected if key.endswith(".*"))
        for path in seen:
            name = path.rstrip("?")
            without_value = path.endswith("?") and any(key.startswith((name + ".", name + "[]")) for key in expected)
            self.assertTrue(name in expected or without_value or name.startswith(families), f"{path} is not in {DOCUMENT}")
        for key in expected:
            is_there = {key, key + "?", key.removesuffix("[]") + "?"} & seen
            if key.endswith(".*"):
                is_there = any(path.startswith(key[:-1]) for path in seen)
            self.assertTrue(is_there, f"{key} is nowhere")

    def pieces(self):
        """Points with other values in each piece, a cell twice, a text, and the name of one of Gmsh's groups."""
        texts = [half(4, side, -8.0, encoding="ascii") for side in (False, True)]
        ids = texts[0].array("connectivity")[4]
        ids[0:4] = ids[4:8]
        texts = [mesh.bytes().decode() for mesh in texts]
        first, second = (re.search("<Piece .*</Piece>", text, re.DOTALL)[0] for text in texts)
        fields = ("<FieldData><Array type='String' Name='note' NumberOfTuples='1' format='ascii'>104 105 0</Array>"
                  "<DataArray type='Int32' Name='gmsh:physical:left' NumberOfTuples='2' format='ascii'>1 3</DataArray></FieldData>")
        return self.write(texts[0].replace(first, fields + first + second).encode(), "pieces.vtu")

    def list_of(self, name, *meshes):
        path = self.folder / name
        steps = "".join(f"<DataSet timestep='{i}' file='{mesh.name}'/>" for i, mesh in enumerate(meshes))
        path.write_text(f"<VTKFile type='Collection'><Collection>{steps}</Collection></VTKFile>")
        return path

    def without(self, report, *keys):
        return {key: value for key, value in report.items() if key not in keys}

    def test_simplify(self):
        expected = self.keys["Reports"] + self.keys["simplify"]
        self.agree(expected[:expected.index("series")],
                   report_of("simplify", self.pieces(), "-o", self.folder / "out.vtu", "--verify", "--max-error", "50%"),
                   report_of("simplify", self.write(TinyVtu()), "-o", self.folder / "out.vtu", "--method", "tetfuse"))

    def test_simplify_steps(self):
        steps = [self.generate("--time", t, tets="2k", name=f"{t}.vtu") for t in (0, 1)]
        out = ["-o", self.folder / "out.pvd", "--reduction", "30%"]
        shared, each = report_of("simplify", *steps, *out), report_of("simplify", *steps, *out, "--series", "each")
        self.assertEqual((shared["series"], each["series"]), ("shared", "each"))
        keys = self.keys["simplify"]
        mine = ("series", "list", "tries", "steps")
        self.agree(keys[keys.index("series"):], {key: shared[key] for key in mine}, {"steps": each["steps"]})
        one = report_of("simplify", steps[0], "-o", self.folder / "out.vtu")
        self.assertEqual(shared.keys() - mine, one.keys())
        self.assertEqual(each["steps"][0]["run"].keys(), one.keys())
        self.agree(self.keys["Reports"], self.without(each, *mine))

    def test_dry_run(self):
        self.agree(["version", "threads"] + self.keys["simplify --dry-run"],
                   report_of("simplify", self.generate(), "-o", self.folder / "out.vtu", "--reduction", "50%", "--dry-run"))

    def test_apply(self):
        mesh, made = self.generate(tets="2k"), self.folder / "out.map"
        run("simplify", mesh, "-o", self.folder / "out.vtu", "--reduction", "30%", "--map", made)
        keys = self.keys["apply"]
        begin = keys.index("path")
        self.agree(self.keys["Reports"] + keys, report_of("apply", made, mesh, "-o", self.folder / "out2.vtu"))
        steps = report_of("apply", made, mesh, self.generate("--time", 1, tets="2k", name="1.vtu"), "-o", self.folder / "out.pvd")
        self.agree(keys[begin:] + ["step", "time"], steps, only="steps")
        self.agree(self.keys["Reports"] + keys[:begin] + ["list"], self.without(steps, "steps"))

    def test_refine(self):
        mesh, made = self.generate(), self.folder / "out.tfp"
        run("simplify", mesh, "-o", self.folder / "out.vtu", "--reduction", "50%", "--max-error", "100%", "--progressive", made)
        self.agree(self.keys["Reports"] + self.keys["refine"],
                   report_of("refine", made, "-o", self.folder / "out2.vtu", "--roi", "sphere=0,0,0,0.2"))

    def test_compare(self):
        meshes = TinyVtu(4), TinyVtu(3)
        for mesh, kind in zip(meshes, ("Float32", "Float64")):
            count = len(mesh.tets)
            mesh.arrays[1:1] = [["CellData", "material", "Int32", 1, [i % 2 for i in range(count)]],
                                ["CellData", "density", kind, 1, [float(i) for i in range(count)]]]
        meshes[1].remove("id")
        pair = [self.write(mesh, f"{i}.vtu") for i, mesh in enumerate(meshes)]
        bounds = ["--max-error", "0.1%", "--surface", "1%"]
        self.agree(self.keys["Reports"] + self.keys["compare"], report_of("compare", *pair, *bounds, code=INVALID))
        lists = [self.list_of(f"{mesh.stem}.pvd", mesh) for mesh in pair]
        steps = report_of("compare", *lists, *bounds, code=INVALID)
        self.agree(self.keys["compare"] + ["time"], steps, only="steps")
        self.agree(self.keys["Reports"] + ["original.path", "simplified.path"], self.without(steps, "steps"))

    def test_check(self):
        keys, unreadable = self.keys["check"], TinyVtu()
        unreadable.array("connectivity")[4][0] = 10**6
        meshes = self.pieces(), self.write(unreadable, "unreadable.vtu")
        self.agree(self.keys["Reports"] + keys, report_of("check", meshes[0], "--fix", self.folder / "fixed.vtu"),
                   report_of("check", meshes[1], code=INVALID))
        steps = report_of("check", self.list_of("list.pvd", *meshes), code=INVALID)
        self.agree([key for key in keys if not key.startswith("fix.")] + ["time"], steps, only="steps")
        self.agree(self.keys["Reports"] + ["path", "valid"], self.without(steps, "steps"))

    def test_info(self):
        shared = self.keys["check"]
        shared = shared[shared.index("points"):shared.index("min_dihedral_deg")]
        shared.remove("nonconforming_faces")
        self.agree(self.keys["Reports"] + self.keys["info"] + shared,
                   report_of("info", self.list_of("list.pvd", self.pieces())))


if __name__ == "__main__":
    main()
