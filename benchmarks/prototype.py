"""The composition of the kernel tried on a rough bench: stick-slip finger, resonant sensor, notch (decision 1).

    python benchmarks/prototype.py

Scalar steps are lifted to tiles exactly as in ``frictionloop.loop``, but the plant advances by substeps: a Dahl contact
in series with the skin has dynamics faster than a control period, so each substep is one pass over the lanes. The
numbers are rough, assumed where not from the paper; the point is the cost of a block and that the composition carries.
"""

from __future__ import annotations

import math
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numba import njit
from scipy.linalg import expm
from scipy.signal import iirnotch

from frictionloop.control.lookup import inverse_step
from frictionloop.control.pi import PiState, pi_step
from frictionloop.loop.slab import LANES, load, peek, pointer, poke, store
from frictionloop.physics.friction import remaining_step
from frictionloop.physics.plate import lowpass_step
from frictionloop.quantities.arithmetic import fma, sin_turns, step
from frictionloop.sensing.measurement import Measurement

SUBSTEPS = 10  # 50 kHz inside a 5 kHz period
NAMES = """
    a skin_x skin_v bristle force p v f_m integral n1 n2 command error2
    decay f0 per_unit speed k c per_mass s0 h a11 a12 a21 a22 b1 b2 sensor_decay
    kp ki low high log2_f0 um2_per_halving c0 c1 c2 d1 d2
"""
ROW = {name: row for row, name in enumerate(NAMES.split())}


def at(names: str) -> tuple[int, ...]:
    return tuple(ROW[name] for name in names.split())


@step
def dahl_step(skin_x, skin_v, bristle, limit, speed, k, c, per_mass, s0, h):  # type: ignore[no-untyped-def]
    """Skin m x'' = s0 z - k x - c x' over a Dahl bristle z' = v (1 - s0 z sign(v)/F_c), both implicit."""
    relative = speed - skin_v
    bristle = fma(h, relative, bristle) / (1.0 + h * s0 * abs(relative) / limit)
    force = s0 * bristle
    skin_v = fma(h * per_mass, force - k * skin_x, skin_v) / (1.0 + h * per_mass * (c + h * k))
    return fma(h, skin_v, skin_x), skin_v, bristle, force


@step
def suspension_step(p, v, f_m, force, a11, a12, a21, a22, b1, b2, decay):  # type: ignore[no-untyped-def]
    """Resonant suspension (exact for a held force), then a first-order low-pass."""
    p, v = fma(a11, p, fma(a12, v, b1 * force)), fma(a21, p, fma(a22, v, b2 * force))
    return p, v, fma(f_m - p, decay, p)


@step
def notch_step(n1, n2, x, c0, c1, c2, d1, d2):  # type: ignore[no-untyped-def]
    """One biquad in transposed direct form II."""
    y = fma(c0, x, n1)
    return fma(c1, x, fma(-d1, y, n2)), fma(c2, x, -d2 * y), y


def lift(function, reads: str, writes: str):  # type: ignore[no-untyped-def]
    """Lift a scalar step to a loop over the lanes of a tile."""
    read_rows, write_rows = at(reads), at(writes)

    @njit(error_model="numpy")
    def tile(s, n):  # type: ignore[no-untyped-def]
        for i in range(n):
            store(s, i, LANES, write_rows, function(*load(s, i, LANES, read_rows)))

    return tile


@step
def plate(a, command, decay):  # type: ignore[no-untyped-def]
    return (lowpass_step(a, command, decay),)


@step
def finger(skin_x, skin_v, bristle, a, f0, per_unit, speed, k, c, per_mass, s0, h):  # type: ignore[no-untyped-def]
    limit = f0 * remaining_step(a * per_unit)
    return dahl_step(skin_x, skin_v, bristle, limit, speed, k, c, per_mass, s0, h)


