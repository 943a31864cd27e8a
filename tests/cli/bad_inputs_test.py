#!/usr/bin/env python3
"""What the command does with bad input: each case gives its exit code and a message that names the file or option, says
what was expected, and leaves nothing behind. Usage: bad_inputs_test.py TETFUSION"""
import gzip
import json
import subprocess

from harness import BAD, IO, USAGE, FolderTest, command, finish, main, run
from tiny_vtu import TinyVtu

CASES = []  # (name, bytes of the input or a function that makes it, arguments, exit code, words in the message)


def file_case(name, data, code, *words, arguments=()):
    CASES.append((name, data, list(arguments), code, words))


def option_case(name, arguments, code, *words):
    CASES.append((name, TinyVtu().bytes(), arguments, code, words))


def changed(change, *arguments, **keywords):
    mesh = TinyVtu(*arguments, **keywords)
    change(mesh)
    return mesh.bytes()


def set_value(name, index, value):
    def change(mesh):
        mesh.array(name)[4][index] = value
    return change


def set_attribute(name, key, value):
    return lambda mesh: mesh.attributes.update({(name, key): value})


def set_count(key, value):
    return lambda mesh: mesh.counts.update({key: value})


def set_member(name, value):
    return lambda mesh: setattr(mesh, name, value)


def cut_after(marker, extra=0):
    data = TinyVtu().bytes()
    return data[:data.index(marker) + len(marker) + extra]


def cut_in_array(name, extra):
    """The file ends `extra` bytes into the array, counted from its size word."""
    mesh = TinyVtu()
    data = mesh.bytes()
    at = data.index(b'encoding="raw">\n_') + len(b'encoding="raw">\n_')
    for array in mesh.arrays:
        if array[1] == name:
            return data[:at + extra]
        at += len(mesh.payload(array))
    raise KeyError(name)


def only_cells_of(kind, size):
    def change(mesh):
        mesh.array("connectivity")[4] = list(range(size)) * len(mesh.tets)
        mesh.array("offsets")[4] = [size * (i + 1) for i in range(len(mesh.tets))]
        mesh.array("types")[4] = [kind] * len(mesh.tets)
    return change


def no_cells(mesh):
    mesh.counts["NumberOfCells"] = "0"
    for name in ("id", "connectivity", "offsets", "types"):
        mesh.array(name)[4] = []


def no_points(mesh):
    no_cells(mesh)
    mesh.counts["NumberOfPoints"] = "0"
    for name in ("temperature", "Points"):
        mesh.array(name)[4] = []


# Files that are not there, or no meshes.
file_case("packed", gzip.compress(TinyVtu().bytes()), BAD, "gzip", "unpack it first")
file_case("missing file", None, IO, "[Nn]o such file")
file_case("directory", "directory", IO, "folder")
file_case("empty file", b"", BAD, "empty")
file_case("garbage", bytes(range(256)) * 10, BAD)
file_case("text", b"solid cube\nendsolid\n", BAD)
file_case("other XML", b'<?xml version="1.0"?><svg></svg>', BAD)
file_case("other VTK type", changed(set_member("file_type", "PolyData")), BAD, "PolyData|UnstructuredGrid")
# Truncated at every structural point.
file_case("cut in the XML head", cut_after(b"<Piece "), BAD)
file_case("a tag that ends another", TinyVtu().bytes().replace(b"</Points>", b"</Pints>"), BAD, "where it says '.*Pints>")
file_case("cut in an attribute", cut_after(b'NumberOfPoints="'), BAD)
file_case("cut before the appended data", cut_after(b"</UnstructuredGrid>"), BAD)
file_case("cut at the underscore", cut_after(b'encoding="raw">\n'), BAD)
file_case("no appended bytes", cut_after(b'encoding="raw">\n_'), BAD)
for array_name in ("temperature", "id", "Points", "connectivity", "offsets", "types"):
    file_case(f"cut in the size word of {array_name}", cut_in_array(array_name, 5), BAD, "cut off|ends")
    file_case(f"cut in {array_name}", cut_in_array(array_name, 40), BAD, "cut off|ends")
