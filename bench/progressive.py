#!/usr/bin/env python3
"""The way back of a simplification: how large its file is, what it takes to write and to go, and how the error falls on it.

Usage: progressive.py TETFUSION WORK_FOLDER MESH.vtu [--reduction 90%] [--levels 10] [--options ...]
The file's size is told as a share of MESH as a .vtu of several encodings. Mtet/s are the tetrahedra that refine brought back in a
second of processor time, reading and writing included. Levels share the tetrahedra between the result and the original evenly; errors are what
compare finds for the first array, as shares of the range; each level is checked. Fails where the way back does not end at MESH (as a raw .vtu, by its
SHA-256), or the mean error does not fall from level to level.
"""
import argparse
import json
import pathlib
import subprocess
import sys

from measure import print_table, sha256


def run(*command):
    return subprocess.run([*map(str, command), "--quiet"], check=True, capture_output=True).stdout


def report_of(*command):
    return json.loads(run(*command, "--report", "-"))


def mib(report):
    return report["peak_rss_bytes"] >> 20


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", metavar="TETFUSION", type=pathlib.Path)
    parser.add_argument("work", metavar="WORK_FOLDER", type=pathlib.Path)
    parser.add_argument("mesh", metavar="MESH.vtu", type=pathlib.Path)
    parser.add_argument("--reduction", default="90%")
    parser.add_argument("--levels", type=int, default=10)
    parser.add_argument("--options", default="", help="for simplify")
    parser.add_argument("--refine-options", default="", help="for refine")
    args = parser.parse_args()
    args.work.mkdir(parents=True, exist_ok=True)
    command = args.command.resolve()
    out, back, level = (args.work / f"progressive_{name}" for name in ("out.vtu", "run.tfp", "level.vtu"))

    simplify = [command, "simplify", args.mesh, "-o", out, "--reduction", args.reduction, *args.options.split()]
    plain = report_of(*simplify)
    noted = report_of(*simplify, "--progressive", back)
    row = {"mesh": args.mesh.stem, "tetrahedra": noted["input"]["tets"], "left": noted["output"]["tets"],
           ".tfp MB": round(back.stat().st_size / 1e6, 2)}
    for encoding in ("lz4", "zlib", "raw"):
        run(command, "convert", args.mesh, level, "--encoding", encoding)
        row[f"of {encoding} %"] = round(100 * back.stat().st_size / level.stat().st_size, 1)
    original = sha256(level)
    refine = [command, "refine", back, "-o", level, *args.refine_options.split()]
    full = report_of(*refine, "--encoding", "raw")
    is_back = sha256(level) == original
    came = full["result"]["tets"] - full["base"]["tets"]
    row |= {"simplify cpu s": round(plain["cpu_seconds"], 2), "with .tfp": round(noted["cpu_seconds"], 2), "MiB": mib(plain),
            "with .tfp MiB": mib(noted), "refine cpu s": round(full["cpu_seconds"], 2),
            "Mtet/s": round(came / full["cpu_seconds"] / 1e6, 2), "refine MiB": mib(full), "the original": "yes" if is_back else "NO"}
    print_table([row])

    rows, means = [], []
    for i in range(args.levels):
        goal = full["base"]["tets"] + came * i // args.levels
        report = report_of(*refine, "--tets", goal)
        run(command, "check", level)
        error = report_of(command, "compare", args.mesh, level)["arrays"][0]
        means.append(error["rms"])
        rows.append({"tetrahedra": report["result"]["tets"], "rms %": f"{100 * error['rms']:.4f}", "max %": f"{100 * error['max']:.3f}"})
    print()
    print_table(rows)
    if not is_back or any(after >= before for before, after in zip(means, means[1:])):
        sys.exit("not the original again, or an error that does not fall")


if __name__ == "__main__":
    main()
