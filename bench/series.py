#!/usr/bin/env python3
"""The steps of a moving front, simplified on one mesh: memory, time beside that of one step, errors of each step by `compare`.

Usage: series.py TETFUSION WORK_FOLDER [--tets 10M] [--steps 30] [--memory 1G] [--bound 5%] [--cold] [--repeat 1] [--options ...]
A sphere grows through a jittered five-split of the unit box. "x" is the time of the series over that of one step alone, with the same
options, and of reading all steps and writing and syncing as many bytes as the outputs have, in each of the turns; seconds are medians. The files (0.05 GB a million
tetrahedra and step) are removed at the end, unless --keep is given.
"""
import argparse
import json
import pathlib
import shutil
import statistics
import subprocess
import sys

from measure import MIB, Run, bytes_of, drop_from_page_cache, print_table, seconds_to_copy


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", metavar="TETFUSION", type=pathlib.Path)
    parser.add_argument("work", metavar="WORK_FOLDER", type=pathlib.Path)
    parser.add_argument("--tets", default="10M", help="of each step; default 10M, 1M for a quick run")
    parser.add_argument("--steps", type=int, default=30)
    parser.add_argument("--memory", default="1G")
    parser.add_argument("--bound", default="5%", help="--max-error of both; default 5%%")
    parser.add_argument("--options", default="--reduction 90%", help="for simplify; default --reduction 90%%")
    parser.add_argument("--repeat", type=int, default=1, help="turns: the series, one step, reading and writing")
    parser.add_argument("--keep", action="store_true", help="the files of the steps, for another run")
    parser.add_argument("--cold", action="store_true", help="drop the steps from the page cache before each run, and before the copying")
    args = parser.parse_args()
    folder = args.work / f"series_{args.tets}_{args.steps}"
    folder.mkdir(parents=True, exist_ok=True)
    steps = [folder / f"step_{i:03d}.vtu" for i in range(args.steps)]
    for i, step in enumerate(steps):
        if not step.exists():
            subprocess.run([args.command, "generate", "five", "--tets", args.tets, "--jitter", "0.5", "--time", str(4.5 * i / args.steps),
                            "-o", step, "--quiet"], check=True)
    options = ["--array", "front", "--max-error", args.bound, "--memory", args.memory, *args.options.split(), "--quiet", "--report",
               "-"]

    def drop_steps():
        for step in steps if args.cold else []:
            drop_from_page_cache(step)

    def run(inputs, out):
        drop_steps()
        done = Run([args.command, "simplify", *inputs, "-o", out, *options])
        if done.status != 0:
            sys.exit(f"exit code {done.status}: {done.stderr}")
        done.report = json.loads(done.stdout)
        return done
    def copy():
        drop_steps()
        return sum(seconds_to_copy(step, out) for step, out in zip(steps, outputs))
    middle = steps[len(steps) // 2]
    turns = []
    for _ in range(args.repeat):
        all_steps = run(steps, folder / "out_{step}.vtu")
        outputs = [pathlib.Path(p) for p in all_steps.report["outputs"]]
        turns.append((all_steps, run([middle], folder / "one.vtu"), copy()))
    all_steps, one = turns[0][:2]
    seconds = [statistics.median(turn[0].seconds for turn in turns), statistics.median(turn[1].seconds for turn in turns),
               statistics.median(turn[2] for turn in turns)]
    errors = []
    for step, out in zip(steps, outputs):
        compared = subprocess.run([args.command, "compare", step, out, "--array", "front", "--max-error", args.bound, "--quiet",
                                   "--report", "-"], capture_output=True)
        if compared.returncode not in (0, 1):
            sys.exit(compared.stderr.decode())
        front = next(a for a in json.loads(compared.stdout)["arrays"] if a["name"] == "front")
        errors.append((front["rms"], front["max"], compared.returncode))
    rms, largest, broken = zip(*errors)
    peak = max(all_steps.peak, all_steps.report["peak_rss_bytes"])
    print_table([{
        "tetrahedra": all_steps.report["input"]["tets"], "steps": args.steps, "less %": round(100 * all_steps.report["reduction"], 2),
        "tries": all_steps.report["tries"], "VmHWM MiB": round(peak / MIB, 1), "one step s": round(seconds[1], 1), "one step cpu s": round(one.cpu, 1),
        "one step less %": round(100 * one.report["reduction"], 2), "reading and writing s": round(seconds[2], 1),
        "series s": round(seconds[0], 1), "cpu s": round(all_steps.cpu, 1),
        "x": " ".join(f"{a.seconds / (b.seconds + c):.2f}" for a, b, c in turns),
        "rms %": f"{100 * min(rms):.3g} to {100 * max(rms):.3g}", "max %": f"{100 * min(largest):.3g} to {100 * max(largest):.3g}",
        "broken": sum(broken)}])
    if not args.keep:
        shutil.rmtree(folder)
    if peak > bytes_of(args.memory) or any(broken):
        sys.exit("beyond the memory, or the bound")


if __name__ == "__main__":
    main()
