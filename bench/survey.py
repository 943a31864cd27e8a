#!/usr/bin/env python3
"""Meshes of others: each file in a folder is simplified and verified, in several ways, and what is refused is counted by its
reason. A file whose result breaks a promise, and a command that crashes or takes too long, is a fault.

survey.py TETFUSION FOLDER [--options "..." ...] [--largest 1M] [--seconds 300]
"""
import argparse
import collections
import pathlib
import re
import subprocess
import sys
import tempfile

SUFFIXES = {".vtu", ".pvtu", ".vtk", ".vtm", ".msh", ".mesh", ".meshb", ".ele", ".e", ".exo", ".ex2", ".exii", ".g", ".case", ".cgns",
            ".vti", ".vtkhdf", ".vtr", ".vts", ".xdmf", ".xmf"}
WAYS = ["--reduction 50%",
        "--reduction 85% --boundary 0.5% --chunk-tets 700 --threads 2",
        "--reduction 90% --boundary planar --conserve --regions none",
        "--method tetfuse --chunk-tets 1000",
        "--reduction 95% --boundary 2% --regions none --chunk-tets 1500 --threads 2 --memory 500M"]
REFUSED = (2, 3, 4)


def size_of(text):
    number, unit = re.fullmatch(r"([\d.]+)([kMG]?)", text).groups()
    return float(number) * {"": 1, "k": 1e3, "M": 1e6, "G": 1e9}[unit]


def reason_of(message, path):
    """The error without the names and numbers that differ from file to file."""
    text = message.strip().splitlines()[-1].replace(str(path), "FILE").removeprefix("tetfusion: error: ")
    return re.sub(r"\d+", "N", re.sub(r"(?:line|byte) \d+: |'[^']*'", "", text))[:100]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--options", action="append", help="of simplify; given again, another way (default: five ways)")
    parser.add_argument("--largest", default="1G", help="files that are larger are left out")
    parser.add_argument("--seconds", type=float, default=300, help="that a run may take")
    arguments = parser.parse_args()
    paths = sorted(path for path in arguments.folder.rglob("*")
                   if path.suffix.lower() in SUFFIXES and path.is_file() and path.stat().st_size <= size_of(arguments.largest))
    ways = arguments.options or WAYS
    refused, faults, read, runs = collections.Counter(), [], 0, 0
    with tempfile.TemporaryDirectory() as folder:
        for path in paths:
            for way in ways:
                words = [arguments.command, "simplify", path, "-o", f"{folder}/out.vtu", "--verify", "--tetrahedralize", "--linearize", *way.split()]
                try:
                    result = subprocess.run(words, capture_output=True, timeout=arguments.seconds, check=False)
                except subprocess.TimeoutExpired:
                    faults.append((path, way, "takes too long"))
                    continue
                said = result.stderr.decode(errors="replace")
                if result.returncode in REFUSED:
                    refused[reason_of(said, path)] += 1
                    break
                runs += 1
                read += way == ways[0]
                if result.returncode != 0:
                    faults.append((path, way, f"exit code {result.returncode}: {said.strip()}"))
    print(f"{len(paths)} files: {read} are read, {sum(refused.values())} refused; {runs} runs, {len(faults)} faults\n")
    for reason, count in refused.most_common():
        print(f"{count:6} {reason}")
    for fault in faults:
        print("FAULT", *fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
