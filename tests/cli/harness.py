"""What the tests of the command share: running it, and a folder for each test. The command is the first argument of
the test program."""
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "support")]

INVALID, USAGE, BAD, IO, MEMORY, INTERRUPTED = 1, 2, 3, 4, 5, 130
COMMANDS = ("simplify", "info", "check", "compare", "apply", "refine", "convert", "generate")
_command = None


def main():
    """For the end of a test program: TEST TETFUSION [unittest's arguments]."""
    global _command
    _command = os.path.abspath(sys.argv.pop(1))
    # What starts the tests may have had these ignored, as nohup and a shell's & do, and whoever is started inherits that.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    result = unittest.main(module="__main__", exit=False).result
    for test, reason in result.skipped:
        print(f"skipped: {test.id()}: {reason}")
    sys.exit(not result.wasSuccessful())


def command():
    return _command


def sanitized():
    """Is the command built with AddressSanitizer, which takes memory of its own?"""
    return b"__asan_init" in pathlib.Path(command()).read_bytes()


def run(*arguments, code=0, **keywords):
    """Runs the command and returns what it wrote to standard output; its standard error must say why where it fails."""
    result = finish(*arguments, **keywords)
    if result.returncode != code:
        raise AssertionError(f"{arguments}: exit code {result.returncode}, not {code}\n{result.stderr.decode()}")
    if code > INVALID and b"tetfusion: error: " not in result.stderr:
        raise AssertionError(f"{arguments}: no error message but {result.stderr}")
    return result.stdout


def finish(*arguments, **keywords):
    return subprocess.run([command(), *map(str, arguments)], capture_output=True, timeout=300, **keywords)


def report_of(command, *arguments, code=0, **keywords):
    return json.loads(run(command, *arguments, "--report", "-", code=code, **keywords))


def least_memory(*arguments):
    """The --memory that the command asks for, as in 73M: with it the mesh is on disk."""
    refused = finish(*arguments, "--memory", "1M")
    asked = re.search(rb"give --memory (\d+M) or more", refused.stderr)
    if (refused.returncode, refused.stdout) != (MEMORY, b"") or not asked:
        raise AssertionError(f"{arguments}: {refused}")
    return asked[1].decode()


def size_of(memory):
    return int(memory[:-1]) << 20


class FolderTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, mesh, name="mesh.vtu"):
        path = self.folder / name
        path.write_bytes(mesh if isinstance(mesh, bytes) else mesh.bytes())
        return path

    def generate(self, *options, kind="bcc", tets="20k", name="generated.vtu"):
        path = self.folder / name
        run("generate", kind, "--tets", tets, "-o", path, *options)
        return path

    def start(self, *arguments, until, times=1, **keywords):
        """Starts the command and comes back when its progress bar has shown that phase so many times."""
        process = subprocess.Popen([command(), *map(str, arguments), "--progress", "always"], stderr=subprocess.PIPE,
                                   stdout=subprocess.DEVNULL, **keywords)
        seen = b""
        while seen.count(until.encode()) < times:
            chunk = os.read(process.stderr.fileno(), 4096)
            if not chunk:
                raise AssertionError(f"ended before '{until}': {seen}")
            seen += chunk
        return process

    def end(self, process):
        message = process.stderr.read().decode()
        process.stderr.close()
        return process.wait(timeout=60), message

    def stop_when(self, pattern, *arguments, by=signal.SIGINT, code=INTERRUPTED, limit=60):
        """Starts the command, stops it as soon as the folder has a file of that name, and returns its message."""
        process = subprocess.Popen([command(), *map(str, arguments)], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
        self.addCleanup(process.kill)
        self.wait_for(pattern, process, limit)
        process.send_signal(by)
        message = process.communicate(timeout=limit)[1].decode()
        self.assertEqual(process.returncode, code, message)
        if code == INTERRUPTED:
            self.assertIn("interrupted", message)
        return message

    def wait_for(self, pattern, process, limit=60):
        """Until the folder has a file of that name, or the process has ended."""
        end = time.monotonic() + limit
        while process.poll() is None and not list(self.folder.glob(pattern)):
            self.assertLess(time.monotonic(), end, f"no {pattern}")
            time.sleep(0.001)

    def files(self):
        return sorted(p.name for p in self.folder.iterdir())