# Counts and sizes.
file_case("2^60 points", changed(set_count("NumberOfPoints", str(2**60))), BAD)
file_case("2^60 cells", changed(set_count("NumberOfCells", str(2**60))), BAD)
file_case("2^64 points", changed(set_count("NumberOfPoints", str(2**64))), BAD, "NumberOfPoints")
file_case("negative points", changed(set_count("NumberOfPoints", "-5")), BAD, "NumberOfPoints")
file_case("points that are no number", changed(set_count("NumberOfPoints", "many")), BAD, "NumberOfPoints")
file_case("no count of cells", changed(set_count("NumberOfCells", None)), BAD, "NumberOfCells")
file_case("a point too many", changed(set_count("NumberOfPoints", "126")), BAD)
file_case("a cell too few", changed(set_count("NumberOfCells", "383")), BAD)
file_case("size word too large", changed(lambda m: m.size_words.update(Points=2**62)), BAD, "coordinates")
file_case("size word too small", changed(lambda m: m.size_words.update(Points=12)), BAD, "coordinates")
file_case("size word overflows", changed(lambda m: m.size_words.update(connectivity=2**64 - 8)), BAD, "connectivity")
file_case("offset beyond the file", changed(set_attribute("Points", "offset", "99999999")), BAD, "Points")
file_case("negative offset", changed(set_attribute("Points", "offset", "-8")), BAD, "Points")
file_case("no offset", changed(set_attribute("Points", "offset", None)), BAD, "Points")
file_case("two components", changed(set_attribute("Points", "NumberOfComponents", "2")), BAD, "coordinates", "2")
file_case("no components", changed(set_attribute("temperature", "NumberOfComponents", "0")), BAD, "temperature")
file_case("2^62 components", changed(set_attribute("temperature", "NumberOfComponents", str(2**62))), BAD, "temperature")
file_case("short point array", changed(lambda m: m.array("temperature")[4].pop()), BAD, "temperature")
file_case("short cell array", changed(lambda m: m.array("id")[4].pop()), BAD, "id")
# Cells and coordinates.
file_case("index one too high", changed(set_value("connectivity", 7, 125)), BAD, "125")
file_case("negative index", changed(set_value("connectivity", 7, -1)), BAD, "-1")
file_case("huge index", changed(set_value("connectivity", 7, 2**40)), BAD, str(2**40))
file_case("offset not a multiple of four", changed(set_value("offsets", 3, 17)), BAD)
file_case("offsets that fall", changed(set_value("offsets", 3, 4)), BAD)
file_case("offset past the connectivity", changed(set_value("offsets", 383, 10**9)), BAD)
file_case("NaN coordinate", changed(set_value("Points", 10, float("nan"))), BAD, "point 3")
file_case("infinite coordinate", changed(set_value("Points", 10, float("inf"))), BAD, "point 3")
file_case("hexahedra", changed(only_cells_of(12, 8)), BAD, "hexahedron", "--tetrahedralize")
file_case("one wedge among tetrahedra", changed(set_value("types", 5, 13)), BAD)
file_case("quadratic tetrahedra", changed(only_cells_of(24, 10)), BAD, "--linearize")
file_case("triangles alone", changed(only_cells_of(5, 3)), BAD, "tetrahedr")
file_case("one polyhedron among tetrahedra", changed(set_value("types", 5, 42)), BAD, "polyhedron", "--tetrahedralize")
file_case("one hexagonal prism", changed(set_value("types", 5, 16)), BAD, "hexagonal prism", "Tetrahedralize")
file_case("unknown cell type", changed(set_value("types", 5, 200)), BAD, "200")
file_case("no cells", changed(no_cells), BAD, "no tetrahedr|no cells")
file_case("no points", changed(no_points), BAD)
# Arrays and encodings.
file_case("no Points", changed(lambda m: m.remove("Points")), BAD, "coordinates")
file_case("no connectivity", changed(lambda m: m.remove("connectivity")), BAD, "connectivity")
file_case("no offsets", changed(lambda m: m.remove("offsets")), BAD, "offsets")
file_case("no types", changed(lambda m: m.remove("types")), BAD, "types")
file_case("unknown type", changed(set_attribute("temperature", "type", "Float16")), BAD, "Float16")
file_case("unknown format", changed(set_attribute("temperature", "format", "carved")), BAD, "carved")
file_case("float connectivity", changed(set_attribute("connectivity", "type", "Float64")), BAD, "connectivity")
file_case("unknown compressor", changed(set_member("compressor", "vtkZipDataCompressor")), BAD, "vtkZipDataCompressor")
file_case("unknown byte order", changed(set_member("byte_order", "PDPEndian")), BAD, "PDPEndian")
file_case("unknown header type", changed(set_member("header_type", "UInt16")), BAD, "UInt16")
file_case("corrupt zlib block", changed(lambda m: m.array_bytes.update(Points=b"\x78\x9c" + b"\xff" * 50),
                                        compressor="vtkZLibDataCompressor"), BAD, "coordinates")
