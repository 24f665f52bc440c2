"""Touch in the firmware against touch_step, on the same counts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cffi import FFI

from frictionloop.firmware.compiled_core import host_sources
from frictionloop.firmware.compiler import shared_library
from frictionloop.parameters import Board, Touch
from frictionloop.sensing.touch import TouchState, touch_coefficients, touch_step

DT = 1 / 5000
Q28 = 2.0**28
BOARD = Board()
DECLARED = """
typedef struct {
    int64_t position, missing, back; int32_t speed, mean_load, mean_speed; uint8_t begun, backwards;
} fl_touch;
typedef struct { int32_t force, position, speed, load, valid; } fl_measurement;
typedef struct { int32_t mantissa, shift; } fl_gain;
int32_t fl_counts(fl_gain, int32_t);
fl_measurement fl_touch_step(fl_touch *, const void *, int32_t, int32_t, int32_t);
"""


@pytest.fixture(scope="module")
def parts() -> tuple[FFI, Any]:
    ffi = FFI()
    ffi.cdef(DECLARED)
    sources, folders = host_sources()
    return ffi, ffi.dlopen(str(shared_library("core", sources, folders)))


def in_c(parts, words: np.ndarray, position: np.ndarray, load: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return measured (position, speed, load, valid) and the tracked position, missing way, mean at every tick."""
    ffi, lib = parts
    state, table = ffi.new("fl_touch *"), ffi.from_buffer(np.ascontiguousarray(words))
    seen, inner = [], []
    for x, n in zip(np.round(position * Q28).astype(int), np.round(load * Q28).astype(int), strict=True):
        m = lib.fl_touch_step(state, table, int(x), int(n), 0)
        seen.append((m.position / Q28, m.speed / Q28, m.load / Q28, m.valid))
        inner.append((state.position / 2**44, state.missing / 2**44, state.mean_load / Q28))
    return np.array(seen), np.array(inner)


def in_python(position: np.ndarray, load: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the same by touch_step, whose own noise is drawn as 0."""
    given, state = touch_coefficients(Touch(), DT), TouchState(position[0], 0.0, 0.0, 1e-3 * Touch().load.developed_mm)
    seen, inner = [], []
    for x, n in zip(position, load, strict=True):
        state, told = touch_step(state, x, n, 0.0, 0.0, given)
        seen.append(told)
        inner.append((state.position, state.missing, state.mean_load))
    return np.array(seen), np.array(inner)


def strokes(seed: int, ticks: int) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and loads of a finger that goes to and fro, lifts, lands, trembles, with the bench's noise."""
    rng, t = np.random.default_rng(seed), np.arange(ticks) * DT
    position = 0.03 * np.sin(2 * np.pi * 0.4 * t) + 1e-5 * rng.standard_normal(ticks)
    contact = np.clip(8 * np.sin(2 * np.pi * 0.7 * t + 1) + 4, 0, 1)
    load = 0.5 * contact * (1 + 0.4 * np.sin(2 * np.pi * 3 * t)) + 2e-3 * rng.standard_normal(ticks)
    return (
        np.round(position / BOARD.position_m_per_count) * BOARD.position_m_per_count,
        np.round(load / BOARD.load_n_per_count) * BOARD.load_n_per_count,
    )


@pytest.mark.parametrize("seed", [0, 1])
def test_ten_seconds_of_strokes(parts, words, seed: int):
    position, load = strokes(seed, 50_000)
    (seen, inner), (wanted, within) = in_c(parts, words, position, load), in_python(position, load)
    np.testing.assert_allclose(seen[:, [0, 2]], wanted[:, [0, 2]], rtol=0, atol=2 / Q28)
    # The sensor's noise gives the speed 0.7 mm/s; 1 um/s is far below.
    np.testing.assert_allclose(seen[:, 1], wanted[:, 1], rtol=0, atol=1e-6)
    np.testing.assert_allclose(inner[:, 0], within[:, 0], rtol=0, atol=1e-8)
    # Rounding may hold the mean where its step is below half of 2^-28: within 2^-29/mean_gain = 5 uN.
    np.testing.assert_allclose(inner[:, 2], within[:, 2], rtol=0, atol=1e-5)
    np.testing.assert_allclose(inner[:, 1], within[:, 1], rtol=0, atol=1e-6)
    differ = seen[:, 3] != wanted[:, 3]
    assert 0.2 < wanted[:, 3].mean() < 0.9
    assert differ.sum() <= 10  # a threshold that is met a rounding earlier or later


def test_no_lag_at_constant_speed(parts, words):
    position = 0.02 * np.arange(10_000) * DT
    seen, inner = in_c(parts, words, position, np.full(10_000, 0.5))
    assert seen[-1, 1] == pytest.approx(0.02, abs=1e-6)
    assert inner[-1, 0] == pytest.approx(position[-1], abs=1e-8)
    # The way is that of the tracked speed, which sets out from rest.
    developed_m = 1e-3 * Touch().load.developed_mm
    np.testing.assert_allclose(inner[:, 1], np.maximum(developed_m - np.cumsum(seen[:, 1]) * DT, 0.0), atol=1e-8)


def test_a_week_on_the_plate_overflows_nothing(parts, words):
    ffi, lib = parts
    state, table = ffi.new("fl_touch *"), ffi.from_buffer(np.ascontiguousarray(words))
    state.begun, state.missing, state.back, state.position = 1, 2**48, 2**48, 2**48
    for k in range(2000):
        lib.fl_touch_step(state, table, (-1) ** k * (2**31 - 1), 2**31 - 1, 0)
        assert 0 <= state.missing <= 2**44
        assert abs(state.back) <= 2**48
        assert abs(state.position) <= 2**48


@pytest.mark.parametrize(
    ("value", "counts"),
    [(5 / 2**16, 32767), (5 / 2**16, -32768), (1e-6, 123456), (1e-6, -(2**31)), (1.0, 3), (300.0, -1)],
)
def test_counts_to_q28(parts, value: float, counts: int):
    from frictionloop.firmware.quantised import to_gain

    wanted = min(max(value * counts * Q28, -(2.0**31)), 2.0**31 - 1)
    mantissa, shift = to_gain(value)
    told = parts[1].fl_counts((mantissa, shift), counts)
    assert told == pytest.approx(wanted, abs=0.5 + abs(wanted) * 2.0**-30)
