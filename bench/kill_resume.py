#!/usr/bin/env python3
"""Kills runs at random moments, with SIGKILL or SIGINT by chance, and resumes them with other threads and memory.

Usage: kill_resume.py TETFUSION WORK_FOLDER [--kills 20] [--seed 1] [--threads 1,2,3] [--tets 1M] ...  (--help)
The budgets lie between what the run needs with its mesh on disk and in memory, so that it works in the scratch folder.
Prints a line a kill (when, what was left), a line a run, and a summary. Fails if any result differs from that of a straight
run, an exit code or a message is not as promised, a file is under the output's name that is not whole, or anything stays
when a run is done.
"""
import argparse
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time

from measure import MIB, Run, add_mesh_options, bytes_of, prepare, sha256


class Trial:
    """A run of simplify that is killed and resumed until it is done."""

    def __init__(self, args, mesh):
        self.mesh = mesh
        self.folder = args.work / "kill_resume"
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir()
        self.out = self.folder / "out.vtu"
        self.scratch = self.folder / "out.vtu.tetfusion"
        self.simplify = [args.command, "simplify", mesh, "-o", self.out, "--progress", "never", *args.options.split()]
        self.threads = [int(t) for t in args.threads.split(",")]
        self.budgets = {t: self.needs(t) for t in self.threads}
        self.seconds = 0
        self.digest = None
        self.killed = {"SIGKILL": 0, "SIGINT": 0}
        self.resumed = self.anew = self.runs = self.parts = self.whole = 0
        self.faults = []

    def needs(self, threads):
        """Bytes: out of core, in core. The refusal of a budget that is too small names both."""
        run = Run([*self.simplify, "--threads", str(threads), "--memory", "1M"])
        amounts = re.search(r"needs about ([\d.]+ \w+) of memory .* \(and ([\d.]+ \w+) with everything", run.stderr)
        if run.status != 5 or not amounts:
            sys.exit(f"expected a refusal of --memory 1M, got exit code {run.status}: {run.stderr}")
        return bytes_of(amounts[1]), bytes_of(amounts[2])

    def straight(self):
        """In core, and then on disk, which is timed: how long a run goes on, and what comes out."""
        digests = []
        for options in ([], self.some_options(self.threads[0])):
            run = Run([*self.simplify, *options])
            if run.status != 0:
                sys.exit(f"a straight run failed: {run.stderr}")
            digests.append(sha256(self.out))
            self.seconds = run.seconds
        if digests[0] != digests[1]:
            self.fault("in core and out of core differ")
        self.digest = digests[0]

    def some_options(self, threads=None):
        threads = threads or random.choice(self.threads)
        least, most = self.budgets[threads]
        memory = random.randint((least >> 20) + 1, max((most >> 20) - 1, (least >> 20) + 1))
        return ["--threads", str(threads), "--memory", f"{memory}M"]

    def fault(self, what):
        self.faults.append(what)
        print(f"FAULT: {what}", flush=True)

    def start(self, resume):
        self.options = self.some_options() + (["--resume"] if resume else [])
        return subprocess.Popen([*self.simplify, *self.options], stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def left(self):
        """What lies in the folder, in words, and the bytes in the scratch folder."""
        names = sorted(set(os.listdir(self.folder)) - {"out.vtu"})
        if not self.scratch.exists():
            return names, "no scratch folder"
        files = [f for f in self.scratch.iterdir() if f.is_file()]
        states = sorted((f.stem for f in files if f.suffix == ".state"), key=lambda s: (len(s), s))
        size = sum(f.stat().st_size for f in files) / MIB
        return names, f"scratch folder of {len(files)} files, {size:.0f} MiB, states {', '.join(states) or 'none'}"

    def kill(self, process, number, most):
        """Kills a run unless it is done before. True: it was killed."""
        name = random.choice(list(self.killed))
        after = random.uniform(0.01, most)
        try:
            process.wait(timeout=after)
        except subprocess.TimeoutExpired:
            process.send_signal(getattr(signal, name))
        message = process.stderr.read().strip()
        process.wait()
        self.count_resumed(message)
        if process.returncode == 0:
            return False
        self.killed[name] += 1
        names, left = self.left()
        self.judge_killed(process.returncode, name, message, names)
        print(f"  run {number}: {name} after {after:.2f} s of {self.seconds:.2f}, {' '.join(self.options)}: {left}",
              flush=True)
        return True

    def judge_killed(self, status, name, message, names):
        if status != (130 if name == "SIGINT" else -signal.SIGKILL):
            self.fault(f"{name}: exit code {status}: {message}")
        if self.out.exists():  # killed while tidying up
            if sha256(self.out) != self.digest:
                self.fault(f"{name}: there is an output that is not whole")
            self.out.unlink()
            self.whole += 1
        says_so = "--resume goes on from there" in message
        if name == "SIGINT" and "--resume" not in self.options and self.scratch.exists() != says_so:
            self.fault(f"SIGINT: the message does not say what was left: {message}")
        parts = [n for n in names if n.endswith(".part")]
        if name == "SIGINT" and parts:
            self.fault(f"SIGINT: left {parts}")
        for part in parts:  # a killed process cannot tidy up after itself
            self.parts += 1
            (self.folder / part).unlink()

    def count_resumed(self, message):
        if "--resume" in self.options:
            rounds = re.search(r"going on after (\d+) rounds", message)
            self.resumed += bool(rounds)
            self.anew += not rounds

    def run(self, number, kills):
        self.out.unlink(missing_ok=True)
        self.runs += 1
        done = 0
        process = self.start(False)
        while done < kills and self.kill(process, number, 1.02 * self.seconds):
            done += 1
            process = self.start(True)
        message = process.communicate()[1].strip() if process.returncode is None else ""
        if message:
            self.count_resumed(message)
        if process.returncode != 0:
            self.fault(f"run {number}: exit code {process.returncode}: {message}")
        same = self.out.exists() and sha256(self.out) == self.digest
        if not same:
            self.fault(f"run {number}: the result differs from that of a straight run")
        names, _ = self.left()
        if names:
            self.fault(f"run {number}: done, and left {names}")
            shutil.rmtree(self.scratch, ignore_errors=True)
        print(f"run {number}: {done} kills, {'same bytes' if same else 'DIFFERENT'}, left: {', '.join(names) or 'nothing'}",
              flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_mesh_options(parser, "1M")
    parser.add_argument("--threads", default="1,2,3", help="to choose from")
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    random.seed(args.seed)
    trial = Trial(args, prepare(args))
    start = time.perf_counter()
    trial.straight()
    print(f"{trial.mesh.name}: {trial.seconds:.2f} s, SHA-256 {trial.digest}", flush=True)
    while sum(trial.killed.values()) < args.kills:
        trial.run(trial.runs + 1, min(random.randint(1, 3), args.kills - sum(trial.killed.values())))
    print("\n| mesh | runs | SIGKILL | SIGINT | resumed from a round | begun anew | output was whole already "
          "| parts of output left by SIGKILL | faults | wall s |\n|" + " --- |" * 10)
    print(f"| {trial.mesh.stem} | {trial.runs} | {trial.killed['SIGKILL']} | {trial.killed['SIGINT']} | {trial.resumed} "
          f"| {trial.anew} | {trial.whole} | {trial.parts} | {len(trial.faults)} | {time.perf_counter() - start:.0f} |")
    return 1 if trial.faults else 0


if __name__ == "__main__":
    sys.exit(main())