file_case("bad base64", changed(set_attribute("Points", "body", "!!!!" * 100), encoding="inline"), BAD, "Points")
file_case("short base64", changed(set_attribute("Points", "body", "AAAA"), encoding="inline"), BAD, "Points")
file_case("a word among ascii numbers", changed(set_attribute("Points", "body", "0 1 2 x"), encoding="ascii"), BAD,
          "Points")
file_case("too few ascii numbers", changed(set_attribute("Points", "body", "0 1 2"), encoding="ascii"), BAD, "Points")
file_case("an ascii number that does not fit", changed(set_attribute("types", "body", "10 " * 383 + "300"),
                                                       encoding="ascii"), BAD, "types")
# Output.
option_case("output folder missing", ["-o", "{out}/no/such/folder/a.vtu"], IO, "no/such/folder")
option_case("output is a folder", ["-o", "{folder}"], IO, "folder")
option_case("read-only file system", ["-o", "/proc/a.vtu"], IO, "/proc")
option_case("full disk", ["-o", "{full}"], IO, "[Ss]pace")
option_case("scratch folder by the name of the output", ["-o", "{out}/a.vtu", "--scratch", "{out}/a.vtu"], USAGE, "is read or written, too", "--scratch")
option_case("scratch folder of somebody else", ["-o", "{out}/a.vtu", "--scratch", "{folder}/.."], USAGE, "holds", "--scratch")
option_case("unknown suffix", ["-o", "{out}/a.stl"], USAGE, "stl|vtu")
option_case("report folder missing", ["-o", "{out}/a.vtu", "--report", "{out}/no/such/r.json"], IO, "no/such")
# Options.
option_case("unknown array", ["--array", "pressure"], USAGE, "pressure", "temperature")
option_case("unknown cell array", ["--array", "cell:pressure"], USAGE, "pressure")
option_case("unknown region array", ["--regions", "pressure"], USAGE, "pressure")
option_case("a bound of one for an array", ["--array", "temperature:1"], USAGE, "--array temperature:1: give 100% or 1%")
option_case("a bound of more than all for an array", ["--array", "temperature:150%"], USAGE, "at most 100% of the field's range")
option_case("a bound of nothing for an array", ["--array", "temperature:0%"], USAGE, "temperature", "0.5%")
option_case("chunks too large for fuse", ["--chunk-tets", "200M"], USAGE, "--chunk-tets", "134217728")
option_case("chunks of nothing", ["--chunk-tets", "0"], USAGE, "--chunk-tets")
option_case("an empty value", ["--reduction", ""], USAGE, "--reduction")
option_case("levels beyond the goal", ["--lods", "50%,80%", "--reduction", "20%", "-o", "{out}/a_{lod}.vtu"], USAGE, "--lods")
option_case("levels beyond the number of tetrahedra", ["--lods", "50%", "--tets", "300", "-o", "{out}/a_{lod}.vtu"], USAGE,
            "--tets")
