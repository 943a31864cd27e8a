#!/usr/bin/env python3
"""Simplifying one mesh over threads and memory budgets, in one interleaved run.

Usage: scaling.py TETFUSION WORK_FOLDER [--threads 1,2] [--memory 8G,1G,512M,256M] [--tets 10M] [--repeat 3] ...  (--help)
Prints Markdown tables, writes scaling.csv and, with matplotlib, scaling.png. Figures are medians of the repetitions, peaks
of memory the largest. A budget that the command refuses is listed with what it says. Fails if the bytes of the results
differ, or if a run took more memory than its budget.
"""
import argparse
import statistics
import sys

from measure import (MIB, PHASES, add_mesh_options, bytes_of, figures, prepare, print_table, seconds_to_copy, simplify,
                     write_csv)


def plot(rows, path):
    try:
        import matplotlib
        matplotlib.use("Agg")
        import matplotlib.pyplot as pyplot
    except ImportError:
        print("no matplotlib: no plot")
        return
    figure, (rate, peak) = pyplot.subplots(1, 2, figsize=(11, 4.5))
    for memory in dict.fromkeys(r["memory"] for r in rows):
        these = [r for r in rows if r["memory"] == memory]
        rate.plot([r["threads"] for r in these], [r["Mtet/s"] for r in these], "o-", label=f"--memory {memory}")
    rate.set(xlabel="threads", ylabel="million tetrahedra of the input a second, file to file", ylim=(0, None))
    rate.legend()
    for threads in dict.fromkeys(r["threads"] for r in rows):
        these = [r for r in rows if r["threads"] == threads]
        peak.plot([bytes_of(r["memory"]) / MIB for r in these], [r["VmHWM MiB"] for r in these], "o", label=f"threads: {threads}")
    ends = [f(bytes_of(r["memory"]) / MIB for r in rows) for f in (min, max)]
    peak.plot(ends, ends, "k:", label="the budget")
    peak.set(xlabel="budget, MiB", ylabel="VmHWM, MiB", xscale="log", yscale="log")
    peak.legend()
    figure.tight_layout()
    figure.savefig(path)


def measure(args, mesh):
    """(threads, memory) -> runs; (threads, memory) -> why it was refused; seconds of copying."""
    runs, refused, copying = {}, {}, []
    out = args.work / "scaling_out.vtu"
    for _ in range(args.repeat):
        for memory in args.memory.split(","):
            for threads in (int(t) for t in args.threads.split(",")):
                if (threads, memory) in refused:
                    continue
                run = simplify(args.command, mesh, out, ["--threads", str(threads), "--memory", memory, *args.options.split()])
                if run.status == 5:
                    refused[threads, memory] = run.stderr
                elif run.status != 0:
                    sys.exit(f"--threads {threads} --memory {memory}: exit code {run.status}: {run.stderr}")
                else:
                    runs.setdefault((threads, memory), []).append(run)
        if runs:
            copying.append(seconds_to_copy(mesh, out))
    return runs, refused, copying


def speedup(first, runs, seconds):
    """The median over the repetitions: neighbours on the machine slow one as much as the other."""
    return round(statistics.median(seconds(a) / seconds(b) for a, b in zip(first, runs)), 2)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_mesh_options(parser, "10M")
    parser.add_argument("--threads", default="1,2")
    parser.add_argument("--memory", default="8G,1G,512M,256M")
    parser.add_argument("--repeat", type=int, default=3)
    args = parser.parse_args()
    mesh = prepare(args)
    runs, refused, copying = measure(args, mesh)
    rows = []
    for (threads, memory), these in runs.items():
        row = {"memory": memory, **figures(these, copying)}
        first = next(r for key, r in runs.items() if key[1] == memory)
        row["speedup"] = speedup(first, these, lambda r: r.seconds)
        row["rounds speedup"] = speedup(first, these, lambda r: sum(lod["seconds"] for lod in r.report["lods"]))
        row["sha256"] = these[0].digest
        rows.append(row)
    print(f"{mesh.name}, {mesh.stat().st_size / MIB:.0f} MiB; medians of {args.repeat}; "
          "speedup is against the first number of threads\n")
    digests = {run.digest for these in runs.values() for run in these}
    if rows:
        phases = [f"{name} s" for name in PHASES]
        print_table(rows, without=[*phases, "tets", "chunks", "copy s", "sha256"])
        print("By phase; the first round may be done in assemble:\n")
        print_table([{name: row[name] for name in ["memory", "threads", *phases, "wall s"]} for row in rows])
        write_csv(args.work / "scaling.csv", rows)
        plot(rows, args.work / "scaling.png")
        print(f"reading the input and writing the output alone: {rows[0]['copy s']} s")
        print(f"SHA-256: {', '.join(sorted(digests))}")
    for (threads, memory), why in refused.items():
        print(f"refused: --threads {threads} --memory {memory}: {why}")
    over = [f"--threads {r['threads']} --memory {r['memory']}: {r['VmHWM MiB']} MiB" for r in rows
            if r["VmHWM MiB"] * MIB > bytes_of(r["memory"])]
    if over:
        print("over the budget: " + "; ".join(over), file=sys.stderr)
    if len(digests) > 1:
        print("the bytes of the results differ", file=sys.stderr)
    return 1 if over or len(digests) != 1 else 0


if __name__ == "__main__":
    sys.exit(main())
