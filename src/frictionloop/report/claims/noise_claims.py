"""Numbers of the claims of Sec. 2.3 and 5 about sensor noise, Fig. 2e and 2f and equation (3)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from frictionloop.analysis.linear import check_pi
from frictionloop.parameters import System, feasible
from frictionloop.report.claims.claim import Numbers, Value, numbers
from frictionloop.report.results import Results
from frictionloop.report.sensor_noise import NOISE, NOISE_READINGS, knee_n, linear_gain, steady_noise
from frictionloop.report.system_comparison import FEASIBLE, PER_SAMPLE, PER_SECOND, per_sample
from frictionloop.report.tolerances import R2_STEP, SATURATION_STEP

UNITS = {PER_SECOND: feasible(), PER_SAMPLE: per_sample(feasible())}
"""The loop whose noise is simulated, by the unit that a printed Ki may have."""


def noise_precision(results: Results) -> Numbers:
    """Return the noise that lowers the fidelity."""
    return _knee(results, "r2_identity", R2_STEP)


def noise_saturation(results: Results) -> Numbers:
    """Return the noise that saturates the output."""
    return _knee(results, "saturation_index", SATURATION_STEP)


def _knee(results: Results, metric: str, step: float) -> Numbers:
    """Return the noise at which a metric has moved by a step, in the unit of each reading of a noise level."""
    knees = {name: knee_n(sweep[metric], step) for name, sweep in results.noise.items()}
    levels: dict[str, Value] = {
        f"{reading} ({of.unit}), {name}": None if sigma is None else of.level(sigma)
        for reading, of in NOISE_READINGS.items()
        for name, sigma in knees.items()
    }
    reachable_n = knees[FEASIBLE]
    assert reachable_n is not None
    return numbers(levels, step=step, reachable_mn=1e3 * reachable_n, times=reachable_n / 1e-4)


def noise_subliminal(_: Results) -> Numbers:
    """Return the noise of the force that the printed noise of the sensor becomes."""

    def output_n(reading: str) -> float:
        sigma_n = NOISE_READINGS[reading].sigma_n(5e-5)
        return steady_noise(feasible().evolve({NOISE: sigma_n}))["f_a"]

    return numbers({f"{reading} ({of.unit})": output_n(reading) for reading, of in NOISE_READINGS.items()})


def low_gain_attenuates(_: Results) -> Numbers:
    """Return noise of the force over that of the sensor at a tenth of the gains."""
    return _at_gains(lambda low, _: low)


def higher_gain_amplifies(_: Results) -> Numbers:
    """Return noise of the force over that at a tenth of the gains."""
    return _at_gains(lambda low, high: high / low)


def _at_gains(of: Callable[[float, float], float]) -> Numbers:
    """Return a number of the noise of the force over the sensor's at a tenth of the printed gains and at these."""
    found = {unit: (_force_gain(system, 0.1), _force_gain(system, 1.0)) for unit, system in UNITS.items()}
    low, high = found[PER_SECOND]
    return numbers({unit: of(*both) for unit, both in found.items()}, low=low, high=high)


@cache
def _force_gain(system: System, share: float) -> float:
    """Return noise of the force over the sensor's with both gains multiplied by ``share``."""
    pi = check_pi(system)
    changed = system.evolve({"controller.kp": share * pi.kp, "controller.ki": share * pi.ki})
    return steady_noise(changed)["f_a"] / system.sensor.noise_rms_n


def equation_3(results: Results) -> Numbers:
    """Return the simulated noise of the force over what equation (3) says of it."""
    (simulated, _), linear = _simulated(results), linear_gain(feasible())
    return numbers(
        {
            "at 1 Hz, as printed": simulated / linear["tone"],
            "summed over the noise's spectrum": simulated / linear["f_a"],
        },
        summed=linear["f_a"],
        simulated=simulated,
        tone=linear["tone"],
    )


FORCE, COMMAND = "friction force", "force command"
"""The output, and what it is not."""


def one_order_lower(results: Results) -> Numbers:
    """Return noise of the output over that of the sensor at Kp = 10."""
    return numbers(dict(zip((FORCE, COMMAND), _simulated(results), strict=True)), compared=[COMMAND])


def one_order_not_linear(results: Results) -> Numbers:
    """Return noise of the output at Kp = 10, simulated over what equation (3) says of it, |G/(1 + G)|."""
    predicted = {"summed over the spectrum": "f_a", "at 1 Hz": "tone"}
    linear, found = linear_gain(feasible()), dict(zip((FORCE, COMMAND), _simulated(results), strict=True))
    ratios = {f"{of}, {by}": each / linear[key] for of, each in found.items() for by, key in predicted.items()}
    return numbers(ratios, compared=[COMMAND], summed=linear["f_a"], tone=linear["tone"])


def _simulated(results: Results) -> tuple[float, float]:
    """Return noise of force and command over that of the sensor at Kp = 10, Ki = 2."""
    at_10 = results.steady.sel(kp_simulated=10.0)
    return float(at_10["simulated_f"]), float(at_10["simulated_u"])