option_case("the same, tried", ["--lods", "50%", "--tets", "300", "-o", "{out}/a_{lod}.vtu", "--dry-run"], USAGE, "--tets")
option_case("the report in the place of the input", ["--report", "{mesh}"], USAGE, "--report")
option_case("the report in the place of the output", ["--report", "{out}/small.vtu"], USAGE, "--report")
option_case("two goals", ["--reduction", "50%", "--tets", "100"], USAGE, "--reduction", "--tets")
option_case("reduction of more than all", ["--reduction", "150%"], USAGE, "--reduction")
option_case("reduction that is no number", ["--reduction", "much"], USAGE, "much")
option_case("negative reduction", ["--reduction=-10%"], USAGE, "--reduction")
option_case("no tetrahedra left", ["--tets", "0"], USAGE, "--tets")
option_case("tets that are no number", ["--tets", "1x"], USAGE, "1x")
option_case("tolerance of nothing", ["--method", "tetfuse", "--scalar-tolerance", "0"], USAGE, "--scalar-tolerance")
option_case("stretch below one", ["--method", "tetfuse", "--stretch-factor", "0.5"], USAGE, "--stretch-factor")
option_case("aspect below one", ["--method", "tetfuse", "--aspect-ratio", "0.5"], USAGE, "--aspect-ratio")
option_case("integrals with tetfuse", ["--method", "tetfuse", "--conserve"], USAGE, "--conserve", "fuse")
option_case("integrals with a boundary that moves", ["--conserve", "--boundary", "1%"], USAGE, "--conserve", "planar")
option_case("an error of nothing", ["--max-rms", "0"], USAGE, "--max-rms")
option_case("an error that is no number", ["--max-rms", "little"], USAGE, "little", "0.1%")
option_case("a bound of nothing", ["--max-error", "0"], USAGE, "--max-error")
option_case("a bound that is no number", ["--max-error", "little"], USAGE, "little", "1%")
option_case("a bound with tetfuse", ["--method", "tetfuse", "--max-error", "1%"], USAGE, "--max-error", "fuse")
option_case("a quality below none", ["--min-quality=-0.1"], USAGE, "--min-quality")
option_case("a quality that only regular ones have", ["--min-quality", "1"], USAGE, "--min-quality")
option_case("a quality that is no number", ["--min-quality", "good"], USAGE, "good")
option_case("an angle of nothing", ["--boundary", "1%", "--feature-angle", "0"], USAGE, "--feature-angle", "180 degrees")
option_case("an angle that is none", ["--boundary", "1%", "--feature-angle", "sharp"], USAGE, "sharp", "40, or off")
option_case("an angle where nothing moves", ["--feature-angle", "60"], USAGE, "--feature-angle", "--boundary")
option_case("unknown method", ["--method", "quadric"], USAGE, "quadric")
option_case("unknown boundary rule", ["--method", "tetfuse", "--boundary-rule", "edges"], USAGE, "edges")
option_case("a boundary that moves with tetfuse", ["--method", "tetfuse", "--boundary", "1%"], USAGE, "--boundary")
option_case("unknown encoding", ["--encoding", "brotli"], USAGE, "brotli")
option_case("negative threads", ["--threads=-1"], USAGE, "threads")
option_case("regions and none", ["--regions", "none", "--regions", "id"], USAGE, "give it alone")
option_case("levels without a place for them", ["--lods", "50%,80%"], USAGE, "{lod}")
option_case("levels that fall", ["--lods", "80%,50%", "-o", "{out}/a_{lod}.vtu"], USAGE, "--lods")
option_case("no levels", ["--lods", "0", "--reduction", "20%", "-o", "{out}/a_{lod}.vtu"], USAGE, "--lods: give 1 to 1000 levels")
option_case("levels without a goal", ["--lods", "3", "-o", "{out}/a_{lod}.vtu"], USAGE, "--lods")
option_case("a place without levels", ["-o", "{out}/a_{lod}.vtu"], USAGE, "--lods")
option_case("mesh and report to standard output", ["-o", "-", "--report", "-"], USAGE, "standard output")
option_case("not available: --no-such-option", ["--no-such-option"], USAGE, "--no-such-option")


