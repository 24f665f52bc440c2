"""What a force sensor of given geometry does, and what the loop's ``sensor`` block leaves out of its noise."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq

from frictionloop.findings import Condition, Finding, Result, shown
from frictionloop.findings.result import Row, Tables, frame, plain, toml_table
from frictionloop.hardware.sensor import front_end, noise_budget, springs
from frictionloop.hardware.sensor.front_end import Sides, capacitance_f, check_geometry
from frictionloop.hardware.sensor.sensor_search import HEADROOM, SensorProposal, SensorRequirement, propose_sensor
from frictionloop.parameters.doubtful_values import unusual
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.parameters.toml_reader import read_design

PAPER_NOISE_N = 5e-5
"""Noise that is asked for if a requirement names none (paper, Sec. 3.1)."""
LOUD = 1.5
"""Noise at the end of the range over that at rest from which its largest part is told (assumed)."""

CONVERTER = "adc.bits"
"""Parameter of the one term that the loop makes itself, from the block's ``adc_bits`` and ``range_n``."""
BLOCK_TO_HZ = 500.0
"""Frequency to which the loop's block is compared with the design."""


class Omitted(NamedTuple):
    """Noise that a design has and its block in the loop has not."""

    at_rest_n: dict[str, float]
    """Name of the term to N rms: forces on the frame, such as vibration of the base and tilt."""
    under_load_n: float
    """What the electronics add at the end of the range to their noise at rest, N rms: the excitation's amplitude."""
    force_n: float
    """That end of the range."""

    @property
    def rest_rms_n(self) -> float:
        """All that is left out at rest, N rms."""
        return math.hypot(*self.at_rest_n.values())


class BlockError(NamedTuple):
    """Largest deviation of the loop's block with the delay added, up to 500 Hz."""

    gain: float
    phase_deg: float


