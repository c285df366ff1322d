"""The compiled field on a grid, for the programs that want one: the best case, where the formula is compiled code."""

import ctypes
import os

import numpy as np

NAMES = ["torus", "dodeca", "dtorus", "mcmullen", "chair", "decocube"]

_library = ctypes.CDLL(os.environ["PEER_FIELDS"])
_library.peer_grid.restype = None
_library.peer_grid.argtypes = [
    ctypes.c_uint32,
    ctypes.c_void_p,
    ctypes.c_double,
    ctypes.c_void_p,
    ctypes.c_void_p,
]


class Grid:
    """Values with z slowest and x fastest; `parameter` intervals along the longest side of the box."""

    def __init__(self, request):
        low, high = np.array(request.box).reshape(3, 2).T
        self.step = (high - low).max() / round(request.parameter)
        size = np.ceil((high - low) / self.step - 1e-9).astype(np.uintp) + 1
        self.origin = np.ascontiguousarray(low)
        self.values = np.empty(size[::-1], np.float32)
        _library.peer_grid(
            NAMES.index(request.name),
            self.origin.ctypes.data,
            self.step,
            size.ctypes.data,
            self.values.ctypes.data,
        )
