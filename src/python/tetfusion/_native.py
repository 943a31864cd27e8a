"""libtetfusion.so by its C interface (tetfusion_c.h)."""
import ctypes
import os
import pathlib

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

    def __init__(self, progress, cancelled, notice):
        super().__init__(None, _PROGRESS(lambda data, share, phase: progress(share)),
                         _CANCELLED(lambda data: cancelled()), _NOTICE(lambda data, text: notice(readable(text))))


class Result:
    """Frees what the library has made when nobody refers to it any more."""

    def __init__(self, address):
        self._address = address
        self.code = _library.tetfusion_code(address)
        self.message = readable(_library.tetfusion_message(address))
        self.report = readable(_library.tetfusion_report(address))
        self.mesh = _library.tetfusion_mesh_of(address).contents

    def __del__(self):
        _library.tetfusion_free(self._address)

    def numbers(self, values):
        """The library's memory as an array, which keeps it alive."""
        return np.asarray(_Memory(self, values)) if values.size else np.zeros(0, TYPES[values.type])


class _Memory:
    def __init__(self, owner, values):
        self._owner = owner
        self.__array_interface__ = {"version": 3, "shape": (values.size,), "typestr": TYPES[values.type].str,
                                    "data": (values.data, False)}


def simplify(mesh, options, observer):
    address = _library.tetfusion_simplify(ctypes.byref(mesh), options.encode(), ctypes.byref(observer))
    if not address:
        raise MemoryError
    return Result(address)


def values_of(array):
    """REQUIRES: the array is contiguous and of one of TYPES; it must stay alive."""
    return Values(TYPES.index(array.dtype), array.ctypes.data if array.size else None, array.size)


def readable(text):
    return text.decode(errors="surrogateescape")


def version():
    return readable(_library.tetfusion_version())


def _load():
    name = "libtetfusion.so.0.1"  # another minor version is another interface
    given = os.environ.get("TETFUSION_LIBRARY")
    here = pathlib.Path(__file__).resolve().parent  # PREFIX/lib/python3/dist-packages/tetfusion, or that below a build
    lib = here.parents[2]
    beside = [lib / name, *sorted(lib.glob(f"*/{name}")), lib.parent / name]
    for place in [given] if given else [*(path for path in beside if path.exists()), name]:
        try:
            return ctypes.CDLL(str(place))
        except OSError as error:
            failure = error
    raise ImportError(f"{failure}; TETFUSION_LIBRARY may say where {name} lies") from failure


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
