"""Claims of Sec. 2.3 and the Discussion about how noise goes round the loop, equation (3)."""

from __future__ import annotations

import math

from frictionloop.parameters import feasible
from frictionloop.report.claims.claim import Claim, python
from frictionloop.report.numbers import number
from frictionloop.report.results import Results
from frictionloop.report.steady import linear_gain
from frictionloop.report.tolerances import DECADE_FACTOR, HALF_DECADE, SAME, SAME_RULE, half_decade

STEADY = "import frictionloop as fl; from frictionloop.report.steady import *; "
FORCE, COMMAND = "output = friction force", "output = force command"


def _gains(results: Results) -> tuple[dict[str, float], dict[str, float]]:
    """Return the noise gain of force and command at Kp = 10, Ki = 2, simulated and linear."""
    at_10 = results.steady.sel(kp_simulated=10.0)
    return {"f_a": float(at_10["simulated_f"]), "u": float(at_10["simulated_u"])}, linear_gain(feasible())


def _attenuates(results: Results) -> Claim:
    gain = results.steady["simulated_f"]
    return Claim(
        id="low-gain-attenuates",
        note=19,
        quantity="noise of force over sensor's",
        title="A lower gain attenuates the sensor's noise",
        place="Sec. 2.3, eq. (3)",
        quote="A lower gain attenuates the noise of the sensors",
        published="less than 1",
        measure="rms of f_a over rms of the sensor noise, Kp = 1",
        readings={"simulated": float(gain.sel(kp_simulated=1.0))},
        accepted=(0.0, 1.0),
        tolerance="attenuates: the force carries less noise than the sensor",
        explanation=f"Noise of the force over noise of the sensor is {float(gain.sel(kp_simulated=1.0)):.2f} at Kp = "
        f"1 and {float(gain.sel(kp_simulated=10.0)):.2f} at 10.",
        command=python(STEADY + "print(simulated_gain(fl.feasible().evolve({'controller.kp': 1.0}))['f_a'])"),
    )


def _single_frequency(results: Results) -> Claim:
    simulated, linear = _gains(results)
    return Claim(
        id="equation-3",
        note=19,
        quantity="simulated over predicted",
        title="Equation (3) gives the output noise",
        place="Sec. 2.3, eq. (3)",
        quote="error propagation analysis leads to the following relationship: σ_f² = |G/(1+G)|² σ_n²",
        published=1.0,
        measure="rms of f_a, simulated over predicted, Kp = 10",
        digits=4,
        readings={
            "at 1 Hz, as printed": simulated["f_a"] / linear["tone"],
            "summed over the noise's spectrum": simulated["f_a"] / linear["f_a"],
        },
        accepted=(1 - SAME, 1 + SAME),
        tolerance=SAME_RULE,
        explanation="As printed it holds for one frequency. Summed over a white spectrum (exactly, for the sampled "
        f"loop) it gives {linear['f_a']:.3f}, as simulated ({simulated['f_a']:.3f}); at 1 Hz alone it gives "
        f"{linear['tone']:.3f}.",
        command=python(STEADY + "print(simulated_gain(fl.feasible())['f_a'] / linear_gain(fl.feasible())['tone'])"),
    )


def _one_order(results: Results) -> Claim:
    simulated, _ = _gains(results)
    return Claim(
        id="one-order-lower",
        note=21,
        quantity="noise of force over sensor's",
        title="Sensor noise must be a tenth of the output's",
        place="Sec. 5",
        quote="to obtain a particular noise level on the output, the sensor noise has to be one order of magnitude "
        "lower",
        published=10.0,
        measure="output noise over sensor noise, Kp = 10",
        readings={FORCE: simulated["f_a"], COMMAND: simulated["u"]},
        accepted=half_decade(10.0),
        tolerance=HALF_DECADE,
        explanation=f"The friction force carries {number(simulated['f_a'])} times the sensor's noise, the command of "
        f"the controller {number(simulated['u'])} times, which is Kp: true of the command, not of what the finger "
        "feels.",
        command=python(STEADY + "print(simulated_gain(fl.feasible())['f_a'])"),
    )


def _not_linear(results: Results) -> Claim:
    simulated, linear = _gains(results)
    return Claim(
        id="one-order-not-linear",
        note=21,
        quantity="simulated over linear",
        title="Linear theory does not predict ten times the noise",
        place="Sec. 5",
        quote="This particular ratio is not predicted by the noise sensitivity function … might be the results of "
        "the non linearity",
        published="not predicted",
        measure="output noise, simulated over linear theory, Kp = 10",
        digits=4,
        readings={FORCE: simulated["f_a"] / linear["f_a"], COMMAND: simulated["u"] / linear["u"]},
        accepted=(DECADE_FACTOR, math.inf),
        tolerance="not predicted: half a decade or more above linear theory",
        explanation=f"Linear theory predicts both: {linear['f_a']:.2f} for the force and {linear['u']:.2f} for the "
        "command. No non-linearity is needed at these noise levels.",
        command=python(STEADY + "print(simulated_gain(fl.feasible())['f_a'] / linear_gain(fl.feasible())['f_a'])"),
    )


CLAIMS = (_attenuates, _single_frequency, _one_order, _not_linear)
