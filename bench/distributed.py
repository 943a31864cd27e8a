#!/usr/bin/env python3
"""The distributed run under ParaView on 1, 2 and 4 processes, beside the command: time, reduction, errors, and whether the pieces fit.

Usage: distributed.py TETFUSION PVBATCH SCRIPT [--tets 2M] [--reduction 80%], where SCRIPT is the distributed.py that was installed with the
plugin, and pvbatch finds its libraries and Python modules. Prints rows of the table in README.md, and after each what the ranks said.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile
import time


def run(*arguments):
    began = time.monotonic()
    done = subprocess.run([*map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{arguments}: exit code {done.returncode}\n{done.stdout}")
    return done.stdout, time.monotonic() - began


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("tetfusion")
    parser.add_argument("pvbatch")
    parser.add_argument("script")
    parser.add_argument("--tets", default="2M")
    parser.add_argument("--reduction", default="80%")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        raw, mesh, report = folder / "raw.vtu", folder / "in.vtu", folder / "report.json"
        run(options.tetfusion, "generate", "five", "--tets", options.tets, "--jitter", "0.3", "-o", raw, "--quiet")
        run(options.tetfusion, "convert", raw, mesh, "--encoding", "inline", "--quiet")
        goal = ["--reduction", options.reduction, "--regions", "none"]
        print("| run | s | tetrahedra | valid | boundary | rms error | largest error |\n| --- | --- | --- | --- | --- | --- | --- |")
        for name, start in [("command", [options.tetfusion, "simplify"])] + [
                (f"{n} ranks", ["mpirun", "-n", n, options.pvbatch, options.script]) for n in (1, 2, 4)]:
            out = folder / (name.replace(" ", "") + ".pvtu")
            said, seconds = run(*start, mesh, "-o", out, *goal)
            run(options.tetfusion, "check", out, "--quiet", "--report", report)
            check = json.loads(report.read_text())
            run(options.tetfusion, "compare", mesh, out, "--quiet", "--report", report)
            compare = json.loads(report.read_text())
            steering = compare["arrays"]
            steering = next(a for a in steering if a["name"] == "temperature") if isinstance(steering, list) else steering["temperature"]
            surface = "identical" if compare["surface"]["identical"] else "moved"
            print(f"| {name} | {seconds:.1f} | {check['tets']:,} | {'yes' if check['valid'] else 'no'} | {surface} | {steering['rms']:.3%} | "
                  f"{steering['max']:.2%} |", flush=True)
            if name != "command":
                print("".join(f"    {line}\n" for line in said.splitlines() if line.startswith(("read", "pass", "wrote"))), flush=True)


if __name__ == "__main__":
    main()
