#!/usr/bin/env python3
"""The passes over threads and chunk sizes, in one interleaved run.

Usage: scaling.py TETFUSION WORK_FOLDER [TETS [ROUNDS [THREADS,...]]]     (default 10M, 3 rounds, threads 1,2)
Simplifies a jittered lattice until nothing fuses. Prints a Markdown table, writes scaling.csv, and checks that the bytes of
the result depend on the chunk size alone. With matplotlib there is a plot too (scaling.png).
"""
import csv
import hashlib
import json
import pathlib
import statistics
import subprocess
import sys


def run(command, mesh, out, threads, chunk_tets):
    report = subprocess.run(
        [command, "simplify", mesh, "-o", out, "--method", "tetfuse", "--regions", "none", "--scalar-tolerance", "off",
         "--threads", str(threads), "--chunk-tets", chunk_tets, "--quiet", "--report", "-"], check=True, capture_output=True)
    return json.loads(report.stdout), hashlib.sha256(out.read_bytes()).hexdigest()


def plot(rows, path):
    try:
        import matplotlib
        matplotlib.use("Agg")
        import matplotlib.pyplot as pyplot
    except ImportError:
        return
    for chunk_tets in dict.fromkeys(r["chunk_tets"] for r in rows):
        these = [r for r in rows if r["chunk_tets"] == chunk_tets]
        pyplot.plot([r["threads"] for r in these], [r["mtets_per_s"] for r in these], "o-", label=f"{chunk_tets} a chunk")
    pyplot.xlabel("threads")
    pyplot.ylabel("passes, million tetrahedra of the input a second")
    pyplot.legend()
    pyplot.savefig(path)


def main():
    command, work = sys.argv[1], pathlib.Path(sys.argv[2])
    tets = sys.argv[3] if len(sys.argv) > 3 else "10M"
    rounds = int(sys.argv[4]) if len(sys.argv) > 4 else 3
    threads = [int(t) for t in (sys.argv[5] if len(sys.argv) > 5 else "1,2").split(",")]
    chunk_sizes = ["50k", "200k", "1M", "1000M"]
    work.mkdir(parents=True, exist_ok=True)
    mesh = work / f"five_{tets}.vtu"
    if not mesh.exists():
        subprocess.run([command, "generate", "five", "--tets", tets, "--jitter", "0.5", "-o", mesh, "--quiet"], check=True)
    runs, digests = {}, {}
    for _ in range(rounds):
        for chunk_tets in chunk_sizes:
            for t in threads:
                report, digest = run(command, mesh, work / "out.vtu", t, chunk_tets)
                runs.setdefault((chunk_tets, t), []).append(report)
                digests.setdefault(chunk_tets, set()).add(digest)
    rows = []
    for (chunk_tets, t), reports in runs.items():
        passes = statistics.median(r["seconds"]["passes"] for r in reports)
        one = statistics.median(a["seconds"]["passes"] / b["seconds"]["passes"]
                                for a, b in zip(runs[chunk_tets, threads[0]], reports))
        rows.append({"chunk_tets": chunk_tets, "chunks": reports[0]["chunks"], "threads": t,
                     "rounds": len(reports[0]["lods"]), "reduction": round(100 * reports[0]["reduction"], 2),
                     "passes_s": round(passes, 2), "mtets_per_s": round(reports[0]["input"]["tets"] / 1e6 / passes, 2),
                     "speedup": round(one, 2), "total_s": round(statistics.median(r["seconds"]["total"] for r in reports), 2),
                     "peak_bytes_per_tet": round(max(r["peak_rss_bytes"] for r in reports) / reports[0]["input"]["tets"])})
    print("| " + " | ".join(rows[0]) + " |\n|" + " --- |" * len(rows[0]))
    for row in rows:
        print("| " + " | ".join(str(v) for v in row.values()) + " |")
    with open(work / "scaling.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)
    plot(rows, work / "scaling.png")
    if any(len(d) > 1 for d in digests.values()):
        sys.exit("the bytes of the result depend on the number of threads")


if __name__ == "__main__":
    main()
