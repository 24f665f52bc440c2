"""Lookup and overdrive in the C core against the exact inverse and the float64 step, compared as forces."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.lookup import overdrive_gains, overdrive_step
from frictionloop.firmware.compiled_core import CELLS, host_library
from frictionloop.quantities.schema import parameter_words

ONE = 2.0**28
FORCE_N = 2e-4
WORDS = parameter_words()
MODELS = {
    "paper": fl.paper().controller.model,
    "bench": fl.bench().controller.model,
    "strong": fl.Model(nominal_n=1.4, susceptibility_per_um2=0.6),
    "weak": fl.Model(nominal_n=0.5, susceptibility_per_um2=0.05, max_amplitude_um=1.0),
    "wide": fl.Model(nominal_n=2.0, susceptibility_per_um2=0.05, max_amplitude_um=7.9),
}


def friction(model, amplitude_um):
    return model.nominal_n * np.exp(-model.susceptibility_per_um2 * np.square(amplitude_um))


def inverse(model, force_n):
    return np.sqrt(np.log(model.nominal_n / force_n) / model.susceptibility_per_um2)


@pytest.mark.parametrize("name", MODELS)
def test_lookup_gives_the_amplitude_for_the_force(parity, name):
    model = MODELS[name]
    law = parity.FixedLaw(fl.LookupController(model=model))
    rng = np.random.default_rng(5)
    low, high = (law.words[WORDS[key].first] for key in ("law.low_n", "law.high_n"))
    ends = np.array([low, low + 1, high - 1, high])
    forces = np.concatenate([ends, rng.integers(low, high, 20_000)]).astype(np.int32)
    amplitudes = law.lookup(forces) / ONE
    ideal = inverse(model, np.clip(forces / ONE, model.floor_n, model.nominal_n))
    apart = np.abs(friction(model, amplitudes) - friction(model, ideal))
    assert np.max(apart) < FORCE_N
    # Linear interpolation of a^2 errs by h^2/(8 u) in force; the rest is rounding, of a^2 (2^-26 um^2) and of u.
    spacing = (model.nominal_n - model.floor_n) / CELLS
    lowest = np.maximum(forces / ONE - spacing, model.floor_n)
    assert np.all(apart < spacing**2 / (8 * lowest) + 1e-7)


def test_lookup_stays_within_its_table_for_any_force(parity):
    law = parity.FixedLaw(fl.LookupController())
    forces = np.array([-(2**31), -1, 0, 2**31 - 1], dtype=np.int32)
    np.testing.assert_allclose(law.lookup(forces) / ONE, [2.5, 2.5, 2.5, 0.0], atol=1e-7)


@pytest.mark.parametrize("overdriven", [True, False])
def test_overdrive_takes_the_plate_where_the_float64_step_takes_it(parity, overdriven):
    controller = fl.LookupController(overdrive=overdriven, model=MODELS["bench"])
    model, gains = controller.model, overdrive_gains(controller)
    law, rng = parity.FixedLaw(controller), np.random.default_rng(6)
    low, high = (law.words[WORDS[key].first] for key in ("law.low_n", "law.high_n"))
    wanted = law.lookup(rng.integers(low, high, 20_000, endpoint=True).astype(np.int32))
    wanted[:4] = 0, 1, wanted.max(), round(2.5 * ONE)
    believed = rng.permutation(wanted)
    reached, commands = law.overdrive(believed, wanted)
    ideal = np.array([overdrive_step(b / ONE, w / ONE, gains) for b, w in zip(believed, wanted, strict=True)])
    assert np.max(np.abs(friction(model, reached / ONE) - friction(model, ideal[:, 0]))) < FORCE_N
    # A rounding of p a is multiplied by 1/(1 - p).
    assert np.max(np.abs(commands / ONE - ideal[:, 1])) * ONE < 2 + 2 * gains.inverse


def test_root_is_the_whole_root():
    ffi, library = host_library()
    rng = np.random.default_rng(7)
    edges = [0, 1, 2, 3, 4, 2**62 - 1, 2**62, 2**64 - 2**33, 2**64 - 2**33 + 1, 2**64 - 1]
    roots = rng.integers(1, 2**32, 5_000)
    exact = [int(r) ** 2 + d for r in roots for d in (-1, 0)]
    spread = (rng.integers(0, 2**63, 10_000, dtype=np.uint64) * 2 + 1) >> rng.integers(0, 64, 10_000).astype(np.uint64)
    squares = np.concatenate([np.array([*edges, *exact], dtype=np.uint64), spread])
    found = np.empty(len(squares), dtype=np.uint32)
    library.fl_host_roots(
        len(squares), ffi.cast("uint64_t *", squares.ctypes.data), ffi.cast("uint32_t *", found.ctypes.data)
    )
    assert [math.isqrt(int(s)) for s in squares] == found.tolist()