def build(blocks: int):  # type: ignore[no-untyped-def]
    """Return the kernel with the first ``blocks`` of: control, plate, finger, suspension, notch."""
    plate_tile = lift(plate, "a command decay", "a")
    finger_tile = lift(
        finger, "skin_x skin_v bristle a f0 per_unit speed k c per_mass s0 h", "skin_x skin_v bristle force"
    )
    sensor_tile = lift(suspension_step, "p v f_m force a11 a12 a21 a22 b1 b2 sensor_decay", "p v f_m")
    notch_tile = lift(notch_step, "n1 n2 f_m c0 c1 c2 d1 d2", "n1 n2 f_m")
    integral, command, error2, force = at("integral command error2 force")
    gains, model, measured = at("kp ki low high"), at("log2_f0 um2_per_halving"), at("f_m")

    @njit(error_model="numpy")
    def control(s, n, setpoint, dt):  # type: ignore[no-untyped-def]
        for i in range(n):
            (f_m,) = load(s, i, LANES, measured)
            state = PiState(peek(s, integral * LANES + i))
            m = Measurement(f_m, 0.0, 0.0, 0.0, 1.0)
            state, wanted = pi_step(state, m, setpoint, load(s, i, LANES, gains), dt)
            poke(s, integral * LANES + i, state[0])
            poke(s, command * LANES + i, inverse_step(wanted[0], *load(s, i, LANES, model)))
            error = peek(s, force * LANES + i) - setpoint
            poke(s, error2 * LANES + i, fma(error, error, peek(s, error2 * LANES + i)))

    @njit(error_model="numpy", nogil=True)
    def advance(slab, n, periods, dt):  # type: ignore[no-untyped-def]
        s = pointer(slab)
        for period in range(periods):
            if blocks > 4:
                notch_tile(s, n)
            control(s, n, 0.6 + 0.1 * sin_turns(period * dt), dt)
            for _ in range(SUBSTEPS):
                if blocks > 1:
                    plate_tile(s, n)
                if blocks > 2:
                    finger_tile(s, n)
                if blocks > 3:
                    sensor_tile(s, n)

    return advance


def rough_bench() -> np.ndarray:
    """Return the slab of one tile: 145 Hz, Q 20, 1 kHz pole, 20 mm/s, skin 1 N/mm; a slow PI that survives it."""
    dt, resonance, q = 2e-4, 2 * math.pi * 145, 20
    h = dt / SUBSTEPS
    phi = expm(h * np.array([[0, 1, 0], [-(resonance**2), -resonance / q, resonance**2], [0, 0, 0]]))
    c, d = iirnotch(145, 1.0, 1 / dt)
    values = {
        **{"decay": math.exp(-2 * math.pi * 100 * h), "f0": 1.0, "per_unit": math.sqrt(0.38 / math.log(2))},
        **{"speed": 0.02, "k": 1e3, "c": 1.0, "per_mass": 1e4, "s0": 2e4, "h": h},
        **dict(zip(("a11", "a12", "b1", "a21", "a22", "b2"), phi[:2].ravel(), strict=True)),
        **{"sensor_decay": math.exp(-2 * math.pi * 1000 * h)},
        **{"kp": 0.06, "ki": 134.0, "low": math.exp(-0.38 * 6.25), "high": 1.0},
        **{"log2_f0": 0.0, "um2_per_halving": math.log(2) / 0.38},
        **dict(zip(("c0", "c1", "c2", "d1", "d2"), (*c, *d[1:]), strict=True)),
    }
    slab = np.zeros((len(ROW), LANES))
    for name, value in values.items():
        slab[ROW[name]] = value
    return slab


def measure(blocks: int, periods: int = 50_000, threads: int = 2) -> tuple[float, float]:
    """Return (million control periods per second, rms error in N), the best of three runs."""
    advance = build(blocks)
    advance(rough_bench().ravel(), LANES, 1, 2e-4)

    def run(slab: np.ndarray) -> None:
        advance(slab, LANES, periods, 2e-4)

    best = math.inf
    for _ in range(3):
        slabs = [rough_bench().ravel() for _ in range(threads)]
        start = time.perf_counter()
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(run, slabs))
        best = min(best, time.perf_counter() - start)
    error2 = slabs[0].reshape(len(ROW), LANES)[ROW["error2"], 0]
    return threads * LANES * periods / best / 1e6, math.sqrt(error2 / periods)


def main() -> None:
    print(f"2 threads, a tile of {LANES} lanes each, {SUBSTEPS} substeps of 20 us, 10 s of signal")
    names = {1: "control alone", 2: "and plate", 4: "and Dahl finger, suspension", 5: "and notch"}
    for blocks, name in names.items():
        rate, rms = measure(blocks)
        error = f"   rms error {1e3 * rms:5.1f} mN" if blocks > 3 else ""
        print(f"{name:28s} {rate:7.1f} M control periods/s{error}")


if __name__ == "__main__":
    main()
