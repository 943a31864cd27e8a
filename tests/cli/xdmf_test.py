#!/usr/bin/env python3
"""XDMF files with HDF5 files beside them, as other programs write both. Usage: xdmf_test.py TETFUSION"""
import signal

import numpy as np

from follow_test import jittered, values
from harness import BAD, INVALID, MEMORY, USAGE, finish, main, report_of, run
from independent_check import Vtu
from solvers_test import GOAL, TIMES, SolverTest

try:
    import h5py
except ImportError:
    h5py = None

DOCTYPE = '<?xml version="1.0"?>\n<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>\n'


class XdmfTest(SolverTest):
    def setUp(self):
        if h5py is None:
            self.skipTest("h5py is not installed")
        super().setUp()
        self.points = self.points.astype("f8")
        self.outside = self.skin()

    def skin(self):
        seen = {}
        for tet in self.tets:
            for face in ([1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]):
                seen.setdefault(tuple(sorted(tet[face])), []).append(tet[face])
        return np.array([f[0] for f in seen.values() if len(f) == 1])

    def number(self, step):
        return np.full(len(self.tets), step, dtype="i4")

    def store(self, name="run.h5", **arrays):
        """Data sets by their paths, with slashes for double underscores."""
        with h5py.File(self.folder / name, "a") as file:
            for path, values in arrays.items():
                file[path.replace("__", "/")] = values

    def xml(self, text, name="run.xdmf"):
        return self.write(text.encode(), name)

    def expect_steps(self, path, names=("heat", "number")):
        report = report_of("info", path)
        self.assertEqual((report["time_steps"], report["tets"], report["format"]), (TIMES, len(self.tets), "XDMF file, read with VTK"))
        for step in range(len(TIMES)):
            mesh, told = self.converted(path, "--time-step", step)
            self.assertNotIn("left out", told)
            np.testing.assert_array_equal(mesh.points, self.points)
            np.testing.assert_array_equal(mesh.tets, self.tets)
            if "heat" in names:
                np.testing.assert_array_equal(values(mesh, "heat"), self.heat(step))
            if "number" in names:
                np.testing.assert_array_equal(mesh.arrays["cell"]["number"][1][:, 0], self.number(step))
            ranges = {a["name"]: a["ranges"] for a in report_of("info", path, "--time-step", step)["arrays"]}
            self.assertEqual(ranges["TimeValue"], [[TIMES[step]] * 2])
        return mesh

    # Dialects: each writes the whole series.

    def fenics(self):
        """XDMFFile.write(u, t) of FEniCS 2019: steps take their mesh from the first one."""
        self.store(Mesh__0__mesh__topology=self.tets.astype("i8"), Mesh__0__mesh__geometry=self.points)
        steps = ""
        for i, time in enumerate(TIMES):
            self.store(**{f"VisualisationVector__{i}": self.heat(i).reshape(-1, 1), f"Cells__{i}": self.number(i).reshape(-1, 1)})
            mesh = f"""<Topology NumberOfElements="{len(self.tets)}" TopologyType="Tetrahedron" NodesPerElement="4">
          <DataItem Dimensions="{len(self.tets)} 4" NumberType="UInt" Format="HDF">run.h5:/Mesh/0/mesh/topology</DataItem>
        </Topology>
        <Geometry GeometryType="XYZ">
          <DataItem Dimensions="{len(self.points)} 3" Format="HDF">run.h5:/Mesh/0/mesh/geometry</DataItem>
        </Geometry>"""
            again = ('<xi:include xpointer="xpointer(//Grid[@Name=&quot;TimeSeries&quot;]/Grid[1]/*[self::Topology or self::Geometry])" />')
            steps += f"""
      <Grid{"" if i else ' Name="mesh" GridType="Uniform"'}>
        {again if i else mesh}
        <Time Value="{time}" />
        <Attribute Name="heat" AttributeType="Scalar" Center="Node">
          <DataItem Dimensions="{len(self.points)} 1" Format="HDF">run.h5:/VisualisationVector/{i}</DataItem>
        </Attribute>
        <Attribute Name="number" AttributeType="Scalar" Center="Cell">
          <DataItem Dimensions="{len(self.tets)} 1" Format="HDF">run.h5:/Cells/{i}</DataItem>
        </Attribute>
      </Grid>"""
        return self.xml(DOCTYPE + f"""<Xdmf Version="3.0" xmlns:xi="http://www.w3.org/2001/XInclude">
  <Domain>
    <Grid Name="TimeSeries" GridType="Collection" CollectionType="Temporal">{steps}
    </Grid>
  </Domain>
</Xdmf>
""")

    def fenicsx(self, more="", functions=("heat",)):
        """dolfinx.io.XDMFFile: the mesh, then a collection for each function."""
        self.store(Mesh__mesh__topology=self.tets.astype("i8"), Mesh__mesh__geometry=self.points)
        collections = ""
        for name in functions:
            collections += f'    <Grid Name="{name}" GridType="Collection" CollectionType="Temporal">\n'
            for i, time in enumerate(TIMES):
                at_points = name == "heat"
                self.store(**{f"Function__{name}__{i}": (self.heat(i) if at_points else self.number(i)).reshape(-1, 1)})
                collections += f"""      <Grid Name="{name}" GridType="Uniform">
        <xi:include xpointer="xpointer(/Xdmf/Domain/Grid[@GridType='Uniform'][1]/*[self::Topology or self::Geometry])" />
        <Time Value="{time}" />
        <Attribute Name="{name}" AttributeType="Scalar" Center="{"Node" if at_points else "Cell"}">
          <DataItem Dimensions="{len(self.points) if at_points else len(self.tets)} 1" Format="HDF">run.h5:/Function/{name}/{i}</DataItem>
        </Attribute>
      </Grid>
"""
            collections += "    </Grid>\n"
        return self.xml(DOCTYPE + f"""<Xdmf Version="3.0" xmlns:xi="https://www.w3.org/2001/XInclude">
  <Domain>
    <Grid Name="mesh" GridType="Uniform">
      <Topology TopologyType="Tetrahedron" NumberOfElements="{len(self.tets)}" NodesPerElement="4">
        <DataItem Dimensions="{len(self.tets)} 4" NumberType="Int" Format="HDF">run.h5:/Mesh/mesh/topology</DataItem>
      </Topology>
      <Geometry GeometryType="XYZ">
        <DataItem Dimensions="{len(self.points)} 3" Format="HDF">run.h5:/Mesh/mesh/geometry</DataItem>
      </Geometry>
    </Grid>
{more}{collections}  </Domain>
</Xdmf>
""")

    def tags(self, name, kind, cells, tags):
        """MeshTags of dolfinx."""
        self.store(**{f"MeshTags__{name}__topology": cells.astype("i8"), f"MeshTags__{name}__Values": tags.reshape(-1, 1)})
        return f"""    <Grid Name="{name}" GridType="Uniform">
      <xi:include xpointer="xpointer(/Xdmf/Domain/Grid[@GridType='Uniform'][1]/Geometry)" />
      <Topology TopologyType="{kind}" NumberOfElements="{len(cells)}" NodesPerElement="{cells.shape[1]}">
        <DataItem Dimensions="{len(cells)} {cells.shape[1]}" NumberType="Int" Format="HDF">run.h5:/MeshTags/{name}/topology</DataItem>
      </Topology>
      <Attribute Name="{name}" AttributeType="Scalar" Center="Cell">
        <DataItem Dimensions="{len(cells)} 1" Format="HDF">run.h5:/MeshTags/{name}/Values</DataItem>
      </Attribute>
    </Grid>
"""

    def meshio(self):
        """meshio.xdmf.TimeSeriesWriter; the series comes before the mesh that it names."""
        self.store(data0=self.points, data1=self.tets.astype("i8"))
        steps = ""
        for i, time in enumerate(TIMES):
            self.store(**{f"data{2 * i + 2}": self.heat(i), f"data{2 * i + 3}": self.number(i)})
            steps += (f'<Grid><ns0:include xmlns:ns0="http://www.w3.org/2003/XInclude" '
                      f'xpointer="xpointer(//Grid[@Name=&quot;mesh&quot;]/*[self::Topology or self::Geometry])" /><Time Value="{time}" />'
                      f'<Attribute Name="heat" AttributeType="Scalar" Center="Node"><DataItem DataType="Float" Dimensions="{len(self.points)}" '
                      f'Format="HDF" Precision="4">run.h5:/data{2 * i + 2}</DataItem></Attribute>'
                      f'<Attribute Name="number" AttributeType="Scalar" Center="Cell"><DataItem DataType="Int" Dimensions="{len(self.tets)}" '
                      f'Format="HDF" Precision="4">run.h5:/data{2 * i + 3}</DataItem></Attribute></Grid>')
        return self.xml(f'<Xdmf Version="3.0"><Domain><Grid Name="TimeSeries_meshio" GridType="Collection" CollectionType="Temporal">{steps}</Grid>'
                        f'<Grid Name="mesh" GridType="Uniform"><Geometry GeometryType="XYZ"><DataItem DataType="Float" '
                        f'Dimensions="{len(self.points)} 3" Format="HDF" Precision="8">run.h5:/data0</DataItem></Geometry>'
                        f'<Topology TopologyType="Tetrahedron" NumberOfElements="{len(self.tets)}" NodesPerElement="4"><DataItem DataType="Int" '
                        f'Dimensions="{len(self.tets)} 4" Format="HDF" Precision="8">run.h5:/data1</DataItem></Topology></Grid></Domain></Xdmf>')

    def seissol(self, form="HDF"):
        """A collection for each step, arrays of cells as rows of one data set; or all in binary files."""
        cells, points = len(self.tets), len(self.points)
        numbers = np.array([self.number(i) for i in range(len(TIMES))])
        if form == "HDF":
            self.store("run_vertex.h5", mesh0__geometry=self.points)
            self.store("run_cell.h5", mesh0__connect=self.tets.astype("u8"), mesh0__number=numbers)
            geometry, connect, number = "run_vertex.h5:/mesh0/geometry", "run_cell.h5:/mesh0/connect", "run_cell.h5:/mesh0/number"
        else:
            geometry, connect, number = (f"run_cell/mesh0/{name}.bin" for name in ("geometry", "connect", "number"))
            (self.folder / "run_cell" / "mesh0").mkdir(parents=True)
            for name, array in (geometry, self.points), (connect, self.tets.astype("u8")), (number, numbers):
                (self.folder / name).write_bytes(array.tobytes())
        steps = ""
        for i, time in enumerate(TIMES):
            steps += f"""
  <Grid Name="TimeSeries" GridType="Collection" CollectionType="Temporal">
   <Grid Name="step_{i:012}" GridType="Uniform">
    <Topology TopologyType="Tetrahedron" NumberOfElements="{cells}">
     <DataItem NumberType="Int" Precision="8" Format="{form}" Dimensions="{cells} 4">{connect}</DataItem>
    </Topology>
    <Geometry name="geo" GeometryType="XYZ" NumberOfElements="{points}">
     <DataItem NumberType="Float" Precision="8" Format="{form}" Dimensions="{points} 3">{geometry}</DataItem>
    </Geometry>
    <Time Value="{time}"/>
    <Attribute Name="number" Center="Cell">
     <DataItem ItemType="HyperSlab" Dimensions="{cells}">
      <DataItem NumberType="UInt" Precision="4" Format="XML" Dimensions="3 2">{i} 0 1 1 1 {cells}</DataItem>
      <DataItem NumberType="Int" Precision="4" Format="{form}" Dimensions="{i + 1} {cells}">{number}</DataItem>
     </DataItem>
    </Attribute>
   </Grid>
  </Grid>"""
        return self.xml(f'<?xml version="1.0" ?>\n<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>\n<Xdmf Version="2.0">\n <Domain>{steps}\n </Domain>\n</Xdmf>\n')

    def pylith(self):
        """An entity for the file, references to items of the domain, a list of times, cells that are floating-point numbers."""
        cells, points = len(self.tets), len(self.points)
        self.store(topology__cells=self.tets.astype("f8"), geometry__vertices=self.points,
                   vertex_fields__heat=np.array([self.heat(i)[:, None] for i in range(len(TIMES))]),
                   vertex_fields__displacement=np.array([self.points * i for i in range(len(TIMES))]),
                   cell_fields__number=np.array([self.number(i)[:, None] for i in range(len(TIMES))]))
        def attribute(name, kind, center, i, rows, width, group):
            return f"""        <Attribute Name="{name}" Type="{kind}" Center="{center}">
          <DataItem ItemType="HyperSlab" Dimensions="1 {rows} {width}" Type="HyperSlab">
            <DataItem Dimensions="3 3" Format="XML">
              {i} 0 0
              1 1 1
              1 {rows} {width}
            </DataItem>
            <DataItem DataType="Float" Precision="8" Dimensions="{len(TIMES)} {rows} {width}" Format="HDF">
              &HeavyData;:/{group}/{name}
            </DataItem>
          </DataItem>
        </Attribute>
"""
        steps = ""
        for i in range(len(TIMES)):
            steps += f"""      <Grid Name="domain" GridType="Uniform">
        <Topology TopologyType="Tetrahedron" NumberOfElements="{cells}">
          <DataItem Reference="XML">
            /Xdmf/Domain/DataItem[@Name="cells"]
          </DataItem>
        </Topology>
        <Geometry GeometryType="XYZ">
          <DataItem Reference="XML">
            /Xdmf/Domain/DataItem[@Name="vertices"]
          </DataItem>
        </Geometry>
{attribute("heat", "Scalar", "Node", i, points, 1, "vertex_fields")}{attribute("displacement", "Vector", "Node", i, points, 3, "vertex_fields")}{attribute("number", "Scalar", "Cell", i, cells, 1, "cell_fields")}      </Grid>
"""
        return self.xml(f"""<?xml version="1.0" ?>
<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" [
<!ENTITY HeavyData "run.h5">
]>

<Xdmf>
  <Domain Name="domain">
    <DataItem Name="cells"
              ItemType="Uniform"
              Format="HDF"
              NumberType="Float" Precision="8"
              Dimensions="{cells} 4">
      &HeavyData;:/topology/cells
    </DataItem>
    <DataItem Name="vertices"
              Format="HDF"
              Dimensions="{points} 3">
      &HeavyData;:/geometry/vertices
    </DataItem>
    <!-- ============================================================ -->
    <Grid Name="TimeSeries" GridType="Collection" CollectionType="Temporal">
      <Time TimeType="List">
        <DataItem Format="XML" NumberType="Float" Dimensions="{len(TIMES)}">
          {" ".join(map(str, TIMES))}
        </DataItem>
      </Time>
{steps}    </Grid>
  </Domain>
</Xdmf>
""")

    def paraview(self):
        """ParaView's Xdmf3 writer: mixed cells, data sets without a slash, the mesh of later steps as a pointer of numbers."""
        mixed = np.concatenate([np.full((len(self.tets), 1), 6), self.tets], axis=1).astype("i8")
        self.store(Data0=self.points, Data1=mixed.ravel())
        steps = ""
        for i, time in enumerate(TIMES):
            self.store(**{f"Heat{i}": self.heat(i), f"Number{i}": self.number(i)})
            first = f"""<Geometry Origin="" Type="XYZ"><DataItem DataType="Float" Dimensions="{len(self.points)} 3" Format="HDF" Precision="8">run.h5:Data0</DataItem></Geometry>
          <Topology Dimensions="{len(self.tets)}" Type="Mixed"><DataItem DataType="Int" Dimensions="{mixed.size}" Format="HDF" Precision="8">run.h5:Data1</DataItem></Topology>"""
            later = '<xi:include xpointer="element(/1/1/1/1/2)"/><xi:include xpointer="element(/1/1/1/1/3)"/>'
            steps += f"""
        <Grid Name="Grid">
          <Time Value="{time}"/>
          {later if i else first}
          <Attribute Center="Node" ElementCell="" ElementDegree="0" ElementFamily="" ItemType="" Name="heat" Type="Scalar">
            <DataItem DataType="Float" Dimensions="{len(self.points)}" Format="HDF" Precision="4">run.h5:Heat{i}|0:1:{len(self.points)}:{len(self.points)}</DataItem>
          </Attribute>
          <Attribute Center="Cell" ElementCell="" ElementDegree="0" ElementFamily="" ItemType="" Name="number" Type="Scalar">
            <DataItem DataType="Int" Dimensions="{len(self.tets)}" Format="HDF" Precision="4">run.h5:Number{i}</DataItem>
          </Attribute>
        </Grid>"""
        return self.xml(f"""<?xml version="1.0" encoding="utf-8"?>
<Xdmf xmlns:xi="http://www.w3.org/2001/XInclude" Version="3.0">
  <Domain>
    <Grid CollectionType="Temporal" GridType="Collection" Name="Collection">{steps}
    </Grid>
  </Domain>
</Xdmf>
""")


