"""What the tests of the plugin share: an installation of it that was moved, and runs of pvbatch.

Arguments of each test: TETFUSION PVBATCH MPIEXEC CMAKE BUILD PLUGIN_FOLDER DATA_FOLDER [unittest's arguments], where PLUGIN_FOLDER is the
plugin's below the prefix. Without the data folder the tests of real meshes are skipped.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import textwrap
import unittest

COMMAND, PVBATCH, MPIEXEC, CMAKE, BUILD, FOLDER = (sys.argv.pop(1) for _ in range(6))
DATA = pathlib.Path(sys.argv.pop(1))


def command(*arguments, code=0):
    run = subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True, timeout=300)
    assert run.returncode == code, f"{arguments}: exit code {run.returncode}\n{run.stderr}"
    return run.stdout


class ParaViewCase(unittest.TestCase):
    TETS = "30k"

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="tetfusion-paraview-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        subprocess.run([CMAKE, "--install", BUILD, "--component", "paraview", "--prefix", cls.folder / "first"], check=True,
                       capture_output=True)
        (cls.folder / "first").rename(cls.folder / "moved")
        cls.plugin = cls.folder / "moved" / FOLDER
        command("generate", "five", "--tets", cls.TETS, "--jitter", "0.3", "--quiet", "-o", cls.folder / "raw.vtu")
        cls.mesh = cls.folder / "in.vtu"
        command("convert", cls.folder / "raw.vtu", cls.mesh, "--encoding", "inline", "--quiet")

    def run_pvbatch(self, arguments, processes=1, symmetric=False, load=True):
        """pvbatch with the plugin loaded by its path variable; nothing waits for ever where processes do not end together."""
        environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                           OMPI_MCA_rmaps_base_oversubscribe="1",
                           PRTE_MCA_rmaps_default_mapping_policy=":oversubscribe")  # Open MPI 5
        if load:
            environment["PV_PLUGIN_PATH"] = str(self.plugin)
        start = [MPIEXEC, "-n", str(processes)] if processes > 1 else []
        return subprocess.run([*start, PVBATCH, *(["--sym"] if symmetric else []), *map(str, arguments)], env=environment, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=self.folder, timeout=300)

    def run_script(self, text, load=True, code=0):
        script = self.folder / "script.py"
        script.write_text("from paraview.simple import *\n" + textwrap.dedent(text))
        run = self.run_pvbatch([script], load=load)
        self.assertEqual(run.returncode, code, run.stdout)
        return run.stdout
