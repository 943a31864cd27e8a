"""libtetfusion.so by its C interface (tetfusion_c.h)."""
import _thread
import atexit
import ctypes
import os
import pathlib
import queue
import sysconfig
import threading

import numpy as np

# In the order of the header.
TYPES = [np.dtype(name) for name in ("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64")]


class Values(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int32), ("data", ctypes.c_void_p), ("size", ctypes.c_uint64)]


class Array(ctypes.Structure):
    _fields_ = [("name", ctypes.c_char_p), ("components", ctypes.c_uint32), ("values", Values)]


class Mesh(ctypes.Structure):
    _fields_ = [("points", Values), ("connectivity", Values), ("offsets", Values), ("types", Values), ("ghosts", Values),
                ("point_arrays", ctypes.POINTER(Array)), ("point_array_count", ctypes.c_uint64),
                ("cell_arrays", ctypes.POINTER(Array)), ("cell_array_count", ctypes.c_uint64),
                ("active_scalars", ctypes.c_char_p)]


_PROGRESS = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_double, ctypes.c_char_p)
_CANCELLED = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p)
_NOTICE = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p)


class Observer(ctypes.Structure):
    _fields_ = [("data", ctypes.c_void_p), ("progress", _PROGRESS), ("cancelled", _CANCELLED), ("notice", _NOTICE)]


class _Runs:
    """Those that go on. Python may not end while the library calls it, so the runs of daemon threads end first."""

    def __init__(self):
        self.ending = False
        self._count = 0
        self._change = threading.Condition()

    def begin(self):
        with self._change:
            self._count += 0 if self.ending else 1
            return not self.ending

    def done(self):
        with self._change:
            self._count -= 1
            self._change.notify_all()

    def end(self):
        with self._change:
            self.ending = True
            self._change.wait_for(lambda: self._count == 0)


_runs = _Runs()
atexit.register(_runs.end)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=lambda: _runs.__init__())  # threads stay behind


def _load():
    name = "libtetfusion.so.0.1"  # another minor version is another interface
    given = os.environ.get("TETFUSION_LIBRARY")
    for place in [given] if given else [*_beside(name), name]:
        try:
            return ctypes.CDLL(str(place))
        except OSError as error:
            failure = error
    raise ImportError(f"{failure}; TETFUSION_LIBRARY may say where {name} lies") from failure


def _beside(name):
    """Of an installation, PREFIX/lib/python3/dist-packages/tetfusion, or the same below a build; nowhere else."""
    here = pathlib.Path(__file__).resolve().parent.parts
    if here[-4:] != ("lib", "python3", "dist-packages", "tetfusion"):
        return []
    lib = pathlib.Path(*here[:-3])
    places = [lib / name, lib / (sysconfig.get_config_var("MULTIARCH") or "") / name, lib.parent / name]
    return [place for place in places if place.exists()]


_library = _load()
_library.tetfusion_simplify.restype = ctypes.c_void_p
_library.tetfusion_simplify.argtypes = [ctypes.POINTER(Mesh), ctypes.c_char_p, ctypes.POINTER(Observer)]
_library.tetfusion_code.restype = ctypes.c_int32
_library.tetfusion_mesh_of.restype = ctypes.POINTER(Mesh)
for _function in ("code", "message", "report", "mesh_of", "free"):
    getattr(_library, "tetfusion_" + _function).argtypes = [ctypes.c_void_p]
for _function in ("message", "report", "version"):
    getattr(_library, "tetfusion_" + _function).restype = ctypes.c_char_p
_library.tetfusion_free.restype = None


INTERRUPTED = 130  # a code of the library's


class Result:
    """Frees what the library has made when nobody refers to it any more."""

    def __init__(self, address):
        self._address = address
        self.code = _library.tetfusion_code(address)
        self.message = readable(_library.tetfusion_message(address))
        self.report = readable(_library.tetfusion_report(address))
        self.mesh = _library.tetfusion_mesh_of(address).contents

    def __del__(self, free=_library.tetfusion_free):
        free(self._address)

    def numbers(self, values):
        """The library's memory as an array, which keeps it alive."""
        return np.asarray(_Memory(self, values)) if values.size else np.zeros(0, TYPES[values.type])


class _Memory:
    def __init__(self, owner, values):
        self._owner = owner
        self.__array_interface__ = {"version": 3, "shape": (values.size,), "typestr": TYPES[values.type].str,
                                    "data": (values.data, False)}


def simplify(mesh, options, tell, notice):
    """A Result. Calls tell(share), which may answer False to end the run, and notice(text), and raises what they raise.

    The library works on a thread of its own, where no handlers of signals run: nothing may be thrown through it.
    """
    events = queue.SimpleQueue()
    ended, done = threading.Event(), threading.Event()
    observer = Observer(None, _PROGRESS(lambda data, share, phase: events.put((tell, share))),
                        _CANCELLED(lambda data: ended.is_set() or _runs.ending),
                        _NOTICE(lambda data, text: events.put((notice, readable(text)))))
    made = []
    order = []  # whoever comes first has its way: the thread, or what interrupts its start

    def is_first(who):
        order.append(who)
        return order[0] == who

    def work():
        try:
            if is_first("thread") and _runs.begin():
                try:
                    address = _library.tetfusion_simplify(ctypes.byref(mesh), options.encode(), ctypes.byref(observer))
                    made.append(Result(address) if address else None)
                finally:
                    _runs.done()
        finally:
            done.set()
            events.put(None)
    try:
        _thread.start_new_thread(work, ())  # threading's may be left half begun by what a signal's handler raises
        while (event := events.get()) is not None:
            function, value = event
            answer = None if ended.is_set() else function(value)
            if answer is not None and not answer:
                ended.set()
    except BaseException:
        ended.set()
        _wait(lambda: is_first("caller") or done.wait())
        raise
    if _runs.ending and threading.current_thread().daemon:
        threading.Event().wait()  # Python ends, and this thread with it
    if not made:
        raise RuntimeError("Python ends")
    if made[0] is None:
        raise MemoryError
    if ended.is_set():  # though all may be done
        made[0].code = INTERRUPTED
    return made[0]


def _wait(over):
    """Till the library has done with what it was given, if it has begun; another Ctrl-C does not change that."""
    while True:
        try:
            over()
            return
        except BaseException:
            pass


def values_of(array):
    """REQUIRES: the array is contiguous and of one of TYPES; it must stay alive."""
    return Values(TYPES.index(array.dtype), array.ctypes.data if array.size else None, array.size)


def readable(text):
    return text.decode(errors="surrogateescape")


def version():
    return readable(_library.tetfusion_version())
