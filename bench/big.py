#!/usr/bin/env python3
"""One large mesh, simplified once: the measures as one row, appended to big.csv.

Usage: big.py TETFUSION WORK_FOLDER [--tets 69.5M] [--kind five] [--shuffle] [--memory 1G] [--threads 2] [--cold] ...  (--help)
Fails if the run did, or took more memory than its budget. The result stays in the work folder.
"""
import argparse
import datetime
import sys

from measure import (MIB, PHASES, add_mesh_options, bytes_of, drop_from_page_cache, figures, prepare, print_table,
                     seconds_to_copy, simplify, write_csv)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_mesh_options(parser, "69.5M", grading=4)
    parser.add_argument("--threads", default="2")
    parser.add_argument("--memory", default="1G")
    parser.add_argument("--cold", action="store_true", help="drop the input from the page cache before it is read")
    args = parser.parse_args()
    mesh = prepare(args)
    out = args.work / f"big_out_{mesh.name}"
    if args.cold:
        drop_from_page_cache(mesh)
    run = simplify(args.command, mesh, out, ["--threads", args.threads, "--memory", args.memory, *args.options.split()])
    if run.status != 0:
        sys.exit(f"exit code {run.status} after {run.seconds:.0f} s: {run.stderr}")
    if args.cold:
        drop_from_page_cache(mesh)
    copying = seconds_to_copy(mesh, out)
    row = {"date": datetime.date.today().isoformat(), "mesh": mesh.stem, "cache": "cold" if args.cold else "as it was",
           "options": args.options, "memory": args.memory, **figures([run], [copying]),
           "input MiB": round(mesh.stat().st_size / MIB), "output MiB": round(out.stat().st_size / MIB),
           "sha256": run.digest, "version": run.report["version"]}
    phases = [f"{name} s" for name in PHASES]
    print_table([row], without=[*phases, "date", "options", "sha256", "version"])
    print_table([{name: row[name] for name in [*phases, "wall s"]}])
    print(f"SHA-256: {run.digest}")
    write_csv(args.work / "big.csv", [row], append=True)
    if run.peak > bytes_of(args.memory):
        sys.exit(f"over the budget: {run.peak / MIB:.1f} MiB with --memory {args.memory}")


if __name__ == "__main__":
    main()
