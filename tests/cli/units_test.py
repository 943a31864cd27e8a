#!/usr/bin/env python3
"""Units of arrays, through all that the command makes of a mesh. Usage: units_test.py TETFUSION"""
import re
import unittest
import xml.etree.ElementTree as ElementTree

from harness import FolderTest, finish, main, report_of, run
from independent_check import Vtu

try:
    import vtk
except ImportError:
    vtk = None

# Of arrays that the generator makes; "front" has none.
UNITS = {"temperature": "\u00b0C", "velocity": "m / s", "region": "<rock> & 50%", "TimeValue": "s"}


def escaped(text):
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def with_units(data, units):
    """The .vtu with units as VTK writes them: inside the element, behind the values if they are there."""
    for name, text in units.items():
        key = ('<InformationKey name="L2_NORM_RANGE" location="vtkDataArray" length="2">\n<Value index="0">0</Value>\n'
               '<Value index="1">1</Value>\n</InformationKey>\n<InformationKey name="UNITS_LABEL" location="vtkDataArray">\n'
               f"    {escaped(text)}\n  </InformationKey>\n</DataArray>").encode()
        element = re.compile(rb'(<DataArray [^>]*Name="%s"[^>]*?)(/>|>([^<]*)</DataArray>)' % name.encode())
        data, count = element.subn(lambda m: m[1] + b">" + (m[3] or b"") + key, data, 1)
        assert count == 1, name
    return data


def labels(data):
    """Those that a .vtu or .pvtu says, by array."""
    head, appended, _ = data.partition(b"<AppendedData")
    root = ElementTree.fromstring(head + (b"</VTKFile>" if appended else b""))
    return {a.get("Name"): key.text.strip() for a in root.iter() if a.tag in ("DataArray", "PDataArray", "Array")
            for key in a.findall("InformationKey") if key.get("name") == "UNITS_LABEL"}


def units_by_vtk(path):
    readers = {".vtk": "vtkUnstructuredGridReader", ".vtu": "vtkXMLUnstructuredGridReader", ".pvtu": "vtkXMLPUnstructuredGridReader"}
    reader = getattr(vtk, readers[path.suffix])()
    if path.suffix == ".vtk":
        for what in ("Scalars", "Vectors", "Fields"):
            getattr(reader, f"ReadAll{what}On")()
    reader.SetFileName(str(path))
    reader.Update()
    grid, key = reader.GetOutput(), vtk.vtkDataArray.UNITS_LABEL()
    assert grid.GetNumberOfCells() > 0, path
    units = {}
    for data in (grid.GetPointData(), grid.GetCellData(), grid.GetFieldData()):
        for array in (data.GetArray(i) for i in range(data.GetNumberOfArrays())):
            if array.HasInformation() and array.GetInformation().Has(key):
                units[array.GetName()] = array.GetInformation().Get(key)
    return units


