#!/usr/bin/env python3
"""Simplifies a mesh in order, then with its work scrambled: every piece of it at another's turn, one in eight late.

Usage: scrambled.py SCRAMBLED WORK_FOLDER [--seeds 1,2,3] [--threads 2] [--memory 8G,512M] [--tets 1M] ...  (--help)
SCRAMBLED is build/release/scrambled. Prints a row a run; exit code 1 if a result differs from that of the run in order.
"""
import argparse
import sys

from measure import Run, add_mesh_options, prepare, print_table, sha256


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_mesh_options(parser, "1M")
    parser.add_argument("--seeds", default="1,2,3")
    parser.add_argument("--threads", default="2")
    parser.add_argument("--memory", default="8G,512M")
    args = parser.parse_args()
    in_order = args.command.resolve().parent / "tetfusion"
    scrambled, args.command = args.command.resolve(), in_order
    mesh, out = prepare(args), args.work / "out.vtu"
    rows = []
    for memory in args.memory.split(","):
        for seed in (None, *args.seeds.split(",")):
            command = [in_order] if seed is None else [scrambled, seed]
            run = Run([*command, "simplify", mesh, "-o", out, "--quiet", "--threads", "1" if seed is None else args.threads,
                       "--memory", memory, *args.options.split()])
            if run.status != 0:
                sys.exit(f"exit code {run.status}: {run.stderr}")
            rows.append({"memory": memory, "schedule": seed or "in order", "moved": "" if seed is None else run.stderr.split()[0],
                         "s": f"{run.seconds:.1f}", "SHA-256": sha256(out)[:16]})
    print_table(rows)
    return 0 if len({row["SHA-256"] for row in rows}) == 1 else 1


if __name__ == "__main__":
    sys.exit(main())
