"""The processes, and what they tell one another."""
import json
import os


def tell(stream, text):
    """At once: in a source's script Python's own streams end in a buffer that os._exit() forgets."""
    os.write(stream, (text + "\n").encode())


class Ranks:
    """What the processes tell one another. Every method must be called on all of them."""

    def __init__(self):
        from paraview.modules.vtkRemotingCore import vtkProcessModule
        self.controller = vtkProcessModule.GetProcessModule().GetGlobalController()
        self.rank = self.controller.GetLocalProcessId() if self.controller else 0
        self.count = self.controller.GetNumberOfProcesses() if self.controller else 1

    def gather(self, values):
        """The numbers of all ranks, as many of each, a row a rank."""
        import numpy as np
        from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
        own = np.ascontiguousarray(values, dtype=np.float64).ravel()
        if self.count == 1:
            return own.reshape(1, -1)
        out = numpy_to_vtk(np.zeros(own.size * self.count), deep=1)
        self.controller.AllGather(numpy_to_vtk(own, deep=1), out)
        return vtk_to_numpy(out).reshape(self.count, -1).copy()

    def agree(self, words):
        """The list of strings of the first rank that has any."""
        text = json.dumps(words).encode() if words else b""
        length = int(self.gather(len(text)).max())
        said = (bytes(row.astype(int).tolist()).strip() for row in self.gather(list(text.ljust(length + 1))))
        return next((json.loads(one) for one in said if one), [])

    def wait(self):
        if self.count > 1:
            self.controller.Barrier()

    def say(self, text):
        if self.rank == 0:
            tell(1, text)

    def end(self, code, message, of_all):
        """Ends this process; mpirun then ends the others."""
        if not of_all or self.rank == 0:
            where = f" on rank {self.rank}" if self.count > 1 and not of_all else ""
            tell(2, f"distributed.py: error{where}: {message}")
        if of_all:
            self.wait()
        os._exit(code)

    def threads(self):
        beside = int(os.environ.get("OMPI_COMM_WORLD_LOCAL_SIZE", self.count))
        return max(1, len(os.sched_getaffinity(0)) // beside if beside == 1 else (os.cpu_count() or 1) // beside)
