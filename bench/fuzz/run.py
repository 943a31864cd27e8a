#!/usr/bin/env python3
"""Runs the fuzz targets one after the other, each from its seeds and the cases of tests/fuzz, and prints a row for
each: executions, time, how many inputs the corpus came to, what was found. Findings lie in WORK/TARGET.found.

    cmake --preset fuzz && cmake --build --preset fuzz
    python3 bench/fuzz/run.py build/fuzz /tmp/fuzz --seconds 1800
"""
import argparse
import pathlib
import re
import shutil
import subprocess
import sys
import time

TARGETS = ["vtu", "pvtu", "pvd", "legacy", "medit", "gmsh", "tetgen", "chunk_store", "map", "progressive", "command_line"]
ROOT = pathlib.Path(__file__).resolve().parent.parent.parent

# An input has at most MAX_BYTES; what it makes a reader allocate at once must be in proportion: LZMA may make 16,384
# bytes of one, and take 72 MiB itself.
MAX_BYTES = 8192
MALLOC_MIB = {"vtu": 144, "pvtu": 144}
OTHER_MALLOC_MIB = 16
RSS_MIB = 1024


def fuzz(target, args):
    corpus = args.work / target
    corpus.mkdir(parents=True, exist_ok=True)
    for case in (ROOT / "tests/fuzz" / target).glob("*"):
        shutil.copy(case, corpus)
    found = args.work / f"{target}.found"
    found.mkdir(exist_ok=True)
    log = args.work / f"{target}.log"
    command = ["nice", "-n", "19", args.build / f"fuzz_{target}", corpus, f"-max_total_time={args.seconds}",
               f"-runs={args.runs}", f"-max_len={MAX_BYTES}", f"-malloc_limit_mb={MALLOC_MIB.get(target, OTHER_MALLOC_MIB)}",
               f"-rss_limit_mb={RSS_MIB}", "-timeout=10", f"-artifact_prefix={found}/", "-print_final_stats=1",
               f"-dict={ROOT / 'bench/fuzz/words.dict'}"]
    if target == "command_line":
        command.append("-close_fd_mask=3")
    begin = time.monotonic()
    with log.open("wb") as out:
        status = subprocess.run(command, stdout=out, stderr=subprocess.STDOUT, check=False).returncode
    seconds = time.monotonic() - begin
    text = log.read_text(errors="replace")
    runs = re.search(r"stat::number_of_executed_units: (\d+)", text)
    cover = re.findall(r"cov: (\d+) ft: (\d+) corp: (\d+)", text)
    findings = len(list(found.iterdir()))
    print(f"| {target} | {runs.group(1) if runs else '?'} | {seconds:.0f} | {cover[-1][2] if cover else '?'} "
          f"| {findings} |", flush=True)
    return status == 0 and findings == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path, help="the build folder")
    parser.add_argument("work", type=pathlib.Path, help="folder for corpora, logs and findings")
    parser.add_argument("--seconds", type=int, default=1800, help="of each target, at most")
    parser.add_argument("--runs", type=int, default=10_000_000, help="of each target, at most")
    parser.add_argument("--targets", nargs="+", default=TARGETS, choices=TARGETS)
    args = parser.parse_args()
    subprocess.run([args.build / "fuzz_replay", "--write-seeds", args.work], check=True)
    print("| target | executions | s | corpus | findings |\n| --- | --- | --- | --- | --- |")
    return 0 if all([fuzz(target, args) for target in args.targets]) else 1


if __name__ == "__main__":
    sys.exit(main())
