"""Claims about the friction model, what it can reach, and the numbers of the simulation's signals."""

from __future__ import annotations

import math
from functools import partial

from frictionloop.parameters import System, paper
from frictionloop.physics.friction import friction_force, reachable
from frictionloop.physics.sources import evaluate
from frictionloop.report.claims.claim import Claim, python
from frictionloop.report.numbers import number
from frictionloop.report.results import Results
from frictionloop.report.systems import FEASIBLE, compared, reachable_share, readings

BAND_HIGH = "f₀ = 0.8 N plus the smallest d, which is 0 or less: the finger on the device must have had more."


def _not_negative(_: Results) -> Claim:
    floor = float(friction_force(2.5, paper().friction))
    return Claim(
        id="disturbance-amplitude",
        title="The disturbance never makes friction negative",
        place="Sec. 2.1",
        quote="perturbation d that is bounded so to avoid negative values … 1 Hz sine wave of 0.8 N amplitude and "
        "0.4 N offset",
        published="not negative",
        unit="N",
        measure="lowest friction force, g(2.5 µm) + min d",
        readings={"0.8 N peak to peak": floor + 0.4 - 0.4, "0.8 N zero to peak": floor + 0.4 - 0.8},
        accepted=(0.0, math.inf),
        tolerance="the sign",
        explanation="Only 0.8 N peak to peak, which is the 0.4 N amplitude of Sec. 2.3, keeps friction from pulling "
        "the finger forward. Both statements then agree.",
        command=python(
            "import frictionloop as fl; s = fl.paper(); d = s.disturbance; "
            "print(float(fl.friction_force(2.5, s.friction)) + d.offset_n - d.amplitude_n)"
        ),
    )


def _setpoint_reachable(results: Results) -> Claim:
    share = {name: reachable_share(system) for name, system in readings().items()}
    bounds = ", ".join(f"{number(float(results.over_kp[name]['r2_bound']), 2)} ({name})" for name in share)
    return Claim(
        id="setpoint-reachable",
        title="The set-point of the simulation can be followed",
        place="Sec. 2.3",
        quote="the setpoint signal was a logarithmically swept-sinusoid … of 1.2 N amplitude",
        published="implied",
        measure="share of the time at which f_r is within reach",
        readings=share,
        accepted=(1.0, 1.0),
        tolerance="fidelity to f_a = f_r presupposes a set-point within [g(2.5 µm) + d, f₀ + d]",
        explanation="The disturbance moves the reachable band by more than its width. The best R² that any "
        f"controller could reach is {bounds}; it is 1 for the {FEASIBLE}, by construction.",
        command=python(
            "import frictionloop as fl; from frictionloop.report.systems import *; print(reachable_share(fl.paper()))"
        ),
    )


def _ends(system: System) -> tuple[float, float]:
    time = [k / 1000 for k in range(1000)]
    return reachable(system, evaluate(system.disturbance, time))  # type: ignore[arg-type]


def _band_low_text() -> str:
    floor = float(friction_force(2.5, paper().friction))
    return (
        f"g(2.5 µm) = {number(floor, 2)} N plus the largest d: 0.3 N is within reach at all times only if d never "
        f"exceeds {0.3 - floor:.3f} N, which no reading of the simulated disturbance satisfies."
    )


def _band(low: bool, _: Results) -> Claim:
    end, printed = (0, 0.3) if low else (1, 0.9)
    return Claim(
        id="band-low" if low else "band-high",
        title=f"{printed} N can be reached at all times",
        place="Sec. 4.2, Sec. 6",
        quote="between 0.3 and 0.9 N, which corresponds to a range of reliably achievable forces",
        published=printed,
        unit="N",
        measure="lowest force reachable at all times" if low else "highest force reachable at all times",
        readings={name: _ends(system)[end] for name, system in readings().items()},
        compared={FEASIBLE: _ends(compared()[FEASIBLE])[end]},
        accepted=(-math.inf, printed) if low else (printed, math.inf),
        tolerance="the printed end of the range",
        explanation=_band_low_text() if low else BAND_HIGH,
        command=python(
            "import frictionloop as fl; s = fl.paper(); d = s.disturbance; "
            f"print(fl.reachable(s, [d.offset_n - d.amplitude_n, d.offset_n + d.amplitude_n])[{end}])"
        ),
    )


CLAIMS = (_not_negative, _setpoint_reachable, partial(_band, True), partial(_band, False))
