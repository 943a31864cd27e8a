#!/usr/bin/env python3
"""Legacy .vtk files from outside, and what VTK and meshio say to ours. Usage: legacy_test.py TETFUSION"""
import itertools
import pathlib
import unittest

import numpy as np

from harness import BAD, USAGE, FolderTest, finish, main, report_of, run, sanitized
from independent_check import Vtu
from tiny_vtu import TinyVtu

try:
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError:
    vtk = None
try:
    import meshio
except ImportError:
    meshio = None

TETS = [(0, 1, 2, 3), (4, 1, 3, 2)]
POINTS = [(0, 0, 0), (1, 0, 0.1), (0, 1, 0), (0, 0, 1), (1, 1, -1)]
# Of VTK, by the name that its class has.
TYPES = ("SignedChar", "UnsignedChar", "Short", "UnsignedShort", "Int", "UnsignedInt", "LongLong", "UnsignedLongLong",
         "Float", "Double")


def add(data, name, kind, values, components=1, active=None, names=()):
    array = getattr(vtk, f"vtk{kind}Array")()
    array.SetName(name)
    array.SetNumberOfComponents(components)
    for row in np.reshape(values, (-1, components)):
        array.InsertNextTuple(tuple(float(v) for v in row))
    for k, component in enumerate(names):
        array.SetComponentName(k, component)
    data.AddArray(array)
    if active:
        getattr(data, "Set" + active)(array)


def sample():
    """A grid of two tetrahedra, a triangle, a line and a vertex, with arrays of all types and all attributes."""
    grid, points = vtk.vtkUnstructuredGrid(), vtk.vtkPoints()
    points.SetDataTypeToDouble()
    for p in POINTS:
        points.InsertNextPoint(p)
    grid.SetPoints(points)
    for kind, ids in [(10, t) for t in TETS] + [(5, (1, 2, 3)), (3, (0, 1)), (1, (4,))]:
        grid.InsertNextCell(kind, len(ids), ids)
    of_points, of_cells = grid.GetPointData(), grid.GetCellData()
    count = lambda n: np.arange(5.0 * n) + 0.25
    add(of_points, "two words", "Float", count(1), active="Scalars")
    add(of_points, "100%", "Double", count(2), 2, names=("in plane", "across"))
    add(of_points, "v", "Double", count(3), 3, "Vectors")
    add(of_points, "n", "Float", count(3), 3, "Normals")
    add(of_points, "t", "Double", count(9), 9, "Tensors")
    add(of_points, "uv", "Float", count(2), 2, "TCoords")
    add(of_points, "gid", "LongLong", range(5, 10), 1, "GlobalIds")
    add(of_points, "pid", "Int", range(5), 1, "PedigreeIds")
    for kind in TYPES:
        add(of_cells, kind, kind, [1, 0, 3, 4, 100], active="Scalars" if kind == "Int" else None)
    text = vtk.vtkStringArray()
    text.SetName("a title")
    for value in ("some words", "", "100 % \u00e9\n", "x" * 100, "y" * 20000):
        text.InsertNextValue(value)
    grid.GetFieldData().AddArray(text)
    add(grid.GetFieldData(), "TimeValue", "Double", [0.5])
    return grid


def read(path):
    if pathlib.Path(path).suffix == ".vtu":
        reader = vtk.vtkXMLUnstructuredGridReader()
    else:
        reader = vtk.vtkUnstructuredGridReader()
        for what in ("Scalars", "Vectors", "Normals", "Tensors", "TCoords", "Fields"):
            getattr(reader, f"ReadAll{what}On")()
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetErrorCode() == 0, path
    return reader.GetOutput()


