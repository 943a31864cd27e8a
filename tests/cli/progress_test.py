#!/usr/bin/env python3
"""Progress on standard error: a bar on a terminal, lines elsewhere. Usage: progress_test.py TETFUSION"""
import fcntl
import os
import pty
import re
import shutil
import signal
import struct
import subprocess
import termios
import time

from harness import INTERRUPTED, USAGE, FolderTest, command, finish, main, run

LINE = re.compile(r" *(\d+) % ([a-z ]+?)(  [\d.]+ M tets/s)?(  [\d:]+ left)?$")
ERASE = "\r\x1b[K"


class Lines(FolderTest):
    """Without a terminal."""

    def lines(self, *arguments):
        """(percent, phase) of each line of progress."""
        text = finish(*arguments, "--progress", "always").stderr.decode()
        self.assertNotIn("\r", text)
        self.assertNotIn("\x1b", text)
        matches = [LINE.match(line) for line in text.splitlines()]
        return [(int(m.group(1)), m.group(2)) for m in matches if m]

    def test_every_command_has_them_when_asked(self):
        path, out = self.generate(), self.folder / "out.vtu"
        for arguments in (["simplify", path, "-o", out], ["info", path], ["check", path], ["convert", path, out],
                          ["compare", path, path], ["check", path, "--fix", out], ["generate", "five", "--tets", "1k", "-o", out]):
            self.assertEqual(self.lines(*arguments)[-1], (100, "done"), arguments)
            for choice in ("never", "auto"):
                result = finish(*arguments, "--progress", choice)
                self.assertEqual(result.returncode, 0)
                self.assertIsNone(re.search(rb"\d %( |$)", re.sub(rb".*less.*", b"", result.stderr)), choice)
        run("info", path, "--progress", "often", code=USAGE)

    def test_percentages_never_fall(self):
        path = self.generate(tets="300k")
        for options in (["-o", self.folder / "a.vtu"], ["-o", self.folder / "b_{lod}.vtu", "--lods", "10%,20%,30%,40%"]):
            lines = self.lines("simplify", path, *options, "--chunk-tets", "20k")
            percentages = [percent for percent, _ in lines]
            self.assertEqual(percentages, sorted(percentages))
            self.assertEqual(percentages[-1], 100)
            self.assertEqual(len({p // 10 for p in percentages} & {0, 10}), 2, "from the beginning to the end")

    def test_looking_at_the_result_has_its_part(self):
        path = self.generate(tets="100k")
        lines = self.lines("simplify", path, "-o", self.folder / "a.vtu", "--verify", "--map", self.folder / "a.map")
        percentages = [percent for percent, _ in lines]
        self.assertEqual(percentages, sorted(percentages))
        for phase in "mapping", "verifying":
            self.assertLess(min(percent for percent, its in lines if its == phase), 100, phase)

    def test_levels_share_one_scale(self):
        path = self.generate(tets="300k")
        lines = self.lines("simplify", path, "-o", self.folder / "{lod}.vtu", "--lods", "10%,20%,30%,40%")
        first_written = min(percent for percent, phase in lines if phase == "writing")
        self.assertLess(first_written, 75, "the first of four levels is written, and the run nearly over?")

    def test_a_series_is_done_when_all_of_it_is(self):
        """The simplification is but a part of it; and where hardly a tetrahedron goes in a second no rate is shown."""
        first = self.generate(tets="1k", name="step_000.vtu")
        for step in range(1, 150):
            shutil.copy(first, self.folder / f"step_{step:03}.vtu")
        for kind in "shared", "each":
            said = finish("simplify", *sorted(self.folder.glob("step_*.vtu")), "-o", self.folder / "out_{step}.vtu", "--series", kind,
                          "--reduction", "50%", "--progress", "always").stderr.decode()
            self.assertNotIn("0.00 M", said)
            done = [line for line in said.splitlines() if re.match(r" *\d+ % done", line)]
            self.assertEqual([line for line in done if not line.startswith("100")], [])

    def test_lines_are_few(self):
        path = self.generate(tets="300k")
        lines = self.lines("simplify", path, "-o", self.folder / "a.vtu", "--chunk-tets", "5k")
        self.assertLess(len(lines), 25, "a line for each tenth, and for each new phase")


class Terminal(FolderTest):
    def watch(self, *arguments, columns=80, interrupt_at=None, terminal="xterm"):
        """Exit code, what the terminal got, seconds."""
        try:
            ours, theirs = pty.openpty()
        except OSError as error:
            self.skipTest(f"this machine has no pseudo-terminals: {error}")
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        start = time.monotonic()
        process = subprocess.Popen([command(), *map(str, arguments)], stdout=subprocess.PIPE, stderr=theirs,
                                   env={**os.environ, "TERM": terminal})
        os.close(theirs)
        seen = b""
        try:
            while chunk := os.read(ours, 4096):
                seen += chunk
                if interrupt_at and interrupt_at in seen:
                    process.send_signal(signal.SIGINT)
                    interrupt_at = None
        except OSError:  # how a terminal ends
            pass
        os.close(ours)
        self.assertNotIn(b"\x1b", process.stdout.read())
        process.stdout.close()
        return process.wait(timeout=60), seen.decode(), time.monotonic() - start

    def test_a_bar_unless_it_is_not_wanted(self):
        path = self.generate()
        for options, expected in (([], True), (["--progress", "always"], True), (["--progress", "never"], False),
                                  (["--quiet"], False), (["--progress", "always", "--quiet"], False)):
            code, seen, _ = self.watch("check", path, *options)
            self.assertEqual(code, 0)
            self.assertEqual(ERASE in seen, expected, options)

    def test_no_bar_where_it_cannot_be_erased(self):
        path = self.generate()
        self.assertNotIn("\x1b", self.watch("check", path, terminal="dumb")[1])
        seen = self.watch("check", path, "--progress", "always", terminal="dumb")[1]
        self.assertIn("100 % done", seen)
        self.assertNotIn("\x1b", seen)

    def test_nothing_is_left_behind(self):
        path = self.generate(tets="100k")
        for arguments, expected in ((["simplify", path, "-o", self.folder / "a.vtu"], 0),
                                    (["check", path], 0),
                                    (["simplify", path, "-o", self.folder / "a.vtu", "--array", "none"], USAGE)):
            code, seen, _ = self.watch(*arguments)
            self.assertEqual(code, expected)
            # Every bar is erased before anything else is written, and nothing follows the last erasing but text.
            for drawn in seen.split(ERASE)[1:-1]:
                self.assertRegex(drawn, r"^(.*\r\n)*(\[[= ]*\] +\d+ % [^\r\n]*)?$")
            self.assertNotIn("%  ", seen.split(ERASE)[-1])
            self.assertTrue(seen.endswith("\n") or seen.endswith(ERASE))

    def test_no_more_than_ten_updates_a_second_and_one_line(self):
        path = self.generate("--shuffle", tets="600k")
        for columns in (30, 80, 200):
            code, seen, seconds = self.watch("simplify", path, "-o", self.folder / "a.vtu", columns=columns)
            self.assertEqual(code, 0)
            bars = [drawn for drawn in seen.split(ERASE) if drawn and "\n" not in drawn]
            self.assertLessEqual(len(bars), 10 * seconds + 2)
            self.assertGreater(len(bars), 2)
            self.assertLess(max(map(len, bars)), columns, "the line wraps")
            percentages = [int(re.search(r"(\d+) %", bar).group(1)) for bar in bars]
            self.assertEqual(percentages, sorted(percentages))

    def test_ctrl_c_is_answered(self):
        path = self.generate("--shuffle", tets="3M")
        code, seen, _ = self.watch("simplify", path, "-o", self.folder / "a.vtu", interrupt_at=b"assembling")
        self.assertEqual(code, INTERRUPTED)
        self.assertRegex(seen, re.escape(ERASE) + r"tetfusion: error: [^\r\n]*interrupted[^\r\n]*\r\n$")


if __name__ == "__main__":
    main()
