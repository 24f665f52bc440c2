"""Section 2: the systems compared, sliding trials (Fig. 1a), and force against set-point (Fig. 2b to 2d)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.signal import welch
from scipy.special import ndtr

from frictionloop.analysis.linear import check_pi
from frictionloop.figures.style import BLACK, BLUE, GREY, VERMILLION, new_figure, one_panel, styled
from frictionloop.loop.metrics import r2_identity, saturation_index
from frictionloop.loop.simulate import simulate
from frictionloop.parameters import READINGS, ColouredNoise, Constant, Friction, FrictionLimit, System, feasible, paper
from frictionloop.physics.coloured_noise import colour, shaping_filter, stationary_state
from frictionloop.physics.fingers import LOG_NORMAL, UNIFORM
from frictionloop.physics.friction import friction_force
from frictionloop.physics.reach import reach
from frictionloop.physics.signal_values import evaluate
from frictionloop.quantities import Array
from frictionloop.quantities.counter_noise import normals
from frictionloop.report.number_text import number

WORKING = "peak-to-peak"
"""The reading that ``paper()`` takes of the printed amplitudes."""
FEASIBLE = "reachable set-point"
"""Not a reading: ``feasible()``, the same loop asked for forces it can give."""


def readings() -> dict[str, System]:
    """Return the systems of the printed text, by the name of the reading; the working one is first."""
    return {name: paper().evolve(overrides) for name, overrides in READINGS.items()}


def compared() -> dict[str, System]:
    """Return ``readings`` and the system with a reachable set-point, which is last."""
    return readings() | {FEASIBLE: feasible()}


PER_SECOND, PER_SAMPLE = "Ki per second", "Ki per sample"
"""Readings of a Ki without a unit: the other one adds 2 in every control period."""


def per_sample(system: System) -> System:
    """Return a system whose ki is what the same number per control period would be, in 1/s."""
    return system.evolve({"controller.ki": check_pi(system).ki * system.controller.rate_hz})


def in_both_units(systems: Mapping[str, System]) -> dict[str, System]:
    """Return systems with Ki per second, then with Ki per sample, which their names then say."""
    return {**systems, **{f"{name}, {PER_SAMPLE}": per_sample(system) for name, system in systems.items()}}


def at_means(system: System) -> System:
    """Return a system with set-point and disturbance held at their means, as equation (3) assumes."""
    means = {name: getattr(getattr(system, name), "offset_n", 0.0) for name in ("setpoint", "disturbance")}
    return system.evolve({name: Constant(offset_n=mean_n) for name, mean_n in means.items()})


def reachable_share(system: System) -> float:
    """Return the share of control periods of 10 s at which f_r lies in [g(a_max) + d, f0 + d], 0 to 1."""
    time = np.arange(round(10.0 * system.controller.rate_hz)) / system.controller.rate_hz
    f_r, d = evaluate(system.setpoint, time), evaluate(system.disturbance, time)  # type: ignore[arg-type]
    there = reach(system.friction, system.motion, system.plate.max_amplitude_um).plus(d)
    return float(np.mean(~there.beyond(f_r)))


KPS = (40.0, 10.0, 1.0)
"""Proportional gains of Fig. 2b, 2c and 2d."""
NOISE_FROM_HZ = 200.0
"""Twice the highest frequency of the set-point: what lies above was not asked for."""


def tracking_run(system: System, kp: float) -> xr.Dataset:
    """Return the 10 s run at one gain."""
    return simulate(system.evolve({"controller.kp": kp}), duration_s=10.0, seed=0)


def tracking_runs(system: System) -> dict[float, xr.Dataset]:
    """Return the runs of Fig. 2b, 2c and 2d by their gain."""
    return {kp: tracking_run(system, kp) for kp in KPS}


def noise_above_n(run: xr.Dataset) -> float:
    """Return the rms of f_a above `NOISE_FROM_HZ` in N: the square root of its spectrum's integral (Welch)."""
    rate_hz = 1.0 / float(run["time"][1] - run["time"][0])
    frequency, density = welch(run["f_a"].values, rate_hz, nperseg=2048)
    above = frequency >= NOISE_FROM_HZ
    return float(np.sqrt(np.trapezoid(density[above], frequency[above])))


