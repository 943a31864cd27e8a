#!/usr/bin/env python3
"""A bound on the error at every point: does `compare --max-error X` agree after `simplify --max-error X`, and what is left?

Usage: bounds.py TETFUSION WORK_FOLDER [--meshes ball1m,five1m,bluntfin,...] [--bounds 0.1%,1%,5%] [--boundaries exact,0.5%] ...  (--help)
One thread. Prints a Markdown table and writes bounds.csv. Fails if a bound does not hold.
"""
import argparse
import pathlib
import sys

from measure import MIB, Run, print_table, write_csv
from peers import asked, find_mesh, our_seconds, steering_array


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", metavar="TETFUSION", type=pathlib.Path, help="the command")
    parser.add_argument("work", metavar="WORK_FOLDER", type=pathlib.Path, help="for meshes, results and bounds.csv")
    parser.add_argument("--data", type=pathlib.Path, default="../shared/data", help="folder of real meshes; default %(default)s")
    parser.add_argument("--meshes", default="ball1m,five1m,bluntfin,spx,disk_out_ref", help="as for peers.py; default %(default)s")
    parser.add_argument("--bounds", default="0.1%,1%,5%", help="shares of the array's range; default %(default)s")
    parser.add_argument("--boundaries", default="exact,0.5%", help="as simplify --boundary takes them; default %(default)s")
    parser.add_argument("--options", default="", help="more options for simplify")
    args = parser.parse_args()
    args.command = args.command.resolve()
    args.work.mkdir(parents=True, exist_ok=True)
    return args


def measure(args, mesh, array, bound, boundary):
    out = args.work / "bounds_out.vtu"
    report = asked(args.command, "simplify", mesh, "-o", out, "--max-error", bound, "--array", array, "--boundary", boundary,
                   "--regions", "none", "--threads", "1", *args.options.split())
    compared = Run([args.command, "compare", mesh, out, "--max-error", bound, "--array", array, "--quiet"])
    field = next(a for a in asked(args.command, "compare", mesh, out)["arrays"]
                 if a["association"] == "point" and a["name"] == array)
    return {"mesh": mesh.stem, "array": array, "boundary": boundary, "bound %": bound.rstrip("%"),
            "tets": report["input"]["tets"], "less %": round(100 * report["reduction"], 2), "cpu s": round(our_seconds(report), 2),
            "MiB": round(report["peak_rss_bytes"] / MIB, 1), "rms %": f"{100 * field['rms']:.3g}",
            "max %": f"{100 * field['max']:.4g}", "holds": "yes" if compared.status == 0 else f"no: exit code {compared.status}"}


def main():
    args = arguments()
    rows = []
    for name in args.meshes.split(","):
        mesh = find_mesh(args, name)
        if mesh is None:
            print(f"{name}: not there, left out", file=sys.stderr)
            continue
        array = steering_array(asked(args.command, "info", mesh))
        rows += [measure(args, mesh, array, bound, boundary)
                 for boundary in args.boundaries.split(",") for bound in args.bounds.split(",")]
    if rows:
        print_table(rows)
        write_csv(args.work / "bounds.csv", rows)
    return 0 if rows and all(row["holds"] == "yes" for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