class Dialects(XdmfTest):
    def test_fenics(self):
        path = self.fenics()
        self.expect_steps(path)
        self.assertIn("the time steps from 0.1 to 0.25 (the first of 3, at 0, is read; --time-step", self.converted(path)[1])

    def test_steps_whose_times_descend_are_held_against_those_of_their_time(self):
        path, out = self.meshio(), self.folder / "out.pvd"
        text = path.read_text()
        for time in TIMES:
            text = text.replace(f'<Time Value="{time}" />', f'<Time Value="{1 - time}" />')
        path.write_text(text)
        run("convert", path, out, "--quiet")
        report = report_of("compare", path, out, "--max-error", "0.001%")
        self.assertEqual([step["time"] for step in report["steps"]], sorted(1 - time for time in TIMES))

    def test_fenicsx(self):
        mesh = self.expect_steps(self.fenicsx(functions=("heat", "number")))
        self.assertNotIn("block", mesh.arrays["cell"])

    def test_meshio(self):
        self.expect_steps(self.meshio())

    def test_seissol(self):
        self.expect_steps(self.seissol(), ["number"])

    def test_seissol_binary(self):
        self.expect_steps(self.seissol("Binary"), ["number"])

    def test_pylith(self):
        mesh = self.expect_steps(self.pylith())
        np.testing.assert_array_equal(mesh.arrays["point"]["displacement"][1], self.points * (len(TIMES) - 1))

    def test_paraview(self):
        self.expect_steps(self.paraview())

    def test_tags_of_fenicsx(self):
        """Cells listed again in another order are the same cells; triangles are cells of lower dimension."""
        order = np.random.default_rng(5).permutation(len(self.tets))
        cells = self.tags("cell_tags", "Tetrahedron", self.tets[order][:, [2, 0, 3, 1]], np.arange(len(order), dtype="i4")[order])
        facets = self.tags("facet_tags", "Triangle", self.outside, np.arange(len(self.outside), dtype="i4") + 100)
        path = self.fenicsx(cells + facets, ("heat", "number"))
        mesh, told = self.converted(path, "--time-step", 1)
        self.assertNotIn("left out", told)
        np.testing.assert_array_equal(mesh.tets, self.tets)
        np.testing.assert_array_equal(mesh.points, self.points)
        array = mesh.arrays["cell"]
        np.testing.assert_array_equal(array["cell_tags"][1][:len(self.tets), 0], np.arange(len(self.tets)))
        np.testing.assert_array_equal(array["facet_tags"][1][len(self.tets):, 0], np.arange(len(self.outside)) + 100)
        np.testing.assert_array_equal([sorted(ids) for _, ids in mesh.others], np.sort(self.outside))
        np.testing.assert_array_equal(array["block"][1][:, 0], np.repeat([0, 1], [len(self.tets), len(self.outside)]))

    def test_checkpoint_of_fenics(self):
        """write_checkpoint: values of linear functions by the numbers that each cell has for them."""
        order = np.random.default_rng(7).permutation(len(self.points))
        place = np.argsort(order)
        self.store(f__f_0__mesh__topology=self.tets.astype("i8"), f__f_0__mesh__geometry=self.points,
                   f__f_0__vector=self.heat(1).astype("f8")[order][:, None], f__f_0__cell_dofs=place[self.tets].astype("u8").reshape(-1, 1),
                   f__f_0__x_cell_dofs=(4 * np.arange(len(self.tets) + 1, dtype="u8"))[:, None],
                   f__f_0__cells=np.arange(len(self.tets), dtype="u8")[:, None])
        def item(name, rows, columns, kind=' NumberType="UInt"'):
            return f'<DataItem Dimensions="{rows} {columns}"{kind} Format="HDF">run.h5:f/f_0/{name}</DataItem>\n'
        count, points = len(self.tets), len(self.points)
        path = self.xml(DOCTYPE + f"""<Xdmf Version="3.0" xmlns:xi="http://www.w3.org/2001/XInclude">
  <Domain>
    <Grid Name="f" GridType="Collection" CollectionType="Temporal">
      <Grid Name="f_0" GridType="Uniform">
        <Topology NumberOfElements="{count}" TopologyType="Tetrahedron" NodesPerElement="4">{item("mesh/topology", count, 4)}</Topology>
        <Geometry GeometryType="XYZ">{item("mesh/geometry", points, 3, "")}</Geometry>
        <Time Value="2" />
        <Attribute ItemType="FiniteElementFunction" ElementFamily="CG" ElementDegree="1" ElementCell="tetrahedron" Name="f" Center="Other" AttributeType="Scalar">
          {item("cell_dofs", 4 * count, 1)}{item("vector", points, 1, ' NumberType="Float"')}{item("x_cell_dofs", count + 1, 1)}{item("cells", count, 1)}
        </Attribute>
      </Grid>
    </Grid>
  </Domain>
</Xdmf>
""")
        mesh, told = self.converted(path)
        self.assertNotIn("left out", told)
        np.testing.assert_array_equal(mesh.tets, self.tets)
        np.testing.assert_array_equal(values(mesh, "f"), self.heat(1).astype("f8"))
        self.assertEqual(report_of("info", path)["time_steps"], [2])

    def test_all_steps_are_a_series(self):
        self.expect_series(self.fenics())

    def test_a_changed_file_is_noticed(self):
        self.write(jittered(24), "grid.vtu")
        self.points, self.tets = np.array(Vtu(self.grid).points), Vtu(self.grid).tets
        self.expect_resumed_only_as_it_was(self.fenics(), self.folder / "run.h5")

    def test_no_output_takes_the_place_of_a_data_file(self):
        path = self.fenics()
        (self.folder / "run.h5").rename(self.folder / "run.vtu")
        path.write_bytes(path.read_bytes().replace(b"run.h5", b"run.vtu"))
        told = self.refused("simplify", path, "-o", self.folder / "run.vtu", *GOAL, code=USAGE)
        self.assertIn("that is one of the files of", told)