class Units(FolderTest):
    def mesh(self, encoding="raw", units=UNITS):
        plain = self.generate("--time", "2.5", tets="3k", name="plain.vtu")
        run("convert", plain, plain, "--encoding", encoding)
        return self.write(with_units(plain.read_bytes(), units), "mesh.vtu")

    def expect_units(self, path, units=UNITS):
        self.assertEqual({a["name"]: a["units"] for a in report_of("info", path)["arrays"] if a["units"] is not None}, units, path)
        if path.suffix in (".vtu", ".pvtu"):
            ours = labels(path.read_bytes())
            if path.suffix == ".pvtu":  # field data is in the pieces alone
                units = {name: text for name, text in units.items() if name != "TimeValue"}
            self.assertEqual(ours, units, path)
        if vtk and b"<AppendedData" not in path.read_bytes():  # which VTK 9.1 cannot read any more
            theirs = units_by_vtk(path)
            theirs.pop("TimeValue", None)
            self.assertEqual(theirs, {name: text for name, text in units.items() if name != "TimeValue"}, path)

    def test_info_says_them(self):
        path = self.mesh()
        arrays = {a["name"]: a for a in report_of("info", path)["arrays"]}
        self.assertEqual({name: a["units"] for name, a in arrays.items()}, {**UNITS, "front": None})
        text = run("info", path).decode()
        for word in ("velocity (m / s) ", "temperature (\u00b0C) ", "TimeValue (s) ", "front "):
            self.assertIn(word, text)
        self.assertNotIn("front (", text)

    def test_every_encoding_and_legacy_files(self):
        for encoding in ("raw", "zlib", "inline", "ascii"):
            path, out = self.mesh(encoding), self.folder / "out.vtu"
            self.expect_units(path)
            for other in ("raw", "zlib", "lz4", "inline", "ascii"):
                run("convert", path, out, "--encoding", other)
                self.expect_units(out)
            for other in ("raw", "ascii"):
                legacy, back = self.folder / "out.vtk", self.folder / "back.vtu"
                run("convert", path, legacy, "--encoding", other)
                self.assertIn(b"INFORMATION 1\nNAME UNITS_LABEL LOCATION vtkDataArray\nDATA m%20/%20s\n", legacy.read_bytes())
                self.expect_units(legacy)
                run("convert", legacy, back)
                self.expect_units(back)

    def test_what_they_leave_as_it_was(self):
        plain, raw = self.folder / "plain.vtu", self.folder / "raw.vtu"
        run("convert", self.mesh(), raw)
        self.expect_units(raw)
        a, b = Vtu(plain), Vtu(raw)
        self.assertEqual(a.points.tobytes(), b.points.tobytes())
        for kind in ("point", "cell"):
            self.assertEqual({name: values.tobytes() for name, (_, values) in a.arrays[kind].items()},
                             {name: values.tobytes() for name, (_, values) in b.arrays[kind].items()})
        # Formats that have no place for units have one for the values.
        for name in ("out.msh", "out.mesh", "out.ele"):
            units, none = finish("convert", raw, self.folder / name), finish("convert", plain, self.folder / name)
            notices = [result.stderr.splitlines()[:-1] for result in (units, none)]  # the last line has the time
            self.assertEqual((units.returncode, notices[0]), (0, notices[1]))

    def test_they_follow_a_simplification(self):
        path = self.mesh()
        for name in ("out.vtu", "out.vtk", "out.pvtu"):
            out = self.folder / name
            more = ["--pieces", "2"] if name == "out.pvtu" else ["--map", self.folder / "out.map"]
            run("simplify", path, "-o", out, "--reduction", "50%", "--encoding", "ascii", *more)
            self.expect_units(out)
        step = self.write(with_units((self.folder / "plain.vtu").read_bytes(), {**UNITS, "temperature": "K"}), "step.vtu")
        moved = {**UNITS, "temperature": "K"}
        for name in ("moved.vtu", "moved.vtk"):
            run("apply", self.folder / "out.map", step, "-o", self.folder / name)
            self.expect_units(self.folder / name, moved)
        legacy = self.folder / "in.vtk"
        run("convert", path, legacy)
        run("simplify", legacy, "-o", self.folder / "out.vtu", "--reduction", "50%")
        self.expect_units(self.folder / "out.vtu")

    def test_they_are_there_on_the_way_back(self):
        path, back, full = self.mesh(), self.folder / "run.tfp", self.folder / "full.vtu"
        run("convert", path, path)  # ours, to the byte
        run("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "50%", "--progressive", back)
        self.assertEqual(back.read_bytes()[12], 3)
        run("refine", back, "-o", full)
        self.assertEqual(full.read_bytes(), path.read_bytes())
        run("refine", back, "-o", full, "--reduction", "30%")
        self.expect_units(full)
        # What has no units is as it was, for older programs.
        run("simplify", self.folder / "plain.vtu", "-o", self.folder / "out.vtu", "--reduction", "50%", "--progressive", back)
        self.assertEqual(back.read_bytes()[12], 2)
        run("refine", back, "-o", full)
        self.assertEqual(full.read_bytes(), (self.folder / "plain.vtu").read_bytes())
        for only in ({"region": "1"}, {"TimeValue": "h"}):
            run("convert", self.mesh(units=only), path)
            run("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "50%", "--progressive", back)
            run("refine", back, "-o", full)
            self.assertEqual(full.read_bytes(), path.read_bytes())

    def test_they_follow_the_steps_of_a_series(self):
        path = self.mesh()
        steps = [self.write(path.read_bytes(), f"step_{i}.vtu") for i in range(2)]
        run("simplify", *steps, "-o", self.folder / "s_{step}.vtu", "--reduction", "50%")
        outs = sorted(self.folder.glob("s_*.vtu"))
        self.assertEqual(len(outs), 2)
        for out in outs:
            self.expect_units(out)

    @unittest.skipUnless(vtk, "VTK is not installed")
    def test_files_of_vtk(self):
        self.mesh("ascii")
        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(self.folder / "plain.vtu"))
        reader.Update()
        grid, key = reader.GetOutput(), vtk.vtkDataArray.UNITS_LABEL()
        for data in (grid.GetPointData(), grid.GetCellData(), grid.GetFieldData()):
            for name in UNITS:
                if data.HasArray(name):
                    data.GetArray(name).GetInformation().Set(key, UNITS[name])
                    data.GetArray(name).GetRange(-1)  # VTK keeps it as a key, too
        grid.GetPoints().GetData().GetInformation().Set(key, "mm")
        for mode in ("Ascii", "Binary", "Appended"):
            writer = vtk.vtkXMLUnstructuredGridWriter()
            getattr(writer, f"SetDataModeTo{mode}")()
            self.expect_same_by_vtk(writer, grid, "theirs.vtu")
        for kind in (1, 2):
            writer = vtk.vtkUnstructuredGridWriter()
            writer.SetFileType(kind)
            self.expect_same_by_vtk(writer, grid, "theirs.vtk")

    def expect_same_by_vtk(self, writer, grid, name):
        theirs = self.folder / name
        writer.SetFileName(str(theirs))
        writer.SetInputData(grid)
        self.assertEqual(writer.Write(), 1)
        for ours, options in (("ours.vtu", ["--encoding", "inline"]), ("ours.vtk", []), ("ours.vtk", ["--encoding", "ascii"])):
            run("convert", theirs, self.folder / ours, *options)
            self.expect_units(self.folder / ours)


if __name__ == "__main__":
    main()
