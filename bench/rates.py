#!/usr/bin/env python3
"""Speed of the passes: the first greedy pass, and all of them (adjacency, passes, compaction) until nothing fuses.

On one thread, in one chunk, without a scalar tolerance, with the default stretch factor and without; jittered lattices of
each kind. Prints medians and best rates, in millions of the input's tetrahedra a second.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", metavar="TETFUSION")
    parser.add_argument("work", metavar="WORK_FOLDER", type=pathlib.Path)
    parser.add_argument("tets", metavar="TETS", nargs="?", default="1M")
    parser.add_argument("rounds", metavar="ROUNDS", nargs="?", type=int, default=5)
    a = parser.parse_args()
    command, work, tets, rounds = a.command, a.work, a.tets, a.rounds
    work.mkdir(parents=True, exist_ok=True)
    print("| mesh | stretch | reduction % | passes | first pass Mtet/s: median, best | all passes Mtet/s: median, best |")
    print("| --- | --- | --- | --- | --- | --- |")
    for kind in ("five", "kuhn", "bcc"):
        mesh = work / f"{kind}_{tets}.vtu"
        if not mesh.exists():
            subprocess.run([command, "generate", kind, "--tets", tets, "--jitter", "0.5", "-o", mesh, "--quiet"], check=True)
        for stretch in ("off", "5"):
            first, whole = [], []
            for _ in range(rounds):
                report = json.loads(subprocess.run(
                    [command, "simplify", mesh, "-o", work / "out.vtu", "--method", "tetfuse", "--threads", "1", "--regions",
                     "none", "--scalar-tolerance", "off", "--stretch-factor", stretch, "--chunk-tets", "128M", "--quiet",
                     "--report", "-"], check=True, capture_output=True).stdout)
                millions = report["input"]["tets"] / 1e6
                first.append(millions / report["lods"][0]["seconds"])
                whole.append(millions / report["seconds"]["passes"])
            print(f"| {kind} {tets} | {stretch} | {100 * report['reduction']:.1f} | {len(report['lods'])} "
                  f"| {statistics.median(first):.1f}, {max(first):.1f} | {statistics.median(whole):.2f}, {max(whole):.2f} |")


if __name__ == "__main__":
    main()
