"""Build reference.c with the machine's C compiler (or zig from the ziglang wheel) and call it through ctypes."""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from paper import Array, Paper

HERE = Path(__file__).parent
# What a C programmer allows: fused multiply-adds, no errno; not -ffast-math, which undoes rounding by a constant.
FLAGS = (
    "-O3",
    "-march=native",
    "-ffp-contract=fast",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fPIC",
    "-shared",
    "-pthread",
)
WIDE = "-mprefer-vector-width=512"  # x86 only; compilers default to 256 bits there


def compiler() -> list[str]:
    """`$CC`, else cc, else zig; a one-line error when there is none."""
    named = os.environ.get("CC", "cc").split()
    if shutil.which(named[0]):
        return named
    if find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc"]
    raise SystemExit("no C compiler: install cc, or `pip install ziglang`")


def build(cc: list[str] | None = None) -> Path:
    """Compile once per compiler and source; later calls find the library in the temporary folder."""
    cc = cc or compiler()
    text = (
        b"".join(source.read_bytes() for source in sorted(HERE.glob("reference*.[ch]")))
        + " ".join((*cc, *FLAGS, WIDE)).encode()
    )
    folder = Path(tempfile.gettempdir()) / f"frictionloop-benchmarks-{os.getuid() if hasattr(os, 'getuid') else 0}"
    folder.mkdir(mode=0o700, exist_ok=True)
    library = folder / f"reference-{hashlib.sha256(text).hexdigest()[:16]}.so"
    if not library.exists():
        fresh = library.with_suffix(f".{os.getpid()}")
        command = [*cc, *FLAGS, str(HERE / "reference.c"), "-o", str(fresh), "-lm"]
        if subprocess.run(
            [*command, WIDE], check=False, capture_output=True
        ).returncode:  # a compiler without the x86 option
            subprocess.run(command, check=True)
        fresh.replace(library)
    return library


class Reference:
    """The C loop. A call evaluates set-point, disturbance and noise itself and returns freshly allocated results."""

    traces = ("f_r", "f_a", "f_m", "u", "a", "d", "saturated")

    def __init__(self, cc: list[str] | None = None) -> None:
        self.cc = cc or compiler()
        self._c = ctypes.CDLL(str(build(self.cc)))
        pointer, long, number = ctypes.c_void_p, ctypes.c_long, ctypes.c_uint64
        for name in ("run_one", "run_one_jump"):
            getattr(self._c, name).argtypes = [pointer, pointer, long, number, pointer]
            getattr(self._c, name).restype = None
        self._c.run_grid.argtypes = [pointer, long, pointer, pointer, number, long, ctypes.c_int, pointer]

    @property
    def version(self) -> str:
        return subprocess.run([*self.cc, "--version"], check=True, capture_output=True, text=True).stdout.splitlines()[
            0
        ]

    def one(self, p: Paper, kp: float, ki: float, periods: int, seed: int = 0, jump: bool = False) -> Array:
        """All traces, one row each. `jump`: branch over logarithm and root while the clamp is active."""
        numbers, gains, out = np.array(p.numbers()), np.array([kp, ki], dtype=float), np.empty((7, periods))
        run = self._c.run_one_jump if jump else self._c.run_one
        run(numbers.ctypes.data, gains.ctypes.data, periods, seed, out.ctypes.data)
        return out

    def grid(self, p: Paper, kp: Array, ki: Array, periods: int, threads: int, seeds: Any = None) -> Array:
        """R2_identity and saturation index, one row per lane; `seeds` draws noise in the loop, one stream per lane."""
        numbers, gains, out = (
            np.array(p.numbers()),
            np.ascontiguousarray(np.stack([kp, ki], axis=1)),
            np.empty((len(kp), 2)),
        )
        own = None if seeds is None else np.ascontiguousarray(seeds, dtype=np.uint64)
        address = None if own is None else own.ctypes.data
        if self._c.run_grid(
            numbers.ctypes.data, len(kp), gains.ctypes.data, address, 0, periods, threads, out.ctypes.data
        ):
            raise RuntimeError("the C reference could not start its threads")
        return out