class Legacy(FolderTest):
    def assert_equal(self, one, other):
        """The same cells in the same order, and arrays in theirs: names, types, components, values, what is active."""
        np.testing.assert_array_equal(vtk_to_numpy(one.GetPoints().GetData()), vtk_to_numpy(other.GetPoints().GetData()))
        for part in (lambda g: g.GetCells().GetConnectivityArray(), lambda g: g.GetCells().GetOffsetsArray(),
                     lambda g: g.GetCellTypesArray()):
            np.testing.assert_array_equal(vtk_to_numpy(part(one)), vtk_to_numpy(part(other)))
        for of in ("GetPointData", "GetCellData", "GetFieldData"):
            a, b = getattr(one, of)(), getattr(other, of)()
            self.assertEqual(self.names(a), self.names(b))
            for i in range(a.GetNumberOfArrays()):
                self.assert_same_array(a.GetAbstractArray(i), b.GetAbstractArray(i))
            if of == "GetFieldData":
                continue
            for k in range(7):  # VTK's attributes, up to pedigree ids
                x, y = a.GetAbstractAttribute(k), b.GetAbstractAttribute(k)
                self.assertEqual(x and x.GetName(), y and y.GetName(), k)

    @staticmethod
    def names(data):
        return [data.GetAbstractArray(i).GetName() for i in range(data.GetNumberOfArrays())]

    def assert_same_array(self, a, b):
        components = a.GetNumberOfComponents()
        self.assertEqual((components, a.GetNumberOfTuples()), (b.GetNumberOfComponents(), b.GetNumberOfTuples()))
        if isinstance(a, vtk.vtkStringArray):
            self.assertEqual([a.GetValue(i) for i in range(a.GetNumberOfValues())],
                             [b.GetValue(i) for i in range(b.GetNumberOfValues())])
            return
        # A text has an empty name where there is none.
        self.assertEqual([a.GetComponentName(k) or "" for k in range(components)],
                         [b.GetComponentName(k) or "" for k in range(components)])
        x, y = vtk_to_numpy(a), vtk_to_numpy(b)
        self.assertEqual(x.dtype, y.dtype, a.GetName())
        np.testing.assert_array_equal(x, y)

    def vtk_file(self, grid, version, binary):
        path = self.folder / "theirs.vtk"
        writer = vtk.vtkUnstructuredGridWriter()
        writer.SetFileVersion(version)
        writer.SetFileType(2 if binary else 1)
        writer.SetFileName(str(path))
        writer.SetInputData(grid)
        self.assertEqual(writer.Write(), 1)
        return path

    @unittest.skipUnless(vtk, "VTK is not installed")
    def test_vtk_and_we_read_one_another(self):
        ours, grid = self.folder / "ours.vtu", sample()
        for version, binary in itertools.product((42, 51), (False, True)):
            theirs = self.vtk_file(grid, version, binary)
            run("convert", theirs, ours)
            # As VTK reads its own file: text has less digits, and ids may have other types.
            self.assert_equal(read(ours), read(theirs))
            for encoding in ("raw", "ascii"):
                run("convert", ours, self.folder / "ours.vtk", "--encoding", encoding)
                self.assert_equal(read(self.folder / "ours.vtk"), read(ours))
                run("convert", self.folder / "ours.vtk", self.folder / "back.vtu")
                self.assertEqual((self.folder / "back.vtu").read_bytes(), ours.read_bytes())

    @unittest.skipUnless(vtk, "VTK is not installed")
    def test_an_array_that_is_active_as_two_kinds(self):
        """VTK writes it twice."""
        grid = sample()
        add(grid.GetPointData(), "both", "Float", range(15), 3, "Scalars", names=("", "up"))
        grid.GetPointData().SetActiveVectors("both")
        for version, binary in itertools.product((42, 51), (False, True)):
            theirs, ours = self.vtk_file(grid, version, binary), self.folder / "ours.vtu"
            run("convert", theirs, ours)
            self.assert_equal(read(ours), read(theirs))
            self.assertEqual(read(ours).GetPointData().GetScalars().GetName(), "both")
            for encoding in ("raw", "ascii"):
                run("convert", ours, self.folder / "ours.vtk", "--encoding", encoding)
                self.assert_equal(read(self.folder / "ours.vtk"), read(ours))
                run("convert", self.folder / "ours.vtk", self.folder / "back.vtu")
                self.assertEqual((self.folder / "back.vtu").read_bytes(), ours.read_bytes())

    @unittest.skipUnless(vtk, "VTK is not installed")
    def test_vtk_reads_what_simplify_writes(self):
        original = self.generate("--double", "--jitter", "0.3", tets="5k")
        for encoding in ("raw", "ascii"):
            run("simplify", original, "-o", self.folder / "a.vtk", "--reduction", "60%", "--encoding", encoding)
            run("simplify", original, "-o", self.folder / "a.vtu", "--reduction", "60%")
            self.assert_equal(read(self.folder / "a.vtk"), read(self.folder / "a.vtu"))

    @unittest.skipUnless(meshio, "meshio is not installed")
    def test_meshio_and_we_read_one_another(self):
        mesh = meshio.Mesh(np.array(POINTS), [("tetra", np.array(TETS)), ("triangle", np.array([[1, 2, 3]]))])
        mesh.point_data = {"T": np.arange(5.0), "v": np.arange(15.0).reshape(5, 3)}
        mesh.cell_data = {"stress": [np.array([0.5, 2.5]), np.array([4.5])]}
        out, ours = self.folder / "out.vtu", self.folder / "ours.vtk"
        for kind, binary in itertools.product(("vtk42", "vtk51"), (False, True)):
            theirs = self.folder / "theirs.vtk"
            meshio.write(theirs, mesh, file_format=kind, binary=binary)
            run("convert", theirs, out)
            found = Vtu(out)
            np.testing.assert_array_equal(found.points, mesh.points)
            np.testing.assert_array_equal(found.tets, TETS)
            np.testing.assert_array_equal(found.arrays["point"]["T"][1].ravel(), mesh.point_data["T"])
            np.testing.assert_array_equal(found.arrays["point"]["v"][1], mesh.point_data["v"])
            np.testing.assert_array_equal(found.arrays["cell"]["stress"][1].ravel(), [0.5, 2.5, 4.5])
            run("convert", theirs, ours, *([] if binary else ["--encoding", "ascii"]))
            back = meshio.read(ours)
            np.testing.assert_array_equal(back.points, mesh.points)
            np.testing.assert_array_equal(back.cells_dict["tetra"], TETS)
            np.testing.assert_array_equal(back.cells_dict["triangle"], [[1, 2, 3]])
            for name, values in mesh.point_data.items():
                np.testing.assert_array_equal(back.point_data[name], values)
            np.testing.assert_array_equal(np.concatenate(back.cell_data["stress"]), [0.5, 2.5, 4.5])

    def test_arrays_called_like_a_keyword(self):
        for name in ("metadata", "MetaData", "metadata_2", "FIELD", "NULL_ARRAY", "CELL_DATA", "meta"):
            mesh = TinyVtu(2)
            mesh.array("id")[1] = name
            mesh.arrays.insert(1, ["CellData", "first", "Int32", 1, list(range(len(mesh.tets)))])
            original = Vtu(self.write(mesh))
            for encoding in ("raw", "ascii"):
                run("convert", self.folder / "mesh.vtu", self.folder / "a.vtk", "--encoding", encoding)
                run("convert", self.folder / "a.vtk", self.folder / "back.vtu")
                back = Vtu(self.folder / "back.vtu").arrays["cell"]
                self.assertEqual(list(back), list(original.arrays["cell"]))
                np.testing.assert_array_equal(back[name][1], original.arrays["cell"][name][1])
            if vtk:
                data = read(self.folder / "a.vtk").GetCellData()
                self.assertEqual({data.GetArrayName(i) for i in range(data.GetNumberOfArrays())}, set(back))

    def test_standard_input_and_encodings(self):
        original = self.generate("--jitter", "0.3", tets="5k")
        for encoding in ("raw", "ascii"):
            path = self.folder / f"{encoding}.vtk"
            run("convert", original, path, "--encoding", encoding)
            run("convert", "-", self.folder / "out.vtu", input=path.read_bytes())
            self.assertEqual((self.folder / "out.vtu").read_bytes(), original.read_bytes())
        for encoding in ("zlib", "lz4", "inline"):
            run("convert", original, self.folder / "a.vtk", "--encoding", encoding, code=USAGE)

    def test_bad_files_say_what_and_where(self):
        path, text = self.folder / "a.vtk", self.folder / "b.vtk"
        run("convert", self.generate("--jitter", "0.3", tets="1k"), path)
        run("convert", path, text, "--encoding", "ascii")
        whole, lines = path.read_bytes(), text.read_text().split("\n")
        for bytes_, words in ((whole[: len(whole) // 4], b"byte "), (whole[:60], b"expected DATASET"),
                              (whole.replace(b"POINTS ", b"POINTS 1"), b"byte "),
                              (whole.replace(b"BINARY", b"TEXT"), b"line 3"),
                              ("\n".join(lines[:50]).encode(), b"cut off or damaged"),
                              ("\n".join(lines).replace("CELL_TYPES ", "CELL_TYPES 1").encode(), b"CELL_TYPES"),
                              (b"# vtk DataFile Version 3.0\n", b"line 3")):
            path.write_bytes(bytes_)
            result = finish("info", path)
            self.assertEqual(result.returncode, BAD, result.stderr)
            self.assertIn(words, result.stderr)
            self.assertIn(b"a.vtk: ", result.stderr)

    def test_meshes_larger_than_memory(self):
        """In every format: the same bytes as with the whole mesh in memory, and no more memory than was allowed."""
        original = self.generate("--jitter", "0.3", tets="800k")
        for suffix in (".vtk", ".msh", ".meshb"):
            path, out = self.folder / ("in" + suffix), self.folder / ("out" + suffix)
            run("convert", original, path)
            whole = report_of("simplify", path, "-o", out, "--reduction", "90%", "--quiet", "--memory", "4G")
            expected = out.read_bytes()
            report = report_of("simplify", path, "-o", out, "--reduction", "90%", "--quiet", "--memory", "160M", "--threads", "1")
            self.assertEqual(out.read_bytes(), expected)
            if not sanitized():
                self.assertLess(report["peak_rss_bytes"], 160 << 20)
                self.assertLess(report["peak_rss_bytes"], whole["peak_rss_bytes"])

    def test_arrays_that_are_wider_than_the_mesh(self):
        """Windows of the input have fewer rows then: 40 numbers a cell take no more memory than was allowed."""
        mesh = Vtu(self.generate("--jitter", "0.3", tets="200k"))
        path, out = self.folder / "wide.vtu", self.folder / "out.vtu"
        count = len(mesh.tets)
        numbers = np.arange(40 * count, dtype=np.float64)
        blocks = [mesh.points[:, 0].astype(np.float64), numbers, mesh.points.astype(np.float64), mesh.tets.astype(np.int64),
                  4 * np.arange(1, count + 1, dtype=np.int64), np.full(count, 10, np.uint8)]
        offsets = np.cumsum([0] + [8 + b.nbytes for b in blocks])

        def array(i, type, name, components=1):
            return f'<DataArray type="{type}" Name="{name}" NumberOfComponents="{components}" format="appended" offset="{offsets[i]}"/>'

        with open(path, "wb") as file:
            file.write(f'''<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64"><UnstructuredGrid>
<Piece NumberOfPoints="{len(mesh.points)}" NumberOfCells="{count}"><PointData>{array(0, "Float64", "f")}</PointData>
<CellData>{array(1, "Float64", "wide", 40)}</CellData><Points>{array(2, "Float64", "xyz", 3)}</Points><Cells>
{array(3, "Int64", "connectivity")}{array(4, "Int64", "offsets")}{array(5, "UInt8", "types")}</Cells></Piece></UnstructuredGrid>
<AppendedData encoding="raw">_'''.encode())
            for block in blocks:
                file.write(np.uint64(block.nbytes).tobytes() + block.tobytes())
        options = ["simplify", path, "-o", out, "--reduction", "80%", "--chunk-tets", "20k", "--quiet", "--threads", "1"]
        run(*options, "--memory", "4G")
        expected = out.read_bytes()
        report = report_of(*options, "--memory", "110M")
        self.assertEqual(out.read_bytes(), expected)
        if not sanitized():
            self.assertLess(report["peak_rss_bytes"], 110 << 20)
        # Its sample is smaller there, too.
        estimate = report_of(*options, "--memory", "110M", "--dry-run")["estimate"]
        self.assertLess(estimate["sample_tets"], report_of(*options, "--memory", "4G", "--dry-run")["estimate"]["sample_tets"])
        self.assertGreater(estimate["reduction"], 0.8)


if __name__ == "__main__":
    main()
