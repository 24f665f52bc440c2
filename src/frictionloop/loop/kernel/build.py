"""The compiled loops: steps of all rooms composed into one control period, the period repeated over time.

A kernel, ``advance``, is compiled for tiles of 32 lanes and for a single lane. It is single-threaded, releases the GIL
and is called for chunks of time, so that threads, Ctrl-C and progress belong to the caller.
"""

from __future__ import annotations

from threading import Lock
from typing import Any

import numpy as np

from frictionloop.loop.kernel.exchange import EXTERNAL, NOTHING, STILL, Options, Plan, buffers
from frictionloop.loop.kernel.kernel_quadrature import build_quadrature
from frictionloop.loop.kernel.kernel_substeps import build_substeps
from frictionloop.loop.kernel.slab import ROWS, aligned
from frictionloop.quantities.compiled import SourceCache

BUILDERS = {"quadrature": build_quadrature, "substeps": build_substeps}
_kernels: dict[tuple[str, int], Any] = {}
_building = Lock()


def kernel(name: str, width: int) -> Any:
    """Return the compiled ``advance`` for tiles of this width (1 or ``LANES``), from the disk cache if it is there."""
    with _building:  # threads that start together must not compile it twice
        if (name, width) not in _kernels:
            advance = BUILDERS[name](width)
            advance._cache = SourceCache(advance.py_func, f"{name}-{width}")
            _call_once(advance, width)
            _kernels[name, width] = advance
        return _kernels[name, width]


def _call_once(advance: Any, width: int) -> None:
    """Compile or load the kernel by running it for no time at all, and let it never be compiled again.

    Numba does not guard the first call of a cached function: two threads would each load it, and the one that loses
    runs code that has been freed.
    """
    none = Options(EXTERNAL, 1, 0, 0, True, 0, True, True, 0, 0, False, 0, 0, 1.0, STILL, False, 0, Plan(), False, 0, 0)
    scratch = buffers(width, 1, 1, NOTHING, np.zeros(width, np.uint64))
    advance(aligned(ROWS * width), width, 0, 0, none, scratch, NOTHING, NOTHING, 0, NOTHING)
    advance.disable_compile()
