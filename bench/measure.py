"""What the benchmarks share: meshes, a run of the command watched from outside, tables.

Sizes of memory are as the command takes them: powers of 1024. Rates are millions of the input's tetrahedra a second.
"""
import csv
import hashlib
import json
import os
import pathlib
import re
import statistics
import subprocess
import tempfile
import time

PHASES = ["read", "locate", "scatter cells", "scatter points", "assemble", "passes", "fit", "write"]
UNITS = {"": 1, "B": 1, "K": 1 << 10, "M": 1 << 20, "G": 1 << 30, "KiB": 1 << 10, "MiB": 1 << 20, "GiB": 1 << 30}
MIB = 1 << 20


def bytes_of(text):
    """512M, 1.5G, or the command's own "203.8 MiB"."""
    match = re.fullmatch(r"([0-9.]+) ?([A-Za-z]*)", text)
    return int(float(match[1]) * UNITS[match[2]])


def add_mesh_options(parser, tets, grading=1):
    parser.add_argument("command", metavar="TETFUSION", type=pathlib.Path, help="the command")
    parser.add_argument("work", metavar="WORK_FOLDER", type=pathlib.Path,
                        help="for the mesh, the results and the scratch folder")
    parser.add_argument("--tets", default=tets, help=f"of the mesh, which is made unless it is there; default {tets}")
    parser.add_argument("--kind", default="five", choices=["five", "kuhn", "bcc"])
    parser.add_argument("--jitter", default="0.5")
    parser.add_argument("--grading", default=str(grading))
    parser.add_argument("--shuffle", action="store_true", help="points and tetrahedra of the mesh in pseudo-random order")
    parser.add_argument("--options", default="--method tetfuse",
                        help='options for simplify, as in --options="--reduction 90%% --regions none"; default: --method tetfuse')


def prepare(args):
    """The mesh that the options ask for: makes it if it is not there."""
    args.command = args.command.resolve()
    args.work.mkdir(parents=True, exist_ok=True)
    order = "_shuffled" if args.shuffle else ""
    mesh = args.work / f"{args.kind}_{args.tets}_j{args.jitter}_g{args.grading}{order}.vtu"
    if not mesh.exists():
        subprocess.run([args.command, "generate", args.kind, "--tets", args.tets, "--jitter", args.jitter, "--grading",
                        args.grading, *(["--shuffle"] if args.shuffle else []), "-o", mesh, "--quiet"], check=True)
    return mesh


def sha256(path):
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(1 << 24):
            digest.update(block)
    return digest.hexdigest()


def vm_hwm(pid):
    """The most memory that a process has had resident so far, as the kernel counts it; 0 when it has ended."""
    try:
        match = re.search(rb"VmHWM:\s*(\d+) kB", pathlib.Path(f"/proc/{pid}/status").read_bytes())
    except OSError:
        return 0
    return int(match[1]) * 1024 if match else 0


class Run:
    """A command from its start to its end. The program is not its own witness: time and memory are taken from outside, memory
    every ten milliseconds."""

    def __init__(self, command):
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as errors:
            start = time.perf_counter()
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=errors)
            self.peak = 0
            while True:
                self.peak = max(self.peak, vm_hwm(process.pid))
                pid, status, usage = os.wait4(process.pid, os.WNOHANG)
                if pid != 0:
                    break
                time.sleep(0.01)
            self.seconds = time.perf_counter() - start
            self.cpu = usage.ru_utime + usage.ru_stime
            self.status = process.returncode = os.waitstatus_to_exitcode(status)
            for file in (out, errors):
                file.seek(0)
            self.stdout, self.stderr = out.read(), errors.read().decode(errors="replace").strip()


def simplify(command, mesh, out, options):
    """A Run of simplify, with its report, and the digest of what it wrote; both None if it failed."""
    run = Run([command, "simplify", mesh, "-o", out, "--quiet", "--report", "-", *options])
    run.report = run.digest = None
    if run.status == 0:
        run.report = json.loads(run.stdout)
        run.peak = max(run.peak, run.report["peak_rss_bytes"])
        run.digest = sha256(out)
    return run


def drop_from_page_cache(path):
    with open(path, "rb") as file:
        os.fsync(file.fileno())
        os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)


def seconds_to_copy(source, result):
    """What no program that makes `result` of `source` can do without: reading one, writing and syncing the other."""
    block = bytearray(1 << 23)
    start = time.perf_counter()
    with open(source, "rb", buffering=0) as file:
        while file.readinto(block):
            pass
    seconds = time.perf_counter() - start
    left = result.stat().st_size
    copy = result.with_suffix(".copy")
    start = time.perf_counter()
    with open(copy, "wb", buffering=0) as file:
        while left > 0:
            left -= file.write(memoryview(block)[:min(left, len(block))])
        os.fsync(file.fileno())
    seconds += time.perf_counter() - start
    copy.unlink()
    return seconds


def figures(runs, copying):
    """A row of measures: medians of several runs of one kind, the largest of their peaks. `copying` holds seconds_to_copy()."""
    report = runs[0].report
    median = lambda f: statistics.median(f(r) for r in runs)
    millions = report["input"]["tets"] / 1e6
    seconds = median(lambda r: r.seconds)
    # The first round may be done while chunks are put together: the rounds' own seconds count it, the phase "passes" does not.
    rounds = median(lambda r: sum(lod["seconds"] for lod in r.report["lods"]))
    row = {"tets": report["input"]["tets"], "threads": report["threads"], "chunks": report["chunks"],
           "rounds": len(report["lods"]), "reduction %": round(100 * report["reduction"], 2), "wall s": round(seconds, 2),
           "cpu s": round(median(lambda r: r.cpu), 2), "VmHWM MiB": round(max(r.peak for r in runs) / MIB, 1),
           "scratch MiB": round(max(r.report["scratch_bytes"] for r in runs) / MIB), "Mtet/s": round(millions / seconds, 2),
           "rounds s": round(rounds, 2), "rounds Mtet/s": round(millions / max(rounds, 1e-9), 2),
           "copy s": round(statistics.median(copying), 2), "x copy": round(seconds / statistics.median(copying), 1)}
    row.update({f"{name} s": round(median(lambda r: r.report["seconds"].get(name, 0)), 2) for name in PHASES})
    return row


def print_table(rows, without=()):
    names = [name for name in rows[0] if name not in without]
    print("| " + " | ".join(names) + " |\n|" + " --- |" * len(names))
    for row in rows:
        print("| " + " | ".join(str(row[name]) for name in names) + " |")
    print(flush=True)


def write_csv(path, rows, append=False):
    begin = not (append and path.exists())
    with open(path, "w" if begin else "a", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        if begin:
            writer.writeheader()
        writer.writerows(rows)
