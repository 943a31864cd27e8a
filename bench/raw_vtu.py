"""Reads and writes appended-raw .vtu files of tetrahedra with numpy: enough for the benchmarks, no VTK needed."""
import pathlib
import re
import xml.etree.ElementTree as ElementTree

import numpy as np

TYPES = {"Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4",
         "Int64": "i8", "UInt64": "u8", "Float32": "f4", "Float64": "f8"}
NAMES = {np.dtype(code): name for name, code in TYPES.items()}


class Mesh:
    """points (n, 3); tets (m, 4); point_data and cell_data: name -> array of n or m rows."""

    def __init__(self, points, tets, point_data=None, cell_data=None):
        self.points, self.tets = points, tets
        self.point_data, self.cell_data = point_data or {}, cell_data or {}


def read(path):
    data = pathlib.Path(path).read_bytes()
    start = re.search(rb"<AppendedData[^>]*>\s*_", data)
    head = ElementTree.fromstring(data[:start.start()] + b"</VTKFile>")
    if head.get("header_type") != "UInt64" or head.get("compressor"):
        raise ValueError(f"{path}: only uncompressed files with UInt64 headers are read here")

    def values(element):
        at = start.end() + int(element.get("offset"))
        size = int(np.frombuffer(data, "u8", 1, at)[0])
        kind = np.dtype(TYPES[element.get("type")])
        array = np.frombuffer(data, kind, size // kind.itemsize, at + 8)
        components = int(element.get("NumberOfComponents", 1))
        return array.reshape(-1, components) if components > 1 else array

    def section(name):
        return {e.get("Name"): values(e) for e in head.iter(name) for e in e.iter("DataArray")}

    cells = section("Cells")
    if not (cells["types"] == 10).all():
        raise ValueError(f"{path}: only tetrahedra are read here")
    points = next(iter(section("Points").values()))
    return Mesh(points, cells["connectivity"].reshape(-1, 4), section("PointData"), section("CellData"))


def write(path, mesh):
    cells = len(mesh.tets)
    sections = [("PointData", mesh.point_data), ("CellData", mesh.cell_data), ("Points", {"Points": mesh.points}),
                ("Cells", {"connectivity": mesh.tets.astype("i8").ravel(),
                           "offsets": np.arange(4, 4 * cells + 1, 4, dtype="i8"),
                           "types": np.full(cells, 10, "u1")})]
    arrays, offset, lines = [], 0, []
    for tag, section in sections:
        lines.append(f"<{tag}>")
        for name, array in section.items():
            components = array.shape[1] if array.ndim > 1 else 1
            lines.append(f'<DataArray type="{NAMES[array.dtype]}" Name="{name}" NumberOfComponents="{components}" '
                         f'format="appended" offset="{offset}"/>')
            arrays.append(np.ascontiguousarray(array))
            offset += 8 + array.nbytes
        lines.append(f"</{tag}>")
    with open(path, "wb") as file:
        file.write(f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
                   f'header_type="UInt64">\n<UnstructuredGrid>\n<Piece NumberOfPoints="{len(mesh.points)}" '
                   f'NumberOfCells="{cells}">\n'.encode())
        file.write("\n".join(lines).encode())
        file.write(b'\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding="raw">\n_')
        for array in arrays:
            file.write(np.uint64(array.nbytes).tobytes())
            file.write(array.tobytes())
        file.write(b"\n</AppendedData>\n</VTKFile>\n")


def split_in_eight(mesh):
    """Each tetrahedron into eight by its edge midpoints: four at the corners, and the octahedron between them in four
    round its shortest diagonal. Point arrays are averaged at the midpoints, cell arrays are repeated."""
    corners = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    edges = np.sort(np.concatenate([mesh.tets[:, pair] for pair in corners]), axis=1)
    unique, inverse = np.unique(edges, axis=0, return_inverse=True)
    points = len(mesh.points)
    mid = (points + inverse.reshape(6, -1)).T
    average = lambda a: np.concatenate([a, a[unique].astype("f8").mean(axis=1).astype(a.dtype)])
    new_points = average(mesh.points)
    t = mesh.tets
    m01, m02, m03, m12, m13, m23 = mid.T
    parts = [np.stack(p, 1) for p in ((t[:, 0], m01, m02, m03), (m01, t[:, 1], m12, m13), (m02, m12, t[:, 2], m23),
                                      (m03, m13, m23, t[:, 3]))]
    # A diagonal and the ring of the four other vertices round it.
    rings = [(m01, m23, (m02, m03, m13, m12)), (m02, m13, (m01, m12, m23, m03)), (m03, m12, (m01, m02, m23, m13))]
    length = np.stack([np.linalg.norm(new_points[a].astype("f8") - new_points[b], axis=1) for a, b, _ in rings])
    choice = length.argmin(axis=0)
    for side in range(4):
        part = np.empty_like(parts[0])
        for k, (a, b, ring) in enumerate(rings):
            these = choice == k
            part[these] = np.stack([a, b, ring[side], ring[(side + 1) % 4]], 1)[these]
        parts.append(part)
    tets = np.stack(parts, 1).reshape(-1, 4)
    p = new_points[tets].astype("f8")
    volume = np.einsum("ij,ij->i", np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), p[:, 3] - p[:, 0])
    tets[volume < 0] = tets[volume < 0][:, [1, 0, 2, 3]]
    return Mesh(new_points, tets, {n: average(a) for n, a in mesh.point_data.items()},
                {n: np.repeat(a, 8, axis=0) for n, a in mesh.cell_data.items()})
