#!/usr/bin/env python3
"""Interruption, and disks too small. Usage: trouble_test.py TETFUSION"""
import itertools
import resource
import signal
import subprocess
import time

from harness import INTERRUPTED, IO, FolderTest, command, finish, main, run
from tiny_vtu import TinyVtu


class Trouble(FolderTest):
    TETS = "1M"

    def test_ctrl_c(self):
        """SIGTERM and SIGHUP are the same; each has its turn."""
        mesh, out = self.generate("--shuffle", tets=self.TETS), self.folder / "out.vtu"
        jobs = [(["simplify", mesh, "-o", out, "--encoding", "ascii", "--reduction", "10%"], phase)
                for phase in ("reading", "assembling", "fusing", "writing")]
        jobs += [(["convert", mesh, out, "--encoding", "ascii"], phase) for phase in ("reading", "writing")]
        jobs += [(["check", mesh], "reading"), (["info", mesh], "reading"),
                 (["generate", "five", "--tets", "20M", "-o", out], "writing")]
        for (arguments, phase), by in zip(jobs, itertools.cycle((signal.SIGINT, signal.SIGTERM, signal.SIGHUP))):
            with self.subTest(command=arguments[0], phase=phase, by=by):
                process = self.start(*arguments, until=phase)
                process.send_signal(by)
                code, message = self.end(process)
                self.assertEqual(code, INTERRUPTED, message)
                self.assertIn("interrupted", message)
                self.assertEqual(self.files(), ["generated.vtu"], "something was left behind")

    def test_a_hangup_that_is_ignored_ends_nothing(self):
        """As under nohup."""
        mesh, out = self.generate(tets="200k"), self.folder / "out.vtu"
        process = self.start("simplify", mesh, "-o", out, "--reduction", "10%", until="reading",
                             preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        process.send_signal(signal.SIGHUP)
        code, message = self.end(process)
        self.assertEqual(code, 0, message)
        self.assertTrue(out.exists())

    def test_a_second_ctrl_c_ends_at_once(self):
        mesh, out = self.generate("--shuffle", tets=self.TETS), self.folder / "out.vtu"
        process = self.start("simplify", mesh, "-o", out, until="reading")
        process.send_signal(signal.SIGINT)
        time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        code, _ = self.end(process)
        self.assertIn(code, (-signal.SIGINT, INTERRUPTED))
        self.assertFalse(out.exists())

    def test_kill_leaves_the_old_output(self):
        mesh, out = self.generate(tets=self.TETS), self.write(b"precious", "out.vtu")
        for phase in ("fusing", "writing"):
            process = self.start("simplify", mesh, "-o", out, "--encoding", "ascii", "--reduction", "50%", until=phase)
            process.kill()
            code, _ = self.end(process)
            self.assertEqual(code, -signal.SIGKILL)
            self.assertEqual(out.read_bytes(), b"precious")
        # What the killed run left does not hinder the next one.
        run("simplify", mesh, "-o", out, "--reduction", "50%", "--quiet")
        run("check", out, "--quiet")

    def limited(self, *arguments, limit, code=IO):
        set_limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        result = finish(*arguments, preexec_fn=set_limit)
        self.assertEqual(result.returncode, code, result.stderr)
        return result.stderr.decode()

    def test_a_disk_too_small(self):
        mesh, out = self.generate(tets="300k"), self.write(b"precious", "out.vtu")
        size = mesh.stat().st_size
        for limit in (0, 1000, size // 10):
            for arguments in (["simplify", mesh, "-o", out], ["convert", mesh, out],
                              ["convert", mesh, out, "--encoding", "zlib"],
                              ["generate", "five", "--tets", "300k", "-o", out],
                              ["check", mesh, "--report", out] if limit == 0 else ["convert", mesh, out]):
                with self.subTest(command=arguments[0], limit=limit):
                    message = self.limited(*arguments, limit=limit)
                    self.assertRegex(message, r"out\.vtu.*(too large|space)")
                    self.assertEqual(out.read_bytes(), b"precious")
                    self.assertEqual(self.files(), ["generated.vtu", "out.vtu"])

    def test_work_that_is_damaged_is_not_recommended(self):
        """Damaged while the run stands still, which has read none of it: a run that is resumed may find an older state."""
        mesh, scratch = self.generate("--jitter", "0.5", tets="400k"), self.folder / "s"
        process = subprocess.Popen([command(), "simplify", mesh, "-o", self.folder / "out.vtu", "--progressive",
                                    self.folder / "run.tfp", "--reduction", "80%", "--chunk-tets", "20k", "--memory", "110M",
                                    "--threads", "1", "--scratch", scratch], stderr=subprocess.PIPE)
        self.addCleanup(process.kill)
        self.wait_for("s/log-2.0.pieces", process)
        process.send_signal(signal.SIGSTOP)
        logs = list(scratch.glob("log-1.*.pieces"))
        self.assertGreater(len(logs), 10)
        for log in logs:
            damaged = bytearray(log.read_bytes())
            damaged[-100] ^= 1
            log.write_bytes(damaged)
        process.send_signal(signal.SIGCONT)
        message = process.communicate(timeout=60)[1]
        self.assertEqual(process.returncode, IO, message)
        self.assertRegex(message, rb"log-.*start the run again")
        self.assertNotIn(b"the work so far is kept", message)

    def test_nothing_to_go_on_with_is_said(self):
        result = finish("simplify", self.write(TinyVtu()), "-o", self.folder / "out.vtu", "--reduction", "10%", "--resume")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(b"nothing to go on with (--resume)", result.stderr)

    def test_a_full_device(self):
        mesh = self.write(TinyVtu())
        for arguments in (["simplify", mesh, "-o", "/dev/full"], ["convert", mesh, "/dev/full"],
                          ["generate", "five", "--tets", "1k", "-o", "/dev/full"], ["info", mesh, "--report", "/dev/full"]):
            self.assertIn(b"no space left", finish(*arguments).stderr)
            run(*arguments, code=IO)
        old = self.folder / "old.vtu"
        for option in ("--map", "--progressive"):
            old.write_bytes(b"what was there")
            run("simplify", mesh, "-o", old, option, "/dev/full", "--reduction", "10%", code=IO)
            self.assertEqual(old.read_bytes(), b"what was there", option)
        with open("/dev/full", "wb") as full:
            self.assertEqual(subprocess.run([command(), "--help"], stdout=full, stderr=subprocess.DEVNULL).returncode, IO)


if __name__ == "__main__":
    main()
