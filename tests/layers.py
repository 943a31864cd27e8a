#!/usr/bin/env python3
"""Holds the code to the layers that each folder's README.md states.

Every room has a README.md with a line "May include: a, b." naming the rooms whose headers its files may use (its own
are always allowed), or "May include: nothing.". VTK's headers may be included in src/vtk alone.
"""
import pathlib
import re
import sys

ROOMS = {"base": "src/base", "mesh": "src/mesh", "kernel": "src/kernel", "generate": "src/generate",
         "compare": "src/compare", "driver": "src/driver", "cli": "src/cli", "vtk": "src/vtk", "partition": "partition", "io": "io"}


def allowed_rooms(readme):
    match = re.search(r"^May include: ([^.]*)\.", readme.read_text(), re.MULTILINE)
    if not match:
        return None
    names = [name.strip() for name in match.group(1).split(",")]
    return set() if names == ["nothing"] else set(names)


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
        for file in sorted((root / folder).glob("*.[hc]*")):
            for number, line in enumerate(file.read_text().splitlines(), 1):
                match = re.match(r'\s*#\s*include\s*(["<])([^">]+)[">]', line)
                if not match:
                    continue
                seen += 1
                where = f"{file.relative_to(root)}:{number}"
                if match.group(1) == "<":
                    if match.group(2).startswith("vtk") and room != "vtk":
                        faults.append(f"{where}: VTK is included outside src/vtk")
                    continue
                used = match.group(2).split("/")[0]
                if used not in ROOMS:
                    faults.append(f"{where}: {match.group(2)} lies in no room")
                elif used != room and used not in allowed:
                    faults.append(f"{where}: {room} may not include {used}")
    if seen == 0:
        faults.append("found no includes at all: the test looks in the wrong place")
    for fault in faults:
        print(fault)
    print(f"{seen} includes, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
