#!/usr/bin/env python3
"""Ours beside VTK's vtkUnstructuredGridQuadricDecimation: processor time, memory, errors and shapes, in one interleaved run.

Usage: peers.py TETFUSION PEER_VTK WORK_FOLDER [--meshes ball1m,five1m,...] [--targets 50,80,90,95] [--match] ...  (--help)
Both on one thread, in fresh processes, in turn. Both results are measured by `tetfusion compare` and `tetfusion check`, so
neither program is its own witness. Prints a Markdown table for each mesh and writes peers.csv after each of them.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys

from measure import MIB, Run, print_table, write_csv

BALL = [sys.executable, pathlib.Path(__file__).with_name("ball.py"), "--tets"]
MADE = {"ball1m": [*BALL, "1M"], "ball1m_ordered": [*BALL, "1M", "--ordered"],
        "ball10m": [*BALL, "10.2M"], "ball10m_ordered": [*BALL, "10.2M", "--ordered"],
        "layers1m": [sys.executable, pathlib.Path(__file__).with_name("layers.py"), "--tets", "1M"],
        "five1m": ["TETFUSION", "generate", "five", "--tets", "1M", "--jitter", "0.3", "--quiet", "-o"]}
# VTK's least volume is not relative: as large beside the tetrahedra of the ten times finer ball as beside those of the other.
VTK_OPTIONS = {"ball10m": "--scale 2.16", "ball10m_ordered": "--scale 2.16"}
PROGRAMS = ["VTK", "ours"]  # VTK first: with --match ours aims at its count


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", metavar="TETFUSION", type=pathlib.Path, help="the command")
    parser.add_argument("peer", metavar="PEER_VTK", type=pathlib.Path, help="built of peer_vtk.cpp where there is VTK")
    parser.add_argument("work", metavar="WORK_FOLDER", type=pathlib.Path, help="for meshes, results and peers.csv")
    parser.add_argument("--data", type=pathlib.Path, default="../shared/data", help="folder of real meshes; default %(default)s")
    parser.add_argument("--meshes", default="ball1m,five1m,bluntfin,spx",
                        help="those that are made: " + ", ".join(MADE) + "; else the name of a .vtu in WORK_FOLDER or "
                        "--data, or a path; those that are not there are left out; default %(default)s")
    parser.add_argument("--targets", default="50,80,90,95", help="reductions in per cent; default %(default)s")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--match", action="store_true", help="ours aims at the number of tetrahedra that VTK has left")
    parser.add_argument("--only", choices=PROGRAMS, help="run one of them alone")
    parser.add_argument("--options", default="", help='more options for simplify, as in --options="--max-error 1%%"')
    parser.add_argument("--vtk-options", default="", help='more options for PEER_VTK, as in --vtk-options="--scale 0"; '
                        f"default for some meshes: {VTK_OPTIONS}")
    parser.add_argument("--judge", type=pathlib.Path, help="the command that compares and checks; default: TETFUSION")
    args = parser.parse_args()
    args.command, args.peer = args.command.resolve(), args.peer.resolve()
    args.judge = args.judge.resolve() if args.judge else args.command
    args.work.mkdir(parents=True, exist_ok=True)
    return args


def find_mesh(args, name):
    """Makes it if it is one of ours; None if there is no such file."""
    for path in (args.work / f"{name}.vtu", args.data / f"{name}.vtu", pathlib.Path(name)):
        if path.is_file():
            return path
    if name not in MADE:
        return None
    path = args.work / f"{name}.vtu"
    subprocess.run([args.command if word == "TETFUSION" else word for word in MADE[name]] + [path], check=True)
    return path


def asked(command, *words):
    """The JSON report of one of our subcommands. Exit code 1 is an answer, too: what was looked at is not in order."""
    run = Run([command, *words, "--quiet", "--report", "-"])
    if run.status not in (0, 1):
        sys.exit(f"{' '.join(map(str, words))}: exit code {run.status}: {run.stderr}")
    return json.loads(run.stdout)


def steering_array(info):
    """What both programs follow: the active scalars, else the first floating-point point array of one component."""
    arrays = [a for a in info["arrays"] if a["association"] == "point" and a["components"] == 1]
    floating = [a["name"] for a in arrays if a["type"].startswith("Float")]
    active = [a["name"] for a in arrays if any(role.lower() == "scalars" for role in a["active"])]
    return (active + floating)[0]


class Side:
    """One program on one mesh towards one goal: its runs, and its result."""

    def __init__(self, args, program, mesh, array, share):
        self.args, self.program, self.mesh, self.array, self.share = args, program, mesh, array, share
        self.out = args.work / f"peers_{program}.vtu"
        self.cpu, self.peak, self.tets, self.failure = [], 0, None, None

    def run(self, vtk_tets):
        """Once more; after a failure never again."""
        if self.failure:
            return
        self.out.unlink(missing_ok=True)
        run = Run(self.vtk_command() if self.program == "VTK" else self.our_command(vtk_tets))
        if run.status != 0:
            self.failure = f"exit code {run.status}: {run.stderr}"
            return
        report = json.loads(run.stdout)
        self.peak = max(self.peak, report["peak_rss_bytes"])
        self.tets = report["tets"] if self.program == "VTK" else report["output"]["tets"]
        self.cpu.append(report["cpu_seconds"] if self.program == "VTK" else our_seconds(report))

    def vtk_command(self):
        return [self.args.peer, self.mesh, self.out, "--array", self.array, "--reduction", str(self.share),
                *(self.args.vtk_options or VTK_OPTIONS.get(self.mesh.stem, "")).split()]

    def our_command(self, vtk_tets):
        goal = ["--tets", str(vtk_tets)] if self.args.match and vtk_tets else ["--reduction", str(self.share)]
        return [self.args.command, "simplify", self.mesh, "-o", self.out, *goal, "--array", self.array, "--regions", "none",
                "--threads", "1", "--quiet", "--report", "-", *self.args.options.split()]

    def row(self, name, tets):
        row = {"mesh": name, "tets": tets, "goal %": round(100 * self.share, 2), "program": self.program}
        if self.failure:
            print(f"{name}, {row['goal %']} %, {self.program}: {self.failure}", file=sys.stderr)
        row.update({"left": self.tets, "cpu s": None, "Mtet/cpu s": None, "VmHWM MiB": None, **errors(self), **shapes(self)})
        if not self.failure:
            cpu = statistics.median(self.cpu)
            row.update({"cpu s": round(cpu, 3), "Mtet/cpu s": round(tets / 1e6 / cpu, 3), "VmHWM MiB": round(self.peak / MIB, 1)})
        return row


def our_seconds(report):
    """Everything but reading and writing. The phases are wall time: where others held the processor up they are more than
    was used, but never more than all phases together used."""
    phases = report["seconds"]
    return min(report["cpu_seconds"], phases["total"] - phases.get("read", 0) - phases.get("write", 0))


def errors(side):
    """Of the field at the original points, in per cent of its range, and of the surface, in per cent of the diagonal."""
    row = dict.fromkeys(["rms %", "max %", "surface %", "outside"])
    if not side.failure and side.args.can_compare:
        report = asked(side.args.judge, "compare", side.mesh, side.out)
        field = next(a for a in report["arrays"] if a["association"] == "point" and a["name"] == side.array)
        row.update({"rms %": f"{100 * field['rms']:.3g}", "max %": f"{100 * field['max']:.3g}",
                    "surface %": f"{100 * report['surface']['max']:.2g}", "outside": report["outside_points"]})
    return row


def shapes(side):
    row = dict.fromkeys(["inverted", "degenerate", "worst angle", "1 % angle"])
    if not side.failure:
        report = asked(side.args.judge, "check", side.out)
        row.update({"inverted": report["inverted"], "degenerate": report["degenerate"],
                    "worst angle": f"{report['dihedral_deg']['min']:.3g}", "1 % angle": f"{report['dihedral_deg']['p1']:.3g}"})
    return row


def measure(args, mesh, array, share):
    sides = [Side(args, program, mesh, array, share) for program in PROGRAMS if args.only in (None, program)]
    for _ in range(args.repeat):
        vtk_tets = None
        for side in sides:
            side.run(vtk_tets)
            vtk_tets = side.tets
    return sides


def main():
    args = arguments()
    args.can_compare = b"  compare" in Run([args.judge, "--help"]).stdout
    if not args.can_compare:
        print("this tetfusion has no compare: errors are left out", file=sys.stderr)
    rows, failed = [], False
    for name in args.meshes.split(","):
        mesh = find_mesh(args, name)
        if mesh is None:
            print(f"{name}: not there, left out", file=sys.stderr)
            continue
        info = asked(args.command, "info", mesh)
        array = steering_array(info)
        mine = []
        for target in args.targets.split(","):
            sides = measure(args, mesh, array, float(target) / 100)
            mine += [side.row(mesh.stem, info["tets"]) for side in sides]
            failed |= any(side.failure for side in sides)
        print(f"{mesh.stem}, {info['tets']:,} tetrahedra, {info['points']:,} points, `{array}`; medians of {args.repeat}\n")
        print_table([{key: "-" if value is None else value for key, value in row.items()} for row in mine],
                    without=["mesh", "tets"])
        rows += mine
        write_csv(args.work / "peers.csv", rows)
    return 1 if failed or not rows else 0


if __name__ == "__main__":
    sys.exit(main())
