#!/usr/bin/env python3
"""simplify --verify, from outside. Usage: verify_test.py TETFUSION"""
from harness import MEMORY, USAGE, FolderTest, finish, least_memory, main, report_of, run, sanitized, size_of


class Verify(FolderTest):
    def names(self, report, output=0):
        return [check["name"] for check in report["verified"][output]["checks"]]

    def test_the_report_says_what_was_verified(self):
        path = self.generate("--jitter", "0.5")
        out = self.folder / "out.vtu"
        plain = report_of("simplify", path, "-o", out, "--max-error", "2%", "--quiet")
        self.assertEqual(plain["verified"], [])
        result = out.read_bytes()
        report = report_of("simplify", path, "-o", out, "--max-error", "2%", "--verify", "--quiet")
        self.assertEqual(out.read_bytes(), result)
        self.assertEqual([v["path"] for v in report["verified"]], [str(out)])
        for name in ("inverted", "duplicate_tets", "nonconforming_faces", "boundary", "interfaces", "missing arrays"):
            self.assertIn(name, self.names(report))
        error = [c for c in report["verified"][0]["checks"] if c["name"] == "error:" + report["steering"][0]]
        self.assertEqual(error[0]["allowed"], 0.02)
        self.assertGreater(error[0]["found"], 0.01)
        self.assertLessEqual(error[0]["found"], 0.02)
        self.assertIn("verify", report["seconds"])

    def test_however_it_is_written(self):
        path = self.generate("--jitter", "0.5")
        options = ["--reduction", "70%", "--chunk-tets", "4k", "--verify", "--quiet"]
        out = self.folder / "out.vtu"
        run("simplify", path, "-o", out, *options)
        # Through pipes, and out of core.
        self.assertEqual(run("simplify", "-", "-o", "-", *options, input=path.read_bytes()), out.read_bytes())
        again = self.folder / "again.vtu"
        report = report_of("simplify", path, "-o", again, "--memory", "120M", "--threads", "1", *options)
        self.assertEqual(again.read_bytes(), out.read_bytes())
        if not sanitized():
            self.assertLess(report["peak_rss_bytes"], 120 << 20)
        for encoding in ("inline", "ascii", "lz4"):
            run("simplify", path, "-o", again, "--encoding", encoding, *options)
        report = report_of("simplify", path, "-o", self.folder / "lod_{lod}.pvtu", "--lods", "30%,60%", "--pieces", "3",
                           "--verify", "--quiet")
        self.assertEqual(len(report["verified"]), 2)
        self.assertIn("nonconforming_faces", self.names(report, 1))
        # The other formats cannot hold all that was verified.
        said = finish("simplify", path, "-o", self.folder / "out.mesh", *options[:-1])
        self.assertIn("not verified: what its format has no place for", said.stderr.decode())
        # In place of its input.
        copy = self.folder / "copy.vtu"
        copy.write_bytes(path.read_bytes())
        run("simplify", copy, "-o", copy, *options)
        self.assertEqual(copy.read_bytes(), out.read_bytes())

    def test_what_cannot_be_verified_is_refused_at_the_start(self):
        path = self.generate(tets="100k")
        out = self.folder / "out.pvtu"
        run("simplify", path, "-o", out, "--reduction", "50%", "--verify", "--pieces", "512", code=USAGE)
        self.assertEqual(self.files(), ["generated.vtu"])
        small = ["--reduction", "50%", "--memory", "72M", "--threads", "1", "--chunk-tets", "4k", "--quiet"]
        run("simplify", path, "-o", out, "--verify", *small, code=MEMORY)
        self.assertEqual(self.files(), ["generated.vtu"])
        run("simplify", path, "-o", out, *small)

    def test_less_memory_takes_more_passes(self):
        path = self.generate("--jitter", "0.3", tets="1M", kind="five")
        options = ["simplify", path, "-o", self.folder / "out.vtu", "--tets", "800k", "--regions", "none", "--verify", "--threads", "1",
                   "--chunk-tets", "50k", "--quiet"]
        least = least_memory(*options)
        # All sides of the result's triangles at once would take 98 MiB alone.
        self.assertLess(size_of(least), 240 << 20)
        report = report_of(*options, "--memory", least)
        self.assertIn("boundary", self.names(report))
        if not sanitized():
            self.assertLess(report["peak_rss_bytes"], size_of(least))

    def test_it_says_so(self):
        path = self.generate()
        result = finish("simplify", path, "-o", self.folder / "out.vtu", "--reduction", "50%", "--verify",
                        "--max-rms", "5%", "--verbose")
        self.assertRegex(result.stderr.decode(), r"out.vtu: verified, \d+ checks hold")
        self.assertIn("not verified: the mean error of fusions: --max-rms is for an estimate of it\n", result.stderr.decode())


if __name__ == "__main__":
    main()
