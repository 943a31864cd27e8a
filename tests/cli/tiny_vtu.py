"""Small .vtu files, whole or with one thing wrong. Nothing but the standard library; no code of the project."""
import base64
import struct
import zlib

CODES = {"Int8": "b", "UInt8": "B", "Int32": "i", "Int64": "q", "UInt32": "I", "UInt64": "Q", "Float32": "f",
         "Float64": "d"}


def grid(n):
    """n^3 unit cubes, each split in six: points and tetrahedra."""
    side = n + 1
    at = lambda x, y, z: (z * side + y) * side + x
    points = [(float(x), float(y), float(z)) for z in range(side) for y in range(side) for x in range(side)]
    steps = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
    orders = [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (1, 0, 2), (2, 1, 0)]
    tets = []
    for z in range(n):
        for y in range(n):
            for x in range(n):
                for number, order in enumerate(orders):
                    corner, path = [x, y, z], [at(x, y, z)]
                    for axis in order:
                        corner = [c + s for c, s in zip(corner, steps[axis])]
                        path.append(at(*corner))
                    if number >= 3:
                        path[1], path[2] = path[2], path[1]
                    tets.append(path)
    return points, tets


class TinyVtu:
    """A mesh as a list of arrays that a test may change before the file is made."""

    def __init__(self, n=4, encoding="raw", compressor=None):
        self.points, self.tets = grid(n)
        self.encoding, self.compressor = encoding, compressor
        self.byte_order, self.header_type, self.file_type = "LittleEndian", "UInt64", "UnstructuredGrid"
        self.counts = {"NumberOfPoints": str(len(self.points)), "NumberOfCells": str(len(self.tets))}
        flat = [c for p in self.points for c in p]
        # section, name, type, components, values
        self.arrays = [
            ["PointData", "temperature", "Float32", 1, [p[0] + 2 * p[1] for p in self.points]],
            ["CellData", "id", "Int32", 1, list(range(len(self.tets)))],
            ["Points", "Points", "Float32", 3, flat],
            ["Cells", "connectivity", "Int64", 1, [v for t in self.tets for v in t]],
            ["Cells", "offsets", "Int64", 1, list(range(4, 4 * len(self.tets) + 1, 4))],
            ["Cells", "types", "UInt8", 1, [10] * len(self.tets)]]
        self.attributes = {}  # (array name, attribute) -> text, None to leave it out
        self.array_bytes = {}  # array name -> the bytes in place of the encoded values
        self.size_words = {}   # array name -> the byte count that the array claims

    def array(self, name):
        return next(a for a in self.arrays if a[1] == name)

    def remove(self, name):
        self.arrays.remove(self.array(name))

    def payload(self, array):
        _, name, kind, _, values = array
        raw = struct.pack(f"<{len(values)}{CODES[kind]}", *values)
        if self.compressor == "vtkZLibDataCompressor":
            block = zlib.compress(raw)
            block = self.array_bytes.get(name, block)
            return struct.pack("<4Q", 1, len(raw), 0, len(block)) + block
        raw = self.array_bytes.get(name, raw)
        return struct.pack("<Q", self.size_words.get(name, len(raw))) + raw

    def bytes(self):
        offset, payloads, sections = 0, [], {}
        for array in self.arrays:
            section, name, kind, components, values = array
            attributes = {"type": kind, "Name": name, "NumberOfComponents": str(components)}
            body = ""
            if self.encoding == "raw":
                payload = self.payload(array)
                attributes.update(format="appended", offset=str(offset))
                payloads.append(payload)
                offset += len(payload)
            elif self.encoding == "inline":
                attributes["format"] = "binary"
                body = base64.b64encode(self.payload(array)).decode()
            else:
                attributes["format"] = "ascii"
                body = " ".join(repr(v) for v in values)
            body = self.attributes.get((name, "body"), body)
            for key in list(attributes):
                attributes[key] = self.attributes.get((name, key), attributes[key])
            text = " ".join(f'{k}="{v}"' for k, v in attributes.items() if v is not None)
            sections.setdefault(section, []).append(f"<DataArray {text}>{body}</DataArray>")
        counts = " ".join(f'{k}="{v}"' for k, v in self.counts.items() if v is not None)
        compressor = f' compressor="{self.compressor}"' if self.compressor else ""
        head = (f'<?xml version="1.0"?>\n<VTKFile type="{self.file_type}" version="1.0" '
                f'byte_order="{self.byte_order}" header_type="{self.header_type}"{compressor}>\n'
                f"<UnstructuredGrid><Piece {counts}>\n")
        for section, lines in sections.items():
            head += f"<{section}>\n" + "\n".join(lines) + f"\n</{section}>\n"
        head += "</Piece></UnstructuredGrid>\n"
        data = head.encode()
        if self.encoding == "raw":
            data += b'<AppendedData encoding="raw">\n_' + b"".join(payloads) + b"\n</AppendedData>\n"
        return data + b"</VTKFile>\n"
