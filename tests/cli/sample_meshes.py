"""Small meshes with something special about them."""
import numpy as np

from tiny_vtu import TinyVtu


def two_tets(shared):
    """Two tetrahedra that share so many points."""
    mesh = TinyVtu(1)
    corner = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    other = [(0, 0, 0), (1, 0, 0), (0, -1, 0), (0, 0, -1)]
    mesh.points = corner + other[shared:]
    ids = [0, 1, 2, 3] + list(range(shared)) + list(range(4, 8 - shared))
    ids[6:8] = ids[7:5:-1]
    mesh.tets = [ids[:4], ids[4:]]
    return rebuilt(mesh)


def rebuilt(mesh):
    """The arrays of a TinyVtu whose points and tets were changed."""
    fresh = {"temperature": [float(p[0]) for p in mesh.points], "id": list(range(len(mesh.tets))),
             "Points": [float(c) for p in mesh.points for c in p], "connectivity": [v for t in mesh.tets for v in t],
             "offsets": list(range(4, 4 * len(mesh.tets) + 1, 4)), "types": [10] * len(mesh.tets)}
    for name, values in fresh.items():
        mesh.array(name)[4] = values
    mesh.counts = {"NumberOfPoints": str(len(mesh.points)), "NumberOfCells": str(len(mesh.tets))}
    return mesh


def set_value(name, index, value):
    mesh = TinyVtu()
    mesh.array(name)[4][index] = value
    return mesh


def mesh_of_all_sorts():
    """Arrays of every kind, and cells of lower dimension before and after the tetrahedra."""
    mesh = TinyVtu(3)
    points, tets = len(mesh.points), len(mesh.tets)
    rng = np.random.default_rng(1)
    lower = [(5, [0, 1, 5]), (3, [2, 6])], [(1, [7])]
    cells = lower[0] + [(10, t) for t in mesh.tets] + lower[1]
    mesh.counts["NumberOfCells"] = str(len(cells))
    mesh.array("connectivity")[4] = [v for _, ids in cells for v in ids]
    mesh.array("offsets")[4] = [int(n) for n in np.cumsum([len(ids) for _, ids in cells])]
    mesh.array("types")[4] = [kind for kind, _ in cells]
    mesh.array("id")[4] = list(range(tets + 3))
    mesh.arrays += [["PointData", "double", "Float64", 1, [float(v) for v in rng.normal(size=points)]],
                    ["PointData", "vector", "Float32", 3, [float(v) for v in rng.normal(size=3 * points).astype("f4")]],
                    ["PointData", "bytes", "Int8", 2, [int(v) for v in rng.integers(-128, 128, 2 * points)]],
                    ["CellData", "large", "Int64", 1, [int(v) for v in rng.integers(-2**62, 2**62, tets + 3)]]]
    mesh.arrays.sort(key=lambda a: ["PointData", "CellData", "Points", "Cells"].index(a[0]))
    return mesh


HEXAHEDRA = b"""# vtk DataFile Version 3.0
two hexahedra and a side of the second one
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 12 float
0 0 0  1 0 0  2 0 0  0 1 0  1 1 0  2 1 0
0 0 1  1 0 1  2 0 1  0 1 1  1 1 1  2 1 1
CELLS 3 23
8 0 1 4 3 6 7 10 9
8 1 2 5 4 7 8 11 10
4 2 5 11 8
CELL_TYPES 3
12 12 9
CELL_DATA 3
SCALARS number int 1
LOOKUP_TABLE default
0 1 2
"""

STRUCTURED = b"""<?xml version="1.0"?>
<VTKFile type="StructuredGrid" version="1.0" byte_order="LittleEndian">
<StructuredGrid WholeExtent="0 2 0 1 0 1"><Piece Extent="0 2 0 1 0 1">
<PointData><DataArray type="Float64" Name="height" format="ascii">0 0 1 0 0 1 1 1 2 1 1 2</DataArray></PointData>
<CellData/><Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">
0 0 0  1 0 0  2 0 0  0 1 0  1 1 0  2 1 0  0 0 1  1 0 1  2 0 1  0 1 1  1 1 1  2 1 1
</DataArray></Points></Piece></StructuredGrid></VTKFile>
"""
