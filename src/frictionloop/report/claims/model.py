"""Claims about the friction model, what it can reach, and the numbers of the simulation's signals."""

from __future__ import annotations

import math

from frictionloop.parameters import paper
from frictionloop.physics.friction import friction_force
from frictionloop.report.claims.claim import Claim, Group, python
from frictionloop.report.numbers import number
from frictionloop.report.results import Results
from frictionloop.report.systems import FEASIBLE, reachable_share, readings


def _not_negative(_: Results) -> Claim:
    floor = float(friction_force(2.5, paper().friction))
    return Claim(
        id="disturbance-amplitude",
        of=Group.SLIP,
        note=1,
        quantity="lowest friction",
        meant="0.8 N peak to peak",
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
        of=Group.QUESTION,
        note=3,
        quantity="share of time in reach",
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


CLAIMS = (_not_negative, _setpoint_reachable)
