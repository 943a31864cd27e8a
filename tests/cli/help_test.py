#!/usr/bin/env python3
"""What --help and --version say. Usage: help_test.py TETFUSION"""
import re
import unittest

from harness import COMMANDS, HERE, finish, main, run


EVERYWHERE = ["--help", "--threads", "--progress", "--quiet", "--verbose"]
READING = ["--tetrahedralize", "--linearize", "--merge-points", "--drop-patches", "--drop-patch", "--time-step"]
OPTIONS = {
    "simplify": READING + ["--output", "--reduction", "--tets", "--scalar-tolerance", "--stretch-factor", "--aspect-ratio", "--max-volume",
                           "--roi", "--weight", "--method", "--max-error", "--max-rms", "--min-quality", "--conserve", "--boundary-rule",
                           "--boundary", "--feature-angle", "--array", "--regions", "--lods", "--series", "--encoding", "--pieces",
                           "--report", "--strict", "--memory", "--scratch", "--chunk-tets", "--resume", "--dry-run", "--verify",
                           "--original-ids", "--map", "--progressive"],
    "refine": ["--output", "--tets", "--reduction", "--max-error", "--max-rms", "--roi", "--encoding", "--report", "--memory", "--scratch"],
    "info": READING + ["--report", "--memory", "--scratch"],
    "check": READING + ["--report", "--strict", "--fix", "--encoding", "--memory", "--scratch"],
    "compare": READING + ["--report", "--max-error", "--max-rms", "--surface", "--interfaces", "--array", "--memory"],
    "apply": READING + ["--output", "--array", "--fit", "--scratch", "--encoding", "--report"],
    "convert": READING + ["--labels", "--encoding"],
    "generate": ["--tets", "--output", "--jitter", "--grading", "--shuffle", "--seed", "--time", "--double", "--encoding"]}


class Help(unittest.TestCase):
    def test_version(self):
        self.assertRegex(run("--version").decode(), r"^tetfusion \d+\.\d+\.\d+\n$")

    def test_the_command_lists_its_subcommands(self):
        for option in ("--help", "-h"):
            text = run(option).decode()
            for word in (*COMMANDS, "--version"):
                self.assertIn(word, text)

    def test_each_subcommand_lists_its_options(self):
        for command in COMMANDS:
            result = finish(command, "--help")
            self.assertEqual((result.returncode, result.stderr), (0, b""))
            listed = re.findall(r"^  (?:-\w,)?(--[\w-]+)", result.stdout.decode(), re.MULTILINE)
            self.assertEqual(sorted(listed), sorted(EVERYWHERE + OPTIONS[command]), command)

    def test_the_manual_has_the_options_of_simplify(self):
        manual = (HERE.parents[1] / "src/cli/MANUAL.md").read_text()
        chapter = manual.partition("## simplify\n")[2].partition("\n### Steps of a series")[0]
        told = re.findall(r"\*\*`(--[a-z][a-z-]*)", chapter)
        elsewhere = ["--help", "--output"]  # the latter by its short name
        self.assertEqual({*told, *elsewhere}, {*EVERYWHERE, *OPTIONS["simplify"]})

    def test_options_that_are_given_again_take_one_value_each(self):
        text = run("simplify", "--help").decode()
        self.assertIn("IN TEXT ... REQUIRED", text)
        self.assertRegex(text, r"--array TEXT +An array")

    def test_options_are_grouped(self):
        text = run("simplify", "--help").decode()
        found = [text.index(f"\n{group}:\n") for group in ("Output", "Goal", "Criteria", "Input", "Performance", "Messages")]
        self.assertEqual(found, sorted(found))

    def test_the_defaults_of_tetfuse_are_stated(self):
        text = run("simplify", "--help").decode()
        for default in ("tetfuse", "Default: 0.025 with --method tetfuse", "Default: 5 with --method tetfuse"):
            self.assertIn(default, text)
        self.assertRegex(text, r"--encoding TEXT:\{[a-z0-9,]*\}(=raw| \[raw\])")  # as this version of CLI11 has it


if __name__ == "__main__":
    main()