CARRIER_UM = 2.5
"""Largest amplitude of the carrier (paper, Sec. 2.1)."""
MODULATION_HZ = 1.0
"""Frequency of the amplitude modulation (paper, Sec. 2.1)."""
LEVEL_SPREAD_N = 0.05
"""Standard deviation of a trial's constant part of d (assumed)."""
FLUCTUATION = ColouredNoise(rms_n=0.05, exponent=1.0, low_hz=0.5, high_hz=50.0)
"""Varying part of d relative to f0: 5 % rms (assumed), 1/f as the friction of a sliding finger (paper, ref. [18])."""
RATE_HZ, DURATION_S = 200.0, 2.0
PARAMETER_STREAM, FLUCTUATION_STREAM = 3, 4
"""Streams of the counter-based noise that no other part of the package draws from."""


def sliding_trials(n: int = 26, seed: int = 0) -> xr.Dataset:
    """Return synthetic sliding trials under an amplitude-modulated carrier, a population like that of Fig. 1a.

    f = f0 exp(-tau a^2) + d, equation (1), with a(t) = 1.25 um (1 - cos(2 pi 1 Hz t)) and, per trial, f0 uniform,
    tau log-normal, and d a constant plus 1/f noise. d is bounded below by -g(a), "so to avoid negative values of the
    friction force". Trial i is the same whatever ``n``.

    Returns
    -------
    xarray.Dataset
        ``a`` (um) over ``sample``; ``f`` and ``d`` (N) over both; ``f0`` (N) and ``tau`` (um^-2) over ``trial``.
    """
    samples = round(RATE_HZ * DURATION_S)
    time = np.arange(samples) / RATE_HZ
    a = CARRIER_UM / 2 * (1 - np.cos(2 * np.pi * MODULATION_HZ * time))
    f0, tau, level = _fingers(n, seed)
    g = np.array(
        [friction_force(a, Friction(nominal_n=f, susceptibility_per_um2=t)) for f, t in zip(f0, tau, strict=True)]
    )
    d = np.maximum(level[:, None] + f0[:, None] * _fluctuations(n, seed, samples), -g)
    both = ("trial", "sample")
    return xr.Dataset(
        {"a": ("sample", a), "f": (both, g + d), "d": (both, d), "f0": ("trial", f0), "tau": ("trial", tau)}
    )


def _fingers(n: int, seed: int) -> tuple[Array, Array, Array]:
    """Return f0 (N), tau (um^-2) and the constant part of d (N) of each trial, f0 and tau as of `fingers`."""
    z = normals(seed, PARAMETER_STREAM, 0, 3 * n).reshape(n, 3)
    (low, high), (median, spread) = UNIFORM["friction.nominal_n"], LOG_NORMAL["friction.susceptibility_per_um2"]
    f0 = low + (high - low) * ndtr(z[:, 0])
    return f0, median * np.exp(spread * z[:, 1]), LEVEL_SPREAD_N * z[:, 2]


def _fluctuations(n: int, seed: int, samples: int) -> Array:
    """Return 1/f noise relative to f0, shape (trials, samples)."""
    sos = shaping_filter(FLUCTUATION, RATE_HZ)
    lead = 2 * len(sos)
    drawn = normals(seed, FLUCTUATION_STREAM, 0, n * (lead + samples)).reshape(n, -1)
    noise, _ = colour(sos, drawn[:, lead:], stationary_state(sos, drawn[:, :lead]))
    return FLUCTUATION.rms_n * noise


BINS_UM = np.linspace(0.0, 2.5, 11)
EVERY = 4
"""Of the samples of a trial, one in four is drawn."""