class DataSets(XdmfTest):
    """One grid, whose array T is what is tried."""

    def grid_with(self, values, dimensions=None, name="/T", **options):
        (self.folder / "run.h5").unlink(missing_ok=True)
        self.store(cells=self.tets.astype("i4"), points=self.points)
        with h5py.File(self.folder / "run.h5", "a") as file:
            file.create_dataset("T", data=values, **options)
        dimensions = dimensions or " ".join(map(str, np.shape(values)))
        return self.xml(f"""<Xdmf><Domain><Grid>
<Topology TopologyType="Tetrahedron"><DataItem Format="HDF" Dimensions="{len(self.tets)} 4">run.h5:/cells</DataItem></Topology>
<Geometry><DataItem Format="HDF" Dimensions="{len(self.points)} 3">run.h5:/points</DataItem></Geometry>
<Attribute Name="T" Center="Cell"><DataItem Format="HDF" Dimensions="{dimensions}">run.h5:{name}</DataItem></Attribute></Grid></Domain></Xdmf>""")

    def test_all_types_of_numbers(self):
        numbers = np.arange(len(self.tets)) % 100
        for stored, read in (("i1", "i1"), ("u1", "u1"), ("<i2", "<i2"), (">u2", "<u2"), (">i4", "<i4"), ("<u4", "<u4"), (">i8", "<i8"),
                             ("<u8", "<u8"), ("<f4", "<f4"), (">f8", "<f8"), ("f2", "<f4"), ("?", "i1")):
            with self.subTest(stored):
                values = (numbers % 2 if stored == "?" else numbers).astype(stored)
                path = self.grid_with(values, chunks=True, compression="gzip")
                found = self.converted(path)[0].arrays["cell"]["T"]
                self.assertEqual(np.dtype(read).name, {"Int8": "int8", "UInt8": "uint8"}.get(found[0][0], found[0][0].lower()))
                np.testing.assert_array_equal(found[1][:, 0], values.astype(read))
        big = np.full(len(self.tets), 2 ** 63 - 1)
        np.testing.assert_array_equal(self.converted(self.grid_with(big))[0].arrays["cell"]["T"][1][:, 0], big)

    def test_what_is_wrong_is_named(self):
        count = len(self.tets)
        self.assertIn(f"'T' has {count + 1} values for {count} cells",
                      self.refused("info", self.grid_with(np.zeros(count + 1))))
        self.assertIn(f"says {count} values, and there are {count + 1}",
                      self.refused("info", self.grid_with(np.zeros(count + 1), dimensions=count)))
        self.assertIn("data set /Nowhere of", self.refused("info", self.grid_with(np.zeros(count), name="/Nowhere")))
        self.assertIn("does not say FILE:/DATA_SET", self.refused("info", self.grid_with(np.zeros(count), name="")))
        told = self.converted(self.grid_with(np.full(count, b"words")))[1]
        self.assertIn("array 'T', whose DataItem names the data set /T of", told)
        self.assertIn("which holds no numbers", told)
        part = f"|0:1:{count}:{count}"
        run("info", self.grid_with(np.zeros(count), name="T" + part))
        self.assertIn("is not inside of", self.refused("info", self.grid_with(np.zeros(count), name="T" + part.replace("|0", "|1"))))
        self.assertIn("parts of several data sets", self.converted(self.grid_with(np.zeros(count), name="T" + part + part))[1])
        self.assertIn("without its start, step and count", self.refused("info", self.grid_with(np.zeros(count), name="T|0:1")))
        # The data set has one dimension, and the XML says another number of them, so that only the lists tell how many there are.
        for said, lists, counted in ((f"1 {count} 1", f"0:1 1:1 {count} 1", "1 starts, 2 steps and 3 counts"),
                                     (f"1 {count}", f"0:1 1:1 {count}", "1 starts, 2 steps and 2 counts"),
                                     (f"1 {count}", f"0 0:1:1 {count}", "2 starts, 1 steps and 2 counts"),
                                     (count, f"0 0:1 1:{count}", "2 starts, 2 steps and 1 counts"),
                                     (count, "::", "0 starts, 0 steps and 0 counts")):
            with self.subTest(lists):
                self.assertIn(f"by {counted}, where there must be one of each",
                              self.refused("info", self.grid_with(np.zeros(count), dimensions=said, name="T|" + lists)))
        path = self.grid_with(np.zeros(count))
        (self.folder / "run.h5").write_bytes(b"no such file")
        self.assertIn("which the HDF5 library cannot open", self.refused("info", path))
        (self.folder / "run.h5").unlink()
        self.assertIn("run.h5, which is not there", self.refused("info", path))
        self.assertIn("an absolute path", self.refused("info", self.xml(path.read_text().replace("run.h5", str(self.folder / "run.h5")))))

    def test_a_data_set_that_is_larger_than_memory(self):
        """Its file is small: nothing was written to it."""
        path = self.grid_with(np.zeros(1), dimensions="100000000")
        with h5py.File(self.folder / "run.h5", "a") as file:
            del file["T"]
            file.create_dataset("T", (100000000,), dtype="f8", chunks=(1 << 20,))
        self.assertIn("of memory to read it", self.refused("info", path, "--memory", "1M", code=MEMORY))

    def test_damaged_files_are_errors(self):
        heavy = self.folder / "run.h5"
        for dialect in self.fenics, self.pylith:
            path = dialect()
            for file in path, heavy:
                data = file.read_bytes()
                for place in range(16, len(data), len(data) // 20):
                    for bytes_ in data[:place], data[:place] + b"\xff\xff\xff\x7f" + data[place + 4:]:
                        file.write_bytes(bytes_)
                        result = finish("info", path)
                        self.assertNotIn(-result.returncode, [s.value for s in signal.Signals], (file, place))
                        if result.returncode != 0:
                            self.assertEqual((result.returncode in (BAD, INVALID), result.stderr.count(b"\n")), (True, 1), result.stderr)
                file.write_bytes(data)
            run("info", path)
            heavy.unlink()


if __name__ == "__main__":
    main()