class BadInputs(FolderTest):
    def run_case(self, data, arguments, code, words):
        mesh, out = self.folder / "mesh.vtu", self.folder / "out"
        full, folder = self.folder / "full.vtu", self.folder / "folder.vtu"
        out.mkdir(), folder.mkdir(), full.symlink_to("/dev/full")
        if data == "directory":
            mesh.mkdir()
        elif data is not None:
            mesh.write_bytes(data)
        for word, path in (("{out}", out), ("{full}", full), ("{mesh}", mesh), ("{folder}", folder)):
            arguments = [a.replace(word, str(path)) for a in arguments]
        if "-o" not in arguments:
            arguments += ["-o", str(out / "small.vtu")]
        result = finish("simplify", mesh, *arguments)
        message = result.stderr.decode()
        self.assertEqual(result.returncode, code, message)
        self.assertIn("tetfusion: error: ", message)
        self.assertEqual(result.stdout, b"")
        if code in (BAD, IO) and "-o" not in arguments[:-2] and data != TinyVtu().bytes():
            self.assertIn("mesh.vtu", message)
        for word in words:
            self.assertRegex(message, word.replace("{lod}", r"\{lod\}"))
        self.assertGreater(len(message.split()), 5, message)
        self.assertEqual(list(out.iterdir()), [], "something was left behind")
        self.assertLessEqual(set(self.files()), {"full.vtu", "folder.vtu", "mesh.vtu", "out"})
        if isinstance(data, bytes) and data:
            self.assertEqual(mesh.read_bytes(), data, "the input was changed")

    def test_the_unchanged_mesh_is_good(self):
        for encoding, compressor in (("raw", None), ("raw", "vtkZLibDataCompressor"), ("inline", None), ("ascii", None)):
            out = self.folder / f"{encoding}_{compressor}.vtu"
            run("simplify", self.write(TinyVtu(encoding=encoding, compressor=compressor)), "-o", out, "--quiet", "--reduction", "10%")
            self.assertTrue(out.exists())

    def test_a_broken_standard_error_ends_no_job(self):
        mesh = self.write(TinyVtu())
        outputs = set()
        for number, redirection in enumerate(("2>/dev/null", "2>&-", "2>/dev/full", "2>&- >&- <&-")):
            out = self.folder / f"small{number}.vtu"
            subprocess.run(f'"{command()}" simplify "{mesh}" -o "{out}" -v --progress always {redirection}', shell=True, check=True)
            outputs.add(out.read_bytes())
        self.assertEqual(len(outputs), 1)

    def test_a_closed_standard_output_gets_nothing(self):
        mesh = self.write(TinyVtu())
        for line in ("simplify {} -o - --reduction 10%", "convert {} -", "info {}", "check {} --report -"):
            result = subprocess.run(f'"{command()}" {line.format(mesh)} >&-', shell=True, capture_output=True)
            self.assertEqual(result.returncode, IO, line)
            self.assertIn(b"standard output", result.stderr)

    def test_files_of_other_commands_are_known(self):
        mesh = self.write(TinyVtu())
        run("simplify", mesh, "-o", self.folder / "out.vtu", "--progressive", self.folder / "run.tfp", "--reduction", "10%")
        run("simplify", mesh, "-o", self.folder / "out.vtu", "--map", self.folder / "out.map", "--reduction", "10%")
        for name, said in (("run.tfp", b"'tetfusion refine' makes meshes of it"), ("out.map", b"it is for 'tetfusion apply'")):
            result = finish("info", self.folder / name)
            self.assertEqual(result.returncode, BAD)
            self.assertIn(said, result.stderr)

    def test_a_name_that_is_not_utf8(self):
        mesh = self.write(TinyVtu(), "caf\udce9.vtu")  # the byte 0xe9
        for name, *output in (("simplify", "-o", self.folder / "out.vtu"), ("check",), ("info",)):
            result = finish(name, mesh, *output, "--quiet", "--report", "-")
            self.assertEqual((result.returncode, result.stderr), (0, b""), name)
            self.assertIn("caf", repr(json.loads(result.stdout)))

    def test_wrong_usage_says_whose_help_says_more(self):
        for arguments, message in ((["simplfy", "a.vtu"], b"there is no command \"simplfy\"; see 'tetfusion --help'"),
                                   (["convert", "a.vtu"], b"see 'tetfusion convert --help'"),
                                   (["simplify", "a.vtu", "-o", "b.vtu", "--tets", "1", "--tets", "2"],
                                    b"--tets is given more than once: give it once; see 'tetfusion simplify --help'"),
                                   (["simplify", "--no-such-option"], b"see 'tetfusion simplify --help'"),
                                   ([], b"see 'tetfusion --help'")):
            result = finish(*arguments)
            self.assertEqual(result.returncode, USAGE, arguments)
            self.assertIn(message, result.stderr)

    def test_empty_names(self):
        """As of variables that are not set."""
        mesh = self.write(TinyVtu())
        for arguments in (["simplify", "", "-o", "a.vtu"], ["simplify", mesh, "", "-o", "a.pvd"], ["simplify", mesh, "-o", ""],
                          ["info", ""], ["check", ""], ["compare", "", mesh], ["compare", mesh, ""], ["convert", "", "a.vtu"],
                          ["convert", mesh, ""], ["apply", "", mesh, "-o", "a.vtu"], ["apply", "a.map", "", "-o", "a.vtu"],
                          ["apply", "a.map", mesh, "-o", ""], ["refine", "", "-o", "a.vtu"], ["refine", "a.tfp", "-o", ""],
                          ["generate", "five", "-o", ""]):
            result = finish(*arguments, cwd=self.folder)
            self.assertEqual(result.returncode, USAGE, arguments)
            self.assertIn(b"the value is empty", result.stderr, arguments)

    def test_values_between_commas(self):
        result = finish("simplify", self.write(TinyVtu()), "-o", self.folder / "a.vtu", "--scalar-tolerance", "0.1,,0.2")
        self.assertEqual(result.returncode, USAGE)
        self.assertIn(b"--scalar-tolerance 0.1,,0.2: a value is missing at a comma", result.stderr)

    def test_wrong_usage_of_the_command(self):
        for arguments in ([], ["frobnicate"], ["simplify"], ["simplify", "a.vtu"], ["check"], ["info"],
                          ["convert", "a.vtu"], ["generate", "six", "-o", "a.vtu"]):
            result = finish(*arguments)
            self.assertEqual(result.returncode, USAGE, arguments)
            self.assertIn(b"tetfusion: error: ", result.stderr)
            self.assertIn(b"--help", result.stderr)


def add_case(number, case):
    name, data, arguments, code, words = case
    slug = "".join(c if c.isalnum() else "_" for c in name)
    setattr(BadInputs, f"test_{number:03}_{slug}", lambda self: self.run_case(data, arguments, code, words))


for case_number, bad_case in enumerate(CASES):
    add_case(case_number, bad_case)

if __name__ == "__main__":
    main()