class SensorAnswers(Result, schema="design.sensor/1"):
    """The figures of one sensor design."""

    design: SensorDesign
    stiffness: springs.Stiffness
    """Of the suspension, N/m."""
    resonance_hz: float
    """First resonance along x."""
    travel_um: float
    """Displacement at the end of the range."""
    stress_mpa: float
    """Largest stress in the springs there."""
    capacitance_f: Sides
    """At rest."""
    amplitude_v: float
    """Demodulated amplitude of one side at rest, mean of both."""
    peak_v: float
    """Largest amplitude at a charge amplifier within the range, as if it did not clip."""
    clips_from_n: float | None
    """Force from which an amplifier clips; None if it does not within the range, 0 if it does at rest."""
    nonlinearity: float
    """Reading at the ends of the range, halved difference, relative to the force, minus 1: (x/e)^2 for subtraction."""
    at_rest: noise_budget.Budget
    """Noise without a force."""
    at_range: noise_budget.Budget
    """Noise at the end of the range."""
    side_density_pm_rthz: float
    """Displacement noise of one side's electronics, without the excitation's."""
    delay_s: float
    """Delay of the carrier's electronics, mostly the band-pass, which the loop's block lacks."""
    block_error: BlockError
    """What else the loop's block lacks."""
    proposal: SensorProposal | None = None
    """The search that led to the design, and what other electrodes would be; None without a requirement."""

    @property
    def clips(self) -> bool:
        """Whether an amplifier clips within the range: then the sensor has no range and no block in the loop."""
        return self.clips_from_n is not None

    @property
    def dynamic_range_db(self) -> float | None:
        """Range over noise at rest, 20 log10; None if it clips."""
        return None if self.clips else 20 * math.log10(self.design.load.range_n / self.at_rest.rms_n)

    @property
    def suspended(self) -> dict[str, Any] | None:
        """Values of the ``sensor`` block of kind "suspended" that stands for it in the loop; None if it clips."""
        if self.clips:
            return None
        design = self.design
        return {
            "kind": "suspended",
            "moving_mass_kg": design.moving.mass_kg,
            "resonance_hz": self.resonance_hz,
            "q": design.moving.q,
            "cutoff_hz": design.filters.cutoff_hz,
            "noise_density_n_rthz": self.at_rest.white_density_n_rthz,
            "adc_bits": design.adc.bits,
            "range_n": design.adc.range_n,
        }

    @property
    def omitted(self) -> Omitted | None:
        """Noise that this block leaves out; None if it clips."""
        if self.clips:
            return None
        at_rest, at_range = self.at_rest, self.at_range
        # The block's density is that of the electronics at rest; its converter's noise follows from its bits.
        forces_n = {term.name: term.rms_n for term in at_rest.terms if not term.white and term.parameter != CONVERTER}
        rest, load = (math.hypot(*(term.rms_n for term in each.terms if term.white)) for each in (at_rest, at_range))
        return Omitted(forces_n, math.sqrt(max(load**2 - rest**2, 0.0)), at_range.force_n)

    def rows(self) -> list[Row]:
        """Return resonance, springs, electrodes, noise and delay."""
        design, rest, loaded = self.design, self.at_rest, self.at_range
        leaves, range_n = design.springs, design.load.range_n
        across = (
            f"radius {shown(leaves.radius_mm, 4)}" if leaves.kind == "arc" else f"length {shown(leaves.length_mm, 4)}"
        )
        db = "" if self.clips else f", {shown(self.dynamic_range_db)} dB"
        return [
            (
                "resonance",
                f"{shown(self.resonance_hz, 4)} Hz with {shown(design.moving.mass_kg)} kg, range {range_n:g} N{db}",
            ),
            (
                "springs",
                f"{leaves.count} {leaves.kind}, {across} mm, {shown(leaves.width_mm, 4)} x "
                f"{shown(leaves.thickness_mm)} mm, {shown(self.stress_mpa)} of {shown(leaves.yield_mpa)} MPa",
            ),
            (
                "electrodes",
                f"{shown(design.electrodes.area_mm2, 4)} mm2, gap {shown(design.electrodes.gap_um, 4)} um, "
                f"travel {shown(self.travel_um)} um; {shown(self.peak_v)} of {shown(design.amplifier.swing_v)} V",
            ),
            ("noise", f"{shown(1e6 * rest.rms_n)} uN rms at rest, {shown(1e6 * loaded.rms_n)} at {loaded.force_n:g} N"),
            ("delay", f"{shown(1e6 * self.delay_s)} us, part of controller.delay_s"),
        ]

    def tables(self) -> Tables:
        """Return the block for a System, unless an amplifier clips; other electrodes, and the noise term by term."""
        import pandas as pd  # type: ignore[import-untyped]

        found = {} if self.suspended is None else {"block": toml_table("sensor", self.suspended)}
        if self.proposal is not None:
            options = [each.to_dict() for each in self.proposal.options]
            found["electrodes that meet the noise"] = pd.DataFrame(options, dtype=object).set_index("area_mm2")
        terms = [
            {
                "noise": term.name,
                "N/rtHz": term.density_n_rthz,
                "uN rms": 1e6 * term.rms_n,
                "loaded": 1e6 * there.rms_n,
                "set by": term.parameter,
            }
            for term, there in zip(self.at_rest.terms, self.at_range.terms, strict=True)
        ]
        found["noise"] = frame(terms, "noise")
        return found | {"figures": pd.DataFrame({"value": self._figures()}, dtype=object).rename_axis("figure")}

    def _figures(self) -> dict[str, Any]:
        x, y = self.stiffness
        names = ("resonance_hz", "travel_um", "stress_mpa", "amplitude_v", "peak_v", "side_density_pm_rthz", "delay_s")
        found = {name: getattr(self, name) for name in names} | {"stiffness_x_n_per_m": x, "stiffness_y_n_per_m": y}
        found |= {"capacitance_pf": 1e12 * sum(self.capacitance_f) / 2}
        if self.clips:
            return found | {"clips_from_n": self.clips_from_n}
        error = self.block_error
        return found | {
            "nonlinearity": self.nonlinearity,
            "block_gain_error": error.gain,
            "block_phase_error_deg": error.phase_deg,
        }

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name; None what a sensor that clips has not."""
        left_out = self.omitted
        missing = None if left_out is None else {**left_out._asdict(), "rest_rms_n": left_out.rest_rms_n}
        found: dict[str, Any] = {"clips": self.clips, "sensor": self.suspended, "not_in_sensor": missing}
        found["dynamic_range_db"] = self.dynamic_range_db
        withheld = {"nonlinearity": None, "block_error": None} if self.clips else {}
        return super().to_dict() | plain(found) | withheld


def sensor(
    design: SensorDesign | str | os.PathLike[str] | None = None,
    overrides: Mapping[str, Any] | None = None,
    *,
    resonance_hz: float | None = None,
    range_n: float | None = None,
    noise_rms_n: float | None = None,
    noise_density_n_rthz: float | None = None,
) -> SensorAnswers:
    """Return springs, electrodes, electronics and noise of a force sensor, and the block of it for a System.

    Parameters
    ----------
    design
        A design, or a TOML file with what differs from the one that is built in; None: that one.
    overrides
        Values of it by dotted name: ``{"electrodes.gap_um": 150.0, "springs.kind": "straight"}``.
    resonance_hz, range_n, noise_rms_n, noise_density_n_rthz
        If any is given the geometry is searched: first resonance and range, those of the design if not given, and
        noise of the output at rest, `PAPER_NOISE_N` if not given, or density of the electronics' noise instead.

    Raises
    ------
    FrictionloopError
        For a requirement that cannot be met, a gap that is not larger than the travel, springs that yield, or a
        converter that ends below the force.
    """
    base = design if isinstance(design, SensorDesign) else SensorDesign()
    if design is not None and not isinstance(design, SensorDesign):
        base = read_design(Path(design), base)
    described = base.evolve(dict(overrides or {}))
    noises = {"noise_rms_n": noise_rms_n, "noise_density_n_rthz": noise_density_n_rthz}
    given = {name: value for name, value in noises.items() if value is not None}
    if not given and resonance_hz is None and range_n is None:
        found = _analysed(described)
    else:
        own = springs.resonance_hz(described) if resonance_hz is None else resonance_hz
        most_n = described.load.range_n if range_n is None else range_n
        required = SensorRequirement(own, most_n, **(given or {"noise_rms_n": PAPER_NOISE_N}))
        proposal = propose_sensor(required, described)
        found = _analysed(proposal.design, proposal)
    return found.with_findings((*unusual(described), *_doubts(found)))


def _doubts(found: SensorAnswers) -> Iterator[Finding]:
    """Yield where an amplifier clips; else what the excitation adds under load, and what the block lacks."""
    design, rest, loaded, missing = found.design, found.at_rest, found.at_range, found.omitted
    if missing is None:
        swing_v = design.amplifier.swing_v
        less = {
            "excitation.amplitude_v": float(f"{HEADROOM * design.excitation.amplitude_v * swing_v / found.peak_v:.3g}")
        }
        yield Finding("AMP-CLIPS", value=found.clips_from_n, unit="N", limit=swing_v, remedy=less)
        return
    if loaded.rms_n > LOUD * rest.rms_n and loaded.dominant.parameter == noise_budget.EXCITATION:
        yield Finding(
            "EXCITATION-LOUD",
            value=1e6 * loaded.dominant.rms_n,
            unit="uN",
            limit=1e6 * rest.rms_n,
            where=Condition(force_n=loaded.force_n),
            remedy={"readout.form": "ratio"},
        )
    name = max(missing.at_rest_n, key=missing.at_rest_n.__getitem__)
    lacks = {"term": name, "loaded": 1e6 * missing.under_load_n}
    yield Finding("NOISE-OUTSIDE", value=1e6 * missing.rest_rms_n, unit="uN", limit=1e6 * rest.rms_n, more=lacks)


def _analysed(design: SensorDesign, proposal: SensorProposal | None = None) -> SensorAnswers:
    """Return what a sensor of this geometry does."""
    check_geometry(design)
    range_n, travel_m = design.load.range_n, springs.travel_m(design)
    return SensorAnswers(
        design=design,
        stiffness=springs.stiffness(design.springs),
        resonance_hz=springs.resonance_hz(design),
        travel_um=travel_m * 1e6,
        stress_mpa=springs.peak_stress_pa(design.springs, travel_m) * 1e-6,
        capacitance_f=capacitance_f(design),
        amplitude_v=sum(front_end.amplitudes_v(design)) / 2,
        peak_v=max(front_end.peak_amplifier_v(design, force) for force in (-range_n, range_n)),
        clips_from_n=clips_from_n(design),
        nonlinearity=_nonlinearity(design),
        at_rest=noise_budget.noise_budget(design),
        at_range=noise_budget.noise_budget(design, range_n),
        side_density_pm_rthz=noise_budget.side_density_pm_rthz(design),
        delay_s=front_end.carrier_delay_s(design),
        block_error=_block_error(design),
        proposal=proposal,
    )


def clips_from_n(design: SensorDesign) -> float | None:
    """Return the force within the range from which a charge amplifier clips, 0 if it clips at rest, else None."""

    def above(force_n: float) -> float:
        # The plus side is the larger one, and the frame approaches it under a positive force.
        return front_end.peak_amplifier_v(design, force_n) - design.amplifier.swing_v

    if above(0.0) > 0:
        return 0.0
    range_n = design.load.range_n
    return float(brentq(above, 0.0, range_n, xtol=1e-9 * range_n)) if above(range_n) > 0 else None


def _block_error(design: SensorDesign) -> BlockError:
    frequency_hz = np.linspace(1.0, BLOCK_TO_HZ, 500)
    ratio = front_end.loop_response(design, frequency_hz) / front_end.sensor_response(design, frequency_hz)
    return BlockError(float(np.max(np.abs(np.abs(ratio) - 1))), float(np.max(np.abs(np.angle(ratio, deg=True)))))


def _nonlinearity(design: SensorDesign) -> float:
    range_n = design.load.range_n
    high, low = (
        float(front_end.readings(design, *front_end.amplitudes_v(design, force)).force_n)
        for force in (range_n, -range_n)
    )
    return (high - low) / (2 * range_n) - 1
