#!/usr/bin/env python3
"""Speed of the passes: the first greedy pass, and all of them (adjacency, passes, compaction) until nothing fuses.

Usage: rates.py TETFUSION WORK_FOLDER [TETS [ROUNDS]]     (default 1M, 5 rounds)
On one thread, in one chunk, without a scalar tolerance, with the default stretch factor and without; jittered lattices of
each kind. Prints medians and best rates, in millions of the input's tetrahedra a second.
"""
import json
import pathlib
import statistics
import subprocess
import sys


def main():
    command, work = sys.argv[1], pathlib.Path(sys.argv[2])
    tets = sys.argv[3] if len(sys.argv) > 3 else "1M"
    rounds = int(sys.argv[4]) if len(sys.argv) > 4 else 5
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
                     "none", "--scalar-tolerance", "off", "--stretch-factor", stretch, "--chunk-tets", "1G", "--quiet",
                     "--report", "-"], check=True, capture_output=True).stdout)
                millions = report["input"]["tets"] / 1e6
                first.append(millions / report["lods"][0]["seconds"])
                whole.append(millions / report["seconds"]["passes"])
            print(f"| {kind} {tets} | {stretch} | {100 * report['reduction']:.1f} | {len(report['lods'])} "
                  f"| {statistics.median(first):.1f}, {max(first):.1f} | {statistics.median(whole):.2f}, {max(whole):.2f} |")


if __name__ == "__main__":
    main()