def binned(trials: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return bin centres in um, mean and standard deviation of the force in N over all trials."""
    within = np.clip(np.digitize(trials["a"].values, BINS_UM) - 1, 0, len(BINS_UM) - 2)
    forces = [trials["f"].values[:, within == k].ravel() for k in range(len(BINS_UM) - 1)]
    centres = (BINS_UM[1:] + BINS_UM[:-1]) / 2
    return centres, np.array([f.mean() for f in forces]), np.array([f.std() for f in forces])


@styled
def figure_population(trials: xr.Dataset, nominal: FrictionLimit) -> Figure:
    """Return the forces of all trials in grey, their mean and standard deviation in black, equation (1) in blue."""
    figure, axes = one_panel()
    lines = axes.plot(trials["a"].values[::EVERY], trials["f"].values[:, ::EVERY].T, color=GREY, alpha=0.4, lw=0.5)
    lines[0].set_label("one trial")
    centres, mean, spread = binned(trials)
    axes.errorbar(centres, mean, spread, fmt="o-", color=BLACK, capsize=3, lw=1.2, label="mean ± SD")
    curve = np.linspace(0, 2.5, 200)
    axes.plot(curve, friction_force(curve, nominal), "--", color=BLUE, label="eq. (1), $d = 0$")
    axes.set(xlabel="vibration amplitude $a$ (µm)", ylabel="friction force $f$ (N)", xlim=(-0.03, 2.53), ylim=(0, None))
    axes.set_title(f"{trials.sizes['trial']} synthetic sliding trials")
    axes.legend(loc="upper right")
    return figure


DOTS = 1500
"""Points of an input-output cloud, evenly spaced in time."""
PIECE_S = (2.2, 2.6)
"""The piece shown over time: the sweep passes 3 Hz."""

GROUND = {"fc": "white", "ec": "none", "alpha": 0.8, "pad": 1.5}
"""White ground of words that lie over data."""


@styled
def figure_tracking(run: xr.Dataset, kp: float, limits_n: tuple[float, float]) -> Figure:
    """Return the input-output cloud of a run above a piece of its traces, forces within ``limits_n``."""
    figure = new_figure(3.2, 4.9)
    above, below = figure.subplots(2, height_ratios=(1.55, 1))
    _cloud(above, run, limits_n)
    above.set_title(f"$K_p$ = {number(kp)}")
    scores = f"$R^2$ = {r2_identity(run):.3f}\nsaturated {saturation_index(run):.0%}"
    above.text(0.04, 0.97, scores, transform=above.transAxes, va="top", linespacing=1.4, bbox=GROUND)
    _traces(below, run.sel(time=slice(*PIECE_S)), limits_n)
    below.plot([], [], "--", color=BLACK, lw=1, label="$f_a = f_r$")
    figure.legend(*below.get_legend_handles_labels(), loc="outside lower center", ncols=2, handlelength=2.2)
    return figure


def _cloud(axes: Axes, run: xr.Dataset, limits_n: tuple[float, float]) -> None:
    shown = run.isel(time=np.linspace(0, run.sizes["time"] - 1, DOTS).astype(int))
    axes.plot(shown["f_r"], shown["f_a"], "o", ms=1.5, color=BLUE, alpha=0.5, mew=0)
    axes.plot(limits_n, limits_n, "--", color=BLACK, lw=1)
    axes.set(xlim=limits_n, ylim=limits_n, aspect="equal")
    axes.set(xlabel="set-point $f_r$ (N)", ylabel="friction force $f_a$ (N)")


def _traces(axes: Axes, run: xr.Dataset, limits_n: tuple[float, float]) -> None:
    time = run["time"]
    axes.plot(time, run["d"], ":", color=GREY, lw=1.2, label="disturbance $d$")
    axes.plot(time, run["f_a"], color=BLUE, lw=0.8, label="friction $f_a$")
    axes.plot(time, run["f_r"], "--", color=VERMILLION, lw=1.4, label="set-point $f_r$")
    axes.set(xlim=PIECE_S, ylim=(min(limits_n[0], float(run["d"].min())), limits_n[1]))
    axes.set(xlabel="time (s)", ylabel="force (N)")


def common_limits_n(runs: list[xr.Dataset]) -> tuple[float, float]:
    """Return limits that hold f_r and f_a of several runs, with a twentieth of room, in N."""
    values = [float(getattr(run[name], end)()) for run in runs for name in ("f_r", "f_a") for end in ("min", "max")]
    room = (max(values) - min(values)) / 20
    return min(values) - room, max(values) + room
