#!/usr/bin/env python3
"""Holds the code to the layers that each folder's README.md states.

Every room has a README.md that names each of its headers, and has a line "May include: a, b." naming the rooms whose headers its files may use (its own
are always allowed), or "May include: nothing.". VTK's headers may be included in src/vtk alone, and nothing
but the standard library's in the public header, which belongs to the library.
"""
import pathlib
import re
import sys

ROOMS = {"base": "src/base", "mesh": "src/mesh", "kernel": "src/kernel", "verify": "src/verify", "follow": "src/follow", "refine": "src/refine", "repair": "src/repair", "generate": "src/generate",
         "compare": "src/compare", "driver": "src/driver", "series": "src/series", "cli": "src/cli", "vtk": "src/vtk", "partition": "partition",
         "io": "io", "library": "src/library", "vtk/filter": "src/vtk/filter",
         "vtk/versions": "src/vtk/versions"}
PUBLIC_HEADERS = ("tetfusion.h", "tetfusion_c.h")  # of the library; they include the standard library's headers alone


def allowed_rooms(readme):
    match = re.search(r"^May include: ([^.]*)\.", readme.read_text(), re.MULTILINE)
    if not match:
        return None
    names = [name.strip() for name in match.group(1).split(",")]
    return set() if names == ["nothing"] else set(names)


def room_of(header):
    if header in PUBLIC_HEADERS:
        return "library"
    folder = header.rpartition("/")[0]
    return folder if folder in ROOMS else None


def includes_of(file):
    for number, line in enumerate(file.read_text().splitlines(), 1):
        match = re.match(r'\s*#\s*include\s*(["<])([^">]+)[">]', line)
        if match:
            yield number, match.group(1) == "<", match.group(2)


def main():
    root = pathlib.Path(__file__).resolve().parent.parent
    faults = []
    seen = 0
    for room, folder in ROOMS.items():
        readme = root / folder / "README.md"
        allowed = allowed_rooms(readme) if readme.exists() else None
        if allowed is None:
            faults.append(f"{folder}: no README.md with a line 'May include: ...'")
            continue
        for name in allowed - ROOMS.keys():
            faults.append(f"{readme}: no room is called {name}")
        words = set(re.findall(r"\w+", readme.read_text()))
        faults += [f"{readme}: does not say what {header.name} is for"
                   for header in sorted((root / folder).glob("*.h")) if header.stem not in words]
        for file in sorted((root / folder).glob("*.[hc]*")):
            for number, in_brackets, header in includes_of(file):
                seen += 1
                where = f"{file.relative_to(root)}:{number}"
                if in_brackets:
                    if header.startswith("vtk") and not room.startswith("vtk"):
                        faults.append(f"{where}: VTK is included outside src/vtk")
                    continue
                used = room_of(header)
                if used is None:
                    faults.append(f"{where}: {header} lies in no room")
                elif used != room and used not in allowed:
                    faults.append(f"{where}: {room} may not include {used}")
    for public in PUBLIC_HEADERS:
        for number, in_brackets, header in includes_of(root / "src" / public):
            seen += 1
            if not in_brackets or header.startswith("vtk") or "." in header and header != "stdint.h":
                faults.append(f"src/{public}:{number}: {header} is not of the standard library")
    if seen == 0:
        faults.append("found no includes at all: the test looks in the wrong place")
    for fault in faults:
        print(fault)
    print(f"{seen} includes, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
