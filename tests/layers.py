#!/usr/bin/env python3
"""Holds the code to the layers that each folder's README.md states.

Every folder with code is a room. Its README.md names each of its headers, and has a line "May include: a, b." naming the
rooms whose headers its files may use, with the rooms inside of these (its own are always allowed), or "May include:
nothing.". No two rooms may use each other. VTK's headers may be included in src/vtk alone, and nothing but the standard
library's in the public headers, which belong to the library. What a file uses of the headers that builds precompile is
included by it or by headers of ours that it includes, as those builds would not miss it.
"""
import functools
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
TOPS = {"src": "", "partition": "partition", "io": "io"}  # folders, and how includes name them
PUBLIC_HEADERS = ("tetfusion.h", "tetfusion_c.h")  # of the library; they include the standard library's headers alone

PRECOMPILED = {  # in the top CMakeLists.txt, and what shows that a file needs one
    "algorithm": r"(?:ranges::)?(?:all_of|any_of|clamp|copy|copy_n|count_if|equal|fill|find|find_if|lower_bound|max|max_element|min"
                 r"|min_element|none_of|nth_element|remove_if|reverse|sort|stable_sort|transform|unique|upper_bound)\(",
    "array": r"array\b", "atomic": r"atomic\b", "functional": r"(?:function|greater|hash|less)\b", "map": r"(?:multi)?map\b",
    "memory": r"(?:make_unique|make_shared|shared_ptr|unique_ptr|weak_ptr)\b",
    "mutex": r"(?:call_once|lock_guard|mutex|once_flag|scoped_lock|unique_lock)\b",
    "numeric": r"(?:accumulate|exclusive_scan|inclusive_scan|iota|partial_sum|reduce)\b", "optional": r"(?:nullopt|optional)\b",
    "span": r"span\b", "string": r"(?:string|to_string)\b", "variant": r"(?:get_if|holds_alternative|variant|visit)\b",
    "vector": r"vector\b"}
NEEDS = {header: re.compile(r"\bstd::" + used) for header, used in PRECOMPILED.items()}
NEEDS["fmt/format.h"], NEEDS["CLI/CLI.hpp"] = re.compile(r"\bfmt::"), re.compile(r"\bCLI::")


def code_in(folder):
    return sorted(folder.glob("*.[hc]*"))


def find_rooms():
    """Their folders, by the names that includes give them."""
    rooms = {}
    for top, name in TOPS.items():
        for folder in [ROOT / top, *(path for path in (ROOT / top).rglob("*") if path.is_dir())]:
            files = [file for file in code_in(folder) if file.suffix in (".h", ".cpp") and file.name not in PUBLIC_HEADERS]
            if files:
                rooms["/".join(filter(None, [name, *folder.relative_to(ROOT / top).parts]))] = folder
    return rooms


def allowed_rooms(readme):
    match = re.search(r"^May include: ([^.]*)\.", readme.read_text(), re.MULTILINE)
    if not match:
        return None
    names = [name.strip() for name in match.group(1).split(",")]
    return set() if names == ["nothing"] else set(names)


@functools.cache
def includes_of(file):
    """Number of the line, is it in brackets, which header."""
    matches = (re.match(r'\s*#\s*include\s*(["<])([^">]+)[">]', line) for line in file.read_text().splitlines())
    return [(number, match.group(1) == "<", match.group(2)) for number, match in enumerate(matches, 1) if match]


def reachable(file, seen):
    """The headers in brackets that it includes, or headers of ours in it do."""
    if file in seen:
        return set()
    seen.add(file)
    found = set()
    for _, in_brackets, header in includes_of(file):
        if in_brackets:
            found.add(header)
            continue
        for place in (ROOT / "src" / header, ROOT / header):
            found |= reachable(place, seen) if place.exists() else set()
    return found


def missing_includes(file):
    code = re.sub(r'//.*|"(?:\\.|[^"\\])*"', "", file.read_text())
    return sorted({header for header, used in NEEDS.items() if used.search(code)} - reachable(file, set()))


def main():
    rooms = find_rooms()
    faults = []
    seen = 0
    uses = set()
    for room, folder in rooms.items():
        readme = folder / "README.md"
        allowed = allowed_rooms(readme) if readme.exists() else None
        if allowed is None:
            faults.append(f"{folder}: no README.md with a line 'May include: ...'")
            continue
        for name in allowed - rooms.keys():
            faults.append(f"{readme}: no room is called {name}")
        words = set(re.findall(r"\w+", readme.read_text()))
        faults += [f"{readme}: does not say what {header.name} is for"
                   for header in code_in(folder) if header.suffix == ".h" and header.stem not in words
                   and header.name not in PUBLIC_HEADERS]
        for file in code_in(folder):
            faults += [f"{file.relative_to(ROOT)}: uses <{header}>, and does not include it" for header in missing_includes(file)]
            for number, in_brackets, header in includes_of(file):
                seen += 1
                where = f"{file.relative_to(ROOT)}:{number}"
                if in_brackets:
                    if header.startswith("vtk") and room.split("/")[0] != "vtk":
                        faults.append(f"{where}: VTK is included outside src/vtk")
                    continue
                used = "library" if header in PUBLIC_HEADERS else header.rpartition("/")[0]
                if used not in rooms:
                    faults.append(f"{where}: {header} lies in no room")
                elif used != room:
                    uses.add((room, used))
                    if not any(used == name or used.startswith(name + "/") for name in allowed):
                        faults.append(f"{where}: {room} may not include {used}")
    faults += [f"{a} and {b} include each other" for a, b in sorted(uses) if a < b and (b, a) in uses]
    for public in PUBLIC_HEADERS:
        for number, in_brackets, header in includes_of(ROOT / "src" / public):
            seen += 1
            if not in_brackets or header.startswith("vtk") or "." in header and header != "stdint.h":
                faults.append(f"src/{public}:{number}: {header} is not of the standard library")
    precompiled = re.search(r"set\(TETFUSION_COMMON_HEADERS ([^)]*)\)", (ROOT / "CMakeLists.txt").read_text()).group(1)
    faults += [f"{header} is precompiled, but nobody looks who includes it"
               for header in re.findall("<(.*?)>", precompiled) if header not in NEEDS]
    if seen == 0:
        faults.append("found no includes at all: the test looks in the wrong place")
    for fault in faults:
        print(fault)
    print(f"{len(rooms)} rooms, {seen} includes, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
