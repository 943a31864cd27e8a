#!/usr/bin/env python3
"""Standard input, output and error, and pipes. Usage: streams_test.py TETFUSION"""
import json
import os
import subprocess

from harness import BAD, IO, FolderTest, command, finish, main, report_of, run
from sample_meshes import mesh_of_all_sorts


class Streams(FolderTest):
    def test_standard_input_and_output(self):
        mesh = mesh_of_all_sorts().bytes()
        path = self.write(mesh)
        out = self.folder / "out.vtu"
        self.assertEqual(report_of("info", "-", input=mesh)["tets"], 162)
        self.assertEqual(report_of("check", "-", input=mesh)["tets"], 162)
        run("convert", path, out)
        self.assertEqual(run("convert", "-", "-", input=mesh), out.read_bytes())
        run("simplify", path, "-o", out, "--method", "tetfuse", "--scalar-tolerance", "off")
        piped = run("simplify", "-", "-o", "-", "--method", "tetfuse", "--scalar-tolerance", "off", input=mesh)
        self.assertEqual(piped, out.read_bytes())
        self.generate()
        self.assertEqual(run("generate", "bcc", "--tets", "20k", "-o", "-"), (self.folder / "generated.vtu").read_bytes())

    def test_standard_input_is_copied_to_the_disk_of_the_scratch_folder(self):
        mesh, out = mesh_of_all_sorts().bytes(), self.folder / "out.vtu"
        nowhere = {**os.environ, "TMPDIR": str(self.folder / "missing")}
        run("simplify", "-", "-o", out, input=mesh, env=nowhere)
        expected = out.read_bytes()
        for scratch in (self.folder, self.folder / "new"):
            self.assertEqual(run("simplify", "-", "-o", "-", "--scratch", scratch, input=mesh, env=nowhere), expected)
        self.assertEqual(self.files(), ["out.vtu"])
        plan = ["simplify", "-", "-o", out, "--reduction", "50%", "--dry-run"]
        self.assertRegex(run(*plan, input=mesh).decode(), r"scratch +[\d.]+ KiB for a copy of the input")
        self.assertEqual(report_of(*plan, input=mesh)["scratch_bytes"], len(mesh))
        for arguments in (["simplify", "-", "-o", "-"], ["simplify", "-", "-o", "/dev/null"], ["info", "-"]):
            self.assertIn(b"TMPDIR", finish(*arguments, input=mesh, env=nowhere).stderr)
        self.assertIn(b"for standard output in %s (TMPDIR) failed" % nowhere["TMPDIR"].encode(),
                      finish("simplify", out, "-o", "-", "--verify", env=nowhere).stderr)

    def test_a_pipe_of_three(self):
        line = ('"$0" generate bcc --tets 20k -o - | "$0" simplify - -o - --reduction 30% --quiet | '
                '"$0" info - --report -')
        piped = subprocess.run(["bash", "-o", "pipefail", "-c", line, command()], capture_output=True, timeout=120)
        self.assertEqual((piped.returncode, piped.stderr), (0, b""))
        report = json.loads(piped.stdout)
        self.assertTrue(0.69 * 20160 < report["tets"] < 0.72 * 20160)
        self.assertIn("velocity", [a["name"] for a in report["arrays"]])

    def test_a_reader_that_goes_away(self):
        path = self.generate(tets="500k")
        writer = subprocess.Popen([command(), "convert", path, "-"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        writer.stdout.read(10)
        writer.stdout.close()
        message = writer.stderr.read()
        writer.stderr.close()
        self.assertEqual(writer.wait(timeout=60), IO)
        self.assertIn(b"reader has gone", message)

    def test_standard_input_that_is_no_mesh(self):
        for data in (b"", b"nothing", b"# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n"):
            self.assertEqual(run("info", "-", input=data, code=BAD), b"")

    def test_quiet_prints_nothing(self):
        path, out = self.write(mesh_of_all_sorts()), self.folder / "out.vtu"
        for arguments in (["simplify", path, "-o", out], ["info", path], ["check", path], ["convert", path, out],
                          ["generate", "five", "--tets", "1k", "-o", out]):
            for options in [], ["--progress", "always"]:
                result = finish(*arguments, "--quiet", *options)
                self.assertEqual((result.returncode, result.stdout, result.stderr), (0, b"", b""), arguments)
        result = finish("info", self.folder / "missing.vtu", "--quiet")
        self.assertEqual((result.returncode, result.stdout), (IO, b""))
        self.assertIn(b"missing.vtu", result.stderr)


if __name__ == "__main__":
    main()
