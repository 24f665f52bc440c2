"""How good a run is: how well the force followed, where the error lies, whether the loop rings, what was misread."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import field
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionloop.analysis.linear import condition_of
from frictionloop.analysis.operating_point import UNCLEAR
from frictionloop.analysis.stability import OPEN, Ringing
from frictionloop.findings import Finding, Result, shown
from frictionloop.findings.result import Row, Table, Tables, frame
from frictionloop.loop import run_findings
from frictionloop.loop.band_residuals import Band, by_band, split_edges
from frictionloop.loop.companion_runs import FELT, PLAIN, REGRESSION, TURNS, metrics, open_loop_of
from frictionloop.loop.input_findings import contact_turns, of_recorded, recordings, signal_findings
from frictionloop.loop.metrics import rms_error, scored_from
from frictionloop.loop.record import system_of
from frictionloop.loop.run_findings import ReachSplit, reach_split
from frictionloop.loop.run_ringing import of_loop, of_own_law, of_ringing, rings_alone, run_ringing, unseen
from frictionloop.loop.transients import StepTime, step_times
from frictionloop.parameters import Skin, Strokes, System
from frictionloop.parameters.doubtful_values import of_ceiling as board_ceiling
from frictionloop.parameters.summary import gains_said, listed, summary
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.design.controller_design import ControllerDesign

METRIC_NAMES = (*PLAIN, "disturbance_left", *REGRESSION, *TURNS, *FELT)
NAMES = {"intercept": "intercept_n", "output_noise": "output_noise_n", "rms_error": "rms_error_n"} | {
    "rms_error_turns": "rms_error_turns_n",
    "turn_peak": "turn_peak_n",
}
"""Metrics that have a unit, by the field that holds them."""


class Diagnosis(Result, schema="diagnose/1"):
    """How good a run is; forces in N, NaN where a metric has no meaning."""

    system: System
    seed: int | None
    duration_s: float
    score_from_s: float
    scored: float
    """Share of the control periods that counts: not reversals, lifts, or what is before ``score_from_s``."""
    r2_identity: float
    r2_bound: float
    r2_regression: float
    slope: float
    intercept_n: float
    rms_error_n: float
    open_loop_rms_error_n: float
    """The same run under the lookup table alone; NaN where it is that, or was measured."""
    rms_error_turns_n: float
    turn_peak_n: float
    feedback_share: float
    output_noise_n: float
    disturbance_left: float
    saturation_index: float
    perceptual_index: float
    relative_index: float
    own_metrics: Mapping[str, float] = field(default_factory=dict)
    """Metrics of runs that are registered."""
    reach: ReachSplit | None = None
    ringing: Ringing | None = None
    """None of an open loop, or where it is not known."""
    rings_alone: bool = False
    """Whether the loop rings whatever the disturbance: what is left of that is then no share of it."""
    steps: tuple[StepTime, ...] = ()
    """Steps of the set-point that were followed."""
    steps_asked: int = 0
    bands: tuple[Band, ...] = ()
    """The disturbance between the frequencies that were named."""
    recorded: Mapping[str, Any] = field(default_factory=dict)
    """What was read of recorded signals, by their names."""
    unscored_s: tuple[tuple[float, float], ...] = ()
    """From when to when is not scored."""
    advice: ControllerDesign | None = None
    """A controller designed for this system, if advice was asked for."""

    def rows(self) -> list[Row]:
        """Return the law, the error, and what makes it."""
        return [row for row in self._rows() if row[1]]

    def _rows(self) -> Iterator[Row]:
        yield self.system.controller.kind, gains_said(self.system)
        yield "error", "; ".join(self._error())
        line = f"{shown(self.slope)} f_r {'-' if self.intercept_n < 0 else '+'} {shown(abs(self.intercept_n))} N"
        bound = f"R2 {shown(self.r2_identity)} of {shown(self.r2_bound)} in reach"
        line = f"{bound}; line {line}, R2 {shown(self.r2_regression)}"
        yield "follows", "" if math.isnan(self.r2_identity) else line
        felt = [f"{shown(self.relative_index)} x a plain stroke"] if not math.isnan(self.relative_index) else []
        felt += [f"{shown(self.perceptual_index)} thresholds"] if not math.isnan(self.perceptual_index) else []
        yield "to touch", "; ".join(felt)
        known = not (math.isnan(self.disturbance_left) or self.rings_alone)
        left = [f"{shown(100 * self.disturbance_left)} % of the disturbance left"] if known else []
        clamped = [f"{shown(100 * self.saturation_index)} % of commands clamped"] if self.saturation_index > 0.0 else []
        yield "loop", "; ".join([*left, *clamped, *self._ringing_text()])
        yield "steps", self._steps()
        if self.advice is not None:
            yield "advice", f"{self.advice.law}   {gains_said(self.advice.system)}"

    def _error(self) -> Iterator[str]:
        if not self.scored:
            return
        opened = self.open_loop_rms_error_n
        beside = "" if math.isnan(opened) else f", {shown(1e3 * opened)} in open loop"
        yield f"{shown(1e3 * self.rms_error_n)} mN rms{beside}"
        if not math.isnan(self.turn_peak_n):
            yield f"{shown(1e3 * self.turn_peak_n)} mN peak after turns"

    def _ringing_text(self) -> Iterator[str]:
        found = self.ringing
        if found is not None:
            near = "" if found.frequency_hz is None or found.how == "calm" else f" near {shown(found.frequency_hz)} Hz"
            how = {"unstable": "unstable", "near": f"Ms {shown(found.sensitivity_peak)}"}.get(found.how)
            yield f"{how}{near}" if how else f"Ms {shown(found.sensitivity_peak)}"

    def _steps(self) -> str:
        means = []
        for name, some in (
            ("rise", [each for each in self.steps if each.to_n > each.from_n]),
            ("fall", [each for each in self.steps if each.to_n < each.from_n]),
        ):
            if some:
                to_63, rise = (1e3 * sum(each) / len(some) for each in list(zip(*some, strict=True))[3:])
                means.append(f"{name} {shown(rise)} ms, {shown(to_63)} to 63 %")
        return "; ".join([*means, f"{len(self.steps)} of {self.steps_asked} followed"]) if self.steps_asked else ""

    def tables(self) -> Tables:
        """Return the error by part, what is left by frequency, steps, metrics, the system and what was read."""
        import pandas as pd  # type: ignore[import-untyped]

        found = {"disturbance by frequency": self._bands()} if self.bands else {}
        found["error"] = self._parts()
        if self.steps:
            found["steps"] = frame([each._asdict() for each in self.steps], "start_s")
        found["metrics"] = frame(self.metrics, "metric", ["value"])
        about = summary(self.system).items()
        blocks = {name: [each.kind, listed({**each.values, **each.derived})] for name, each in about}
        found["system"] = frame(blocks, "", ["kind", "values"])
        if self.recorded:
            found["recordings"] = pd.DataFrame(dict(self.recorded))
        return found

    @property
    def metrics(self) -> dict[str, float]:
        """Every metric by the name of its field."""
        names = [NAMES.get(name, name) for name in METRIC_NAMES]
        return {name: getattr(self, name) for name in names} | dict(self.own_metrics)

    def _parts(self) -> Table:
        parts = {"scored": (self.scored, self.rms_error_n)}
        parts |= self.reach.parts(self.scored) if self.reach is not None else {}
        if not math.isclose(self.rms_error_turns_n, self.rms_error_n) and not math.isnan(self.rms_error_turns_n):
            parts["with turns"] = (math.nan, self.rms_error_turns_n)
        if not math.isnan(self.open_loop_rms_error_n):
            parts["open loop"] = (self.scored, self.open_loop_rms_error_n)
        return run_findings.error_table(parts)

    def _bands(self) -> Table:
        rows = {
            f"{shown(each.low_hz)} to {shown(each.high_hz)} Hz": (
                1e3 * each.disturbance_n,
                1e3 * each.left_n,
                math.nan if self.rings_alone else 100.0 * each.disturbance_left,
            )
            for each in self.bands
        }
        columns = ["varies, mN", "left, mN", "left, %"]
        return frame(rows, "disturbance", columns)


def diagnose(
    run: xr.Dataset, score_from_s: float = 0.0, advise: bool = False, split_hz: Sequence[float] = ()
) -> Diagnosis:
    """Return how good a run is: its metrics, where the error lies, whether the linear loop rings, what was misread.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate`` or ``load``, with the force on the finger.
    score_from_s : float
        Start of the part that counts, in s.
    advise : bool
        Design a controller for the system too, as `fl.design.controller` does.
    split_hz : sequence of float
        Frequencies in Hz, rising: what is left of the disturbance below, between and above.

    Raises
    ------
    FrictionloopError
        For what is no run with its System, frequencies that do not rise within half the control rate, a recording that
        is gone, or a design that finds no controller.
    """
    if advise:
        from frictionloop.design.controller_design import controller
    system = system_of(run)
    edges_hz = split_edges(split_hz, system.controller.rate_hz)
    mask, duration_s = scored_from(run, score_from_s)["scored"].values, run.sizes["time"] / system.controller.rate_hz
    read, found = recordings(system), dict[str, Any]()
    doubts = list(signal_findings(system))
    unclear = {each.code for each in doubts} & UNCLEAR
    told: list[Finding] = [*doubts, *run_findings.of_sensor(run, run["time"].values >= score_from_s)]
    if mask.any():
        found, more = _of_scored(run, mask, edges_hz, unclear, "" if advise else "--advise")
        told += more
    told += chain(
        of_recorded(system, duration_s),
        run_findings.of_unscored(run),
        contact_turns(system),
        board_ceiling(system),
        _one_place(system),
    )
    values = dict.fromkeys(METRIC_NAMES, math.nan) | found.pop("metrics", {})
    fields = {NAMES.get(name, name): value for name, value in values.items()}
    own = {name: fields.pop(name) for name in list(fields) if name not in Diagnosis.__dataclass_fields__}
    return Diagnosis(
        **{"open_loop_rms_error_n": math.nan, **found, **fields},
        own_metrics=own,
        system=system,
        seed=int(run.attrs["seed"]) if "seed" in run.attrs else None,
        duration_s=duration_s,
        score_from_s=score_from_s,
        scored=float(mask.mean()),
        recorded={name: each.summary() for name, each in read.items()},
        unscored_s=run_findings.unscored_s(run),
        advice=controller(system) if advise else None,
        findings=tuple(told),
    )


def _of_scored(
    run: xr.Dataset,
    mask: np.ndarray,
    edges_hz: Sequence[float],
    unclear: Collection[str],
    remedy: str,
) -> tuple[dict[str, Any], list[Finding]]:
    """Return fields and findings of what is scored; ``unclear`` are doubts that leave out what says nothing."""
    system, split = system_of(run), reach_split(run, mask)
    opened = None if system.controller.kind in OPEN else open_loop_of(run)
    found: dict[str, Any] = {"metrics": metrics(run, mask), "reach": split}
    if opened is not None:
        found["open_loop_rms_error_n"] = float(rms_error(opened, mask))
    told: list[Finding] = []
    try:
        found["ringing"] = run_ringing(run, mask)
        found["rings_alone"] = rings_alone(run, mask, found["ringing"])
        told += of_ringing(found["ringing"], found["rings_alone"], remedy)
    except FrictionloopError as error:  # a law, or a recording beyond the reach, without a linear analysis
        told += unseen(run, mask, error)
    wanted = float(np.clip(np.median(run["f_r"].values[mask]), split.low_n, split.high_n))
    told += of_own_law(system, wanted) if opened is not None else ()
    told += of_loop(found["metrics"]["rms_error"], found.get("open_loop_rms_error_n", math.inf))
    found["bands"] = by_band(run, mask, edges_hz)
    if not {*unclear} - {"SIGN-DOUBT"}:  # no reach explains what comes of a signal in another unit
        told += run_findings.of_reach(run, mask, split)
    if system.setpoint.kind == "steps":
        late = run["time"].values >= run["time"].values[mask][0]
        starts = (np.diff(run["f_r"].values) != 0) & late[1:]
        found["steps_asked"] = int(np.sum(starts))
        found["steps"] = tuple(each for each in step_times(run) if each.start_s >= run["time"].values[mask][0])
    return found, told


def _one_place(system: System) -> Iterator[Finding]:
    """Yield that a finger strokes with one slip length at one speed."""
    if isinstance(system.finger, Skin) and isinstance(system.motion, Strokes) and system.controller.kind not in OPEN:
        yield Finding("PLACE-ONE", where=condition_of(system), remedy="frictionloop design check FILE")
