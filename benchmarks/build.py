"""Build the C loops with the machine's C compiler (or zig from the ziglang wheel) and call them through ctypes."""

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
MIX = ("-fschedule-insns", "-fsched-pressure")  # gcc then mixes the two halves of a tile
OWN = ("f0", "tau", "a_max", "model_f0", "model_tau", "model_a_max", "plate_hz", "sensor_hz", "noise_rms", "kp", "ki")
"""What each lane of reference_lanes.c has of its own, in the order of its `Lane`."""


def compiler() -> list[str]:
    """`$CC`, else cc, else zig; a one-line error when there is none."""
    named = os.environ.get("CC", "cc").split()
    if shutil.which(named[0]):
        return named
    if find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc"]
    raise SystemExit("no C compiler: install cc, or `pip install ziglang`")


def build(cc: list[str] | None = None, name: str = "reference", more: tuple[str, ...] = ()) -> Path:
    """Compile once per compiler, flags and source; later calls find the library in the temporary folder."""
    cc = cc or compiler()
    text = (
        b"".join(source.read_bytes() for source in sorted(HERE.glob("reference*.[ch]")))
        + " ".join((*cc, *FLAGS, WIDE, *more)).encode()
    )
    folder = Path(tempfile.gettempdir()) / f"frictionloop-benchmarks-{os.getuid() if hasattr(os, 'getuid') else 0}"
    folder.mkdir(mode=0o700, exist_ok=True)
    library = folder / f"{name}-{hashlib.sha256(text).hexdigest()[:16]}.so"
    if not library.exists():
        fresh = library.with_suffix(f".{os.getpid()}")
        command = [*cc, *FLAGS, str(HERE / f"{name}.c"), "-o", str(fresh), "-lm"]
        for known in ((WIDE, *more), (WIDE,), more):  # not every compiler knows them
            if not subprocess.run([*command, *known], check=False, capture_output=True).returncode:
                break
        else:
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
        whole = ctypes.c_int
        self._c.run_grid.argtypes = [pointer, long, pointer, pointer, number, long, whole, whole, pointer]
        self._run_lanes = ctypes.CDLL(str(build(self.cc, "reference_lanes", MIX))).run_lanes
        self._run_lanes.argtypes = [pointer, long, pointer, pointer, long, ctypes.c_int, pointer]

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

    def grid(
        self, p: Paper, kp: Array, ki: Array, periods: int, threads: int, seeds: Any = None, ends: bool = False
    ) -> Array:
        """R2_identity and saturation index, one row per lane; `seeds` draws noise in the loop, one stream per lane.

        `ends`: a period from its two ends, which is frictionloop's rule, instead of six nodes.
        """
        numbers, gains, out = (
            np.array(p.numbers()),
            np.ascontiguousarray(np.stack([kp, ki], axis=1)),
            np.empty((len(kp), 2)),
        )
        own = None if seeds is None else np.ascontiguousarray(seeds, dtype=np.uint64)
        address = None if own is None else own.ctypes.data
        if self._c.run_grid(
            numbers.ctypes.data, len(kp), gains.ctypes.data, address, 0, periods, threads, ends, out.ctypes.data
        ):
            raise RuntimeError("the C reference could not start its threads")
        return out

    def lanes(self, p: Paper, own: dict[str, Any], periods: int, threads: int, seeds: Any = None) -> Array:
        """The same two numbers from reference_lanes.c, where every lane has a System of its own.

        `own` holds numbers or arrays over lanes by the names of `OWN`; the rest is the paper's, and the controller's
        model that of the finger unless it is given. Without `seeds` there is no noise.
        """
        given: dict[str, Any] = {name: getattr(p, name) for name in OWN if hasattr(p, name)} | own
        columns: list[Any] = [given.get(name, given.get(name.removeprefix("model_"))) for name in OWN]
        rows = np.ascontiguousarray(np.stack(np.broadcast_arrays(*columns), axis=-1), dtype=np.float64)
        numbers, out = np.array(p.numbers()), np.empty((len(rows), 2))
        streams = None if seeds is None else np.ascontiguousarray(seeds, dtype=np.uint64)
        address = None if streams is None else streams.ctypes.data
        if self._run_lanes(
            numbers.ctypes.data, len(rows), rows.ctypes.data, address, periods, threads, out.ctypes.data
        ):
            raise RuntimeError("the C reference could not start its threads")
        return out
